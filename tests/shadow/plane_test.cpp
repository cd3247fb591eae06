// The rectangle of plane.h against brute force: every ray of the light's rim through every corner of the box.
#include "runtime/math/shadow_rectangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace {

using namespace sandglass;

constexpr double k_degree = k_pi / 180;
constexpr double k_half_angle = 10 * k_degree;

void direction(double polar, double azimuth, double out[3]) {
  out[0] = std::sin(polar) * std::cos(azimuth);
  out[1] = std::cos(polar);
  out[2] = std::sin(polar) * std::sin(azimuth);
}

// The rectangle on the plane that the rays of the rim through the corners span.
ShadowRectangle brute_force(const ShadowBox& box, const double light[3]) {
  double across[3] = {light[1], -light[0], 0};
  if (std::hypot(across[0], across[1]) < 1e-9) {
    across[0] = 1;
    across[1] = 0;
  }
  const double length = std::hypot(across[0], across[1]);
  for (double& c : across) c /= length;
  const double beside[3] = {light[1] * across[2] - light[2] * across[1], light[2] * across[0] - light[0] * across[2],
                            light[0] * across[1] - light[1] * across[0]};
  ShadowRectangle seen = {INFINITY, INFINITY, -INFINITY, -INFINITY};
  constexpr int k_rays = 20000;
  for (int i = 0; i < k_rays; ++i) {
    const double turn = 2 * k_pi * i / k_rays, sine = std::sin(k_half_angle), cosine = std::cos(k_half_angle);
    double r[3];
    for (int k = 0; k < 3; ++k)
      r[k] = cosine * light[k] + sine * (std::cos(turn) * across[k] + std::sin(turn) * beside[k]);
    for (int corner = 0; corner < 8; ++corner) {
      const double y = corner & 1 ? box.height : 0;
      const double x = (corner & 2 ? box.half_x : -box.half_x) - y * r[0] / r[1];
      const double z = (corner & 4 ? box.half_z : -box.half_z) - y * r[2] / r[1];
      seen = {std::min(seen.low_x, x), std::min(seen.low_z, z), std::max(seen.high_x, x), std::max(seen.high_z, z)};
    }
  }
  return seen;
}

TEST(Plane, FittedRectangleHoldsExactlyWhatTheLightCanReach) {
  const ShadowBox box = {0.3, 0.1, 0.8};
  for (const double polar : {0.0, 5.0, 30.0, 45.0, 70.0})
    for (double azimuth = 0; azimuth < 360; azimuth += 17) {
      double light[3];
      direction(polar * k_degree, azimuth * k_degree, light);
      const ShadowRectangle fitted = shadow_rectangle(box, PlaneRule::fitted, light, std::sin(k_half_angle), 0);
      const ShadowRectangle seen = brute_force(box, light);
      const double tolerance = 1e-5 * (seen.high_x - seen.low_x + seen.high_z - seen.low_z);
      EXPECT_NEAR(fitted.low_x, seen.low_x, tolerance) << polar << " " << azimuth;
      EXPECT_NEAR(fitted.low_z, seen.low_z, tolerance) << polar << " " << azimuth;
      EXPECT_NEAR(fitted.high_x, seen.high_x, tolerance) << polar << " " << azimuth;
      EXPECT_NEAR(fitted.high_z, seen.high_z, tolerance) << polar << " " << azimuth;
    }
}

TEST(Plane, FixedSquareHasTheSourcesSideLength) {
  const ShadowBox box = {0.3, 0.1, 0.8};
  double light[3];
  direction(20 * k_degree, 1, light);
  const double reach = std::tan(45 * k_degree + k_half_angle);
  const ShadowRectangle r = shadow_rectangle(box, PlaneRule::fixed, light, std::sin(k_half_angle), reach);
  EXPECT_NEAR(r.high_x - r.low_x, 0.6 + 2 * reach * 0.8, 1e-12);  // (6.11)
  EXPECT_EQ(r.low_x, r.low_z);
  EXPECT_EQ(r.high_x, r.high_z);
}

}  // namespace
