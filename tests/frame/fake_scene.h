// A scene that consists of time only. Three stages like the real ones hand out units whose cost a test chooses:
//   granular  a cycle of four kinds of unit, without end; share 0.6
//   refine    blocked in each frame until one granular cycle is complete, then without end
//   output    three units, mandatory, at the end
// The scene keeps true time itself, so that a test knows it when the clock lies.
#pragma once

#include <cstdint>

#include "runtime/frame/governor.h"
#include "runtime/math/random.h"

namespace sandglass::governor_test {

// The library's random numbers, with bounds of 64 bits.
struct Random : sandglass::Random {
  uint64_t below(uint64_t bound) { return next() % bound; }
};

enum Kind : uint32_t { k_predict, k_neighbours, k_solve, k_finish, k_refine, k_output, k_kind_count };

// How many frames a budget case runs. Each case prints how many it ran.
constexpr uint64_t k_case_frames = SANDGLASS_GOVERNOR_FRAMES;
constexpr uint64_t k_budget_ns = 4000000;
// Undisturbed cost of a unit, nanoseconds, and its items.
constexpr uint64_t k_cost_ns[k_kind_count] = {60000, 140000, 90000, 50000, 100000, 70000};
constexpr uint32_t k_items[k_kind_count] = {1000, 1000, 500, 1000, 2048, 4096};
constexpr uint32_t k_output_units = 3;
// Places in the array of stages.
constexpr uint32_t k_granular = 0;
constexpr uint32_t k_refinement = 1;
constexpr uint32_t k_closing = 2;

struct FakeScene {
  // Returns the cost of the unit about to run, given its undisturbed cost. Null: undisturbed.
  uint64_t (*cost)(FakeScene* scene, Kind kind, uint64_t undisturbed) = nullptr;
  // Returns what the clock shows when true time is `true_ns`. Null: the truth.
  uint64_t (*show)(FakeScene* scene) = nullptr;
  void* user = nullptr;
  Random random{{1}};

  uint64_t true_ns = 0;
  uint64_t scale_percent = 100;  // factor of every cost: the machine's speed
  uint64_t readings = 0;

  // This frame's ledger.
  uint64_t frame_start_ns = 0;
  uint64_t stage_units[3] = {};
  uint64_t last_cost[3] = {};     // cost of each stage's last unit
  uint64_t closing_ns = 0;        // true time of the output stage
  bool disturbed = false;         // set by the test: a unit, the machine or the clock was disturbed
  bool unforeseeable = false;     // set by the test: the machine or the clock was disturbed
  bool output_disturbed = false;  // set here when an output unit cost more than undisturbed
  uint64_t order_hash = 0;        // hash of the kinds run since the start, in order

  uint32_t cycle = 0;  // position in granular's cycle
  uint32_t cycles_this_frame = 0;
  uint32_t outputs_this_frame = 0;
};

void fake_begin_frame(FakeScene* scene);

// A fake scene under a governor of its own.
struct FakeRun {
  explicit FakeRun(bool with_clock = true);
  FakeRun(const FakeRun&) = delete;
  FakeRun& operator=(const FakeRun&) = delete;

  // One frame: its report is in `report`. False if the plan does not fit.
  bool frame(uint64_t budget_ns = k_budget_ns, const sandglass_plan* plan = nullptr);

  FakeScene scene;
  Governor governor;
  Stage stages[3];
  sandglass_frame_report report = {};
};

}  // namespace sandglass::governor_test
