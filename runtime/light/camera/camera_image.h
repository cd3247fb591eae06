// A camera's image: its pixels, and directions from the camera's frame to the world's. What is wrong with one,
// sandglass_camera_check says; after that nothing here fails.
#pragma once

#include <cstdint>

#include "sandglass/camera.h"

namespace sandglass {

using CameraImage = sandglass_camera_image;

// The image with its turn known: SANDGLASS_TURN_FROM_POSE is replaced by what the pose says. `last` is that of the image
// before, and stays where another is hardly better.
CameraImage with_turn(const CameraImage& image, uint32_t last = SANDGLASS_TURN_FROM_POSE);

// From the upright camera's frame (x right, y down, z forward) to the world's.
void camera_to_world(const CameraImage& image, const double camera[3], double world[3]);

inline bool is_yuv(sandglass_camera_format format) {
  return format >= SANDGLASS_CAMERA_NV12 && format != SANDGLASS_CAMERA_BGRA;
}

// Where each of a pixel's three channels lies: R, G, B, or Y, U, V.
struct CameraLayout {
  uint32_t planes;
  uint32_t plane[3], step[3], offset[3];  // of a channel; bytes from pixel to pixel, and from a pixel's first byte
};
CameraLayout camera_layout(const CameraImage& image);

// One pixel of the stored image. x and y lie within it.
void camera_pixel(const CameraImage& image, const CameraLayout& layout, uint32_t x, uint32_t y, uint8_t rgb[3]);

inline uint8_t clamped_byte(int32_t value) { return static_cast<uint8_t>(value < 0 ? 0 : value > 255 ? 255 : value); }

// Coefficients times 2^16: ITU-R BT.601, BT.709 and BT.2020, for luma over 0..255 and over 16..235 (chroma over
// 16..240).
struct YuvMatrix {
  int32_t luma_offset, luma, red_v, green_u, green_v, blue_u;
};
constexpr YuvMatrix k_yuv_matrices[6] = {
    {0, 65536, 91881, -22553, -46802, 116130},  {16, 76309, 104597, -25675, -53279, 132201},
    {0, 65536, 103206, -12276, -30679, 121609}, {16, 76309, 117489, -13975, -34925, 138438},
    {0, 65536, 96639, -10784, -37444, 123299},  {16, 76309, 110014, -12277, -42626, 140363}};

inline void yuv_to_rgb(sandglass_yuv_range range, uint8_t y, uint8_t u, uint8_t v, uint8_t rgb[3]) {
  const YuvMatrix& m = k_yuv_matrices[range];
  const int32_t luma = (y - m.luma_offset) * m.luma + 32768, cu = u - 128, cv = v - 128;
  // Shifts of negative numbers keep the sign (C++20).
  rgb[0] = clamped_byte((luma + m.red_v * cv) >> 16);
  rgb[1] = clamped_byte((luma + m.green_u * cu + m.green_v * cv) >> 16);
  rgb[2] = clamped_byte((luma + m.blue_u * cu) >> 16);
}

}  // namespace sandglass
