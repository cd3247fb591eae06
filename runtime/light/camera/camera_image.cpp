#include "runtime/light/camera/camera_image.h"

#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/math.h"
#include "runtime/math/turn.h"

namespace sandglass {

namespace {

constexpr float k_intrinsics_limit = 1e6f;
constexpr float k_exposure_limit = 1e6f;
constexpr float k_gain_limit = 16.0f;
constexpr double k_turn_margin =
    0.35;  // of the image's up: 20 degrees beyond the vertical, or beyond half a quarter turn

constexpr uint32_t k_curve_points = 32;
bool is_curve(const float* curve, uint32_t points) {
  if (points < 2 || points > k_curve_points || !all_within(curve, 2 * points, 0.0f, 1.0f)) return false;
  const float* last = curve + 2 * (points - 1);
  for (const float* at = curve; at != last; at += 2)
    if (at[2] < at[0] || at[3] < at[1]) return false;
  return last[0] > curve[0] && last[1] > curve[1];
}

}  // namespace

// Once an image: made small, as sandglass_camera_check.
__attribute__((cold)) CameraImage with_turn(const CameraImage& image, uint32_t last) {
  CameraImage turned = image;
  if (image.turn_deg != SANDGLASS_TURN_FROM_POSE) return turned;
  Rotation rotation = {};
  (void)rotation_of(image.orientation, &rotation);
  // The world's up in the stored image, x right and y down. The turn is right in which up has the smallest y.
  const double right = rotation.m[1][0], down = -rotation.m[1][1];
  const double upright[4] = {down, right, -down, -right};
  uint32_t best = 0;
  for (uint32_t quarter = 1; quarter < 4; ++quarter)
    if (upright[quarter] < upright[best]) best = quarter;
  const bool stays = last < 360 && upright[last / 90] < upright[best] + k_turn_margin;
  turned.turn_deg = stays ? last : 90 * best;
  return turned;
}

CameraLayout camera_layout(const CameraImage& image) {
  switch (image.format) {
    case SANDGLASS_CAMERA_RGB:
      return {1, {}, {3, 3, 3}, {0, 1, 2}};
    case SANDGLASS_CAMERA_RGBA:
      return {1, {}, {4, 4, 4}, {0, 1, 2}};
    case SANDGLASS_CAMERA_BGRA:
      return {1, {}, {4, 4, 4}, {2, 1, 0}};
    case SANDGLASS_CAMERA_NV12:
      return {2, {0, 1, 1}, {1, 2, 2}, {0, 0, 1}};
    case SANDGLASS_CAMERA_NV21:
      return {2, {0, 1, 1}, {1, 2, 2}, {0, 1, 0}};
    case SANDGLASS_CAMERA_P010:  // of two bytes the upper one, which is stored second
      return {2, {0, 1, 1}, {2, 4, 4}, {1, 1, 3}};
    default: {
      const uint32_t step = image.chroma_step == 2 ? 2 : 1;
      return {3, {0, 1, 2}, {1, step, step}, {0, 0, 0}};
    }
  }
}

void camera_to_world(const CameraImage& image, const double camera[3], double world[3]) {
  const uint32_t turn = image.pose_is_upright != 0 ? 0 : image.turn_deg;
  const double x = camera[0], y = camera[1];
  const double stored_x = turn == 90 ? y : turn == 180 ? -x : turn == 270 ? -y : x;
  const double stored_y = turn == 90 ? -x : turn == 180 ? -y : turn == 270 ? x : y;
  Rotation rotation = {};
  (void)rotation_of(image.orientation, &rotation);
  const double local[3] = {stored_x, -stored_y, -camera[2]};  // y up, looking along -z
  rotate(rotation, local, world);
}

void camera_pixel(const CameraImage& image, const CameraLayout& at, uint32_t x, uint32_t y, uint8_t rgb[3]) {
  const bool yuv = is_yuv(image.format);
  uint8_t channels[3];
  for (int c = 0; c < 3; ++c) {
    const uint32_t plane = at.plane[c], half = plane != 0 ? 1 : 0;
    channels[c] = image.planes[plane][static_cast<int64_t>(y >> half) * image.strides[plane] +
                                      (x >> half) * at.step[c] + at.offset[c]];
  }
  if (yuv) return yuv_to_rgb(image.range, channels[0], channels[1], channels[2], rgb);
  for (int c = 0; c < 3; ++c) rgb[c] = channels[c];
}

}  // namespace sandglass

