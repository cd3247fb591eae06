#include "runtime/lighting/camera_image.h"

#include "runtime/core/math.h"

namespace sandglass {

namespace {

constexpr int32_t k_one = 256;  // a pixel, in the fixed point of boxes
constexpr float k_intrinsics_limit = 1e6f;

sandglass_status refuse(const char** reason, const char* sentence) {
  if (reason != nullptr) *reason = sentence;
  return SANDGLASS_ERROR_INVALID_ARGUMENT;
}

// Input interval that an output pixel covers along one axis, in 1/256 pixel from the image's edge; never empty.
struct Box {
  int32_t low, high;
};

Box box_of(uint32_t index, double first, double step, uint32_t size) {
  // Beyond this the answer is an edge pixel, and the conversion to integers is safe.
  const double limit = 2.0 * k_camera_side_limit;
  const double width = step < 1.0 ? 1.0 : step;
  double middle = first + step * index + 0.5;  // 0 is the image's edge
  middle = middle < -limit ? -limit : middle > limit ? limit : middle;
  const double half = width < limit ? 0.5 * width : 0.5 * limit;
  const int32_t end = static_cast<int32_t>(size) * k_one;
  auto low = static_cast<int32_t>(floor_index((middle - half) * k_one + 0.5));
  auto high = static_cast<int32_t>(floor_index((middle + half) * k_one + 0.5));
  if (high <= 0) return {0, k_one};
  if (low >= end) return {end - k_one, end};
  low = low < 0 ? 0 : low;
  high = high > end ? end : high;
  return high > low ? Box{low, high} : Box{low, low + 1};
}

// Where along a stored axis the output's pixels lie: pixel i of `count` at first + step * i.
struct Axis {
  double first, step;
};

// `focal`, `centre`: of the input along this axis; `backwards`: the output's axis runs against it. Chroma at half
// resolution has its samples between pairs of luma: (x - 1/2) / 2.
Axis axis_of(float focal, float centre, uint32_t count, bool backwards, bool half) {
  double step = static_cast<double>(focal) / k_light_focal;
  double first = static_cast<double>(centre) - step * 0.5 * (count - 1);
  if (half) step *= 0.5, first = (first - 0.5) * 0.5;
  if (backwards) first += step * (count - 1), step = -step;
  return {first, step};
}

Box oriented_box(const Axis& axis, uint32_t index, uint32_t count, uint32_t size) {
  // A box has no direction: count from the other end.
  return axis.step >= 0.0 ? box_of(index, axis.first, axis.step, size)
                          : box_of(count - 1 - index, axis.first + axis.step * (count - 1), -axis.step, size);
}

struct Plane {
  const uint8_t* bytes;
  uint32_t stride, step;  // bytes between rows and between pixels
  uint32_t width, height;
};

// The mean of one byte of each pixel over a box of pixels, rounded.
uint8_t box_mean(const Plane& plane, const Box& across, const Box& down) {
  const int32_t x0 = across.low / k_one, x1 = (across.high - 1) / k_one;
  const int32_t y0 = down.low / k_one, y1 = (down.high - 1) / k_one;
  uint64_t sum = 0;
  for (int32_t y = y0; y <= y1; ++y) {
    const uint8_t* row = plane.bytes + static_cast<uint64_t>(y) * plane.stride;
    const auto part = [](const Box& box, int32_t i) {
      const int32_t from = i * k_one > box.low ? i * k_one : box.low;
      const int32_t to = (i + 1) * k_one < box.high ? (i + 1) * k_one : box.high;
      return static_cast<uint32_t>(to - from);
    };
    uint32_t inner = 0, of_row = part(across, x0) * row[static_cast<uint64_t>(x0) * plane.step];
    for (int32_t x = x0 + 1; x < x1; ++x) inner += row[static_cast<uint64_t>(x) * plane.step];
    of_row += inner * k_one;
    if (x1 > x0) of_row += part(across, x1) * row[static_cast<uint64_t>(x1) * plane.step];
    sum += static_cast<uint64_t>(of_row) * part(down, y);
  }
  const uint64_t area = static_cast<uint64_t>(across.high - across.low) * static_cast<uint64_t>(down.high - down.low);
  return static_cast<uint8_t>((sum + area / 2) / area);
}

uint8_t clamped_byte(int32_t value) { return static_cast<uint8_t>(value < 0 ? 0 : value > 255 ? 255 : value); }

// Coefficients times 2^16: ITU-R BT.601 and BT.709, for luma over 0..255 and over 16..235 (chroma over 16..240).
struct YuvMatrix {
  int32_t luma_offset, luma, red_v, green_u, green_v, blue_u;
};
constexpr YuvMatrix k_matrices[4] = {{0, 65536, 91881, -22553, -46802, 116130},
                                     {16, 76309, 104597, -25675, -53279, 132201},
                                     {0, 65536, 103206, -12276, -30679, 121609},
                                     {16, 76309, 117489, -13975, -34925, 138438}};

void yuv_to_rgb(YuvRange range, uint8_t y, uint8_t u, uint8_t v, uint8_t rgb[3]) {
  const YuvMatrix& m = k_matrices[static_cast<uint32_t>(range)];
  const int32_t luma = (y - m.luma_offset) * m.luma + 32768, cu = u - 128, cv = v - 128;
  // Shifts of negative numbers keep the sign (C++20).
  rgb[0] = clamped_byte((luma + m.red_v * cv) >> 16);
  rgb[1] = clamped_byte((luma + m.green_u * cu + m.green_v * cv) >> 16);
  rgb[2] = clamped_byte((luma + m.blue_u * cu) >> 16);
}

bool is_yuv(CameraFormat format) { return format >= CameraFormat::nv12; }

bool finite_within(float value, float limit) { return value >= -limit && value <= limit; }  // false for NaN

}  // namespace

sandglass_status check_camera_image(const CameraImage* image, const char** reason) {
  if (image == nullptr) return refuse(reason, "camera image: there is none; give an image");
  if (image->format > CameraFormat::i420)
    return refuse(reason, "camera image: unknown format; give RGB, RGBA, NV12, NV21 or I420");
  if (image->range > YuvRange::video_709)
    return refuse(reason, "camera image: unknown YUV range; give one of BT.601 or BT.709, full or video");
  if (image->width < 2 || image->height < 2)
    return refuse(reason, "camera image: smaller than 2 x 2 pixels; light cannot be estimated from it");
  if (image->width > k_camera_side_limit || image->height > k_camera_side_limit)
    return refuse(reason, "camera image: a side is longer than 16384 pixels; scale it down");
  const bool yuv = is_yuv(image->format);
  if (yuv && (image->width % 2 != 0 || image->height % 2 != 0))
    return refuse(reason, "camera image: YUV with an odd width or height; crop it to even numbers");
  const uint32_t planes = image->format == CameraFormat::i420 ? 3 : yuv ? 2 : 1;
  const uint32_t row_bytes[3] = {image->format == CameraFormat::rgb    ? 3 * image->width
                                 : image->format == CameraFormat::rgba ? 4 * image->width
                                                                       : image->width,
                                 image->format == CameraFormat::i420 ? image->width / 2 : image->width,
                                 image->width / 2};
  for (uint32_t i = 0; i < planes; ++i) {
    if (image->planes[i] == nullptr)
      return refuse(reason, "camera image: a plane is NULL; give every plane of the format");
    if (image->strides[i] < row_bytes[i])
      return refuse(reason, "camera image: a stride is smaller than its row; strides are bytes from row to row");
  }
  if (image->turn_deg != 0 && image->turn_deg != 90 && image->turn_deg != 180 && image->turn_deg != 270)
    return refuse(reason, "camera image: the turn is not 0, 90, 180 or 270 degrees; give the sensor's orientation");
  if (!(image->focal_x >= 1.0f && image->focal_x <= k_intrinsics_limit && image->focal_y >= 1.0f &&
        image->focal_y <= k_intrinsics_limit))
    return refuse(
        reason,
        "camera image: a focal length is not a number from 1 to a million pixels; give the camera's intrinsics");
  if (!finite_within(image->centre_x, k_intrinsics_limit) || !finite_within(image->centre_y, k_intrinsics_limit))
    return refuse(reason, "camera image: the principal point is not finite; give the camera's intrinsics");
  if (reason != nullptr) *reason = "";
  return SANDGLASS_OK;
}

uint32_t camera_rows(const CameraImage& image) { return image.turn_deg % 180 == 0 ? k_light_height : k_light_width; }

void resample_camera_rows(const CameraImage& image, uint32_t first, uint32_t count, uint8_t* rgb) {
  const bool quarter = image.turn_deg % 180 != 0, yuv = is_yuv(image.format);
  const uint32_t across = quarter ? k_light_height : k_light_width, down = quarter ? k_light_width : k_light_height;
  // Upright x is the stored x, -y, -x, y for turns of 0, 90, 180, 270 degrees clockwise; upright y is y, x, -y, -x.
  const bool x_backwards = image.turn_deg == 180 || image.turn_deg == 270;
  const bool y_backwards = image.turn_deg == 90 || image.turn_deg == 180;
  const Axis x_axis = axis_of(image.focal_x, image.centre_x, across, x_backwards, false);
  const Axis y_axis = axis_of(image.focal_y, image.centre_y, down, y_backwards, false);
  const Axis x_half = axis_of(image.focal_x, image.centre_x, across, x_backwards, true);
  const Axis y_half = axis_of(image.focal_y, image.centre_y, down, y_backwards, true);
  const uint32_t pixel = image.format == CameraFormat::rgba ? 4 : 3;
  Plane planes[3];
  if (yuv) {
    const bool planar = image.format == CameraFormat::i420;
    const uint32_t half_width = image.width / 2, half_height = image.height / 2;
    const uint8_t* pairs = image.planes[1];
    const uint32_t u_first = image.format == CameraFormat::nv21 ? 1 : 0;
    planes[0] = {image.planes[0], image.strides[0], 1, image.width, image.height};
    planes[1] = planar ? Plane{image.planes[1], image.strides[1], 1, half_width, half_height}
                       : Plane{pairs + u_first, image.strides[1], 2, half_width, half_height};
    planes[2] = planar ? Plane{image.planes[2], image.strides[2], 1, half_width, half_height}
                       : Plane{pairs + 1 - u_first, image.strides[1], 2, half_width, half_height};
  } else {
    for (uint32_t c = 0; c < 3; ++c)
      planes[c] = {image.planes[0] + c, image.strides[0], pixel, image.width, image.height};
  }
  for (uint32_t b = first; b < first + count; ++b) {
    const Box rows = oriented_box(y_axis, b, down, image.height);
    const Box chroma_rows = yuv ? oriented_box(y_half, b, down, image.height / 2) : rows;
    for (uint32_t a = 0; a < across; ++a) {
      const Box columns = oriented_box(x_axis, a, across, image.width);
      const Box chroma_columns = yuv ? oriented_box(x_half, a, across, image.width / 2) : columns;
      uint8_t value[3];
      value[0] = box_mean(planes[0], columns, rows);
      value[1] = box_mean(planes[1], chroma_columns, chroma_rows);
      value[2] = box_mean(planes[2], chroma_columns, chroma_rows);
      const uint32_t x = quarter ? b : a, y = quarter ? a : b;
      uint8_t* out = rgb + 3 * (y * k_light_width + x);
      if (yuv) yuv_to_rgb(image.range, value[0], value[1], value[2], out);
      else out[0] = value[0], out[1] = value[1], out[2] = value[2];
    }
  }
}

}  // namespace sandglass
