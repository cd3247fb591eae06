// The quality ladder: what a frame gives up, in order, when its budget does not hold everything. A rung includes what
// the rungs above it gave up; the governor takes the first one whose predicted cost fits.
//
// The order is that of the measured errors (sandglass bench ladder, README): the grains' steps first, which no contact
// sees; then the guarantee of the neighbour lists, which on a collapsing column changes no percentile of the overlap;
// then the length of the sub-steps, whose error grows with its square; simulated time last. Twice the sub-step is the
// end: beyond it, impacts overlap by half a radius.
#pragma once

#include <cstdint>

#include "sandglass/sandglass.h"

namespace sandglass {

struct Rung {
  bool refine_often;     // grains follow every refine_step, or once a frame
  float list_reuse;      // lists are kept until the particles' motion could have closed so many skins
  float coarsening;      // SMALL_STEP: length of the sub-steps in substep_max; AVERAGED: iterations divided by this
  sandglass_level told;  // what the app is told
};

extern const Rung k_ladder[SANDGLASS_LEVEL_COUNT];

// Iterations at a rung. One stays one: then the sub-steps are longer.
uint32_t rung_iterations(const Rung& rung, uint32_t iterations);
float rung_substep(const Rung& rung, uint32_t iterations, float substep_max);

}  // namespace sandglass
