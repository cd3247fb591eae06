// The particles' machine: which phase of a sub-step follows which.
//
// A sub-step predicts, resolves the contacts pair by pair, and completes the motion with the colliders. In the source's
// scheme a pass does all of that at once. Passes over particles run over the record groups that hold an awake one
// (Sleep, in solver.h).
#include "kernels/whole.h"
#include "runtime/sand/granular.h"

namespace sandglass {

namespace {

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
  neighbours_begin_sort(&g->neighbours, *g);
  pair_colours_forget(&g->colours);
  return SubstepPhase::sort;
}

// What the particles do that have not departed.
void end_look(Granular* g) {
  Bounds all;
  float speed_max;
  if (departed_narrows(g->departed, *g, &all, &speed_max)) particles_narrow(&g->particles, all, speed_max);
  if (g->departed.returned) neighbours_invalidate(&g->neighbours);
}

SubstepPhase begin_passes(Granular* g) {
  contacts_clear_extent(&g->contacts);
  return first_pass(*g);
}

// Bodies whose particles have all kept still fall asleep.
void put_bodies_to_sleep(Granular* g) {
  for (uint32_t b = 0; b < g->bodies.count; ++b) {
    if (sleep_put_body(&g->sleep, *g, g->bodies.all[b])) bodies_stop(&g->bodies, b);
  }
}

// Sinks take the bodies of which they hold every particle.
void drain_bodies(Granular* g) {
  for (uint32_t index = g->bodies.count; index-- > 0;) {
    if (bodies_all_inside(g->bodies, index)) granular_take_out_body(g, index);
  }
}

void end_bodies(Granular* g) {
  contacts_include(&g->contacts, g->bodies.extent);
  complete(g);
}

// The phase that follows `done`, whose last unit has run.
SubstepPhase after(Granular* g, SubstepPhase done) {
  switch (done) {
    case SubstepPhase::idle:
      return SubstepPhase::idle;
    case SubstepPhase::departed:
      end_look(g);
      return SubstepPhase::idle;
    case SubstepPhase::slack:
      return neighbours_stale(*g, g->substep.level, g->substep.length) ? begin_sort(g) : begin_passes(g);
    case SubstepPhase::sort:
      particles_swap(&g->particles);
      return SubstepPhase::lists;
    case SubstepPhase::lists:
    case SubstepPhase::colours:
      return begin_passes(g);
    case SubstepPhase::stabilise:
      return contacts_next_pass(&g->contacts, g->desc.reference.stabilisation_iterations) ? done : solving(*g);
    case SubstepPhase::predict:
      return pair_count(g->colours) != 0 ? SubstepPhase::pairs : SubstepPhase::complete;
    case SubstepPhase::pairs:
      return contacts_next_pass(&g->contacts, g->contacts.iterations) ? done : SubstepPhase::complete;
    case SubstepPhase::solve:
      if (contacts_next_pass(&g->contacts, g->contacts.iterations)) return done;
      [[fallthrough]];
    case SubstepPhase::complete:
      if (bodies_begin(&g->bodies, *g)) return SubstepPhase::bodies;
      complete(g);
      return first_due(*g);
    case SubstepPhase::bodies:
      end_bodies(g);
      return first_due(*g);
    case SubstepPhase::touch:
      colliders_seen_by_particles(&g->colliders, *g);
      break;
    case SubstepPhase::sleep:
      put_bodies_to_sleep(g);
      sleep_collect_groups(&g->sleep, *g);
      break;
    case SubstepPhase::drain:
      drain_bodies(g);
      break;
    case SubstepPhase::wake:
      break;
    case SubstepPhase::wake_lists:
      pair_colours_forget(&g->colours);
      sleep_collect_groups(&g->sleep, *g);
      break;
  }
  substep_set_due(&g->substep, done, false);
  return first_due(*g);
}

void enter(Granular* g, SubstepPhase phase) {
  g->substep.phase = phase;
  g->substep.cursor = 0;
  if (phase == SubstepPhase::idle) granular_skip_time(g);
}

// ---- a sub-step's begin and end

void begin(Granular* g, uint32_t level) {
  Substep& s = g->substep;
  // As fast as what comes within the interval.
  if (s.interval_left == 0) particles_expect_speed(&g->particles, flow_speed(g->flow));
  SubstepPlan plan = time_plan_substep(*g, level);
  if (s.interval_left == 0) time_begin_interval(&g->time, plan.interval);
  departed_begin_interval(&g->departed);
  s.interval_left = plan.count;
  s.length = plan.substep;
  contacts_begin(&g->contacts, level_iterations(k_ladder[level], g->desc.reference.solver_iterations));
  // Seconds between the end of this sub-step and the end of the frame, where the colliders' poses are given.
  const double before_end = g->time.debt - static_cast<double>(s.length);
  colliders_begin_substep(&g->colliders, before_end > 0.0 ? static_cast<float>(before_end) : 0.0f,
                          g->desc.particle_radius);
  s.level = level;
  if (flow_is_due(*g)) {
    granular_pour(g);
    plan.stale = neighbours_stale(*g, level, s.length);
  }
  if (plan.stale && neighbours_doubt(*g)) {
    neighbours_begin_measuring(&g->neighbours);
    return enter(g, SubstepPhase::slack);
  }
  enter(g, plan.stale ? begin_sort(g) : begin_passes(g));
}

// The last pass has written records[1], and the bodies have corrected it: that is the state now.
void complete(Granular* g) {
  Substep& s = g->substep;
  particles_swap(&g->particles);
  particles_take_extent(&g->particles, g->contacts.extent, g->sleep.resting);
  neighbours_wear(&g->neighbours, *g);
  --s.interval_left;
  contacts_complete(&g->contacts, &g->counts);
  time_pay(&g->time, *g);
  flow_pass_time(&g->flow, static_cast<double>(s.length));
  substep_set_due(&s, SubstepPhase::wake, g->contacts.extent.touched != 0);
  if (!sleep_check_due(&g->sleep, *g)) return;
  substep_set_due(&s, SubstepPhase::sleep, g->desc.sleep_after > 0.0f);
  substep_set_due(&s, SubstepPhase::drain, g->flow.sink_count != 0 || g->departed.gone);
}

// ---- two phases that several parts have a share in

bool run_lists(Granular* g) {
  ListsSeen seen;
  if (g->substep.cursor == 0) sleep_begin_count(&g->sleep);
  const bool done = neighbours_run_lists(&g->neighbours, *g, &g->substep.cursor, &seen);
  sleep_count(&g->sleep, seen.awake, seen.resting);
  if (done) sleep_end_count(&g->sleep, *g);
  count_lists(&g->counts, seen.dropped, done);
  return done;
}

bool run_drain(Granular* g) {
  const uint32_t items = sleep_active_items(*g);
  const uint32_t end = items - g->substep.cursor < g->unit ? items : g->substep.cursor + g->unit;
  uint32_t removed = 0;
  if (g->substep.cursor == 0) bodies_begin_drain(g->bodies);
  // From the last group to the first, so the particle that fills a gap has been looked at.
  for (uint32_t at = g->substep.cursor; at < end; at += k_lane_group) {
    const uint32_t first = g->sleep.active_groups[g->sleep.active_count - 1 - at / k_lane_group] * k_lane_group;
    if (first < g->particles.count) removed += granular_drain_particles(g, first);
  }
  flow_count_removed(&g->flow, removed, 0, 0);
  if (removed != 0) granular_after_removal(g);
  g->substep.cursor = end;
  return end >= items;
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
  if (g.carry.due == Carry::Moment::jump) {  // before all else: what is under way goes on where it was carried
    carry_unit(g, unit);
    return true;
  }
  // A snapshot under way reads the state in several units and must find it unchanged.
  if (g.sweep.phase == SweepPhase::snapshot) return false;
  const SubstepPhase phase = upcoming(g, level);
  if (phase == SubstepPhase::idle) return false;
  const PhaseUnit& next = k_units[static_cast<uint32_t>(phase)];
  const uint32_t left = items_left(g, phase);
  unit->kind = next.kind;
  unit->name = next.name;
  const uint32_t limit = phase == SubstepPhase::pairs ? pair_unit(g.colours, g.unit) / k_pairs_an_item : g.unit;
  unit->items = left < limit || (phase == SubstepPhase::sort && g.substep.phase == phase) ? left : limit;
  return true;
}

// Runs the phase's next unit. True once its last one has run.
bool run_unit(Granular* g, SubstepPhase phase) {
  uint32_t* cursor = &g->substep.cursor;
  switch (phase) {
    case SubstepPhase::idle:
      return true;
    case SubstepPhase::departed:
      return departed_run(&g->departed, *g, cursor);
    case SubstepPhase::slack:
      return neighbours_run_measuring(&g->neighbours, *g, cursor);
    case SubstepPhase::sort:
      return neighbours_run_sort(&g->neighbours, *g);
    case SubstepPhase::lists:
      return run_lists(g);
    case SubstepPhase::colours:
      return pair_colours_run(&g->colours, *g, cursor, &g->counts);
    case SubstepPhase::stabilise:
    case SubstepPhase::solve:
    case SubstepPhase::predict:
    case SubstepPhase::complete:
      return contacts_run(&g->contacts, *g, cursor);
    case SubstepPhase::pairs:
      return contacts_run_pairs(&g->contacts, *g, cursor);
    case SubstepPhase::bodies:
      return bodies_run(&g->bodies, *g, &g->counts);
    case SubstepPhase::touch:
      return sleep_run_touch(&g->sleep, *g, cursor);
    case SubstepPhase::wake:
      return sleep_run_wake(&g->sleep, *g, cursor);
    case SubstepPhase::sleep:
      return sleep_run_sleep(&g->sleep, *g, cursor);
    case SubstepPhase::drain:
      return run_drain(g);
    case SubstepPhase::wake_lists:
      return sleep_run_wake_lists(&g->sleep, *g, cursor, &g->counts);
  }
  return true;
}

void run(void* state, uint32_t level) {
  Granular* g = static_cast<Granular*>(state);
  output_restart(&g->output);  // emitters and sinks change what was written
  if (g->carry.due == Carry::Moment::jump) return granular_carry(g);
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
  s->phase = SubstepPhase::idle;
  s->due = s->cursor = s->interval_left = 0;
  s->length = s->longest;
}

void substep_set_limits(Substep* s, float longest, float shortest) {
  s->longest = longest;
  s->shortest = shortest;
}

void substep_end_for_carry(Granular* g) {
  const Substep& s = g->substep;
  while (s.phase == SubstepPhase::slack || s.phase == SubstepPhase::sort || s.phase == SubstepPhase::bodies)
    if (run_unit(g, s.phase)) enter(g, after(g, s.phase));
}

void substep_end_interval(Substep* s) { s->interval_left = 0; }

bool substep_idle(const Granular& g) { return g.substep.phase == SubstepPhase::idle && g.substep.due == 0; }

void substep_set_due(Substep* s, SubstepPhase phase, bool due) {
  if (due) s->due |= bit(phase);
  else s->due &= ~bit(phase);
}

void substep_abandon(Granular* g) {
  Substep& s = g->substep;
  while (s.phase == SubstepPhase::bodies) {
    if (!bodies_run(&g->bodies, *g, &g->counts)) continue;
    end_bodies(g);
    enter(g, first_due(*g));
  }
  if (s.phase == SubstepPhase::colours) pair_colours_forget(&g->colours);
  if (s.phase == SubstepPhase::sort || s.phase == SubstepPhase::lists) {
    neighbours_invalidate(&g->neighbours);  // the records may have moved already
    bodies_find_rows(*g);
    sleep_recount(&g->sleep, *g);  // the lists count the awake as they are built
  }
  s.phase = SubstepPhase::idle;
  s.due &= bit(SubstepPhase::touch);
}

Stage granular_particle_stage(Granular* granular) {
  const Granular& g = *granular;
  const uint32_t jumps = g.carry.due == Carry::Moment::jump ? carry_units(g) : 0;
  // A carry may take all of a small budget: sand in a vessel gets about as long beside it, or else it would hang in there.
  const uint32_t beside = carry_is_expected(g) && g.carry.holds ? 1 + carry_units(g) : 0;
  return {granular, next, run, forecast, k_granular_kinds, 1 + jumps + beside, 0.6f};
}

}  // namespace sandglass
