// How much time is simulated, in how many parts, and what is given up where time is short. Whether a sub-step still
// fits into the frame, the governor decides (frame/governor.cpp).
#include "kernels/whole.h"
#include "runtime/math/finite.h"
#include "runtime/sand/granular.h"

namespace sandglass {

// ---- ShownTime

namespace {

constexpr double k_rate_frames = 8.0;      // over which the rate is smoothed
constexpr double k_frames_max = 4.0;       // in one frame; more says nothing about the rate
constexpr double k_behind_max = 2.0;       // frames
constexpr double k_spare_frames = 32.0;    // in which a frame's worth of spare time may come back
constexpr double k_spare_taken = 1.0 / 8;  // of it, a frame
constexpr double k_duration_min = 1e-5;    // seconds; less is none

}  // namespace

void shown_reset(ShownTime* s) { *s = {0.0, 0.0, 1.0, 0.0}; }

void shown_follow(ShownTime* s, double reached, double step) {
  if (__builtin_fabs(reached - s->reached) < k_duration_min) reached = s->reached;  // rounding
  if (step > 0.0) {
    const double frames = (reached - s->reached) / step;
    const double counted = frames > 0.0 ? (frames < k_frames_max ? frames : k_frames_max) : 0.0;
    s->rate += (counted - s->rate) / k_rate_frames;
    double ahead = reached - (s->shown + s->rate * step);
    if (ahead > k_behind_max * step) ahead = k_behind_max * step;
    s->spare += step / k_spare_frames;
    if (ahead < s->spare) s->spare = ahead > 0.0 ? ahead : 0.0;
    ahead -= k_spare_taken * s->spare;
    s->shown = ahead < k_duration_min ? reached : reached - ahead;
  }
  s->reached = reached;
  if (s->shown > reached) s->shown = reached;
}

// ---- SimulatedTime

namespace {

constexpr float k_longest_gap = 10.0f;    // seconds; a longer frame says nothing about where things were
constexpr double k_frames_made_up = 2.0;  // an older debt becomes slow motion
// With time debt a sweep covers up to so many frames. It costs the same whatever time it covers.
constexpr double k_frames_in_sweep = 2.0;

// Sub-steps of an interval. Where the shortest sub-step would need more, they are longer: else no frame would end.
constexpr uint32_t k_substeps_max = 10000;

// Rounded up; but a hair above a whole number is that number: 20 ms in steps of 20/64 ms are 64.
uint32_t whole_parts(double count) {
  const uint32_t whole = to_whole<uint32_t>(count);
  return count - whole > 1e-4 ? whole + 1 : (whole == 0 ? 1 : whole);
}

}  // namespace

void time_reset(SimulatedTime* t) {
  t->frame_step = t->left_out = 0.0f;
  t->debt = t->interval_debt = t->slipped = t->simulated = t->grain_lag = t->asked = 0.0;
  t->share = t->rate = 1.0;
  shown_reset(&t->grains);
}

void time_restore(SimulatedTime* t, const SavedScene& s) {
  t->debt = s.state.debt;
  t->slipped = s.state.slipped;
  t->simulated = s.state.simulated;
  t->grain_lag = s.state.grain_lag;
  t->frame_step = s.state.frame_step;
  t->grains = s.state.shown;
  t->share = s.state.share;
  t->rate = s.state.rate;
}

static void take_step(SimulatedTime* time, const Granular& g, float asked) {
  SimulatedTime& t = *time;
  const float some = is_finite(asked) && asked > 0.0f ? asked : 0.0f;
  const float step = some < k_longest_step ? some : k_longest_step;
  const double debt_max = k_frames_made_up * static_cast<double>(step);
  t.frame_step = step;
  t.left_out = (some < k_longest_gap ? some : k_longest_gap) - step;
  t.debt += static_cast<double>(step);
  if (g.substep.interval_left == 0) {
    if (step > 0.0f && t.debt > debt_max) {
      t.slipped += t.debt - debt_max;
      t.debt = debt_max;
    }
    return;
  }
  // An interval under way is never cut short.
  t.interval_debt += static_cast<double>(step);
  if (step > 0.0f && t.interval_debt > debt_max) {
    t.slipped += t.interval_debt - debt_max;
    t.debt -= t.interval_debt - debt_max;
    t.interval_debt = debt_max;
  }
}

void time_take(SimulatedTime* t, const Granular& g, float asked) {
  take_step(t, g, asked);
  t->asked = t->debt;
}

float time_find_rate(SimulatedTime* time) {
  // It falls faster than it rises: a collider that is too fast for the time that sand has presses it together.
  constexpr double k_falls = 0.5, k_rises = 0.25, k_whole = 0.9, k_share_min = 1.0 / 64;
  SimulatedTime& t = *time;
  const double step = static_cast<double>(t.frame_step), done = (t.asked - t.debt) / step, before = t.rate;
  const double now = done < 1.0 ? done : 1.0;
  t.share += (now < t.share ? k_falls : k_rises) * (now - t.share);
  if (t.debt < k_time_resolution && t.share > k_whole) t.share = 1.0;
  if (t.share < k_share_min) t.share = k_share_min;
  const double needed = t.debt < k_time_resolution ? 1.0 : step / (step + t.debt);
  t.rate = t.share < needed ? t.share : needed;
  return static_cast<float>(t.rate / before);
}

void time_forget_rate(SimulatedTime* t) { t->share = t->rate = 1.0; }

void time_end_frame(SimulatedTime* t, const Granular& g) {
  const double reached = g.grains.count != 0 ? t->simulated - t->grain_lag : t->simulated;
  shown_follow(&t->grains, reached, static_cast<double>(t->frame_step));
}

bool time_paused(const Granular& g) { return !(g.time.frame_step > 0.0f); }

void time_pay(SimulatedTime* time, const Granular& g) {
  SimulatedTime& t = *time;
  const double paid = static_cast<double>(g.substep.length);
  t.simulated += paid;
  if (g.grains.count != 0) t.grain_lag += paid;
  t.debt -= paid;
  if (g.substep.interval_left != 0) return;
  // The rounding of the parts does not add up: at the end of an interval the debt is what it was meant to be.
  t.simulated += t.debt - t.interval_debt;
  t.debt = t.interval_debt;
  if (t.debt < k_time_resolution) t.debt = 0.0;
}

void time_skip(SimulatedTime* time, const Granular& g) {
  SimulatedTime& t = *time;
  t.simulated += t.debt;
  if (g.grains.count != 0) {
    // Around sleepers grains only come to rest: what they cannot follow now they need not.
    const double limit = time_lag_limit(g);
    t.grain_lag += t.debt;
    if (t.grain_lag > limit) t.grain_lag = limit;
  }
  t.debt = t.interval_debt = 0.0;
}

void time_begin_interval(SimulatedTime* t, double interval) { t->interval_debt = t->debt - interval; }

void time_forget_interval(SimulatedTime* t) { t->interval_debt = 0.0; }

void time_grains_followed(SimulatedTime* t, double seconds) {
  t->grain_lag -= seconds;
  if (t->grain_lag < k_time_resolution) t->grain_lag = 0.0;
}

void time_grains_followed(SimulatedTime* t) { t->grain_lag = 0.0; }

double time_interval(const Granular& g) {
  const double longest = g.desc.reference.blend == SANDGLASS_BLEND_SOURCE && g.desc.grain_capacity != 0
                             ? static_cast<double>(g.desc.refine_step)
                             : static_cast<double>(g.time.frame_step);
  const double count = g.time.debt / (longest > k_time_resolution ? longest : g.time.debt);
  return g.time.debt / static_cast<double>(whole_parts(count));
}

uint32_t time_substeps(const Granular& g, double interval, uint32_t level) {
  float limit = level_substep(k_ladder[level], g.desc.reference.solver_iterations, g.substep.longest);
  if (g.particles.speed_max > 0.0f) {
    // What falls is faster at the interval's end.
    const float speed = g.particles.speed_max + g.gravity_length * static_cast<float>(interval);
    const float courant = g.desc.courant * g.desc.particle_radius / speed;
    limit = courant < limit ? courant : limit;
    limit = limit < g.substep.shortest ? g.substep.shortest : limit;
  }
  const uint32_t count = whole_parts(interval / static_cast<double>(limit));
  return count < k_substeps_max ? count : k_substeps_max;
}

SubstepPlan time_plan_substep(const Granular& g, uint32_t level) {
  SubstepPlan plan = {0.0, g.substep.interval_left, g.substep.length, false};
  if (plan.count == 0) {
    plan.interval = time_interval(g);
    plan.count = time_substeps(g, plan.interval, level);
    plan.substep = static_cast<float>(plan.interval / plan.count);
  }
  plan.stale = neighbours_stale(g, level, plan.substep);
  return plan;
}

double time_lag_limit(const Granular& g) {
  const float frame = g.time.frame_step > g.desc.refine_step ? g.time.frame_step : g.desc.refine_step;
  const double under_way = g.sweep.phase == SweepPhase::idle ? 0.0 : g.sweep.time;
  return under_way + k_sweep_steps_max * static_cast<double>(frame);
}

bool time_awaits_grains(const Granular& g) {
  if (g.grains.count == 0 || g.particles.count == 0) return false;  // without particles there is nothing to follow
  const SimulatedTime& t = g.time;
  if (g.substep.interval_left != 0 || t.grain_lag <= k_time_resolution) return false;
  const bool owes = t.debt >= k_time_resolution && g.desc.reference.blend != SANDGLASS_BLEND_SOURCE;
  if (!owes || g.sweep.phase != SweepPhase::idle) return true;
  return t.grain_lag + time_interval(g) > 1.0001 * k_frames_in_sweep * static_cast<double>(t.frame_step);
}

// ---- The quality ladder

namespace {

struct Measured {
  float cost_solver, cost_refine, overlap_p99, overlap_mean, angle_deg;
};

constexpr Measured k_measured[] = {
#include "runtime/sand/ladder_measured.inc"
};
constexpr uint32_t k_measured_levels = sizeof k_measured / sizeof k_measured[0];
static_assert(k_measured_levels == SANDGLASS_LEVEL_SLOW_MOTION, "slow motion has the numbers of the level before it");

constexpr bool each_gives_up_accuracy_for_time() {
  for (uint32_t level = 1; level < k_measured_levels; ++level) {
    const Measured &better = k_measured[level - 1], &cheaper = k_measured[level];
    if (cheaper.cost_solver > better.cost_solver || cheaper.overlap_p99 < better.overlap_p99) return false;
  }
  return true;
}
static_assert(each_gives_up_accuracy_for_time(), "a level that is both dearer and worse than another has no use");

constexpr sandglass_level reported(const char* name, uint32_t measured) {
  const Measured& m = k_measured[measured];
  return {sizeof(sandglass_level), name, m.cost_solver, m.cost_refine, m.overlap_p99, m.overlap_mean, m.angle_deg};
}

}  // namespace

const QualityLevel k_ladder[SANDGLASS_LEVEL_COUNT] = {
    {1.0f, 1.0f, reported("full", 0)},
    {2.0f, 1.0f, reported("lists kept longer", 1)},
    {2.0f, 4.0f / 3.0f, reported("sub-steps 4/3 as long", 2)},
    {2.0f, 2.0f, reported("sub-steps twice as long", 3)},
    {2.0f, 2.0f, reported("slow motion", 3)},
};

uint32_t level_iterations(const QualityLevel& level, uint32_t iterations) {
  const uint32_t fewer = to_whole<uint32_t>(static_cast<float>(iterations) / level.coarsening + 0.5f);
  return iterations <= 1 || fewer == 0 ? 1 : fewer;
}

float level_substep(const QualityLevel& level, uint32_t iterations, float longest) {
  return iterations <= 1 ? longest * level.coarsening : longest;
}

}  // namespace sandglass
