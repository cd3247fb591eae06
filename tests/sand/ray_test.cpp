// A ray finds the first particle on its way: against every sphere in long double, and what it must not find.
#include <gtest/gtest.h>

#include <cmath>

#include "runtime/math/random.h"
#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_radius = 0.01f;
using Real = long double;

// The index of the nearest sphere on the ray, or -1; its distance in *nearest.
int nearest_sphere(const std::vector<float>& p, const std::array<float, 3>& o, const std::array<float, 3>& d,
                   Real* nearest) {
  const Real length = std::sqrt(Real{d[0]} * Real{d[0]} + Real{d[1]} * Real{d[1]} + Real{d[2]} * Real{d[2]});
  int found = -1;
  for (size_t i = 0; i < p.size(); i += 3) {
    Real b = 0, c = -Real{k_radius} * Real{k_radius};  // t^2 - 2 b t + c = 0
    for (size_t k = 0; k < 3; ++k) {
      const Real to = Real{p[i + k]} - Real{o[k]};
      b += to * Real{d[k]} / length;
      c += to * to;
    }
    const Real t = b - std::sqrt(b * b - c);  // not a number: past it
    if (t >= 0 && (found < 0 || t < *nearest)) {
      found = static_cast<int>(i / 3);
      *nearest = t;
    }
  }
  return found;
}

// 2,084 particles, 148 of them bodies, and 1,500 rays from outside. What is hit, and where, is what the equation says.
// The count of each answer shows that all three were tried.
TEST(Ray, FindsTheFirstSphereOnItsWay) {
  GranularScene scene(with_bodies(1936, 2, 148));
  std::vector<float> sand = lattice(22, 4, 22, 0.03f, 0.4f), body = lattice(12, 1, 12, 0.0201f, 0.6f);
  scene.add_body(lattice(2, 1, 2, 0.0201f, 0.8f));
  scene.add_body(body);
  scene.add(sand);
  const std::vector<float> p = scene.positions();
  sandglass::Random random{11};
  const auto number = [&] { return static_cast<float>(random.below(20001)) / 10000.0f - 1.0f; };
  int counts[3] = {};
  for (int ray = 0; ray < 1500; ++ray) {
    const std::array<float, 3> origin = {0.3f + 0.6f * number(), 2.0f + number(), 0.3f + 0.6f * number()};
    const float scale = std::ldexp(1.0f, static_cast<int>(random.below(100)) - 50);
    const std::array<float, 3> direction = {0.3f * number() * scale, -scale, 0.3f * number() * scale};
    Real expected = 0;
    const int first = nearest_sphere(p, origin, direction, &expected);
    const sandglass_ray_hit hit = scene.scene.ray(origin, direction, INFINITY);
    ++counts[hit.what];
    ASSERT_EQ(hit.what, first < 0 ? SANDGLASS_HIT_NOTHING : first < 148 ? SANDGLASS_HIT_BODY : SANDGLASS_HIT_SAND);
    if (first < 0) continue;
    ASSERT_EQ(hit.index, first < 4 ? 0u : first < 148 ? 1u : static_cast<uint32_t>(first));
    ASSERT_NEAR(hit.distance, static_cast<double>(expected), 1e-6);
    for (size_t k = 0; k < 3; ++k) {
      const double center = static_cast<double>(p[3 * static_cast<size_t>(first) + k]);
      ASSERT_NEAR(center + 0.01 * static_cast<double>(hit.normal[k]), hit.point[k], 1e-6);
    }
    ASSERT_NEAR(std::hypot(hit.normal[0], hit.normal[1], hit.normal[2]), 1.0f, 1e-6f);
    // The reach decides, to a part in a million.
    ASSERT_EQ(scene.scene.ray(origin, direction, hit.distance * (1 - 1e-6f)).what, SANDGLASS_HIT_NOTHING);
    ASSERT_EQ(scene.scene.ray(origin, direction, hit.distance * (1 + 1e-6f)).index, hit.index);
  }
  for (const int count : counts) EXPECT_GT(count, 30);
}

