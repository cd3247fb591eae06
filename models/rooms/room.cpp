// Makes a room from its seed. First come kind and size, then the shell with its windows, the furniture, and the lights.
#include "models/rooms/room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "models/rooms/panorama.h"
#include "models/rooms/room_builder.h"

namespace sandglass::host {

namespace {

constexpr double k_sun_solid_angle = 2.0 * std::numbers::pi * (1.0 - k_sun_cosine);
constexpr double k_frame = 0.05;  // metres, the width of a window's bars

struct Opening {
  double start, width, sill, height;
};

// A wall as seen from inside. It starts at `origin` and runs along the unit vector `along`. `inward` points into the
// room.
struct Wall {
  Vec3 origin, along, inward;
  double length, height;
  std::vector<Opening> windows;  // ordered, not overlapping
};

void build_window(RoomBuilder* b, const Wall& wall, const Opening& o, double depth, int reveal, int frame,
                  bool blinds) {
  const Vec3 up = {0.0, 1.0, 0.0}, out = wall.inward * -depth;
  const Vec3 corner = wall.origin + wall.along * o.start + up * o.sill;
  const Vec3 across = wall.along * o.width, high = up * o.height;
  b->quad(corner, across, out, reveal);
  b->quad(corner + high, across, out, reveal);
  b->quad(corner, high, out, reveal);
  b->quad(corner + across, high, out, reveal);
  const int columns = 1 + static_cast<int>(o.width / b->between(0.7, 1.4)), rows = b->chance(0.4) ? 2 : 1;
  for (int i = 0; i <= columns; ++i)
    b->quad(corner + out + wall.along * (i * (o.width - k_frame) / columns), wall.along * k_frame, high, frame);
  for (int i = 0; i <= rows; ++i)
    b->quad(corner + out + up * (i * (o.height - k_frame) / rows), across, up * k_frame, frame);
  if (blinds) {
    const double pitch = 0.09, drop = b->between(0.3, 1.0) * o.height;
    const Vec3 slat = (wall.inward * 0.06) + up * b->between(-0.05, 0.05);
    for (double y = pitch; y < drop; y += pitch) b->quad(corner + high - up * y + out * 0.4, across, slat, frame);
  }
  Emitter window;
  window.kind = Emitter::Kind::window;
  window.corner = corner;
  const bool inwards = dot(cross(across, high), wall.inward) > 0.0;
  window.edge_a = inwards ? across : high;
  window.edge_b = inwards ? high : across;
  b->room.emitters.push_back(window);
}

void build_wall(RoomBuilder* b, const Wall& wall, int surface, int skirting, int frame, bool blinds) {
  const Vec3 up = {0.0, 1.0, 0.0};
  const double depth = b->between(0.1, 0.3);
  double from = 0.0;
  const auto piece = [&](double start, double width, double low, double high) {
    if (width > 0.0 && high > low)
      b->quad(wall.origin + wall.along * start + up * low, wall.along * width, up * (high - low), surface);
  };
  for (const Opening& o : wall.windows) {
    piece(from, o.start - from, 0.0, wall.height);
    piece(o.start, o.width, 0.0, o.sill);
    piece(o.start, o.width, o.sill + o.height, wall.height);
    build_window(b, wall, o, depth, surface, frame, blinds);
    from = o.start + o.width;
  }
  piece(from, wall.length - from, 0.0, wall.height);
  if (skirting >= 0)
    b->quad(wall.origin + wall.inward * 0.012, wall.along * wall.length, up * b->between(0.06, 0.14), skirting);
}

std::vector<Opening> choose_windows(RoomBuilder* b, double length, double height, bool large) {
  std::vector<Opening> windows;
  const double sill = large ? b->between(0.0, 0.3) : b->between(0.6, 1.1);
  const double tall = std::max(0.5, (large ? b->between(0.8, 0.95) : b->between(0.6, 0.85)) * height - sill);
  const double width = large ? b->between(1.5, 3.0) : b->between(0.7, 1.8), gap = b->between(0.3, 2.0);
  const int count = static_cast<int>((length - gap) / (width + gap));
  const double margin = 0.5 * (length - count * width - (count - 1) * gap);
  for (int i = 0; i < count; ++i)
    if (count == 1 || b->chance(0.85)) windows.push_back({margin + i * (width + gap), width, sill, tall});
  return windows;
}

Sky choose_sky(RoomBuilder* b, bool day) {
  Sky sky;
  sky.skyline_seed = b->random.next();
  if (!day) {
    const Vec3 glow = colour_of_temperature(b->between(2200.0, 6000.0));
    sky.zenith = glow * b->log_between(0.005, 0.1);
    sky.horizon = sky.zenith * 3.0;
    sky.ground = sky.zenith * 2.0;
    sky.skyline = glow * b->log_between(0.01, 0.5);
    return sky;
  }
  const bool clear = b->chance(0.5);
  const double bright = b->log_between(800.0, 9000.0);
  sky.zenith = colour_of_temperature(clear ? b->between(9000.0, 20000.0) : b->between(6000.0, 8000.0)) * bright;
  const double low_sky = bright * b->between(0.6, 1.6);
  sky.horizon = colour_of_temperature(b->between(5200.0, 7500.0)) * low_sky;
  sky.ground = b->colour({0.05, 0.4}, {0.1, 0.6}, 0.15) * bright;
  sky.skyline = b->colour({0.0, 1.0}, {0.0, 0.3}, b->between(0.1, 0.4)) * bright;
  if (clear && b->chance(0.7)) {
    const double elevation = b->between(0.12, 1.0), turn = b->between(0.0, 2.0 * std::numbers::pi);
    sky.sun_direction = direction_of_angles(0.5 * std::numbers::pi - elevation, turn);
    // Air reddens and dims a low sun.
    const double irradiance = bright * b->between(6.0, 14.0) * (1.0 - std::exp(-4.0 * elevation));
    sky.sun_radiance =
        colour_of_temperature(2600.0 + 3200.0 * (1.0 - std::exp(-3.0 * elevation))) * (irradiance / k_sun_solid_angle);
  }
  return sky;
}

void lay(RoomMaterial* m, Pattern pattern, double scale, double darker) {
  m->pattern = pattern;
  m->scale = scale;
  m->second = m->colour * darker;
}

RoomMaterial wall_material(RoomBuilder* b) {
  RoomMaterial m;
  const bool white = b->chance(0.55);
  const double bright = white ? b->between(0.5, 0.85) : b->between(0.1, 0.7);
  m.colour = b->colour({0.0, 1.0}, white ? Span{0.0, 0.12} : Span{0.1, 0.6}, bright);
  m.second = m.colour * b->between(0.6, 0.95);
  m.pattern = Pattern::blotches;
  m.scale = b->between(0.5, 3.0);
  if (b->chance(0.12)) lay(&m, Pattern::bricks, b->between(0.2, 0.3), 0.6);
  if (b->chance(0.08)) lay(&m, Pattern::planks, b->between(0.08, 0.2), 0.5);
  if (b->chance(0.08)) lay(&m, Pattern::stripes, b->between(0.1, 0.5), 0.75);
  if (b->chance(0.06)) {
    m.pattern = Pattern::tiles;
    m.scale = b->between(0.1, 0.4);
    m.coat = 0.04;
    m.coat_blur = 0.05;
  }
  return m;
}

RoomMaterial floor_material(RoomBuilder* b) {
  RoomMaterial m;
  const int kind = b->pick(5);
  const Vec3 wood = b->colour({0.05, 0.11}, {0.35, 0.75}, b->log_between(0.06, 0.4));
  const Vec3 grey = b->colour({0.0, 1.0}, {0.0, 0.2}, b->between(0.15, 0.6));
  m.colour = kind <= 1 ? wood : grey;
  m.second = m.colour * b->between(0.4, 0.8);
  constexpr Pattern k_floors[] = {Pattern::planks, Pattern::planks, Pattern::tiles, Pattern::checker,
                                  Pattern::blotches};
  m.pattern = k_floors[kind];
  m.scale = kind <= 1 ? b->between(0.07, 0.2) : kind <= 3 ? b->between(0.25, 0.8) : b->between(0.03, 0.6);
  if (kind == 4 && b->chance(0.5)) {
    m.colour = colour_of_hue(b->between(0.0, 1.0), 0.5, 0.2);
    m.second = m.colour * 0.6;
  }
  if (kind < 4 && b->chance(0.6)) {
    m.coat = 0.04;
    m.coat_blur = b->log_between(0.01, 0.25);
  }
  return m;
}

void build_shell(RoomBuilder* b, bool day) {
  Room& room = b->room;
  const Vec3 s = room.size;
  const int floor = b->material(floor_material(b));
  RoomMaterial white;
  white.colour = b->colour({0.0, 1.0}, {0.0, 0.1}, b->between(0.55, 0.88));
  if (b->chance(0.15)) white = wall_material(b);
  if (b->chance(0.15)) lay(&white, Pattern::tiles, 0.6, 0.8);
  const int ceiling = b->material(white);
  b->quad({0, 0, 0}, {0, 0, s.z}, {s.x, 0, 0}, floor);
  b->quad({0, s.y, 0}, {s.x, 0, 0}, {0, 0, s.z}, ceiling);
  const RoomMaterial paint = wall_material(b), accent = wall_material(b);
  RoomMaterial trim;
  trim.colour = b->chance(0.6) ? Vec3{0.75, 0.74, 0.71} : colour_of_hue(0.08, 0.6, b->between(0.05, 0.3));
  const int frame = b->material(trim), skirting = b->chance(0.6) ? frame : -1;
  const bool blinds = b->chance(0.15), large = b->chance(0.25);
  Wall walls[4] = {{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, s.x, s.y, {}},
                   {{s.x, 0, 0}, {0, 0, 1}, {-1, 0, 0}, s.z, s.y, {}},
                   {{s.x, 0, s.z}, {-1, 0, 0}, {0, 0, -1}, s.x, s.y, {}},
                   {{0, 0, s.z}, {0, 0, -1}, {1, 0, 0}, s.z, s.y, {}}};
  const int with_windows = day ? 1 + b->pick(2) : b->pick(3), first = b->pick(4);
  for (int i = 0; i < with_windows; ++i) {
    Wall& wall = walls[(first + i * (1 + b->pick(2))) % 4];
    wall.windows = choose_windows(b, wall.length, wall.height, large);
  }
  const int painted = b->material(paint), accented = b->material(accent);
  const int accent_wall = b->chance(0.35) ? b->pick(4) : -1;
  for (int i = 0; i < 4; ++i) build_wall(b, walls[i], i == accent_wall ? accented : painted, skirting, frame, blinds);
  if (b->chance(0.15)) {  // beams under the ceiling
    const int beam = b->material(floor_material(b));
    const double deep = b->between(0.12, 0.3), step = b->between(0.8, 2.0);
    for (double z = 0.5 * step; z < s.z; z += step)
      b->box({0.5 * s.x, s.y - deep, z}, {s.x, deep, b->between(0.1, 0.2)}, 0.0, beam);
  }
}

}  // namespace

Room make_room(uint64_t seed) {
  RoomBuilder builder(seed);
  RoomBuilder* b = &builder;
  Room& room = builder.room;
  const int kind = b->pick(10);  // 0-5 a living room or office, 6-7 a long room, 8-9 a hall
  const double x = kind < 6 ? b->between(2.6, 6.5) : kind < 8 ? b->between(1.8, 3.2) : b->between(6.0, 16.0);
  const double z = kind < 6 ? b->between(2.8, 7.5) : kind < 8 ? b->between(6.0, 15.0) : b->between(7.0, 20.0);
  const double y = kind < 8 ? b->between(2.3, 3.3) : b->between(3.5, 7.0);
  room.size = b->chance(0.5) ? Vec3{x, y, z} : Vec3{z, y, x};
  room.eye = {room.size.x * b->between(0.3, 0.7), b->between(1.0, 1.7), room.size.z * b->between(0.3, 0.7)};
  constexpr double k_clear = 0.45;  // around the camera, metres
  b->taken.push_back({room.eye.x - k_clear, room.eye.z - k_clear, room.eye.x + k_clear, room.eye.z + k_clear});
  // The key is the logarithmic mean of a picture's luminance. Captured interiors have 0.04 to 0.8, and half of them lie
  // between 0.11 and 0.3.
  room.key = std::clamp(0.19 * std::pow(4.0, b->between(0.0, 1.0) + b->between(0.0, 1.0) - 1.0), 0.05, 0.75);
  const bool day = b->chance(0.6);
  room.sky = choose_sky(b, day);
  build_shell(b, day);
  furnish(b);
  bool lit_by_day = false;
  if (day)
    for (const Emitter& e : room.emitters) lit_by_day = lit_by_day || e.kind == Emitter::Kind::window;
  light(b, lit_by_day);
  return std::move(builder.room);
}

}  // namespace sandglass::host
