// Alg. 3 of the dissertation: the numbers that define the packing (12 neighbours at exactly l, density sqrt(2)/l^3) and
// its place.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/solid/point_checks.h"

namespace sandglass::test {
namespace {

TEST(Lattice, has_twelve_neighbours_at_exactly_the_distance) {
  const sandglass::Box box = {{-3.1f, 2.2f, 10.3f}, {-2.1f, 3.2f, 11.3f}};
  const float distance = 0.083f;
  const Points sites = sample_lattice(box, distance, everywhere);
  const PointLookup lookup(sites, 1.2 * distance);
  // A coordinate near 11 has a rounding error of up to 5e-7; a distance takes three.
  const double rounding = 1.5e-6;
  int interior = 0;
  for (size_t i = 0; i < sites.size(); i += 3) {
    bool inner = true;
    for (size_t k = 0; k < 3; ++k)
      inner = inner && sites[i + k] > box.min[k] + 1.01f * distance && sites[i + k] < box.max[k] - 1.01f * distance;
    if (!inner) continue;
    ++interior;
    ASSERT_EQ(lookup.count_within(&sites[i], distance + rounding), 13);                      // itself and twelve
    ASSERT_EQ(lookup.count_within(&sites[i], static_cast<double>(distance) - rounding), 1);  // itself
  }
  EXPECT_GT(interior, 500);
}

TEST(Lattice, is_hexagonal_not_cubic_close_packed) {
  // In a hexagonal packing the mirror image of a site about a neighbour layer is again a site: layer j + 2 lies exactly
  // above layer j.
  const Points sites = sample_lattice(k_unit_box, 0.1f, everywhere);
  const PointLookup lookup(sites, 0.01);
  const float two_layers = 0.1f * static_cast<float>(2 * std::sqrt(6.0) / 3);
  for (size_t i = 0; i < sites.size(); i += 3) {
    const float above[3] = {sites[i], sites[i + 1] + two_layers, sites[i + 2]};
    if (above[1] < 0.99f) {
      ASSERT_LT(lookup.nearest(above), 1e-6);
    }
  }
}

TEST(Lattice, starts_at_the_minimum_of_the_box) {
  const sandglass::Box box = {{-5.5f, 7.25f, 0.125f}, {-4.5f, 8.25f, 1.125f}};
  const Points sites = sample_lattice(box, 0.25f, everywhere);
  ASSERT_GE(sites.size(), 3u);
  for (size_t k = 0; k < 3; ++k) EXPECT_EQ(sites[k], box.min[k]);
  for (size_t i = 0; i < sites.size(); ++i) {
    ASSERT_GE(sites[i], box.min[i % 3]);
    ASSERT_LE(sites[i], box.max[i % 3]);
  }
}

TEST(Lattice, fills_space_at_the_density_of_the_closest_packing) {
  // One site per l^3/sqrt(2). A box of extent b has more, because of the half cells along its faces: of order l/b.
  const float distance = 0.05f;
  const Points sites = sample_lattice({{0, 0, 0}, {2, 2, 2}}, distance, everywhere);
  const double expected = 8 * std::sqrt(2.0) / std::pow(static_cast<double>(distance), 3);
  EXPECT_NEAR(static_cast<double>(sites.size() / 3) / expected, 1, 3 * 0.05 / 2);
}

TEST(Lattice, keeps_what_is_inside) {
  const Points all = sample_lattice(k_unit_box, 0.1f, everywhere);
  const Points half = sample_lattice(k_unit_box, 0.1f, [](const float* p) { return p[1] < 0.5f; });
  Points expected;
  for (size_t i = 0; i < all.size(); i += 3)
    if (all[i + 1] < 0.5f) expected.insert(expected.end(), {all[i], all[i + 1], all[i + 2]});
  EXPECT_EQ(half, expected);
}

}  // namespace
}  // namespace sandglass::test
