// Sleep: sand that is asleep costs nothing. It wakes where it is touched and nowhere else.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_radius = 0.01f, k_frame = 0.02f;

// Three layers of sand, loose enough to settle without order. The rows of a lattice would carry a push to the other
// end.
std::vector<float> loose_bed(uint32_t wide) {
  std::vector<float> points = lattice(wide, 3, wide, 2.3f * k_radius, k_radius);
  for (size_t i = 0; i < points.size(); ++i)
    if (i % 3 != 1) points[i] += 0.1f * k_radius * std::sin(12.9898f * static_cast<float>(i));
  return points;
}

// A bed that sleeps.
GranularScene sleeping_bed(uint32_t wide, float sleep_after = 0.5f) {
  sandglass_scene_desc desc = description(wide * wide * 3 + 8);
  desc.granular.sleep_after = sleep_after;
  GranularScene bed(desc);
  bed.add(loose_bed(wide));
  bed.add_floor();
  if (sleep_after > 0.0f) until_asleep(&bed);
  return bed;
}

TEST(Sleep, ARestingBedSleepsAndThenTimePassesWithoutSubsteps) {
  GranularScene bed = sleeping_bed(16);
  const uint64_t before = bed.hash();
  const sandglass_frame_report report = bed.frame(k_frame);
  EXPECT_EQ(report.sand.awake, 0u);
  EXPECT_EQ(report.sand.substeps, 0u);
  EXPECT_EQ(report.stages[SANDGLASS_STAGE_GRANULAR].units, 0u);
  EXPECT_DOUBLE_EQ(report.time.debt, 0.0);
  EXPECT_EQ(bed.hash(), before);
}

TEST(Sleep, NeverWhenSwitchedOff) {
  GranularScene bed = sleeping_bed(6, 0.0f);
  for (int frame = 0; frame < 400; ++frame) bed.frame(k_frame);
  EXPECT_EQ(bed.frame(k_frame).sand.awake, bed.particle_count);
  EXPECT_GT(bed.frame(k_frame).sand.substeps, 0u);
}

TEST(Sleep, AHandWakesWhatItTouchesAndNothingElse) {
  if (SANDGLASS_EMULATED != 0) GTEST_SKIP() << "minutes under emulation; the kernels are compared there to the bit";
  GranularScene bed = sleeping_bed(40);
  const std::vector<float> before = bed.positions();
  bed.colliders.push_back(sandglass::sphere(0.1f, 0.1f, 0.4f, 0.03f));
  uint32_t awake_max = 0;
  const auto move = [&](int axis, float speed, int frames) {
    for (int frame = 0; frame < frames; ++frame) {
      sandglass_collider& moving = bed.colliders.back();
      for (float& v : moving.linear_velocity) v = 0.0f;
      moving.linear_velocity[axis] = speed;
      moving.position[axis] += speed * k_frame;
      awake_max = std::max(awake_max, bed.frame(k_frame).sand.awake);
    }
  };
  move(1, -0.1f, 20);  // down into the sand, then along
  move(0, 0.1f, 50);
  EXPECT_GT(awake_max, 20u);
  EXPECT_LT(awake_max, bed.particle_count / 4);
  // The hand passed at z = 0.4 in the direction of x. Sand that is ten diameters to the side has not moved at all.
  const std::vector<float> after = bed.positions();
  uint32_t far = 0, pushed = 0;
  for (uint32_t i = 0; i < bed.particle_count; ++i) {
    if (std::fabs(static_cast<double>(before[3 * i + 2]) - 0.4) > 0.03 + 20 * 0.01) {
      ++far;
      EXPECT_EQ(distance(before, i, after, i), 0.0);
    }
    pushed += distance(before, i, after, i) > static_cast<double>(k_radius) ? 1 : 0;
    const std::vector<float> hand(bed.colliders.back().position, bed.colliders.back().position + 3);
    EXPECT_GE(distance(after, i, hand, 0), 0.03 + 0.01 - 1e-4) << "no particle inside the hand";
  }
  EXPECT_GT(far, bed.particle_count / 3);
  EXPECT_GT(pushed, 10u);
}

TEST(Sleep, WithoutItsFloorTheBedFalls) {
  GranularScene bed = sleeping_bed(8);
  const std::vector<float> before = bed.positions();
  bed.colliders.clear();
  for (int frame = 0; frame < 20; ++frame) bed.frame(k_frame);
  // Free fall of 0.4 s is 0.78 m. At worst the topmost layer wakes a few frames late.
  for (uint32_t i = 0; i < bed.particle_count; ++i) EXPECT_GT(distance(before, i, bed.positions(), i), 0.4) << i;
}

TEST(Sleep, NewFrictionWakesAll) {
  GranularScene bed = sleeping_bed(8);
  accept(bed.scene.set_friction(0.1f, 0.1f));
  EXPECT_EQ(bed.frame(k_frame).sand.awake, bed.particle_count);
}

