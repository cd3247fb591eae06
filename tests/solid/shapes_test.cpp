// Disk, sphere and ring against the dissertation's formulas in long double, and the ring's promise: exactly M points,
// all in it.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/solid/point_checks.h"

namespace sandglass::test {
namespace {

constexpr long double k_pi_long = 3.141592653589793238462643383279502884L;
const long double k_golden_angle = 2 * k_pi_long * (1 - 2 / (1 + std::sqrt(5.0L)));  // (3.2), (3.3)

TEST(Disk, follows_3_4_and_3_5) {
  const uint32_t count = 5000;
  Points points(3 * count);
  const char* reason = nullptr;
  ASSERT_EQ(sandglass_sample_disk(2.0f, points.data(), count, &reason), SANDGLASS_OK);
  for (uint32_t i = 1; i <= count; ++i) {
    const long double r = 2 * std::sqrt((i - 0.5L) / (count - 0.5L)), phi = k_golden_angle * i;
    ASSERT_NEAR(points[3 * i - 3], static_cast<double>(r * std::cos(phi)), 2e-7) << i;
    ASSERT_EQ(points[3 * i - 2], 0.0f);
    ASSERT_NEAR(points[3 * i - 1], static_cast<double>(r * std::sin(phi)), 2e-7) << i;
  }
}

TEST(Sphere, follows_3_8_and_3_9) {
  for (uint32_t count : {1u, 2u, 3u, 1000u, 4001u}) {
    Points points(3 * count);
    const char* reason = nullptr;
    ASSERT_EQ(sandglass_sample_sphere(1.0f, points.data(), count, &reason), SANDGLASS_OK);
    for (uint32_t i = 1; i <= count; ++i) {
      const long double theta = std::acos((count + 1.0L - 2.0L * i) / count), phi = k_golden_angle * i;
      ASSERT_NEAR(points[3 * i - 3], static_cast<double>(std::sin(theta) * std::cos(phi)), 2e-7);
      ASSERT_NEAR(points[3 * i - 2], static_cast<double>(std::cos(theta)), 2e-7);
      ASSERT_NEAR(points[3 * i - 1], static_cast<double>(std::sin(theta) * std::sin(phi)), 2e-7);
    }
  }
}

struct RingSweep {
  int rings = 0, off_by_formula = 0;
};

// How many points (3.10) keeps of the sphere that (3.11) asks for: the dissertation's own number.
int64_t count_by_formula(double a, double b, uint32_t wanted) {
  const double n = std::ceil(2 * wanted / (std::cos(a) - std::cos(b)));
  return static_cast<int64_t>(std::floor((n * (1 - std::cos(b)) + 1) / 2) -
                              std::ceil((n * (1 - std::cos(a)) + 1) / 2)) +
         1;
}

void check_ring(float a, float b, uint32_t wanted, RingSweep* sweep) {
  // The array has room for one more point, as a guard: exactly `wanted` points are written.
  Points points(3 * (wanted + 1), -7.0f);
  const char* reason = nullptr;
  ASSERT_EQ(sandglass_sample_ring(1.0f, a, b, points.data(), wanted, &reason), SANDGLASS_OK)
      << a << " " << b << " " << wanted << ": " << reason;
  for (uint32_t i = 0; i < wanted; ++i) {
    const double x = points[3 * i], y = points[3 * i + 1], z = points[3 * i + 2];
    const double theta = std::atan2(std::sqrt(x * x + z * z), y);
    ASSERT_NEAR(x * x + y * y + z * z, 1, 4e-7);
    ASSERT_GE(theta, a - 1.5e-7) << a << " " << b << " " << wanted << " point " << i;
    ASSERT_LE(theta, b + 1.5e-7) << a << " " << b << " " << wanted << " point " << i;
  }
  for (uint32_t k = 3 * wanted; k < 3 * wanted + 3; ++k) ASSERT_EQ(points[k], -7.0f);
  ++sweep->rings;
  sweep->off_by_formula += count_by_formula(a, b, wanted) != wanted;
}

TEST(Ring, has_exactly_the_wanted_points_all_inside) {
  RingSweep sweep;
  const float pi = 3.14159274f;
  for (int ia = 0; ia < 12; ++ia)
    for (int ib = ia + 1; ib <= 12; ++ib)
      for (uint32_t wanted : {1u, 2u, 3u, 5u, 7u, 16u, 33u, 100u, 301u, 1000u}) {
        check_ring(pi * static_cast<float>(ia) / 12, std::min(pi, pi * static_cast<float>(ib) / 12), wanted, &sweep);
        if (HasFatalFailure()) return;
      }
  for (float width : {1e-4f, 1e-3f, 0.01f})
    for (uint32_t wanted : {1u, 10u, 77u}) check_ring(0.7f, 0.7f + width, wanted, &sweep);
  // The correction is needed: the printed formula misses the number for some of these rings.
  EXPECT_GT(sweep.off_by_formula, 0);
  RecordProperty("rings", sweep.rings);
  RecordProperty("rings_where_3_11_is_off", sweep.off_by_formula);
}

TEST(Ring, is_the_sphere_when_it_spans_everything) {
  Points ring(300), sphere(300);
  const char* reason = nullptr;
  ASSERT_EQ(sandglass_sample_ring(1.0f, 0.0f, 3.14159274f, ring.data(), 100, &reason), SANDGLASS_OK);
  ASSERT_EQ(sandglass_sample_sphere(1.0f, sphere.data(), 100, &reason), SANDGLASS_OK);
  EXPECT_EQ(ring, sphere);
}

TEST(Ring, spreads_evenly_over_its_area) {
  // cos(theta) of points that are even over the area is uniform between the two rims.
  const uint32_t count = 2000;
  Points points(3 * count);
  const char* reason = nullptr;
  ASSERT_EQ(sandglass_sample_ring(1.0f, 0.3f, 1.1f, points.data(), count, &reason), SANDGLASS_OK);
  std::vector<double> heights;
  for (uint32_t i = 0; i < count; ++i)
    heights.push_back((points[3 * i + 1] - std::cos(1.1)) / (std::cos(0.3) - std::cos(1.1)));
  EXPECT_LE(uniformity_gap(heights), 1.01 / count);
}

TEST(Shapes, refuse_what_is_no_shape) {
  Points points(30);
  const char* reason = nullptr;
  const float nan = std::nanf("");
  const sandglass_status statuses[] = {sandglass_sample_disk(nan, points.data(), 10, &reason),
                                       sandglass_sample_sphere(-1.0f, points.data(), 10, &reason),
                                       sandglass_sample_sphere(1.0f, points.data(), 0, &reason),
                                       sandglass_sample_ring(1.0f, 0.5f, 0.5f, points.data(), 10, &reason),
                                       sandglass_sample_ring(1.0f, nan, 0.5f, points.data(), 10, &reason),
                                       sandglass_sample_ring(1.0f, 0.5f, 3.2f, points.data(), 10, &reason),
                                       sandglass_sample_ring(1.0f, 0.0f, 1e-7f, points.data(), 1000, &reason)};
  for (const sandglass_status status : statuses) EXPECT_EQ(status, SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(reason, nullptr);
  EXPECT_EQ(points, Points(30));
}

}  // namespace
}  // namespace sandglass::test
