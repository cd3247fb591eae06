// Emitters, sinks and removal. Everything that an emitter adds is either in the scene or counted as removed, and the
// numbers of removed particles are used again.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_radius = 0.01f, k_frame = 0.02f;

struct Flow {
  Flow(uint32_t particles, uint32_t grains_per_particle)
      : scene([&] {
          sandglass_scene_desc desc = description(particles, particles * grains_per_particle);
          desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;
          desc.log = {[](void* user, const char* sentence) { *static_cast<const char**>(user) = sentence; }, &said};
          return desc;
        }()) {
    emitter = sandglass::emitter(0.0f, 0.5f, 0.0f, 0.04f, 1.0f, grains_per_particle);
    if (grains_per_particle != 0) scene.grains.resize(static_cast<size_t>(particles) * grains_per_particle);
  }

  sandglass_frame_report frame() {
    scene.emitters.assign(pours ? 1 : 0, emitter);
    scene.sinks.assign(drains ? 1 : 0, sink);
    return scene.frame(k_frame);
  }

  const char* said = nullptr;  // the last sentence of the log
  GranularScene scene;
  sandglass_emitter emitter;
  sandglass_collider sink = sandglass::floor_at(-0.3f);
  bool pours = true, drains = true;
};

TEST(Sink, WhatComesIsThereOrGoneAndNumbersAreUsedAgain) {
  Flow flow(600, 4);
  flow.scene.colliders.push_back(sandglass::floor_at(-10.0f));
  sandglass_frame_report report = {};
  for (int frame = 0; frame < 300; ++frame) {
    report = flow.frame();
    ASSERT_EQ(report.sand.emitted_particles, report.sand.particles + report.sand.removed_particles) << frame;
    ASSERT_EQ(report.sand.emitted_grains, report.sand.grains + report.sand.removed_grains) << frame;
    ASSERT_LE(report.sand.particle_numbers, 600u);
    std::set<uint32_t> present;
    for (uint32_t i = 0; i < report.sand.grain_numbers; ++i) {
      const sandglass_grain& grain = flow.scene.grains[i];
      if (grain.speed < 0.0f) {
        ASSERT_EQ(grain.position[1], SANDGLASS_REMOVED_Y);
      } else {
        present.insert(i);
        // The checks are a frame apart, so a grain falls below the sink for at most one frame.
        ASSERT_GT(grain.position[1], -0.3f - 2.0f * 4.0f * k_frame - 0.1f);
      }
    }
    ASSERT_EQ(present.size(), report.sand.grains);
  }
  EXPECT_GT(report.sand.removed_particles, 600u) << "more than fit at once have passed";
  EXPECT_GT(report.sand.removed_grains, 2400u);
}

