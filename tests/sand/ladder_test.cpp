// The quality ladder: the governor goes down it level by level as the budget shrinks, and every quality level is
// stable.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_frame = 0.02f, k_radius = 0.01f;

// A clock that advances only while work is done: 20 microseconds a work unit.
struct UnitClock {
  uint64_t now = 1;
  uint32_t triages = 0;  // units that choose the grains to refine: one a sweep of fewer than 16 * 256 grains
  static uint64_t read(void* user) { return static_cast<UnitClock*>(user)->now; }
  static void end(void* user, const char* name) {
    UnitClock* clock = static_cast<UnitClock*>(user);
    clock->now += 20000;
    if (std::strcmp(name, "refine.triage") == 0) ++clock->triages;
  }
};

sandglass_scene_desc counted_description(UnitClock* clock, uint32_t particles, uint32_t grains) {
  sandglass_scene_desc desc = description(particles, grains);
  desc.unit_items = 256;
  desc.clock = {UnitClock::read, clock};
  desc.trace = {nullptr, UnitClock::end, clock};
  return desc;
}

// A block that collapses and then lies there awake. Its clock counts work units.
struct Counted {
  explicit Counted(uint32_t finest)
      : scene([&] {
          sandglass_scene_desc desc = counted_description(&clock, 1000, 8000);
          desc.granular.sleep_after = 0.0f;
          desc.finest_level = finest;
          return desc;
        }()) {
    const std::vector<float> block = lattice(10, 10, 10, 0.0205f, k_radius);
    scene.add(block, {}, grains_about(block, 0.004f));
    scene.add_floor();
    for (int frame = 0; frame < 50; ++frame) settled = scene.frame(k_frame);
    // Some frames measure what the neighbour lists have left, build them, or sort the grains. Every other one pushes
    // the grains apart, from level 3 on one in four. So the dearer one of two frames counts, of the two that do nothing
    // else; from level 3 on neither pushes.
    sandglass_frame_report last = settled;
    settled.time.elapsed_ns = ~0ull;
    for (int frame = 0; frame < 12; ++frame) {
      const sandglass_frame_report report = scene.frame(k_frame);
      const sandglass_frame_report& dearer = report.time.elapsed_ns < last.time.elapsed_ns ? last : report;
      dearest = std::max(dearest, static_cast<double>(report.time.elapsed_ns));
      if (frame != 0 && dearer.time.elapsed_ns < settled.time.elapsed_ns) settled = dearer;
      last = report;
    }
  }
  UnitClock clock;
  GranularScene scene;
  sandglass_frame_report settled;
  double dearest = 0.0;  // nanoseconds
};

// If a quality level's dearest frame fits the budget with a quarter to spare, the governor chooses it or a better one. If it does not
// fit, the governor does not stay there. In between, forecasts decide. They count a list build, which a pile that lies
// still does not need.
TEST(Ladder, EachLevelHasItsBudget) {
  if (SANDGLASS_EMULATED != 0)
    GTEST_SKIP() << "minutes under emulation; which level is chosen does not depend on the CPU";
  double cost[SANDGLASS_LEVEL_COUNT] = {}, dearest[SANDGLASS_LEVEL_COUNT] = {}, sweep = 0;
  for (uint32_t level = 0; level < SANDGLASS_LEVEL_SLOW_MOTION; ++level) {
    const Counted counted(level);
    cost[level] = static_cast<double>(counted.settled.time.elapsed_ns);
    dearest[level] = counted.dearest;
    sweep = static_cast<double>(counted.settled.stages[SANDGLASS_STAGE_REFINE].elapsed_ns);
    ASSERT_EQ(counted.settled.level, level);
  }
  Counted counted(SANDGLASS_LEVEL_FULL);
  std::vector<bool> reached(SANDGLASS_LEVEL_COUNT, false);
  double debt = 0.0;
  // With time debt there is a sweep of the grains in two frames' time.
  const double cost_min = cost[SANDGLASS_LEVEL_COARSER] - sweep / 2;
  for (double budget = 1.3 * cost[0]; budget > 0.8 * cost_min; budget *= 0.97) {
    uint32_t best = SANDGLASS_LEVEL_COUNT, worst = 0;
    sandglass_frame_report report = {};
    for (int frame = 0; frame < 30; ++frame) {
      report = counted.scene.frame(k_frame, static_cast<uint64_t>(budget));
      if (frame < 10) continue;
      reached[report.level] = true;
      best = std::min(best, report.level);
      worst = std::max(worst, report.level);
    }
    for (const uint32_t level :
         {uint32_t{SANDGLASS_LEVEL_FULL}, uint32_t{SANDGLASS_LEVEL_COARSE}, uint32_t{SANDGLASS_LEVEL_COARSER}}) {
      if (budget > 1.25 * dearest[level]) {
        EXPECT_LE(best, level) << budget;
      }
      if (budget < 0.9 * cost[level]) {
        EXPECT_GT(worst, level) << budget;
      }
    }
    // Before the last level there is no slow motion: the time debt stays below two frames.
    if (budget > 1.25 * cost[SANDGLASS_LEVEL_COARSER]) {
      EXPECT_LE(report.time.debt, 2.0 * static_cast<double>(k_frame));
    }
    debt = report.time.debt;
  }
  for (uint32_t level = 0; level < SANDGLASS_LEVEL_COUNT; ++level) {
    if (level == SANDGLASS_LEVEL_KEEP_LISTS) continue;  // a pile that lies still builds no lists
    EXPECT_TRUE(reached[level]) << sandglass_level_name(level);
  }
  EXPECT_GT(debt, 2.0 * static_cast<double>(k_frame)) << "at the last level there is slow motion";
}

