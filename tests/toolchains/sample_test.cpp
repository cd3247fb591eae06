// What the phones' samples share: it pours within the budget, is lit from the first frame on, throws shadows and rests.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "sample/sand.h"

namespace {

using Grains = std::vector<sandglass_grain>;

// The sum of the heights between two buffers, of the grains that both have.
double heights(const Grains& older, const Grains& newer, float share) {
  double sum = 0;
  for (size_t i = 0; i < newer.size(); ++i)
    if (std::min(older[i].speed, newer[i].speed) >= 0)
      sum += std::lerp(older[i].position[1], newer[i].position[1], share);
  return sum;
}

TEST(Sample, PoursOntoTheTappedPointWithinTheBudget) {
  sample::Sand sand;
  ASSERT_TRUE(sand.create());
  std::vector<sandglass_grain> grains(sample::k_grains);
  EXPECT_EQ(sand.frame(0.0f, 1.0f, grains.data(), nullptr).sand.grain_numbers, 0u);
  const float table[3] = {1.0f, 0.7f, -2.0f};
  sand.pour(table);
  EXPECT_NE(sand.buffers().next, 0u) << "it may still be drawn";
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

// In slow motion what is written stands in many frames, and what is drawn hardly in any. At rest nothing is uploaded.
TEST(Sample, MovesEvenlyAndRests) {
  uint64_t ns = 0, stood_drawn = 0, stood_written = 0, rested = 0, versions = 0;
  sample::Sand sand;
  ASSERT_TRUE(sand.create(1, {[](void* now) { return *static_cast<uint64_t*>(now) += 30'000; }, &ns}));
  sand.pour(std::array{0.0f, 0.0f, 0.0f}.data());
  Grains all[sample::k_buffers];
  for (Grains& grains : all) grains.resize(sample::k_grains);
  const sample::Buffers& now = sand.buffers();
  double drawn = 0, written = 0;
  for (int frame = 0; frame < 5000 && rested < 10; ++frame) {
    Grains& grains = all[now.next];
    if (rested == 5) std::fill(grains.begin(), grains.end(), sandglass_grain{{1, 2, 3}, 4});
    const bool asleep = sand.frame(1.0f / 60, 1, grains.data(), nullptr).sand.awake == 0;
    const uint64_t before = std::exchange(versions, sand.shadows().sand.version + sand.shadows().sand_room.version);
    rested = asleep && !now.changed && versions == before ? rested + 1 : 0;
    EXPECT_TRUE(rested != 4 || heights(grains, grains, 1) == heights(all[now.newer], all[now.newer], 1));
    EXPECT_TRUE(rested < 10 || heights(grains, grains, 1) == 2 * sample::k_grains) << "written at rest";
    if (frame >= 150) continue;
    const double was_drawn = std::exchange(drawn, heights(all[now.older], all[now.newer], now.share));
    const double was_written = std::exchange(written, heights(grains, grains, 1));
    if (frame >= 50) {
      stood_drawn += drawn == was_drawn;
      stood_written += written == was_written;
    }
  }
  EXPECT_GT(stood_written, 20u) << "the control";
  EXPECT_LE(stood_drawn, stood_written / 20);
  EXPECT_GT(versions, 100u) << "the control";
  EXPECT_EQ(rested, 10u);
}

TEST(Sample, OnAHotPhoneLightAndTheBestLevelsRest) {
  sample::Sand sand;
  ASSERT_TRUE(sand.create(sample::k_rests_at));
  EXPECT_EQ(sand.frame(0.01f, 0.6f, nullptr, nullptr).level, SANDGLASS_LEVEL_COARSE) << "all fits";
  const sandglass_camera_image image = {};  // one that cannot be used: the report says whether it was looked at
  EXPECT_EQ(sand.frame(0.01f, 0.6f, nullptr, &image).estimator.ignored_images, 0u);
  EXPECT_EQ(sand.frame(0.01f, 0.8f, nullptr, &image).estimator.ignored_images, 1u);
}

// Sand is drawn for the image on the screen, which a short one for lamps is not. The control: one that is half as long
// is, and by the rule for that the short one would be drawn at a 64th.
TEST(Sample, AShortImageForLampsLeavesTheSandAsBright) {
  sample::Sand sand;
  ASSERT_TRUE(sand.create());
  std::vector<uint8_t> bytes(3 * 64 * 48);
  sandglass_camera_image image;
  sandglass_camera_image_default(&image);
  image.width = 64;
  image.height = 48;
  image.planes[0] = bytes.data();
  image.strides[0] = 3 * 64;
  image.focal_x = image.focal_y = 50;
  image.centre_x = 31.5f;
  image.centre_y = 23.5f;
  const auto drawn = [&](float exposure) {  // linear light of 0.25
    const double light = 0.25 * static_cast<double>(exposure);
    std::fill(bytes.begin(), bytes.end(),
              static_cast<uint8_t>(
                  std::lround(255 * (light < .0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - .055))));
    image.exposure = exposure;
    image.timestamp_ns += 200'000'000;
    sand.frame(0.2f, 1.0f, nullptr, &image);
    return sand.shading().ambient[1];
  };
  for (int i = 0; i < 30; ++i) drawn(1);
  const float before = drawn(1);
  EXPECT_NEAR(drawn(1.0f / 64) / before, 1, 0.02);
  EXPECT_NEAR(drawn(1.0f / 4096) / before, 1, 0.02);
  EXPECT_NEAR(drawn(0.5f) / before, 0.5, 0.02) << "the control";
}

// The texel of a texture over a place of the table; `outside` where it has none.
int at(const sample::ShadowTexture& t, float x, float z, int outside) {
  const float u = (x - t.box[0]) * t.box[2], v = (z - t.box[1]) * t.box[3];
  if (u < 0 || u >= 1 || v < 0 || v >= 1) return outside;
  return t.bytes[static_cast<uint32_t>(v * static_cast<float>(t.texels)) * t.texels +
                 static_cast<uint32_t>(u * static_cast<float>(t.texels))];
}

// Under a board of 20 cm half a centimetre above the table little of the room's light is left, and far from it all.
TEST(Sample, SandAndObjectsThrowShadows) {
  sample::Sand sand;
  ASSERT_TRUE(sand.create());
  const float corners[12] = {0.1f, 0.005f, 0.1f, 0.3f, 0.005f, 0.1f, 0.3f, 0.005f, 0.3f, 0.1f, 0.005f, 0.3f};
  const uint32_t triangles[6] = {0, 2, 1, 0, 3, 2};
  sandglass_cast_mesh board = sandglass::cast_mesh();
  board.positions = corners;
  board.vertex_count = 4;
  board.indices = triangles;
  board.triangle_count = 2;
  ASSERT_TRUE(sand.stand(&board, 1));
  const float table[3] = {};
  sand.pour(table);
  sample::Shadows shadows;
  for (int frame = 0; frame < 2000; ++frame) {  // however slow this machine is
    sand.frame(1.0f / 60.0f, 1.0f, nullptr, nullptr);
    shadows = sand.shadows();
    if (shadows.object_room.version > 0 && at(shadows.object, 0.2f, 0.2f, 0) > 0 &&
        at(shadows.sand_room, 0, 0, 255) < 128)
      break;
  }
  EXPECT_EQ(at(shadows.object, 0.2f, 0.2f, 0), 255);
  EXPECT_LT(at(shadows.object_room, 0.2f, 0.2f, 255), 40);
  EXPECT_EQ(at(shadows.object_room, -0.3f, -0.3f, 255), 255);
  EXPECT_LT(at(shadows.sand_room, 0, 0, 255), 128) << "under the sand";
  EXPECT_GT(at(shadows.sand_room, -0.4f, 0.4f, 255), 250);
}

}  // namespace
