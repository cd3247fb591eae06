// The particles' machine: which phase of a sub-step follows which.
//
// A sub-step predicts, resolves the contacts pair by pair, and completes the motion with the colliders. In the source's
// scheme a pass does all of that at once. Passes over particles run over the record groups that hold an awake one
// (Sleep, in solver.h).
#include "kernels/whole.h"
#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

// 2^32 over the golden ratio: every stretch of the sequence averages to nothing.
constexpr uint32_t k_dither_stride = 2654435769u;

// Pairs a particle, for the forecast before they are known.
constexpr uint64_t k_pairs_expected = 5;

constexpr uint32_t bit(SubstepPhase phase) { return 1u << static_cast<uint32_t>(phase); }

// ---- what follows what

SubstepPhase solving(const Granular& g) { return solves_pairs(g) ? SubstepPhase::predict : SubstepPhase::solve; }

// What follows once the lists are good.
SubstepPhase first_pass(const Granular& g) {
  if (solves_pairs(g) && !g.colours.ready) return SubstepPhase::colours;
  return g.desc.reference.stabilisation_iterations != 0 ? SubstepPhase::stabilise : solving(g);
}

// The phase whose unit comes next; idle: none.
SubstepPhase upcoming(const Granular& g, uint32_t level) {
  const Substep& s = g.substep;
  if (s.phase != SubstepPhase::idle) return s.phase;
  if ((s.due & bit(SubstepPhase::touch)) != 0) return SubstepPhase::touch;
  if (s.interval_left == 0 && (g.time.debt < k_time_resolution || time_awaits_grains(g))) return SubstepPhase::idle;
  if (s.interval_left == 0 && departed_due(g)) return SubstepPhase::departed;
  if (flow_is_due(g)) return SubstepPhase::sort;
  if (!time_plan_substep(g, level).stale) return first_pass(g);
  return neighbours_doubt(g) ? SubstepPhase::slack : SubstepPhase::sort;
}

// What runs after a complete sub-step: the first phase that is due.
SubstepPhase first_due(const Granular& g) {
  constexpr SubstepPhase k_phases[] = {SubstepPhase::touch, SubstepPhase::wake, SubstepPhase::sleep,
                                       SubstepPhase::drain};
  for (const SubstepPhase phase : k_phases) {
    if ((g.substep.due & bit(phase)) != 0) return phase;
  }
  return g.sleep.waking_count != 0 && g.neighbours.valid ? SubstepPhase::wake_lists : SubstepPhase::idle;
}

void complete(Granular* g);

SubstepPhase begin_sort(Granular* g) {
  neighbours_begin_sort(g);
  return SubstepPhase::sort;
}

// The phase that follows `done`, whose last unit has run.
SubstepPhase after(Granular* g, SubstepPhase done) {
  Substep& s = g->substep;
  switch (done) {
    case SubstepPhase::idle:
    case SubstepPhase::departed:
      return SubstepPhase::idle;
    case SubstepPhase::slack:
      if (neighbours_stale(*g, s.level, s.length)) return begin_sort(g);
      contacts_begin(g);
      return first_pass(*g);
    case SubstepPhase::sort:
      return SubstepPhase::lists;
    case SubstepPhase::lists:
    case SubstepPhase::colours:
      contacts_begin(g);
      return first_pass(*g);
    case SubstepPhase::stabilise:
      if (++s.pass < g->desc.reference.stabilisation_iterations) return SubstepPhase::stabilise;
      s.pass = 0;
      return solving(*g);
    case SubstepPhase::predict:
      return pair_count(g->colours) != 0 ? SubstepPhase::pairs : SubstepPhase::complete;
    case SubstepPhase::pairs:
      return ++s.pass < s.iterations ? SubstepPhase::pairs : SubstepPhase::complete;
    case SubstepPhase::solve:
      if (++s.pass < s.iterations) return SubstepPhase::solve;
      [[fallthrough]];
    case SubstepPhase::complete:
      s.pass = 0;
      if (bodies_begin(g)) return SubstepPhase::bodies;
      complete(g);
      return first_due(*g);
    case SubstepPhase::bodies:
      complete(g);
      return first_due(*g);
    case SubstepPhase::touch:
    case SubstepPhase::wake:
    case SubstepPhase::sleep:
    case SubstepPhase::drain:
      s.due &= ~bit(done);
      return first_due(*g);
    case SubstepPhase::wake_lists:
      return first_due(*g);
  }
  return SubstepPhase::idle;
}

