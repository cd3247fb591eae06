// What the API adds to the stages: the version, a rotation from axis and angle, a box body whose collider fits it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "sandglass/sandglass.hpp"

namespace {

// v turned by the quaternion q.
void turned(const float q[4], const float v[3], double out[3]) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  const double t[3] = {2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])};
  out[0] = v[0] + w * t[0] + y * t[2] - z * t[1];
  out[1] = v[1] + w * t[1] + z * t[0] - x * t[2];
  out[2] = v[2] + w * t[2] + x * t[1] - y * t[0];
}

TEST(Version, TheLinkedLibraryIsThatOfTheHeaders) {
  EXPECT_EQ(sandglass_version(), static_cast<uint32_t>(SANDGLASS_VERSION));
  EXPECT_TRUE(SANDGLASS_VERSION_FITS());
  EXPECT_EQ(SANDGLASS_VERSION / 1000000, SANDGLASS_VERSION_MAJOR);
  EXPECT_EQ(SANDGLASS_VERSION / 1000 % 1000, SANDGLASS_VERSION_MINOR);
}

TEST(Rotation, AnyAxisAndAngleAgreeWithSineAndCosine) {
  for (const float angle : {-7.0f, -0.3f, 0.0f, 1e-4f, 2.0f, 100.0f}) {
    const float axis[3] = {1e-20f, 2e-20f, -2e-20f};
    float q[4];
    ASSERT_EQ(sandglass_rotation_about(axis, angle, q), 1);
    const double s = std::sin(0.5 * angle) / 3.0;
    EXPECT_NEAR(q[0], s, 1e-7);
    EXPECT_NEAR(q[1], 2 * s, 1e-7);
    EXPECT_NEAR(q[2], -2 * s, 1e-7);
    EXPECT_NEAR(q[3], std::cos(0.5 * angle), 1e-7);
  }
}

TEST(Rotation, WithoutAnAxisOrAnAngleItIsTheIdentity) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  const float none[3] = {0, 0, 0}, broken[3] = {0, nan, 0}, endless[3] = {infinite, 0, 0}, y[3] = {0, 1, 0};
  const struct {
    const float* axis;
    float angle;
  } cases[] = {{none, 1}, {broken, 1}, {endless, 1}, {y, nan}, {y, infinite}};
  for (const auto& c : cases) {
    float q[4] = {5, 5, 5, 5};
    EXPECT_EQ(sandglass_rotation_about(c.axis, c.angle, q), 0);
    EXPECT_EQ(q[0], 0.0f);
    EXPECT_EQ(q[1], 0.0f);
    EXPECT_EQ(q[2], 0.0f);
    EXPECT_EQ(q[3], 1.0f);
  }
}

constexpr float k_radius = 0.01f;

sandglass::BoxBody make_box(const std::array<float, 3>& half, const std::array<float, 3>& position, float density,
                            const sandglass::Rotation& rotation = {0, 0, 0, 1}) {
  sandglass::BoxBody box;
  const sandglass::Status status = sandglass::box_body(half, k_radius, position, density, &box, rotation);
  EXPECT_TRUE(status) << status.reason;
  return box;
}

// The extent of the spheres along each axis, in the box's own frame.
TEST(BoxBody, ItsSpheresTouchAllFacesFromInside) {
  for (const float h : {0.01f, 0.013f, 0.02f, 0.05f, 0.0777f}) {
    const std::array<float, 3> half = {h, 0.03f, 0.01f};
    const sandglass::BoxBody box = make_box(half, {0, 0, 0}, 1.0f);
    for (size_t k = 0; k < 3; ++k) {
      float lowest = 1.0f, highest = -1.0f;
      for (size_t i = k; i < box.particles.size(); i += 3) {
        lowest = std::min(lowest, box.particles[i] - k_radius);
        highest = std::max(highest, box.particles[i] + k_radius);
      }
      EXPECT_NEAR(lowest, -half[k], 1e-6f) << h;
      EXPECT_NEAR(highest, half[k], 1e-6f) << h;
    }
  }
}

