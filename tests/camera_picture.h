// A camera's image of these bytes, in one plane or in NV12's two, seen straight ahead.
#pragma once

#include <cstdint>

#include "sandglass/camera.h"

namespace sandglass::tests {

inline sandglass_camera_image camera_picture(const uint8_t* bytes, uint32_t width, uint32_t height, float focal,
                                             sandglass_camera_format format = SANDGLASS_CAMERA_RGB) {
  const bool yuv = format == SANDGLASS_CAMERA_NV12;
  sandglass_camera_image image;
  sandglass_camera_image_default(&image);
  image.format = format;
  image.width = width;
  image.height = height;
  image.planes[0] = bytes;
  image.planes[1] = yuv ? bytes + uint64_t{width} * height : nullptr;
  image.strides[0] = static_cast<int32_t>(yuv ? width : 3 * width);
  image.strides[1] = yuv ? static_cast<int32_t>(width) : 0;
  image.focal_x = image.focal_y = focal;
  image.centre_x = 0.5f * static_cast<float>(width - 1);
  image.centre_y = 0.5f * static_cast<float>(height - 1);
  return image;
}

}  // namespace sandglass::tests
