#include "tests/laboratory/shot/traced_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/compositing/shot_light.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/room.h"
#include "models/rooms/room_render.h"

namespace sandglass::host {

Warped warped_beside_traced(uint64_t seed, uint32_t threads) {
  constexpr uint64_t k_rooms = 8, k_first = 7000;
  constexpr double k_radius = 3.0, k_above_floor = 0.02, k_from_walls = 0.3;  // metres
  Warped sums;
  double places = 0;
  for (uint64_t i = 0; i < k_rooms; ++i) {
    Room room = make_room(k_first + k_rooms * seed + i);
    RoomRenderOptions rendering;
    rendering.width = 256;
    rendering.samples = 24;
    rendering.threads = threads;
    const RadianceMap panorama = trace_room(room, rendering).radiance;
    const Vec3 eye = room.eye;
    for (int k = 0; k < 3; ++k) {
      const double azimuth = 2.0 * std::numbers::pi * (k / 3.0 + 0.1 * static_cast<double>(i)), away = 0.8 + 0.4 * k;
      room.eye = {eye.x + away * std::cos(azimuth), k_above_floor, eye.z + away * std::sin(azimuth)};
      if (std::min({room.eye.x, room.eye.z, room.size.x - room.eye.x, room.size.z - room.eye.z}) < k_from_walls)
        continue;
      const auto level = [](const RadianceMap& map, View view) {
        return luminance(irradiance_of(light_of(map, view)));
      };
      constexpr View k_ahead = {0.5 * std::numbers::pi, 0.5 * std::numbers::pi};
      const double traced = level(trace_room(room, rendering).radiance, k_ahead);
      const auto seen_from = [&](Vec3 place) {
        const View view = {std::acos(place.y / length(place)), std::atan2(place.z, place.x)};
        return level(warp(panorama, view, std::min(length(place), k_farthest_insertion), 256, 128), view);
      };
      const Vec3 foot = (room.eye - eye) * (1.0 / k_radius);
      if (!(traced > 0)) continue;
      sums.to_foot += std::fabs(std::log(seen_from(foot) / traced));
      sums.to_level += std::fabs(std::log(seen_from({foot.x, 0, foot.z}) / traced));
      ++places;
    }
  }
  return {sums.to_foot / places, sums.to_level / places};
}

}  // namespace sandglass::host
