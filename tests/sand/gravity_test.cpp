// Gravity that changes: a device that is tipped. Sand flows to the side that is low now, what sleeps wakes where the
// change is worth it. (Replays: random_scenes_test.cpp.)
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_radius = 0.01f, k_frame = 0.02f;
constexpr double k_degree = 3.14159265358979323846 / 180.0;

// Gravity of a device that is turned by so much about z: its +x side is lower.
std::array<float, 3> tipped(double degrees) {
  return {static_cast<float>(9.81 * std::sin(degrees * k_degree)),
          static_cast<float>(-9.81 * std::cos(degrees * k_degree)), 0.0f};
}

constexpr float k_width = 0.3f, k_depth = 0.1f;  // of an open box along x and z, its middle over the origin

// Sand for it: as high as the box is wide by half, and so far out of order that it does not lie like stacked balls.
std::vector<float> loose_fill() {
  constexpr float k_spacing = 2.4f * k_radius;
  std::vector<float> points = lattice(12, 9, 4, k_spacing, k_radius);
  for (size_t i = 0; i < points.size(); ++i) {
    points[i] += 0.15f * k_radius * std::sin(12.9898f * static_cast<float>(i));
    if (i % 3 != 1) points[i] -= (i % 3 == 0 ? 5.5f : 1.5f) * k_spacing;
  }
  return points;
}

GranularScene filled_box() {
  const std::vector<float> particles = loose_fill();
  GranularScene box(description(static_cast<uint32_t>(particles.size() / 3)));
  box.add_floor();
  box.add_walls({-0.5f * k_width, -0.5f * k_depth}, {0.5f * k_width, 0.5f * k_depth});
  box.add(particles);
  return box;
}

double mean(const std::vector<float>& positions, size_t axis) {
  double sum = 0.0;
  for (size_t i = axis; i < positions.size(); i += 3) sum += static_cast<double>(positions[i]);
  return 3.0 * sum / static_cast<double>(positions.size());
}

// A surface of slope s in a box of width w, filled to the height h, moves the centre of mass by w^2 tan(s) / 12 h. Sand
// comes to lie level with gravity, up to its angle of repose: s is between the tilt less that angle, and the tilt.
TEST(Gravity, SandInATippedBoxFlowsToTheNewLowSide) {
  GranularScene box = filled_box();
  until_asleep(&box);
  const std::vector<float> level = box.positions();
  const double height = 2.0 * mean(level, 1), share = static_cast<double>(k_width * k_width) / (12.0 * height);
  constexpr double k_tilt = 45.0, k_repose = 30.0;
  EXPECT_LT(std::fabs(mean(level, 0)), 0.5 * share * std::tan((k_tilt - k_repose) * k_degree)) << "not level before";
  for (const double side : {1.0, -1.0}) {
    accept(box.scene.set_gravity(tipped(side * k_tilt)));
    EXPECT_EQ(box.frame(k_frame).sand.awake, box.particle_count);
    until_asleep(&box);
    const double moved = side * mean(box.positions(), 0);
    EXPECT_GT(moved, share * std::tan((k_tilt - k_repose) * k_degree));
    EXPECT_LT(moved, share * std::tan(k_tilt * k_degree));
  }
}

TEST(Gravity, ATremblingHandWakesNobodyAndASlowTurnDoes) {
  GranularScene box = filled_box();
  until_asleep(&box);
  const uint64_t before = box.hash();
  for (int frame = 0; frame < 20; ++frame) {
    accept(box.scene.set_gravity(tipped(frame % 2 == 0 ? 1.0 : -1.0)));
    EXPECT_EQ(box.frame(k_frame).sand.awake, 0u) << frame;
  }
  EXPECT_EQ(box.hash(), before);
  accept(box.scene.set_gravity(tipped(1.3)));
  EXPECT_EQ(box.frame(k_frame).sand.awake, box.particle_count);
}

// Grains that lie on the floor away from all particles slide from rest, slowed by friction alone.
TEST(Gravity, GrainsThatLieAloneSlide) {
  std::vector<float> grains;
  for (int i = 0; i < 40; ++i) grains.insert(grains.end(), {0.01f * static_cast<float>(i % 8), 0.0035f, 2.0f});
  sandglass_scene_desc desc = description(8, 40);
  GranularScene scene(desc);
  scene.add_floor();
  scene.add({0.0f, k_radius, 0.0f}, {}, grains);
  sandglass_frame_report report = {};
  for (int frame = 0; frame < 200; ++frame) report = scene.frame(k_frame);
  ASSERT_EQ(report.sand.awake + report.sand.awake_grains, 0u);
  const std::vector<sandglass_grain> before = scene.grains;
  accept(scene.scene.set_gravity(tipped(30.0)));
  constexpr int k_frames = 10;
  for (int frame = 0; frame < k_frames; ++frame) report = scene.frame(k_frame);
  EXPECT_GT(report.sand.awake_grains, 0u);
  const double friction = static_cast<double>(desc.granular.kinetic_friction), seconds = k_frames * 0.02;
  const double slid =
      0.5 * 9.81 * (std::sin(30.0 * k_degree) - friction * std::cos(30.0 * k_degree)) * seconds * seconds;
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_NEAR(scene.grains[i].position[0] - before[i].position[0], slid, 0.15 * slid) << i;
}

}  // namespace
