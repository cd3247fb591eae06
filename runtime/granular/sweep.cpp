// The grains' machine: which phase of a sweep follows which.
#include "kernels/whole.h"
#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

constexpr float k_support_radii = 3.0f;       // h = 3r
constexpr float k_grain_cell_radii = 1.3f;    // coarser: more vectors lie in several blocks of the motion grid
constexpr float k_sweeps_per_sort = 4.0f;     // grains move a fraction of a cell between sorts
constexpr float k_sort_next = 1e9f;           // sweeps since the last sort, where the next sweep must sort
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
void complete(Granular* g);

// What follows when the grains are in order: with the dissertation's rule every step looks the particles up.
SweepPhase read_motion(Granular* g) {
  if (!source_rule(*g)) return SweepPhase::scatter;
  grain_sleep_begin_triage(g);
  return SweepPhase::triage;
}

// The phase that follows `done`, whose last unit has run.
SweepPhase after(Granular* g, SweepPhase done) {
  switch (done) {
    case SweepPhase::idle:
      return SweepPhase::idle;
    case SweepPhase::snapshot:
      if (g->sweep.sweeps_since_sort < k_sweeps_per_sort) return read_motion(g);
      begin_sort(g);
      return SweepPhase::sort;
    case SweepPhase::sort:
      return read_motion(g);
    case SweepPhase::scatter:
      return SweepPhase::join;
    case SweepPhase::join:
      if (pushes(*g)) return SweepPhase::count;
      grain_sleep_begin_triage(g);
      return SweepPhase::triage;
    case SweepPhase::count:
      return SweepPhase::smooth;
    case SweepPhase::smooth:
      grain_sleep_begin_triage(g);
      return SweepPhase::triage;
    case SweepPhase::triage:
      return SweepPhase::refine;
    case SweepPhase::refine:
      complete(g);
      return departed_takes_grains(g) || g->flow.sink_count != 0 ? SweepPhase::drain : SweepPhase::idle;
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
  SimulatedTime& t = g->time;
  const double count = t.grain_lag / static_cast<double>(g->desc.refine_step);
  const uint32_t whole = to_whole<uint32_t>(count);
  uint32_t steps = count - whole > 1e-4 ? whole + 1 : (whole == 0 ? 1 : whole);
  if (steps > k_sweep_steps_max) steps = k_sweep_steps_max;
  g->sweep.time = t.grain_lag;
  g->sweep.steps = steps;
  g->sweep.step = static_cast<float>(t.grain_lag / steps);
  cell_sort_begin(&g->grains.snapshot.sort, k_support_radii * g->desc.particle_radius, g->particles.low,
                  g->particles.high, 3);
  motion_begin(&g->motion, t.simulated);
  colliders_pose(g->colliders.given, g->colliders.count, static_cast<float>(t.debt), g->colliders.sweep_frames);
  g->colliders.sweep_count = g->colliders.count;
}

// The velocity of a particle in the snapshot becomes the mean one since the last sweep. The table of blocks is emptied
// along with that.
bool measure(Granular* g) {
  const uint32_t all = g->sweep.particles, begin = g->sweep.cursor;
  const uint32_t end = all - begin < g->unit ? all : begin + g->unit;
  const float inverse = static_cast<float>(1.0 / g->sweep.time);
  for (uint32_t i = begin; i < end; ++i) {
    Particle* p = &g->grains.snapshot.particles[i];
    const Place& start = g->motion.starts[number_of(*p)];
    Place* here = &g->motion.ends[number_of(*p)];
    float mean[3];
    for (int k = 0; k < 3; ++k) {
      here->position[k] = p->position[k];
      mean[k] = (p->position[k] - start.position[k]) * inverse;
    }
    set_free_fall(p, motion_free_fall(p->velocity, mean, g->gravity, static_cast<float>(g->sweep.time)));
    for (int k = 0; k < 3; ++k) p->velocity[k] = mean[k];
  }
  motion_clear(&g->motion.grid, begin, end, all);
  g->sweep.cursor = end;
  return end >= all;
}

bool run_snapshot(Granular* g) {
  Snapshot& s = g->grains.snapshot;
  if (s.sort.phase == k_sort_done) return measure(g);
  const SortTarget target = {as_records(s.particles), {s.positions[0], s.positions[1], s.positions[2]}, true};
  cell_sort_run(&s.sort, *g->kernels, as_records(g->particles.records[0]), g->particles.count, g->unit, target);
  if (s.sort.phase != k_sort_done) return false;
  g->sweep.particles = g->particles.count;
  return source_rule(*g);
}

void begin_sort(Granular* g) {
  g->sweep.sweeps_since_sort = 0.0f;
  cell_sort_begin(&g->grains.sort, k_grain_cell_radii * g->desc.particle_radius, g->particles.low, g->particles.high,
                  2);
}

bool run_sort(Granular* g) {
  Grains& grains = g->grains;
  const SortTarget in_place = {as_records(grains.records), {nullptr, nullptr, nullptr}, false};
  g->grain_sleep.groups_changed = true;
  cell_sort_run(&grains.sort, *g->kernels, in_place.records, grains.count, g->unit, in_place);
  return grains.sort.phase == k_sort_done;
}

float minimum_of(float a, float b) { return a < b ? a : b; }

struct RefineTask {
  const Kernels* kernels;
  RefineArgs args;
  RefineExtent extents[k_pieces];
  void run(uint32_t piece, uint32_t begin, uint32_t end) { kernels->refine_grains(&args, begin, end, &extents[piece]); }
};

uint32_t refine_items(const Granular& g) { return g.grain_sleep.group_count * k_lane_group; }

bool run_refine(Granular* g) {
  const Snapshot& snapshot = g->grains.snapshot;
  RefineTask task = {};
  task.kernels = g->kernels;
  RefineArgs& a = task.args;
  a.grid = snapshot.sort.grid;
  a.snapshot = snapshot.particles;
  for (int k = 0; k < 3; ++k) a.positions[k] = snapshot.positions[k], a.gravity[k] = g->gravity[k];
  a.motion = source_rule(*g) ? nullptr : &g->motion.grid;
  a.grains = g->grains.records;
  a.grain_count = g->grains.count;
  a.groups = g->grain_sleep.groups;
  a.still = g->grain_sleep.still;
  a.still_distance = k_still_speed_units * granular_speed_scale(*g) * static_cast<float>(g->sweep.time);
  a.speed_scale = granular_speed_scale(*g);
  a.still_sweeps = k_patience_sweeps;
  a.support = k_support_radii * g->desc.particle_radius;
  // Down the density's gradient by 0.3 h^2 |grad| / density for h = a cell of half a particle radius, but slower than
  // what counts as still.
  a.push = pushes(*g) ? 0.15f * g->desc.particle_radius : 0.0f;
  a.push_max = minimum_of(0.1f * g->desc.particle_radius, 0.5f * a.still_distance);
  a.push_reach = 1.2f * g->desc.particle_radius;
  a.step = g->sweep.step;
  a.steps = g->sweep.steps;
  a.fall = g->gravity_length * static_cast<float>(g->sweep.time);
  a.source_rule = source_rule(*g) ? 1 : 0;
  a.own_particles = g->desc.reference.blend == SANDGLASS_BLEND_CONTINUOUS ? 1 : 0;
  a.weight_at_radius = 512.0f / 729.0f;  // W(r) = (1 - 1/9)^3
  a.colliders = g->colliders.sweep_frames;
  a.collider_count = g->colliders.sweep_count;
  a.grain_radius = g->desc.grain_radius;
  a.friction = g->desc.kinetic_friction;
  uint32_t& cursor = g->sweep.cursor;
  const uint32_t items = refine_items(*g);
  const uint32_t end = items - cursor < g->unit ? items : cursor + g->unit;
  granular_split(*g, cursor, end, &task);
  for (const RefineExtent& e : task.extents) g->counts.quarantined += e.quarantined;
  cursor = end;
  return end >= items;
}

// All groups that were listed have followed.
void complete(Granular* g) {
  const uint32_t items = refine_items(*g);
  motion_complete(g);
  g->time.grain_lag -= g->sweep.time;
  if (g->time.grain_lag < k_time_resolution) g->time.grain_lag = 0.0;
  g->sweep.sweeps_since_sort += static_cast<float>(items) / static_cast<float>(g->grains.count);
  g->grain_sleep.all_asleep = items == 0 && g->sleep.awake_count == 0;
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
      unit->kind = k_unit_snapshot, unit->name = "refine.snapshot";
      unit->items = g.particles.count < g.unit ? g.particles.count : g.unit;
      return true;
    case SweepPhase::snapshot:
      unit->kind = k_unit_snapshot, unit->name = "refine.snapshot";
      unit->items = cell_sort_items(g.grains.snapshot.sort, g.particles.count, g.unit);
      if (g.grains.snapshot.sort.phase == k_sort_done)
        unit->items = g.sweep.particles - g.sweep.cursor < g.unit ? g.sweep.particles - g.sweep.cursor : g.unit;
      return true;
    case SweepPhase::sort:
      unit->kind = k_unit_grain_sort, unit->name = "refine.sort";
      unit->items = cell_sort_items(g.grains.sort, g.grains.count, g.unit);
      return true;
    case SweepPhase::scatter:
    case SweepPhase::join:
    case SweepPhase::count:
    case SweepPhase::smooth:
      unit->kind = k_unit_motion, unit->name = "refine.motion";
      unit->items = motion_items(g);
      return true;
    case SweepPhase::triage:
      unit->kind = k_unit_triage, unit->name = "refine.triage";
      unit->items = grain_sleep_items(g);
      return true;
    case SweepPhase::refine:
      unit->kind = k_unit_refine, unit->name = "refine.grains";
      if (left == 0) unit->items = 1;  // all sleep: the sweep ends
      return true;
    case SweepPhase::drain:
      unit->kind = k_unit_drain, unit->name = "refine.drain";
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
    case SweepPhase::sort:
      return run_sort(g);
    case SweepPhase::scatter:
      return motion_run_scatter(g);
    case SweepPhase::join:
      return motion_run_join(g);
    case SweepPhase::count:
      return motion_run_count(g);
    case SweepPhase::smooth:
      return motion_run_smooth(g);
    case SweepPhase::triage:
      return grain_sleep_run_triage(g);
    case SweepPhase::refine:
      return run_refine(g);
    case SweepPhase::drain:
      return flow_run_grain_drain(g);
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
  s->sweeps_since_sort = k_sort_next;
  s->since_push = 0;  // so the sweeps that push are not those that sort
}

void sweep_finish(Granular* g) {
  while (g->sweep.phase != SweepPhase::idle ||
         (g->grains.count != 0 && g->particles.count != 0 && g->time.grain_lag >= k_time_resolution))
    run(g, 0);
}

bool sweep_takes_grains(const Granular& g) {
  return g.sweep.phase == SweepPhase::idle || g.sweep.phase == SweepPhase::refine || g.sweep.phase == SweepPhase::drain;
}

void sweep_particles_changed(Granular* g) {
  if (g->sweep.phase == SweepPhase::snapshot) g->sweep.phase = SweepPhase::idle;
}

void sweep_grains_added(Granular* g, uint32_t count) {
  if (!sweep_takes_grains(*g)) g->sweep.phase = SweepPhase::idle;
  for (uint32_t group = (g->grains.count - count) / k_lane_group; group * k_lane_group < g->grains.count; ++group)
    g->grain_sleep.still[group] = 0;
  g->sweep.sweeps_since_sort = k_sort_next;
  g->grain_sleep.all_asleep = false;
}

void sweep_grains_removed(Granular* g) {
  g->grain_sleep.groups_changed = true;
  g->sweep.phase = SweepPhase::idle;
  g->grain_sleep.all_asleep = false;
}

// A unit of grains becomes mandatory when the particles wait for them: whatever the budget, one of the two goes on.
Stage granular_grain_stage(Granular* granular) {
  const bool awaited = time_awaits_grains(*granular) || granular->sweep.phase == SweepPhase::snapshot;
  return {granular, next, run, forecast, k_granular_kinds, awaited ? 1u : 0u, 1.0f};
}

}  // namespace sandglass
