// The quality ladder: what a frame gives up, in order, when its budget does not hold everything. A level includes what
// the levels before it gave up. The governor takes the first one whose predicted cost fits.
//
// The order is that of the measured errors (sandglass_lab bench ladder): the guarantee of the neighbour lists first, which
// on a collapsing column changes no percentile of the overlap, only single impacts; then the length of the sub-steps,
// whose error grows with its square; simulated time last. Twice the sub-step is the end: beyond it, impacts overlap by
// half a radius.
#pragma once

#include <cstdint>

#include "sandglass/sandglass.h"

namespace sandglass {

struct QualityLevel {
  float list_reuse;      // lists are kept until the particles' motion could have closed so many skins
  float coarsening;      // one solver iteration: sub-steps so many times as long; several: so many times fewer of them
  sandglass_level told;  // what the app is told
};

extern const QualityLevel k_ladder[SANDGLASS_LEVEL_COUNT];

// What a level makes of the description's solver iterations and longest sub-step.
uint32_t level_iterations(const QualityLevel& level, uint32_t iterations);
float level_substep(const QualityLevel& level, uint32_t iterations, float longest);

}  // namespace sandglass
