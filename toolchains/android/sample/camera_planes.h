// Tells which layout the planes of Android's YUV_420_888 have. That format leaves open how chroma lies in memory; the
// pixel stride and the order of the planes show whether it is NV12, NV21 or I420, which the library reads.
#pragma once

#include <cstdint>

#include "sandglass/camera.h"

namespace sample {

// Takes the planes Y, U and V with their strides in bytes, from row to row and from pixel to pixel. Returns false and
// leaves *image as it was if the layout is none of the three.
inline bool set_yuv_planes(const uint8_t* const planes[3], const int32_t row_strides[3], const int32_t pixel_strides[3],
                           sandglass_camera_image* image) {
  const uint8_t *u = planes[1], *v = planes[2];
  const bool same_rows = row_strides[1] == row_strides[2];
  if (pixel_strides[0] != 1 || pixel_strides[1] != pixel_strides[2] || row_strides[0] < 0 || row_strides[1] < 0)
    return false;
  if (pixel_strides[1] == 1) {
    image->format = SANDGLASS_CAMERA_I420;
    image->planes[1] = u;
    image->planes[2] = v;
  } else if (pixel_strides[1] == 2 && same_rows && v == u + 1) {
    image->format = SANDGLASS_CAMERA_NV12;
    image->planes[1] = u;
    image->planes[2] = nullptr;
  } else if (pixel_strides[1] == 2 && same_rows && u == v + 1) {
    image->format = SANDGLASS_CAMERA_NV21;
    image->planes[1] = v;
    image->planes[2] = nullptr;
  } else {
    return false;
  }
  image->planes[0] = planes[0];
  for (int i = 0; i < 3; ++i) image->strides[i] = static_cast<uint32_t>(row_strides[i]);
  return true;
}

}  // namespace sample
