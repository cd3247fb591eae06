// An image into the parts of the sphere. The parts ask for their pixels, not the pixels for their parts: each part that
// may be in the picture is projected into it at 4 x 4 points, and reads one pixel at each. So the work is bounded
// whatever the image's size, a part's share of the picture is known, and nothing is scattered.
//
// Where the points lie within a part changes from image to image, so that a lamp smaller than a part is met in the end.
#include "kernels/whole.h"
#include "runtime/core/luminance.h"
#include "runtime/core/math.h"
#include "runtime/core/turn.h"
#include "runtime/room/room.h"

namespace sandglass {

namespace {

constexpr uint32_t k_points = 4;        // along each side of a part
constexpr uint32_t k_lamp_points = 12;  // of one that is brighter than white: a lamp is smaller than a part
constexpr uint32_t k_vote_points = 2;   // the same where the image is only compared
// The steps of a sequence that fills a square evenly: powers of 1 / x, where x is the root of x^3 = x + 1.
constexpr double k_step_row = 0.7548776662466927, k_step_column = 0.5698402909980532;
constexpr uint8_t k_white = 250;  // sRGB: a channel from here on may be clipped
constexpr double k_margin_sine = 0.5, k_margin_cosine = 0.8660254037844386;  // 30 degrees: half a part, and parallax
constexpr float k_weight_most = 8.0f;  // what is known of a part counts as no more images than these
constexpr float k_clearer_rate = 0.9f, k_changed_rate = 0.5f;  // least shares of a new image
constexpr float k_radiance_most = 1e6f;                        // of a part
// Time stamps closer than this are no nanoseconds, if they come so many times in a row.
constexpr uint64_t k_shortest_ns = 1'000'000;
constexpr uint32_t k_hasty_most = 8;
constexpr double k_ticks = 2048;  // of a half-life, in the age of a part
constexpr uint32_t k_oldest = 65535;
// An image counts as taken at most a half-life after the one before; and where it is a day, the clock was another one.
constexpr uint64_t k_day_ns = 86'400'000'000'000;
constexpr double k_known = 0.3;  // share of a part from which on it counts as known
// An image that was exposed so much shorter than the last, and is dark, is one of lamps.
constexpr double k_short = 8.0, k_short_shows = 0.02;

bool is_short(const Room& room) {
  return room.images != 0 && room.exposure_known && room.view.scale > k_short * room.scale;
}

// sRGB to linear light, (c + 0.055) / 1.055 to the power 2.4, by Newton's fifth root: x^2.4 = x^2 (x^2)^(1/5).
struct LinearTable {
  float value[256];
};
constexpr LinearTable linear_table() {
  LinearTable table = {};
  for (int i = 0; i < 256; ++i) {
    const double c = i / 255.0;
    if (c <= 0.04045) {
      table.value[i] = static_cast<float>(c / 12.92);
      continue;
    }
    const double x = (c + 0.055) / 1.055, square = x * x;
    double root = 1.0;
    for (int step = 0; step < 60; ++step) root = root - (root - square / (root * root * root * root)) * 0.2;
    table.value[i] = static_cast<float>(square * root);
  }
  return table;
}
constexpr LinearTable k_linear = linear_table();

double fraction(double x) { return x - static_cast<double>(floor_index(x)); }

SinCos elevation_of(double row) { return sin_cos_turns((row / k_room_rows - 0.5) / 2); }
SinCos azimuth_of(double column) { return sin_cos_turns(column / k_room_columns); }

// An angle that is x radians greater, for |x| below 0.1: the series' next terms are below 1e-12.
SinCos turned(const SinCos& angle, double x) {
  const double y = x * x;
  const double s = x * (1 - y * (1.0 / 6) * (1 - y * (1.0 / 20) * (1 - y * (1.0 / 42))));
  const double c = 1 - y * 0.5 * (1 - y * (1.0 / 12) * (1 - y * (1.0 / 30) * (1 - y * (1.0 / 56))));
  return {angle.sin * c + angle.cos * s, angle.cos * c - angle.sin * s};
}

// A part, and where its middle lies.
struct PartMiddle {
  uint32_t part;
  SinCos elevation, azimuth;
};

void direction_of(const SinCos& elevation, const SinCos& azimuth, double direction[3]) {
  direction[0] = elevation.cos * azimuth.cos;
  direction[1] = elevation.sin;
  direction[2] = elevation.cos * azimuth.sin;
}

// Points of a part weigh by the area that each stands for: less towards the zenith.
RoomObservation observe(const RoomView& view, uint32_t images, const PartMiddle& part, uint32_t points) {
  RoomObservation seen = {};
  const CameraLayout layout = camera_layout(view.image);
  const bool is_lamp = points == k_lamp_points;
  // Not the same in all columns: at the zenith they see the same lamp.
  double down, across;
  room_step(images + part.part % k_room_columns, &down, &across);
  SinCos elevations[k_lamp_points], azimuths[k_lamp_points];
  for (uint32_t i = 0; i < points; ++i) {
    elevations[i] = turned(part.elevation, k_pi / k_room_rows * ((i + down) / points - 0.5));
    azimuths[i] = turned(part.azimuth, 2 * k_pi / k_room_columns * ((i + across) / points - 0.5));
  }
  double area = 0, all = 0, white = 0, light = 0, middle[2] = {}, from[2] = {};
  for (uint32_t i = 0; i < points; ++i)
    for (uint32_t j = 0; j < points; ++j) {
      double direction[3];
      direction_of(elevations[i], azimuths[j], direction);
      const double weight = elevations[i].cos;
      all += weight;
      uint32_t x, y;
      if (!room_pixel_of(view, direction, &x, &y)) continue;
      uint8_t rgb[3];
      camera_pixel(view.image, layout, x, y, rgb);
      double linear[3];
      for (int c = 0; c < 3; ++c) {
        linear[c] = static_cast<double>(k_linear.value[rgb[c]]);
        seen.colour[c] += weight * linear[c];
      }
      white += rgb[0] >= k_white || rgb[1] >= k_white || rgb[2] >= k_white ? weight : 0;
      area += weight;
      if (!is_lamp) continue;
      const double shown = weight * luminance(linear), at[2] = {static_cast<double>(i), static_cast<double>(j)};
      light += shown;
      for (int k = 0; k < 2; ++k) {
        middle[k] += weight * at[k];
        from[k] += shown * at[k];
      }
    }
  if (!(area > 0)) return seen;
  for (double& c : seen.colour) c /= area;
  seen.clipped = white / area;
  seen.covered = area / all;
  if (light > 0) {
    seen.up = 2.0 / points * (from[0] / light - middle[0] / area);
    seen.aside = 2.0 / points * (from[1] / light - middle[1] / area);
  }
  return seen;
}

int8_t towards(int8_t known, double now, float rate) {
  const double moved = known + static_cast<double>(rate) * (127.0 * now - known);
  const int64_t whole = floor_index(moved + 0.5);
  return static_cast<int8_t>(whole < -127 ? -127 : whole > 127 ? 127 : whole);
}

// What one part shows, into what is known of it.
void learn(Room* room, const PartMiddle& part) {
  RoomPart* known = &room->parts[part.part];
  const double memory = room_memory(known->age);
  if (room->view.lesson == RoomLesson::unknown && memory * static_cast<double>(known->seen) >= k_known) return;
  const bool is_bright = luminance(known->radiance) * room->light > room->scale;
  const RoomObservation now = observe(room->view, room->images, part, is_bright ? k_lamp_points : k_points);
  float weight = known->weight * static_cast<float>(memory);
  weight = weight < k_weight_most ? weight : k_weight_most;
  const RoomKnown before = {luminance(known->radiance), known->clipped, weight};
  if (!(now.covered > 0) || room_tells_nothing(*room, before, now)) return;
  const auto covered = static_cast<float>(now.covered), clipped = static_cast<float>(now.clipped);
  const float seen = known->seen * static_cast<float>(memory);
  known->seen = seen > covered ? seen : covered;
  known->age = 0;
  known->weight = weight + covered;
  const float rate = room_rate(*room, before, now);
  for (int c = 0; c < 3; ++c) {
    const double radiance = now.colour[c] * room->view.scale / room->light;
    known->radiance[c] += rate * (room_bounded_radiance(radiance) - known->radiance[c]);
  }
  known->clipped += rate * (clipped - known->clipped);
  known->up = towards(known->up, now.up, rate);
  known->aside = towards(known->aside, now.aside, rate);
  if (part.part >= k_room_below) return;
  for (int k = 0; k < 3; ++k) room->from[part.part][k] = towards(0, room->view.position[k], 1);
}

// The pose of the stored image in the sphere's frame.
void place(const Room& room, RoomView* view) {
  const CameraImage& image = view->image;
  for (int axis = 0; axis < 3; ++axis) {
    const double x = axis == 0 ? 1 : 0, y = axis == 1 ? 1 : 0;  // of the stored image; the upright one is turned
    const double quarters[4][2] = {{x, y}, {-y, x}, {-x, -y}, {y, -x}};
    const double* at = quarters[image.turn_deg / 90 % 4];
    const double upright[3] = {at[0], at[1], axis == 2 ? 1.0 : 0.0};
    double world[3];
    camera_to_world(image, upright, world);
    room_to_sphere(room, world, view->to_camera[axis]);
  }
  if (image.mirrored != 0)
    for (double& x : view->to_camera[0]) x = -x;
  const double position[3] = {static_cast<double>(image.position[0]), static_cast<double>(image.position[1]),
                              static_cast<double>(image.position[2])};
  room_place(room, position, view->position);
  const auto farther = [](double centre, double size) {
    return centre + 1 > size - centre ? centre + 1 : size - centre;
  };
  const double across = farther(static_cast<double>(image.centre_x), image.width) / static_cast<double>(image.focal_x);
  const double down = farther(static_cast<double>(image.centre_y), image.height) / static_cast<double>(image.focal_y);
  const double tangent = square_root(across * across + down * down);
  const double cosine = 1 / square_root(1 + tangent * tangent), sine = tangent * cosine;
  view->most_cosine = cosine * k_margin_cosine - sine * k_margin_sine;
}

// All that was seen is so much older.
void pass_time(Room* room, uint64_t step_ns) {
  const uint64_t whole_ns = to_whole<uint64_t>(room->half_life * (1e9 / k_ticks)),
                 tick_ns = whole_ns > 0 ? whole_ns : 1;
  const uint64_t ns = room->rest_ns + step_ns, ticks = ns / tick_ns;
  room->rest_ns = ns % tick_ns;
  const auto older = [ticks](uint16_t age) {
    return static_cast<uint16_t>(age + ticks < k_oldest ? age + ticks : k_oldest);
  };
  for (RoomPart& part : room->parts) part.age = older(part.age);
  for (uint32_t i = 0; room->texels != nullptr && i < k_cube_texels; ++i)
    room->texels[i].age = older(room->texels[i].age);
  room->view.step = static_cast<double>(step_ns) * 1e-9;
  room->settled += room->view.step;
}

bool due(const Room& room, uint64_t time_ns) {
  if (time_ns == 0 || room.images == 0 || time_ns < room.last_ns) return true;  // no clock, or one that restarted
  return time_ns != room.last_ns && time_ns - room.last_ns >= room.interval_ns;
}

}  // namespace

double room_linear(uint8_t value) { return static_cast<double>(k_linear.value[value]); }

void room_direction(double row, double column, double direction[3]) {
  direction_of(elevation_of(row), azimuth_of(column), direction);
}

void room_to_sphere(const Room& room, const double world[3], double sphere[3]) {
  const SinCos turn = sin_cos_turns(room.yaw);
  sphere[0] = turn.cos * world[0] + turn.sin * world[2];
  sphere[1] = world[1];
  sphere[2] = turn.cos * world[2] - turn.sin * world[0];
}

void room_to_world(const Room& room, const double sphere[3], double world[3]) {
  const SinCos turn = sin_cos_turns(room.yaw);
  world[0] = turn.cos * sphere[0] - turn.sin * sphere[2];
  world[1] = sphere[1];
  world[2] = turn.sin * sphere[0] + turn.cos * sphere[2];
}

void room_place(const Room& room, const double world[3], double sphere[3], double farthest) {
  double offset[3], squared = 0;
  for (int k = 0; k < 3; ++k) {
    offset[k] = (world[k] - room.centre[k]) / room.radius;
    squared += offset[k] * offset[k];
  }
  if (squared > farthest * farthest)
    for (double& o : offset) o *= farthest / square_root(squared);
  room_to_sphere(room, offset, sphere);
}

double room_memory(uint32_t age) { return age > 0 ? exponential(-0.6931471805599453 / k_ticks * age) : 1.0; }

bool room_may_be_seen(const RoomView& view, const double direction[3]) {
  double squared = 0, along = 0;
  for (int k = 0; k < 3; ++k) {
    const double v = direction[k] - view.position[k];
    squared += v * v;
    along += v * view.to_camera[2][k];
  }
  return along >= view.most_cosine * square_root(squared);
}

void room_step(uint32_t step, double* down, double* across) {
  *down = fraction(step * k_step_row);
  *across = fraction(step * k_step_column);
}

bool room_pixel_of(const RoomView& view, const double direction[3], uint32_t* x, uint32_t* y) {
  double c[3];
  for (int axis = 0; axis < 3; ++axis) {
    c[axis] = 0;
    for (int k = 0; k < 3; ++k) c[axis] += view.to_camera[axis][k] * (direction[k] - view.position[k]);
  }
  if (!(c[2] > 1e-6)) return false;
  const double u =
      static_cast<double>(view.image.focal_x) * c[0] / c[2] + static_cast<double>(view.image.centre_x) + 0.5;
  const double v =
      static_cast<double>(view.image.focal_y) * c[1] / c[2] + static_cast<double>(view.image.centre_y) + 0.5;
  if (!(u >= 0 && u < view.image.width && v >= 0 && v < view.image.height)) return false;
  *x = to_whole<uint32_t>(u);
  *y = to_whole<uint32_t>(v);
  return true;
}

bool room_tells_nothing(const Room& room, const RoomKnown& known, const RoomObservation& now) {
  if (now.clipped > 0 || !(luminance(now.colour) < room.tells_from)) return false;
  if (!(known.weight > 0)) return is_short(room);
  return known.luminance * room.light < room.tells_from * room.view.scale;
}

// What is clipped more than before says nothing new unless it is brighter; what is clipped less says more than all that
// was seen before; otherwise the mean of the last images moves on, faster where the light has changed.
float room_rate(const Room& room, const RoomKnown& known, const RoomObservation& now) {
  const auto covered = static_cast<float>(now.covered), clipped = static_cast<float>(now.clipped);
  const double before = known.luminance, after = luminance(now.colour) * room.view.scale / room.light;
  const bool hidden = clipped > 2 * known.clipped && after <= 1.1 * before;
  if (known.weight > 0 && hidden) return 0;
  const float rate = covered / (known.weight + covered);
  const bool clearer = 2 * clipped < known.clipped;
  const bool changed = after > 2 * before || after < 0.5 * before;
  const float least = covered * (clearer ? k_clearer_rate : changed ? k_changed_rate : 0.0f);
  return rate > least ? rate : least;
}

float room_bounded_radiance(double radiance) {
  const auto bounded = static_cast<float>(radiance);
  return bounded < k_radiance_most ? bounded : k_radiance_most;
}

bool room_clock_is_sound(Room* room, uint64_t time_ns) {
  const bool hasty = time_ns > room->offered_ns && time_ns - room->offered_ns < k_shortest_ns;
  if (time_ns != room->offered_ns) room->hasty = hasty ? room->hasty + 1 : 0;
  room->offered_ns = time_ns;
  return room->hasty < k_hasty_most;
}

bool room_take_image(Room* room, const CameraImage& image) {
  if (room->phase != RoomPhase::idle || !due(*room, image.timestamp_ns)) return false;
  if (room->images == 0 && (room->probe == nullptr || !(room->probe->confidence > 0)))
    for (int k = 0; k < 3; ++k) room->centre[k] = static_cast<double>(image.position[k]);
  RoomView* view = &room->view;
  // Without a clock images count as `interval` apart; so do those of a clock that was set back, or of another session.
  const uint64_t since = image.timestamp_ns - room->last_ns;
  const bool clocked = room->last_ns != 0 && image.timestamp_ns > room->last_ns && since < k_day_ns;
  const uint64_t step = clocked ? since : room->interval_ns;
  const auto longest = to_whole<uint64_t>(room->half_life * 1e9);
  if (room->images != 0) pass_time(room, step < longest ? step : longest);
  room->last_ns = image.timestamp_ns;
  view->image = with_turn(image);
  view->vote = {};
  view->lesson = RoomLesson::all;
  view->sparse = room_is_steady(*room) && image.exposure > 0;
  place(*room, view);
  view->scale = room->exposure_known && image.exposure > 0 ? 1 / static_cast<double>(image.exposure) : room->scale;
  room->phase = RoomPhase::compare;
  room->cursor = 0;
  return true;
}

uint32_t room_texel_units_left(const Room& room) {
  const uint32_t done = room.phase == RoomPhase::texels ? room.cursor : 0;
  return room.texels == nullptr || room.phase == RoomPhase::idle ? 0 : (k_cube_texels - done) / k_cube_unit_texels;
}

uint32_t room_units_left(const Room& room) {
  constexpr uint32_t k_units = k_room_parts / k_room_unit_parts;
  const uint32_t texels = room_texel_units_left(room);
  if (room.phase == RoomPhase::idle || room.phase == RoomPhase::texels) return texels;
  return texels + (room.phase == RoomPhase::compare ? 2 : 1) * k_units - room.cursor / k_room_unit_parts;
}

namespace {

// The next phase of an image whose parts were all looked at in this one.
RoomPhase phase_after(const Room& room) {
  if (room.phase == RoomPhase::compare)
    return room.view.lesson == RoomLesson::nothing ? RoomPhase::idle : RoomPhase::gather;
  return room.phase == RoomPhase::gather && room.texels != nullptr ? RoomPhase::texels : RoomPhase::idle;
}

void run_parts(Room* room) {
  RoomView* view = &room->view;
  static_assert(k_room_unit_parts % k_room_columns == 0);
  const uint32_t end = room->cursor + k_room_unit_parts;
  SinCos azimuths[k_room_columns];
  for (uint32_t column = 0; column < k_room_columns; ++column) azimuths[column] = azimuth_of(column + 0.5);
  for (PartMiddle middle = {}; room->cursor < end; ++room->cursor) {
    const uint32_t column = room->cursor % k_room_columns;
    const uint32_t row = room->cursor / k_room_columns;
    if (column == 0) middle.elevation = elevation_of(row + 0.5);
    middle.part = room->cursor;
    middle.azimuth = azimuths[column];
    double direction[3];
    direction_of(middle.elevation, middle.azimuth, direction);
    if (!room_may_be_seen(*view, direction)) continue;
    if (room->phase == RoomPhase::gather) {
      learn(room, middle);
      continue;
    }
    if (view->sparse && (column + row + room->images) % 2 != 0) continue;
    const RoomObservation now = observe(*view, room->images, middle, k_vote_points);
    if (now.covered > 0) room_vote(room, room->cursor, (view->sparse ? 2 : 1) * middle.elevation.cos, now);
  }
}

}  // namespace

void room_run_unit(Room* room) {
  RoomView* view = &room->view;
  if (room->phase == RoomPhase::texels) {
    room_learn_texels(room, room->cursor);
    room->cursor += k_cube_unit_texels;
  } else {
    run_parts(room);
  }
  if (room->cursor < (room->phase == RoomPhase::texels ? k_cube_texels : k_room_parts)) return;
  room->cursor = 0;
  if (room->phase == RoomPhase::compare) room_decide(room);
  const bool teaches = view->lesson != RoomLesson::nothing;
  room->phase = phase_after(*room);
  if (room->phase != RoomPhase::idle) return;
  if (teaches) {
    const bool dark = static_cast<double>(view->vote.shown) < k_short_shows * static_cast<double>(view->vote.area);
    if (!dark || !is_short(*room)) room->scale = view->scale;
    ++room->images;
  }
  for (const uint8_t*& plane : view->image.planes) plane = nullptr;
}

}  // namespace sandglass
