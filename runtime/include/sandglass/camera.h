/* Sandglass camera: one image of the camera, as it lies in the app's memory, and where the camera looked. One image is
 * estimated by a network (estimator.h); many are gathered into a room (room.h).
 *
 * The world frame is right-handed with y up, as in sandglass.h. Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_CAMERA_H
#define SANDGLASS_CAMERA_H

#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The longest side of a camera image, pixels. */
#define SANDGLASS_CAMERA_SIDE_LIMIT 16384

/* How the bytes of an image are laid out.
 *
 * RGB, RGBA and BGRA: one plane. NV12 and NV21: luma, then pairs of chroma at half resolution, U first in NV12, V
 * first in NV21. I420: luma, U, V. P010: NV12 in numbers of 16 bits, of which the upper ten count; only the upper eight
 * are read.
 *
 * Android's YUV_420_888 is I420 with `chroma_step` = the pixel stride of its planes U and V, whatever their order.
 * ARKit's capturedImage is NV12, or P010 where the app asked for HDR video. */
typedef int32_t sandglass_camera_format;
enum {
  SANDGLASS_CAMERA_RGB = 0,
  SANDGLASS_CAMERA_RGBA = 1,
  SANDGLASS_CAMERA_NV12 = 2,
  SANDGLASS_CAMERA_NV21 = 3,
  SANDGLASS_CAMERA_I420 = 4,
  SANDGLASS_CAMERA_BGRA = 5,
  SANDGLASS_CAMERA_P010 = 6
};

/* How luma and chroma become RGB: by ITU-R BT.601, BT.709 or BT.2020, with luma over 0..255 (FULL) or over 16..235
 * (VIDEO). Android's cameras give FULL_601. iOS names its matrix in the attachments of the pixel buffer. */
typedef int32_t sandglass_yuv_range;
enum {
  SANDGLASS_YUV_FULL_601 = 0,
  SANDGLASS_YUV_VIDEO_601 = 1,
  SANDGLASS_YUV_FULL_709 = 2,
  SANDGLASS_YUV_VIDEO_709 = 3,
  SANDGLASS_YUV_FULL_2020 = 4,
  SANDGLASS_YUV_VIDEO_2020 = 5
};

/* What the values of R, G and B, 0..1, mean: the linear light of a value, in units of the reference white. sRGB; the
 * value itself; HLG and PQ of ITU-R BT.2100, whose reference white is 75 % of HLG and 203 cd/m^2, and which show up to
 * 3.8 and 49 times as much; or `curve`. iOS names it in the attachments of the pixel buffer. The colours of BT.2020
 * are taken for those of BT.709. */
typedef int32_t sandglass_transfer;
enum {
  SANDGLASS_TRANSFER_SRGB = 0,
  SANDGLASS_TRANSFER_LINEAR = 1,
  SANDGLASS_TRANSFER_HLG = 2,
  SANDGLASS_TRANSFER_PQ = 3,
  SANDGLASS_TRANSFER_CURVE = 4
};

/* A `turn_deg` that lets the library choose the quarter turn by which the world's up comes nearest to the image's up.
 * It needs a pose of the stored image. While a camera looks straight down or up, its last turn stays. */
#define SANDGLASS_TURN_FROM_POSE 0xffffffffu

/* An image of a pinhole camera, in the app's memory, and where the camera looked.
 *
 * The pose is that of the image *as stored*, unless `pose_is_upright` is 1: x along its rows to the right, y up its
 * columns, looking along -z. ArCamera_getPose and ARCamera.transform are such poses. ArCamera_getDisplayOrientedPose
 * and the transform of Unity's AR camera are those of the upright image. Only the rotation matters: light comes from
 * far. */
