// A camera's image as the lighting network wants it: 256 x 192 upright sRGB pixels at 85 degrees across the diagonal.
//
// Two pinhole cameras that share centre and axis differ by a scale and a shift of each axis, also when the sensor is
// mounted a quarter turn off. So each axis is resampled on its own: an output pixel averages the box of input pixels
// that it covers (at least one pixel wide, which interpolates where the image is enlarged), in integers, so that the
// result is the same on every machine. What the camera does not see is filled with the colour of the image's edge, in
// training as here. YUV is averaged before it is converted; planes are read as the camera hands them over, with their
// strides.
#pragma once

#include <cstdint>

#include "sandglass/sandglass.h"

namespace sandglass {

constexpr uint32_t k_light_width = 256, k_light_height = 192;  // pixels
constexpr uint32_t k_camera_side_limit = 16384;                // pixels of an input's side
// Focal length of the output in pixels: half its diagonal, 160, over the tangent of 42.5 degrees.
constexpr double k_light_focal = 174.60936017108344;

enum class CameraFormat : uint32_t { rgb, rgba, nv12, nv21, i420 };

// Luma and chroma to RGB. Android's cameras give full_601; iOS names its matrix in the pixel buffer's attachments.
enum class YuvRange : uint32_t { full_601, video_601, full_709, video_709 };

struct CameraImage {
  CameraFormat format;
  YuvRange range;            // of nv12, nv21, i420
  uint32_t width, height;    // pixels as stored
  const uint8_t* planes[3];  // rgb, rgba: one; nv12, nv21: luma, pairs of chroma; i420: luma, U, V
  uint32_t strides[3];       // bytes from row to row
  uint32_t turn_deg;         // clockwise turn that makes the image upright: 0, 90, 180, 270
  float focal_x, focal_y;    // pixels, along the stored image's axes
  float centre_x, centre_y;  // principal point, pixels; the centre of the first pixel is (0, 0)
};

// Everything that may be wrong with an image, one sentence each; after this the passes run blind.
sandglass_status check_camera_image(const CameraImage* image, const char** reason);

// Output is made in rows of the stored image's orientation: k_light_height of them for a turn of 0 or 180 degrees,
// k_light_width for 90 or 270. A range of rows is a unit of work; rows may be made in any order.
uint32_t camera_rows(const CameraImage& image);
void resample_camera_rows(const CameraImage& image, uint32_t first, uint32_t count,
                          uint8_t rgb[3 * k_light_width * k_light_height]);

}  // namespace sandglass
