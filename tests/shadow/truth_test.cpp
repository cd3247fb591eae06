// The ray caster against deterministic quadrature of the irradiance under the light of 20 degrees that is baked, and what
// it refuses.
#include "models/baking/truth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "models/mesh/generated.h"
#include "tests/refusal.h"

namespace {

using namespace sandglass;
using namespace sandglass::host;

constexpr double k_degree = k_pi / 180;

// The irradiance at (x, 0, 0) divided by the unoccluded one, by midpoints in cos(theta) and phi, without random numbers
// or a mesh.
double quadrature(const Direction& light, double half_angle, double x, double height, double radius) {
  constexpr int k_rings = 400, k_sectors = 800;
  const double flat = std::hypot(light[0], light[2]);
  const Direction a = {light[2] / flat, 0, -light[0] / flat};
  const Direction b = {light[1] * a[2] - light[2] * a[1], light[2] * a[0] - light[0] * a[2],
                       light[0] * a[1] - light[1] * a[0]};
  double visible = 0, all = 0;
  for (int i = 0; i < k_rings; ++i) {
    const double cosine = 1 - (1 - std::cos(half_angle)) * (i + 0.5) / k_rings, sine = std::sqrt(1 - cosine * cosine);
    for (int j = 0; j < k_sectors; ++j) {
      const double turn = 2 * k_pi * (j + 0.5) / k_sectors;
      Direction r;
      for (size_t k = 0; k < 3; ++k) r[k] = cosine * light[k] + sine * (std::cos(turn) * a[k] + std::sin(turn) * b[k]);
      const double along = -x * r[0] + height * r[1];  // along the ray, to the place nearest to the sphere's centre
      const double miss_squared = x * x + height * height - along * along;
      all += r[1];
      visible += along > 0 && miss_squared < radius * radius ? 0 : r[1];
    }
  }
  return visible / all;
}

TEST(ShadowTruth, SphereUnderTheBakedLightAgainstQuadrature) {
  const double alpha = 10 * k_degree, height = 1, radius = 0.3;
  Mesh ball = make_icosphere(static_cast<float>(radius), 6);  // about the origin
  for (size_t i = 1; i < ball.vertices.size(); i += 3) ball.vertices[i] += static_cast<float>(height);
  const ShadowCaster caster(ball, alpha, {4, 32}, 3);
  for (const double polar : {20.0, 45.0, 70.0}) {
    const Direction light = {std::sin(polar * k_degree), std::cos(polar * k_degree), 0};
    constexpr uint32_t k_texels = 48;
    const double centre = -std::tan(polar * k_degree), width = 1.4 / light[1];
    double worst = 0;
    for (uint32_t i = 0; i < k_texels; ++i) {
      const double x = centre + width * texel_centre(i, k_texels);
      const uint32_t texel[2] = {0, 0};
      float traced = 0;
      caster.texels({x - 1e-5, -1e-6, x + 1e-5, 1e-6}, light, 0, 1, 1, texel, 1, &traced);
      worst = std::max(worst, std::fabs(quadrature(light, alpha, x, height, radius) - static_cast<double>(traced)));
    }
    EXPECT_LE(worst, 0.003) << polar;
  }
}

// A control of the test above: (6.16) as printed has another factor sin(theta_s), which gives the light's middle less
// weight.
TEST(ShadowTruth, SourcesPrintedWeightWouldBeSeen) {
  const double alpha = 10 * k_degree, x = 0.2, height = 1, radius = 0.3;
  const double right = quadrature({1e-9, 1, 0}, alpha, x, height, radius);
  double visible = 0, all = 0;
  for (int i = 0; i < 400; ++i)
    for (int j = 0; j < 800; ++j) {
      const double cosine = 1 - (1 - std::cos(alpha)) * (i + 0.5) / 400, sine = std::sqrt(1 - cosine * cosine);
      const double turn = 2 * k_pi * (j + 0.5) / 800, weight = cosine * sine;
      const double along = -x * sine * std::cos(turn) + height * cosine;
      all += weight;
      visible += x * x + height * height - along * along < radius * radius ? 0 : weight;
    }
  EXPECT_GT(std::fabs(right - visible / all), 0.012);
}

TEST(ShadowTruth, SizeAndPlaceOfTheMeshDoNotMatter) {
  const Mesh torus = make_torus(0.5f, 0.25f, 48, 24);
  const StandingObject reference = stand_on_plane(torus, "torus");
  for (const float scale : {0x1p-30f, 0x1p30f}) {
    Mesh moved = torus;
    for (size_t i = 0; i < moved.vertices.size(); ++i)
      moved.vertices[i] = (moved.vertices[i] + static_cast<float>(i % 3) * 8.0f) * scale;
    const StandingObject object = stand_on_plane(moved, "torus");
    EXPECT_NEAR(object.scale / static_cast<double>(scale), reference.scale, 2e-6);
    for (size_t i = 0; i < object.mesh.vertices.size(); ++i)
      ASSERT_NEAR(static_cast<double>(object.mesh.vertices[i]), static_cast<double>(reference.mesh.vertices[i]), 2e-6);
  }
}

TEST(ShadowTruth, RefusesWhatCastsNoShadow) {
  const auto refused = [](const Mesh& mesh, const char* part) {
    tests::expect_refusal(part, [&] { (void)stand_on_plane(mesh, "m"); });
  };
  refused({{}, {}}, "no triangles");
  refused({{0, 0, 0, 1, NAN, 0, 0, 0, 1}, {0, 1, 2}}, "not finite");
  refused({{0, 0, 0, 1, 0, 0, 0, 0, 1}, {0, 1, 2}}, "flat");
  refused({{0, 0, 0, 0, 1, 0, 0, 2, 0}, {0, 1, 2}}, "line");
  refused({{0, 0, 0, 0, 0, 0, 0, 0, 0}, {0, 1, 2}}, "out of range");
  refused({{1e6f, 0, 0, 1e6f + 1, 1, 0, 1e6f, 0, 1}, {0, 1, 2}}, "far from its origin");
}

}  // namespace
