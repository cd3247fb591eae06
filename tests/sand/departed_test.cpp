// What has left: it costs nothing while it falls, is removed once it has fallen far, and stands in no move's way. And
// sleep needs a contact: nothing hangs in the air.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_radius = 0.01f, k_frame = 1.0f / 60.0f;
constexpr double k_gravity = 9.81;

// The sub-steps of a frame while nothing is fast: the longest are 0.01742 sqrt(r/g), as the header says.
double calm_substeps(double radius) { return std::ceil(k_frame / (0.01742 * std::sqrt(radius / k_gravity)) - 1e-4); }

sandglass_collider table(float width) {
  return sandglass::box(0, -width / 12, 0, 0.5f * width, width / 12, 0.5f * width);
}

struct Cost {
  double substeps = 0, builds = 0;  // the most of a frame, and the mean
};
template <class Frame>
Cost cost_of(int frames, const Frame& frame) {
  Cost cost;
  for (int i = 0; i < frames; ++i) {
    const sandglass_frame_report report = frame();
    cost.substeps = std::max(cost.substeps, static_cast<double>(report.sand.substeps));
    cost.builds += report.sand.list_builds / static_cast<double>(frames);
  }
  return cost;
}

// Sand is poured on a table of 24 radii for as long as it takes to fall 50 radii some times over; it spills. Without a
// clock, so the cost is what is counted.
struct Spill {
  explicit Spill(float radius = k_radius, uint32_t grains = 0, sandglass_scene_desc desc = description(3000, 24000))
      : scene([&] {
          desc.granular.particle_radius = radius;
          desc.granular.emitter_capacity = 1;
          return desc;
        }()),
        nozzle(sandglass::emitter(0, 40 * radius, 0, 5 * radius, 5 * std::sqrt(radius), grains)) {
    scene.colliders = {table(24 * radius)};
  }
  sandglass_frame_report frame() {
    scene.emitters.assign(pours ? 1 : 0, nozzle);
    return scene.frame(k_frame);
  }
  Cost run(int frames) {
    return cost_of(frames, [&] { return report = frame(); });
  }
  std::vector<float> heights() const {
    const std::vector<float> at = scene.positions();
    std::vector<float> y;
    for (size_t i = 1; i < at.size(); i += 3)
      if (at[i] != SANDGLASS_REMOVED_Y) y.push_back(at[i]);
    return y;
  }
  GranularScene scene;
  sandglass_emitter nozzle;
  bool pours = true;
  sandglass_frame_report report;
};

TEST(Departed, SandThatSpillsCostsNoMoreSubstepsOrListsThanSandThatLands) {
  for (const float radius : {0.002f, 0.01f, 0.05f}) {
    Spill spills(radius), lands(radius), far(radius);
    lands.scene.colliders.push_back(sandglass::floor_at(-75 * radius));
    // The rule before holds where something is under it all: (4.45) counts every faller.
    far.scene.colliders.push_back(sandglass::floor_at(-6000 * radius));
    const int frames = static_cast<int>(150 * std::sqrt(radius / 0.01f));
    const Cost landing = lands.run(frames), spilling = spills.run(frames), falling = far.run(frames);
    EXPECT_LE(spilling.substeps, calm_substeps(static_cast<double>(radius))) << radius;
    EXPECT_LE(spilling.builds, landing.builds) << radius;
    EXPECT_GT(falling.substeps, 2 * calm_substeps(static_cast<double>(radius))) << radius;
    EXPECT_GT(falling.builds, 2 * landing.builds) << radius;
    const std::vector<float> at = spills.heights();  // and it did spill
    EXPECT_LT(*std::min_element(at.begin(), at.end()), -400 * radius);
  }
}

TEST(Departed, WhatFallsFreelyKeepsItsSpeedAboveTheLimit) {
  // Fast particles are slowed to courant r / substep_min: 8 m/s here, which a fall of 3.3 m exceeds.
  sandglass_scene_desc desc = description(1);
  desc.granular.particle_radius = 0.0005f;
  desc.granular.lowest = 0;
  GranularScene scene(desc);
  scene.colliders = {table(0.1f)};
  scene.add({0.2f, 0.0f, 0.0f});
  for (int i = 0; i < 120; ++i) scene.frame(k_frame);
  const double fall = 0.5 * k_gravity * 4.0;
  EXPECT_NEAR(static_cast<double>(scene.positions()[1]), -fall, 1e-3 * fall);
  EXPECT_GT(-scene.velocities()[1], 2 * 0.5 * 0.0005 / (0.25 * 0.01742 * std::sqrt(0.0005 / k_gravity)));
}