TEST(BoxBody, ItWeighsAsMuchAsItsVolumeOfSandTimesItsDensity) {
  const sandglass::BoxBody box = make_box({0.033f, 0.04f, 0.05f}, {1, 2, 3}, 2.5f);
  const double packed = 4.0 * std::sqrt(2.0) * std::pow(static_cast<double>(k_radius), 3);
  const double volume = 8.0 * 0.033 * 0.04 * 0.05;
  EXPECT_NEAR(box.body.particle_count * static_cast<double>(box.body.density_ratio) * packed, 2.5 * volume,
              1e-5 * volume);
}

// Half a second of falling, turned and spinning: every particle stays within the box that the collider is, and the
// outermost stay at its faces.
TEST(BoxBody, TheColliderAtItsPoseFitsItsParticles) {
  const std::array<float, 3> half = {0.04f, 0.02f, 0.03f};
  sandglass::BoxBody box = make_box(half, {0.1f, 1.0f, -0.2f}, 1.0f, sandglass::rotation_about(1, 2, 3, 0.7f));
  box.body.angular_velocity[0] = 3.0f;
  box.body.angular_velocity[2] = -2.0f;
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.granular.particle_capacity = desc.granular.body_particle_capacity = box.body.particle_count;
  desc.granular.body_capacity = 1;
  sandglass::Scene scene;
  ASSERT_TRUE(scene.create(desc));
  uint32_t index = 7;
  ASSERT_TRUE(scene.add_body(box.body, &index));
  EXPECT_EQ(index, 0u);
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60.0f;
  for (int frame = 0; frame < 30; ++frame) ASSERT_TRUE(scene.frame(input));
  const sandglass_collider collider = box.collider(scene.body_pose(index));
  EXPECT_EQ(collider.shape, SANDGLASS_SHAPE_BOX);
  EXPECT_EQ(collider.grains_only, 1u);
  EXPECT_LT(collider.position[1], 0.5f) << "it fell";
  std::vector<float> now(box.particles.size());
  sandglass_scene_particles(scene.get(), now.data(), nullptr);
  const float inverse[4] = {-collider.rotation[0], -collider.rotation[1], -collider.rotation[2], collider.rotation[3]};
  double extent[3] = {};
  for (size_t i = 0; i < now.size(); i += 3) {
    const float offset[3] = {now[i] - collider.position[0], now[i + 1] - collider.position[1],
                             now[i + 2] - collider.position[2]};
    double own[3];
    turned(inverse, offset, own);
    for (int k = 0; k < 3; ++k) extent[k] = std::max(extent[k], std::fabs(own[k]) + k_radius);
  }
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(extent[k], half[k], 2e-6) << k;
}

TEST(BoxBody, ABoxThatHoldsNoParticleOrTooManyIsRefused) {
  uint32_t count = 7;
  const char* reason = nullptr;
  sandglass_box_desc desc = sandglass::box_desc();
  desc.particle_radius = k_radius;
  for (const float half : {0.009f, 10.0f, NAN, 0.02f}) {
    for (float& extent : desc.half_extents) extent = half;
    const bool good = half == 0.02f;
    EXPECT_EQ(sandglass_box_count(&desc, &count, &reason), good ? SANDGLASS_OK : SANDGLASS_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(reason == nullptr, good);
  }
  EXPECT_EQ(count, 8u);
  float points[3 * 8];
  sandglass_body body;
  EXPECT_EQ(sandglass_box_body(&desc, points, 7, &body, &reason), SANDGLASS_ERROR_CAPACITY);
  EXPECT_EQ(sandglass_box_body(&desc, points, 8, &body, &reason), SANDGLASS_OK);
  for (float* const number : {&desc.density, &desc.position[1], &desc.rotation[2]}) {
    const float good = *number;
    *number = NAN;
    EXPECT_EQ(sandglass_box_count(&desc, &count, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
    *number = good;
  }
}

}  // namespace