void enter(Granular* g, SubstepPhase phase) {
  g->substep.phase = phase;
  g->substep.cursor = 0;
  if (phase == SubstepPhase::idle) sleep_skip_time(g);
}

// ---- a sub-step's begin and end

void begin(Granular* g, uint32_t level) {
  Substep& s = g->substep;
  if (s.interval_left == 0) {
    // As fast as what comes within the interval.
    const float speed = flow_speed(g->flow);
    if (speed > g->particles.speed_max) g->particles.speed_max = speed;
  }
  SubstepPlan plan = time_plan_substep(*g, level);
  if (s.interval_left == 0) g->time.interval_debt = g->time.debt - plan.interval;
  g->departed.known = false;  // of the next interval
  s.interval_left = plan.count;
  s.length = plan.substep;
  s.iterations = level_iterations(k_ladder[level], g->desc.reference.solver_iterations);
  // Seconds between the end of this sub-step and the end of the frame, where the colliders' poses are given.
  const double before_end = g->time.debt - static_cast<double>(s.length);
  colliders_pose(g->colliders.given, g->colliders.solid_count, before_end > 0.0 ? static_cast<float>(before_end) : 0.0f,
                 g->colliders.substep_frames);
  g->colliders.substep_count = g->colliders.solid_count;
  s.level = level;
  if (flow_is_due(*g)) {
    flow_emit(g);
    plan.stale = neighbours_stale(*g, level, s.length);
  }
  if (plan.stale && neighbours_doubt(*g)) {
    neighbours_begin_measuring(g);
    return enter(g, SubstepPhase::slack);
  }
  if (plan.stale) return enter(g, begin_sort(g));
  contacts_begin(g);
  enter(g, first_pass(*g));
}

// The last pass has written records[1], and the bodies have corrected it: that is the state now.
void complete(Granular* g) {
  Substep& s = g->substep;
  Particles& p = g->particles;
  particles_swap(&p);
  g->counts.quarantined += s.extent.quarantined;
  p.speed_max = __builtin_sqrtf(s.extent.speed_squared);
  for (int k = 0; k < 3; ++k) {
    if (s.extent.low[k] > s.extent.high[k]) continue;
    const Bounds& resting = g->sleep.resting;
    p.low[k] = s.extent.low[k] < resting.low[k] ? s.extent.low[k] : resting.low[k];
    p.high[k] = s.extent.high[k] > resting.high[k] ? s.extent.high[k] : resting.high[k];
  }
  neighbours_wear(g);
  --s.interval_left;
  ++g->counts.substeps;
  s.dither += k_dither_stride;
  time_pay(g);
  substep_set_due(g, SubstepPhase::wake, s.extent.touched != 0);
  if (g->time.simulated < g->sleep.next_check - k_time_resolution) return;
  substep_set_due(g, SubstepPhase::sleep, g->desc.sleep_after > 0.0f);
  substep_set_due(g, SubstepPhase::drain, g->flow.sink_count != 0 || g->departed.gone);
  g->sleep.next_check = g->time.simulated + k_sleep_period;
}

// ---- the stage

struct PhaseUnit {
  uint32_t kind;
  const char* name;
};

