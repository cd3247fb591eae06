// The stage that the sample apps share: it fills the scene of a phone's size, keeps the sand on the floor where it was
// poured, keeps the budget law, and lights sand and floor by what the camera has seen, in every layout of its images.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
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
    sandglass::Room room;
    EXPECT_TRUE(static_cast<bool>(room.create()));
    EXPECT_TRUE(static_cast<bool>(room.set_image(image)));
    return room.hash();
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

// Before any image the light is what is usual: soft, without a main light, and the sand does not float.
TEST_F(SandStage, WithoutAnImageTheShadowIsSoft) {
  ASSERT_TRUE(static_cast<bool>(stage.create()));
  pour(0, 0, 0);
  for (int frame = 0; frame < 600 && stage.sky().valid == 0; ++frame) (void)stage.frame(0.0f, 1.0f, nullptr);
  const sandglass_pile_shadow_sky sky = stage.sky();
  ASSERT_NE(sky.valid, 0u);
  EXPECT_LT(sky.floor[sky.texels / 2 * (sky.texels + 1)], 60) << "the floor must be dark under the block";
  EXPECT_GT(sky.floor[0], 240);
  EXPECT_EQ(stage.light().valid, 0u);
  EXPECT_EQ(stage.shadow_strength(), 0.0f);
  EXPECT_EQ(stage.light_scale(), 1.0f);
  EXPECT_NE(stage.look(), nullptr) << "nothing was seen: the user must be asked to look around";
}

// A camera turns once, 50 degrees up, in a dim room with a lamp at azimuth 90 (along +z). It clips first; then the app
// asks for short exposures, by which the lamp is found.
TEST_F(SandStage, TheRoomThatWasSeenLightsTheSand) {
  ASSERT_TRUE(static_cast<bool>(stage.create()));
  pour(0.1f, 0.0f, 0.1f);
  const double up = 50.0 * std::numbers::pi / 180, lamp[3] = {0.0, std::sin(up), std::cos(up)};
  std::vector<uint8_t> pixels(3 * k_width * k_height);
  bool was_asked = false;
  for (int shot = 0; shot < 36; ++shot) {
    const double azimuth = 2 * std::numbers::pi * shot / 12,
                 ahead[3] = {std::cos(up) * std::cos(azimuth), std::sin(up), std::cos(up) * std::sin(azimuth)};
    const double right[3] = {-std::sin(azimuth), 0, std::cos(azimuth)};
    const double above[3] = {-std::sin(up) * std::cos(azimuth), std::cos(up), -std::sin(up) * std::sin(azimuth)};
    sandglass_camera_image image = pinhole();
    was_asked = was_asked || stage.wants_short_exposure();
    image.exposure = was_asked ? 1.0f / 64 : 1.0f;
    float columns[16] = {};
    for (int k = 0; k < 3; ++k)
      columns[k] = static_cast<float>(right[k]), columns[4 + k] = static_cast<float>(above[k]),
      columns[8 + k] = static_cast<float>(-ahead[k]);
    ASSERT_EQ(sandglass_camera_orientation(columns, image.orientation), 1);
    for (uint32_t i = 0; i < k_width * k_height; ++i) {
      double ray[3], length = 0, along = 0;
      const double u = (i % k_width - 79.5) / 150, v = (59.5 - i / k_width) / 150;
      for (int k = 0; k < 3; ++k) {
        ray[k] = ahead[k] + u * right[k] + v * above[k];
        length += ray[k] * ray[k], along += ray[k] * lamp[k];
      }
      const double linear = (along / std::sqrt(length) > 0.995 ? 50.0 : 0.2) * static_cast<double>(image.exposure);
      const double coded =
          linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(std::min(linear, 1.0), 1 / 2.4) - 0.055;
      for (size_t c = 0; c < 3; ++c) pixels[3 * i + c] = static_cast<uint8_t>(std::lround(255 * coded));
    }
    image.planes[0] = pixels.data(), image.strides[0] = 3 * k_width;
    image.timestamp_ns = 200'000'000u * static_cast<uint64_t>(shot);
    // The light fades in; no time may pass for the sand here, so the block stands.
    (void)stage.frame(0.0f, 1.0f, nullptr, &image);
  }
  EXPECT_TRUE(was_asked) << "a clipped lamp must ask for short exposures";
  sandglass_room_light light = stage.light();
  EXPECT_EQ(light.main_share, 0.0f) << "nothing fades in without time";
  for (int frame = 0; frame < 300; ++frame) {
    (void)stage.frame(0.02f, 1.0f, nullptr);
    EXPECT_LT(stage.light().main_share - light.main_share, 0.04f) << "light must come in softly";
    light = stage.light();
  }
  EXPECT_EQ(stage.look(), nullptr);
  EXPECT_GT(light.main_share, 0.1f);
  double agreement = 0;
  for (int k = 0; k < 3; ++k) agreement += static_cast<double>(light.main_direction[k]) * lamp[k];
  EXPECT_GT(agreement, 0.98);
  EXPECT_FLOAT_EQ(stage.shadow_strength(), stage.shadow().opacity * light.main_share);
  EXPECT_FLOAT_EQ(stage.light_scale(), light.white / 64.0f);

  std::vector<std::byte> saved;
  ASSERT_TRUE(static_cast<bool>(stage.save_room(&saved)));
  stage.forget_room();
  EXPECT_NE(stage.look(), nullptr);
  ASSERT_TRUE(static_cast<bool>(stage.restore_room(saved.data(), saved.size())));
  EXPECT_EQ(stage.look(), nullptr);
  EXPECT_FALSE(static_cast<bool>(stage.restore_room(saved.data(), saved.size() - 1)));
}

}  // namespace
