// One frame, top to bottom: choose a quality level; run what is mandatory; keep time free for the output stage; admit
// optional units while they fit; run the output stage; remember what things cost.
//
// The clock is read once after every unit, and time is the sum of the differences. So every nanosecond of the frame
// belongs to some unit, the governor's own overhead included. A difference is believed when it is positive and below a
// second; otherwise the unit is charged with its prediction. Differences wrap modulo 2^64 and all other sums saturate,
// so no reading can overflow anything.
#include "runtime/frame/governor.h"

#include "kernels/whole.h"
#include "platform/check.h"
#include "platform/trace.h"
#include "runtime/frame/predictor.h"

namespace sandglass {
namespace {

// A unit is meant to take 50 us. A second means a suspended machine, a debugger or a broken clock. A step backward,
// modulo 2^64, is longer than that too.
constexpr uint64_t k_jump_ns = 1000000000;
// A unit of unknown cost that the clock did not see counts for this part of the budget: 62 us of 4 ms.
constexpr uint64_t k_unit_cap = 64;
// A clock that does not move for this many units in a row is not coarse but frozen.
constexpr uint32_t k_frozen_units = 8;
// Most optional units of a frame. At 60 ns each, less than reading a clock takes, they fill 4 ms. A clock that shows
// room for more does not follow the work.
constexpr uint32_t k_optional_units_max = 65536;
// A level better than the last frame's must leave this part of the budget free.
constexpr uint64_t k_hysteresis_divisor = 8;
// Shares are in units of 1/1024, to stay in integers.
constexpr uint32_t k_share_one = 1024;

// One frame in progress.
struct Frame {
  Governor* governor;
  const Stage* stages;
  sandglass_frame_report* report;
  uint32_t open_count;  // stages before the output stage
  uint32_t level;
  bool timed;  // the clock decides
  bool reads;  // the clock is read (a replay reads it to report)
  uint64_t budget;
  uint64_t reserve;
  uint64_t reserve_margin;  // of it: what the output stage may take beyond its estimate

