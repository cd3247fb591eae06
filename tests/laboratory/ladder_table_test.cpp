// The quality ladder ships with a table of errors, which were measured on the column. This test measures them again at
// every quality level. It does not measure costs, because they depend on the machine.
#include <gtest/gtest.h>

#include "tests/laboratory/sand/granular_bench.h"

namespace sandglass::host {
namespace {

TEST(LadderTable, IsWhatTheColumnMeasures) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "a quarter of an hour under emulation, for the same bits";
  const SceneFile column = load_scene("column14k");
  double before = 0.0;
  for (uint32_t level = 0; level < SANDGLASS_LEVEL_SLOW_MOTION; ++level) {
    const sandglass_level& step = *sandglass_level_describe(level);
    const BenchRow row = bench_scene(
        column, SANDGLASS_ISA_AUTOMATIC, 1, 100, false, [] { return true; }, level);
    // The collapse is chaotic. Sums in another order move its percentiles by a few per cent.
    EXPECT_NEAR(row.overlap_p99, static_cast<double>(step.overlap_p99), 0.1 * row.overlap_p99) << step.name;
    EXPECT_NEAR(row.overlap_mean, static_cast<double>(step.overlap_mean), 0.1 * row.overlap_mean) << step.name;
    EXPECT_NEAR(row.angle_deg, static_cast<double>(step.angle_deg), 2.5) << step.name;
    EXPECT_GT(row.overlap_p99, 0.9 * before) << "a quality level must be no better than the one above it";
    before = row.overlap_p99;
  }
  EXPECT_EQ(sandglass_level_describe(SANDGLASS_LEVEL_COUNT), nullptr);
}

}  // namespace
}  // namespace sandglass::host
