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

constexpr uint32_t k_points = 4;          // along each side of a part
constexpr uint32_t k_overlap_points = 2;  // the same where only the exposure is asked for
// The steps of a sequence that fills a square evenly: powers of 1 / x, where x is the root of x^3 = x + 1.
constexpr double k_step_row = 0.7548776662466927, k_step_column = 0.5698402909980532;
constexpr uint8_t k_white = 250;  // sRGB: a channel from here on may be clipped
constexpr double k_margin_sine = 0.5, k_margin_cosine = 0.8660254037844386;  // 30 degrees: half a part, and parallax
constexpr double k_farthest = 0.8;     // radii: a camera or an object farther out counts as this far
constexpr float k_weight_most = 8.0f;  // what is known of a part counts as no more images than these
constexpr float k_clearer_rate = 0.9f, k_changed_rate = 0.5f;  // least shares of a new image
constexpr float k_clip_slack = 0.05f;  // a difference of clipped shares below this means nothing
// What tells an exposure: parts that are remembered, that were hardly clipped (else they are brighter than is known),
// and that are not black now. Black is one step of a byte: an image that is exposed for a 64th shows little more of a
// wall.
constexpr double k_overlap_memory = 0.3, k_overlap_clipped = 0.01, k_overlap_dark = 0.0003, k_overlap_least = 1.0;
constexpr double k_scale_most = 1e6;
// The light of the whole room has changed where almost all that is seen again is brighter or darker by half: in the
// logarithm, the share of what is compared, how much is compared (parts on the horizon), and how bright a part is shown
// at least, so that bytes do not round it.
constexpr double k_change = 0.405, k_change_share = 0.8, k_change_least = 8.0, k_change_dark = 0.01;
constexpr float k_radiance_most = 1e6f;  // of a part

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

struct Observation {
  double colour[3] = {};  // linear, 1 is white
  double clipped = 0;     // share of the points
  double covered = 0;     // share of the points that are in the picture
};

double fraction(double x) { return x - static_cast<double>(floor_index(x)); }

SinCos elevation_of(double row) { return sin_cos_turns((row / k_room_rows - 0.5) / 2); }
SinCos azimuth_of(double column) { return sin_cos_turns(column / k_room_columns); }

void direction_of(const SinCos& elevation, const SinCos& azimuth, double direction[3]) {
  direction[0] = elevation.cos * azimuth.cos;
  direction[1] = elevation.sin;
  direction[2] = elevation.cos * azimuth.sin;
}

bool may_be_seen(const RoomView& view, const SinCos& elevation, uint32_t column) {
  double direction[3], squared = 0, along = 0;
  direction_of(elevation, azimuth_of(column + 0.5), direction);
  for (int k = 0; k < 3; ++k) {
    const double v = direction[k] - view.position[k];
    squared += v * v;
    along += v * view.to_camera[2][k];
  }
  return along >= view.most_cosine * square_root(squared);
}

