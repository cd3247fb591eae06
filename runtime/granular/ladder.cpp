#include "runtime/granular/ladder.h"

namespace sandglass {

// name, cost of the solver and of the refinement, P99 and mean of the overlap, angle: sandglass bench ladder
// --threads 1.
const Rung k_ladder[SANDGLASS_LEVEL_COUNT] = {
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

uint32_t rung_iterations(const Rung& rung, uint32_t iterations) {
  const uint32_t fewer = static_cast<uint32_t>(static_cast<float>(iterations) / rung.coarsening + 0.5f);
  return iterations <= 1 || fewer == 0 ? 1 : fewer;
}

float rung_substep(const Rung& rung, uint32_t iterations, float substep_max) {
  return iterations <= 1 ? substep_max * rung.coarsening : substep_max;
}

}  // namespace sandglass
