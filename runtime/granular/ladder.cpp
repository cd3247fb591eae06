#include "runtime/granular/ladder.h"
#include "kernels/whole.h"

namespace sandglass {

// Name, cost of the solver and of the refinement, P99 and mean of the overlap, angle: as
// `sandglass bench ladder --threads 1` measures them.
const QualityLevel k_ladder[SANDGLASS_LEVEL_COUNT] = {
    {true, 1.0f, 1.0f, {sizeof(sandglass_level), "full", 1.0f, 1.0f, 0.0052f, 0.0009f, 25.0f}},
    {false, 1.0f, 1.0f, {sizeof(sandglass_level), "refinement once a frame", 0.96f, 0.35f, 0.0052f, 0.0009f, 25.0f}},
    {false, 3.0f, 1.0f, {sizeof(sandglass_level), "lists kept longer", 0.79f, 0.33f, 0.0053f, 0.0009f, 24.0f}},
    {false,
     3.0f,
     4.0f / 3.0f,
     {sizeof(sandglass_level), "sub-steps 4/3 as long", 0.65f, 0.34f, 0.0082f, 0.0015f, 25.0f}},
    {false, 3.0f, 2.0f, {sizeof(sandglass_level), "sub-steps twice as long", 0.59f, 0.35f, 0.0160f, 0.0032f, 24.0f}},
    {false, 3.0f, 2.0f, {sizeof(sandglass_level), "slow motion", 0.59f, 0.35f, 0.0160f, 0.0032f, 24.0f}},
};

uint32_t level_iterations(const QualityLevel& level, uint32_t iterations) {
  const uint32_t fewer = to_whole<uint32_t>(static_cast<float>(iterations) / level.coarsening + 0.5f);
  return iterations <= 1 || fewer == 0 ? 1 : fewer;
}

float level_substep(const QualityLevel& level, uint32_t iterations, float longest) {
  return iterations <= 1 ? longest * level.coarsening : longest;
}

}  // namespace sandglass
