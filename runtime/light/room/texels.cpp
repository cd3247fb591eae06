// What reflections need: what the camera saw in the texels of a cube around the sphere, in its frame, and the cube that is
// seen from a place.
//
// A texel learns from an image as a part does, before the parts do. It is seen at 2 x 2 points, whose places in it
// change from image to image. What no image has shown is the parts' expected light (estimate.cpp). A direction below the
// horizon meets what the object stands on, which is looked up where the camera saw that.
#include "kernels/whole.h"
#include "runtime/light/camera/transfer.h"
#include "runtime/light/cube_map.h"
#include "runtime/light/luminance.h"
#include "runtime/light/room/room.h"
#include "runtime/math/half.h"
#include "runtime/math/math.h"

namespace sandglass {

namespace {

constexpr uint32_t k_points = 2;     // along each side of a texel
constexpr float k_image = 16.0f;     // the weight of an image
constexpr float k_weight_max = 15;   // what is known counts as no more images than these
constexpr uint8_t k_white = 250;     // sRGB: a channel from here on may be clipped
constexpr double k_known = 1.0;      // the weight from which on a texel counts as seen
constexpr double k_ray_min = 1e-12;  // a squared length, in radii

double at_texel(double texel) { return texel * (2.0 / k_cube_size) - 1; }

RoomObservation observe(const RoomView& view, const CameraLayout& layout, const CubePoint& corner, double down,
                        double across) {
  RoomObservation seen = {};
  for (uint32_t i = 0; i < k_points * k_points; ++i) {
    const uint32_t column = i % k_points, row = i / k_points;
    const double s = corner.s + (column + across) * (2.0 / k_points / k_cube_size);
    const double t = corner.t + (row + down) * (2.0 / k_points / k_cube_size);
    double direction[3];
    cube_direction({corner.face, s, t}, direction);
    uint32_t x, y;
    if (!room_pixel_of(view, direction, &x, &y)) continue;
    uint8_t rgb[3];
    camera_pixel(view.image, layout, x, y, rgb);
    for (int c = 0; c < 3; ++c) seen.colour[c] += static_cast<double>(camera_light(view.image, view.light, rgb[c]));
    seen.clipped += rgb[0] >= k_white || rgb[1] >= k_white || rgb[2] >= k_white ? 1 : 0;
    seen.covered += 1;
  }
  if (!(seen.covered > 0)) return seen;
  for (int c = 0; c < 3; ++c) seen.colour[c] /= seen.covered * static_cast<double>(view.balance[c]);
  seen.clipped /= seen.covered;
  seen.covered /= k_points * k_points;
  seen.brightest = luminance(seen.colour);
  return seen;
}

void learn(const Room& room, const RoomObservation& now, RoomTexel* texel) {
  const auto covered = static_cast<float>(now.covered), clipped = static_cast<float>(now.clipped);
  const auto memory = static_cast<float>(room_memory(texel->age));
  float weight = texel->weight / k_image * memory;
  weight = weight < k_weight_max ? weight : k_weight_max;
  const RoomKnown before = {luminance(texel->radiance), texel->clipped / 255.0f, weight, 0, 0, false};
  if (room.view.lesson == RoomLesson::unknown && before.weight > 0) return;
  if (!(now.covered > 0) || room_tells_nothing(room, before, now)) return;
  const float rate = room_rate(room, before, now);
  texel->age = 0;
  texel->weight = to_whole<uint8_t>(static_cast<double>((weight + covered) * k_image + 0.5f));
  for (int c = 0; c < 3; ++c) {
    const double radiance = now.colour[c] * room.view.scale / room.light;
    texel->radiance[c] += rate * (room_bounded_radiance(radiance) - texel->radiance[c]);
  }
  const float share = before.clipped + rate * (clipped - before.clipped);
  texel->clipped = to_whole<uint8_t>(static_cast<double>(share * 255 + 0.5f));
}

// The radiance that is expected in a direction of the sphere, between the middles of parts.
void smooth_parts(const float parts[k_room_parts][3], const double direction[3], double colour[3]) {
  const double flat = square_root(direction[0] * direction[0] + direction[2] * direction[2]);
  const double row = (arc_tangent2(direction[1], flat) / k_pi + 0.5) * k_room_rows - 0.5;
  const double column = arc_tangent2(direction[2], direction[0]) / (2 * k_pi) * k_room_columns - 0.5;
  const int64_t low = floor_index(row), left = floor_index(column);
  for (int c = 0; c < 3; ++c) colour[c] = 0;
  for (int i = 0; i < 4; ++i) {
    const int64_t r = low + i / 2, bounded = r < 0 ? 0 : r < k_room_rows ? r : k_room_rows - 1;
    const int64_t around = (left + i % 2 + 2 * k_room_columns) % k_room_columns;
    const double up = row - static_cast<double>(low), aside = column - static_cast<double>(left);
    const double weight = (i / 2 == 0 ? 1 - up : up) * (i % 2 == 0 ? 1 - aside : aside);
    const float* part = parts[bounded * k_room_columns + around];
    for (int c = 0; c < 3; ++c) colour[c] += weight * static_cast<double>(part[c]);
  }
}

// What texels show of a direction, and the share of it that was seen.
double smooth_texels(const Room& room, const RoomModel& model, const double direction[3], double colour[3]) {
  const CubePoint at = cube_point(direction);
  const double x = (at.s + 1) * (0.5 * k_cube_size) - 0.5, y = (at.t + 1) * (0.5 * k_cube_size) - 0.5;
  const int64_t left = floor_index(x), top = floor_index(y);
  double seen = 0;
  for (int c = 0; c < 3; ++c) colour[c] = 0;
  for (int i = 0; i < 4; ++i) {
    const auto inside = [](int64_t k) { return k < 0 ? 0 : k < k_cube_size ? k : k_cube_size - 1; };
    const double right = x - static_cast<double>(left), down = y - static_cast<double>(top);
    const double weight = (i % 2 == 0 ? 1 - right : right) * (i / 2 == 0 ? 1 - down : down);
    const RoomTexel& texel =
        room.texels[(at.face * k_cube_size + inside(top + i / 2)) * k_cube_size + inside(left + i % 2)];
    const double share = texel.weight / static_cast<double>(k_image), known = share < k_known ? share / k_known : 1;
    const double weighs = weight * known * room_memory(texel.age);
    const double times = weighs * (1 + model.boost * texel.clipped / 255) * room.light / room.scale;
    for (int c = 0; c < 3; ++c) colour[c] += times * static_cast<double>(texel.radiance[c] * room.balance[c]);
    seen += weighs;
  }
  return seen;
}

// Where a ray from inside the sphere meets it. The direction has length 1. What was restored may say that a camera was
// outside: then somewhere.
void meet_sphere(const double from[3], const double direction[3], double d[3]) {
  double along = 0, inside = 1;
  for (int k = 0; k < 3; ++k) {
    along += from[k] * direction[k];
    inside -= from[k] * from[k];
  }
  const double far = square_root(along * along + (inside > 0 ? inside : 0)) - along;
  for (int k = 0; k < 3; ++k) d[k] = from[k] + far * direction[k];
}

// The direction of the sphere in which the camera that looked there last saw a place.
void seen_through(const Room& room, const double place[3], double d[3]) {
  double from[3] = {};
  for (int step = 0; step < 2; ++step) {
    double ray[3];
    for (int k = 0; k < 3; ++k) ray[k] = place[k] - from[k];
    const double squared = square_of(ray);
    if (!(squared > k_ray_min)) return;
    for (double& r : ray) r /= square_root(squared);
    meet_sphere(from, ray, d);
    double row, column;
    const uint32_t part = room_part_at(d, &row, &column);
    if (part >= k_room_below) return;
    for (int k = 0; k < 3; ++k) from[k] = room.parts[part].from[k] / 127.0;
  }
}

}  // namespace

void room_learn_texels(Room* room, uint32_t first) {
  const RoomView& view = room->view;
  const CameraLayout layout = camera_layout(view.image);
  for (uint32_t i = first; i < first + k_cube_unit_texels; ++i) {
    const CubePoint corner = {i / (k_cube_size * k_cube_size), at_texel(i % k_cube_size),
                              at_texel(i / k_cube_size % k_cube_size)};
    const CubePoint middle = {corner.face, corner.s + 1.0 / k_cube_size, corner.t + 1.0 / k_cube_size};
    double direction[3];
    cube_direction(middle, direction);
    if (!room_may_be_seen(view, direction)) continue;
    double down, across;
    room_step(room->images + i, &down, &across);
    learn(*room, observe(view, layout, corner, down, across), &room->texels[i]);
  }
}

void room_face(const Room& room, const RoomModel& model, const float position[3], float height, uint32_t face,
               bool left_handed, uint16_t* texels) {
  float parts[k_room_parts][3];
  room_radiance(room, model, parts);
  const double place[3] = {static_cast<double>(position[0]), static_cast<double>(position[1]),
                           static_cast<double>(position[2])};
  double at[3];
  room_place(room, place, at);
  for (uint32_t i = 0; i < k_cube_size * k_cube_size; ++i) {
    const uint32_t column = i % k_cube_size, row = i / k_cube_size;
    const CubePoint middle = {face, at_texel(column + 0.5), at_texel(row + 0.5)};
    double world[3], d[3], colour[3], expected[3];
    cube_direction(middle, world);
    if (left_handed) world[2] = -world[2];
    room_to_sphere(room, world, d);
    if (height > 0 && world[1] < 0) {
      // What it stands on lies nearer than the sphere.
      const double far = -static_cast<double>(height) / (world[1] * room.radius);
      double below[3];
      for (int k = 0; k < 3; ++k) below[k] = at[k] + far * d[k];
      if (square_of(below) < 1) seen_through(room, below, d);
      else meet_sphere(at, d, d);
    } else {
      meet_sphere(at, d, d);
    }
    const double seen = smooth_texels(room, model, d, colour);
    if (seen < 1) smooth_parts(parts, d, expected);
    for (int c = 0; c < 3; ++c)
      texels[4 * i + c] = half_of(seen < 1 ? colour[c] + (1 - seen) * expected[c] : colour[c]);
    texels[4 * i + 3] = half_of(seen);
  }
}

}  // namespace sandglass
