// See point_checks.h.
#include "tests/solid/point_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sandglass::test {
sandglass_sample_desc desc_with_seed(uint64_t seed) {
  sandglass_sample_desc desc = sandglass::sample_desc();
  desc.seed = seed;
  return desc;
}

bool everywhere(const float*) { return true; }

namespace {

void accept(const sandglass::Status& status) { EXPECT_TRUE(status) << status.reason; }

}  // namespace

Points sample_surface(const host::Mesh& mesh, float distance, const sandglass_sample_desc& desc) {
  Points points;
  accept(sandglass::sample_surface(mesh.view(), distance, &points, desc));
  return points;
}

Points sample_volume(const sandglass::Box& box, float distance, const Inside& inside,
                     const sandglass_sample_desc& desc) {
  Points points;
  accept(sandglass::sample_volume(box, distance, inside, &points, desc));
  return points;
}

Points sample_lattice(const sandglass::Box& box, float distance, const Inside& inside) {
  Points points;
  accept(sandglass::sample_lattice(box, distance, inside, &points));
  return points;
}

sandglass::MeshInside inside_of(const host::Mesh& mesh, sandglass_inside_rule rule) {
  sandglass::MeshInside inside;
  accept(inside.create(mesh.view(), rule));
  return inside;
}

sandglass::Box bounds_of(const host::Mesh& mesh) {
  const sandglass_mesh surface = mesh.view();
  sandglass::Box box;
  EXPECT_EQ(sandglass_mesh_bounds(&surface, box.min, box.max, nullptr), SANDGLASS_OK);
  return box;
}

double distance_between(const float a[3], const float b[3]) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += (static_cast<double>(a[k]) - b[k]) * (static_cast<double>(a[k]) - b[k]);
  return std::sqrt(sum);
}

PointLookup::PointLookup(const Points& points, double edge) : edge_(edge) {
  for (size_t i = 0; i < points.size(); i += 3) cells_[cell_of(&points[i])].push_back(&points[i]);
}

std::array<int64_t, 3> PointLookup::cell_of(const float place[3]) const {
  std::array<int64_t, 3> cell;
  for (size_t k = 0; k < 3; ++k) cell[k] = std::llround(std::floor(place[k] / edge_));
  return cell;
}

std::vector<double> PointLookup::distances(const float place[3]) const {
  const auto [x, y, z] = cell_of(place);
  std::vector<double> found;
  for (int n = 0; n < 27; ++n) {
    const auto cell = cells_.find({x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1});
    if (cell == cells_.end()) continue;
    for (const float* point : cell->second) found.push_back(distance_between(point, place));
  }
  return found;
}

double PointLookup::nearest(const float place[3]) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const double distance : distances(place)) nearest = std::min(nearest, distance);
  return nearest;
}

int PointLookup::count_within(const float place[3], double reach) const {
  int count = 0;
  for (const double distance : distances(place)) count += distance <= reach ? 1 : 0;
  return count;
}

double distance_min(const Points& points, double expected) {
  const PointLookup lookup(points, 1.01 * expected);
  double nearest = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < points.size(); i += 3) {
    // The point itself is found at distance 0, so a second one must be within reach.
    if (lookup.count_within(&points[i], 1.01 * expected) < 2) continue;
    for (size_t j = 0; j < points.size(); j += 3)
      if (j != i) nearest = std::min(nearest, distance_between(&points[i], &points[j]));
  }
  return nearest;
}

double uniformity_gap(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double gap = 0;
  const double n = static_cast<double>(values.size());
  for (size_t i = 0; i < values.size(); ++i)
    gap = std::max(
        {gap, std::abs(values[i] - static_cast<double>(i) / n), std::abs(values[i] - static_cast<double>(i + 1) / n)});
  return gap;
}

}  // namespace sandglass::test
