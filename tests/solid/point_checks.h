// What the sampling tests share: the samplers, and distances between points that
// are found independently (in double, by a plain grid of their own).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "models/mesh/mesh.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::test {

using Points = std::vector<float>;  // x, y, z of each point

sandglass_sample_desc desc_with_seed(uint64_t seed);

using Inside = std::function<bool(const float*)>;
bool everywhere(const float point[3]);

// Each fails the test on any error.
Points sample_surface(const host::Mesh& mesh, float distance, const sandglass_sample_desc& desc);
Points sample_volume(const sandglass::Box& box, float distance, const Inside& inside,
                     const sandglass_sample_desc& desc);
Points sample_lattice(const sandglass::Box& box, float distance, const Inside& inside);
sandglass::MeshInside inside_of(const host::Mesh& mesh, sandglass_inside_rule rule);
sandglass::Box bounds_of(const host::Mesh& mesh);
constexpr sandglass::Box k_unit_box = {{0, 0, 0}, {1, 1, 1}};

double distance_between(const float a[3], const float b[3]);
// The least distance between two points of the set.
double distance_min(const Points& points, double expected);
// Points sorted into cubes, to find out whether one lies within `reach` (at most the cube's edge) of a place.
class PointLookup {
 public:
  PointLookup(const Points& points, double edge);
  double nearest(const float place[3]) const;  // infinity if further than `edge`
  int count_within(const float place[3], double reach) const;

 private:
  std::array<int64_t, 3> cell_of(const float place[3]) const;
  // From the place to each point in the 27 cells about it.
  std::vector<double> distances(const float place[3]) const;
  double edge_;
  std::map<std::array<int64_t, 3>, std::vector<const float*>> cells_;
};

// Largest gap between the empirical distribution of values in 0..1 and the uniform one (Kolmogorov and Smirnov).
double uniformity_gap(std::vector<double> values);

}  // namespace sandglass::test
