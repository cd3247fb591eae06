// What the phones' samples share: it pours within the budget, is lit from the first frame on, and reads an image in
// every layout that Android has.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "android/sample/camera_planes.h"
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

// An image as three planes, whose rows end in padding, as those of cameras do.
constexpr uint32_t k_width = 160, k_height = 120, k_row = 192;
struct Planes {
  std::vector<uint8_t> y, u, v, uv, vu;
  Planes() : y(k_row * k_height), u(k_row * k_height / 2), v(u), uv(u), vu(u) {
    for (uint32_t row = 0; row < k_height; ++row)
      for (uint32_t column = 0; column < k_width; ++column) {
        y[row * k_row + column] = static_cast<uint8_t>(250 - column - (row > 80 ? 60 : 0));
        const size_t chroma = row / 2 * k_row + column / 2, pair = row / 2 * k_row + (column & ~1u);
        u[chroma] = uv[pair] = vu[pair + 1] = static_cast<uint8_t>(110 + row / 8);
        v[chroma] = uv[pair + 1] = vu[pair] = static_cast<uint8_t>(130 + column / 16);
      }
  }
  bool set(const uint8_t* first, const uint8_t* second, std::array<int32_t, 3> pixels,
           sandglass_camera_image* image) const {
    const uint8_t* const of[3] = {y.data(), first, second};
    const int32_t rows[3] = {k_row, k_row, k_row};
    return sample::set_yuv_planes(of, rows, pixels.data(), image);
  }
};

TEST(CameraPlanes, EveryLayoutOfOneImageIsTheSameImageAndAnotherIsRefused) {
  const Planes planes;
  sandglass_camera_image image = sandglass::camera_image();
  image.width = k_width;
  image.height = k_height;
  image.focal_x = image.focal_y = 150.0f;
  // The hash of what the library keeps of the image.
  const auto kept = [&](const uint8_t* u, const uint8_t* v, int32_t pixel, sandglass_camera_format expected) {
    EXPECT_TRUE(planes.set(u, v, {1, pixel, pixel}, &image));
    EXPECT_EQ(image.format, expected);
    sandglass::Room room;
    EXPECT_TRUE(room.create());
    EXPECT_TRUE(room.set_image(image));
    return room.hash();
  };
  for (const std::array<int32_t, 3>& pixels : {std::array{1, 4, 4}, std::array{1, 2, 2}, std::array{1, 1, 2}}) {
    EXPECT_FALSE(planes.set(planes.u.data(), planes.v.data(), pixels, &image));
    EXPECT_EQ(image.planes[0], nullptr) << "nothing is touched";
  }
  const uint64_t separate = kept(planes.u.data(), planes.v.data(), 1, SANDGLASS_CAMERA_I420);
  EXPECT_EQ(kept(planes.uv.data(), planes.uv.data() + 1, 2, SANDGLASS_CAMERA_NV12), separate);
  EXPECT_EQ(kept(planes.vu.data() + 1, planes.vu.data(), 2, SANDGLASS_CAMERA_NV21), separate);
  EXPECT_NE(kept(planes.v.data(), planes.u.data(), 1, SANDGLASS_CAMERA_I420), separate) << "exchanged colours";
}

}  // namespace