typedef struct sandglass_camera_image {
  uint32_t struct_size;
  /* How its pixels are stored. */
  sandglass_camera_format format;
  /* For NV12, NV21, I420 and P010. */
  sandglass_yuv_range range;
  /* Pixels as stored, 2..SANDGLASS_CAMERA_SIDE_LIMIT; even in NV12, NV21, I420 and P010. */
  uint32_t width, height;
  /* The clockwise turn that makes the stored image upright: 0, 90, 180, 270, or SANDGLASS_TURN_FROM_POSE, which is the
   * default. */
  uint32_t turn_deg;
  /* The upper row of each plane, as many as the format has. */
  const uint8_t* planes[3];
  /* Bytes from row to row of each plane, at least the bytes of a row. Negative where the lower row is stored first. */
  int32_t strides[3];
  /* Bytes from pixel to pixel of U and V in I420: 1 or 2. 0: 1. */
  uint32_t chroma_step;
  /* 1: each row is stored from right to left, as the preview of a front camera is. Pose, turn and focal length are those
   * of the image that is not mirrored; `centre_x` is where the principal point is stored. */
  uint32_t mirrored;
  /* Pixels of the stored image, 1..1e6. */
  float focal_x, focal_y;
  /* The principal point, pixels of the stored image, within it; the centre of the first pixel is (0, 0). */
  float centre_x, centre_y;
  /* Camera to world, (x, y, z, w) of any length above 0. */
  float orientation[4];
  /* 1: `orientation` is that of the upright image. 0: that of the stored one. */
  uint32_t pose_is_upright;
  /* When it was taken, by any clock that grows: the time of the filter. */
  uint64_t timestamp_ns;
  /* Where the camera was, world, metres. Only room.h reads it. */
  float position[3];
  /* How long and how sensitively the image was exposed, at least 0: seconds times ISO / 100, or any other number that
   * is proportional to it. ARCore: SENSOR_EXPOSURE_TIME * 1e-9 * SENSOR_SENSITIVITY / 100. ARKit: exposureDuration
   * times the ISO of the frame's EXIF data / 100. 0: unknown. Only room.h reads it. */
  float exposure;
  /* What the values mean. Default: sRGB. */
  sandglass_transfer transfer;
  /* With SANDGLASS_TRANSFER_CURVE the points of `curve`, 2..32; else 0. */
  uint32_t curve_points;
  /* Pairs of linear light and value, each 0..1 and never below the one before, the last above the first; straight in
   * between. Camera2's TonemapCurve.copyColorCurve writes such pairs. Read in the call or the frame that the image is
   * passed to. */
  const float* curve;
  /* White balance: what the camera multiplied linear red, green and blue by, each 1/16..16. ARCore: numbers 0, 1 and 3 of
   * COLOR_CORRECTION_GAINS. AVFoundation: deviceWhiteBalanceGains. Only ratios from image to image count. 0, 0, 0:
   * unknown; then room.h finds how it moves. Only room.h reads it. */
  float gains[3];
} sandglass_camera_image;

/* Fills *image with the defaults: RGB, no planes, the turn from the pose, no rotation, BT.601 over 0..255, at the origin,
 * exposure and gains unknown. */
SANDGLASS_API void sandglass_camera_image_default(sandglass_camera_image* image);

/* The focal length, in pixels, of a camera of which only the field of view across the diagonal is known (2.15). The
 * angle is in degrees, 1..179; 0 is returned for any other. Take ((width - 1) / 2, (height - 1) / 2) as the principal
 * point. */
SANDGLASS_API float sandglass_camera_focal(uint32_t width, uint32_t height, float diagonal_deg);

/* The rotation of a column-major 4 x 4 matrix from camera to world (simd_float4x4, OpenGL), as (x, y, z, w). The rest
 * of the matrix is not read. Returns 1. For a matrix that is not a rotation, to 0.001, it gives the identity and
 * returns 0. */
SANDGLASS_API int32_t sandglass_camera_orientation(const float matrix[16], float orientation[4]);

/* Whether the library can use an image. Fails with INVALID_ARGUMENT, and says which of these it is: an unknown format
 * or range, a side that is too short or too long, an odd side in YUV, a missing plane, a stride shorter than its row,
 * an unknown turn, a principal point outside the image or at (0, 0), which is where it is left out or normalised,
 * intrinsics or a pose that are not finite, an exposure, a transfer or gains out of range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_camera_check(const sandglass_camera_image* image,
                                                                          const char** reason);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_CAMERA_H */
