// The budget law for random scenes. Stages have random work units, kinds, shares and mandatory parts, and may block
// each other. Costs range over six orders of magnitude, and budgets are random. Every frame keeps the law by the
// scene's own ledger of costs, does its mandatory work, writes its output, and replays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "fake_scene.h"

namespace sandglass::governor_test {
namespace {

struct RandomScene;

struct RandomStage {
  RandomScene* scene = nullptr;
  uint32_t index = 0;
  uint32_t units = 0;
  uint32_t done = 0;
  uint32_t kinds = 1;
  // After this many work units the stage waits until the other one has caught up. 0: it never waits.
  uint32_t gate = 0;
  uint64_t base_ns = 0;
};

struct RandomScene {
  uint64_t now_ns = 0;
  Random random{{0}};
  uint64_t run_ns[3] = {};
  std::vector<uint8_t> order;
  RandomStage stages[3];
};

uint32_t kind_of(const RandomStage& stage) { return stage.done % stage.kinds; }

bool random_next(const void* state, uint32_t, WorkUnit* unit) {
  const RandomStage* self = static_cast<const RandomStage*>(state);
  *unit = {kind_of(*self), 64, "random"};
  if (self->done >= self->units) return false;
  if (self->gate == 0 || self->index == 2) return true;
  const RandomStage& other = self->scene->stages[1 - self->index];
  const bool other_ended = other.done >= other.units;
  return other_ended || self->done / self->gate <= other.done;
}

void random_run(void* state, uint32_t) {
  RandomStage* self = static_cast<RandomStage*>(state);
  RandomScene* scene = self->scene;
  uint64_t cost = self->base_ns * (1 + kind_of(*self));
  const uint64_t luck = scene->random.below(1000);
  if (luck < 5) cost *= 1000;
  else if (luck < 30) cost *= 10;
  else cost = cost * (80 + luck % 41) / 100;
  scene->now_ns += cost;
  scene->run_ns[self->index] += cost;
  scene->order.push_back(static_cast<uint8_t>(self->index));
  ++self->done;
}

uint32_t random_forecast(const void* state, uint32_t, Forecast* entries) {
  const RandomStage* self = static_cast<const RandomStage*>(state);
  for (uint32_t k = 0; k < self->kinds; ++k) {
    entries[k] = {k, 64ull * ((self->units - self->done + self->kinds - 1 - k) / self->kinds)};
  }
  return self->kinds;
}

TEST(LawProperty, HoldsForRandomStagesAndCosts) {
  const uint32_t scenes = static_cast<uint32_t>(std::max<uint64_t>(k_case_frames / 1000, 50));
  uint64_t frames = 0;
  for (uint32_t seed = 1; seed <= scenes; ++seed) {
    RandomScene scene;
    scene.random.state = seed;
    Random& random = scene.random;
    Stage stages[3];
    for (uint32_t i = 0; i < 3; ++i) {
      RandomStage& stage = scene.stages[i];
      stage.scene = &scene;
      stage.index = i;
      stage.kinds = 1 + static_cast<uint32_t>(random.below(4));
      stage.gate = static_cast<uint32_t>(random.below(6));
      stage.base_ns = uint64_t{1} << (6 + random.below(14));
      const uint32_t mandatory = static_cast<uint32_t>(random.below(5));
      const float share = static_cast<float>(random.below(12)) / 10.0f;
      stages[i] = {&stage, random_next, random_run, random_forecast, stage.kinds, mandatory, share};
    }
    stages[2].mandatory_units = k_all_units;
    assign_kinds(stages, 3);
    const sandglass_clock clock = {[](void* user) { return *static_cast<uint64_t*>(user); }, &scene.now_ns};
    Governor governor;
    governor_init(&governor, clock, {}, 1 + static_cast<uint32_t>(random.below(3)));
    Governor replaying;
    governor_init(&replaying, {}, {}, governor.level_count);

    for (uint32_t frame = 0; frame < 64; ++frame, ++frames) {
      RandomScene before;
      for (uint32_t i = 0; i < 3; ++i) {
        scene.stages[i].units = static_cast<uint32_t>(random.below(i == 2 ? 8 : 120));
        scene.stages[i].done = 0;
        scene.run_ns[i] = 0;
        before.stages[i] = scene.stages[i];
        before.stages[i].scene = &before;
      }
      scene.order.clear();
      const uint64_t budget = random.below(4) == 0 ? random.below(1000) : random.below(8000000);
      const uint64_t start = scene.now_ns;
      sandglass_frame_report report = {};
      ASSERT_TRUE(governor_frame(&governor, stages, 3, budget, nullptr, &report));

      const uint64_t elapsed = scene.now_ns - start;
      if (report.time.clock_fault == 0) {
        ASSERT_EQ(report.time.elapsed_ns, elapsed);
        for (uint32_t i = 0; i < 3; ++i) ASSERT_EQ(report.stages[i].elapsed_ns, scene.run_ns[i]);
      }
      ASSERT_LE(report.time.elapsed_ns, std::max(budget, report.time.mandatory_ns) + report.time.last_unit_ns)
          << "seed " << seed;
      ASSERT_LE(governor.closing_excess_ns, scene.run_ns[2]);
      ASSERT_EQ(scene.stages[2].done, scene.stages[2].units);
      ASSERT_TRUE(budget != 0 || report.time.elapsed_ns == report.time.mandatory_ns);
      // A stage that nothing blocks has done its mandatory work units, or all of its work units if it had fewer.
      for (uint32_t i = 0; i < 2; ++i) {
        if (scene.stages[i].gate != 0) continue;
        ASSERT_GE(report.stages[i].units, std::min(stages[i].mandatory_units, scene.stages[i].units));
      }
      Stage replay_stages[3];
      for (uint32_t i = 0; i < 3; ++i) {
        replay_stages[i] = stages[i];
        replay_stages[i].state = &before.stages[i];
      }
      sandglass_frame_report replayed = {};
      ASSERT_TRUE(governor_frame(&replaying, replay_stages, 3, 0, &report.plan, &replayed));
      ASSERT_EQ(before.order, scene.order);
      ASSERT_EQ(std::memcmp(&replayed.plan, &report.plan, sizeof report.plan), 0);
      ASSERT_EQ(replayed.time.elapsed_ns, 0u);
    }
  }
  RecordProperty("frames", static_cast<int>(frames));
}

// The clock may do anything. Frames still end, the output is written, and memory stays valid.
TEST(LawProperty, SurvivesAClockOfRandomNumbers) {
  FakeRun run;
  const sandglass_frame_report& report = run.report;
  run.scene.show = [](FakeScene* self) { return self->random.next() >> self->random.below(64); };
  for (uint64_t frame = 0; frame < k_case_frames / 10; ++frame) {
    run.frame();
    ASSERT_EQ(run.scene.outputs_this_frame, k_output_units);
    ASSERT_GE(report.stages[0].units, 4u);
    ASSERT_LE(report.time.elapsed_ns,
              std::max(report.time.budget_ns, report.time.mandatory_ns) + report.time.last_unit_ns);
  }
  // The clock is right again. 16 frames later the scene fills its budget again.
  run.scene.show = nullptr;
  for (uint32_t frame = 0; frame < 17; ++frame) run.frame();
  EXPECT_GE(report.time.elapsed_ns * 10, k_budget_ns * 9);
  EXPECT_LE(report.time.elapsed_ns, k_budget_ns);
  EXPECT_GT(report.stages[k_refinement].units, 0u);
}

// The clock is frozen from the first reading, before any cost is known. Each frame ends at the cap of 64 optional work
// units.
TEST(LawProperty, AClockThatNeverRanEndsFramesAtTheUnitCap) {
  FakeRun run;
  run.scene.show = [](FakeScene*) { return uint64_t{42}; };
  for (uint32_t frame = 0; frame < 1000; ++frame) {
    run.frame();
    ASSERT_LE(run.report.stages[0].units + run.report.stages[1].units, 64u + 4u);
    ASSERT_GT(run.report.stages[1].units, 0u);
    ASSERT_EQ(run.report.stages[2].units, k_output_units);
    ASSERT_EQ(run.report.time.clock_fault, 1u);
  }
}

// A clock that moves by one nanosecond a reading would admit four million work units. The frame ends at 65,536.
TEST(LawProperty, AClockThatCrawlsEndsFramesAtTheUnitLimit) {
  FakeRun run;
  run.scene.show = [](FakeScene* self) { return self->readings; };
  for (uint32_t frame = 0; frame < 3; ++frame) {
    run.frame();
    EXPECT_LE(run.report.stages[0].units + run.report.stages[1].units, 65536u + 4u);
  }
  EXPECT_EQ(run.report.time.clock_fault, 1u);
}

}  // namespace
}  // namespace sandglass::governor_test