// One a phase.
constexpr PhaseUnit k_units[] = {
    {k_unit_kind_none, ""},
    {k_unit_departed, "granular.departed"},
    {k_unit_slack, "granular.slack"},
    {k_unit_particle_sort, "granular.sort"},
    {k_unit_lists, "granular.lists"},
    {k_unit_colours, "granular.colours"},
    {k_unit_stabilise, "granular.stabilise"},
    {k_unit_solve, "granular.solve"},
    {k_unit_predict, "granular.predict"},
    {k_unit_pairs, "granular.pairs"},
    {k_unit_complete, "granular.complete"},
    {k_unit_bodies, "granular.bodies"},
    {k_unit_touch, "granular.touch"},
    {k_unit_wake, "granular.wake"},
    {k_unit_sleep, "granular.rest"},
    {k_unit_drain, "granular.drain"},
    {k_unit_lists, "granular.wake_lists"},
};
static_assert(sizeof k_units / sizeof k_units[0] == static_cast<uint32_t>(SubstepPhase::wake_lists) + 1);

// Items that the phase has left; of the sort and of the bodies, those of the next unit.
uint32_t items_left(const Granular& g, SubstepPhase phase) {
  const bool begun = g.substep.phase == phase;
  const uint32_t cursor = begun ? g.substep.cursor : 0;
  switch (phase) {
    case SubstepPhase::sort:
      return begun ? cell_sort_items(g.neighbours.sort, g.particles.count, g.unit) : g.particles.count;
    case SubstepPhase::bodies:
      return bodies_items(g);
    case SubstepPhase::pairs:
      return (pair_count(g.colours) - cursor + k_pairs_an_item - 1) / k_pairs_an_item;
    case SubstepPhase::slack:
      return g.particles.count;
    case SubstepPhase::departed:
      return departed_items(g) - cursor;
    case SubstepPhase::lists:
    case SubstepPhase::colours:
    case SubstepPhase::touch:
      return g.particles.count - cursor;
    case SubstepPhase::wake:
      return sleep_active_items(g);
    case SubstepPhase::wake_lists:
      return g.sleep.waking_count * k_lane_group;
    default:
      return sleep_active_items(g) - cursor;
  }
}

bool next(const void* state, uint32_t level, WorkUnit* unit) {
  const Granular& g = *static_cast<const Granular*>(state);
  // What has begun ends, though the last particle is gone and the nozzle closed.
  if (time_paused(g) || (g.particles.count == 0 && g.flow.emitter_count == 0 && substep_idle(g))) return false;
  // A snapshot under way reads the state in several units and must find it unchanged.
  if (g.sweep.phase == SweepPhase::snapshot) return false;
  const SubstepPhase phase = upcoming(g, level);
  if (phase == SubstepPhase::idle) return false;
  const PhaseUnit& next = k_units[static_cast<uint32_t>(phase)];
  const uint32_t left = items_left(g, phase);
  unit->kind = next.kind, unit->name = next.name;
  const uint32_t most = phase == SubstepPhase::pairs ? pair_unit(g.colours, g.unit) / k_pairs_an_item : g.unit;
  unit->items = left < most || (phase == SubstepPhase::sort && g.substep.phase == phase) ? left : most;
  return true;
}

// Runs the phase's next unit. True once its last one has run.
bool run_unit(Granular* g, SubstepPhase phase) {
  switch (phase) {
    case SubstepPhase::idle:
      return true;
    case SubstepPhase::departed:
      return departed_run(g);
    case SubstepPhase::slack:
      return neighbours_run_measuring(g);
    case SubstepPhase::sort:
      return neighbours_run_sort(g);
    case SubstepPhase::lists:
      return neighbours_run_lists(g);
    case SubstepPhase::colours:
      return pair_colours_run(g);
    case SubstepPhase::stabilise:
    case SubstepPhase::solve:
    case SubstepPhase::predict:
    case SubstepPhase::complete:
      return contacts_run(g);
    case SubstepPhase::pairs:
      return contacts_run_pairs(g);
    case SubstepPhase::bodies:
      return bodies_run(g);
    case SubstepPhase::touch:
      return sleep_run_touch(g);
    case SubstepPhase::wake:
      return sleep_run_wake(g);
    case SubstepPhase::sleep:
      return sleep_run_sleep(g);
    case SubstepPhase::drain:
      return flow_run_drain(g);
    case SubstepPhase::wake_lists:
      return sleep_run_wake_lists(g);
  }
  return true;
}

