// A frame runs its stages in the right order and with the right shares, and its plan records what ran. The tests cover
// unblocking, the quality ladder and replay. They also cover the edges: no clock, no budget, no stage, a full plan, and
// a plan that does not fit.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "fake_scene.h"
#include "platform/virtual_clock.h"

namespace sandglass::governor_test {
namespace {

// A stage with a finite list of work units of one kind. Each takes 100 us on the shared clock. Another stage may have
// to unblock them.
struct ListStage {
  VirtualClock* clock;
  std::string* log;
  uint32_t kind;
  uint32_t units = 0;  // how many it offers
  uint32_t done = 0;
  // If set, work units run only while fewer than *ahead + lead are done.
  const uint32_t* ahead = nullptr;
  uint32_t lead = 0;
  bool spread = false;  // whether the forecast calls it work that is spread over several frames
};

constexpr uint64_t k_list_unit_ns = 100000;

Stage list_stage(ListStage* list, uint32_t mandatory, float share) {
  Stage stage = {};
  stage.state = list;
  stage.next = [](const void* state, uint32_t, WorkUnit* unit) {
    const ListStage* self = static_cast<const ListStage*>(state);
    *unit = {self->kind, 10, "fake.list"};
    const bool blocked = self->ahead != nullptr && self->done >= *self->ahead + self->lead;
    return self->done < self->units && !blocked;
  };
  stage.run = [](void* state, uint32_t) {
    ListStage* self = static_cast<ListStage*>(state);
    ++self->done;
    self->clock->now_ns += k_list_unit_ns;
    *self->log += static_cast<char>('a' + self->kind);
  };
  stage.forecast = [](const void* state, uint32_t, Forecast* entries) {
    const ListStage* self = static_cast<const ListStage*>(state);
    entries[0] = {self->kind, 10ull * (self->units - self->done), self->spread};
    return 1u;
  };
  stage.mandatory_units = mandatory;
  stage.share = share;
  return stage;
}

struct Lists {
  VirtualClock clock;
  std::string log;
  ListStage first{&clock, &log, 0}, second{&clock, &log, 1}, output{&clock, &log, 2};
  Governor governor = {};
  sandglass_frame_report report = {};

