#include "runtime/light/network/resample.h"

#include "kernels/whole.h"
#include "runtime/math/math.h"

namespace sandglass {

namespace {

constexpr int32_t k_fixed_one = 256;  // a pixel, in the fixed point of boxes
constexpr uint32_t k_block_rows_max = 16;
constexpr uint32_t k_camera_box_columns =
    k_camera_sums / 4;  // pixels of a box that are read, at most; of up to four bytes

// The interval of the input that an output pixel covers along one axis, in 1/256 pixel from the image's edge. It is
// never empty.
struct Box {
  int32_t low, high;
};

Box box_of(uint32_t index, double first, double step, uint32_t size) {
  // Beyond this the answer is an edge pixel, and the conversion to integers is safe.
  const double limit = 2.0 * SANDGLASS_CAMERA_SIDE_LIMIT;
  const double width = step < 1.0 ? 1.0 : step;
  double middle = first + step * index + 0.5;  // 0 is the image's edge
  middle = middle < -limit ? -limit : middle > limit ? limit : middle;
  const double half = width < limit ? 0.5 * width : 0.5 * limit;
  const int32_t end = static_cast<int32_t>(size) * k_fixed_one;
  auto low = static_cast<int32_t>(floor_index((middle - half) * k_fixed_one + 0.5));
  auto high = static_cast<int32_t>(floor_index((middle + half) * k_fixed_one + 0.5));
  if (high <= 0) return {0, k_fixed_one};
  if (low >= end) return {end - k_fixed_one, end};
  low = low < 0 ? 0 : low;
  high = high > end ? end : high;
  return high > low ? Box{low, high} : Box{low, low + 1};
}

// Where the output's pixels lie along a stored axis: pixel i of `count` at first + step * i.
struct Axis {
  double first, step;
};

// `focal` and `centre` are the input's along this axis. `backwards`: the output's axis runs against it. Chroma of half
// the resolution has its samples between pairs of luma: (x - 1/2) / 2.
Axis axis_of(float focal, float centre, uint32_t count, bool backwards, bool half) {
  double step = static_cast<double>(focal) / k_light_focal;
  double first = static_cast<double>(centre) - step * 0.5 * (count - 1);
  if (half) {
    step *= 0.5;
    first = (first - 0.5) * 0.5;
  }
  if (backwards) {
    first += step * (count - 1);
    step = -step;
  }
  return {first, step};
}

Box oriented_box(const Axis& axis, uint32_t index, uint32_t count, uint32_t size) {
  // A box has no direction: count from the other end.
  return axis.step >= 0.0 ? box_of(index, axis.first, axis.step, size)
                          : box_of(count - 1 - index, axis.first + axis.step * (count - 1), -axis.step, size);
}

// A plane of bytes in which a pixel has one to four channels.
struct Plane {
  const uint8_t* bytes;
  int64_t stride;  // bytes between rows
  uint32_t step;   // bytes between pixels
  uint32_t width, height;
  uint32_t channels, first;  // how many of the picture's three channels it holds, and which is the first
  uint32_t offset[3];        // bytes from the start of a pixel to each channel
  uint32_t bytes_of_pixel;   // up to the last channel
};

// The part of pixel i that lies in the box, in 1/256.
uint32_t part(const Box& box, int32_t i) {
  const int32_t from = i * k_fixed_one > box.low ? i * k_fixed_one : box.low;
  const int32_t to = (i + 1) * k_fixed_one < box.high ? (i + 1) * k_fixed_one : box.high;
  return static_cast<uint32_t>(to - from);
}

int32_t first_of(const Box& box) { return box.low / k_fixed_one; }
int32_t last_of(const Box& box) { return (box.high - 1) / k_fixed_one; }

// The middle of a box, at most `limit` pixels of it.
Box middle_of(const Box& box, int32_t limit) {
  if (last_of(box) - first_of(box) < limit) return box;
  const int32_t first = (first_of(box) + last_of(box) + 1 - limit) / 2;
  return {first * k_fixed_one, (first + limit) * k_fixed_one};
}

// sums[i] is the weighted sum of the box's rows at byte `from` + i.
void sum_rows(const Plane& plane, const Box& rows, uint32_t from, uint32_t count, uint32_t* sums) {
  for (int32_t y = first_of(rows); y <= last_of(rows); ++y) {
    const uint8_t* row = plane.bytes + y * plane.stride + from;
    const uint32_t weight = part(rows, y);
    if (y == first_of(rows))
      for (uint32_t i = 0; i < count; ++i) sums[i] = weight * row[i];
    else
      for (uint32_t i = 0; i < count; ++i) sums[i] += weight * row[i];
  }
}

// The mean of one channel over a box, rounded; `sums` begins at pixel `from`.
uint8_t box_mean(const uint32_t* sums, uint32_t step, int32_t from, const Box& across, const Box& down) {
  const int32_t x0 = first_of(across), x1 = last_of(across);
  const uint32_t* at = sums + static_cast<uint64_t>(x0 - from) * step;
  uint64_t sum = static_cast<uint64_t>(part(across, x0)) * *at, inner = 0;
  for (int32_t x = x0 + 1; x < x1; ++x) inner += *(at += step);
  sum += inner * k_fixed_one;
  if (x1 > x0) sum += static_cast<uint64_t>(part(across, x1)) * at[step];
  const uint64_t area = static_cast<uint64_t>(across.high - across.low) * static_cast<uint64_t>(down.high - down.low);
  return static_cast<uint8_t>((sum + area / 2) / area);
}

// One output row of a plane's channels. At a time, as many boxes as the sums of their bytes fit the scratch.
void resample_row(const Plane& plane, const Box* columns, uint32_t count, const Box& rows, uint8_t* values[3],
                  uint32_t* sums) {
  const auto pixels = static_cast<int32_t>(k_camera_sums / plane.step);
  for (uint32_t begin = 0; begin < count;) {
    int32_t low = first_of(columns[begin]), high = last_of(columns[begin]);
    uint32_t end = begin + 1;
    for (; end < count; ++end) {
      const int32_t l = first_of(columns[end]) < low ? first_of(columns[end]) : low;
      const int32_t h = last_of(columns[end]) > high ? last_of(columns[end]) : high;
      if (h - l >= pixels) break;
      low = l;
      high = h;
    }
    // The bytes of the last pixel end with its last channel: a plane may end there, too.
    sum_rows(plane, rows, static_cast<uint32_t>(low) * plane.step,
             static_cast<uint32_t>(high - low) * plane.step + plane.bytes_of_pixel, sums);
    for (uint32_t c = 0; c < plane.channels; ++c)
      for (uint32_t a = begin; a < end; ++a)
        values[plane.first + c][a] = box_mean(sums + plane.offset[c], plane.step, low, columns[a], rows);
    begin = end;
  }
}

}  // namespace

CameraBlock whole_camera_block(const CameraImage& image) {
  const bool quarter = image.turn_deg % 180 != 0;
  return {0, quarter ? k_light_width : k_light_height, 0, quarter ? k_light_height : k_light_width};
}

namespace {

// About how many pixels of the input a box reads along an axis.
uint64_t box_pixels(float focal, uint32_t limit) {
  const auto step = to_whole<uint64_t>(static_cast<double>(focal) / k_light_focal);
  return (step < 1 ? 1 : step > limit ? limit : step) + 1;
}

}  // namespace

CameraBlocks camera_blocks(const CameraImage& image) {
  const CameraBlock whole = whole_camera_block(image);
  const CameraLayout layout = camera_layout(image);
  const uint64_t pixel = layout.planes == 1 ? layout.step[0] : 2 * layout.step[0];
  const uint64_t column = pixel * box_pixels(image.focal_y, k_camera_box_rows), row = column * image.width;
  CameraBlocks blocks;
  if (row <= k_camera_block_bytes) {
    const uint64_t rows = k_camera_block_bytes / row;
    blocks.rows = static_cast<uint32_t>(rows > k_block_rows_max ? k_block_rows_max : rows);
    blocks.columns = whole.columns;
    blocks.bytes = blocks.rows * row;
  } else {
    const uint64_t box = column * (box_pixels(image.focal_x, k_camera_box_columns) + 1);
    const uint64_t columns = k_camera_block_bytes / box;  // at least 3: 4 bytes x 17 rows x 1026 columns
    blocks.rows = 1;
    blocks.columns = columns > whole.columns ? whole.columns : static_cast<uint32_t>(columns);
    blocks.bytes = blocks.columns * box;
  }
  blocks.across = (whole.columns + blocks.columns - 1) / blocks.columns;
  blocks.count = blocks.across * ((whole.rows + blocks.rows - 1) / blocks.rows);
  return blocks;
}

CameraBlock camera_block(const CameraImage& image, const CameraBlocks& blocks, uint32_t index) {
  const CameraBlock whole = whole_camera_block(image);
  const uint32_t row = index / blocks.across * blocks.rows, column = index % blocks.across * blocks.columns;
  const uint32_t rows = whole.rows - row, columns = whole.columns - column;
  return {row, rows < blocks.rows ? rows : blocks.rows, column, columns < blocks.columns ? columns : blocks.columns};
}

namespace {

uint32_t planes_of(const CameraImage& image, Plane planes[3]) {
  const CameraLayout layout = camera_layout(image);
  for (uint32_t i = 0; i < layout.planes; ++i) {
    const uint32_t half = i != 0 ? 1 : 0;
    planes[i] = {image.planes[i], image.strides[i], 0, image.width >> half, image.height >> half, 0, 0, {}, 0};
  }
  for (uint32_t c = 3; c-- > 0;) {
    Plane* plane = &planes[layout.plane[c]];
    plane->step = layout.step[c];
    plane->first = c;
    ++plane->channels;
  }
  for (uint32_t c = 0; c < 3; ++c) {
    Plane* plane = &planes[layout.plane[c]];
    plane->offset[c - plane->first] = layout.offset[c];
    if (plane->bytes_of_pixel <= layout.offset[c]) plane->bytes_of_pixel = layout.offset[c] + 1;
  }
  return layout.planes;
}

}  // namespace

void resample_camera_block(const CameraImage& image, const CameraBlock& block, uint8_t* rgb, uint32_t* sums) {
  const bool quarter = image.turn_deg % 180 != 0, yuv = is_yuv(image.format);
  const CameraBlock whole = whole_camera_block(image);
  const uint32_t across = whole.columns, down = whole.rows;
  // Upright x is the stored x, -y, -x, y for turns of 0, 90, 180, 270 degrees clockwise; upright y is y, x, -y, -x.
  const bool x_backwards = (image.turn_deg == 180 || image.turn_deg == 270) != (image.mirrored != 0);
  const bool y_backwards = image.turn_deg == 90 || image.turn_deg == 180;
  Plane planes[3];
  const uint32_t plane_count = planes_of(image, planes);
  Box columns[2][k_light_width];  // of planes of full and of half size
  for (uint32_t half = 0; half < (yuv ? 2u : 1u); ++half) {
    const Axis axis = axis_of(image.focal_x, image.centre_x, across, x_backwards, half != 0);
    for (uint32_t a = 0; a < block.columns; ++a)
      columns[half][a] =
          middle_of(oriented_box(axis, block.first_column + a, across, half != 0 ? image.width / 2 : image.width),
                    static_cast<int32_t>(k_camera_box_columns));
  }
  uint8_t bytes[3][k_light_width];
  uint8_t* values[3] = {bytes[0], bytes[1], bytes[2]};
  for (uint32_t b = block.first_row; b < block.first_row + block.rows; ++b) {
    for (uint32_t i = 0; i < plane_count; ++i) {
      const bool half = yuv && i > 0;
      const Axis axis = axis_of(image.focal_y, image.centre_y, down, y_backwards, half);
      const Box rows =
          middle_of(oriented_box(axis, b, down, planes[i].height), static_cast<int32_t>(k_camera_box_rows));
      resample_row(planes[i], columns[half ? 1 : 0], block.columns, rows, values, sums);
    }
    for (uint32_t a = 0; a < block.columns; ++a) {
      const uint32_t column = block.first_column + a, x = quarter ? b : column, y = quarter ? column : b;
      uint8_t* out = rgb + 3 * (y * k_light_width + x);
      if (yuv) yuv_to_rgb(image.range, bytes[0][a], bytes[1][a], bytes[2][a], out);
      else
        for (uint32_t c = 0; c < 3; ++c) out[c] = bytes[c][a];
    }
  }
}

}  // namespace sandglass
