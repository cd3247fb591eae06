// The metrics of packings with known overlap, slope and reach.
#include "models/simulation/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "models/geometry/cell_grid.h"

namespace sandglass::host {
namespace {

TEST(Overlap, OfTwoSpheresIsTheirDepthOverTheRadius) {
  const std::vector<float> pair = {0.0f, 0.0f, 0.0f, 0.75f, 0.0f, 0.0f};
  const Overlap overlap = measure_overlap(pair, 0.5);
  EXPECT_EQ(overlap.pairs, 1u);
  EXPECT_DOUBLE_EQ(overlap.mean, 0.5);
  EXPECT_DOUBLE_EQ(overlap.max, 0.5);
  EXPECT_DOUBLE_EQ(overlap.p99, 0.5);
}

TEST(Overlap, LeavesOutWhatIsNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(measure_overlap(std::vector<float>{0, 0, 0, nan, 0, 0, 1, 0, 0}, 0.6).pairs, 1u);
}

// A simple cubic lattice of 6x5x4 with spacing 1.9 r. Every nearest pair overlaps by 0.1 r, and no other pair touches.
TEST(Overlap, OfALatticeCountsEachPairOnce) {
  std::vector<float> points;
  for (int i = 0; i < 6 * 5 * 4; ++i)
    for (const int index : {i % 6, i / 6 % 5, i / 30}) points.push_back(1.9f * static_cast<float>(index));
  const Overlap overlap = measure_overlap(points, 1.0);
  EXPECT_EQ(overlap.pairs, 5u * 5 * 4 + 6u * 4 * 4 + 6u * 5 * 3);
  EXPECT_NEAR(overlap.mean, 0.1, 1e-6);
  EXPECT_NEAR(overlap.max, 0.1, 1e-6);
}

TEST(Overlap, OverARunAveragesP99AndMeanAndKeepsTheMaximum) {
  OverlapOverRun run;
  run.add({0.2, 0.1, 0.5, 10});
  run.add({0.4, 0.3, 0.2, 20});
  EXPECT_DOUBLE_EQ(run.p99(), 0.3);
  EXPECT_DOUBLE_EQ(run.mean(), 0.2);
  EXPECT_DOUBLE_EQ(run.max, 0.5);
}

TEST(Quantile, IsTheNearestRank) {
  std::vector<double> values;
  for (int i = 100; i >= 1; --i) values.push_back(i);
  EXPECT_EQ(quantile(values, 0.99), 99.0);
  EXPECT_EQ(quantile(values, 0.0), 1.0);
  EXPECT_EQ(quantile(values, 1.0), 100.0);
  EXPECT_EQ(quantile({}, 0.5), 0.0);
}

// Ten of 200 values lie beyond the 95th percentile, and so on. With one value less they are nine and a part.
TEST(Quantile, IsToldByTenValuesBeyondIt) {
  const std::pair<double, size_t> count_min[] = {{0.95, 200}, {0.99, 1000}, {0.999, 10000}};
  for (const auto& [q, count] : count_min) {
    EXPECT_TRUE(tells_quantile(count, q)) << q;
    EXPECT_FALSE(tells_quantile(count - 1, q)) << q;
  }
  EXPECT_FALSE(tells_quantile(0, 0.95));
  EXPECT_FALSE(tells_quantile(1000000, 1.0)) << "nothing is beyond the largest";
}

class Cone : public ::testing::TestWithParam<double> {};

TEST_P(Cone, HasItsSlopeHeightAndReach) {
  constexpr double k_radius = 1.0, k_r = 0.01, k_off_x = 3.0, k_off_z = -2.0;
  const double slope = std::tan(GetParam() * std::numbers::pi / 180.0);
  std::vector<float> points;
  for (double x = -k_radius; x <= k_radius; x += 0.02)
    for (double z = -k_radius; z <= k_radius; z += 0.02)
      for (double y = k_r; y < slope * (k_radius - std::sqrt(x * x + z * z)); y += 0.02)
        points.insert(points.end(),
                      {static_cast<float>(x + k_off_x), static_cast<float>(y), static_cast<float>(z + k_off_z)});
  const Pile pile = measure_pile(points, k_r);
  EXPECT_NEAR(pile.angle_deg, GetParam(), 0.8);
  EXPECT_NEAR(pile.height, slope * k_radius, 0.03);
  EXPECT_NEAR(pile.runout, k_radius, 0.10);
}

INSTANTIATE_TEST_SUITE_P(Angles, Cone, ::testing::Values(10.0, 20.0, 30.0));

TEST(CellGrid, FindsExactlyTheNeighboursThatASearchOverAllPairsFinds) {
  std::vector<float> points;
  uint32_t state = 1;
  for (int i = 0; i < 900; ++i) {
    state = state * 1664525u + 1013904223u;
    points.push_back(static_cast<float>(state >> 8) * 0x1p-24f);
  }
  constexpr double k_reach = 0.11;
  const CellGrid grid(points, 0.07);
  const auto point = [&](uint32_t i) { return Vec3{points[3 * i], points[3 * i + 1], points[3 * i + 2]}; };
  for (uint32_t i = 0; i < 300; ++i) {
    uint32_t found = 0, expected = 0;
    grid.near(point(i), k_reach, [&](uint32_t j) { found += length(point(j) - point(i)) < k_reach; });
    for (uint32_t j = 0; j < 300; ++j) expected += length(point(j) - point(i)) < k_reach;
    EXPECT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace sandglass::host
