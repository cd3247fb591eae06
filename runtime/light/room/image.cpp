// An image into the parts of the sphere. The parts ask for their pixels, not the pixels for their parts: each part that
// may be in the picture is projected into it at 4 x 4 points, and reads one pixel at each. So the work is bounded
// whatever the image's size, a part's share of the picture is known, and nothing is scattered.
//
// Where the points lie within a part changes from image to image, so that a lamp smaller than a part is met in the end.
#include "kernels/whole.h"
#include "runtime/light/camera/transfer.h"
#include "runtime/light/luminance.h"
#include "runtime/light/room/room.h"
#include "runtime/math/math.h"
#include "runtime/math/turn.h"

namespace sandglass {

namespace {

constexpr uint32_t k_points = 4;        // along each side of a part
constexpr uint32_t k_lamp_points = 12;  // of one that is brighter than white: a lamp is smaller than a part
constexpr double k_lamp_clips = 0.5;    // share of a part: what clips less of it may be a lamp
constexpr uint32_t k_close_looks = 6;   // at such parts in an image, about; where there are more they take turns
constexpr uint32_t k_vote_points = 3;   // the same where the image is only compared
constexpr uint32_t k_fewer_points = 2;  // the same where its exposure is not known
// The steps of a sequence that fills a square evenly: powers of 1 / x, where x is the root of x^3 = x + 1.
constexpr double k_step_row = 0.7548776662466927, k_step_column = 0.5698402909980532;
constexpr double k_dark = 0.01;       // linear: bytes round what is darker
constexpr uint8_t k_white = 250;      // sRGB: a channel from here on may be clipped
constexpr double k_to_corner = 0.14;  // radii, from the middle of a part
constexpr float k_weight_max = 8.0f;  // what is known of a part counts as no more images than these
constexpr float k_clearer_rate = 0.9f, k_changed_rate = 0.5f;  // shares of a new image, at least
constexpr float k_whole = 0.999f, k_as_much = 0.9f;
constexpr uint8_t k_cut_white = 16;     // quarters of an octave that a short image counts less whose rim cuts a lamp
constexpr float k_hardly = 1;           // weight of what one image has shown in part, or many long ago
constexpr float k_faint = 0.001f;       // share of a part that is clipped: the sun's
constexpr float k_little = 0.02f;       // the same of a bulb, which points may miss
constexpr float k_clear = 0.8f;         // an image that counts for more says that nothing is clipped, where it is not
constexpr float k_radiance_max = 1e6f;  // of a part
// Time stamps closer than this are no nanoseconds, if they come so many times in a row.
constexpr uint64_t k_shortest_ns = 1'000'000;
constexpr uint32_t k_hasty_max = 8;
constexpr double k_ticks = 2048;  // of a half-life, in the age of a part
constexpr uint32_t k_oldest = 65535;
// An image counts as taken at most a half-life after the one before; and where it is a day, the clock was another one.
constexpr uint64_t k_day_ns = 86'400'000'000'000;
constexpr double k_known = 0.3;  // share of a part from which on it counts as known
// An image that was exposed so much shorter than the last, and is dark, is one of lamps.
constexpr double k_short = 8.0, k_short_shows = 0.02;

SinCos elevation_of(double row) { return sin_cos_turns((row / k_room_rows - 0.5) / 2); }
SinCos azimuth_of(double column) { return sin_cos_turns(column / k_room_columns); }

// An angle that is x radians greater, for |x| below 0.1: the series' next terms are below 1e-12.
__attribute__((noinline)) SinCos turned(const SinCos& angle, double x) {
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

// The same of a place in it, 0..1 from edge to edge.
SinCos elevation_in(const PartMiddle& part, double at) {
  return turned(part.elevation, k_pi / k_room_rows * (at - 0.5));
}
SinCos azimuth_in(const PartMiddle& part, double at) {
  return turned(part.azimuth, 2 * k_pi / k_room_columns * (at - 0.5));
}

void direction_of(const SinCos& elevation, const SinCos& azimuth, double direction[3]) {
  direction[0] = elevation.cos * azimuth.cos;
  direction[1] = elevation.sin;
  direction[2] = elevation.cos * azimuth.sin;
}

// What points of a part have shown.
struct Points {
  double colour[3], area, all, white, light, squares, brightest;
  double middle[2], from[2], clipped[2];  // where points lie, from 0 to 1: of all, by light, of those that are clipped
};

// One point, which stands for `share` of the area of a cell of the grid.
__attribute__((always_inline)) inline void add_point(const RoomView& view, const CameraLayout& layout,
                                                     const SinCos& elevation, const SinCos& azimuth, const double at[2],
                                                     double share, Points* points) {
  double direction[3];
  direction_of(elevation, azimuth, direction);
  const double weight = share * elevation.cos;
  points->all += weight;
  uint32_t x, y;
  if (!room_pixel_of(view, direction, &x, &y)) return;
  uint8_t rgb[3];
  camera_pixel(view.image, layout, x, y, rgb);
  double linear[3];
  for (int c = 0; c < 3; ++c) {
    linear[c] = static_cast<double>(camera_light(view.image, view.light, rgb[c]));
    points->colour[c] += weight * linear[c];
  }
  const double white = rgb[0] >= k_white || rgb[1] >= k_white || rgb[2] >= k_white ? weight : 0, y_ = luminance(linear);
  points->white += white;
  points->area += weight;
  points->light += weight * y_;
  points->squares += weight * y_ * y_;
  points->brightest = y_ > points->brightest ? y_ : points->brightest;
  for (int k = 0; k < 2; ++k) {
    points->middle[k] += weight * at[k];
    points->from[k] += weight * y_ * at[k];
    points->clipped[k] += white * at[k];
  }
}

__attribute__((noinline)) void add_fine_point(const RoomView& view, const CameraLayout& layout, const PartMiddle& part,
                                              const double at[2], double share, Points* points) {
  add_point(view, layout, elevation_in(part, at[0]), azimuth_in(part, at[1]), at, share, points);
}

// Where in a part a lamp lies, -1..1 from edge to edge. So many rows and columns of the grid beside it have finer points,
// so many along each side of a cell: the sun is smaller than what lies between points.
struct CloseLook {
  double up, aside;
  uint32_t rows, columns, finer;
};
constexpr uint32_t k_reach = 1, k_finer = 4;
// A short image is all that tells a lamp's light. It is counted by more points: all of a wide one, and closer of a bulb.
constexpr uint32_t k_short_reach = 2, k_short_finer = 8;

// The cells of the grid with finer points.
struct Window {
  uint32_t top, bottom, left, right;

  bool holds(uint32_t row, uint32_t column) const {
    return row >= top && row < bottom && column >= left && column < right;
  }
};
Window window_of(const CloseLook& lamp, uint32_t count) {
  const auto cell = [count](double at) { return floor_index((0.5 + 0.5 * at) * count); };
  const auto within = [count](int64_t at) { return static_cast<uint32_t>(at < 0 ? 0 : at > count ? count : at); };
  const int64_t row = cell(lamp.up), column = cell(lamp.aside);
  return {within(row - lamp.rows), within(row + lamp.rows + 1), within(column - lamp.columns),
          within(column + lamp.columns + 1)};
}

// Points of a part weigh by the area that each stands for: less towards the zenith.
__attribute__((noinline)) RoomObservation observe(const RoomView& view, uint32_t images, const PartMiddle& part,
                                                  uint32_t count, const CloseLook* lamp = nullptr) {
  const CameraLayout layout = camera_layout(view.image);
  // Not the same in all columns: at the zenith they see the same lamp.
  double down, across;
  room_step(images + part.part % k_room_columns, &down, &across);
  const Window near = lamp != nullptr ? window_of(*lamp, count) : Window{};
  SinCos elevations[k_lamp_points], azimuths[k_lamp_points];
  for (uint32_t i = 0; i < count; ++i) {
    elevations[i] = elevation_in(part, (i + down) / count);
    azimuths[i] = azimuth_in(part, (i + across) / count);
  }
  Points points = {};
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = 0; j < count; ++j) {
      if (near.holds(i, j)) continue;
      const double at[2] = {(i + down) / count, (j + across) / count};
      add_point(view, layout, elevations[i], azimuths[j], at, 1, &points);
    }
  for (uint32_t i = near.top; i < near.bottom; ++i)
    for (uint32_t j = near.left; j < near.right; ++j)
      for (uint32_t k = 0; k < lamp->finer * lamp->finer; ++k) {
        const uint32_t row = k / lamp->finer, column = k % lamp->finer;
        const double up = (row + down) / lamp->finer, aside = (column + across) / lamp->finer;
        const double at[2] = {(i + up) / count, (j + aside) / count};
        add_fine_point(view, layout, part, at, 1.0 / (lamp->finer * lamp->finer), &points);
      }
  RoomObservation seen = {};
  if (!(points.area > 0)) return seen;
  for (int c = 0; c < 3; ++c) seen.colour[c] = points.colour[c] / (points.area * static_cast<double>(view.balance[c]));
  seen.uneven = points.light > 0 ? points.squares * points.area / (points.light * points.light) - 1 : 0;
  seen.clipped = points.white / points.area;
  seen.covered = points.area / points.all;
  seen.brightest = count == k_lamp_points ? points.brightest : luminance(seen.colour);
  const auto beside = [&](int k) {
    const double place = points.white > 0 ? points.clipped[k] / points.white : points.from[k] / points.light;
    const bool whole = points.white > 0 || seen.covered < static_cast<double>(k_whole);
    return 2 * (whole ? place - 0.5 : place - points.middle[k] / points.area);
  };
  if (points.white > 0 || (count == k_lamp_points && points.light > 0)) {
    seen.up = beside(0);
    seen.aside = beside(1);
  }
  return seen;
}

// Whether a part that may hold a lamp is looked at closely. Of a short image all are: hardly anything else is clipped
// there.
bool looks_closely(Room* room, uint32_t part) {
  ++room->crowd;
  const uint32_t turns = 1 + room->crowd_before / k_close_looks;
  return room_is_short(*room) || (part + room->images) % turns == 0;
}

// How far away is what the camera sees? In logarithms: below k_alike_log a part speaks for neither answer; it speaks
// for one by at most k_log_max, less k_drift_log, which is chance; and the sum stays above k_surely_near.
constexpr double k_alike_log = 0.1, k_log_max = 1, k_drift_log = 0.03, k_surely_near = -3;

// What is far is seen in the same direction from everywhere; what is near is not. A part of which an image shows the
// same as one that was taken elsewhere, if it looks in the same direction, speaks for the one; one that shows the same
// where the sphere has it, for the other. The sum is bounded below, so that a street behind a door is found, too.
void compare_as_far(Room* room, const PartMiddle& part, const RoomKnown& before, const RoomObservation& now) {
  RoomView* view = &room->view;
  const RoomPart& known = room->parts[part.part];
  double from[3], here[3], squared = 0;
  for (int k = 0; k < 3; ++k) {
    from[k] = known.from[k] / 127.0;
    here[k] = view->position[k];
    squared += (from[k] - here[k]) * (from[k] - here[k]);
  }
  if (squared < k_parallax * k_parallax || now.clipped > 0 || !room_remembers(known)) return;
  for (int k = 0; k < 3; ++k) view->position[k] = from[k];
  const RoomObservation as_far = observe(*view, room->images, part, k_points);
  for (int k = 0; k < 3; ++k) view->position[k] = here[k];
  const double near_light = luminance(now.colour), far_light = luminance(as_far.colour);
  if (as_far.covered < 1 || as_far.clipped > 0 || !(near_light > k_dark) || !(far_light > k_dark)) return;
  const double known_light = before.luminance * room->light / view->scale;
  const double near = absolute(logarithm(near_light / known_light)), far = absolute(logarithm(far_light / known_light));
  if (near < k_alike_log && far < k_alike_log) return;
  const double better = near - far;
  const double evidence = (better < -k_log_max ? -k_log_max : better > k_log_max ? k_log_max : better) - k_drift_log;
  room->farther += part.elevation.cos * evidence;
  if (room->farther < k_surely_near) room->farther = k_surely_near;
}

// What the image shows of a part. `closely`: it was looked at closely, as a lamp is there or may be.
RoomObservation shown_of(Room* room, const PartMiddle& part, bool above, bool* closely) {
  const RoomPart& known = room->parts[part.part];
  const bool may_hold = known.clipped > 0 && known.clipped < k_lamp_clips;
  // A spot is one only in a part that holds no lamp as yet.
  const RoomSpot* spot = room_spot(room->view, part.part);
  const bool is_lamp = spot != nullptr || luminance(known.radiance) * room->light > room->scale ||
                       (may_hold && looks_closely(room, part.part));
  CloseLook look = {(spot != nullptr ? spot->up : known.up) / 127.0,
                    (spot != nullptr ? spot->aside : known.aside) / 127.0, k_reach, k_reach, k_finer};
  if (may_hold && room_is_short(*room)) {
    const bool bulb = known.clipped < static_cast<double>(k_little);
    if (bulb) look.finer = k_short_finer;
    else look.rows = k_short_reach;
    look.columns = to_whole<uint32_t>(look.rows / part.elevation.cos + 0.5);
  }
  RoomObservation now =
      observe(room->view, room->images, part, is_lamp ? k_lamp_points : k_points, is_lamp && above ? &look : nullptr);
  *closely = is_lamp;
  if (!is_lamp && !may_hold && above && now.clipped > 0 && now.clipped < k_lamp_clips &&
      looks_closely(room, part.part)) {
    *closely = true;
    look.up = now.up;
    look.aside = now.aside;
    now = observe(room->view, room->images, part, k_lamp_points, &look);
  }
  return now;
}

// Whether an image of that white shows more of a part than what is known of it: images of a lower white, which it clipped.
bool outshines(const RoomKnown& known, int white) {
  return known.clipped > 0 && known.white != 0 && white > known.white + 2;
}

// What one part shows, into what is known of it.
void learn(Room* room, const PartMiddle& part) {
  RoomPart* known = &room->parts[part.part];
  const double memory = room_memory(known->age);
  if (room->view.lesson == RoomLesson::unknown && memory * known->seen >= k_known) return;
  const bool above = part.part >= k_room_below;
  uint8_t* white = above ? &room->white[part.part - k_room_below] : nullptr;
  bool closely = false;
  const RoomObservation now = shown_of(room, part, above, &closely);
  float weight = known->weight * static_cast<float>(memory);
  weight = weight < k_weight_max ? weight : k_weight_max;
  const RoomKnown before = {luminance(known->radiance),
                            static_cast<float>(known->clipped),
                            weight,
                            static_cast<float>(known->seen * memory),
                            white != nullptr ? *white : uint8_t{0},
                            known->shown == k_shown_anew};
  if (!(now.covered > 0)) return;
  const uint8_t of_now = room_quarter_octaves(room->view.scale);
  if (room_tells_nothing(*room, before, now)) {
    // A lamp so small that its points were missed was looked for: it is not asked for again.
    if (white != nullptr && known->clipped > 0 && now.covered >= static_cast<double>(k_whole) && of_now > *white)
      *white = of_now;
    return;
  }
  if (above && room->given_radius == 0 && !room->far && room->view.lesson == RoomLesson::all && now.covered >= 1 &&
      !room_is_short(*room))
    compare_as_far(room, part, before, now);
  const auto covered = static_cast<float>(now.covered), clipped = static_cast<float>(now.clipped);
  known->seen = static_cast<double>(before.seen > covered ? before.seen : covered);
  known->age = 0;
  known->weight = weight + covered;
  const float rate = room_rate(*room, before, now);
  for (int c = 0; c < 3; ++c) {
    const double radiance = now.colour[c] * room->view.scale / room->light;
    known->radiance[c] += rate * (room_bounded_radiance(radiance) - known->radiance[c]);
  }
  // A lamp that was not known has no place yet.
  const float moved = before.clipped > 0 || before.luminance * room->light > room->scale ? rate : 1;
  // What is clipped a little counts at once, and what is no more so: the next image may miss it.
  const bool at_once = clipped > 0 ? rate > 0 && before.clipped < k_faint && clipped < k_little : rate > k_clear;
  // A short image whose rim cuts a lamp tells its light at least: it remains clipped, and is asked for again.
  const bool cut = covered < k_whole && outshines(before, of_now);
  if (!cut) known->clipped = static_cast<double>(before.clipped + (at_once ? 1 : rate) * (clipped - before.clipped));
  if (rate > 0) {
    known->up = room_towards(known->up, now.up, moved);
    known->aside = room_towards(known->aside, now.aside, moved);
  }
  // Points far apart may have missed a lamp that an ordinary image shows.
  const bool tells_white = closely || before.clipped > 0 || !room_is_short(*room);
  const auto tells_of = static_cast<uint8_t>(cut ? of_now - k_cut_white : of_now);
  if (white != nullptr && rate > 0 && tells_white &&
      (tells_of > *white || clipped > 0 || !(rate < k_changed_rate * covered)))
    *white = tells_of;
  for (int k = 0; k < 3 && (covered >= k_whole || covered >= before.seen); ++k)
    known->from[k] = room_towards(known->from[k], room->view.position[k], above ? rate : 1);
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
  for (int i = 0; i < 4; ++i) {
    const bool along = i < 2, first = i % 2 == 0;
    const double focal = static_cast<double>(along ? image.focal_x : image.focal_y);
    const double centre = static_cast<double>(along ? image.centre_x : image.centre_y) + 0.5;
    const double inwards = first ? centre : (along ? image.width : image.height) - centre;
    const double length = square_root(focal * focal + inwards * inwards);
    double* side = view->sides[i];
    side[3] = -k_to_corner;
    for (int k = 0; k < 3; ++k) {
      const double across = view->to_camera[along ? 0 : 1][k];
      side[k] = ((first ? focal : -focal) * across + inwards * view->to_camera[2][k]) / length;
      side[3] += side[k] * view->position[k];
    }
  }
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

double room_memory(uint32_t age) { return age > 0 ? exponential(-0.6931471805599453 / k_ticks * age) : 1.0; }

bool room_may_be_seen(const RoomView& view, const double direction[3]) {
  for (const double* side : view.sides)
    if (side[0] * direction[0] + side[1] * direction[1] + side[2] * direction[2] < side[3]) return false;
  return true;
}

void room_step(uint32_t step, double* down, double* across) {
  *down = room_fraction(step * k_step_row);
  *across = room_fraction(step * k_step_column);
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

bool room_is_short(const Room& room) {
  return room.images != 0 && room.exposure_known && room.view.scale > k_short * room.scale;
}

bool room_shows_lamps_only(const Room& room) {
  const RoomVote& v = room.view.vote;
  return room_is_short(room) && static_cast<double>(v.shown) < k_short_shows * static_cast<double>(v.area);
}

bool room_tells_nothing(const Room& room, const RoomKnown& known, const RoomObservation& now) {
  if (now.clipped > 0 || !(now.brightest < static_cast<double>(room.tells_from))) return false;
  if (!(known.weight > 0) || room_shows_lamps_only(room)) return room_is_short(room);
  return known.luminance * room.light < static_cast<double>(room.tells_from) * room.view.scale;
}

uint8_t room_quarter_octaves(double radiance) {
  const double steps = 128.5 + 4 / 0.6931471805599453 * logarithm(radiance);
  return to_whole<uint8_t>(steps < 1 ? 1 : steps > 255 ? 255 : steps);
}

// What is clipped more than before says nothing new unless it is brighter; what is clipped less says more than all that
// was seen before; otherwise the mean of the last images moves on, faster where the light has changed.
float room_rate(const Room& room, const RoomKnown& known, const RoomObservation& now) {
  const auto covered = static_cast<float>(now.covered), clipped = static_cast<float>(now.clipped);
  const double before = known.luminance, after = luminance(now.colour) * room.view.scale / room.light;
  const int white_now = room_quarter_octaves(room.view.scale);
  const bool less_white = known.white > white_now + 2, more_white = white_now > known.white + 2;
  const bool more_clipped = known.white != 0 ? less_white && clipped > 0 : clipped > 2 * known.clipped;
  const bool hidden = more_clipped && after <= 1.1 * before;
  // If a part was hardly seen before, what was not seen of it is new.
  const bool new_here = known.weight < k_hardly && covered > known.seen && !(less_white && known.clipped > 0);
  if (known.weight > 0 && hidden) return new_here ? 1 - known.seen / covered : 0;
  // A picture whose rim cuts a lamp shows too little or too much of it. But what a shorter image shows of a clipped
  // lamp is there at least, in the whole part: so much is new.
  const double white = room.scale / room.light, now_at_least = now.covered * after;
  const bool is_lamp = before > white || after > white || clipped > 0 || known.clipped > 0;
  const bool shorter = known.clipped > 0 && more_white;
  const bool by_white = outshines(known, white_now);
  // Where it is not known by which image a part is known, one that shows nearly as much of it as was ever seen shows
  // the same of it.
  const bool cut = covered < k_whole && (by_white || covered <= (shorter ? k_as_much : 1) * known.seen);
  if (cut && is_lamp) {
    const bool tells = shorter && now_at_least > before;
    return tells ? static_cast<float>((now_at_least - before) / (after - before)) : 0;
  }
  const float rate = covered / (known.weight + covered);
  const bool clearer = 2 * clipped < known.clipped;
  const bool changed = !known.anew && (after > 2 * before || after < 0.5 * before);
  // What is known by longer images, and clipped, is a lower bound: beside a shorter image it does not count.
  if (clearer && by_white) return 1;
  const float rate_min = covered * (clearer ? k_clearer_rate : changed ? k_changed_rate : 0.0f);
  return rate > rate_min ? rate : rate_min;
}

float room_bounded_radiance(double radiance) {
  const auto bounded = static_cast<float>(radiance);
  return bounded < k_radiance_max ? bounded : k_radiance_max;
}

bool room_clock_is_sound(Room* room, uint64_t time_ns) {
  const bool hasty = time_ns > room->offered_ns && time_ns - room->offered_ns < k_shortest_ns;
  if (time_ns != room->offered_ns) room->hasty = hasty ? room->hasty + 1 : 0;
  room->offered_ns = time_ns;
  return room->hasty < k_hasty_max;
}

bool room_take_image(Room* room, const CameraImage& image) {
  if (room->phase != RoomPhase::idle || !due(*room, image.timestamp_ns)) return false;
  if (room->images == 0 && (room->probe == nullptr || !(room->probe->confidence > 0)))
    for (int k = 0; k < 3; ++k) room->centre[k] = static_cast<double>(image.position[k]);
  room_fit_sphere(room, image);
  RoomView* view = &room->view;
  // Without a clock images count as `interval` apart; so do those of a clock that was set back, or of another session.
  const uint64_t since = image.timestamp_ns - room->last_ns;
  const bool clocked = room->last_ns != 0 && image.timestamp_ns > room->last_ns && since < k_day_ns;
  const uint64_t step = clocked ? since : room->interval_ns;
  const auto longest = to_whole<uint64_t>(room->half_life * 1e9);
  if (room->images != 0) pass_time(room, step < longest ? step : longest);
  room->last_ns = image.timestamp_ns;
  view->image = with_turn(image);
  view->light = camera_light_table(image);
  view->vote = {};
  view->spot_count = 0;
  view->lesson = RoomLesson::all;
  room->crowd_before = room->crowd;
  room->crowd = 0;
  place(*room, view);
  view->scale = room->exposure_known && image.exposure > 0 ? 1 / static_cast<double>(image.exposure) : room->scale;
  const bool known = room_knows_gains(*room, image);
  for (int c = 0; c < 3; ++c) view->balance[c] = known ? image.gains[c] / room->gains[c] : room->balance[c];
  view->shows_steps = room->shows_steps;
  room->shows_steps = false;  // until it is known how this image is exposed
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
  if (room->phase == RoomPhase::compare) room_search(room, room->cursor / k_room_unit_parts);
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
    if (!room_may_be_seen(*view, direction)) {
      if (room->phase == RoomPhase::compare) room->parts[room->cursor].shown = 0;
      continue;
    }
    if (room->phase == RoomPhase::gather) {
      learn(room, middle);
      continue;
    }
    // Where the exposure is not known, at the same points of each image: so it is known how that changed.
    const RoomObservation now = view->image.exposure > 0 ? observe(*view, room->images, middle, k_vote_points)
                                                         : observe(*view, 0, middle, k_fewer_points);
    if (now.covered > 0) room_vote(room, room->cursor, middle.elevation.cos, now);
    else room->parts[room->cursor].shown = 0;
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
  // A given balance holds for an image that teaches nothing, too.
  if (room_knows_gains(*room, view->image) || (teaches && !room_shows_lamps_only(*room)))
    for (int c = 0; c < 3; ++c) room->balance[c] = view->balance[c];
  if (teaches) {
    room_measure_lamp(room);
    if (!room_shows_lamps_only(*room)) room->scale = view->scale;
    ++room->images;
  }
  for (const uint8_t*& plane : view->image.planes) plane = nullptr;
}

}  // namespace sandglass
