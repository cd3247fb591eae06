// Golden hashes: the samples of a seed on the trefoil are the same bits with every compiler, instruction set and
// architecture. A change of these numbers is a change of the algorithm and of every scene that starts from samples:
// list it among the changes that break recordings.
#include <gtest/gtest.h>

#include <cinttypes>
#include <cstdio>

#include "models/mesh/generated.h"
#include "runtime/math/hash.h"
#include "tests/solid/point_checks.h"

namespace sandglass::test {
namespace {

// Recorded from g++ 12 on x86-64; equal under clang and on aarch64.
constexpr uint64_t k_golden_mesh = 0x292e98ca3895701b;
constexpr uint64_t k_golden_shapes = 0x14eceb86f95189e6;
constexpr uint64_t k_golden_surface = 0x6324ae783a212957;
constexpr uint64_t k_golden_geodesic = 0x567964d61efc6e62;
constexpr uint64_t k_golden_volume = 0x825f98afc4c95ca8;
constexpr uint64_t k_golden_winding = 0xc2778756844f6f7f;
constexpr uint64_t k_golden_lattice = 0x0f98767601037667;

void expect_hash(const char* name, const Points& points, uint64_t golden) {
  const uint64_t hash = hash_bytes(points.data(), points.size() * sizeof(float));
  std::printf("%-9s %6zu points  hash 0x%016" PRIx64 "\n", name, points.size() / 3, hash);
  EXPECT_EQ(hash, golden) << name;
}

const host::Mesh& knot() {
  static const host::Mesh mesh = host::make_trefoil();
  return mesh;
}

// The knot's volume, filled at random or with a lattice.
Points sample_knot(sandglass_inside_rule rule, float distance, bool random) {
  const sandglass::MeshInside inside = inside_of(knot(), rule);
  const auto test = [&](const float* p) { return inside(p); };
  if (!random) return sample_lattice(bounds_of(knot()), distance, test);
  return sample_volume(bounds_of(knot()), distance, test, desc_with_seed(42));
}

TEST(Golden, mesh) { expect_hash("mesh", knot().vertices, k_golden_mesh); }

TEST(Golden, shapes) {
  Points points(9000);
  ASSERT_EQ(sandglass_sample_disk(1, points.data(), 1000, nullptr), SANDGLASS_OK);
  ASSERT_EQ(sandglass_sample_sphere(1, points.data() + 3000, 1000, nullptr), SANDGLASS_OK);
  ASSERT_EQ(sandglass_sample_ring(1, 0.2f, 0.9f, points.data() + 6000, 1000, nullptr), SANDGLASS_OK);
  expect_hash("shapes", points, k_golden_shapes);
}

TEST(Golden, surface) { expect_hash("surface", sample_surface(knot(), 0.004f, desc_with_seed(42)), k_golden_surface); }

TEST(Golden, geodesic) {
  sandglass_sample_desc desc = desc_with_seed(42);
  desc.metric = SANDGLASS_METRIC_GEODESIC;
  expect_hash("geodesic", sample_surface(knot(), 0.006f, desc), k_golden_geodesic);
}

TEST(Golden, volume) { expect_hash("volume", sample_knot(SANDGLASS_INSIDE_PARITY, 0.006f, true), k_golden_volume); }
TEST(Golden, winding) { expect_hash("winding", sample_knot(SANDGLASS_INSIDE_WINDING, 0.01f, true), k_golden_winding); }
TEST(Golden, lattice) { expect_hash("lattice", sample_knot(SANDGLASS_INSIDE_PARITY, 0.006f, false), k_golden_lattice); }

}  // namespace
}  // namespace sandglass::test
