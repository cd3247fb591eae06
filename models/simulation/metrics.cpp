// Touching pairs are found with a cell grid of edge 2r. The pile is measured in sectors and rings.
#include "models/simulation/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "models/geometry/cell_grid.h"
#include "models/work/random.h"

namespace sandglass::host {

// The least-squares line through points.
struct FittedLine {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;  // sums

  void add(double at, double value) {
    n += 1.0;
    x += at;
    y += value;
    xx += at * at;
    xy += at * value;
  }
  double determinant() const { return n * xx - x * x; }
  double slope() const { return (n * xy - x * y) / determinant(); }
};

constexpr int k_sectors = 24;
constexpr double k_runout_share = 0.98;  // of a sector's particles
// Shares of the run-out. They leave out the rounded top and the thin toe.
constexpr double k_slope_from = 0.2, k_slope_to = 0.8;

double quantile(std::span<double> values, double q) {
  if (values.empty()) return 0.0;
  const double rank = std::ceil(q * static_cast<double>(values.size())) - 1.0;
  const size_t index = static_cast<size_t>(std::clamp(rank, 0.0, static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + static_cast<ptrdiff_t>(index), values.end());
  return values[index];
}

bool tells_quantile(size_t count, double q) {
  constexpr double k_beyond = 10.0, k_rounding = 1e-6;
  return static_cast<double>(count) * (1.0 - q) >= k_beyond - k_rounding;
}

Overlap measure_overlap(std::span<const float> positions, double radius) {
  const CellGrid grid(positions, 2.0 * radius);
  const auto point = [&](uint32_t i) { return Vec3{positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]}; };
  std::vector<double> overlaps;
  for (const uint32_t i : grid.order)
    grid.near(point(i), 2.0 * radius, [&](uint32_t j) {
      if (j <= i) return;
      const double distance = length(point(j) - point(i));
      if (distance < 2.0 * radius) overlaps.push_back((2.0 * radius - distance) / radius);
    });
  Overlap result;
  result.pairs = overlaps.size();
  if (overlaps.empty()) return result;
  for (const double overlap : overlaps) {
    result.mean += overlap;
    result.max = std::max(result.max, overlap);
  }
  result.mean /= static_cast<double>(overlaps.size());
  result.p99 = quantile(overlaps, 0.99);
  return result;
}

void OverlapOverRun::add(const Overlap& overlap) {
  p99_sum += overlap.p99;
  mean_sum += overlap.mean;
  max = std::max(max, overlap.max);
  ++frames;
}

Pile measure_pile(std::span<const float> positions, double radius) {
  const size_t count = positions.size() / 3;
  Pile pile;
  if (count == 0) return pile;
  double axis_x = 0.0, axis_z = 0.0;
  for (size_t i = 0; i < count; ++i) {
    axis_x += positions[3 * i];
    axis_z += positions[3 * i + 2];
  }
  axis_x /= static_cast<double>(count);
  axis_z /= static_cast<double>(count);

  struct Item {
    double distance, top;
  };
  std::array<std::vector<Item>, k_sectors> sectors;
  for (size_t i = 0; i < count; ++i) {
    const double x = positions[3 * i] - axis_x, z = positions[3 * i + 2] - axis_z, top = positions[3 * i + 1] + radius;
    const double turn = std::atan2(z, x) / (2.0 * std::numbers::pi) + 0.5;
    const int sector = std::clamp(static_cast<int>(turn * k_sectors), 0, k_sectors - 1);
    sectors[static_cast<size_t>(sector)].push_back({std::sqrt(x * x + z * z), top});
    pile.height = std::max(pile.height, top);
  }
  int occupied = 0;
  for (const std::vector<Item>& sector : sectors) {
    std::vector<double> distances;
    for (const Item& item : sector) distances.push_back(item.distance);
    if (distances.empty()) continue;
    pile.runout += quantile(distances, k_runout_share) + radius;
    ++occupied;
  }
  pile.runout /= occupied;

  const double ring_width = 2.0 * radius;
  const int rings = static_cast<int>(pile.runout / ring_width) + 1;
  FittedLine line;
  for (int ring = 0; ring < rings; ++ring) {
    const double middle = (ring + 0.5) * ring_width;
    if (middle < k_slope_from * pile.runout || middle > k_slope_to * pile.runout) continue;
    double height_sum = 0.0;
    int seen = 0;
    for (const std::vector<Item>& sector : sectors) {
      double top = -1.0;
      for (const Item& item : sector)
        if (static_cast<int>(item.distance / ring_width) == ring) top = std::max(top, item.top);
      if (top >= 0.0) {
        height_sum += top;
        ++seen;
      }
    }
    if (seen > 0) line.add(middle, height_sum / seen);
  }
  if (line.n >= 3.0 && line.determinant() > 0.0) pile.angle_deg = std::atan(-line.slope()) * 180.0 / std::numbers::pi;
  return pile;
}

Evenness measure_evenness(std::span<const float> particles, std::span<const float> grains, double radius,
                          double grain_radius, uint64_t seed) {
  constexpr uint32_t k_spheres = 2000, k_fewest = 200, k_tries = 200'000;
  constexpr uint32_t k_all_octants = 255;
  const double probe = 0.7 * radius, about = 3.0 * radius;
  const CellGrid solid(particles, about), fine(grains, probe);
  const uint32_t count = static_cast<uint32_t>(particles.size() / 3);
  Random random = {seed};
  double sum = 0.0, squares = 0.0;
  Evenness even;
  for (uint32_t tries = 0; count > 0 && even.spheres < k_spheres && tries < k_tries; ++tries) {
    Vec3 at = from_floats(&particles[3 * size_t{random.below(count)}]);
    for (double* coordinate : {&at.x, &at.y, &at.z}) *coordinate += radius * (2.0 * random.uniform() - 1.0);
    uint32_t octants = 0, number = 0;
    within(solid, particles, at, about, [&](uint32_t i, double) {
      const float* p = &particles[3 * size_t{i}];
      octants |= 1u << ((p[0] > at.x) + 2 * (p[1] > at.y) + 4 * (p[2] > at.z));
    });
    if (octants != k_all_octants) continue;
    within(fine, grains, at, probe, [&](uint32_t, double) { ++number; });
    sum += number;
    squares += static_cast<double>(number) * number;
    ++even.spheres;
  }
  if (even.spheres < k_fewest || sum == 0.0) return even;
  even.variation = std::sqrt(squares / sum - sum / even.spheres);
  std::vector<double> nearest;
  for (uint32_t i = 0; i < grains.size() / 3; ++i) {
    double squared_min = probe * probe;
    within(fine, grains, from_floats(&grains[3 * size_t{i}]), probe, [&](uint32_t j, double squared) {
      if (j != i) squared_min = std::min(squared_min, squared);
    });
    nearest.push_back(std::sqrt(squared_min) / grain_radius);
  }
  even.nearest = quantile(nearest, 0.5);
  return even;
}

double speed_rms(std::span<const float> velocities) {
  double sum = 0.0;
  for (const float v : velocities) sum += static_cast<double>(v) * static_cast<double>(v);
  return velocities.empty() ? 0.0 : std::sqrt(sum * 3.0 / static_cast<double>(velocities.size()));
}

double fitted_exponent(std::span<const double> x, std::span<const double> y) {
  FittedLine line;
  for (size_t i = 0; i < x.size() && i < y.size(); ++i) line.add(std::log(x[i]), std::log(y[i]));
  return line.slope();
}

}  // namespace sandglass::host