using namespace sandglass;

namespace {

// What is wrong with where an image's pixels lie, or null.
const char* layout_fault(const sandglass_camera_image& image) {
  if (image.format < SANDGLASS_CAMERA_RGB || image.format > SANDGLASS_CAMERA_P010)
    return "camera image: unknown format; give RGB, RGBA, BGRA, NV12, NV21, I420 or P010.";
  if (image.range < SANDGLASS_YUV_FULL_601 || image.range > SANDGLASS_YUV_VIDEO_2020)
    return "camera image: unknown YUV range; give one of BT.601, BT.709 or BT.2020, full or video.";
  if (image.width < 2 || image.height < 2)
    return "camera image: smaller than 2 x 2 pixels; light cannot be estimated from it.";
  if (image.width > SANDGLASS_CAMERA_SIDE_LIMIT || image.height > SANDGLASS_CAMERA_SIDE_LIMIT)
    return "camera image: a side is longer than 16384 pixels; scale it down.";
  const bool yuv = is_yuv(image.format);
  if (yuv && (image.width % 2 != 0 || image.height % 2 != 0))
    return "camera image: YUV with an odd width or height; crop it to even numbers.";
  if (image.chroma_step > 2 || (image.chroma_step != 0 && image.format != SANDGLASS_CAMERA_I420))
    return "camera image: chroma_step is not 0, or 1 or 2 in I420; give the pixel stride of U and V.";
  if (image.mirrored > 1) return "camera image: mirrored is neither 0 nor 1.";
  const CameraLayout layout = camera_layout(image);
  for (uint32_t i = 0; i < layout.planes; ++i) {
    if (image.planes[i] == nullptr) return "camera image: a plane is NULL; give every plane of the format.";
    // The last pixel of planes that lie in each other ends before its step does.
    const uint32_t pixels = i != 0 ? image.width / 2 : image.width;
    const bool lone = image.format == SANDGLASS_CAMERA_I420 && i != 0;
    const int64_t row = lone ? int64_t{pixels - 1} * layout.step[i] + 1 : int64_t{pixels} * layout.step[i];
    const int64_t stride = image.strides[i];
    if ((stride < 0 ? -stride : stride) < row)
      return "camera image: a stride is smaller than its row; strides are bytes from row to row.";
  }
  return nullptr;
}

// What is wrong with how its camera stands, or null.
const char* view_fault(const sandglass_camera_image& image) {
  const bool from_pose = image.turn_deg == SANDGLASS_TURN_FROM_POSE;
  if (!from_pose && image.turn_deg != 0 && image.turn_deg != 90 && image.turn_deg != 180 && image.turn_deg != 270)
    return "camera image: the turn is not 0, 90, 180 or 270 degrees; give the sensor's orientation.";
  if (from_pose && image.pose_is_upright != 0)
    return "camera image: the pose of an upright image does not tell its turn; give the turn in degrees.";
  if (!within(image.focal_x, 1.0f, k_intrinsics_limit) || !within(image.focal_y, 1.0f, k_intrinsics_limit))
    return "camera image: a focal length is not a number from 1 to a million pixels; give the camera's intrinsics.";
  if (!within(image.centre_x, 0.0f, static_cast<float>(image.width - 1)) ||
      !within(image.centre_y, 0.0f, static_cast<float>(image.height - 1)) ||
      (image.centre_x == 0 && image.centre_y == 0))
    return "camera image: the principal point is outside the image or at (0, 0); give the intrinsics of this image, "
           "in its pixels.";
  Rotation rotation = {};
  if (!rotation_of(image.orientation, &rotation))
    return "camera image: the orientation is zero or not finite; give the camera's pose.";
  if (!all_within(image.position, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
    return "camera image: the position is not finite or beyond 1000 m; give the camera's pose.";
  return nullptr;
}

// What is wrong with the light that its values mean, or null.
const char* value_fault(const sandglass_camera_image& image) {
  if (!within(image.exposure, 0.0f, k_exposure_limit))
    return "camera image: the exposure is not in 0..1e6; give seconds times ISO / 100, or 0.";
  if (image.transfer < SANDGLASS_TRANSFER_SRGB || image.transfer > SANDGLASS_TRANSFER_CURVE)
    return "camera image: unknown transfer; give SRGB, LINEAR, HLG, PQ or CURVE.";
  const bool has_curve = image.transfer == SANDGLASS_TRANSFER_CURVE;
  if (has_curve != (image.curve != nullptr) || (!has_curve && image.curve_points != 0))
    return "camera image: a curve goes with SANDGLASS_TRANSFER_CURVE, and only with it.";
  if (has_curve && !is_curve(image.curve, image.curve_points))
    return "camera image: the curve is not 2 to 32 pairs of light and value that never fall, of 0 to 1; give "
           "both for each point, as TonemapCurve.copyColorCurve does.";
  const float* gains = image.gains;
  const bool given = gains[0] != 0 || gains[1] != 0 || gains[2] != 0;
  if (given && !all_within(gains, 3, 1 / k_gain_limit, k_gain_limit))
    return "camera image: the gains are not three numbers of 1/16..16; give those of red, green and blue, or 0, 0, "
           "0 where they are unknown.";
  return nullptr;
}

}  // namespace

void sandglass_camera_image_default(sandglass_camera_image* image) {
  if (!empty_struct(image)) return;
  image->turn_deg = SANDGLASS_TURN_FROM_POSE;
  image->orientation[3] = 1.0f;
}

float sandglass_camera_focal(uint32_t width, uint32_t height, float diagonal_deg) {
  if (!(diagonal_deg >= 1.0f && diagonal_deg <= 179.0f)) return 0.0f;
  const double w = width, h = height;
  const SinCos half = sin_cos_turns(static_cast<double>(diagonal_deg) / 720.0);
  return static_cast<float>(0.5 * square_root(w * w + h * h) * half.cos / half.sin);
}

// Once an image, as above.
__attribute__((cold)) sandglass_status sandglass_camera_check(const sandglass_camera_image* image,
                                                              const char** reason) {
  if (image == nullptr) return refuse(reason, "camera image: the image is NULL; give an image.");
  if (image->struct_size != sizeof *image)
    return refuse(reason,
                  "camera image: struct_size is not this library's; start from sandglass_camera_image_default.");
  const char* fault = layout_fault(*image);
  if (fault == nullptr) fault = view_fault(*image);
  if (fault == nullptr) fault = value_fault(*image);
  return fault == nullptr ? accept(reason) : refuse(reason, fault);
}

int32_t sandglass_camera_orientation(const float matrix[16], float orientation[4]) {
  if (orientation == nullptr) return 0;
  if (matrix == nullptr) {
    orientation[0] = orientation[1] = orientation[2] = 0.0f;
    orientation[3] = 1.0f;
    return 0;
  }
  constexpr double k_tolerance = 1e-3;  // of lengths and right angles
  double axes[3][3];
  bool fine = true;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) axes[i][j] = static_cast<double>(matrix[4 * i + j]);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) {
      const double product = axes[i][0] * axes[j][0] + axes[i][1] * axes[j][1] + axes[i][2] * axes[j][2];
      fine = fine && absolute(product - (i == j ? 1.0 : 0.0)) < k_tolerance;
    }
  const double* x = axes[0];
  const double* y = axes[1];
  const double turned = axes[2][0] * (x[1] * y[2] - x[2] * y[1]) + axes[2][1] * (x[2] * y[0] - x[0] * y[2]) +
                        axes[2][2] * (x[0] * y[1] - x[1] * y[0]);
  fine = fine && turned > 0.0;
  if (fine) quaternion_of(axes[0], axes[1], axes[2], orientation);
  else {
    orientation[0] = orientation[1] = orientation[2] = 0.0f;
    orientation[3] = 1.0f;
  }
  return fine ? 1 : 0;
}
