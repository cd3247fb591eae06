// What a depth camera sees that looks straight down at a plane with a box on it: whole millimetres, without noise.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "sandglass/sandglass.hpp"

namespace sandglass::tests {

constexpr uint32_t k_width = 128, k_height = 96;
constexpr float k_focal = 100;                   // pixels: 6 mm of the plane each
constexpr double k_camera_high = 0.6;            // metres above the plane
constexpr double k_box[3] = {0.10, 0.05, 0.08};  // half its width, its height, half its depth

struct DepthOfBox {
  std::vector<uint16_t> pixels;
  std::vector<uint8_t> mask;  // where the box is
  sandglass_depth_image image = depth_image();

  // `factor`: what the camera tells in place of 1.
  explicit DepthOfBox(bool box = true, double factor = 1) {
    for (uint32_t y = 0; y < k_height; ++y)
      for (uint32_t x = 0; x < k_width; ++x) {
        const double right = (x - 0.5 * (k_width - 1)) / k_focal, down = (y - 0.5 * (k_height - 1)) / k_focal;
        const double top = k_camera_high - k_box[1];
        const bool on = box && std::fabs(right * top) < k_box[0] && std::fabs(down * top) < k_box[2];
        pixels.push_back(static_cast<uint16_t>(1000 * factor * (on ? top : k_camera_high) + 0.5));
        mask.push_back(on ? 1 : 0);
      }
    image.width = k_width;
    image.height = k_height;
    image.depth = pixels.data();
    image.stride = 2 * k_width;
    image.focal_x = image.focal_y = k_focal;
    image.centre_x = 0.5f * (k_width - 1);
    image.centre_y = 0.5f * (k_height - 1);
    image.position[1] = static_cast<float>(k_camera_high);
    // Looks along -y, with the image's up along -z.
    const float x_axis[3] = {1, 0, 0};
    sandglass_rotation_about(x_axis, -1.57079632679f, image.orientation);
  }
  DepthOfBox(const DepthOfBox&) = delete;
  DepthOfBox& operator=(const DepthOfBox&) = delete;
};

inline Relief made(const sandglass_relief_desc& desc = relief_desc()) {
  Relief relief;
  EXPECT_TRUE(relief.create(desc));
  return relief;
}

// After so many looks at the same.
inline Relief seen(const sandglass_depth_image& image, uint32_t looks = 8) {
  Relief relief = made();
  for (uint32_t i = 0; i < looks; ++i) EXPECT_TRUE(relief.set_image(image));
  return relief;
}

inline std::vector<float> heights_of(const Relief& relief) {
  const sandglass_heights h = relief.heights();
  return {h.heights, h.heights + h.cells[0] * h.cells[1]};
}

// How many heights are farther from the truth than that, of cells 1 cm or more within the box, or 2 cm or more beside it.
inline uint32_t wrong_heights(const Relief& relief, double tolerance, double truth = k_box[1]) {
  const sandglass_heights h = relief.heights();
  uint32_t wrong = 0;
  for (uint32_t z = 0; z < h.cells[1]; ++z)
    for (uint32_t x = 0; x < h.cells[0]; ++x) {
      const double half = 0.5 * static_cast<double>(h.cell), along = (x + 0.5 - 0.5 * h.cells[0]) * 2 * half,
                   across = (z + 0.5 - 0.5 * h.cells[1]) * 2 * half;
      const bool on = std::fabs(along) + half < k_box[0] - 0.01 && std::fabs(across) + half < k_box[2] - 0.01;
      const bool beside = std::fabs(along) > k_box[0] + 0.02 || std::fabs(across) > k_box[2] + 0.02;
      const double is = static_cast<double>(h.heights[z * h.cells[0] + x]);
      wrong += on ? std::fabs(is - truth) > tolerance : beside && is != 0;
    }
  return wrong;
}

}  // namespace sandglass::tests