// A heap asleep on a floor.
GranularScene heap() {
  GranularScene scene(description(600));
  scene.add(lattice(8, 4, 8, 2.02f * k_radius, k_radius));
  scene.add_floor();
  until_asleep(&scene, k_frame);
  return scene;
}

TEST(Departed, AFastParticleThatReachesNothingDrivesNobody) {
  GranularScene scene = heap();
  sandglass_collider ball = sandglass::sphere(20, 2, 0, 1);  // over which it flies: a box around all would hold it
  scene.colliders.insert(scene.colliders.begin(), ball);
  ball.position[1] = 14;
  scene.colliders.insert(scene.colliders.begin(), ball);
  scene.add({0.3f, 0.3f, 0.0f}, {20.0f, 12.0f, 0.0f});  // up and away
  const Cost cost = cost_of(120, [&] { return scene.frame(k_frame); });
  EXPECT_LE(cost.substeps, calm_substeps(0.01));
  EXPECT_LE(cost.builds, 4.01 / 120);
  // The rule before holds for a flow: more than 64 of them.
  GranularScene flow = heap();
  for (int i = 0; i < 65; ++i) flow.add({0.5f + 0.2f * static_cast<float>(i), 0.3f, 0.0f}, {20.0f, 12.0f, 0.0f});
  EXPECT_GT(flow.frame(k_frame).sand.substeps, 2 * calm_substeps(0.01));
  const std::vector<float> at = scene.positions();
  EXPECT_NEAR(static_cast<double>(at[at.size() - 3]), 40.3, 0.05);
  EXPECT_NEAR(static_cast<double>(at[at.size() - 2]), 0.3 + 24.0 - 2 * k_gravity, 0.05);
}

TEST(Departed, AFastParticleThatReachesSandObeysTheCourantLimitThere) {
  GranularScene scene = heap();
  const float top = scene.positions()[1];
  scene.add({2.0f, 2.0f, 0.0f}, {-20.0f, -20.0f, 0.0f});  // at the heap, from 2.8 m away
  bool met = false;
  for (int i = 0; i < 30; ++i) {
    const std::vector<float> before = scene.velocities();
    const double speed =
        std::hypot(static_cast<double>(before[before.size() - 3]), static_cast<double>(before[before.size() - 2]));
    const std::vector<float> from = scene.positions();
    const sandglass_frame_report report = scene.frame(k_frame);
    const bool reaches =
        std::hypot(static_cast<double>(from[from.size() - 3]), static_cast<double>(from[from.size() - 2] - top)) <
        speed * static_cast<double>(k_frame);
    if (!reaches || speed < 15.0) continue;
    met = true;
    EXPECT_LE(static_cast<double>(report.sand.substep) * speed, 0.5 * 0.01 * 1.001);
  }
  EXPECT_TRUE(met);
  EXPECT_GT(scene.frame(k_frame).sand.awake, 0u);  // and it woke the heap
}

TEST(Departed, TwoFastParticlesThatMeetInTheAirCollide) {
  GranularScene scene = heap();
  scene.add({-1.0f, 3.0f, 0.0f, 1.0f, 3.0f, 0.0f}, {20.0f, 3.0f, 0.0f, -20.0f, 3.0f, 0.0f});
  for (int i = 0; i < 10; ++i) scene.frame(k_frame);
  const std::vector<float> at = scene.positions();
  EXPECT_LT(at[at.size() - 6], at[at.size() - 3]);  // they did not pass
  const std::vector<float> v = scene.velocities();
  EXPECT_LT(std::fabs(v[v.size() - 3]), 2.0f);
}

// ---- lowest

TEST(Lowest, WhatFellSoFarIsRemovedWithItsGrainsAndCounted) {
  sandglass_scene_desc desc = description(4000, 32000);
  desc.granular.lowest = 3;
  Spill spill(k_radius, 8, desc);
  const float bottom = -0.04f;
  spill.run(180);
  spill.pours = false;
  EXPECT_GT(spill.report.sand.removed_particles, 100u);
  EXPECT_GT(spill.report.sand.removed_grains, 100u);
  // At 8 m/s a check every 20 ms is up to 16 cm late; what is there is above.
  for (const float y : spill.heights()) EXPECT_GT(y, bottom - 3.2f);
  spill.run(240);
  EXPECT_EQ(spill.report.sand.awake, 0u);
  EXPECT_EQ(spill.report.sand.substeps, 0u);
  EXPECT_EQ(spill.report.sand.particles + spill.report.sand.removed_particles, spill.report.sand.emitted_particles);
  EXPECT_EQ(spill.report.sand.grains + spill.report.sand.removed_grains, spill.report.sand.emitted_grains);
  EXPECT_GT(spill.report.sand.particles, 20u);  // what lies on the table stays
}