  uint64_t reading;  // the clock's last
  uint64_t elapsed;  // sum of believed differences
  uint64_t assumed;  // predictions of units whose difference was not believed
  uint64_t unseen;   // predictions of units since the clock last moved
  uint32_t unseen_units;
  uint32_t optional_units;
  bool closed;            // one of those has run
  bool closing;           // the output stage knows that it is the frame's end; its units are a run of their own
  uint32_t quiet;         // bit i: stage i offered nothing, and no unit has run since
  uint64_t kinds_run;     // bit k: kind k
  uint64_t kinds_denied;  // bit k: a unit of kind k was predicted not to fit
};

uint64_t share_of(uint64_t time, float share) {
  const uint64_t parts = share > 0.0f ? (share < 1.0f ? to_whole<uint64_t>(share * k_share_one) : k_share_one) : 0;
  return time / k_share_one * parts + time % k_share_one * parts / k_share_one;
}

// ---------------------------------------------------------------------------------------------------- forecasts

// Predicted cost of all that the stage would like to do, and whether the cost of some of it is unknown. Work that it
// may spread over frames counts for no more than it will get.
uint64_t predict_stage(const Governor* governor, const Stage& stage, uint32_t level, uint64_t budget, bool* unknown) {
  Forecast entries[k_unit_kinds];
  const uint32_t count = stage_forecast(stage, level, entries);
  uint64_t sum = 0, spread = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const uint64_t ns = governor_predict(governor, entries[i].kind, entries[i].items);
    if (ns == 0 && entries[i].items != 0) *unknown = true;
    if (entries[i].spread) spread = add(spread, ns);
    else sum = add(sum, ns);
  }
  const uint64_t limit = share_of(budget, stage.share);
  return add(sum, spread < limit ? spread : limit);
}

// Out of line: its entries are not on the stack below every unit.
__attribute__((noinline)) bool has_forecast(const Stage& stage, uint32_t level) {
  Forecast entries[k_unit_kinds];
  const uint32_t count = stage_forecast(stage, level, entries);
  for (uint32_t i = 0; i < count; ++i)
    if (entries[i].items != 0) return true;
  return false;
}

uint32_t first_level_that_fits(const Governor* governor, const Stage* stages, uint32_t stage_count, uint64_t budget) {
  for (uint32_t level = governor->finest_level; level + 1 < governor->level_count; ++level) {
    bool unknown = false;  // unknown work counts for nothing: trying it is how its cost becomes known
    uint64_t sum = 0;
    for (uint32_t i = 0; i < stage_count; ++i)
      sum = add(sum, predict_stage(governor, stages[i], level, budget, &unknown));
    if (sum <= (level < governor->level ? budget - budget / k_hysteresis_divisor : budget)) return level;
  }
  return governor->level_count - 1;
}

uint32_t choose_level(Governor* governor, const Stage* stages, uint32_t stage_count, uint64_t budget) {
  const uint32_t fits = first_level_that_fits(governor, stages, stage_count, budget);
  if (fits >= governor->level) {
    governor->better_frames = 0;
    return fits;
  }
  // What leaves half of the budget free is no matter of single frames.
  const uint32_t fits_half = first_level_that_fits(governor, stages, stage_count, budget / 2);
  if (fits_half < governor->level) {
    governor->better_frames = 0;
    return fits_half;
  }
  if (governor->better_frames == 0 || fits > governor->better_level) governor->better_level = fits;
  if (++governor->better_frames < governor->policy.better_after) return governor->level;
  governor->better_frames = 0;
  return governor->better_level;
}

// ---------------------------------------------------------------------------------------------------- time and units

// How far costs of before a jump lay apart says nothing about those after it.
void forget_spreads(Governor* governor) {
  for (Governor::Kind& kind : governor->kinds) kind.spread = {};
  governor->closing = {};
}

uint64_t read_difference(Frame* frame) {
  const uint64_t reading = frame->governor->clock.now_ns(frame->governor->clock.user);
  const uint64_t difference = reading - frame->reading;
  frame->reading = reading;
  if (difference < k_jump_ns) return difference;
  frame->report->time.clock_fault = 1;
  forget_spreads(frame->governor);
  return k_time_max;
}

// The duration of the unit that has just run, or 0 if the clock's difference is not believed.
uint64_t account(Frame* frame, const WorkUnit& unit) {
  const uint64_t predicted = governor_predict(frame->governor, unit.kind, unit.items);
  const uint64_t charge = predicted != 0 ? predicted : frame->budget / k_unit_cap + 1;
  const uint64_t difference = read_difference(frame);
  if (difference == k_time_max) {
    frame->assumed = add(frame->assumed, charge);
    return 0;
  }
  if (difference == 0) {
    frame->unseen = add(frame->unseen, charge);
    ++frame->unseen_units;
    return 0;
  }
  // A coarse clock shows the time of many units at once: each is given an equal part.
  if (frame->timed)
    predictor_observe(frame->governor, unit, difference / (static_cast<uint64_t>(frame->unseen_units) + 1));
  frame->unseen = 0;
  frame->unseen_units = 0;
  frame->elapsed += difference;
  return difference;
}

// Room in the plan for one more unit of a stage; one run is kept for the output stage.
bool plan_has_room(const Frame& frame, uint32_t stage) {
  const sandglass_plan& plan = frame.report->plan;
  if (plan.run_count > 0) {
    const sandglass_plan_run& last = plan.runs[plan.run_count - 1];
    if (last.stage == stage && last.units != ~0u) return true;
  }
  return plan.run_count < SANDGLASS_PLAN_RUNS - (stage < frame.open_count ? 1u : 0u);
}

void plan_append(sandglass_plan* plan, uint32_t stage, bool anew) {
  if (plan->run_count > 0 && !anew) {
    sandglass_plan_run* last = &plan->runs[plan->run_count - 1];
    if (last->stage == stage && last->units != ~0u) {
      ++last->units;
      return;
    }
  }
  plan->runs[plan->run_count++] = {stage, 1};
}

// Runs the unit that the stage offers, records it in the plan and returns its duration.
uint64_t run_unit(Frame* frame, uint32_t index, const WorkUnit& unit) {
  const Stage& stage = frame->stages[index];
  sandglass_frame_report* report = frame->report;
  trace_begin(frame->governor->trace, unit.name);
  stage.run(stage.state, frame->level);
  frame->quiet = 0;
  trace_end(frame->governor->trace, unit.name);
  const UnitObserver& observer = frame->governor->observer;
  if (observer.ran != nullptr) observer.ran(observer.user, unit);
  plan_append(&report->plan, index, frame->closing && !frame->closed);
  frame->closed = frame->closing;
  ++report->stages[index].units;
  if (!frame->reads) return 0;

  const uint64_t duration = account(frame, unit);
  report->stages[index].elapsed_ns += duration;
  if (duration > report->time.longest_unit_ns) report->time.longest_unit_ns = duration;
  if (frame->timed && unit.kind < k_unit_kinds) {
    frame->kinds_run |= 1ull << unit.kind;
    frame->governor->kinds[unit.kind].frames_denied = 0;
    frame->governor->kinds[unit.kind].frames_idle = 0;
  }
  return duration;
}

bool offers(const Frame& frame, uint32_t index, WorkUnit* unit) {
  const Stage& stage = frame.stages[index];
  return stage.state != nullptr && stage_next(stage, frame.level, unit);  // null: it is left out
}

// ---------------------------------------------------------------------------------------------------- admission

// Whether `cost` still fits: by the clock, and by what was charged where the clock said nothing.
bool fits(Frame* frame, uint64_t cost) {
  const uint64_t charged = add(frame->elapsed, frame->assumed);
  const uint64_t needed = add(cost, frame->reserve);
  if (add(add(charged, frame->unseen), needed) <= frame->budget) return true;
  // Would the clock alone have said yes? Then it stands still, unless it is merely coarse.
  const bool clock_agrees = add(charged, needed) > frame->budget;
  if (!clock_agrees && (charged == 0 || frame->unseen_units >= k_frozen_units)) frame->report->time.clock_fault = 1;
  return false;
}

bool admitted(Frame* frame, const WorkUnit& unit) {
  if (!frame->timed) return true;
  if (frame->optional_units >= k_optional_units_max) {
    frame->report->time.clock_fault = 1;
    return false;
  }
  if (!fits(frame, 1)) return false;  // no time at all: says nothing about the kind
  const uint64_t predicted = governor_predict(frame->governor, unit.kind, unit.items);
  if (predicted == 0) return true;

  const PredictorPolicy& policy = frame->governor->policy;
  const Governor::Kind& kind = frame->governor->kinds[unit.kind];
  uint64_t cost = with_margin(policy, kind.spread, predicted);
  // The unit and the output stage seldom exceed their estimates in the same frame: half the smaller margin serves both,
  // but no less than the smallest margin is left.
  const uint64_t margin = cost - predicted, smallest = with_margin(policy, Spread{}, predicted);
  const uint64_t shared = (margin < frame->reserve_margin ? margin : frame->reserve_margin) / 2;
  cost = cost - shared > smallest ? cost - shared : smallest;
  if (policy.capped && cost > frame->budget / 2) cost = frame->budget / 2;
  if (policy.probe_frames != 0) {
    if (kind.frames_denied + 1 >= policy.probe_frames) return true;
    cost -= cost / policy.probe_frames * kind.frames_denied;
  }
  if (fits(frame, cost)) return true;
  frame->kinds_denied |= 1ull << unit.kind;
  return false;
}

// Mandatory units of all stages but the output stage. In several passes, since one stage's units may unblock another's.
void run_mandatory(Frame* frame, uint64_t* last_unit) {
  bool ran = true;
  while (ran) {
    ran = false;
    for (uint32_t i = 0; i < frame->open_count; ++i) {
      WorkUnit unit;
      while (frame->report->stages[i].units < frame->stages[i].mandatory_units && plan_has_room(*frame, i) &&
             offers(*frame, i, &unit)) {
        *last_unit = run_unit(frame, i, unit);
        ran = true;
      }
    }
  }
}

// Runs the first unit of the output stage where the cost of its kind is unknown. Otherwise half of the first frame's
// budget would be kept free for it, and the frame would begin with a time debt that it need not have.
void learn_output(Frame* frame, uint32_t output, uint64_t* last_unit) {
  WorkUnit unit;
  if (!offers(*frame, output, &unit) || unit.kind >= k_unit_kinds || !plan_has_room(*frame, output)) return;
  if (governor_predict(frame->governor, unit.kind, unit.items) == 0) *last_unit = run_unit(frame, output, unit);
}

// Whether a later stage has a claim on optional time. A stage that is blocked has one, until a whole pass ran nothing:
// then the units that would unblock it must be allowed to run.
bool later_stage_has_work(const Frame& frame, uint32_t index, const bool* denied, bool blocked_counts) {
  for (uint32_t i = index + 1; i < frame.open_count; ++i) {
    if (denied[i]) continue;
    WorkUnit unit;
    if (offers(frame, i, &unit)) return true;
    if (blocked_counts && has_forecast(frame.stages[i], frame.level)) return true;
  }
  return false;
}

// Optional units, in passes over the stages until one runs nothing. Returns whether any ran.
bool run_optional(Frame* frame, uint64_t* last_unit) {
  uint64_t allowance[SANDGLASS_STAGE_COUNT] = {};
  uint64_t used[SANDGLASS_STAGE_COUNT] = {};
  bool denied[SANDGLASS_STAGE_COUNT] = {};
  const uint64_t taken = add(add(frame->elapsed, frame->assumed), add(frame->unseen, frame->reserve));
  const uint64_t left = frame->budget > taken ? frame->budget - taken : 0;
  for (uint32_t i = 0; i < frame->open_count; ++i)
    allowance[i] = frame->stages[i].state != nullptr ? share_of(left, frame->stages[i].share) : 0;

  bool blocked_counts = true;
  for (;;) {
    bool ran = false, kept_back = false;
    for (uint32_t i = 0; i < frame->open_count; ++i) {
      WorkUnit unit;
      denied[i] = false;
      for (;;) {
        if (!offers(*frame, i, &unit)) frame->quiet |= 1u << i;
        if ((frame->quiet >> i & 1) != 0 || !plan_has_room(*frame, i)) break;
        const bool over_share = frame->timed && frame->stages[i].share < 1.0f && used[i] >= allowance[i];
        if (over_share && later_stage_has_work(*frame, i, denied, blocked_counts)) {
          kept_back = true;
          break;
        }
        if (!admitted(frame, unit)) {
          denied[i] = true;
          break;
        }
        const uint64_t before = add(add(frame->elapsed, frame->assumed), frame->unseen);
        *last_unit = run_unit(frame, i, unit);
        const uint64_t after = add(add(frame->elapsed, frame->assumed), frame->unseen);
        used[i] = add(used[i], after > before ? after - before : 0);
        ++frame->optional_units;
        ran = true;
      }
    }
    if (!ran && !(kept_back && blocked_counts)) break;
    if (!ran) blocked_counts = false;
  }
  return frame->optional_units > 0;
}

void close_frame(Frame* frame, uint32_t stage_count) {
  const Stage* last = stage_count == frame->open_count ? nullptr : &frame->stages[frame->open_count];
  if (frame->closing || last == nullptr || last->close == nullptr) return;
  frame->closing = true;
  frame->quiet = 0;
  last->close(last->state);
}

// All units that close the frame.
void run_closing(Frame* frame, uint32_t index, uint64_t* last_unit) {
  WorkUnit unit;
  while (offers(*frame, index, &unit) && plan_has_room(*frame, index)) *last_unit = run_unit(frame, index, unit);
}

// Executes a recorded plan. Each unit is asked for before it is run. What closes a frame runs whole, as it did then: its
// count says nothing, and is another where the frame is replayed without what was only drawn.
bool run_plan(Frame* frame, const sandglass_plan& plan, uint32_t stage_count, uint64_t* last_unit) {
  const bool closes = frame->open_count < stage_count && frame->stages[frame->open_count].close != nullptr;
  for (uint32_t r = 0; r < plan.run_count; ++r) {
    const uint32_t stage = plan.runs[r].stage;
    if (stage >= stage_count) return false;
    if (closes && stage == frame->open_count && r + 1 == plan.run_count) break;
    for (uint32_t i = 0; i < plan.runs[r].units; ++i) {
      WorkUnit unit;
      const bool offered = offers(*frame, stage, &unit) && plan_has_room(*frame, stage);
      if (!offered && closes && stage == frame->open_count) break;
      if (!offered) return false;
      *last_unit = run_unit(frame, stage, unit);
    }
  }
  close_frame(frame, stage_count);
  if (closes) run_closing(frame, frame->open_count, last_unit);
  return true;
}

void remember_denials(Governor* governor, const Frame& frame) {
  for (uint32_t k = 0; k < k_unit_kinds; ++k) {
    const uint64_t bit = 1ull << k;
    Governor::Kind* kind = &governor->kinds[k];
    if ((frame.kinds_run & bit) != 0) continue;
    if (kind->frames_idle != ~0u) ++kind->frames_idle;
    if ((frame.kinds_denied & bit) != 0) ++kind->frames_denied;
  }
}

void clear_report(sandglass_frame_report* report, uint64_t budget) {
  *report = {};
  report->time.budget_ns = report->time.target_ns = budget;
  report->plan.struct_size = sizeof(sandglass_plan);
}

Frame frame_of(Governor* governor, const Stage* stages, uint32_t stage_count, uint64_t budget, bool replays,
               sandglass_frame_report* report) {
  const bool has_output = stage_count > 0 && stages[stage_count - 1].mandatory_units == k_all_units;
  Frame frame = {};
  frame.governor = governor;
  frame.stages = stages;
  frame.report = report;
  frame.open_count = has_output ? stage_count - 1 : stage_count;
  frame.budget = budget;
  frame.reads = governor->clock.now_ns != nullptr;
  frame.timed = frame.reads && !replays;
  if (frame.reads) frame.reading = governor->clock.now_ns(governor->clock.user);
  return frame;
}

// Keeps time free for the output stage. What it is estimated to cost; 0: not known.
uint64_t reserve_output(Frame* frame, uint32_t output, uint64_t* last_unit) {
  learn_output(frame, output, last_unit);
  const Governor* governor = frame->governor;
  bool unknown = false;
  const uint64_t closing = predict_stage(governor, frame->stages[output], frame->level, frame->budget, &unknown);
  frame->reserve = with_margin(governor->policy, governor->closing, closing);
  frame->reserve_margin = frame->reserve - closing;
  if (unknown && frame->reserve < frame->budget / 2) frame->reserve = frame->budget / 2;
  return unknown ? 0 : closing;
}

// All units, as the clock allows. Returns the nanoseconds of the optional ones.
uint64_t run_units(Frame* frame, uint32_t stage_count, uint64_t* last_unit) {
  Governor* governor = frame->governor;
  const uint32_t output = frame->open_count;
  const bool has_output = output < stage_count;
  uint64_t last_optional = 0;
  run_mandatory(frame, last_unit);
  const uint64_t closing = has_output && frame->timed ? reserve_output(frame, output, last_unit) : 0;
  const uint64_t optional_from = frame->elapsed;
  const bool any = run_optional(frame, &last_optional);
  const uint64_t output_from = frame->elapsed;
  close_frame(frame, stage_count);
  if (has_output) run_closing(frame, output, last_unit);
  const uint64_t output_ns = frame->elapsed - output_from;
  if (output_ns != 0) spread_observe(governor->policy, &governor->closing, output_ns, closing);
  if (any && output_ns > frame->reserve && frame->timed) governor->closing_excess_ns = output_ns - frame->reserve;
  if (any) *last_unit = last_optional;
  if (frame->timed) remember_denials(governor, *frame);
  return output_from - optional_from;
}

}  // namespace

