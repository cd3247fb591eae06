// What holds sand, end to end: an hourglass from a mesh keeps its sand and drains, a bucket carries sand and tips it out,
// boundary particles are a ground. (Fields from functions: field_test.cpp.)
#include <gtest/gtest.h>

#include <cmath>

#include "models/mesh/generated.h"
#include "models/simulation/scene_file.h"
#include "tests/sand/granular_scene.h"
#include "tests/sand/mesh_collider.h"

namespace {

using sandglass::host::hourglass_profile;
using sandglass::host::make_revolved;
using sandglass::host::Profile;
using sandglass::host::revolved_distance;

constexpr float k_radius = 0.01f, k_spacing = 0.01f;  // the radius of particles, the spacing of a field's nodes

// Nothing leaves. In the end more than 95 % of the particles and of the grains are below the neck.
TEST(Container, AnHourglassFromAMeshKeepsItsSandAndDrains) {
  if (SANDGLASS_EMULATED != 0) GTEST_SKIP() << "minutes under emulation; the kernels are compared there to the bit";
  constexpr double k_height = 0.5, k_bulb = 0.13, k_neck = 0.065;  // the neck is 6.5 particle diameters wide
  const MeshCollider glass(make_revolved(hourglass_profile(k_height, k_bulb, k_neck, 32), 96), SANDGLASS_SOLID_OUTSIDE,
                           k_spacing);
  const Profile outline = hourglass_profile(k_height, k_bulb, k_neck, 60);
  const auto within = [&](const float* p) { return -revolved_distance(outline, {p[0], p[1], p[2]}); };
  GranularScene scene = loose_sand({{-0.126f, 0.30f, -0.126f}, {0.126f, 0.43f, 0.126f}},
                                   [&](const float* p) { return within(p) > 0.012; });
  scene.colliders.push_back(glass.collider);
  const size_t count = scene.particle_count;
  ASSERT_GE(count, 300u);
  for (int frame = 0; frame < 250; ++frame) {
    const sandglass_frame_report report = scene.frame(0.02f);
    ASSERT_EQ(report.sand.particles, count);
    ASSERT_EQ(report.sand.grains, 8 * count);
    const std::vector<float> p = scene.positions();
    for (size_t i = 0; i < p.size(); i += 3) ASSERT_GT(within(&p[i]), 0.0) << "a particle, frame " << frame;
    for (const sandglass_grain& g : scene.grains) ASSERT_GT(within(g.position), 0.0) << "a grain, frame " << frame;
  }
  size_t below = 0, grains_below = 0;
  const std::vector<float> p = scene.positions();
  for (size_t i = 1; i < p.size(); i += 3) below += p[i] < 0.25f ? 1 : 0;
  for (const sandglass_grain& g : scene.grains) grains_below += g.position[1] < 0.25f ? 1 : 0;
  EXPECT_GT(static_cast<double>(below), 0.95 * static_cast<double>(count));
  EXPECT_GT(static_cast<double>(grains_below), 0.95 * 8.0 * static_cast<double>(count));
}

// The bucket is lifted by 0.3 m with sand in it, held, and turned over. It lifts its sand, which then lies on the
// floor.
TEST(Container, ABucketLiftsItsSandAndTipsItOut) {
  constexpr double k_pi = 3.14159265358979323846;
  const MeshCollider bucket(make_revolved(sandglass::host::bucket_profile(0.2, 0.1, 0.13, 0.03), 64),
                            SANDGLASS_SOLID_INSIDE, k_spacing);
  GranularScene scene = loose_sand({{-0.06f, 0.045f, -0.06f}, {0.06f, 0.13f, 0.06f}},
                                   [](const float* p) { return std::hypot(p[0], p[2]) < 0.056f; });
  scene.add_floor();
  scene.colliders.push_back(bucket.collider);
  const auto within = [&](float from, float to) {
    const std::vector<float> p = scene.positions();
    size_t inside = 0;
    for (size_t i = 1; i < p.size(); i += 3) inside += p[i] > from && p[i] < to ? 1 : 0;
    return inside;
  };
  double height = 0.0, angle = 0.0;
  const auto run = [&](int frames, double up, double turn) {
    for (int frame = 0; frame < frames; ++frame) {
      height += 0.02 * up;
      angle += 0.02 * turn;
      sandglass_collider& c = scene.colliders[1];
      c.position[1] = static_cast<float>(height);
      c.linear_velocity[1] = static_cast<float>(up);
      c.rotation[2] = static_cast<float>(std::sin(angle / 2));
      c.rotation[3] = static_cast<float>(std::cos(angle / 2));
      c.angular_velocity[2] = static_cast<float>(turn);
      scene.frame(0.02f);
      for (const sandglass_grain& g : scene.grains) ASSERT_GT(g.position[1], -k_radius) << "under the floor";
    }
  };
  const size_t count = scene.particle_count;
  run(25, 0.0, 0.0);
  run(50, 0.3, 0.0);
  run(25, 0.0, 0.0);
  EXPECT_EQ(within(0.33f, 0.6f), count) << "all of it rode along";
  size_t grains_up = 0;
  for (const sandglass_grain& g : scene.grains) grains_up += g.position[1] > 0.32f ? 1 : 0;
  EXPECT_EQ(grains_up, scene.grains.size());
  run(75, 0.0, k_pi / 1.5);
  run(75, 0.0, 0.0);
  EXPECT_EQ(within(0.0f, 0.2f), count) << "all of it fell out";
}

TEST(Container, AGroundOfBoundaryParticlesHoldsSand) {
  GranularScene scene(description(64, 0, 1600));
  std::vector<float> ground;
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 40; ++k)
      ground.insert(ground.end(), {0.015f * static_cast<float>(i - 20), 0.0f, 0.015f * static_cast<float>(k - 20)});
  }
  accept(scene.scene.set_boundary(ground));
  scene.add(lattice(4, 4, 4, 0.0204f, 0.05f));
  for (int frame = 0; frame < 100; ++frame) scene.frame(0.02f);
  const std::vector<float> p = scene.positions();
  for (size_t i = 1; i < p.size(); i += 3) EXPECT_GT(p[i], 0.010f) << "sunk between boundary particles";
}

}  // namespace
