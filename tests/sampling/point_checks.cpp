// See point_checks.h.
#include "tests/sampling/point_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace sandglass::test {
namespace {

constexpr size_t k_guard = 64;
constexpr uint8_t k_guard_byte = 0xA5;

}  // namespace

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

GuardedBlock::GuardedBlock(uint64_t bytes) : bytes_(bytes), memory_(bytes + 3 * k_guard, k_guard_byte) {
  const auto address = reinterpret_cast<uintptr_t>(memory_.data()) + k_guard;
  const size_t gap = (SANDGLASS_BLOCK_ALIGNMENT - address % SANDGLASS_BLOCK_ALIGNMENT) % SANDGLASS_BLOCK_ALIGNMENT;
  start_ = k_guard + gap;
}

void* GuardedBlock::data() { return memory_.data() + start_; }

bool GuardedBlock::guards_intact() const {
  const auto is_guard = [](uint8_t byte) { return byte == k_guard_byte; };
  return std::all_of(memory_.begin(), memory_.begin() + static_cast<std::ptrdiff_t>(start_), is_guard) &&
         std::all_of(memory_.begin() + static_cast<std::ptrdiff_t>(start_ + bytes_), memory_.end(), is_guard);
}

bool GuardedBlock::untouched() const {
  return std::all_of(memory_.begin(), memory_.end(), [](uint8_t byte) { return byte == k_guard_byte; });
}

sandglass_sample_options options_with_seed(uint64_t seed) {
  sandglass_sample_options options;
  sandglass_sample_options_default(&options);
  options.seed = seed;
  return options;
}

Points sample_surface(const host::Mesh& mesh, float distance, const sandglass_sample_options& options) {
  const sandglass_mesh surface = view(mesh);
  uint32_t capacity = 0, count = 0;
  uint64_t bytes = 0;
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_sample_surface_capacity(&surface, distance, &options, &capacity, &reason), SANDGLASS_OK)
      << reason;
  EXPECT_EQ(sandglass_sample_surface_bytes(&surface, distance, &options, capacity, &bytes, &reason), SANDGLASS_OK)
      << reason;
  GuardedBlock scratch(bytes);
  Points points(3ull * capacity);
  EXPECT_EQ(sandglass_sample_surface(&surface, distance, &options, scratch.data(), bytes, points.data(), capacity,
                                     &count, &reason),
            SANDGLASS_OK)
      << reason;
  EXPECT_TRUE(scratch.guards_intact());
  points.resize(3ull * count);
  return points;
}

Points sample_volume(const float low[3], const float high[3], float distance, sandglass_inside inside, void* user,
                     const sandglass_sample_options& options) {
  uint32_t capacity = 0, count = 0;
  uint64_t bytes = 0;
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_sample_volume_capacity(low, high, distance, &capacity, &reason), SANDGLASS_OK) << reason;
  EXPECT_EQ(sandglass_sample_volume_bytes(low, high, distance, capacity, &bytes, &reason), SANDGLASS_OK) << reason;
  GuardedBlock scratch(bytes);
  Points points(3ull * capacity);
  EXPECT_EQ(sandglass_sample_volume(low, high, distance, inside, user, &options, scratch.data(), bytes, points.data(),
                                    capacity, &count, &reason),
            SANDGLASS_OK)
      << reason;
  EXPECT_TRUE(scratch.guards_intact());
  points.resize(3ull * count);
  return points;
}

Points sample_lattice(const float low[3], const float high[3], float distance, sandglass_inside inside, void* user) {
  uint32_t capacity = 0, count = 0;
  uint64_t bytes = 0;
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_sample_lattice_capacity(low, high, distance, &capacity, &reason), SANDGLASS_OK) << reason;
  EXPECT_EQ(sandglass_sample_lattice_bytes(low, high, distance, &bytes, &reason), SANDGLASS_OK) << reason;
  GuardedBlock scratch(bytes);
  Points points(3ull * capacity);
  EXPECT_EQ(sandglass_sample_lattice(low, high, distance, inside, user, nullptr, scratch.data(), bytes, points.data(),
                                     capacity, &count, &reason),
            SANDGLASS_OK)
      << reason;
  EXPECT_TRUE(scratch.guards_intact());
  points.resize(3ull * count);
  return points;
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

double PointLookup::nearest(const float place[3]) const {
  double nearest = std::numeric_limits<double>::infinity();
  int64_t cell[3];
  for (int k = 0; k < 3; ++k) cell[k] = std::llround(std::floor(place[k] / edge_));
  for (int n = 0; n < 27; ++n)
    for (uint32_t i : buckets_[bucket(cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1)])
      nearest = std::min(nearest, distance_between(&points_[3 * i], place));
  return nearest;
}

int PointLookup::count_within(const float place[3], double reach) const {
  std::vector<uint32_t> found;
  int64_t cell[3];
  for (int k = 0; k < 3; ++k) cell[k] = std::llround(std::floor(place[k] / edge_));
  for (int n = 0; n < 27; ++n)
    for (uint32_t i : buckets_[bucket(cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1)])
      if (distance_between(&points_[3 * i], place) <= reach) found.push_back(i);
  std::sort(found.begin(), found.end());
  return static_cast<int>(std::unique(found.begin(), found.end()) - found.begin());
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

uint64_t fnv1a(const Points& points, uint64_t hash) {
  for (float value : points) {
    uint32_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    for (int shift = 0; shift < 32; shift += 8) hash = (hash ^ (bits >> shift & 255)) * 0x100000001b3ull;
  }
  return hash;
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
