#include "runtime/granular/ladder.h"
#include "kernels/whole.h"

namespace sandglass {

namespace {

struct Measured {
  float cost_solver, cost_refine, overlap_p99, overlap_mean, angle_degrees;
};

constexpr Measured k_measured[] = {
#include "runtime/granular/ladder_measured.inc"
};
constexpr uint32_t k_measured_levels = sizeof k_measured / sizeof k_measured[0];
static_assert(k_measured_levels == SANDGLASS_LEVEL_SLOW_MOTION, "slow motion has the numbers of the level before it");

constexpr bool each_gives_up_accuracy_for_time() {
  for (uint32_t level = 1; level < k_measured_levels; ++level) {
    const Measured &better = k_measured[level - 1], &cheaper = k_measured[level];
    if (cheaper.cost_solver > better.cost_solver || cheaper.overlap_p99 < better.overlap_p99) return false;
  }
  return true;
}
static_assert(each_gives_up_accuracy_for_time(), "a level that is both dearer and worse than another has no use");

constexpr sandglass_level told(const char* name, uint32_t measured) {
  const Measured& m = k_measured[measured];
  return {sizeof(sandglass_level), name, m.cost_solver, m.cost_refine, m.overlap_p99, m.overlap_mean, m.angle_degrees};
}

}  // namespace

const QualityLevel k_ladder[SANDGLASS_LEVEL_COUNT] = {
    {1.0f, 1.0f, told("full", 0)},
    {2.0f, 1.0f, told("lists kept longer", 1)},
    {2.0f, 4.0f / 3.0f, told("sub-steps 4/3 as long", 2)},
    {2.0f, 2.0f, told("sub-steps twice as long", 3)},
    {2.0f, 2.0f, told("slow motion", 3)},
};

uint32_t level_iterations(const QualityLevel& level, uint32_t iterations) {
  const uint32_t fewer = to_whole<uint32_t>(static_cast<float>(iterations) / level.coarsening + 0.5f);
  return iterations <= 1 || fewer == 0 ? 1 : fewer;
}

float level_substep(const QualityLevel& level, uint32_t iterations, float longest) {
  return iterations <= 1 ? longest * level.coarsening : longest;
}

}  // namespace sandglass