// The budget ends in the midst of a sub-step; then the nozzle closes, and the sink has taken all.
TEST(Sink, TimeGoesOnWhenNothingIsLeft) {
  uint64_t now = 0;
  sandglass_scene_desc desc = description(64);
  desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;
  desc.clock = {[](void* user) { return *static_cast<uint64_t*>(user); }, &now};
  desc.trace = {nullptr, [](void* user, const char*) { *static_cast<uint64_t*>(user) += 20'000; }, &now};
  uint32_t emptied = 0;
  for (int frames = 1; frames <= 40; ++frames) {
    GranularScene scene(desc);
    scene.emitters = {sandglass::emitter(0.0f, 0.5f, 0.0f, 0.01f, 0.3f, 0)};
    scene.sinks = {sandglass::floor_at(1.0f)};  // everywhere
    sandglass_frame_report report = {};
    for (int frame = 0; frame < frames; ++frame) report = scene.frame(k_frame, 500'000);
    emptied += report.sand.particles == 0 && report.sand.emitted_particles != 0 ? 1 : 0;
    scene.emitters.clear();
    const double before = report.time.simulated;
    for (int frame = 0; frame < 10; ++frame) report = scene.frame(k_frame);
    EXPECT_GT(report.time.simulated, before + 9 * static_cast<double>(k_frame)) << frames;
  }
  EXPECT_GT(emptied, 0u);
}

TEST(Emitter, WithoutRoomALayerIsLeftOutAndCounted) {
  Flow flow(100, 2);
  flow.drains = false;
  flow.scene.add_floor();
  sandglass_frame_report report = {};
  for (int frame = 0; frame < 60; ++frame) report = flow.frame();
  EXPECT_STREQ(flow.said,
               "granular: an emitter poured less than it should: raise particle_capacity or grain_capacity, "
               "pass a sink, or clear the place before its nozzle.");
  EXPECT_LE(report.sand.particles, 100u);
  EXPECT_GT(report.sand.particles, 80u);
  EXPECT_GT(report.sand.denied_particles, 100u);
  EXPECT_EQ(report.sand.grains, 2 * report.sand.particles);
}

// The widest nozzles at the greatest speed, of the finest sand, and room for nothing: in a frame of 0.1 s each lets go of
// tens of thousands of layers of ten thousand particles. Counting them all takes many seconds.
TEST(Emitter, LayersThatFindNoRoomCostNothing) {
  sandglass_scene_desc desc = description(16);
  desc.granular.particle_radius = 1e-4f;
  desc.granular.substep_min = 1e-6f;  // which bounds the speed
  desc.granular.emitter_capacity = 64;
  GranularScene scene(desc);
  scene.emitters.assign(64, sandglass::emitter(0.0f, 0.5f, 0.0f, 0.01f, 100.0f, 0));
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_GT(scene.frame(0.1f).sand.denied_particles, 1'000'000'000u);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
}

// What was left out, a decimal digit each: colliders, emitters, sinks.
uint32_t left_out(const sandglass_sand_report& s) {
  return 100 * s.ignored_colliders + 10 * s.ignored_emitters + s.ignored_sinks;
}

TEST(Emitter, WhatMakesNoSenseIsLeftOutAndReported) {
  Flow flow(100, 0);
  const sandglass_emitter good = flow.emitter;
  const auto ignored = [&](const auto& change) {
    flow.emitter = good;
    change(&flow.emitter);
    return left_out(flow.frame().sand);
  };
  EXPECT_EQ(ignored([](sandglass_emitter* e) { e->position[1] = NAN; }), 10u);
  EXPECT_EQ(ignored([](sandglass_emitter* e) { e->position[1] = 2000.0f; }), 10u);
  EXPECT_EQ(ignored([](sandglass_emitter* e) { e->speed = 0.0f; }), 10u);
  EXPECT_EQ(ignored([](sandglass_emitter* e) { e->radius = 0.001f; }), 10u);
  EXPECT_EQ(ignored([](sandglass_emitter* e) { e->rotation[3] = 0.0f; }), 10u);
  EXPECT_EQ(ignored([](sandglass_emitter* e) { e->grains_per_particle = 65; }), 10u);
  flow.sink.position[0] = INFINITY;
  EXPECT_EQ(ignored([](sandglass_emitter*) {}), 1u);
  flow.drains = false;
  flow.scene.colliders.assign(1, flow.sink);
  EXPECT_EQ(ignored([](sandglass_emitter*) {}), 100u);
}

TEST(Remove, TakesWhatIsInsideAndWakesTheRest) {
  sandglass_scene_desc desc = description(1200, 1200);
  GranularScene scene(desc);
  const std::vector<float> bed = lattice(20, 3, 20, 2.02f * k_radius, k_radius);
  scene.add(bed, {}, bed);
  scene.add_floor();
  until_asleep(&scene);
  const std::vector<float> before = scene.positions();
  sandglass_collider ball = sandglass::sphere(0.2f, 0.0f, 0.2f, 0.08f);
  uint32_t expected = 0, removed = 0, grains = 0;
  for (size_t i = 0; i < before.size(); i += 3) {
    const double d = std::hypot(static_cast<double>(before[i]) - 0.2, static_cast<double>(before[i + 1]),
                                static_cast<double>(before[i + 2]) - 0.2);
    expected += d < static_cast<double>(0.08f) ? 1 : 0;
  }
  ASSERT_TRUE(scene.scene.remove(ball, &removed, &grains));
  EXPECT_EQ(removed, expected);
  EXPECT_GT(removed, 50u);
  EXPECT_GT(grains, 20u);
  const sandglass_frame_report report = scene.frame(k_frame);
  EXPECT_EQ(report.sand.particles, 1200u - removed);
  EXPECT_EQ(report.sand.awake, 1200u - removed);
  EXPECT_EQ(report.sand.particle_numbers, 1200u);
  const std::vector<float> after = scene.positions();
  uint32_t gone = 0;
  for (size_t i = 1; i < after.size(); i += 3) gone += after[i] == SANDGLASS_REMOVED_Y ? 1 : 0;
  EXPECT_EQ(gone, removed);
  // New particles take over their numbers.
  scene.add(std::vector<float>(3ull * removed, 0.5f));
  EXPECT_EQ(scene.frame(k_frame).sand.particle_numbers, 1200u);
  ball.size[0] = NAN;
  EXPECT_EQ(scene.scene.remove(ball).code, SANDGLASS_ERROR_INVALID_ARGUMENT);
}

TEST(Output, LagsByTheTimeAskedFor) {
  Flow flow(600, 4);
  flow.drains = false;
  for (int frame = 0; frame < 5; ++frame) flow.frame();
  flow.pours = false;
  flow.frame();
  const std::vector<sandglass_grain> newest = flow.scene.grains;
  std::vector<float> positions(3 * 600 * 4), velocities(3 * 600 * 4);
  sandglass_scene_grains(flow.scene.scene.get(), positions.data(), velocities.data());
  // A frame without time draws the same state as it was 4 ms earlier.
  sandglass_frame_input input = flow.scene.input(0.0f);
  input.output_lag = 0.004f;
  flow.scene.run(input);
  for (size_t i = 0; i < 20; ++i)
    for (size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(flow.scene.grains[i].position[k], newest[i].position[k] - 0.004f * velocities[3 * i + k], 1e-7);
}

// Without particles nothing drains, whatever room a scene has for sinks.
TEST(Sink, OfASceneWithoutParticlesIsIgnored) {
  sandglass_scene_desc desc = description(0);
  desc.granular.sink_capacity = desc.granular.emitter_capacity = 2;
  GranularScene scene(desc);
  scene.sinks = {sandglass::sphere(0, 0, 0, 1)};
  scene.emitters = {sandglass::emitter(0, 1, 0, 0.1f, 1, 0)};
  for (int frame = 0; frame < 3; ++frame) EXPECT_EQ(left_out(scene.frame(0.01f).sand), 11u) << "the nozzle, too";
}

}  // namespace
