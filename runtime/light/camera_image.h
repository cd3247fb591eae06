// A camera's image as the lighting network wants it: 256 x 192 upright sRGB pixels at 85 degrees across the diagonal.
//
// Two pinhole cameras that share centre and axis differ by a scale and a shift of each axis, also when the sensor is
// mounted a quarter turn off. So each axis is resampled on its own: an output pixel averages the box of input pixels
// that it covers (at least one pixel wide, which interpolates where the image is enlarged), in integers, so that the
// result is the same on every machine. What the camera does not see is filled with the colour of the image's edge, in
// training as here. YUV is averaged before it is converted; planes are read as the camera hands them over, with their
// strides. Rows are summed first, whole rows at a time, then columns: the order in which the image lies in memory.
#pragma once

#include <cstdint>

#include "sandglass/light.h"

namespace sandglass {

constexpr uint32_t k_light_width = SANDGLASS_LIGHT_WIDTH, k_light_height = SANDGLASS_LIGHT_HEIGHT;  // pixels
// Focal length of the output in pixels: half its diagonal, 160, over the tangent of 42.5 degrees.
constexpr double k_light_focal = 174.60936017108344;
// Sums of a row's bytes that are kept at a time.
constexpr uint32_t k_camera_sums = 4096;
// A box is read in its middle rows, where it has more: it bounds the work on images of thousands of rows.
constexpr uint32_t k_camera_box_rows = 16;

using CameraImage = sandglass_camera_image;

// Everything that may be wrong with an image, one sentence each; after this the passes run blind.
sandglass_status check_camera_image(const CameraImage* image, const char** reason);

// The image with its turn known: SANDGLASS_TURN_FROM_POSE is decided by the pose.
CameraImage with_turn(const CameraImage& image);

// A direction of the upright camera (x right, y down, z forward), in the world.
void camera_to_world(const CameraImage& image, const double camera[3], double world[3]);

// Output pixels in the stored image's orientation: k_light_height rows of k_light_width for a turn of 0 or 180 degrees,
// the other way round for 90 or 270.
struct CameraBlock {
  uint32_t first_row, rows, first_column, columns;
};
CameraBlock whole_camera_block(const CameraImage& image);
// Makes a block of the output; in any order, cut in any way, the bytes are the same. `sums` is scratch.
void resample_camera_block(const CameraImage& image, const CameraBlock& block,
                           uint8_t rgb[3 * k_light_width * k_light_height], uint32_t sums[k_camera_sums]);

// The blocks that are units of work: whole rows, some at a time, or parts of a row where one reads too much of a wide
// image.
struct CameraBlocks {
  uint32_t rows, columns, across, count;  // of a block but the last ones; blocks beside each other; of all
  uint64_t bytes;                         // of the image that one reads, at most, but for the edges of boxes
};
// What a unit reads at most, some tens of microseconds of it.
constexpr uint64_t k_camera_block_bytes = 256 * 1024;
CameraBlocks camera_blocks(const CameraImage& image);
CameraBlock camera_block(const CameraImage& image, const CameraBlocks& blocks, uint32_t index);

}  // namespace sandglass
