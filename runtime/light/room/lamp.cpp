// How large the main light is, from images that show it unclipped, or clipped amid what is all but black: a shadow's
// softness follows from that.
//
// When an image was learned, the brightest part in the picture is looked at closely: 16 x 16 rays over a square, which
// is made half as wide again as the lamp, by and by. With L what a ray shows more than the square's rim does, the solid
// angle of an even lamp is (sum L)^2 / (sum L^2), and that of another one is that of an even one with about the same
// penumbra. The size is kept as a length on the sphere, so that a lamp is smaller from farther away.
#include "kernels/whole.h"
#include "runtime/light/camera/transfer.h"
#include "runtime/light/luminance.h"
#include "runtime/light/room/room.h"
#include "runtime/math/math.h"

namespace sandglass {

namespace {

constexpr uint32_t k_rays = 16;                    // along each side of the square
constexpr double k_first = 0.1963495408493621;     // radians, the square at first: a part, 11.25 degrees
constexpr double k_square = 1.5;                   // times the lamp: the square in the end
constexpr double k_fits = 0.2;                     // share by which it may differ from that
constexpr double k_widest = 0.8;                   // the square at most: of a lamp of 28 degrees
constexpr double k_sampled = 0.03;                 // share by which a size is off because rays are few
constexpr double k_spread = 0.2;                   // the same of a clipped one, whose glow may be clipped, too
constexpr double k_angle_max = 1.5;                // radians that a cast takes
constexpr uint32_t k_looks = 5;                    // until the square fits
constexpr uint8_t k_white = 250;                   // sRGB: a channel from here on may be clipped
constexpr double k_dark = 0.02;                    // of white: a lamp that shows less has too few steps of a byte
constexpr double k_black = 0.02;                   // of white, what lies about a lamp that is clipped
constexpr double k_stands_out = 2.0;               // times the rim's mean: else the square lies in the lamp
constexpr double k_same_lamp = 0.984807753012208;  // cosine of 10 degrees
constexpr uint8_t k_images_max = 8;                // the mean is over so many images
constexpr float k_fades = 0.95f;                   // of a lamp's strength with each that is measured

// What the rays of a square show.
struct Look {
  double middle[3];                   // the lamp's, in the sphere's frame
  double solid_angle;                 // of the lamp; 0: the square lies within it
  double light;                       // its radiance times solid angle, 1 is white
  bool whole, clipped, dark, hidden;  // hidden: it is clipped, and what is beside it may be, too
};

Look look_at(const RoomView& view, const double ahead[3], double side) {
  Look look = {{}, 0, 0, true, false, true, false};
  const CameraLayout layout = camera_layout(view.image);
  // Two axes across.
  const uint32_t axis = absolute(ahead[0]) < absolute(ahead[1]) ? 0 : 1;
  double right[3], up[3];
  for (uint32_t k = 0; k < 3; ++k) right[k] = (k == axis ? 1 : 0) - ahead[axis] * ahead[k];
  const double squared = square_of(right);
  for (double& x : right) x /= square_root(squared);
  for (uint32_t k = 0; k < 3; ++k)
    up[k] = ahead[(k + 1) % 3] * right[(k + 2) % 3] - ahead[(k + 2) % 3] * right[(k + 1) % 3];
  double shown[k_rays * k_rays], rim = 0, rays_of_rim = 0;
  const auto place = [&](uint32_t i) { return side * ((i + 0.5) / k_rays - 0.5); };
  const auto is_rim = [](uint32_t i, uint32_t j) { return i == 0 || j == 0 || i + 1 == k_rays || j + 1 == k_rays; };
  for (uint32_t i = 0; i < k_rays * k_rays; ++i) {
    const uint32_t row = i / k_rays, column = i % k_rays;
    double at[3];
    for (int k = 0; k < 3; ++k) at[k] = view.position[k] + ahead[k] + place(row) * up[k] + place(column) * right[k];
    uint32_t x, y;
    shown[i] = -1;
    if (!room_pixel_of(view, at, &x, &y)) {
      look.whole = false;
      continue;
    }
    uint8_t rgb[3];
    camera_pixel(view.image, layout, x, y, rgb);
    look.clipped = look.clipped || rgb[0] >= k_white || rgb[1] >= k_white || rgb[2] >= k_white;
    double linear[3];
    for (int c = 0; c < 3; ++c) linear[c] = static_cast<double>(camera_light(view.image, view.light, rgb[c]));
    shown[i] = luminance(linear);
    look.dark = look.dark && shown[i] < k_dark;
    if (is_rim(row, column)) {
      rim += shown[i];
      ++rays_of_rim;
    }
  }
  if (rays_of_rim > 0) rim /= rays_of_rim;
  double sum = 0, squares = 0, from[2] = {}, brightest = 0;
  for (uint32_t i = 0; i < k_rays * k_rays; ++i) {
    if (!(shown[i] > rim)) continue;
    const double u = place(i % k_rays), v = place(i / k_rays), light = shown[i] - rim;
    const double length = square_root(1 + u * u + v * v),
                 area = side * side / (k_rays * k_rays * length * length * length);
    sum += area * light;
    squares += area * light * light;
    from[0] += area * light * u;
    from[1] += area * light * v;
    brightest = shown[i] > brightest ? shown[i] : brightest;
  }
  for (int k = 0; k < 3; ++k) look.middle[k] = ahead[k] + (sum > 0 ? (from[0] * right[k] + from[1] * up[k]) / sum : 0);
  const double length = square_root(square_of(look.middle));
  for (double& x : look.middle) x /= length;
  look.hidden = look.clipped && !(rim < k_black);
  if (brightest > k_stands_out * rim) {
    look.solid_angle = sum * sum / squares;
    look.light = sum;
  }
  return look;
}

// The angle across a round lamp.
double diameter_of(double solid_angle) {
  const double s = square_root(solid_angle / (4 * k_pi)), rest = 1 - s * s;
  return 4 * arc_tangent2(s, square_root(rest > 0 ? rest : 0));
}

// The direction from the camera of the brightest part in the picture, if that is brighter than white.
bool brightest_in_picture(const Room& room, double ahead[3]) {
  const RoomView& view = room.view;
  double brightest = room.scale / room.light;
  bool any = false;
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    if (room.parts[i].age > 0) continue;  // another image's
    const double bright = luminance(room.parts[i].radiance);
    if (!(bright > brightest)) continue;
    double direction[3];
    const uint32_t row = i / k_room_columns, column = i % k_room_columns;
    room_direction(row + 0.5 + room.parts[i].up / 254.0, column + 0.5 + room.parts[i].aside / 254.0, direction);
    uint32_t x, y;
    if (!room_pixel_of(view, direction, &x, &y)) continue;
    for (int k = 0; k < 3; ++k) ahead[k] = direction[k] - view.position[k];
    const double squared = square_of(ahead);
    for (int k = 0; k < 3; ++k) ahead[k] /= square_root(squared);
    brightest = bright;
    any = true;
  }
  return any;
}

// Into what is known of that lamp, or in place of the weakest one.
void keep(Room* room, const double at[3], double across, double error, float strength, bool clipped) {
  RoomLamp *same = nullptr, *weakest = &room->lamps[0];
  for (RoomLamp& lamp : room->lamps) {
    lamp.strength *= k_fades;
    const double cosine = (at[0] * lamp.at[0] + at[1] * lamp.at[1] + at[2] * lamp.at[2]) / k_lamp_unit;
    if (lamp.images > 0 && cosine > k_same_lamp) same = &lamp;
    if (lamp.strength < weakest->strength) weakest = &lamp;
  }
  if (same == nullptr && strength < weakest->strength) return;
  RoomLamp* lamp = same != nullptr ? same : weakest;
  // What is clipped may be larger than the lamp, and says nothing beside what is not.
  if (same != nullptr && clipped && lamp->clipped == 0) return;
  if (same == nullptr || (!clipped && lamp->clipped != 0)) *lamp = {};
  lamp->clipped = clipped ? 1 : 0;
  if (lamp->images < k_images_max) ++lamp->images;
  const float share = 1.0f / lamp->images, differs = static_cast<float>(across) - lamp->across;
  const float off = static_cast<float>(error) + (lamp->images > 1 ? (differs < 0 ? -differs : differs) : 0);
  for (int k = 0; k < 3; ++k) {
    const double place = lamp->at[k] + static_cast<double>(share) * (k_lamp_unit * at[k] - lamp->at[k]);
    lamp->at[k] = static_cast<int16_t>(floor_index(place + 0.5));
  }
  lamp->across += share * differs;
  lamp->error += share * (off - lamp->error);
  lamp->strength = strength;
}

// The lamp that is seen from there in that direction, if its size was measured; or NULL.
const RoomLamp* lamp_towards(const Room& room, const double from[3], const double direction[3], double* distance) {
  const RoomLamp* found = nullptr;
  double nearest = k_same_lamp;
  for (const RoomLamp& lamp : room.lamps) {
    double squared = 0, along = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = lamp.at[k] / k_lamp_unit - from[k];
      squared += d * d;
      along += d * direction[k];
    }
    const double away = square_root(squared);
    if (!(lamp.images > 0) || !(along > nearest * away)) continue;
    nearest = along / away;
    *distance = away;
    found = &lamp;
  }
  return found;
}

}  // namespace