void governor_init(Governor* governor, sandglass_clock clock, sandglass_trace trace, uint32_t level_count) {
  SANDGLASS_CHECK(level_count >= 1);
  *governor = {};
  governor->clock = clock;
  governor->trace = trace;
  governor->level_count = level_count;
  governor->policy = k_predictor_policy;
}

void assign_kinds(Stage* stages, uint32_t count) {
  uint32_t next = 0;
  for (uint32_t i = 0; i < count; ++i) {
    uint32_t same = stages[i].state == nullptr ? i : 0;
    while (same < i && stages[same].state != stages[i].state) ++same;
    if (same < i) {
      SANDGLASS_CHECK(stages[same].kinds == stages[i].kinds);
      stages[i].first_kind = stages[same].first_kind;
    } else {
      stages[i].first_kind += next;
      next += stages[i].kinds;
    }
  }
  SANDGLASS_CHECK(next <= k_unit_kinds);
}

Stage stage_without_work(uint32_t kinds) {
  return {nullptr,
          [](const void*, uint32_t, WorkUnit*) { return false; },
          [](void*, uint32_t) {},
          [](const void*, uint32_t, Forecast*) -> uint32_t { return 0; },
          kinds,
          0,
          1.0f};
}

bool stage_next(const Stage& stage, uint32_t level, WorkUnit* unit) {
  if (!stage.next(stage.state, level, unit)) return false;
  if (unit->kind < k_unit_kinds) unit->kind += stage.first_kind;
  return true;
}

