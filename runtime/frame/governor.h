// The governor decides, work unit by work unit, what fits into a frame's budget. It is the only reader of the clock.
// Its decisions are data (the executed plan), so a frame can be replayed to the bit without a clock.
//
// A work unit is a bounded piece of work; after each one the scene is valid. A stage is a table of functions that hands
// out work units. The governor runs the mandatory units of all stages first, then optional ones in the order of the
// stages. It admits an optional unit when
//     now + predicted cost of the unit + predicted cost of what must still come (reserve) <= deadline.
// It predicts a cost per kind of unit and per item: an estimate from recent observations, times what costs of the kind
// exceed their estimates by once in 512. A large outlier counts only in part, so one preemption does not starve a kind
// for ever. Where costs vary as they did before, 99.9 % of frames end within their budget. The promise is
//     elapsed <= max(budget, mandatory part) + the last unit.
// The last unit is the last one admitted. The output stage comes after it, into time that was kept free for it. Where
// the output stage takes longer than its own forecast, nothing can take back what was admitted before: that excess is
// counted into last_unit_ns, and Governor::closing_excess_ns holds it alone. Without it the promise is one unit.
//
// A clock that goes backward, freezes or jumps ends the frame at a cap of units. A unit that such a clock did not time
// is charged with its prediction, or with 1/64 of the budget where nothing is known. It teaches the predictor nothing.
#pragma once

#include <cstdint>

#include "sandglass/sandglass.h"

namespace sandglass {

// Kinds of work unit: the sand's, then those of capabilities.inc.
constexpr uint32_t k_sand_kinds = 24;
constexpr uint32_t k_unit_kinds = k_sand_kinds
#define ONE(stage, field, kinds) +kinds
#define MANY(stage, field, number, handle, kinds) +kinds
#include "runtime/frame/capabilities.inc"
    ;
static_assert(k_unit_kinds <= 64);  // the bits of a word
// Those of each.
#define ONE(stage, field, kinds) constexpr uint32_t k_##field##_kinds = kinds;
#define MANY(stage, field, number, handle, kinds) constexpr uint32_t k_##handle##_kinds = kinds;
#include "runtime/frame/capabilities.inc"
constexpr uint32_t k_unit_kind_none = k_unit_kinds;  // a unit of this kind is never predicted
constexpr uint32_t k_all_units = ~0u;                // Stage::mandatory_units of the output stage

// The next unit of a stage: its kind, for the predictor, and its size. Units of one kind should have similar sizes.
struct WorkUnit {
  uint32_t kind = k_unit_kind_none;
  uint32_t items = 0;
  const char* name = "";  // for the trace hook
};

// Work that a stage would still like to do in this frame, for one kind. There are some tens on the stack: without gaps.
struct Forecast {
  uint64_t items;
  uint32_t kind;
  // May go on in later frames. All work of this sort together counts for no more than the stage's share.
  bool spread;

