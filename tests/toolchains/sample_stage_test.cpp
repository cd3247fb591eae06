// The stage that the sample apps share: it fills the scene of a phone's size, keeps the sand on the floor where it was
// poured, keeps the budget law, and lights sand and floor from the camera's image in every layout.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <vector>

#include "camera_planes.h"
#include "sand_stage.h"

namespace {

// A stage with the block of sand on a point of the floor.
struct SandStage : testing::Test {
  void pour(float x, float y, float z) {
    const float point[3] = {x, y, z};
    ASSERT_TRUE(static_cast<bool>(stage.pour(point)));
    for (int k = 0; k < 3; ++k) EXPECT_EQ(stage.origin()[k], point[k]);
  }
  sample::SandStage stage;
};

TEST_F(SandStage, PoursThePhonesSceneOntoTheTappedPoint) {
  ASSERT_TRUE(static_cast<bool>(stage.create()));
  pour(1.0f, 0.7f, -2.0f);
  EXPECT_GT(stage.drawn(), sample::k_grains * 3 / 4) << "the block must fill most of the capacity";

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

  const uint32_t drawn = stage.drawn();
  pour(3, 1, 0);
  EXPECT_EQ(stage.drawn(), drawn);
  EXPECT_EQ(stage.frame(0.02f, 1.0f, nullptr).frame, 1u) << "the scene must begin again";
}

// The shipped network in 8-byte words.
std::vector<uint64_t> network(uint64_t* bytes) {
  std::ifstream file(SANDGLASS_LIGHTS_DIR "/room.light", std::ios::binary | std::ios::ate);
  *bytes = static_cast<uint64_t>(file.tellg());
  std::vector<uint64_t> words((*bytes + 7) / 8);
  file.seekg(0);
  file.read(reinterpret_cast<char*>(words.data()), static_cast<std::streamsize>(*bytes));
  return words;
}

// A room that is bright on its left, as three planes. Rows end in padding, as those of cameras do.
constexpr uint32_t k_width = 160, k_height = 120, k_row = 192;
struct Planes {
  std::vector<uint8_t> y = std::vector<uint8_t>(k_row * k_height), u = std::vector<uint8_t>(k_row * k_height / 2),
                       v = std::vector<uint8_t>(k_row * k_height / 2);
  Planes() {
    for (uint32_t row = 0; row < k_height; ++row)
      for (uint32_t column = 0; column < k_width; ++column)
        y[row * k_row + column] = static_cast<uint8_t>(250 - column - (row > 80 ? 60 : 0));
    for (uint32_t row = 0; row < k_height / 2; ++row)
      for (uint32_t column = 0; column < k_width / 2; ++column) {
        u[row * k_row + column] = static_cast<uint8_t>(110 + row / 4);
        v[row * k_row + column] = static_cast<uint8_t>(130 + column / 8);
      }
  }
};

sandglass_camera_image pinhole() {
  sandglass_camera_image image = sandglass::camera_image();
  image.width = k_width, image.height = k_height;
  image.focal_x = image.focal_y = 150.0f;
  image.centre_x = 79.5f, image.centre_y = 59.5f;
  return image;
}

bool set_planes(const uint8_t* y, const uint8_t* u, const uint8_t* v, const std::array<int32_t, 3>& pixel_strides,
                sandglass_camera_image* image) {
  const uint8_t* const of[3] = {y, u, v};
  const int32_t rows[3] = {k_row, k_row, k_row};
  return sample::set_yuv_planes(of, rows, pixel_strides.data(), image);
}

TEST(CameraPlanes, EveryLayoutOfOneImageIsTheSameImage) {
  uint64_t bytes = 0;
  const std::vector<uint64_t> file = network(&bytes);
  const Planes planes;
  std::vector<uint8_t> uv(k_row * k_height / 2), vu(k_row * k_height / 2);
  for (uint32_t row = 0; row < k_height / 2; ++row)
    for (uint32_t column = 0; column < k_width / 2; ++column) {
      const size_t from = row * k_row + column, to = row * k_row + 2 * column;
      uv[to] = vu[to + 1] = planes.u[from];
      uv[to + 1] = vu[to] = planes.v[from];
    }
  // The hash of what the library keeps of an image.
  const auto kept = [&](const uint8_t* u, const uint8_t* v, int32_t pixel_stride, sandglass_camera_format expected) {
    sandglass_camera_image image = pinhole();
    EXPECT_TRUE(set_planes(planes.y.data(), u, v, {1, pixel_stride, pixel_stride}, &image));
    EXPECT_EQ(image.format, expected);
    sandglass_light_desc desc = sandglass::light_desc();
    desc.asset = file.data(), desc.asset_bytes = bytes;
    sandglass::Light light;
    EXPECT_TRUE(static_cast<bool>(light.create(desc)));
    uint32_t taken = 0;
    const char* reason = nullptr;
    EXPECT_EQ(sandglass_light_set_image(light.get(), &image, &taken, &reason), SANDGLASS_OK) << reason;
    EXPECT_EQ(taken, 1u);
    return sandglass_light_hash(light.get());
  };
  const uint64_t separate = kept(planes.u.data(), planes.v.data(), 1, SANDGLASS_CAMERA_I420);
  EXPECT_EQ(kept(uv.data(), uv.data() + 1, 2, SANDGLASS_CAMERA_NV12), separate);
  EXPECT_EQ(kept(vu.data() + 1, vu.data(), 2, SANDGLASS_CAMERA_NV21), separate);
  EXPECT_NE(kept(planes.v.data(), planes.u.data(), 1, SANDGLASS_CAMERA_I420), separate)
      << "exchanged colours must change the hash";
}

TEST(CameraPlanes, AnotherLayoutIsRefusedAndNothingIsTouched) {
  const Planes planes;
  using Strides = std::array<int32_t, 3>;
  for (const Strides& pixels : {Strides{1, 4, 4}, Strides{1, 2, 2}, Strides{1, 1, 2}}) {
    sandglass_camera_image image = pinhole();
    EXPECT_FALSE(set_planes(planes.y.data(), planes.u.data(), planes.v.data(), pixels, &image));
    EXPECT_EQ(image.planes[0], nullptr);
  }
}

TEST_F(SandStage, WithoutAnImageNoShadowIsSeen) {
  ASSERT_TRUE(static_cast<bool>(stage.create()));
  pour(0, 0, 0);
  const sandglass_camera_image image = pinhole();  // without a network nothing reads it
  EXPECT_EQ(stage.frame(0.02f, 1.0f, nullptr, &image).light_changed, 0u);
  EXPECT_EQ(stage.shadow_strength(), 0.0f);
}

TEST_F(SandStage, LightComesFromTheImageAndSandCastsItsShadowInIt) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "an estimate in slices of 4 ms of an emulated core takes minutes";
  uint64_t bytes = 0;
  std::vector<uint64_t> file = network(&bytes);
  ASSERT_TRUE(static_cast<bool>(stage.create(std::move(file), bytes)));
  pour(0.3f, 0.0f, -1.0f);
  const Planes planes;
  sandglass_camera_image image = pinhole();
  ASSERT_TRUE(set_planes(planes.y.data(), planes.u.data(), planes.v.data(), {1, 1, 1}, &image));

