// What the phones' samples share: it pours within the budget, and is lit from the first frame on.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "sample/sand.h"

namespace {

TEST(Sample, PoursOntoTheTappedPointWithinTheBudget) {
  sample::Sand sand;
  ASSERT_TRUE(sand.create());
  std::vector<sandglass_grain> grains(sample::k_grains);
  EXPECT_EQ(sand.frame(0.0f, 1.0f, grains.data(), nullptr).sand.grain_numbers, 0u);
  const float table[3] = {1.0f, 0.7f, -2.0f};
  sand.pour(table);
  sandglass_frame_report report = {};
  for (int frame = 0; frame < 60; ++frame) {
    report = sand.frame(1.0f / 60.0f, frame < 30 ? 1.0f : 0.5f, grains.data(), nullptr);
    EXPECT_LE(report.time.elapsed_ns,
              std::max(report.time.target_ns, report.time.mandatory_ns) + report.time.last_unit_ns);
  }
  EXPECT_EQ(report.time.target_ns, sample::k_budget_ns / 2);
  EXPECT_GT(report.sand.grain_numbers, 100u);
  for (uint32_t i = 0; i < report.sand.grain_numbers; ++i) EXPECT_GT(grains[i].position[1], -0.001f) << i;
  EXPECT_EQ(sand.origin()[1], table[1]);
  EXPECT_GT(sand.shading().ambient[1], 0.0f) << "what is usual in a room";
}

}  // namespace