// The pixel that shows a direction, or false.
bool pixel_of(const RoomView& view, const double direction[3], uint32_t* x, uint32_t* y) {
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

Observation observe(const RoomView& view, uint32_t images, uint32_t row, uint32_t column, uint32_t points) {
  Observation seen;
  const double down = fraction(images * k_step_row), across = fraction(images * k_step_column);
  SinCos elevations[k_points], azimuths[k_points];
  for (uint32_t i = 0; i < points; ++i) {
    elevations[i] = elevation_of(row + (i + down) / points);
    azimuths[i] = azimuth_of(column + (i + across) / points);
  }
  uint32_t count = 0, white = 0;
  for (uint32_t i = 0; i < points; ++i)
    for (uint32_t j = 0; j < points; ++j) {
      double direction[3];
      direction_of(elevations[i], azimuths[j], direction);
      uint32_t x, y;
      if (!pixel_of(view, direction, &x, &y)) continue;
      uint8_t rgb[3];
      camera_pixel(view.image, x, y, rgb);
      for (int c = 0; c < 3; ++c) seen.colour[c] += static_cast<double>(k_linear.value[rgb[c]]);
      white += rgb[0] >= k_white || rgb[1] >= k_white || rgb[2] >= k_white ? 1 : 0;
      ++count;
    }
  if (count == 0) return seen;
  for (double& c : seen.colour) c /= count;
  seen.clipped = static_cast<double>(white) / count;
  seen.covered = static_cast<double>(count) / (points * points);
  return seen;
}

// Whether a part is remembered well, and unclipped.
bool is_remembered(const Room& room, const RoomPart& part) {
  return room_memory(room, part) * static_cast<double>(part.seen) >= k_overlap_memory &&
         static_cast<double>(part.clipped) <= k_overlap_clipped && luminance(part.radiance) > 0;
}

// The weight of such a part: its solid angle, 1 on the horizon; 0 where it is not shown whole and unclipped.
double overlap_weight(uint32_t part, const Observation& now) {
  if (now.covered < 1 || now.clipped > 0 || !(luminance(now.colour) > k_overlap_dark)) return 0;
  const uint32_t row = part / k_room_columns;
  return sin_cos_turns((row + 0.5) / (2 * k_room_rows)).sin;
}

// What one part tells of the exposure.
void compare(Room* room, uint32_t part) {
  if (!is_remembered(*room, room->parts[part])) return;
  const Observation now =
      observe(room->view, room->images, part / k_room_columns, part % k_room_columns, k_overlap_points);
  const double weight = overlap_weight(part, now);
  if (!(weight > 0)) return;
  room->view.log_sum += weight * logarithm(luminance(room->parts[part].radiance) / luminance(now.colour));
  room->view.log_weight += weight;
}

// What one part shows, into what is known of it. A part that is clipped more than before says nothing new unless it is
// brighter; one that is clipped less says more than all that was seen before; otherwise the mean of the last images
// moves on, faster where the light has changed.
void learn(Room* room, uint32_t part) {
  const Observation now = observe(room->view, room->images, part / k_room_columns, part % k_room_columns, k_points);
  if (!(now.covered > 0)) return;
  RoomPart* known = &room->parts[part];
  const bool told = room->exposure_known && is_remembered(*room, *known);
  const double compared = told ? overlap_weight(part, now) : 0;
  const auto memory = static_cast<float>(room_memory(*room, *known));
  const auto covered = static_cast<float>(now.covered), clipped = static_cast<float>(now.clipped);
  float weight = known->weight * memory;
  weight = weight < k_weight_most ? weight : k_weight_most;
  const float seen = known->seen * memory;
  known->seen = seen > covered ? seen : covered;
  known->stamp = room->view.stamp;
  known->weight = weight + covered;
  double colour[3];
  for (int c = 0; c < 3; ++c) colour[c] = now.colour[c] * room->view.scale;
  const double before = luminance(known->radiance), after = luminance(colour);
  const bool hidden = clipped > known->clipped + k_clip_slack && after <= 1.1 * before;
  if (weight > 0 && hidden) return;
  float rate = covered / (weight + covered);
  const bool clearer = clipped < known->clipped - k_clip_slack;
  const bool changed = after > 2 * before || after < 0.5 * before;
  const float least = covered * (clearer || room->view.renews ? k_clearer_rate : changed ? k_changed_rate : 0.0f);
  rate = rate > least ? rate : least;
  for (int c = 0; c < 3; ++c) known->radiance[c] += rate * (static_cast<float>(colour[c]) - known->radiance[c]);
  known->clipped += rate * (clipped - known->clipped);
  if (compared > 0 && luminance(now.colour) > k_change_dark) {
    const double darker = logarithm(before / after);
    room->view.log_sum += compared * darker;
    room->view.log_weight += compared;
    if (__builtin_fabs(darker) > k_change) room->view.votes += darker > 0 ? compared : -compared;
  }
}

// Where the light of the room has changed, what is out of the picture has changed as much, as far as one can tell: its
// level follows, its shares stay. What is in the picture is gathered once more and believed.
bool follow_change(Room* room) {
  RoomView* view = &room->view;
  if (!room->exposure_known || view->renews || view->log_weight < k_change_least) return false;
  if (__builtin_fabs(view->votes) < k_change_share * view->log_weight) return false;
  const auto factor = static_cast<float>(exponential(-view->log_sum / view->log_weight));
  for (RoomPart& part : room->parts) {
    if (part.stamp == view->stamp) continue;  // in the picture
    for (float& c : part.radiance) c = c * factor < k_radiance_most ? c * factor : k_radiance_most;
  }
  view->renews = true;
  return true;
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

bool due(const Room& room, uint64_t time_ns) {
  if (time_ns == 0 || room.images == 0 || time_ns < room.last_ns) return true;  // no clock, or one that restarted
  return time_ns != room.last_ns && time_ns - room.last_ns >= room.interval_ns;
}

}  // namespace

void room_direction(double row, double column, double direction[3]) {
  direction_of(elevation_of(row), azimuth_of(column), direction);
}

void room_to_sphere(const Room& room, const double world[3], double sphere[3]) {
  const SinCos turn = sin_cos_turns(room.yaw);
  sphere[0] = turn.cos * world[0] + turn.sin * world[2];
  sphere[1] = world[1];
  sphere[2] = turn.cos * world[2] - turn.sin * world[0];
}

void room_place(const Room& room, const double world[3], double sphere[3]) {
  double offset[3], squared = 0;
  for (int k = 0; k < 3; ++k) {
    offset[k] = (world[k] - room.centre[k]) / room.radius;
    squared += offset[k] * offset[k];
  }
  if (squared > k_farthest * k_farthest)
    for (double& o : offset) o *= k_farthest / square_root(squared);
  room_to_sphere(room, offset, sphere);
}

double room_memory(const Room& room, const RoomPart& part) {
  const double age = static_cast<double>(room.view.stamp) - static_cast<double>(part.stamp);
  return age > 0 ? exponential(-0.6931471805599453 * age / room.half_life) : 1.0;
}

bool room_take_image(Room* room, const CameraImage& image) {
  if (room->phase != RoomPhase::idle || !due(*room, image.timestamp_ns)) return false;
  if (room->images == 0) {
    for (int k = 0; k < 3; ++k) room->centre[k] = static_cast<double>(image.position[k]);
    room->exposure_known = image.exposure > 0;
  }
  RoomView* view = &room->view;
  // Without a clock images count as `interval` apart; so do those of a clock that was set back, or of another session.
  const bool clocked = room->last_ns != 0 && image.timestamp_ns > room->last_ns;
  const uint64_t step = clocked ? image.timestamp_ns - room->last_ns : room->interval_ns;
  if (room->images != 0) view->stamp += static_cast<float>(static_cast<double>(step) * 1e-9);
  room->last_ns = image.timestamp_ns;
  view->image = with_turn(image);
  view->log_sum = view->log_weight = view->votes = 0;
  view->renews = false;
  place(*room, view);
  const bool known = room->exposure_known && image.exposure > 0;
  view->scale = known ? 1 / static_cast<double>(image.exposure) : room->scale;
  room->phase = known || room->images == 0 ? RoomPhase::gather : RoomPhase::overlap;
  room->cursor = 0;
  return true;
}

uint32_t room_units_left(const Room& room) {
  constexpr uint32_t k_units = k_room_parts / k_room_unit_parts;
  if (room.phase == RoomPhase::idle) return 0;
  return (room.phase == RoomPhase::overlap ? 2 : 1) * k_units - room.cursor / k_room_unit_parts;
}

void room_run_unit(Room* room) {
  RoomView* view = &room->view;
  static_assert(k_room_unit_parts % k_room_columns == 0);
  for (uint32_t end = room->cursor + k_room_unit_parts; room->cursor < end;) {
    const uint32_t row = room->cursor / k_room_columns;
    const SinCos elevation = elevation_of(row + 0.5);
    for (uint32_t column = 0; column < k_room_columns; ++column, ++room->cursor) {
      if (!may_be_seen(*view, elevation, column)) continue;
      if (room->phase == RoomPhase::overlap) compare(room, room->cursor);
      else learn(room, room->cursor);
    }
  }
  if (room->cursor < k_room_parts) return;
  room->cursor = 0;
  if (room->phase == RoomPhase::overlap) {
    if (view->log_weight >= k_overlap_least) {
      const double scale = exponential(view->log_sum / view->log_weight);
      view->scale = scale < 1 / k_scale_most ? 1 / k_scale_most : scale > k_scale_most ? k_scale_most : scale;
    }
    view->log_sum = view->log_weight = 0;
    room->phase = RoomPhase::gather;
    return;
  }
  if (follow_change(room)) return;
  room->scale = view->scale;
  ++room->images;
  for (const uint8_t*& plane : view->image.planes) plane = nullptr;
  room->phase = RoomPhase::idle;
}

}  // namespace sandglass
