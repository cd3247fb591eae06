#include "tests/laboratory/shot/traced_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/compositing/shot_light.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/room.h"
#include "models/rooms/room_render.h"

namespace sandglass::host {

namespace {

Warped::Errors apart(const ShotLight& told, const ShotLight& traced) {
  Warped::Errors errors;
  errors.level = std::fabs(std::log(luminance(irradiance_of(told)) / luminance(irradiance_of(traced))));
  for (size_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i)
    errors.shares += std::fabs(static_cast<double>(told.cells[i] - traced.cells[i]));
  return errors;
}

}  // namespace

Warped warped_beside_traced(uint64_t seed, uint32_t threads) {
  constexpr uint64_t k_rooms = 16, k_first = 7000;
  constexpr int k_width = 128, k_height = 64, k_samples = 24;
  constexpr double k_radius = 3.0, k_above_floor = 0.02, k_from_walls = 0.3;  // metres
  Warped sums;
  double places = 0;
  for (uint64_t i = 0; i < k_rooms; ++i) {
    Room room = make_room(k_first + k_rooms * seed + i);
    const Vec3 eye = room.eye;
    const RadianceMap panorama = trace_room(room, {k_width, k_samples, threads}).radiance;
    for (int k = 0; k < 3; ++k) {
      const double azimuth = 2.0 * std::numbers::pi * (k / 3.0 + 0.1 * static_cast<double>(i)), away = 0.8 + 0.4 * k;
      room.eye = {eye.x + away * std::cos(azimuth), k_above_floor, eye.z + away * std::sin(azimuth)};
      if (std::min({room.eye.x, room.eye.z, room.size.x - room.eye.x, room.size.z - room.eye.z}) < k_from_walls)
        continue;
      constexpr View k_ahead = {0.5 * std::numbers::pi, 0.5 * std::numbers::pi};
      const ShotLight traced = light_of(trace_room(room, {k_width, k_samples, threads}).radiance, k_ahead);
      if (!(luminance(irradiance_of(traced)) > 0)) continue;  // under a cupboard
      const auto told_from = [&](Vec3 place) {
        const View view = {std::acos(place.y / length(place)), std::atan2(place.z, place.x)};
        return light_of(warp(panorama, view, std::min(length(place), k_farthest_insertion), k_width, k_height), view);
      };
      const Vec3 foot = (room.eye - eye) * (1.0 / k_radius);
      for (const auto& [errors, place] : {std::pair(&sums.foot, foot), std::pair(&sums.eye, Vec3{foot.x, 0, foot.z})}) {
        const Warped::Errors here = apart(told_from(place), traced);
        errors->level += here.level;
        errors->shares += here.shares;
      }
      ++places;
    }
  }
  for (Warped::Errors* errors : {&sums.foot, &sums.eye}) {
    errors->level /= places;
    errors->shares /= places;
  }
  return sums;
}

}  // namespace sandglass::host