void run(void* state, uint32_t level) {
  Granular* g = static_cast<Granular*>(state);
  output_restart(&g->output);  // emitters and sinks change what was written
  if (g->substep.phase == SubstepPhase::idle) {
    const SubstepPhase first = upcoming(*g, level);
    if (first == SubstepPhase::touch || first == SubstepPhase::departed) enter(g, first);
    else begin(g, level);
  }
  const SubstepPhase phase = g->substep.phase;
  if (run_unit(g, phase)) enter(g, after(g, phase));
}

uint32_t forecast(const void* state, uint32_t level, Forecast* entries) {
  const Granular& g = *static_cast<const Granular*>(state);
  if (time_paused(g) || g.particles.count == 0 || g.time.debt < k_time_resolution) return 0;
  const uint64_t substeps = time_substeps(g, g.time.debt, level), count = g.particles.count;
  const uint64_t active = g.neighbours.valid ? sleep_active_items(g) : count;
  // A pile that lies still builds no lists.
  const float due = g.neighbours.valid ? 0.5f : 1.0f;
  const uint64_t builds = to_whole<uint64_t>(g.neighbours.builds_per_substep * static_cast<float>(substeps) + due);
  uint32_t n = 0;
  if (departed_due(g)) entries[n++] = {k_unit_departed, departed_items(g)};
  entries[n++] = {k_unit_slack, 2 * builds * count};
  entries[n++] = {k_unit_particle_sort, builds * 2 * count};
  entries[n++] = {k_unit_lists, builds * active};
  if (g.desc.reference.stabilisation_iterations != 0)
    entries[n++] = {k_unit_stabilise, substeps * g.desc.reference.stabilisation_iterations * active};
  if (g.bodies.count != 0) entries[n++] = {k_unit_bodies, substeps * 2 * g.bodies.particle_count};
  const uint64_t passes = substeps * level_iterations(k_ladder[level], g.desc.reference.solver_iterations);
  if (!solves_pairs(g)) {
    entries[n++] = {k_unit_solve, passes * active};
    return n;
  }
  entries[n++] = {k_unit_colours, builds * 3 * count};
  entries[n++] = {k_unit_predict, substeps * active};
  const uint64_t pairs = g.colours.ready ? pair_count(g.colours) : k_pairs_expected * active;
  entries[n++] = {k_unit_pairs, passes * pairs / k_pairs_an_item};
  entries[n++] = {k_unit_complete, substeps * active};
  return n;
}

}  // namespace

void substep_reset(Substep* s) {
  substep_forget(s);
  s->dither = 0;
}

void substep_forget(Substep* s) {
  s->phase = SubstepPhase::idle;
  s->due = s->cursor = s->pass = s->interval_left = 0;
  s->length = s->longest;
}

bool substep_idle(const Granular& g) { return g.substep.phase == SubstepPhase::idle && g.substep.due == 0; }

void substep_set_due(Granular* g, SubstepPhase phase, bool due) {
  if (due) g->substep.due |= bit(phase);
  else g->substep.due &= ~bit(phase);
}

void substep_abandon(Granular* g) {
  Substep& s = g->substep;
  while (s.phase == SubstepPhase::bodies) {
    if (bodies_run(g)) enter(g, after(g, s.phase));
  }
  if (s.phase == SubstepPhase::colours) pair_colours_forget(&g->colours);
  if (s.phase == SubstepPhase::sort || s.phase == SubstepPhase::lists) {
    g->neighbours.valid = false;  // the records may have moved already
    bodies_find_rows(g);
    // The lists count the awake as they are built.
    g->sleep.awake_count = 0;
    for (uint32_t i = 0; i < g->particles.count; ++i)
      g->sleep.awake_count += is_awake(g->particles.records[0][i]) ? 1u : 0u;
  }
  s.phase = SubstepPhase::idle;
  s.due &= bit(SubstepPhase::touch);
}

Stage granular_particle_stage(Granular* granular) { return {granular, next, run, forecast, k_granular_kinds, 1, 0.6f}; }

}  // namespace sandglass
