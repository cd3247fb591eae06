// A frame without a time step is a pause: a still picture, whatever is owed. What was owed is made up afterwards.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "platform/virtual_clock.h"
#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_frame = 0.02f;
constexpr float k_pauses[] = {0.0f, -0.0f, -1.0f, NAN, INFINITY, -INFINITY};

// Sand and a body that fall, a nozzle and a sink, by a clock that counts its readings.
struct Falling {
  explicit Falling(bool clocked)
      : scene([&] {
          sandglass_scene_desc desc = description(2000, 4000);
          desc.unit_items = 128;
          desc.granular.body_capacity = 1;
          desc.granular.body_particle_capacity = 8;
          desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;
          if (clocked) desc.clock = sandglass::virtual_clock(&clock);
          return desc;
        }()) {
    scene.add_floor();
    const std::vector<float> sand = lattice(8, 8, 8, 0.0203f, 0.1f);
    scene.add(sand, {}, copies(sand, 4, 0.003f));
    scene.grains.resize(4000);
    scene.add_body(lattice(2, 2, 2, 0.0201f, 0.5f));
    scene.colliders.push_back(sandglass::sphere(-0.2f, 0.1f, 0.1f, 0.05f));
    scene.emitters = {sandglass::emitter(0.5f, 0.5f, 0.0f, 0.03f, 1.0f, 2)};
    scene.sinks = {sandglass::box(0.5f, 0.0f, 0.0f, 0.3f, 0.3f, 0.3f)};
  }

  // The ball moves, and pushes.
  sandglass_frame_report frame(float step, uint64_t budget_ns, const sandglass_plan* plan = nullptr) {
    if (step > 0.0f && std::isfinite(step)) scene.colliders[1].position[0] += step * 0.5f;
    scene.colliders[1].linear_velocity[0] = 0.5f;
    return scene.frame(step, budget_ns, plan);
  }

  sandglass::VirtualClock clock{.step_ns = 10'000};
  GranularScene scene;
};

// After every frame come pauses with room for all work. Not a bit changes in them, of the state or of what is drawn;
// the frames between are the control. And the whole is what the same plans give without the pauses.
TEST(Pause, NothingMovesAndTheDebtIsMadeUpAsIfThereHadBeenNone) {
  Falling paused(true);
  std::vector<sandglass_plan> plans;
  double debt_max = 0.0;
  float lag_max = 0.0f;
  for (int frame = 0; frame < 40; ++frame) {
    const sandglass_frame_report before = paused.frame(k_frame, frame < 30 ? 1'500'000 : ~0ull >> 1);
    plans.push_back(before.plan);
    const uint64_t hash = paused.scene.hash();
    const sandglass_body_pose pose = paused.scene.scene.body_pose(0);
    const std::vector<sandglass_grain> drawn = paused.scene.grains;
    for (const float step : k_pauses) {
      const sandglass_frame_report report = paused.frame(step, ~0ull >> 1);
      ASSERT_EQ(paused.scene.hash(), hash) << step;
      ASSERT_EQ(std::memcmp(drawn.data(), paused.scene.grains.data(), drawn.size() * sizeof drawn[0]), 0) << step;
      const sandglass_body_pose now = paused.scene.scene.body_pose(0);
      ASSERT_EQ(std::memcmp(&now, &pose, sizeof now), 0);
      ASSERT_EQ(report.time.simulated, before.time.simulated);
      ASSERT_EQ(report.time.debt, before.time.debt);
      ASSERT_EQ(report.sand.grain_lag, before.sand.grain_lag);
      ASSERT_EQ(report.sand.emitted_particles, before.sand.emitted_particles);
      ASSERT_EQ(report.stages[SANDGLASS_STAGE_GRANULAR].units + report.stages[SANDGLASS_STAGE_REFINE].units, 0u);
      ASSERT_EQ(report.stages[SANDGLASS_STAGE_GRANULAR].denied, 0u);
    }
    debt_max = std::max(debt_max, before.time.debt);
    lag_max = std::max(lag_max, before.sand.grain_lag);
  }
  EXPECT_GT(debt_max, 2.0 * static_cast<double>(k_frame)) << "nothing was owed";
  EXPECT_GT(lag_max, 0.0f) << "no grain was behind";
  Falling whole(false);
  uint32_t moved = 0;
  for (const sandglass_plan& plan : plans) {
    const uint64_t before = whole.scene.hash();
    whole.frame(k_frame, 0, &plan);
    moved += whole.scene.hash() != before ? 1 : 0;
  }
  EXPECT_GT(moved, 30u) << "nothing would have moved anyway";
  EXPECT_EQ(whole.scene.hash(), paused.scene.hash());
}

TEST(Pause, WhatMovesInItWakesSandWhenTimeGoesOn) {
  GranularScene scene(description(75));
  scene.add_floor();
  scene.add(lattice(5, 3, 5, 0.0202f, 0.01f));
  for (int frame = 0; frame < 200; ++frame) scene.frame(k_frame);
  scene.colliders[0].position[1] = -0.05f;
  for (const float step : k_pauses) EXPECT_EQ(scene.frame(step).sand.awake, 0u);
  uint32_t awake = 0;
  for (int frame = 0; frame < 3; ++frame) awake = scene.frame(k_frame).sand.awake;  // fewer frames are an outlier
  EXPECT_EQ(awake, 75u);
}

}  // namespace
