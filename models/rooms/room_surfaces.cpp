// The look of surfaces and skies. Patterns come from hashed cells, so a point and a seed are all that they need.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/rooms/panorama.h"
#include "models/rooms/room.h"
#include "runtime/math/random.h"

namespace sandglass::host {

namespace {

constexpr double k_joint = 0.035;          // the width of joints between tiles and bricks, in cells
constexpr double k_plank_length = 9.0;     // in widths of a plank
constexpr double k_skyline_steps = 90.0;   // buildings around the horizon
constexpr double k_skyline_height = 0.35;  // tangent of the tallest building's elevation

double cell_random(int64_t i, int64_t j, uint64_t salt) {
  const uint64_t bits = mix_bits(mix_bits(static_cast<uint64_t>(i) * 0x9E3779B97F4A7C15ull + salt) +
                                 static_cast<uint64_t>(j) * 0xC2B2AE3D27D4EB4Full);
  return static_cast<double>(bits >> 11) * 0x1p-53;
}

int64_t cell(double x) { return static_cast<int64_t>(std::floor(x)); }

double smooth_noise(double x, double y, uint64_t salt) {
  const int64_t i = cell(x), j = cell(y);
  const auto ease = [](double t) { return t * t * (3.0 - 2.0 * t); };
  const double fx = ease(x - static_cast<double>(i)), fy = ease(y - static_cast<double>(j));
  const double low = cell_random(i, j, salt) * (1 - fx) + cell_random(i + 1, j, salt) * fx;
  const double high = cell_random(i, j + 1, salt) * (1 - fx) + cell_random(i + 1, j + 1, salt) * fx;
  return low * (1 - fy) + high * fy;
}

Vec3 mixed(Vec3 a, Vec3 b, double t) { return a * (1.0 - t) + b * t; }

// The share of the second colour that a pattern shows at (x, y). Both are in cells.
double second_share(Pattern pattern, double x, double y) {
  const double in_x = x - std::floor(x), in_y = y - std::floor(y);
  switch (pattern) {
    case Pattern::plain:
      return 0.0;
    case Pattern::checker:
      return static_cast<double>((cell(x) + cell(y)) & 1);
    case Pattern::tiles:
      return in_x < k_joint || in_y < k_joint ? 1.0 : 0.25 * cell_random(cell(x), cell(y), 1);
    case Pattern::stripes:
      return in_x < 0.5 ? 0.0 : 1.0;
    case Pattern::planks: {
      const int64_t row = cell(x);
      const double along = y / k_plank_length + cell_random(row, 0, 2);
      const double grain = smooth_noise(6.0 * x, 0.7 * y, 3);
      return in_x < k_joint ? 1.0 : 0.6 * cell_random(row, cell(along), 4) + 0.3 * grain;
    }
    case Pattern::bricks: {
      const int64_t row = cell(2.0 * y);
      const double shifted = x + 0.5 * static_cast<double>(row & 1), in_row = 2.0 * y - static_cast<double>(row);
      if (shifted - std::floor(shifted) < k_joint || in_row < 2.0 * k_joint) return 1.0;
      return 0.3 * cell_random(row, cell(shifted), 5);
    }
    case Pattern::blotches:
      return 0.6 * smooth_noise(x, y, 6) + 0.4 * smooth_noise(3.1 * x, 3.1 * y, 7);
    case Pattern::mosaic:
      return cell_random(cell(x), cell(y), 8);
  }
  return 0.0;
}

}  // namespace

Vec3 reflectance(const RoomMaterial& material, Vec3 p, Vec3 n) {
  if (material.pattern == Pattern::plain) return material.colour;
  const double ax = std::fabs(n.x), ay = std::fabs(n.y), az = std::fabs(n.z);
  const bool level = ay >= ax && ay >= az;
  const double across = level ? p.x : ax > az ? p.z : p.x, along = level ? p.z : p.y;
  const double share = second_share(material.pattern, across / material.scale, along / material.scale);
  return mixed(material.colour, material.second, share);
}

Vec3 sky_radiance(const Sky& sky, Vec3 d) {
  if (d.y <= 0.0) return sky.ground;
  const double level = std::sqrt(d.x * d.x + d.z * d.z);
  const double turn = (std::atan2(d.z, d.x) / (2.0 * std::numbers::pi) + 0.5) * k_skyline_steps;
  const double tall = cell_random(cell(turn), 0, sky.skyline_seed);
  if (d.y < k_skyline_height * tall * tall * level) return sky.skyline * (0.6 + 0.8 * cell_random(cell(turn), 1, 9));
  return mixed(sky.horizon, sky.zenith, std::sqrt(d.y));
}

}  // namespace sandglass::host
