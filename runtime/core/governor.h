// The governor decides, work unit by work unit, what fits into a frame's budget. It is the only reader of the clock;
// what it decided is data (the executed plan), so a frame can be replayed to the bit without a clock.
//
// A stage is a table of functions that hands out work units: bounded pieces of work after each of which the scene is
// valid. The governor runs every stage's mandatory units, then optional ones in stage order, admitting a unit when
//     now + predicted cost of the unit + predicted cost of what must still come (reserve) <= deadline.
// Costs are predicted per kind of unit and per item, by a high quantile of recent observations with outliers censored,
// so that one preemption neither starves a kind for ever nor breaks the promise:
//     elapsed <= max(budget, mandatory part) + the last unit.
// The last unit is the last one admitted. The output stage comes after it, into time kept free for it; where it outruns
// its own forecast, nothing can take back what was admitted before. That excess is counted into last_unit_ns, and told
// apart in Governor::closing_excess_ns; without it the promise is one unit and no more.
//
// A clock that goes backward, freezes or jumps ends the frame at a cap of units: a unit that was not timed is charged
// with its prediction, an unknown one with 1/64 of the budget. Such units teach the predictor nothing.
#pragma once

#include <cstdint>

#include "sandglass/sandglass.h"

namespace sandglass {

constexpr uint32_t k_unit_kinds = 32;                // bits of a word
constexpr uint32_t k_unit_kind_none = k_unit_kinds;  // a unit of this kind is never predicted
constexpr uint32_t k_all_units = ~0u;                // Stage::mandatory_units of the output stage

// The next unit of a stage: its kind (for the predictor) and size. Units of one kind should be of similar size.
struct WorkUnit {
  uint32_t kind = k_unit_kind_none;
  uint32_t items = 0;
  const char* name = "";  // for the trace hook
};

// Work that a stage would still like to do in this frame, for one kind.
struct Forecast {
  uint32_t kind;
  uint64_t items;
  bool spread = false;  // may go on in later frames: all that a stage has of it counts for its share at most
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
  // Units that this stage runs in every frame, whatever the budget, before any optional one and while `next` offers
  // any; what is still blocked then becomes optional. k_all_units marks the output stage, the last of the array: all
  // its units run, at the very end, and its forecast is the reserve that optional units leave free. While the cost of
  // its units is unknown, one runs before the optional ones, to learn it; the stage offers it again if it is out of
  // date.
  uint32_t mandatory_units;
  // Share of the time left after mandatory units and reserve that the stage's optional units may take while a later
  // optional stage has work; what that one leaves is handed back. 1: all.
  float share;
  uint32_t first_kind = 0;  // see assign_kinds
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
  uint32_t dropped;  // of 16 recent costs this many of the largest are not believed: the rest's maximum is the estimate
  uint32_t censor;   // an observation counts for at most this many estimates; 0: for what it is
  uint32_t probe_frames;  // a kind denied in all of so many frames, less one, is tried in the next; 0: never
  bool capped;            // no unit is predicted to need more than half the budget
};

// Two of 16: a kind that sees 1 % of outliers has three among 16 in 0.05 % of its history only. Censoring at 3: a
// processor that throttles to a third of its speed is known after three units, while no outlier, believed or not,
// counts for more than that.
constexpr PredictorPolicy k_predictor_policy = {2, 3, 8, true};

struct Governor {
  sandglass_clock clock;
  sandglass_trace trace;
  uint32_t level_count;  // rungs of the ladder, 1..; the governor takes the lowest-numbered one whose forecast fits the
                         // budget
  uint32_t finest_level;  // rungs better than this are not used
  uint32_t level;  // of the last frame; a better one must fit 7/8 of the budget, so that quality does not flicker
  PredictorPolicy policy;
  uint64_t closing_excess_ns;  // of the last frame: time by which the output stage outran what was kept free for it
  // Recent cost of each kind, picoseconds an item (integers: the same clock trace gives the same plan everywhere).
  struct Kind {
    uint64_t recent[16];
    uint64_t estimate;       // from `recent`, whenever that changes
    uint32_t count;          // of `recent`
    uint32_t cursor;         // where the next observation goes
    uint32_t frames_denied;  // in a row: offered, predicted not to fit, never run
    uint32_t frames_idle;    // in a row: never run
  } kinds[k_unit_kinds];
};

void governor_init(Governor* governor, sandglass_clock clock, sandglass_trace trace, uint32_t level_count);

// Runs one frame over the stages. `replay` NULL: by clock and budget. Else: executes that plan and reads the clock only
// to report. Fills level, budget, elapsed, mandatory, last and longest unit, clock_fault, stages and plan of *report.
// Returns false, with nothing run beyond what fitted, when a replayed plan is malformed or asks for a unit that its
// stage does not offer.
//
// Nothing runs that the plan cannot record: where the stages alternate so often that the runs would overflow, the frame
// ends early (the output stage always has its run). Without a clock everything runs, at the finest rung.
bool governor_frame(Governor* governor, const Stage* stages, uint32_t stage_count, uint64_t budget_ns,
                    const sandglass_plan* replay, sandglass_frame_report* report);

// The part of a budget that a device with this thermal headroom (0..1; sandglass_frame_input) can sustain. Scaled in
// steps of 1/1024 in integers, so that the same hint gives the same plan everywhere.
uint64_t governor_target(uint64_t budget_ns, float headroom);

// Predicted cost of `items` of a kind in nanoseconds; 0 while nothing is known.
uint64_t governor_predict(const Governor* governor, uint32_t kind, uint64_t items);

}  // namespace sandglass
