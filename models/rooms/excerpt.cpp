#include "models/rooms/excerpt.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/work/random.h"

namespace sandglass::host {

namespace {

constexpr double k_pi = std::numbers::pi;
constexpr uint64_t k_view_stream = 21;
constexpr double k_separation = 10.0 * k_pi / 180.0;
constexpr double k_depth_range = 10.0;  // metres

}  // namespace

std::array<View, k_excerpts> choose_views(uint64_t seed) {
  Random random = random_stream(seed, k_view_stream);
  std::array<View, k_excerpts> views = {};
  for (size_t i = 0; i < views.size();) {
    const View view = {k_pi / 2.0 + k_pi / 12.0 * normal_deviate(&random), k_pi * (2.0 * random.uniform() - 0.5)};
    if (view.theta < k_pi / 3.0 || view.theta > 2.0 * k_pi / 3.0) continue;
    bool separate = true;
    for (size_t j = 0; j < i; ++j) {
      const double turn = std::remainder(view.phi - views[j].phi, 2.0 * k_pi), tilt = view.theta - views[j].theta;
      separate = separate && std::sqrt(turn * turn + tilt * tilt) >= k_separation;
    }
    if (separate) views[i++] = view;
  }
  return views;
}

ViewRotation::ViewRotation(View view) {
  const double tilt = view.theta - k_pi / 2.0, turn = view.phi - k_pi / 2.0;
  const double ct = std::cos(tilt), st = std::sin(tilt), cp = std::cos(turn), sp = std::sin(turn);
  columns[0] = {cp, 0.0, sp};
  columns[1] = {-sp * st, ct, cp * st};
  columns[2] = {-sp * ct, -st, cp * ct};
}

double focal_length(int width, int height, double diagonal_fov_deg) {
  return 0.5 * std::sqrt(static_cast<double>(width) * width + static_cast<double>(height) * height) /
         std::tan(diagonal_fov_deg * k_pi / 360.0);
}

static Vec3 pixel_ray(int x, int y, int width, int height, double focal) {
  return {(x - 0.5 * (width - 1)) / focal, (y - 0.5 * (height - 1)) / focal, 1.0};
}

RadianceMap cut_excerpt(const RadianceMap& panorama, View view, int width, int height, double diagonal_fov_deg) {
  const ViewRotation rotation(view);
  const double focal = focal_length(width, height, diagonal_fov_deg);
  RadianceMap excerpt(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Vec3 ray = camera_to_rotated(pixel_ray(x, y, width, height, focal));
      excerpt.set(x, y, look_up(panorama, rotation.to_panorama(ray)));
    }
  return excerpt;
}

double insertion_radius(std::span<const float> depth, int depth_width, View view) {
  if (depth.empty()) return k_unknown_depth_insertion;
  const int depth_height = static_cast<int>(depth.size()) / depth_width;
  const ViewRotation rotation(view);
  const double focal = focal_length(k_excerpt_width, k_excerpt_height, k_excerpt_fov_deg);
  double greatest = 0.0;
  for (int y = 0; y < k_excerpt_height; ++y)
    for (int x = 0; x < k_excerpt_width; ++x) {
      const Vec3 ray = camera_to_rotated(pixel_ray(x, y, k_excerpt_width, k_excerpt_height, focal));
      const PanoramaPlace place = panorama_place(rotation.to_panorama(ray), depth_width, depth_height);
      const int u = static_cast<int>(std::lround(place.u)) % depth_width;
      const int v = std::clamp(static_cast<int>(std::lround(place.v)), 0, depth_height - 1);
      greatest = std::max(greatest, static_cast<double>(depth[static_cast<size_t>(v * depth_width + std::max(u, 0))]));
    }
  return std::clamp(1.0 - greatest / k_depth_range, 0.0, k_farthest_insertion);
}

RadianceMap warp(const RadianceMap& panorama, View view, double radius, int width, int height) {
  constexpr int k_places = 2;  // samples along each side of a pixel
  const ViewRotation rotation(view);
  const Vec3 centre = view.direction() * radius;
  const double inside = 1.0 - radius * radius;
  // A direction is a product of one term for its row and one for its column. So sines are taken once a row and once a
  // column.
  const auto at = [](int i) { return i / k_places + (i % k_places + 0.5) / k_places - 0.5; };
  std::vector<Vec3> columns(static_cast<size_t>(width) * k_places), rows(static_cast<size_t>(height) * k_places);
  for (size_t i = 0; i < columns.size(); ++i)
    columns[i] = panorama_direction(at(static_cast<int>(i)), 0.5 * (height - 1), width, height);
  for (size_t i = 0; i < rows.size(); ++i)
    rows[i] = panorama_direction(0.25 * width - 0.5, at(static_cast<int>(i)), width, height);
  RadianceMap warped(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      Vec3 sum;
      for (int i = 0; i < k_places * k_places; ++i) {
        const Vec3 column = columns[static_cast<size_t>(u * k_places + i % k_places)],
                   row = rows[static_cast<size_t>(v * k_places + i / k_places)];
        const Vec3 d = rotation.to_panorama({column.x * row.x, row.y, column.z * row.x});
        const double along = dot(d, centre);
        sum = sum + look_up(panorama, centre + d * (std::sqrt(along * along + inside) - along));
      }
      warped.set(u, v, sum * (1.0 / (k_places * k_places)));
    }
  return warped;
}

RadianceMap above_horizon(const RadianceMap& panorama, View view) {
  const ViewRotation rotation(view);
  RadianceMap above = panorama;
  for (int v = 0; v < above.height; ++v)
    for (int u = 0; u < above.width; ++u)
      if (!(rotation.to_panorama(panorama_direction(u, v, above.width, above.height)).y > 0.0)) above.set(u, v, {});
  return above;
}

}  // namespace sandglass::host