// How many of two particles beside a table are left after 3 s of falling, 44 m.
uint32_t left_after_a_fall(float lowest, const std::vector<sandglass_collider>& colliders,
                           std::initializer_list<float> gravity = {0, -9.81f, 0}) {
  sandglass_scene_desc desc = description(2);
  desc.granular.lowest = lowest;
  std::copy(gravity.begin(), gravity.end(), desc.gravity);
  GranularScene scene(desc);
  scene.colliders = colliders;
  scene.add({0.3f, 0.0f, 0.0f, 0.3f, 0.0f, 0.3f}, {0, 0, 0, 0, 0, 0});
  sandglass_frame_report report = {};
  for (int i = 0; i < 180; ++i) report = scene.frame(k_frame);
  return report.sand.particles;
}

TEST(Lowest, HoldsOnlyWhereThereIsSomethingToFallFromAndNothingUnderIt) {
  sandglass_collider wall = sandglass::floor_at(0);  // as AR finds it: a degree off the vertical, leaning back
  ASSERT_EQ(sandglass_rotation_about(std::initializer_list<float>{0, 0, 1}.begin(), -1.5533f, wall.rotation), 1);
  wall.position[0] = -2;
  EXPECT_EQ(left_after_a_fall(20, {table(0.24f)}), 0u);
  EXPECT_EQ(left_after_a_fall(20, {table(0.24f), wall}), 0u);
  EXPECT_EQ(left_after_a_fall(20, {table(0.24f)}, {9.81f, 0, 0}), 0u);  // along gravity, wherever that points
  EXPECT_EQ(left_after_a_fall(50, {table(0.24f)}), 2u);
  EXPECT_EQ(left_after_a_fall(0, {table(0.24f)}), 2u);
  EXPECT_EQ(left_after_a_fall(20, {}), 2u);
  EXPECT_EQ(left_after_a_fall(20, {table(0.24f), sandglass::floor_at(-100)}), 2u);
  EXPECT_EQ(left_after_a_fall(20, {table(0.24f)}, {0, 0, 0}), 2u);
}

TEST(Lowest, BeyondTheCoordinateLimitNothingHangsInTheAir) {
  GranularScene scene(description(2, 1));
  scene.add({0, -990.0f, 0, 0, 0, 0}, {0, -30.0f, 0, 0, 0, 0}, {0, -990.0f, 0}, {0, -30.0f, 0});
  sandglass_frame_report report = {};
  for (int i = 0; i < 60; ++i) {
    report = scene.frame(k_frame);
    ASSERT_EQ(report.sand.quarantined, 0u);
  }
  EXPECT_EQ(report.sand.particles, 1u);
  EXPECT_EQ(report.sand.removed_particles, 1u);
  EXPECT_EQ(report.sand.removed_grains, 1u);
}

TEST(Move, LosesWhatHasLeftAndRefusesToLoseAnythingElse) {
  sandglass_scene_desc desc = description(3);
  desc.granular.lowest = 0;
  GranularScene scene(desc);
  scene.colliders = {table(0.24f)};
  scene.add({0, 0.01f, 0, 0.5f, -990.0f, 0});
  for (int i = 0; i < 60; ++i) scene.frame(k_frame);
  accept(scene.scene.move({0, 0, 0, 1}, {0, -20.0f, 0}));
  EXPECT_EQ(scene.positions()[4], SANDGLASS_REMOVED_Y);
  EXPECT_NEAR(scene.positions()[1], -19.99f, 1e-3f);
  EXPECT_EQ(scene.scene.move({0, 0, 0, 1}, {0, -990.0f, 0}).code, SANDGLASS_ERROR_INVALID_ARGUMENT);  // what rests
}