uint32_t stage_forecast(const Stage& stage, uint32_t level, Forecast* entries) {
  const uint32_t count = stage.forecast(stage.state, level, entries);
  SANDGLASS_CHECK(count <= k_unit_kinds);
  for (uint32_t i = 0; i < count; ++i) entries[i].kind += stage.first_kind;
  return count;
}

uint64_t governor_target(uint64_t budget_ns, float headroom) {
  const bool is_number = headroom == headroom;
  return is_number ? share_of(budget_ns, headroom) : budget_ns;
}

bool governor_frame(Governor* governor, const Stage* stages, uint32_t stage_count, uint64_t budget_ns,
                    const sandglass_plan* replay, sandglass_frame_report* report) {
  SANDGLASS_CHECK(report != nullptr && stage_count <= SANDGLASS_STAGE_COUNT);
  for (uint32_t i = 0; i + 1 < stage_count; ++i) SANDGLASS_CHECK(stages[i].mandatory_units != k_all_units);
  clear_report(report, budget_ns);
  governor->closing_excess_ns = 0;
  Frame frame = frame_of(governor, stages, stage_count, budget_ns, replay != nullptr, report);
  if (replay != nullptr) {
    if (replay->run_count > SANDGLASS_PLAN_RUNS || replay->level >= governor->level_count) return false;
    frame.level = replay->level;
  } else {
    frame.level = frame.timed ? choose_level(governor, stages, stage_count, budget_ns) : governor->finest_level;
  }
  report->level = report->plan.level = governor->level = frame.level;
  if (frame.reads) {  // the choice itself took time: mandatory
    const uint64_t difference = read_difference(&frame);
    if (difference != k_time_max) frame.elapsed = difference;
  }
  bool complete = true;
  uint64_t last_unit = 0, optional_ns = 0;
  if (replay != nullptr) complete = run_plan(&frame, *replay, stage_count, &last_unit);
  else optional_ns = run_units(&frame, stage_count, &last_unit);
  for (uint32_t i = 0; i < frame.open_count; ++i) {
    WorkUnit unit;
    report->stages[i].denied = (frame.quiet >> i & 1) == 0 && offers(frame, i, &unit) ? 1 : 0;
  }
  report->time.elapsed_ns = frame.elapsed;
  report->time.mandatory_ns = frame.elapsed - optional_ns;
  report->time.last_unit_ns = add(last_unit, governor->closing_excess_ns);
  return complete;
}

}  // namespace sandglass
