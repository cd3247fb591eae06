// The stage that the sample apps share: it fills the phone scene, keeps the sand on the floor where it was poured, and
// keeps the frame's promise.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "sand_stage.h"

namespace {

TEST(SandStage, PoursThePhonesSceneOntoTheTappedPoint) {
  sample::SandStage stage;
  ASSERT_TRUE(static_cast<bool>(stage.create()));
  const float point[3] = {1.0f, 0.7f, -2.0f};
  ASSERT_TRUE(static_cast<bool>(stage.pour(point)));
  for (int k = 0; k < 3; ++k) EXPECT_EQ(stage.origin()[k], point[k]);
  EXPECT_GT(stage.drawn(), sample::k_grains * 3 / 4) << "the block fills most of what there is room for";

  std::vector<sandglass_grain> grains(sample::k_grains);
  sandglass_frame_report report = {};
  for (int frame = 0; frame < 30; ++frame) {
    report = stage.frame(1.0f / 60.0f, frame < 15 ? 1.0f : 0.5f, grains.data());
    EXPECT_LE(report.elapsed_ns, std::max(report.target_ns, report.mandatory_ns) + report.last_unit_ns);
  }
  EXPECT_EQ(report.target_ns, sample::k_budget_ns / 2);
  EXPECT_EQ(report.grains, stage.drawn());
  EXPECT_EQ(report.quarantined, 0u);
  for (uint32_t i = 0; i < stage.drawn(); ++i)
    EXPECT_GT(grains[i].position[1], -0.001f) << "grain " << i << " under the floor";
}

TEST(SandStage, PoursAgainElsewhere) {
  sample::SandStage stage;
  ASSERT_TRUE(static_cast<bool>(stage.create()));
  const float first[3] = {0, 0, 0}, second[3] = {3, 1, 0};
  ASSERT_TRUE(static_cast<bool>(stage.pour(first)));
  const uint32_t drawn = stage.drawn();
  stage.frame(0.02f, 1.0f, nullptr);
  ASSERT_TRUE(static_cast<bool>(stage.pour(second)));
  EXPECT_EQ(stage.drawn(), drawn);
  EXPECT_EQ(stage.frame(0.02f, 1.0f, nullptr).frame, 1u) << "a new scene";
}

}  // namespace
