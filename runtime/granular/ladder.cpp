#include "runtime/granular/ladder.h"

namespace sandglass {

// name, cost of the solver and of the refinement, P99 and mean of the overlap, angle: sandglass bench ladder
// --threads 1.
const Rung k_ladder[SANDGLASS_LEVEL_COUNT] = {
    {true, 1.0f, 1.0f, {sizeof(sandglass_level), "full", 1.0f, 1.0f, 0.0051f, 0.00085f, 25.0f}},
    {false, 1.0f, 1.0f, {sizeof(sandglass_level), "refinement once a frame", 0.95f, 0.33f, 0.0054f, 0.0009f, 25.0f}},
    {false, 3.0f, 1.0f, {sizeof(sandglass_level), "lists kept longer", 0.78f, 0.33f, 0.0053f, 0.0009f, 26.0f}},
    {false,
     3.0f,
     4.0f / 3.0f,
     {sizeof(sandglass_level), "sub-steps 4/3 as long", 0.63f, 0.33f, 0.0079f, 0.0015f, 26.0f}},
    {false, 3.0f, 2.0f, {sizeof(sandglass_level), "sub-steps twice as long", 0.5f, 0.33f, 0.0147f, 0.0030f, 26.0f}},
    {false, 3.0f, 2.0f, {sizeof(sandglass_level), "slow motion", 0.5f, 0.33f, 0.0147f, 0.0030f, 26.0f}},
};

uint32_t rung_iterations(const Rung& rung, uint32_t iterations) {
  const uint32_t fewer = static_cast<uint32_t>(static_cast<float>(iterations) / rung.coarsening + 0.5f);
  return iterations <= 1 || fewer == 0 ? 1 : fewer;
}

float rung_substep(const Rung& rung, uint32_t iterations, float substep_max) {
  return iterations <= 1 ? substep_max * rung.coarsening : substep_max;
}

}  // namespace sandglass