TEST(Departed, ABodyThatFallsBesideATableDrivesNobodyAndFallsFreely) {
  sandglass_scene_desc desc = with_bodies(0, 1, 27);
  desc.granular.lowest = 0;
  GranularScene scene(desc);
  scene.colliders = {table(0.24f)};
  const uint32_t body = scene.add_body(shifted(lattice(3, 3, 3, 2 * k_radius, k_radius), 0.3f, 0.0f, 0.0f));
  const float from = scene.scene.body_pose(body).position[1];
  const Cost cost = cost_of(120, [&] { return scene.frame(k_frame); });
  EXPECT_LE(cost.substeps, calm_substeps(0.01));
  EXPECT_LE(cost.builds, 2.01 / 120);
  EXPECT_NEAR(static_cast<double>(scene.scene.body_pose(body).position[1] - from), -2 * k_gravity, 0.02);
}

// ---- sleep needs a contact

// The longest that a particle in the air is within 10 % of r of one place: the rule before took that for rest.
double longest_stay(double radius) { return (1 + std::sqrt(2.0)) * std::sqrt(2 * 0.1 * radius / k_gravity); }

// The most awake and the fewest awake of a particle or body thrown up, until it is back at half its height.
uint32_t fewest_awake(float radius, float sleep_after, const std::vector<float>& points, bool body) {
  sandglass_scene_desc desc = with_bodies(8, 1, 8);
  desc.granular.particle_radius = radius;
  desc.granular.sleep_after = sleep_after;
  GranularScene scene(desc);
  scene.add_floor();
  const float speed = 4 * std::sqrt(radius);
  std::vector<float> velocities(points.size(), 0.0f);
  for (size_t i = 1; i < points.size(); i += 3) velocities[i] = speed;
  if (body) scene.add_body(points, 1, {0, speed, 0});
  else scene.add(points, velocities);
  uint32_t fewest = ~0u;
  const int frames = static_cast<int>(2 * static_cast<double>(speed) / k_gravity / static_cast<double>(k_frame));
  for (int i = 0; i < frames; ++i) fewest = std::min(fewest, scene.frame(k_frame).sand.awake);
  return fewest;
}

TEST(Sleep, NothingFallsAsleepInTheAir) {
  EXPECT_GT(longest_stay(10), 0.5);  // the control: by the rule before these did
  EXPECT_GT(longest_stay(3), 0.5);
  EXPECT_GT(longest_stay(0.01), 0.02);
  for (const bool body : {false, true}) {
    for (const float radius : {1.0f, 3.0f, 10.0f}) {
      EXPECT_EQ(fewest_awake(radius, 0.5f, {0, 5 * radius, 0}, body), 1u) << radius;
      // Two that touch each other fly as one does.
      EXPECT_EQ(fewest_awake(radius, 0.5f, {0, 5 * radius, 0, 0, 7 * radius, 0}, body), 2u) << radius;
    }
    for (const float after : {0.02f, 0.03f, 0.04f, 0.06f, 0.1f}) {
      EXPECT_EQ(fewest_awake(k_radius, after, {0, 5 * k_radius, 0}, body), 1u) << after;
      EXPECT_EQ(fewest_awake(k_radius, after, {0, 5 * k_radius, 0, 0, 7 * k_radius, 0}, body), 2u) << after;
    }
  }
}

TEST(Sleep, WhatTouchesAFloorABoxTheBoundaryOrSandSleepsAndSoDoesWhatFloatsWithoutGravity) {
  const auto awake_at_last = [](GranularScene* scene) {
    sandglass_frame_report report = {};
    for (int i = 0; i < 180; ++i) report = scene->frame(k_frame);
    return report.sand.awake;
  };
  for (const float radius : {0.01f, 1.0f, 10.0f}) {
    sandglass_scene_desc desc = description(2, 0, 1);
    desc.granular.particle_radius = radius;
    GranularScene floor(desc), box(desc), boundary(desc), alone(desc);
    floor.add_floor();
    box.colliders = {table(10 * radius)};
    const float sample[3] = {0, -radius, 0};
    const char* reason = nullptr;
    ASSERT_EQ(sandglass_scene_set_boundary(boundary.scene.get(), sample, 1, &reason), SANDGLASS_OK) << reason;
    for (GranularScene* scene : {&floor, &box}) scene->add({0, radius, 0, 0, 3 * radius, 0});
    boundary.add({0, radius, 0});
    alone.add({0, 5 * radius, 0});
    for (GranularScene* scene : {&floor, &box, &boundary}) EXPECT_EQ(awake_at_last(scene), 0u) << radius;
    EXPECT_EQ(awake_at_last(&alone), 1u) << radius;  // the control
    desc.gravity[1] = 0;
    GranularScene floats(desc);
    floats.add({0, 5 * radius, 0});
    EXPECT_EQ(awake_at_last(&floats), 0u) << radius;
  }
}

}  // namespace
