// The time for 100,000 points, and how it grows: four times the points must not take much more than four times as long.
// Only ratios have limits, because times depend on the machine. A quadratic algorithm would show.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <ctime>

#include "models/mesh/generated.h"
#include "tests/solid/point_checks.h"

namespace sandglass::test {
namespace {

constexpr double k_linear = 4, k_quadratic = 16;  // the ratio of times, for four times the points
const double k_growth_limit = std::sqrt(k_linear * k_quadratic);

struct Timed {
  size_t points;
  double seconds;
};

template <class Sample>
Timed timed(const Sample& sample) {
  Timed best = {0, 1e9};
  for (int run = 0; run < 3; ++run) {  // the quickest of three, because other processes only add time
    const std::clock_t start = std::clock();
    best.points = sample().size() / 3;
    best.seconds = std::min(best.seconds, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return best;
}

template <class Sample>
void expect_linear(const char* name, const Sample& sample, float coarse, float fine) {
  const Timed few = timed([&] { return sample(coarse); }), many = timed([&] { return sample(fine); });
  const double points = static_cast<double>(many.points) / static_cast<double>(few.points),
               time = many.seconds / few.seconds;
  std::printf("%-8s %7zu points %7.3f s   %7zu points %7.3f s   x%.1f points, x%.1f time\n", name, few.points,
              few.seconds, many.points, many.seconds, points, time);
  EXPECT_NEAR(points, 4, 0.5);
  EXPECT_LT(time, k_growth_limit);
}

TEST(Speed, surface_is_linear) {
  const host::Mesh knot = host::make_trefoil();
  expect_linear(
      "surface", [&](float distance) { return sample_surface(knot, distance, desc_with_seed(1)); }, 0.00164f, 0.00082f);
}

TEST(Speed, volume_of_a_mesh_is_linear) {
  const host::Mesh knot = host::make_trefoil();
  const sandglass::MeshInside inside = inside_of(knot, SANDGLASS_INSIDE_PARITY);
  const auto test = [&](const float* p) { return inside(p); };
  expect_linear(
      "knot", [&](float distance) { return sample_volume(bounds_of(knot), distance, test, desc_with_seed(1)); },
      0.0029f, 0.00182f);
}

TEST(Speed, geodesic_is_linear) {
  const host::Mesh knot = host::make_trefoil(0.1f, 0.018f, 200, 16);
  sandglass_sample_desc desc = desc_with_seed(1);
  desc.metric = SANDGLASS_METRIC_GEODESIC;
  expect_linear(
      "geodesic", [&](float distance) { return sample_surface(knot, distance, desc); }, 0.006f, 0.003f);
}

}  // namespace
}  // namespace sandglass::test
