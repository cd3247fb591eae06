#include "tests/laboratory/room/session.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sandglass::host {

SeenRoom look_around(const RadianceMap& panorama, Session session, const SessionOptions& options) {
  SeenRoom seen = {};
  Room* room = &seen.room;
  room->given_radius = 1.0;
  room->half_life = 1e6;
  room->interval_ns = 0;
  if (options.reflections) {
    seen.texels = std::make_shared<std::vector<RoomTexel>>(k_cube_texels);
    room->texels = seen.texels->data();
  }
  room_reset(room);
  if (!options.guarded) room->tells_from = 0;
  uint64_t time_ns = 0;
  for (const SessionImage& image : session_images(session, options.seed)) {
    PhoneImage shot = take_image(panorama, session_camera(options.azimuth, image), k_session_width, k_session_height,
                                 std::max(image.exposure, options.shortest));
    shot.image.timestamp_ns = time_ns += 100'000'000;
    shot.image.exposure = options.exposure_known ? static_cast<float>(shot.exposure) : 0.0f;
    if (!room_take_image(room, shot.image)) continue;
    while (room->phase != RoomPhase::idle) room_run_unit(room);
    // A short image for lamps is not the last one that the light is in the scale of.
    if (options.exposure_known) seen.exposure = 1 / room->scale;
    else if (room->view.lesson != RoomLesson::nothing) seen.exposure = shot.exposure;
  }
  if (session == Session::nothing) {
    const SessionImage first = session_images(Session::table, options.seed).front();
    const ShotCamera camera = session_camera(options.azimuth, first);
    seen.exposure = take_image(panorama, camera, k_session_width, k_session_height).exposure;
  }
  return seen;
}

ShotLight light_of_session(const Surroundings& room, Session session, const SessionOptions& options,
                           const sandglass_estimator_light* estimate) {
  const SeenRoom seen = look_around(room.panorama, session, options);
  sandglass_room_place at;
  sandglass_room_place_default(&at);
  to_floats(room.foot, at.position);
  at.network = estimate;
  ShotLight light = {};
  light.struct_size = sizeof light;
  room_estimate(seen.room, k_room_model, at, &light);
  return scaled(light, room.exposure / seen.exposure);
}

uint32_t part_at(double turns, double up) {
  const auto column = static_cast<uint32_t>((turns - std::floor(turns)) * k_room_columns) % k_room_columns;
  const double height = std::asin(std::clamp(up, -1.0, 1.0)) / std::numbers::pi + 0.5;
  return std::min(static_cast<uint32_t>(height * k_room_rows), k_room_rows - 1) * k_room_columns + column;
}

PartRadiance true_parts(const RadianceMap& panorama) {
  PartRadiance sums = {};
  std::array<double, k_room_parts> areas = {};
  for (int v = 0; v < panorama.height; ++v) {
    const double area = pixel_solid_angle(v, panorama.width, panorama.height);
    for (int u = 0; u < panorama.width; ++u) {
      const Vec3 d = panorama_direction(u, v, panorama.width, panorama.height);
      const uint32_t part = part_at(std::atan2(d.z, d.x) / (2 * std::numbers::pi), d.y);
      sums[part] = sums[part] + panorama.colour(u, v) * area;
      areas[part] += area;
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
    const double share = known == Known::unseen_parts ? 1 - part.seen : clipped ? 1.0 : 0.0;
    for (int c = 0; c < 3; ++c)
      part.radiance[c] += static_cast<float>(share * (colour[c] - static_cast<double>(part.radiance[c])));
    part.clipped = part.clipped * (1 - share);
    if (known == Known::unseen_parts) {
      part.seen = 1;
      part.age = 0;
    }
  }
  return room;
}

sandglass_estimator_light estimate_of_table(const RadianceMap& panorama, const SessionOptions& options,
                                            RoomLight* network) {
  const SessionImage image = session_images(Session::table, options.seed).front();
  const PhoneImage shot = take_image(panorama, session_camera(options.azimuth, image), 4 * k_session_width,
                                     4 * k_session_height, image.exposure);
  return network->estimate(shot.image);
}

}  // namespace sandglass::host
