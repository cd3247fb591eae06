// Signed-distance fields: their distances against closed forms, what is refused, and sand in an hourglass.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "models/mesh/generated.h"
#include "tests/granular/box_points.h"
#include "tests/granular/granular_scene.h"
#include "tests/granular/mesh_collider.h"

namespace {

using sandglass::host::make_icosphere;
using sandglass::host::make_torus;
using sandglass::host::Mesh;

double length(const float* p) { return std::hypot(p[0], p[1], p[2]); }

TEST(Field, OfASphereHasItsDistanceAndNormal) {
  constexpr double k_spacing = 0.01, k_band = 0.04;
  const MeshCollider sphere(make_icosphere(0.1f, 4), SANDGLASS_SOLID_INSIDE, 0.01f, 0.04f, 0.05f);
  // Trilinear interpolation of a function with two curvatures of 1/rho errs by at most h^2/4rho. The chords of the
  // icosphere (its edge is e = 0.1 * 1.26 / 2^4) lie at most e^2/2R below the sphere.
  const double edge = 0.1 * 1.26 / 16.0, chord = edge * edge / (2.0 * 0.1);
  double worst = 0.0;
  for_points(sphere.low, sphere.high, 5000, [&](const float* p) {
    const double rho = length(p), truth = rho - 0.1;
    if (std::fabs(truth) > k_band - 2 * k_spacing) return;
    float normal[3];
    const double distance = static_cast<double>(sandglass_field_distance(sphere.collider.field, p, normal));
    worst = std::max(worst, std::fabs(distance - truth));
    EXPECT_NEAR(distance, truth, k_spacing * k_spacing / (4 * (rho - k_spacing)) + chord + 1e-6);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(normal[k], static_cast<double>(p[k]) / rho, 0.12);
  });
  EXPECT_GT(worst, 0.0);
}

TEST(Field, FarFromTheSurfaceItIsAtMostThirteenPercentTooLong) {
  const MeshCollider torus(make_torus(0.1f, 0.04f, 96, 48), SANDGLASS_SOLID_INSIDE, 0.01f, 0.02f, 0.1f);
  for_points(torus.low, torus.high, 5000, [&](const float* p) {
    const double ring = std::hypot(p[0], p[2]) - 0.1, truth = std::hypot(ring, p[1]) - 0.04;
    const double distance = static_cast<double>(sandglass_field_distance(torus.collider.field, p, nullptr));
    EXPECT_TRUE(std::fabs(truth) <= 1.5e-3 || (distance > 0) == (truth > 0));
    // Interpolation (h^2/4rho at the tube, rho >= 2 cm beyond the ridge) and the mesh's chords come on top.
    EXPECT_LE(std::fabs(distance), 1.13 * std::fabs(truth) + 2.5e-3);
    EXPECT_TRUE(truth <= 0 || distance >= truth - 2.5e-3);
  });
}

TEST(Field, TwoSidesDifferInSignAndBeyondTheGrid) {
  const Mesh ball = make_icosphere(0.1f, 4);
  const MeshCollider solid(ball, SANDGLASS_SOLID_INSIDE, 0.01f, 0.03f, 0.03f),
      room(ball, SANDGLASS_SOLID_OUTSIDE, 0.01f, 0.03f, 0.03f);
  for_points(solid.low, solid.high, 2000, [&](const float* p) {
    EXPECT_EQ(sandglass_field_distance(solid.collider.field, p, nullptr),
              -sandglass_field_distance(room.collider.field, p, nullptr));
  });
  const float far[3] = {3.0f, 0.0f, 0.0f};
  float normal[3];
  EXPECT_NEAR(sandglass_field_distance(solid.collider.field, far, normal), 3.0 - 0.13, 0.02);
  EXPECT_EQ(normal[0], 1.0f);
  EXPECT_LT(sandglass_field_distance(room.collider.field, far, normal), -2.8f);
  EXPECT_EQ(normal[0], -1.0f);
}

float ball_distance(void* user, const float p[3]) { return static_cast<float>(length(p)) - *static_cast<float*>(user); }
float no_distance(void*, const float*) { return NAN; }

TEST(Field, RefusesWhatMakesNoSense) {
  float radius = 0.1f;
  const float low[3] = {-0.15f, -0.15f, -0.15f}, high[3] = {0.15f, 0.15f, 0.15f};
  uint64_t bytes = 0;
  const char* reason = nullptr;
  sandglass_field* field = nullptr;
  ASSERT_EQ(sandglass_field_bytes(low, high, 0.01f, &bytes, &reason), SANDGLASS_OK);
  const sandglass::cpp::Block block = sandglass::cpp::allocate_block(bytes + 64);
  std::byte* memory = block.get();
  const auto make = [&](const float* l, const float* h, float spacing, sandglass_solid solid, sandglass_distance f,
                        void* at, uint64_t size) {
    return sandglass_field_from_function(l, h, spacing, solid, f, &radius, at, size, &field, &reason);
  };
  std::memset(memory, 0xa5, bytes + 64);
  EXPECT_EQ(make(low, high, 0.01f, 0, ball_distance, memory, bytes), SANDGLASS_OK);
  for (int i = 0; i < 64; ++i)
    EXPECT_EQ(memory[bytes + static_cast<uint64_t>(i)], std::byte{0xa5}) << "beyond the block";
  EXPECT_EQ(make(low, high, 0.01f, 0, ball_distance, memory, bytes - 1), SANDGLASS_ERROR_MEMORY_TOO_SMALL);
  EXPECT_EQ(make(low, high, 0.01f, 0, ball_distance, memory + 4, bytes), SANDGLASS_ERROR_MEMORY_ALIGNMENT);
  EXPECT_EQ(make(low, high, 0.01f, 0, no_distance, memory, bytes), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(make(low, high, 0.01f, 7, ball_distance, memory, bytes), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(make(low, high, 0.01f, 0, nullptr, memory, bytes), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(make(high, low, 0.01f, 0, ball_distance, memory, bytes), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(make(low, high, NAN, 0, ball_distance, memory, bytes), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(make(low, high, 1e-5f, 0, ball_distance, memory, bytes), SANDGLASS_ERROR_INVALID_ARGUMENT) << "2^24 nodes";
  radius = 0.2f;
  EXPECT_EQ(make(low, high, 0.01f, 0, ball_distance, memory, bytes), SANDGLASS_ERROR_INVALID_ARGUMENT)
      << "leaves the box";
  EXPECT_NE(reason, nullptr);
  // A collider without a field, or with a pointer to something else, is left out.
  GranularScene scene(description(1));
  scene.add({0.0f, 1.0f, 0.0f});
  sandglass_collider nothing = {};
  nothing.shape = SANDGLASS_SHAPE_FIELD;
  nothing.rotation[3] = 1.0f;
  scene.colliders.push_back(nothing);
  EXPECT_EQ(scene.frame(0.02f).ignored_colliders, 1u);
}

// The inner wall of an hourglass: two cones that meet in a neck, closed at both ends.
constexpr double k_neck = 0.08, k_wide = 0.16, k_half = 0.22;  // metres: two radii, and half the height
double wall_radius(double y) { return k_neck + (k_wide - k_neck) * std::fabs(y) / k_half; }
float hourglass_distance(void*, const float p[3]) {
  const double r = std::hypot(p[0], p[2]), slope = (k_wide - k_neck) / k_half;
  const double side = (wall_radius(static_cast<double>(p[1])) - r) / std::sqrt(1 + slope * slope);
  return static_cast<float>(std::min(side, k_half - std::fabs(static_cast<double>(p[1]))));
}

TEST(Field, NothingLeaksFromAnHourglassAndItDrains) {
  const float low[3] = {-0.2f, -0.26f, -0.2f}, high[3] = {0.2f, 0.26f, 0.2f};
  uint64_t bytes = 0;
  const char* reason = nullptr;
  sandglass_field* field = nullptr;
  ASSERT_EQ(sandglass_field_bytes(low, high, 0.01f, &bytes, &reason), SANDGLASS_OK);
  const sandglass::cpp::Block block = sandglass::cpp::allocate_block(bytes);
  ASSERT_EQ(sandglass_field_from_function(low, high, 0.01f, SANDGLASS_SOLID_OUTSIDE, hourglass_distance, nullptr,
                                          block.get(), bytes, &field, &reason),
            SANDGLASS_OK)
      << reason;
  std::vector<float> particles, grains;
  for (const float& y : {0.07f, 0.092f, 0.114f, 0.136f, 0.158f, 0.18f}) {
    for (int j = -6; j <= 6; ++j) {
      for (int i = -6; i <= 6; ++i) {
        const float p[3] = {0.0205f * static_cast<float>(i), y, 0.0205f * static_cast<float>(j)};
        if (hourglass_distance(nullptr, p) < 0.012f) continue;
        particles.insert(particles.end(), p, p + 3);
        for (int g = 0; g < 8; ++g)
          for (int k = 0; k < 3; ++k) grains.push_back(p[k] + ((g >> k & 1) != 0 ? 0.005f : -0.005f));
      }
    }
  }
  GranularScene scene(
      description(static_cast<uint32_t>(particles.size() / 3), static_cast<uint32_t>(grains.size() / 3)));
  scene.add(particles, {}, grains);
  sandglass_collider glass = {};
  glass.shape = SANDGLASS_SHAPE_FIELD;
  glass.field = field;
  glass.rotation[3] = 1.0f;
  scene.colliders.push_back(glass);
  for (int frame = 0; frame < 200; ++frame) {
    scene.frame(0.02f);
    const std::vector<float> p = scene.positions();
    for (size_t i = 0; i < p.size(); i += 3)
      ASSERT_GE(hourglass_distance(nullptr, &p[i]), 0.01f - 0.0025f) << "a particle, h^2/8R at the neck's edge apart";
    for (const sandglass_grain& g : scene.grains)
      ASSERT_GE(hourglass_distance(nullptr, g.position), 0.0f) << "a grain, frame " << frame;
  }
  uint32_t below = 0;
  const std::vector<float> p = scene.positions();
  for (size_t i = 1; i < p.size(); i += 3) below += p[i] < 0.0f ? 1 : 0;
  EXPECT_GT(below, 9 * p.size() / 3 / 10) << "of " << p.size() / 3 << " particles have passed the neck";
}

}  // namespace