  int changed = -1, frame = 0;
  for (; frame < 2000 && (changed < 0 || frame < changed + 30 || stage.shadow().age > 0); ++frame) {
    image.timestamp_ns = 16'666'667u * static_cast<uint64_t>(frame);
    // No time passes for the sand, so the block stands.
    if (stage.frame(0.0f, 1.0f, nullptr, changed < 0 ? &image : nullptr).light_changed != 0) changed = frame;
    if (changed < 0) {
      EXPECT_EQ(stage.shadow_strength(), 0.0f);
    }
  }
  ASSERT_GE(changed, 0) << "no light in " << frame << " frames";
  const sandglass_light_estimate light = stage.light();
  EXPECT_NE(light.valid, 0u);
  const float across = std::hypot(light.direction[0], light.direction[2]);
  EXPECT_NEAR(std::hypot(across, light.direction[1]), 1.0f, 1e-5f);
  EXPECT_GT(light.contrast, 0.0f);

  const sandglass_pile_shadow_texture shadow = stage.shadow();
  ASSERT_NE(shadow.valid, 0u);
  EXPECT_EQ(shadow.texels, sample::k_shadow_texels);
  EXPECT_FLOAT_EQ(stage.shadow_strength(), shadow.opacity * light.contrast);
  double weight = 0, away = 0;
  for (uint32_t row = 0; row < shadow.texels; ++row)
    for (uint32_t column = 0; column < shadow.texels; ++column) {
      const double c = shadow.coverage[row * shadow.texels + column];
      const auto at = [&](uint32_t i, int k) {
        return shadow.low[k] + (shadow.high[k] - shadow.low[k]) * (i + 0.5) / shadow.texels;
      };
      weight += c;
      away -= c * (at(column, 0) * light.direction[0] + at(row, 1) * light.direction[2]) / across;
    }
  ASSERT_GT(weight, 0.0);
  EXPECT_GT(shadow.coverage[shadow.texels / 2 * (shadow.texels + 1)], 230) << "the floor must be dark under the block";
  EXPECT_EQ(shadow.coverage[0], 0) << "the corner must not be dark";
  EXPECT_GT(away / weight, 0.05) << "the shadow must lie on the side away from the light";
}

}  // namespace