TEST(Ray, IsExactFromFarAndForTheFinestSand) {
  sandglass_scene_desc desc = description(1);
  desc.granular.particle_radius = 1e-4f;
  GranularScene scene(desc);
  scene.add({0.0f, 0.0f, 0.0f});
  for (const float aside : {0.0f, 0.99e-4f, 1.01e-4f}) {
    const sandglass_ray_hit hit = scene.scene.ray({1000.0f, aside, 0.0f}, {-1.0f, 0.0f, 0.0f}, 2000.0f);
    EXPECT_EQ(hit.what, aside < 1e-4f ? SANDGLASS_HIT_SAND : SANDGLASS_HIT_NOTHING);
    EXPECT_NEAR(hit.normal[1], aside < 1e-4f ? aside / 1e-4f : 0.0f, 1e-3f);
  }
}

TEST(Ray, BeginsInsideAParticleOrFindsNothing) {
  GranularScene scene(description(3));
  scene.add({0, 0, 0, 0, 0, 0, 0, -1, 0});
  const auto hit = [&](std::array<float, 3> origin, std::array<float, 3> direction, float reach) {
    return scene.scene.ray(origin, direction, reach);
  };
  const sandglass_ray_hit inside = hit({0.0f, 0.005f, 0.0f}, {1, 0, 0}, 1.0f), centre = hit({0, 0, 0}, {2, 0, 0}, 1.0f);
  EXPECT_EQ(inside.distance, 0.0f);
  EXPECT_EQ(inside.point[1], 0.005f);
  EXPECT_EQ(inside.normal[1], 1.0f);
  EXPECT_EQ(centre.normal[0], -1.0f);
  EXPECT_EQ(centre.index, 0u) << "of two the lower number";
  EXPECT_EQ(hit({0, 0.02f, 0}, {0, -1, 0}, 1.0f).what, SANDGLASS_HIT_SAND) << "the control";
  for (const sandglass_ray_hit& none : {hit({0, 0.02f, 0}, {0, 1, 0}, 1.0f), hit({0, 0.02f, 0}, {0, 0, 0}, 1.0f),
                                        hit({0, 0.02f, 0}, {0, -1, 0}, 0.0f), hit({0, 0.02f, 0}, {0, -1, 0}, NAN),
                                        hit({0, 0.02f, 0}, {0, NAN, 0}, 1.0f), hit({0, INFINITY, 0}, {0, -1, 0}, 1.0f)})
    EXPECT_EQ(none.what, SANDGLASS_HIT_NOTHING);
}

// Awake and asleep, and through what it does not see: a floor, boundary particles and grains.
TEST(Ray, SeesParticlesAwakeOrAsleepAndNothingElse) {
  GranularScene scene(description(9, 9, 9));
  const std::vector<float> sheet = lattice(3, 1, 3, 0.0201f, k_radius);
  scene.add_floor();
  std::vector<float> above = sheet;
  for (size_t i = 1; i < above.size(); i += 3) above[i] += 0.3f;
  accept(scene.scene.set_boundary(above));
  scene.add(sheet, {}, above);
  const auto straight_down = [&] { return scene.scene.ray({0.0f, 1.0f, 0.0f}, {0, -1, 0}, 5.0f); };
  EXPECT_NEAR(straight_down().distance, 0.98, 1e-6);
  for (int frame = 0; frame < 200; ++frame) scene.frame(0.02f);
  ASSERT_EQ(scene.frame(0.02f).sand.awake, 0u);
  EXPECT_NEAR(straight_down().distance, 0.98, 1e-3);
  EXPECT_EQ(scene.scene.ray({0.5f, 1.0f, 0.5f}, {0, -1, 0}, 5.0f).what, SANDGLASS_HIT_NOTHING) << "the floor";
}

}  // namespace
