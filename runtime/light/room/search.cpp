// Bright spots of an image that are smaller than what lies between the points of a part: bulbs, spotlights, the sun.
//
// A grid of pixels that lies half a degree apart is read for white ones, at another place of it in each image. One that
// is not white two degrees around it is a spot. Its part is then looked at closely (image.cpp), where that does not hold
// a lamp already.
#include "kernels/whole.h"
#include "runtime/light/luminance.h"
#include "runtime/light/room/room.h"
#include "runtime/math/math.h"

namespace sandglass {

namespace {

constexpr double k_apart = 0.01, k_around = 0.035;  // radians, in the middle of the picture
constexpr double k_elsewhere = 32;                  // 127ths of half a part: 1.4 degrees, what a close look covers
constexpr uint32_t k_lines_max = 192;               // of the grid, each way: of an image of many pixels a degree or few
constexpr uint32_t k_bands = k_room_parts / k_room_unit_parts;  // that the image is searched in
constexpr uint32_t k_tries = 8;                                 // white pixels of a band that are looked at

// The first channel of a pixel, or green, from which on one of its channels is clipped: it is no brighter than these.
uint8_t white_from(const CameraImage& image) {
  constexpr int32_t k_white = 250;
  if (!is_yuv(image.format)) return k_white;
  const YuvMatrix& m = k_yuv_matrices[image.range];
  return static_cast<uint8_t>(m.luma_offset + (k_white * 65536 - 32768 + m.luma - 1) / m.luma);
}

void keep_spot(Room* room, uint32_t x, uint32_t y) {
  RoomView* view = &room->view;
  const double right = (x - static_cast<double>(view->image.centre_x)) / static_cast<double>(view->image.focal_x),
               down = (y - static_cast<double>(view->image.centre_y)) / static_cast<double>(view->image.focal_y);
  double ahead[3], at[3], row, column;
  for (int k = 0; k < 3; ++k)
    ahead[k] = right * view->to_camera[0][k] + down * view->to_camera[1][k] + view->to_camera[2][k];
  const double length = square_root(square_of(ahead));
  for (double& a : ahead) a /= length;
  (void)room_meet(*view, ahead, at);
  const uint32_t index = room_part_at(at, &row, &column);
  RoomPart* part = &room->parts[index];
  if (index < k_room_below) return;
  const int8_t up = room_towards(0, 2 * room_fraction(row) - 1, 1),
               aside = room_towards(0, 2 * room_fraction(column) - 1, 1);
  if (part->clipped > 0 || luminance(part->radiance) * room->light > room->scale) {
    // It was taken to lie elsewhere, by an image that cut its part: a close look there would miss it.
    const double shrinks = square_root(1 - at[1] * at[1]);  // a part's width, towards the zenith
    if (absolute(up - part->up) < k_elsewhere && shrinks * absolute(aside - part->aside) < k_elsewhere) return;
    part->up = up;
    part->aside = aside;
    return;
  }
  if (room_spot(*view, index) == nullptr) view->spots[view->spot_count++] = {static_cast<uint16_t>(index), up, aside};
}

// Lines of the grid along one side of an image.
struct Lines {
  uint32_t first, step, count, around;
};
Lines lines_of(uint32_t size, float focal, double start) {
  const auto pixels = [focal](double angle) { return to_whole<uint32_t>(angle * static_cast<double>(focal)); };
  Lines lines = {0, pixels(k_apart), 0, pixels(k_around) + 1};
  const uint32_t least = size / k_lines_max + 1;
  if (lines.step < least) lines.step = least;
  if (size > 2 * lines.around && lines.step > 0) lines.count = (size - 2 * lines.around) / lines.step;
  lines.first = lines.around + to_whole<uint32_t>(start * lines.step);
  return lines;
}

}  // namespace

const RoomSpot* room_spot(const RoomView& view, uint32_t part) {
  for (uint32_t i = 0; i < view.spot_count; ++i)
    if (view.spots[i].part == part) return &view.spots[i];
  return nullptr;
}

void room_search(Room* room, uint32_t unit) {
  RoomView* view = &room->view;
  const CameraImage& image = view->image;
  if (room_is_short(*room)) return;  // all of its lamps are looked at closely
  double start_row, start_column;
  room_step(room->images, &start_row, &start_column);
  const Lines rows = lines_of(image.height, image.focal_y, start_row),
              columns = lines_of(image.width, image.focal_x, start_column);
  const CameraLayout layout = camera_layout(image);
  const uint32_t channel = is_yuv(image.format) ? 0 : 1, step = layout.step[channel];
  const uint8_t white = white_from(image);
  const int64_t stride = image.strides[0], aside = int64_t{columns.around} * step, below = rows.around * stride;
  // Where there are more spots than are kept, they take turns.
  const uint32_t band = (unit + room->images) % k_bands;
  uint32_t tries = 0;
  for (uint32_t i = rows.count * band / k_bands; i < rows.count * (band + 1) / k_bands; ++i) {
    const uint32_t y = rows.first + i * rows.step;
    const uint8_t* at = image.planes[0] + y * stride + int64_t{columns.first} * step + layout.offset[channel];
    for (uint32_t k = 0; k < columns.count; ++k, at += columns.step * step) {
      if (*at < white) continue;
      if (at[aside] >= white || at[-aside] >= white || at[below] >= white || at[-below] >= white) continue;
      if (view->spot_count == k_room_spots || tries == k_tries) return;
      ++tries;
      keep_spot(room, columns.first + k * columns.step, y);
    }
  }
}

}  // namespace sandglass