  explicit Lists(bool with_clock = true) {
    governor_init(&governor, with_clock ? virtual_clock(&clock) : sandglass_clock{}, {}, 1);
  }
  // A frame in which the stages offer so many work units.
  bool frame(const std::array<uint32_t, 3>& units, uint64_t budget_ns, uint32_t mandatory, float share,
             const sandglass_plan* replay = nullptr) {
    first.units = units[0];
    second.units = units[1];
    output.units = units[2];
    first.done = second.done = output.done = 0;
    const Stage stages[3] = {list_stage(&first, mandatory, share), list_stage(&second, 0, 1.0f),
                             list_stage(&output, k_all_units, 1.0f)};
    log.clear();
    return governor_frame(&governor, stages, 3, budget_ns, replay, &report);
  }
  // Runs a frame. After it the cost of every kind of work unit is known.
  void learn() { frame({4, 4, 4}, 1000000000, 1, 1.0f); }
};

TEST(Plan, WithoutAClockEverythingRunsAtFullQualityAndNoTimeIsReported) {
  Lists lists(false);
  EXPECT_TRUE(lists.frame({3, 2, 1}, 0, 1, 0.5f));
  EXPECT_EQ(lists.log, "aaabbc");
  EXPECT_EQ(lists.report.level, 0u);
  EXPECT_EQ(lists.report.time.elapsed_ns, 0u);
  EXPECT_EQ(lists.report.time.clock_fault, 0u);
  EXPECT_EQ(lists.report.stages[0].denied, 0u);
}

TEST(Plan, ZeroBudgetRunsTheMandatoryPartOnly) {
  Lists lists;
  lists.learn();
  lists.frame({5, 5, 2}, 0, 2, 1.0f);
  EXPECT_EQ(lists.log, "aacc");
  EXPECT_EQ(lists.report.time.mandatory_ns, 4 * k_list_unit_ns);
  EXPECT_EQ(lists.report.time.elapsed_ns, lists.report.time.mandatory_ns);
  EXPECT_EQ(lists.report.stages[0].denied, 1u);
  EXPECT_EQ(lists.report.stages[1].denied, 1u);
}

TEST(Plan, NothingToDoIsAnEmptyPlan) {
  Lists lists;
  lists.frame({0, 0, 0}, 4000000, 4, 0.6f);
  EXPECT_EQ(lists.report.plan.run_count, 0u);
  EXPECT_TRUE(governor_frame(&lists.governor, nullptr, 0, 4000000, nullptr, &lists.report));
  EXPECT_EQ(lists.report.plan.run_count, 0u);
}

TEST(Plan, AShareIsKeptWhileALaterStageHasWorkAndHandedBackAfterwards) {
  Lists lists;
  lists.learn();
  lists.frame({100, 100, 0}, 10 * k_list_unit_ns, 0, 0.5f);
  EXPECT_EQ(lists.log, "aaaaabbbb");  // a tenth unit would fit, but not with its margin
  lists.frame({100, 2, 0}, 10 * k_list_unit_ns, 0, 0.5f);
  EXPECT_EQ(lists.log, "aaaaabbaa");
}

TEST(Plan, AStageThatUnblocksAnotherGetsTimeForIt) {
  Lists lists;
  lists.learn();
  // Each work unit of the first stage unblocks one of the second. The first stage's own share is zero, too little for
  // one work unit.
  lists.second.ahead = &lists.first.done;
  lists.frame({4, 4, 1}, 100 * k_list_unit_ns, 0, 0.0f);
  EXPECT_EQ(lists.log, "ababababc");
  // The other way round: the second stage unblocks the first.
  Lists reversed;
  reversed.learn();
  reversed.first.ahead = &reversed.second.done;
  reversed.first.lead = 2;
  reversed.frame({6, 3, 1}, 100 * k_list_unit_ns, 1, 1.0f);
  EXPECT_EQ(reversed.log, "aabbbaaac");
}

TEST(Plan, RunsAreLengthEncodedInTheOrderInWhichTheyRan) {
  Lists lists;
  lists.learn();
  lists.frame({3, 2, 2}, 100 * k_list_unit_ns, 1, 1.0f);
  ASSERT_EQ(lists.report.plan.run_count, 3u);
  EXPECT_EQ(lists.report.plan.struct_size, sizeof(sandglass_plan));
  const uint32_t expected[3] = {3, 2, 2};
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(lists.report.plan.runs[i].stage, i);
    EXPECT_EQ(lists.report.plan.runs[i].units, expected[i]);
  }
}

TEST(Plan, WhenThePlanIsFullOptionalWorkEndsAndTheOutputIsStillWritten) {
  Lists lists;
  lists.learn();
  lists.second.ahead = &lists.first.done;  // the order is a, b, a, b ..., so each work unit is a run of its own
  lists.frame({100, 100, 3}, 1000 * k_list_unit_ns, 0, 0.0f);
  EXPECT_EQ(lists.report.plan.run_count, static_cast<uint32_t>(SANDGLASS_PLAN_RUNS));
  EXPECT_EQ(lists.report.plan.runs[SANDGLASS_PLAN_RUNS - 1].stage, k_closing);
  EXPECT_EQ(lists.output.done, 3u);
  EXPECT_EQ(lists.report.stages[0].denied, 1u);
  Lists again(false);  // a full plan can be replayed
  again.second.ahead = &again.first.done;
  EXPECT_TRUE(again.frame({100, 100, 3}, 0, 0, 0.0f, &lists.report.plan));
  EXPECT_EQ(again.log, lists.log);
}

TEST(Plan, ReplayTeachesThePredictorNothing) {
  Lists lists;
  lists.learn();
  const uint64_t predicted = governor_predict(&lists.governor, 0, 10);
  sandglass_plan plan = lists.report.plan;
  lists.clock.now_ns += 123456789;
  EXPECT_TRUE(lists.frame({4, 4, 4}, 0, 0, 1.0f, &plan));
  EXPECT_EQ(governor_predict(&lists.governor, 0, 10), predicted);
}

TEST(Plan, AReplayThatDoesNotFitStopsBeforeTheUnitThatIsNotOffered) {
  Lists lists;
  sandglass_plan plan = {};
  plan.struct_size = sizeof(plan);
  plan.run_count = 2;
  plan.runs[0] = {k_granular, 3};
  plan.runs[1] = {k_refinement, 2};
  EXPECT_FALSE(lists.frame({3, 1, 1}, 0, 0, 1.0f, &plan));
  EXPECT_EQ(lists.log, "aaab");

  plan.runs[1].stage = 3;  // no such stage
  EXPECT_FALSE(lists.frame({3, 2, 1}, 0, 0, 1.0f, &plan));
  plan.runs[1].stage = k_refinement;
  plan.run_count = SANDGLASS_PLAN_RUNS + 1;
  EXPECT_FALSE(lists.frame({3, 2, 1}, 0, 0, 1.0f, &plan));
  plan.run_count = 2;
  plan.level = 1;  // the ladder has one level
  EXPECT_FALSE(lists.frame({3, 2, 1}, 0, 0, 1.0f, &plan));
}

TEST(Plan, TheBestQualityLevelThatFitsIsTakenAndDoesNotFlicker) {
  FakeRun run;
  const auto level_at = [&](uint64_t budget) {
    for (uint32_t i = 0; i < 4; ++i) run.frame(budget);
    return run.report.level;
  };
  // The forecast of the fake stages: cycles of 790 us, refinement work units of 100 us, and three output work units of
  // 70 us.
  const uint64_t full = 8 * 790000 + 16 * 100000 + 210000;
  const uint64_t half = 4 * 790000 + 8 * 100000 + 210000;
  EXPECT_EQ(level_at(2 * full), 0u);
  EXPECT_EQ(level_at(full), 0u);
  EXPECT_EQ(level_at(full - 10000), 1u);
  EXPECT_EQ(level_at(full + 10000), 1u);  // level 0 fits again, but with too little to spare
  EXPECT_EQ(level_at(full * 8 / 7 + 10000), 0u);
  EXPECT_EQ(level_at(half - 10000), 2u);
  EXPECT_EQ(level_at(0), 2u);
}

// Frames into which level 0 fits (a), level 1 (b), none but the last one (c), and all twice (d).
TEST(Plan, ABetterQualityLevelIsTakenOnceItHasFitInFourFramesRunning) {
  FakeRun run;
  const uint64_t full = 8 * 790000 + 16 * 100000 + 210000, half = 4 * 790000 + 8 * 100000 + 210000;
  const auto levels_of = [&](const std::string& frames) {
    std::string levels;
    for (const char frame : frames) {
      const uint64_t fits = (frame == 'b' ? half : full) * 8 / 7 + 10000;
      run.frame(frame == 'c' ? 0 : frame == 'd' ? 2 * fits : fits);
      levels += static_cast<char>('0' + run.report.level);
    }
    return levels;
  };
  EXPECT_EQ(levels_of("acaaacaaba"), "0222222221") << "the worst of the four";
  EXPECT_EQ(levels_of("aaaacdc"), "1110202") << "one that fits half of the budget is taken at once";
  run.governor.policy.better_after = 1;
  EXPECT_EQ(levels_of("acbcaba"), "0212010") << "the control";
}

// The output takes a twentieth of the frame. The first frame begins with one work unit of the output. So it learns that
// it need not keep half of its time free.
TEST(Plan, TheFirstFrameLearnsWhatTheOutputCosts) {
  Lists lists;
  EXPECT_TRUE(lists.frame({100, 0, 2}, 4000000, 0, 1.0f));
  EXPECT_EQ(lists.log.front(), 'c') << "the first unit must be one of the output";
  EXPECT_EQ(lists.log.back(), 'c');
  // 40 work units fit into 4 ms. Two of them are output. The second output unit and the last unit of work each need a
  // margin of a quarter, which costs one more.
  EXPECT_GE(lists.report.stages[0].units, 40u - 2 - 1);
  EXPECT_LE(lists.report.time.elapsed_ns, 4000000u);
  EXPECT_TRUE(lists.frame({100, 0, 2}, 4000000, 0, 1.0f));
  EXPECT_EQ(lists.log.front(), 'a') << "the output's cost is known by now";
}

// A shadow texture that costs 10 ms does not force the worst quality level, because its work is spread over frames. But
// other work lacks the millisecond that the texture gets in this frame.
TEST(Plan, WorkSpreadOverFramesCountsForItsShareInTheChoiceOfTheQualityLevel) {
  const auto level_beside = [](uint32_t units) {
    Lists lists;
    lists.learn();
    lists.governor.level_count = 2;
    lists.first.spread = true;
    EXPECT_TRUE(lists.frame({100, units, 1}, 4000000, 0, 0.25f));
    return lists.report.level;
  };
  EXPECT_EQ(level_beside(28), 0u);  // 1 + 2.8 + 0.1 ms
  EXPECT_EQ(level_beside(30), 1u);  // 4.1 ms
}

TEST(Plan, AnEstimateThatNobodyChecksFades) {
  Lists lists;
  lists.learn();
  const uint64_t known = governor_predict(&lists.governor, 1, 10);
  EXPECT_EQ(known, k_list_unit_ns);
  for (uint32_t i = 0; i < 64; ++i) lists.frame({1, 0, 1}, 10000000, 0, 1.0f);
  EXPECT_EQ(governor_predict(&lists.governor, 1, 10), known / 2);
  for (uint32_t i = 0; i < 64 * 64; ++i) lists.frame({1, 0, 1}, 10000000, 0, 1.0f);
  EXPECT_EQ(governor_predict(&lists.governor, 1, 10), 0u);
  EXPECT_EQ(governor_predict(&lists.governor, 0, 10), k_list_unit_ns);
}

TEST(Plan, PredictionsSaturateInsteadOfOverflowing) {
  Governor governor;
  governor_init(&governor, {}, {}, 1);
  EXPECT_EQ(governor_predict(&governor, 0, ~0ull), 0u);
  EXPECT_EQ(governor_predict(&governor, k_unit_kind_none, 1), 0u);
  governor.kinds[0].estimate = ~0ull;
  EXPECT_EQ(governor_predict(&governor, 0, ~0ull), ~0ull);
  governor.kinds[0].estimate = 1;  // a picosecond an item
  EXPECT_EQ(governor_predict(&governor, 0, 1), 1u);
  EXPECT_EQ(governor_predict(&governor, 0, 5000), 5u);
}

// The governor remembers five seconds for a kind of work unit that takes 100 us. Each frame leaves `percent` of the
// budget for it. Returns the number of the frame in which it runs.
uint32_t frames_until_tried(uint32_t percent, Lists* lists) {
  lists->learn();
  Governor::Kind* kind = &lists->governor.kinds[1];
  for (uint64_t& cost : kind->recent) cost = 500000000000000;
  kind->estimate = kind->recent[0];
  kind->count = 16;
  for (uint32_t frames = 1; frames <= 20; ++frames) {
    lists->frame({100 - percent, 1, 0}, 100 * k_list_unit_ns, 100 - percent, 1.0f);
    if (lists->report.stages[1].units > 0) return frames;
  }
  return ~0u;
}

TEST(Plan, AnOverestimateIsCappedFadesWhileDeniedAndIsProbedWithinEightFrames) {
  Lists capped, faded, probed;
  // No prediction for a work unit is more than half the budget.
  EXPECT_EQ(frames_until_tried(60, &capped), 1u);
  // The prediction starts at half the budget. Each of four denials lowers it by an eighth of that.
  EXPECT_EQ(frames_until_tried(30, &faded), 5u);
  // No estimate fits, so only a probe runs it.
  EXPECT_EQ(frames_until_tried(3, &probed), 8u);
  EXPECT_EQ(governor_predict(&probed.governor, 1, 10), k_list_unit_ns) << "one probe corrects the memory";
}

TEST(Plan, EveryUnitIsBracketedByTheTraceHooks) {
  struct Seen {
    uint32_t begun = 0;
    uint32_t ended = 0;
    bool nested = false;
  } seen;
  sandglass_trace trace = {};
  trace.user = &seen;
  trace.begin = [](void* user, const char*) {
    Seen* s = static_cast<Seen*>(user);
    s->nested |= s->begun++ != s->ended;
  };
  trace.end = [](void* user, const char* name) {
    static_cast<Seen*>(user)->ended += std::strcmp(name, "fake.list") == 0;
  };
  Lists lists;
  lists.governor.trace = trace;
  lists.frame({3, 2, 1}, 100000000, 1, 1.0f);
  EXPECT_EQ(seen.begun, 6u);
  EXPECT_EQ(seen.ended, 6u);
  EXPECT_FALSE(seen.nested);
}

}  // namespace
}  // namespace sandglass::governor_test
