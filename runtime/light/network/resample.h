// A camera's image as the lighting network wants it: 256 x 192 upright sRGB pixels at 85 degrees across the diagonal.
//
// Two pinhole cameras that share centre and axis differ by a scale and a shift of each axis, also when the sensor is
// mounted a quarter turn off. So each axis is resampled on its own. An output pixel averages the box of input pixels
// that it covers. The box is at least one pixel wide, which interpolates where the image is enlarged. All sums are
// integers, so the result is the same on every machine.
//
// What the camera does not see gets the colour of the image's edge, here as in training. YUV is averaged before it is
// converted. Planes are read as the camera hands them over, with their strides. Rows are summed first, then columns:
// the order in which the image lies in memory.
#pragma once

#include <cstdint>

#include "runtime/light/camera/camera_image.h"
#include "sandglass/estimator.h"

namespace sandglass {

constexpr uint32_t k_light_width = SANDGLASS_ESTIMATOR_WIDTH, k_light_height = SANDGLASS_ESTIMATOR_HEIGHT;  // pixels
// Focal length of the output in pixels: half its diagonal, 160, over the tangent of 42.5 degrees.
constexpr double k_light_focal = 174.60936017108344;
// Sums that are kept at a time, one for each byte of a row.
constexpr uint32_t k_camera_sums = 4096;
// Of a box with more rows than this, only the middle ones are read. That bounds the work on images of thousands of
// rows.
constexpr uint32_t k_camera_box_rows = 16;

// A rectangle of output pixels, in the orientation of the stored image: k_light_height rows of k_light_width pixels for
// a turn of 0 or 180 degrees, k_light_width rows of k_light_height for 90 or 270.
struct CameraBlock {
  uint32_t first_row, rows, first_column, columns;
};
CameraBlock whole_camera_block(const CameraImage& image);
// Makes a block of the output. The bytes are the same for blocks of any size in any order. `sums` is scratch.
void resample_camera_block(const CameraImage& image, const CameraBlock& block,
                           uint8_t rgb[3 * k_light_width * k_light_height], uint32_t sums[k_camera_sums]);

// The blocks that are work units: some whole rows, or parts of one row where a whole one would read too much of a wide
// image.
struct CameraBlocks {
  uint32_t rows, columns;  // of a block; the last ones may be smaller
  uint32_t across, count;  // blocks beside each other, and all blocks
  uint64_t bytes;          // of the image that a block reads at most, without the edges of boxes
};
// What a unit reads at most: some tens of microseconds.
constexpr uint64_t k_camera_block_bytes = 256 * 1024;
CameraBlocks camera_blocks(const CameraImage& image);
CameraBlock camera_block(const CameraImage& image, const CameraBlocks& blocks, uint32_t index);

}  // namespace sandglass