TEST(Sleep, GrainsSleepOnSleepersAndWakeBesideTheHand) {
  if (SANDGLASS_EMULATED != 0) GTEST_SKIP() << "minutes under emulation; the kernels are compared there to the bit";
  const std::vector<float> particles = loose_bed(40), grains = grains_about(particles, 0.5f * k_radius);
  GranularScene bed(description(40 * 40 * 3, static_cast<uint32_t>(grains.size() / 3)));
  bed.add(particles, {}, grains);
  bed.add_floor();
  sandglass_frame_report report = {};
  for (int frame = 0; frame < 600; ++frame) {
    report = bed.frame(k_frame);
    if (report.sand.awake + report.sand.awake_grains == 0) break;
  }
  ASSERT_EQ(report.sand.awake, 0u);
  ASSERT_EQ(report.sand.awake_grains, 0u);
  report = bed.frame(k_frame);
  EXPECT_EQ(report.stages[SANDGLASS_STAGE_REFINE].units, 0u);
  EXPECT_EQ(report.sand.grain_lag, 0.0f);

  const std::vector<sandglass_grain> before = bed.grains;
  bed.colliders.push_back(sandglass::sphere(0.4f, 0.1f, 0.4f, 0.03f));
  bed.colliders.back().linear_velocity[1] = -0.1f;
  uint32_t awake_max = 0;
  for (int frame = 0; frame < 17; ++frame) {
    bed.colliders.back().position[1] -= 0.1f * k_frame;
    awake_max = std::max(awake_max, bed.frame(k_frame).sand.awake_grains);
  }
  EXPECT_GT(awake_max, 0u);
  EXPECT_LT(awake_max, report.sand.grains / 3);
  uint32_t moved = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    const double dx = static_cast<double>(before[i].position[0]) - 0.4,
                 dz = static_cast<double>(before[i].position[2]) - 0.4;
    const bool same = std::equal(before[i].position, before[i].position + 3, bed.grains[i].position);
    EXPECT_TRUE(same || std::hypot(dx, dz) < 0.25) << i;
    moved += same ? 0 : 1;
    const float *grain = bed.grains[i].position, *hand = bed.colliders.back().position;
    EXPECT_GT(std::hypot(grain[0] - hand[0], grain[1] - hand[1], grain[2] - hand[2]), 0.03f) << "inside the hand";
  }
  EXPECT_GT(moved, 50u);
}

// Particles to a side of a cube that falls down, on the spacing that sandglass_scene_add recommends or loose.
struct Fallen {
  double spread = 0.0,
         rest = 0.0;  // metres from the middle, rms; seconds until a twentieth of the greatest energy is left
  uint32_t awake = 0;
};
Fallen fall(uint32_t wide, bool loose, float sleep_after) {
  sandglass_scene_desc desc = description(wide * wide * wide);
  desc.granular.sleep_after = sleep_after;
  GranularScene scene(desc);
  std::vector<float> points;
  const float step = (loose ? 2.3f : 2.0f) * k_radius, middle = 0.5f * static_cast<float>(wide - 1);
  for (uint32_t i = 0; i < wide * wide * wide; ++i)
    for (const uint32_t at : {i % wide, i / wide / wide, i / wide % wide}) {
      const float shake = loose ? 0.14f * k_radius * std::sin(12.9898f * static_cast<float>(points.size())) : 0.0f;
      const float from = points.size() % 3 == 1 ? -1.0f : middle;
      points.push_back(step * (static_cast<float>(at) - from) + shake);
    }
  scene.add(shifted(points, 0.0f, k_radius - step, 0.0f));
  scene.add_floor();
  Fallen fallen;
  std::vector<double> energy;
  for (int frame = 0; frame < 450; ++frame) {
    fallen.awake = scene.frame(k_frame).sand.awake;
    energy.push_back(0.0);
    for (const float v : scene.velocities()) energy.back() += static_cast<double>(v * v);
  }
  const double energy_max = *std::max_element(energy.begin(), energy.end());
  for (size_t i = 0; i < energy.size(); ++i)
    if (energy[i] > 0.05 * energy_max) fallen.rest = static_cast<double>(k_frame) * static_cast<double>(i + 1);
  const std::vector<float> p = scene.positions();
  for (size_t i = 0; i < p.size(); i += 3) fallen.spread += static_cast<double>(p[i] * p[i] + p[i + 2] * p[i + 2]);
  fallen.spread = std::sqrt(fallen.spread / scene.particle_count);
  return fallen;
}

// A lattice of 2 r leans for two seconds before it falls. What sleeps comes as far, and to rest as soon, as what does not.
TEST(Sleep, WhatWouldFallDoesNotSleep) {
  if (SANDGLASS_EMULATED != 0) GTEST_SKIP() << "minutes under emulation; the kernels are compared there to the bit";
  for (const uint32_t wide : {8u, 10u})
    for (const bool loose : {false, true}) {
      const Fallen truth = fall(wide, loose, 0.0f), slept = fall(wide, loose, 0.5f);
      EXPECT_NEAR(slept.spread, truth.spread, 0.2 * truth.spread) << wide << loose;
      EXPECT_NEAR(slept.rest, truth.rest, 0.2 * truth.rest) << wide << loose;
      EXPECT_LE(slept.awake, wide * wide * wide / 20) << wide << loose;
    }
}

}  // namespace
