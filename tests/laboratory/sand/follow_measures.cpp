// Neighbours come from the cell grid, and cells of 4 r from a table of those that hold something.
#include "tests/laboratory/sand/follow_measures.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "models/geometry/cell_grid.h"
#include "models/simulation/metrics.h"
#include "models/work/random.h"

namespace sandglass::host {

namespace {

using Points = std::span<const float>;

Vec3 point(Points points, size_t i) { return from_floats(&points[3 * i]); }
size_t count(Points points) { return points.size() / 3; }
double share(Points points) { return 1.0 / static_cast<double>(count(points)); }  // of the sand that one of them is

// The share of b that is in another cell than a, from 0 to 1.
double share_in_wrong_cell(Points a, Points b, double edge) {
  constexpr int k_origins = 4;
  constexpr double k_off = 0.5;  // of the way to the next origin: cells do not end at r, where a first layer lies
  double wrong = 0.0;
  for (int origin = 0; origin < k_origins; ++origin) {
    const auto cell = [&](Vec3 p) {
      int64_t key = 0;
      for (const double x : {p.x, p.y, p.z})
        key = key << 21 | (static_cast<int64_t>(std::floor(x / edge + (origin + k_off) / k_origins)) & 0x1fffff);
      return key;
    };
    std::unordered_map<int64_t, double> excess;
    for (size_t i = 0; i < count(a); ++i) excess[cell(point(a, i))] += share(a);
    for (size_t i = 0; i < count(b); ++i) excess[cell(point(b, i))] -= share(b);
    for (const auto& [key, more] : excess) wrong += std::fabs(more) / (2.0 * k_origins);
  }
  return wrong;
}

// As many grains as there are, each at random in the ball of 1 r about its particle.
std::vector<float> in_balls(Points particles, size_t grains, double radius, uint64_t seed) {
  Random random = {seed};
  std::vector<float> points(3 * grains);
  for (size_t i = 0; i < grains; ++i) {
    Vec3 at;
    do
      for (double* coordinate : {&at.x, &at.y, &at.z}) *coordinate = 2.0 * random.uniform() - 1.0;
    while (dot(at, at) > 1.0);
    to_floats(point(particles, i * count(particles) / grains) + at * radius, &points[3 * i]);
  }
  return points;
}

std::vector<double> distances_from(Vec3 axis, Points points) {
  std::vector<double> distances;
  for (size_t i = 0; i < count(points); ++i)
    distances.push_back(std::hypot(point(points, i).x - axis.x, point(points, i).z - axis.z));
  return distances;
}

}  // namespace

Placement measure_placement(Points particles, Points grains, double radius, uint64_t seed) {
  const double reach = 1.5 * radius, edge = 4.0 * radius;
  const size_t n = count(particles), m = count(grains);
  Placement placed;
  if (n == 0 || m == 0) return placed;
  const CellGrid solid(particles, reach), fine(grains, reach);
  for (size_t i = 0; i < m; ++i) {
    bool held = false;
    within(solid, particles, point(grains, i), reach, [&](uint32_t, double) { held = true; });
    placed.beyond += held ? 0.0 : 100.0 * share(grains);
  }
  std::vector<uint32_t> numbers(n);
  Vec3 axis;
  double mean = 0.0;
  for (size_t i = 0; i < n; ++i) {
    axis = axis + point(particles, i) * share(particles);
    within(fine, grains, point(particles, i), reach, [&](uint32_t, double) { ++numbers[i]; });
    mean += numbers[i] * share(particles);
  }
  for (const uint32_t number : numbers) placed.bare += number < 0.25 * mean ? 100.0 * share(particles) : 0.0;
  std::vector<double> simulated = distances_from(axis, particles), drawn = distances_from(axis, grains);
  placed.half = quantile(drawn, 0.5) / quantile(simulated, 0.5);
  placed.p95 = quantile(drawn, 0.95) / quantile(simulated, 0.95);
  placed.wrong = 100.0 * (share_in_wrong_cell(particles, grains, edge) -
                          share_in_wrong_cell(particles, in_balls(particles, m, radius, seed), edge));
  return placed;
}

void GrainMoves::frame(Points particles, Points grains, double radius, double seconds) {
  constexpr double k_move = 0.3, k_jump = 1.0, k_about = 3.0;  // r
  constexpr double k_slow = 0.1;                               // m/s
  const auto displacement = [](Points from, Points to, size_t i) { return length(point(to, i) - point(from, i)); };
  const CellGrid about(particles_, k_about * radius);
  for (size_t i = 0; i < count(grains_); ++i) {
    const double own = displacement(grains_, grains, i);
    if (own < k_move * radius) continue;
    moves_ += 1.0;
    const bool slow = 3 * i < before_.size() && displacement(before_, grains_, i) < k_slow * seconds;
    if (own < k_jump * radius && !slow) continue;
    double highest = -1.0;  // of the particles about it
    within(about, particles_, point(grains_, i), k_about * radius,
           [&](uint32_t j, double) { highest = std::max(highest, displacement(particles_, particles, j)); });
    if (highest < 0.0) continue;
    jumps_ += own - highest > k_jump * radius ? 1.0 : 0.0;
    if (slow && highest < k_slow * seconds) slow_displacement_ = std::max(slow_displacement_, own / radius);
  }
  before_ = std::move(grains_);
  particles_.assign(particles.begin(), particles.end());
  grains_.assign(grains.begin(), grains.end());
}

}  // namespace sandglass::host