  Forecast() = default;
  Forecast(uint32_t of, uint64_t count, bool may_go_on = false) : items(count), kind(of), spread(may_go_on) {}
};

// What a capability takes part in a frame with. Each capability exports one function that returns its Stage; the scene
// puts them into an array. Kinds of work unit are counted from 0 by each stage; assign_kinds gives them their places.
struct Stage {
  void* state;
  // The next unit at this quality level, or false when there is none now (another stage's units may unblock it).
  // Asking changes nothing and is cheap: it is asked more often than it is run.
  bool (*next)(const void* state, uint32_t level, WorkUnit* unit);
  // Runs the unit that `next` describes.
  void (*run)(void* state, uint32_t level);
  // Work left in this frame at `level`. Writes at most k_unit_kinds entries and returns their number.
  uint32_t (*forecast)(const void* state, uint32_t level, Forecast* entries);
  // Kinds of unit that the stage has. Stages of one state share their kinds and name the same number.
  uint32_t kinds;
  // Units that this stage runs in every frame, whatever the budget, before any optional one. Units that `next` does not
  // offer by then become optional.
  //
  // k_all_units marks the output stage, the last of the array. All its units run, at the very end, and its forecast is
  // the reserve that optional units leave free. While the cost of its units is unknown, one of them runs before the
  // optional ones, to learn it; the stage offers that unit again at the end if it is out of date.
  uint32_t mandatory_units;
  // Share of the time left after mandatory units and reserve. While a later stage has optional work, this stage's
  // optional units take no more; what the later stage leaves comes back. 1: all.
  float share;
  // Before assign_kinds: how many of the stage's kinds come before the first one that it names 0.
  uint32_t first_kind = 0;
  // Of the output stage: the frame's optional units are over, and what it offers from now on is the end of the frame.
  void (*close)(void* state) = nullptr;
};

// Gives every stage's kinds their place among all kinds of the frame, in the order of the array: each begins where the
// one before ends. Stages of one state share one place. Pass the same capabilities in the same order every frame, and
// for one that is left out stage_without_work: the predictor's memory is by place.
void assign_kinds(Stage* stages, uint32_t count);

// What stands for a capability that a frame leaves out: it keeps its place and offers nothing.
Stage stage_without_work(uint32_t kinds);

// A stage's answers, with kinds as places among all.
bool stage_next(const Stage& stage, uint32_t level, WorkUnit* unit);
uint32_t stage_forecast(const Stage& stage, uint32_t level, Forecast* entries);

// The numbers of the predictor, in one place so that a test can prove that a worse choice fails.
struct PredictorPolicy {
  // The estimate is the greatest of 16 recent costs after this many of the largest are left out.
  uint32_t dropped;
  // An observation counts for at most this many times the estimate. 0: it counts for what it is.
  uint32_t censor;
  // A kind that was denied in all of this many frames less one is tried in the next. 0: never.
  uint32_t probe_frames;
  // No unit is predicted to need more than half the budget.
  bool capped;
  // Kept free beyond an estimate is what costs of the kind exceed it by, all but one in this many (Spread). 0: a quarter.
  uint32_t exceeded_once_in;
  // A better quality level is taken once it has fit in this many frames in a row; a worse one is taken at once, and so is
  // one that fits half of the budget.
  uint32_t better_after;
};

// Two of 16: with 1 % of outliers, three of them lie among 16 costs in only 0.05 % of all cases. Censoring at 3: a
// processor that throttles to a third of its speed is known after three units, and no outlier counts for more than
// three estimates. One in 512: only a frame's last unit and its output can make it late, and what one of them leaves of
// its margin serves the other. So fewer than one frame in 1000 is late. Better levels after four frames: as many as lie
// between two sweeps that push the grains apart (sweep.cpp). Frames without that push are cheaper: a better level that
// fits only those would flicker.
constexpr PredictorPolicy k_predictor_policy = {2, 3, 8, true, 512, 4};

// How far costs exceed their estimates: a running upper quantile of cost / estimate, in parts of k_spread_one. An
// excess raises it by a step, every other cost lowers it by that step / exceeded_once_in. So it rests where one cost in
// so many exceeds it, whatever the costs' distribution is.
// It is never less than a quarter above 1: a quantile of 16 costs may lie that far below what comes next, also of a kind
// that has always been even.
constexpr uint32_t k_spread_one = 1u << 16;
constexpr uint32_t k_spread_min = k_spread_one + k_spread_one / 4;
struct Spread {
  uint32_t ratio = k_spread_min;
};

// Called for every unit that has run, before the clock is read. The library sets none; the program's estimates of other
// processors do.
struct UnitObserver {
  void (*ran)(void* user, const WorkUnit& unit);
  void* user;
};

struct Governor {
  sandglass_clock clock;
  sandglass_trace trace;
  UnitObserver observer;
  // Quality levels, at least 1. A frame runs at the first one whose forecast fits the budget.
  uint32_t level_count;
  // Levels better than this are not used.
  uint32_t finest_level;
  // The level of the last frame. A better one must fit into 7/8 of the budget, so that quality does not flicker.
  uint32_t level;
  // The worst level of those that fit in the last `better_frames` frames, which were all better than `level`.
  uint32_t better_level, better_frames;
  PredictorPolicy policy;
  // Time that the last frame's output stage took beyond what was kept free for it.
  uint64_t closing_excess_ns;
  // The spread of the output stage as a whole. A sum of units varies less than each of them.
  Spread closing;
  // Recent costs of each kind in picoseconds an item. Integers, so the same clock gives the same plan everywhere.
  struct Kind {
    uint64_t recent[16];
    uint64_t estimate;  // made from `recent`
    Spread spread;
    uint32_t count;          // observations in `recent`
    uint32_t cursor;         // where the next observation goes
    uint32_t frames_denied;  // frames in a row in which a unit was predicted not to fit and none ran
    uint32_t frames_idle;    // frames in a row in which none ran
  } kinds[k_unit_kinds];
};

void governor_init(Governor* governor, sandglass_clock clock, sandglass_trace trace, uint32_t level_count);

// Runs one frame over the stages. With `replay` NULL clock and budget decide. Otherwise that plan is executed, and the
// clock is read only to report. Clears *report, and fills in level, plan, stages, and of `time` what is the clock's.
// Returns false where a replayed plan is malformed or asks for a unit that its stage does not offer;
// nothing runs after that.
//
// Nothing runs that the plan cannot record. Where the stages alternate so often that the plan is full, the frame ends
// early; one run is always kept for the output stage. Without a clock everything runs, at the finest level.
bool governor_frame(Governor* governor, const Stage* stages, uint32_t stage_count, uint64_t budget_ns,
                    const sandglass_plan* replay, sandglass_frame_report* report);

// The part of a budget that a device with this thermal headroom can sustain: 0..1, see sandglass_frame_input. In steps
// of 1/1024, in integers, so that the same headroom gives the same plan everywhere.
uint64_t governor_target(uint64_t budget_ns, float headroom);

// Predicted cost of `items` of a kind in nanoseconds; 0 while nothing is known.
uint64_t governor_predict(const Governor* governor, uint32_t kind, uint64_t items);

}  // namespace sandglass