// Grains lag at most two frames behind the particles. If they cannot follow, time slows for both. A sweep is one pass of
// the refinement over all grains: without time debt one each frame, in slow motion one in two frames' time. (Where the
// grains are then: follow_test.cpp.)
TEST(Ladder, GrainsAreNeverLeftBehind) {
  constexpr double k_simulated = 0.4;  // seconds: a fall of 10 cm takes 0.14, the block then spreads
  for (const uint64_t budget : {~uint64_t{0} >> 1, uint64_t{1'000'000}, uint64_t{300'000}, uint64_t{0}}) {
    UnitClock clock;
    GranularScene scene(counted_description(&clock, 216, 1728));
    std::vector<float> block = lattice(6, 6, 6, 0.0205f, k_radius);
    for (size_t i = 1; i < block.size(); i += 3) block[i] += 0.1f;
    scene.add(block, {}, grains_about(block, 0.004f));
    scene.add_floor();
    sandglass_frame_report report = {};
    for (int frame = 0; report.time.simulated < k_simulated && frame < 3000; ++frame) {
      report = scene.frame(k_frame, budget);
      ASSERT_LE(report.sand.grain_lag, 2.001f * k_frame) << "budget " << budget << ", frame " << frame;
    }
    const double frames_simulated = report.time.simulated / static_cast<double>(k_frame);
    const double covered = budget > 1'000'000 ? 1.0 : 2.0;
    EXPECT_NEAR(clock.triages, frames_simulated / covered, 1.0) << budget;
    EXPECT_GE(report.time.simulated, k_simulated) << "budget " << budget << ": time must go on";
    report = scene.frame(k_frame);  // with time for all: the grains catch up
    EXPECT_LT(report.sand.grain_lag, 1e-6f);
  }
}

TEST(Ladder, WithoutAClockTheFinestLevelRuns) {
  const std::vector<float> block = lattice(6, 6, 6, 0.0205f, k_radius);
  uint32_t substeps[SANDGLASS_LEVEL_COUNT] = {}, lists[SANDGLASS_LEVEL_COUNT] = {};
  for (uint32_t level = 0; level < SANDGLASS_LEVEL_COUNT; ++level) {
    sandglass_scene_desc desc = description(216);
    desc.finest_level = level;
    GranularScene scene(desc);
    scene.add(block);
    scene.add_floor();
    for (int frame = 0; frame < 20; ++frame) {
      const sandglass_frame_report report = scene.frame(k_frame);
      ASSERT_EQ(report.level, level);
      ASSERT_EQ(report.time.debt, 0.0);
      substeps[level] += report.sand.substeps;
      lists[level] += report.sand.list_builds;
    }
  }
  const auto ratio = [](uint32_t a, uint32_t b) { return static_cast<double>(a) / b; };
  EXPECT_EQ(substeps[SANDGLASS_LEVEL_KEEP_LISTS], substeps[SANDGLASS_LEVEL_FULL]);
  EXPECT_NEAR(ratio(substeps[SANDGLASS_LEVEL_COARSE], substeps[SANDGLASS_LEVEL_FULL]), 0.75, 0.02);
  EXPECT_NEAR(ratio(substeps[SANDGLASS_LEVEL_COARSER], substeps[SANDGLASS_LEVEL_FULL]), 0.5, 0.02);
  EXPECT_LT(lists[SANDGLASS_LEVEL_KEEP_LISTS], lists[SANDGLASS_LEVEL_FULL]);
  sandglass_scene_desc desc = description(1);
  desc.finest_level = SANDGLASS_LEVEL_COUNT;
  EXPECT_THROW(GranularScene{desc}, std::runtime_error);
}

// The averaged scheme simulates 20 ms in 16 steps of (7 + 1) iterations. A coarser quality level has fewer iterations,
// not longer steps.
TEST(Ladder, TheAveragedSchemeIteratesLess) {
  double overlap[2] = {};
  for (const uint32_t level : {uint32_t{SANDGLASS_LEVEL_FULL}, uint32_t{SANDGLASS_LEVEL_COARSER}}) {
    sandglass_scene_desc desc = description(216);
    desc.granular.reference.scheme = SANDGLASS_SCHEME_AVERAGED;
    desc.granular.reference.relaxation = 1.0f;
    desc.granular.reference.solver_iterations = 7;
    desc.granular.reference.stabilisation_iterations = 1;
    desc.granular.substep_max = desc.granular.substep_min = 0.02f / 16 * 1.00001f;
    desc.finest_level = level;
    GranularScene scene(desc);
    scene.add(lattice(6, 6, 6, 0.0205f, k_radius));
    scene.add_floor();
    for (int frame = 0; frame < 30; ++frame) {
      ASSERT_EQ(scene.frame(k_frame).sand.substeps, 16u);
      const std::vector<float> p = scene.positions();
      for (size_t i = 0; i < scene.particle_count; ++i)
        for (size_t j = 0; j < i; ++j)
          overlap[level != 0] += std::max(0.0, 2 * static_cast<double>(k_radius) - distance(p, i, p, j));
    }
  }
  EXPECT_GT(overlap[1], overlap[0]);
}

// Two hard cases, where long steps would show first: a tower, and a block that hits the floor at 3 m/s.
TEST(Ladder, EveryLevelIsStable) {
  for (uint32_t level = 0; level < SANDGLASS_LEVEL_COUNT; ++level) {
    sandglass_scene_desc desc = description(20);
    desc.finest_level = level;
    GranularScene tower(desc);
    tower.add_floor();
    std::vector<float> stack;
    for (int i = 0; i < 20; ++i) stack.insert(stack.end(), {0.0f, 0.01f + 0.02f * static_cast<float>(i), 0.0f});
    tower.add(stack);
    float top = 0.0f, height = 0.0f;
    for (int frame = 0; frame < 150; ++frame) {
      tower.frame(k_frame);
      const std::vector<float> p = tower.positions();
      height = 0.0f;
      for (size_t i = 1; i < p.size(); i += 3) height = std::max(height, p[i] + 0.01f);
      top = std::max(top, height);
    }
    EXPECT_GE(height, 0.98f * 0.4f) << sandglass_level_name(level);
    EXPECT_LE(top, 1.01f * 0.4f) << sandglass_level_name(level);

    desc = description(512);
    desc.finest_level = level;
    desc.granular.static_friction = desc.granular.kinetic_friction = 0.3f;
    GranularScene drop(desc);
    drop.add_floor();
    constexpr float k_speed = 3.0f;
    const std::vector<float> block = lattice(8, 8, 8, 0.0205f, k_radius);
    std::vector<float> velocities(block.size(), 0.0f);
    for (size_t i = 1; i < velocities.size(); i += 3) velocities[i] = -k_speed;
    drop.add(block, velocities);
    float fastest = 0.0f;
    for (int frame = 0; frame < 100; ++frame) {
      const sandglass_frame_report report = drop.frame(k_frame);
      fastest = std::max(fastest, report.sand.speed_max);
      ASSERT_EQ(report.sand.quarantined, 0u);
    }
    // One elastic pair could throw a particle at twice the speed of impact.
    EXPECT_LT(fastest, 2.0f * k_speed) << sandglass_level_name(level);
    // Friction stops a particle of that speed after v^2 / (2 mu g). The rest of the limit is the block's width.
    const float reach = k_speed * k_speed / (2.0f * desc.granular.kinetic_friction * 9.81f) + 0.17f;
    for (const float x : drop.positions()) ASSERT_LT(std::fabs(x), reach) << sandglass_level_name(level);
  }
}

}  // namespace
