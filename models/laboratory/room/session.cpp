#include "models/laboratory/room/session.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/files/image.h"
#include "models/rooms/excerpt.h"
#include "runtime/core/random.h"
#include "sandglass/light.h"

namespace sandglass::host {

namespace {

constexpr int k_width = 90, k_height = 120;  // pixels; enough for parts of 11 degrees
constexpr double k_diagonal_deg = 75.0;
constexpr double k_key = 0.2;       // the mean of a picture that the camera exposed by itself
constexpr double k_sway_deg = 4.0;  // of a hand, standard deviation
constexpr double k_short = 1.0 / 64;
constexpr uint64_t k_sway_stream = 97;

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

// The camera's axes in the panorama's frame: right, up, backwards.
struct Axes {
  Vec3 right, up, back;
};

Axes axes_of(double azimuth, const SessionImage& image) {
  // A turn to the left, seen from above, takes +x to -z: it lowers the azimuth that runs from +x to +z.
  const double around = azimuth - radians(image.yaw_deg), above = radians(image.pitch_deg);
  const Vec3 ahead = {std::cos(above) * std::cos(around), std::sin(above), std::cos(above) * std::sin(around)};
  const Vec3 level = {-std::sin(around), 0, std::cos(around)};  // to the right of a level camera
  return {level, cross(level, ahead), ahead * -1.0};
}

void quaternion_of(const Axes& a, float q[4]) {
  // Columns of the rotation are the axes.
  const float matrix[16] = {static_cast<float>(a.right.x),
                            static_cast<float>(a.right.y),
                            static_cast<float>(a.right.z),
                            0,
                            static_cast<float>(a.up.x),
                            static_cast<float>(a.up.y),
                            static_cast<float>(a.up.z),
                            0,
                            static_cast<float>(a.back.x),
                            static_cast<float>(a.back.y),
                            static_cast<float>(a.back.z),
                            0,
                            0,
                            0,
                            0,
                            1};
  (void)sandglass_camera_orientation(matrix, q);
}

// The exposure by which the picture's mean luminance, clipped pixels and all, is the key.
double exposed_by_itself(const RadianceMap& view) {
  double low = 1e-6, high = 1e6;
  for (int step = 0; step < 40; ++step) {
    const double middle = std::sqrt(low * high);
    double sum = 0;
    int count = 0;
    for (int v = 0; v < view.height; v += 3)
      for (int u = 0; u < view.width; u += 3, ++count) sum += std::min(1.0, luminance(view.colour(u, v)) * middle);
    (sum / count < k_key ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

}  // namespace

const char* session_name(Session session) {
  constexpr const char* k_names[] = {"nothing seen",
                                     "one image of a table",
                                     "the table from all sides",
                                     "table, 60 degrees aside and a glance up",
                                     "a full turn",
                                     "a full turn, some images short",
                                     "everything, some images short"};
  return k_names[static_cast<int>(session)];
}

std::vector<SessionImage> session_images(Session session, uint64_t seed) {
  std::vector<SessionImage> images;
  const auto add = [&](double yaw, double pitch, double exposure = 1.0) { images.push_back({yaw, pitch, exposure}); };
  switch (session) {
    case Session::nothing:
      break;
    case Session::table:
      add(0, -35);
      break;
    case Session::around_table:
      for (int i = 0; i < 18; ++i) add(20.0 * i - 180.0, -35);
      break;
    case Session::glance:
      for (int i = 0; i <= 6; ++i) add(20.0 * i - 60.0, -35);
      for (int i = 0; i <= 6; ++i) add(60.0 - 20.0 * i, i % 2 == 0 ? 0.0 : 15.0);
      break;
    case Session::full_turn:
    case Session::full_turn_short:
      for (int i = 0; i < 24; ++i)
        add(15.0 * i, i % 2 == 0 ? 0.0 : 20.0, session == Session::full_turn_short && i % 4 == 1 ? k_short : 1.0);
      break;
    case Session::everything:
      for (int ring = 0; ring < 4; ++ring)
        for (int i = 0; i < 12; ++i) {
          const double pitch[4] = {-40, 0, 40, 80};
          add(30.0 * i, pitch[ring]), add(30.0 * i, pitch[ring], k_short);
        }
      break;
  }
  Random random = random_stream(seed, k_sway_stream);
  for (SessionImage& image : images) {
    const auto sway = [&random] {
      const double a = std::sqrt(-2.0 * std::log(1.0 - random.uniform()));
      return k_sway_deg * a * std::cos(2.0 * std::numbers::pi * random.uniform());
    };
    image.yaw_deg += sway();
    image.pitch_deg = std::clamp(image.pitch_deg + sway(), -85.0, 85.0);
  }
  return images;
}

namespace {

// What a camera sees that is turned in this way, and what it makes of it.
struct Shot {
  Picture picture;
  double exposure;
  sandglass_camera_image image;  // refers to the picture
};

Shot take(const RadianceMap& panorama, const Axes& axes, int width, int height, double exposure_factor) {
  const double focal = focal_length(width, height, k_diagonal_deg);
  RadianceMap view(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      view.set(u, v,
               look_up(panorama, axes.right * ((u - 0.5 * (width - 1)) / focal) +
                                     axes.up * ((0.5 * (height - 1) - v) / focal) - axes.back));
  Shot shot = {Picture(width, height, {0, 0, 0}), exposed_by_itself(view) * exposure_factor, {}};
  for (size_t i = 0; i < view.rgb.size(); ++i)
    shot.picture.rgb[i] = srgb_byte(std::min(1.0, static_cast<double>(view.rgb[i]) * shot.exposure));
  shot.image = camera_image_of(shot.picture, k_diagonal_deg);
  quaternion_of(axes, shot.image.orientation);
  return shot;
}

}  // namespace

SeenRoom look_around(const RadianceMap& panorama, Session session, const SessionOptions& options) {
  SeenRoom seen = {};
  Room* room = &seen.room;
  room->radius = 1.0, room->half_life = 1e6, room->interval_ns = 0;
  room_reset(room);
  uint64_t time_ns = 0;
  for (const SessionImage& image : session_images(session, options.seed)) {
    Shot shot = take(panorama, axes_of(options.azimuth, image), k_width, k_height, image.exposure);
    shot.image.timestamp_ns = time_ns += 100'000'000;
    shot.image.exposure = options.exposure_known ? static_cast<float>(shot.exposure) : 0.0f;
    (void)room_take_image(room, shot.image);
    while (room->phase != RoomPhase::idle) room_run_unit(room);
    seen.exposure = shot.exposure;
  }
  if (session == Session::nothing) {
    const SessionImage first = session_images(Session::table, options.seed).front();
    seen.exposure = take(panorama, axes_of(options.azimuth, first), k_width, k_height, 1.0).exposure;
  }
  return seen;
}

PartRadiance true_parts(const RadianceMap& panorama) {
  PartRadiance sums = {};
  std::array<double, k_room_parts> areas = {};
  for (int v = 0; v < panorama.height; ++v) {
    const double area = pixel_solid_angle(v, panorama.width, panorama.height);
    for (int u = 0; u < panorama.width; ++u) {
      const Vec3 d = panorama_direction(u, v, panorama.width, panorama.height);
      const double turns = std::atan2(d.z, d.x) / (2 * std::numbers::pi);
      const auto column = static_cast<uint32_t>((turns - std::floor(turns)) * k_room_columns) % k_room_columns;
      const double height = std::asin(std::clamp(d.y, -1.0, 1.0)) / std::numbers::pi + 0.5;
      const uint32_t row = std::min(static_cast<uint32_t>(height * k_room_rows), k_room_rows - 1);
      sums[row * k_room_columns + column] = sums[row * k_room_columns + column] + panorama.colour(u, v) * area;
      areas[row * k_room_columns + column] += area;
    }
  }
  for (uint32_t i = 0; i < k_room_parts; ++i) sums[i] = sums[i] * (1 / std::max(areas[i], 1e-12));
  return sums;
}

Room with_known(const SeenRoom& seen, const PartRadiance& truth, Known known) {
  Room room = seen.room;
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    RoomPart& part = room.parts[i];
    const Vec3 there = truth[i] * (seen.exposure * room.scale);  // in the room's scale
    const double colour[3] = {there.x, there.y, there.z};
    const bool clipped = known == Known::clipped_light && part.clipped > 0;
    const float share = known == Known::unseen_parts ? 1 - part.seen : clipped ? 1.0f : 0.0f;
    for (int c = 0; c < 3; ++c) part.radiance[c] += share * (static_cast<float>(colour[c]) - part.radiance[c]);
    part.clipped *= 1 - share;
    if (known == Known::unseen_parts) part.seen = 1, part.stamp = room.view.stamp;
  }
  return room;
}

sandglass_light_estimate estimate_of_table(const RadianceMap& panorama, const SessionOptions& options,
                                           RoomLight* network) {
  const SessionImage image = session_images(Session::table, options.seed).front();
  const Shot shot = take(panorama, axes_of(options.azimuth, image), 4 * k_width, 4 * k_height, image.exposure);
  return network->estimate(shot.image);
}

}  // namespace sandglass::host
