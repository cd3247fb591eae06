// Thermal headroom is the share of the budget that a device can sustain. Half the headroom halves the work that a frame
// plans. Quality falls and recovers with the headroom. The budget law always holds for the scaled budget.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "fake_scene.h"
#include "models/phones/phone.h"
#include "tests/sand/granular_scene.h"

namespace sandglass::governor_test {
namespace {

constexpr uint32_t k_settled = 16;  // frames after which costs are known (budget_test.cpp)

struct Steady {
  uint64_t optional_ns = 0;  // the time of frames without their mandatory work units and output
  uint64_t units = 0;
};

Steady run_steady(float headroom) {
  FakeRun run;
  const uint64_t target = governor_target(k_budget_ns, headroom);
  Steady steady;
  for (uint32_t frame = 0; frame < 10 * k_settled; ++frame) {
    run.frame(target);
    if (frame < k_settled) continue;
    EXPECT_LE(run.report.time.elapsed_ns, target) << "constant cost must never overrun";
    steady.optional_ns += run.report.time.elapsed_ns - run.report.time.mandatory_ns;
    steady.units += run.scene.stage_units[0] + run.scene.stage_units[1];
  }
  return steady;
}

TEST(ThermalHeadroom, HalfOfItHalvesThePlan) {
  const Steady full = run_steady(1.0f), half = run_steady(0.5f);
  // The ratio may differ from a half, for two reasons. Both runs leave up to one work unit of their target unused (the
  // longest costs 140 us, 175 us with its margin). And the mandatory part does not scale.
  const double slack = 9.0 * k_settled * 175e3;
  const double lost = static_cast<double>(9 * k_settled) * 0.5 * k_budget_ns;  // halving takes this from the target
  EXPECT_NEAR(static_cast<double>(full.optional_ns - half.optional_ns), lost, slack);
  EXPECT_NEAR(static_cast<double>(half.units) / static_cast<double>(full.units), 0.5, 0.05);
}

TEST(ThermalHeadroom, OutOfRangeCountsAsTheNearestOrAsUnknown) {
  for (const float whole : {1.0f, 7.0f, NAN, INFINITY}) EXPECT_EQ(governor_target(k_budget_ns, whole), k_budget_ns);
  for (const float none : {0.0f, -1.0f}) EXPECT_EQ(governor_target(k_budget_ns, none), 0u);
  EXPECT_EQ(governor_target(k_budget_ns, 0.5f), k_budget_ns / 2);
  EXPECT_EQ(governor_target(~0ull, 1.0f), ~0ull);
}

// A real scene in which work units cost what they would on a small core (models/phones). The headroom falls from 1 to 0.2,
// as on a phone that warms up. It stays there and recovers as the phone cools.
constexpr uint64_t k_warm_budget_ns = 6000000;  // all work of a frame takes 3 to 5 ms

float headroom_at(size_t frame) {
  const float cooling = std::abs(static_cast<float>(frame) - 200.0f) / 100.0f;  // 2 .. 0 .. 2
  return std::clamp(cooling, 0.2f, 1.0f);
}

enum class Phone { warms, stays_cool };

const std::vector<sandglass_frame_report>& frames_of(Phone phone) {
  const auto run = [](bool warms) {
    std::vector<sandglass_frame_report> reports;
    host::PhoneClock clock(host::phone_core("cortex-a55"));
    sandglass_scene_desc desc = description(512, 2048);
    desc.clock = clock.clock();
    desc.unit_items = 128;
    desc.granular.substep_max = 0.004f;
    desc.granular.sleep_after = 0.0f;
    GranularScene scene(desc);
    clock.follow(scene.scene.get());
    scene.add_floor();
    const std::vector<float> particles = lattice(8, 8, 8, 0.0202f, 0.0102f);
    scene.add(particles, {}, copies(particles, 4, 0.002f));
    for (size_t frame = 0; frame < 400; ++frame) {
      sandglass_frame_input input = scene.input(0.02f, k_warm_budget_ns);
      input.thermal_headroom = warms ? headroom_at(frame) : 1.0f;
      reports.push_back(scene.run(input));
    }
    return reports;
  };
  static const std::vector<sandglass_frame_report> warm = run(true), cool = run(false);
  return phone == Phone::warms ? warm : cool;
}

TEST(ThermalHeadroom, AWarmingPhoneNeverMissesItsTarget) {
  const std::vector<sandglass_frame_report>& warming = frames_of(Phone::warms);
  for (size_t f = 0; f < warming.size(); ++f) {
    const sandglass_time_report& t = warming[f].time;
    EXPECT_EQ(t.budget_ns, k_warm_budget_ns);
    EXPECT_EQ(t.target_ns, governor_target(t.budget_ns, headroom_at(f)));
    EXPECT_LE(t.elapsed_ns, std::max(t.target_ns, t.mandatory_ns) + t.last_unit_ns) << "frame " << f;
    EXPECT_LE(t.elapsed_ns, t.budget_ns) << "frame " << f;
  }
}

// A phone that never warmed says what its quality would be: the pile comes to rest meanwhile, which takes less time.
TEST(ThermalHeadroom, QualityFallsWithItAndRecovers) {
  const auto units = [](size_t from, size_t to) {
    uint64_t sum = 0;
    for (size_t f = from; f < to; ++f)
      for (const sandglass_stage_report& stage : frames_of(Phone::warms)[f].stages) sum += stage.units;
    return static_cast<double>(sum) / static_cast<double>(to - from);
  };
  const double cool = units(60, 100), hot = units(190, 210), again = units(340, 380);
  EXPECT_LT(hot, 0.4 * cool);
  EXPECT_GT(again, 0.9 * cool);
  // A better level waits until it has fit for some frames.
  const auto best_level = [](Phone phone, size_t from) {
    uint32_t best = SANDGLASS_LEVEL_COUNT;
    for (size_t f = from; f < from + 10; ++f) best = std::min(best, frames_of(phone)[f].level);
    return best;
  };
  EXPECT_LT(best_level(Phone::warms, 80), best_level(Phone::warms, 200));
  EXPECT_LT(best_level(Phone::stays_cool, 200), best_level(Phone::warms, 200));
  EXPECT_EQ(best_level(Phone::warms, 380), best_level(Phone::stays_cool, 380));
}

}  // namespace
}  // namespace sandglass::governor_test
