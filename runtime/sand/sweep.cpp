// The grains' machine: which phase of a sweep follows which. Where a grain goes: kernels/grain_motion.inl.
#include "kernels/whole.h"
#include "runtime/sand/granular.h"

namespace sandglass {

namespace {

constexpr float k_sweeps_per_sort = 4.0f;     // grains move a fraction of a cell between sorts
constexpr float k_sort_next = 1e9f;           // sweeps since the last sort, where the next sweep must sort
constexpr double k_on_time = 1.0001;          // frames; more is late
constexpr float k_still_speed_units = 0.25f;  // of sqrt(g d): between sleepers grains creep on, slower than that

// ---- what follows what

bool source_rule(const Granular& g) { return g.desc.reference.blend == SANDGLASS_BLEND_SOURCE; }

// Every other sweep pushes the grains apart: they lie as evenly as with a push in each, for a sixth less. Where time is
// short, one in four does.
bool pushes_next(const Granular& g, uint32_t level) {
  return g.sweep.since_push + 1 >= (level < SANDGLASS_LEVEL_COARSER ? 2 : 4);
}
bool pushes(const Granular& g) { return g.sweep.since_push == 0; }

void begin_sort(Granular* g);
void begin_triage(Granular* g);
void complete(Granular* g);

// The phase that follows `done`, whose last unit has run.
SweepPhase after(Granular* g, SweepPhase done) {
  switch (done) {
    case SweepPhase::idle:
      return SweepPhase::idle;
    case SweepPhase::snapshot:
      if (g->grain_carry.pending) return SweepPhase::carry;
      [[fallthrough]];
    case SweepPhase::carry:
      if (g->sweep.sweeps_since_sort >= k_sweeps_per_sort) {
        begin_sort(g);
        return SweepPhase::sort;
      }
      [[fallthrough]];
    case SweepPhase::sort:
      begin_triage(g);
      return SweepPhase::triage;
    case SweepPhase::triage:  // with the dissertation's rule every step looks the particles up
      return source_rule(*g) || g->grain_sleep.group_count == 0 ? SweepPhase::refine : SweepPhase::scatter;
    case SweepPhase::scatter:
      return SweepPhase::join;
    case SweepPhase::join:
      return pushes(*g) ? SweepPhase::count : SweepPhase::refine;
    case SweepPhase::count:
      return SweepPhase::smooth;
    case SweepPhase::smooth:
      return SweepPhase::refine;
    case SweepPhase::refine:
      complete(g);
      return departed_takes_grains(&g->departed, *g) || g->flow.sink_count != 0 ? SweepPhase::drain : SweepPhase::idle;
    case SweepPhase::drain:
      return SweepPhase::idle;
  }
  return SweepPhase::idle;
}

void enter(Granular* g, SweepPhase phase) {
  g->sweep.phase = phase;
  g->sweep.cursor = 0;
}

// ---- the phases

void begin(Granular* g, uint32_t level) {
  g->sweep.since_push = pushes_next(*g, level) ? 0 : g->sweep.since_push + 1;
  const SimulatedTime& t = g->time;
  const double count = t.grain_lag / static_cast<double>(g->desc.refine_step);
  const uint32_t whole = to_whole<uint32_t>(count);
  uint32_t steps = count - whole > 1e-4 ? whole + 1 : (whole == 0 ? 1 : whole);
  if (steps > k_sweep_steps_max) steps = k_sweep_steps_max;
  g->sweep.time = t.grain_lag;
  g->sweep.steps = steps;
  g->sweep.step = static_cast<float>(t.grain_lag / steps);
  grains_begin_snapshot(&g->grains, *g);
  motion_begin(&g->motion, *g);
  const double late = t.grain_lag > t.asked ? t.grain_lag : t.asked;
  g->sweep.late = g->sweep.late || late > k_on_time * static_cast<double>(t.frame_step);
  colliders_begin_sweep(&g->colliders, colliders_behind(*g), g->desc.grain_radius,
                        g->sweep.late ? g->grain_carry.carried : nullptr, steps);
  grain_carry_begin_sweep(&g->grain_carry, *g);
}

bool run_snapshot(Granular* g) {
  if (g->grains.snapshot.sort.phase == k_sort_done) return motion_measure(&g->motion, *g, &g->sweep.cursor);
  if (!grains_run_snapshot(&g->grains, *g)) return false;
  g->sweep.particles = g->particles.count;
  return source_rule(*g);
}

bool run_carry(Granular* g) {
  const uint32_t all = g->grains.count, begin = g->sweep.cursor, end = all - begin < g->unit ? all : begin + g->unit;
  granular_find_grain_motions(g, false);
  for (uint32_t at = begin; at < end;) at = grain_carry_find(&g->grain_carry, *g, at, end);
  if (grain_carry_take(&g->grain_carry, *g, begin, end))
    grain_sleep_carried(&g->grain_sleep, begin / k_lane_group, (end + k_lane_group - 1) / k_lane_group);
  g->sweep.cursor = end;
  if (end < all) return false;
  grain_carry_taken(&g->grain_carry);
  return true;
}

void begin_sort(Granular* g) {
  g->sweep.sweeps_since_sort = 0.0f;
  grains_begin_sort(&g->grains, *g);
}

void begin_triage(Granular* g) {
  motion_begin_wanting(&g->motion, *g);
  grain_sleep_begin_triage(&g->grain_sleep);
  colliders_find_moved_for_grains(&g->colliders, *g);
}

float minimum_of(float a, float b) { return a < b ? a : b; }

struct RefineTask {
  const Kernels* kernels;
  RefineArgs args;
  RefineExtent extents[k_pieces];
  void run(uint32_t piece, uint32_t begin, uint32_t end) { kernels->refine_grains(&args, begin, end, &extents[piece]); }
};

uint32_t refine_items(const Granular& g) { return g.grain_sleep.group_count * k_lane_group; }

bool run_refine(const Granular& g, uint32_t* cursor, FrameCounts* counts, Output* output) {
  const Snapshot& snapshot = g.grains.snapshot;
  RefineTask task = {};
  task.kernels = g.kernels;
  RefineArgs& a = task.args;
  a.grid = snapshot.sort.grid;
  a.snapshot = snapshot.particles;
  for (int k = 0; k < 3; ++k) {
    a.positions[k] = snapshot.positions[k];
    a.gravity[k] = g.gravity[k];
  }
  a.motion = source_rule(g) ? nullptr : &g.motion.grid;
  a.grains = g.grains.records;
  a.grain_count = g.grains.count;
  a.groups = g.grain_sleep.groups;
  a.still = g.grain_sleep.still;
  a.stamps = g.output.stamps;
  a.stamp = g.output.frame;
  a.still_distance = k_still_speed_units * granular_speed_scale(g) * static_cast<float>(g.sweep.time);
  a.speed_scale = granular_speed_scale(g);
  a.still_sweeps = k_patience_sweeps;
  a.support = k_support_radii * g.desc.particle_radius;
  // Down the density's gradient by 0.3 h^2 |grad| / density for h = a cell of half a particle radius, but slower than
  // what counts as still.
  a.push = pushes(g) ? 0.15f * g.desc.particle_radius : 0.0f;
  a.push_max = minimum_of(0.1f * g.desc.particle_radius, 0.5f * a.still_distance);
  a.push_reach = 1.2f * g.desc.particle_radius;
  a.step = g.sweep.step;
  a.steps = g.sweep.steps;
  a.fall = g.gravity_length * static_cast<float>(g.sweep.time);
  a.source_rule = source_rule(g) ? 1 : 0;
  a.own_particles = g.desc.reference.blend == SANDGLASS_BLEND_CONTINUOUS ? 1 : 0;
  a.weight_at_radius = 512.0f / 729.0f;  // W(r) = (1 - 1/9)^3
  a.colliders = g.colliders.sweep_frames;
  a.step_colliders = g.colliders.sweep_step_frame_count != 0 ? g.colliders.sweep_step_frames : nullptr;
  a.collider_count = g.colliders.sweep_count;
  a.grain_radius = g.desc.grain_radius;
  a.friction = g.desc.kinetic_friction;
  const uint32_t items = refine_items(g);
  const uint32_t end = items - *cursor < g.unit ? items : *cursor + g.unit;
  granular_split(g, *cursor, end, &task);
  for (const RefineExtent& e : task.extents) {
    counts->quarantined += e.quarantined;
    output_moved(output, e.changed);
  }
  *cursor = end;
  return end >= items;
}

bool run_drain(Granular* g) {
  const uint32_t items = refine_items(*g);
  const uint32_t end = items - g->sweep.cursor < g->unit ? items : g->sweep.cursor + g->unit;
  uint32_t removed = 0;
  for (uint32_t at = g->sweep.cursor; at < end; at += k_lane_group) {
    const uint32_t first = g->grain_sleep.groups[g->grain_sleep.group_count - 1 - at / k_lane_group] * k_lane_group;
    if (first < g->grains.count) removed += granular_drain_grains(g, first);
  }
  flow_count_removed(&g->flow, 0, removed, 0);
  if (removed != 0) {
    grain_sleep_regrouped(&g->grain_sleep);
    grain_carry_forget(&g->grain_carry, *g, 0);
    output_changed(&g->output);
  }
  g->sweep.cursor = end;
  return end >= items;
}

// All groups that were listed have followed.
void complete(Granular* g) {
  const uint32_t items = refine_items(*g);
  motion_complete(&g->motion);
  grain_carry_complete(&g->grain_carry);
  time_grains_followed(&g->time, g->sweep.time);
  g->sweep.sweeps_since_sort += static_cast<float>(items) / static_cast<float>(g->grains.count);
  grain_sleep_followed(&g->grain_sleep, items == 0 && g->sleep.awake_count == 0);
}

bool run_triage(Granular* g) {
  const uint32_t listed = g->grain_sleep.group_count;
  const bool done = grain_sleep_run_triage(&g->grain_sleep, *g, &g->sweep.cursor);
  for (uint32_t i = listed; i < g->grain_sleep.group_count; ++i) motion_want(&g->motion, *g, g->grain_sleep.groups[i]);
  return done;
}

// ---- the stage

bool next(const void* state, uint32_t, WorkUnit* unit) {
  const Granular& g = *static_cast<const Granular*>(state);
  if (time_paused(g)) return false;
  const uint32_t left = refine_items(g) - g.sweep.cursor;
  unit->items = left < g.unit ? left : g.unit;
  switch (g.sweep.phase) {
    case SweepPhase::idle:
      if (!time_awaits_grains(g)) return false;
      unit->kind = k_unit_snapshot;
      unit->name = "refine.snapshot";
      unit->items = g.particles.count < g.unit ? g.particles.count : g.unit;
      return true;
    case SweepPhase::snapshot:
      unit->kind = k_unit_snapshot;
      unit->name = "refine.snapshot";
      unit->items = cell_sort_items(g.grains.snapshot.sort, g.particles.count, g.unit);
      if (g.grains.snapshot.sort.phase == k_sort_done)
        unit->items = g.sweep.particles - g.sweep.cursor < g.unit ? g.sweep.particles - g.sweep.cursor : g.unit;
      return true;
    case SweepPhase::carry:
      unit->kind = k_unit_grain_carry;
      unit->name = "refine.carry";
      unit->items = g.grains.count - g.sweep.cursor < g.unit ? g.grains.count - g.sweep.cursor : g.unit;
      return true;
    case SweepPhase::sort:
      unit->kind = k_unit_grain_sort;
      unit->name = "refine.sort";
      unit->items = cell_sort_items(g.grains.sort, g.grains.count, g.unit);
      return true;
    case SweepPhase::scatter:
    case SweepPhase::join:
    case SweepPhase::count:
    case SweepPhase::smooth:
      unit->kind = k_unit_motion;
      unit->name = "refine.motion";
      unit->items = motion_items(g);
      return true;
    case SweepPhase::triage:
      unit->kind = k_unit_triage;
      unit->name = "refine.triage";
      unit->items = grain_sleep_items(g);
      return true;
    case SweepPhase::refine:
      unit->kind = k_unit_refine;
      unit->name = "refine.grains";
      if (left == 0) unit->items = 1;  // all sleep: the sweep ends
      return true;
    case SweepPhase::drain:
      unit->kind = k_unit_drain;
      unit->name = "refine.drain";
      return true;
  }
  return false;
}

// Runs the phase's next unit. True once its last one has run.
bool run_unit(Granular* g, SweepPhase phase) {
  switch (phase) {
    case SweepPhase::idle:
      return true;
    case SweepPhase::snapshot:
      return run_snapshot(g);
    case SweepPhase::carry:
      return run_carry(g);
    case SweepPhase::sort:
      grain_sleep_regrouped(&g->grain_sleep);
      grain_carry_regrouped(&g->grain_carry, *g);
      output_regrouped(&g->output);
      return grains_run_sort(&g->grains, *g);
    case SweepPhase::scatter:
      return motion_run_scatter(&g->motion, *g, &g->sweep.cursor);
    case SweepPhase::join:
      return motion_run_join(&g->motion, *g, &g->sweep.cursor);
    case SweepPhase::count:
      return motion_run_count(&g->motion, *g, &g->sweep.cursor);
    case SweepPhase::smooth:
      return motion_run_smooth(&g->motion, *g, &g->sweep.cursor);
    case SweepPhase::triage:
      return run_triage(g);
    case SweepPhase::refine: {
      const uint32_t begin = g->sweep.cursor;
      const bool done = run_refine(*g, &g->sweep.cursor, &g->counts, &g->output);
      grain_carry_refined(&g->grain_carry, *g, begin, g->sweep.cursor);
      return done;
    }
    case SweepPhase::drain:
      return run_drain(g);
  }
  return true;
}

void run(void* state, uint32_t level) {
  Granular* g = static_cast<Granular*>(state);
  output_restart(&g->output);
  if (g->sweep.phase == SweepPhase::idle) {
    begin(g, level);
    enter(g, SweepPhase::snapshot);
  }
  const SweepPhase phase = g->sweep.phase;
  if (run_unit(g, phase)) enter(g, after(g, phase));
}

uint32_t forecast(const void* state, uint32_t level, Forecast* entries) {
  const Granular& g = *static_cast<const Granular*>(state);
  const SimulatedTime& t = g.time;
  if (time_paused(g) || g.grains.count == 0) return 0;
  uint64_t sweeps = 0;
  if (t.debt >= k_time_resolution || t.grain_lag >= k_time_resolution) {
    sweeps =
        source_rule(g) ? to_whole<uint64_t>((t.debt + t.grain_lag) / static_cast<double>(g.desc.refine_step)) + 1 : 1;
  }
  if (sweeps == 0) return 0;
  entries[0] = {k_unit_snapshot, sweeps * 2 * g.particles.count};
  const uint64_t refined = g.grain_sleep.still_groups == 0 ? g.grains.count : refine_items(g);
  entries[1] = {k_unit_grain_sort, sweeps * 3 * refined / static_cast<uint64_t>(k_sweeps_per_sort)};
  entries[2] = {k_unit_refine, sweeps * refined};
  if (source_rule(g)) return 3;
  const bool even = g.sweep.phase == SweepPhase::idle ? pushes_next(g, level) : pushes(g);
  entries[3] = {k_unit_motion, sweeps * motion_items_of_a_sweep(g, even)};
  return 4;
}

}  // namespace

void sweep_reset(Sweep* s) {
  sweep_forget(s);
  s->phase = SweepPhase::idle;
  s->step = 0.0f;
  s->time = 0.0;
}

void sweep_forget(Sweep* s) {
  s->cursor = 0;
  s->late = false;
  s->sweeps_since_sort = k_sort_next;
  s->since_push = 0;  // so the sweeps that push are not those that sort
}

void sweep_finish(Granular* g) {
  while (g->sweep.phase != SweepPhase::idle ||
         (g->grains.count != 0 && g->particles.count != 0 && g->time.grain_lag >= k_time_resolution))
    run(g, 0);
  if (g->grain_carry.pending) {
    g->sweep.cursor = 0;
    while (!run_carry(g)) {
    }
    output_changed(&g->output);
  }
  grain_carry_settle(&g->grain_carry, *g);
}

void sweep_end_snapshot(Granular* g) {
  while (g->sweep.phase == SweepPhase::snapshot) run(g, 0);
}

bool sweep_has_snapshot(const Granular& g) {
  return g.sweep.phase > SweepPhase::snapshot && g.sweep.phase < SweepPhase::drain;
}

bool sweep_takes_grains(const Granular& g) {
  return g.sweep.phase == SweepPhase::idle || g.sweep.phase == SweepPhase::refine || g.sweep.phase == SweepPhase::drain;
}

void sweep_end(Granular* g) {
  if (g->sweep.phase == SweepPhase::snapshot) g->sweep.phase = SweepPhase::idle;
  if (g->sweep.phase == SweepPhase::idle) return;
  while (g->sweep.phase != SweepPhase::idle) run(g, 0);
  grain_carry_settle(&g->grain_carry, *g);
  output_changed(&g->output);
}

void sweep_particles_changed(Sweep* s) {
  if (s->phase == SweepPhase::snapshot) s->phase = SweepPhase::idle;
}

void sweep_grains_added(Granular* g, uint32_t count) {
  g->sweep.sweeps_since_sort = k_sort_next;
  grain_sleep_added(&g->grain_sleep, *g, count);
  grain_carry_forget(&g->grain_carry, *g, g->grains.count - count);
  output_changed(&g->output);
}

void sweep_grains_removed(Granular* g) {
  grain_sleep_removed(&g->grain_sleep);
  grain_carry_settle(&g->grain_carry, *g);
  output_changed(&g->output);
}

// A unit of grains becomes mandatory when the particles wait for them: whatever the budget, one of the two goes on.
Stage granular_grain_stage(Granular* granular) {
  const bool awaited = time_awaits_grains(*granular) || granular->sweep.phase == SweepPhase::snapshot;
  return {granular, next, run, forecast, k_granular_kinds, awaited ? 1u : 0u, 1.0f};
}

}  // namespace sandglass
