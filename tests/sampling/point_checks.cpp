// See point_checks.h.
#include "tests/sampling/point_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace sandglass::test {
sandglass_mesh view(const host::Mesh& mesh) {
  return {mesh.vertices.data(), mesh.vertex_count(), mesh.indices.data(), mesh.triangle_count()};
}

host::Mesh joined(const host::Mesh& a, const host::Mesh& b) {
  host::Mesh both = a;
  both.vertices.insert(both.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (uint32_t i : b.indices) both.indices.push_back(i + a.vertex_count());
  return both;
}

host::Mesh moved(host::Mesh mesh, float x, float y, float z) {
  for (size_t i = 0; i < mesh.vertices.size(); i += 3) {
    mesh.vertices[i] += x;
    mesh.vertices[i + 1] += y;
    mesh.vertices[i + 2] += z;
  }
  return mesh;
}

host::Mesh unit_square() {
  host::Mesh square;
  square.vertices = {0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1};
  square.indices = {0, 2, 1, 0, 3, 2};
  return square;
}

sandglass_sample_options options_with_seed(uint64_t seed) {
  sandglass_sample_options options;
  sandglass_sample_options_default(&options);
  options.seed = seed;
  return options;
}

int everywhere(void*, const float*) { return 1; }

namespace {

// The capacity that is asked for, scratch memory of that capacity's size, then the samples.
template <class Capacity, class Bytes, class Sample>
Points sampled(const Capacity& ask_capacity, const Bytes& ask_bytes, const Sample& sample) {
  uint32_t capacity = 0, count = 0;
  uint64_t bytes = 0;
  const char* reason = nullptr;
  EXPECT_EQ(ask_capacity(&capacity, &reason), SANDGLASS_OK) << reason;
  EXPECT_EQ(ask_bytes(capacity, &bytes, &reason), SANDGLASS_OK) << reason;
  GuardedBlock scratch(bytes);
  Points points(3ull * capacity);
  EXPECT_EQ(sample(scratch.data(), bytes, points.data(), capacity, &count, &reason), SANDGLASS_OK) << reason;
  EXPECT_TRUE(scratch.guards_intact());
  points.resize(3ull * count);
  return points;
}

}  // namespace

Points sample_surface(const host::Mesh& mesh, float distance, const sandglass_sample_options& options) {
  const sandglass_mesh surface = view(mesh);
  return sampled([&](auto... out) { return sandglass_sample_surface_capacity(&surface, distance, &options, out...); },
                 [&](auto... out) { return sandglass_sample_surface_bytes(&surface, distance, &options, out...); },
                 [&](auto... out) { return sandglass_sample_surface(&surface, distance, &options, out...); });
}

Points sample_volume(const float low[3], const float high[3], float distance, sandglass_inside inside, void* user,
                     const sandglass_sample_options& options) {
  return sampled(
      [&](auto... out) { return sandglass_sample_volume_capacity(low, high, distance, out...); },
      [&](auto... out) { return sandglass_sample_volume_bytes(low, high, distance, out...); },
      [&](auto... out) { return sandglass_sample_volume(low, high, distance, inside, user, &options, out...); });
}

Points sample_lattice(const float low[3], const float high[3], float distance, sandglass_inside inside, void* user) {
  return sampled(
      [&](auto... out) { return sandglass_sample_lattice_capacity(low, high, distance, out...); },
      [&](uint32_t, auto... out) { return sandglass_sample_lattice_bytes(low, high, distance, out...); },
      [&](auto... out) { return sandglass_sample_lattice(low, high, distance, inside, user, nullptr, out...); });
}

namespace {

uint64_t inside_bytes(const host::Mesh& mesh, sandglass_inside_rule rule) {
  const sandglass_mesh surface = view(mesh);
  uint64_t bytes = 0;
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_mesh_inside_bytes(&surface, rule, &bytes, &reason), SANDGLASS_OK) << reason;
  return bytes;
}

}  // namespace

InsideTest::InsideTest(const host::Mesh& mesh, sandglass_inside_rule rule) : block_(inside_bytes(mesh, rule)) {
  const sandglass_mesh surface = view(mesh);
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_mesh_inside_create(&surface, rule, block_.data(), block_.bytes(), &inside_, &reason),
            SANDGLASS_OK)
      << reason;
  EXPECT_TRUE(block_.guards_intact());
}

double distance_between(const float a[3], const float b[3]) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += (static_cast<double>(a[k]) - b[k]) * (static_cast<double>(a[k]) - b[k]);
  return std::sqrt(sum);
}

PointLookup::PointLookup(const Points& points, double edge)
    : points_(points), edge_(edge), buckets_(points.size() / 3 + 1) {
  for (size_t i = 0; i < points.size() / 3; ++i) {
    const float* p = &points[3 * i];
    buckets_[bucket(std::llround(std::floor(p[0] / edge_)), std::llround(std::floor(p[1] / edge_)),
                    std::llround(std::floor(p[2] / edge_)))]
        .push_back(static_cast<uint32_t>(i));
  }
}

size_t PointLookup::bucket(int64_t x, int64_t y, int64_t z) const {
  return static_cast<uint64_t>(x * 73856093 ^ y * 19349663 ^ z * 83492791) % buckets_.size();
}

template <class Visit>
void PointLookup::visit_near(const float place[3], const Visit& visit) const {
  int64_t cell[3];
  for (int k = 0; k < 3; ++k) cell[k] = std::llround(std::floor(place[k] / edge_));
  for (int n = 0; n < 27; ++n)
    for (uint32_t i : buckets_[bucket(cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1)])
      visit(i, distance_between(&points_[3 * i], place));
}

double PointLookup::nearest(const float place[3]) const {
  double nearest = std::numeric_limits<double>::infinity();
  visit_near(place, [&](uint32_t, double distance) { nearest = std::min(nearest, distance); });
  return nearest;
}

int PointLookup::count_within(const float place[3], double reach) const {
  std::set<uint32_t> found;  // two cells may share a bucket
  visit_near(place, [&](uint32_t i, double distance) {
    if (distance <= reach) found.insert(i);
  });
  return static_cast<int>(found.size());
}

double least_distance(const Points& points, double expected) {
  const PointLookup lookup(points, 1.01 * expected);
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < points.size(); i += 3) {
    // The point itself is found at distance 0, so a second one must be within reach.
    if (lookup.count_within(&points[i], 1.01 * expected) < 2) continue;
    for (size_t j = 0; j < points.size(); j += 3)
      if (j != i) least = std::min(least, distance_between(&points[i], &points[j]));
  }
  return least;
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