void room_measure_lamp(Room* room) {
  const RoomView& view = room->view;
  double ahead[3], side = k_first, across = 0, away;
  const bool is_short = room_is_short(*room);
  if (is_short && room->wants_size && room->size_looks < 255) ++room->size_looks;
  room->wants_size = false;
  if (!brightest_in_picture(*room, ahead)) return;
  Look look = {};
  for (uint32_t i = 0;; ++i) {
    look = look_at(view, ahead, side);
    room->wants_size =
        look.whole && look.hidden && !is_short && lamp_towards(*room, view.position, ahead, &away) == nullptr;
    if (i == k_looks || !look.whole || look.hidden || look.dark) return;
    const double last = side;
    across = diameter_of(look.solid_angle);
    if (look.solid_angle > 0) {
      __builtin_memcpy(ahead, look.middle, sizeof ahead);
      side = k_square * across;
    } else {
      side = 2 * side;
    }
    if (side > k_widest) return;
    if (look.solid_angle > 0 && absolute(side - last) < k_fits * last) break;
  }
  double at[3];
  const double far = room_meet(view, ahead, at);
  const double error = 0.5 / static_cast<double>(view.image.focal_x) + (look.clipped ? k_spread : k_sampled) * across;
  keep(room, at, far * across, far * error, static_cast<float>(look.light * view.scale / room->light), look.clipped);
}

void room_main_size(const Room& room, const double at[3], sandglass_room_light* light) {
  if (!(light->main_share > 0)) return;
  const double world[3] = {static_cast<double>(light->main_direction[0]), static_cast<double>(light->main_direction[1]),
                           static_cast<double>(light->main_direction[2])};
  double towards[3], distance = 1;
  room_to_sphere(room, world, towards);
  const RoomLamp* lamp = lamp_towards(room, at, towards, &distance);
  if (lamp == nullptr) return;
  const auto seen = [distance](float across) {
    const double angle = static_cast<double>(across) / distance;
    return static_cast<float>(angle < k_angle_max ? angle : k_angle_max);
  };
  light->main_angular_diameter = seen(lamp->across);
  light->main_angular_error = seen(lamp->error);
}

}  // namespace sandglass
