#include "tests/laboratory/room/balls.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sandglass::host {

namespace {

constexpr int k_across = 32, k_width = 64, k_height = 32;
constexpr double k_silver = 32.0;  // exponent of the lobe about the mirrored ray

RadianceMap coarse(const RadianceMap& panorama) {
  constexpr int k_fine = 4;
  RadianceMap map(k_width, k_height);
  for (int v = 0; v < k_height; ++v)
    for (int u = 0; u < k_width; ++u) {
      Vec3 sum;
      for (int k = 0; k < k_fine * k_fine; ++k)
        sum = sum + look_up(panorama, panorama_direction(u + (k % k_fine + 0.5) / k_fine - 0.5,
                                                         v + (k / k_fine + 0.5) / k_fine - 0.5, k_width, k_height));
      map.set(u, v, sum * (1.0 / (k_fine * k_fine)));
    }
  return map;
}

RadianceMap known_map(const SeenRoom& seen, double azimuth, bool mirrored) {
  float parts[k_room_parts][3];
  room_radiance(seen.room, k_room_model, parts);
  return panorama_of(k_width, k_height, [&](Vec3 d) {
    const double around = std::atan2(d.z, d.x), seen_at = mirrored ? 2 * azimuth - around : around;
    return from_floats(parts[part_at(seen_at / (2 * std::numbers::pi) - seen.room.yaw, d.y)]) * (1.0 / seen.exposure);
  });
}

// What the pixels of each ball show, seen from the azimuth's other side.
std::array<std::vector<Vec3>, 3> balls_in(const RadianceMap& map, double azimuth) {
  const Vec3 forward = {std::cos(azimuth), 0, std::sin(azimuth)}, right = {-std::sin(azimuth), 0, std::cos(azimuth)};
  std::array<std::vector<Vec3>, 3> balls;
  for (int i = 0; i < k_across * k_across; ++i) {
    const double x = 2 * (i % k_across + 0.5) / k_across - 1, y = 1 - 2 * (i / k_across + 0.5) / k_across;
    const double depth = 1 - x * x - y * y;
    if (depth <= 0) continue;
    const Vec3 normal = right * x + Vec3{0, y, 0} - forward * std::sqrt(depth);
    const Vec3 reflected = forward - normal * (2 * dot(normal, forward));
    Vec3 silver, diffuse;
    double lobe = 0;
    for (int v = 0; v < k_height; ++v) {
      const double area = pixel_solid_angle(v, k_width, k_height);
      for (int u = 0; u < k_width; ++u) {
        const Vec3 d = panorama_direction(u, v, k_width, k_height);
        const double weight = area * std::pow(std::max(dot(d, reflected), 0.0), k_silver);
        silver = silver + map.colour(u, v) * weight;
        lobe += weight;
        diffuse = diffuse + map.colour(u, v) * (area * std::max(dot(d, normal), 0.0));
      }
    }
    balls[0].push_back(look_up(map, reflected));
    balls[1].push_back(silver * (1 / lobe));
    balls[2].push_back(diffuse * (1 / std::numbers::pi));
  }
  return balls;
}

BallErrors errors_of(const std::vector<Vec3>& truth, const std::vector<Vec3>& shown) {
  double squares = 0, products = 0, own = 0, error = 0, angles = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    squares += dot(truth[i], truth[i]);
    products += dot(truth[i], shown[i]);
    own += dot(shown[i], shown[i]);
    error += dot(truth[i] - shown[i], truth[i] - shown[i]);
    angles += std::atan2(length(cross(truth[i], shown[i])), dot(truth[i], shown[i]));
  }
  const double best = squares - products * products / std::max(own, 1e-30);  // by the best factor
  return {std::sqrt(error / squares), std::sqrt(std::max(best, 0.0) / squares),
          angles / static_cast<double>(truth.size()) * 180.0 / std::numbers::pi};
}

}  // namespace

ThreeBalls ball_errors(const RadianceMap& panorama, const SeenRoom& seen, double azimuth, bool mirrored) {
  const auto truth = balls_in(coarse(panorama), azimuth), shown = balls_in(known_map(seen, azimuth, mirrored), azimuth);
  ThreeBalls errors;
  for (size_t ball = 0; ball < errors.size(); ++ball) errors[ball] = errors_of(truth[ball], shown[ball]);
  return errors;
}

}  // namespace sandglass::host
