// The grains' stages. A sweep moves every grain once: a snapshot of the particles is sorted by cells of the support
// radius, the grains are re-sorted every few sweeps, then refined unit by unit. A sweep may take several frames; once
// taken, the snapshot is its own copy and the particles go on meanwhile. Output then writes all grains to the app's
// buffer, whatever the budget.
#include "runtime/granular/granular.h"
#include "runtime/granular/ladder.h"

namespace sandglass {

namespace {

constexpr double k_time_resolution = 1e-9;
constexpr float k_support_radii = 3.0f;       // h = 3r
constexpr float k_grain_cell_radii = 2.0f;    // a vector of grains is then about one cell
constexpr float k_sweeps_per_sort = 4.0f;     // grains move a fraction of a cell between sorts
constexpr float k_still_speed_units = 0.25f;  // of sqrt(g d): between sleepers grains creep on, slower than that
constexpr uint32_t k_sweep_steps_max = 4;     // and frames that a sweep may cover

bool sweep_wanted(const Granular& g, uint32_t level) {
  if (g.grain_count == 0 || g.particle_count == 0 || g.unswept < k_time_resolution) return false;
  return !k_ladder[level].refine_often || g.interval_left == 0;
}

bool next(const void* state, uint32_t level, WorkUnit* unit) {
  const Granular& g = *static_cast<const Granular*>(state);
  const uint32_t left = g.grain_group_count * k_lane_group - g.grain_cursor;
  unit->items = left < g.unit ? left : g.unit;
  switch (g.grain_phase) {
    case GrainPhase::idle:
      if (!sweep_wanted(g, level)) return false;
      unit->kind = k_unit_snapshot;
      unit->name = "refine.snapshot";
      unit->items = g.particle_count < g.unit ? g.particle_count : g.unit;
      return true;
    case GrainPhase::snapshot:
      unit->kind = k_unit_snapshot;
      unit->name = "refine.snapshot";
      unit->items = cell_sort_items(g.snapshot_sort, g.particle_count, g.unit);
      return true;
    case GrainPhase::sort:
      unit->kind = k_unit_grain_sort;
      unit->name = "refine.sort";
      unit->items = cell_sort_items(g.grain_sort, g.grain_count, g.unit);
      return true;
    case GrainPhase::drain:
      unit->kind = k_unit_drain;
      unit->name = "refine.drain";
      return true;
    case GrainPhase::mark:
    case GrainPhase::triage:
      unit->kind = k_unit_triage;
      unit->name = "refine.triage";
      unit->items = granular_mark_items(g);
      return true;
    default:
      unit->kind = k_unit_refine;
      unit->name = "refine.grains";
      if (left == 0) unit->items = 1;  // all sleep: the sweep ends
      return true;
  }
}

void begin_sweep(Granular* g, uint32_t level) {
  // Full quality steps by refine_step; below it one step covers a frame.
  const float longest =
      k_ladder[level].refine_often || g->frame_step < g->desc.refine_step ? g->desc.refine_step : g->frame_step;
  const double most = static_cast<double>(longest);
  const double count = g->unswept / most;
  const uint32_t whole = static_cast<uint32_t>(count);
  uint32_t steps = count - whole > 1e-4 ? whole + 1 : (whole == 0 ? 1 : whole);
  if (steps > k_sweep_steps_max) steps = k_sweep_steps_max;
  g->sweep_time = g->unswept;
  g->sweep_steps = steps;
  g->sweep_step = static_cast<float>(g->unswept / steps);
  cell_sort_begin(&g->snapshot_sort, k_support_radii * g->desc.particle_radius, g->low, g->high, 3);
  const double after = g->owed;
  colliders_pose(g->colliders, g->collider_count, static_cast<float>(after), g->sweep_colliders);
  g->grain_phase = GrainPhase::snapshot;
}

void begin_grains(Granular* g) {
  g->grain_cursor = 0;
  if (g->sweeps_since_sort < k_sweeps_per_sort) return granular_begin_mark(g);
  g->sweeps_since_sort = 0.0f;
  cell_sort_begin(&g->grain_sort, k_grain_cell_radii * g->desc.particle_radius, g->low, g->high, 2);
  g->grain_phase = GrainPhase::sort;
}

struct RefineTask {
  const Kernels* kernels;
  RefineArgs args;
  RefineExtent extents[8];
  void run(uint32_t piece, uint32_t begin, uint32_t end) { kernels->refine_grains(&args, begin, end, &extents[piece]); }
};

void run_refine(Granular* g) {
  RefineTask task = {};
  task.kernels = g->kernels;
  RefineArgs& a = task.args;
  a.grid = g->snapshot_sort.grid;
  a.snapshot = g->snapshot;
  for (int k = 0; k < 3; ++k) a.positions[k] = g->snapshot_positions[k], a.gravity[k] = g->gravity[k];
  a.grains = g->grains[0];
  a.grain_count = g->grain_count;
  a.groups = g->grain_groups;
  a.still = g->grain_still;
  a.still_distance = k_still_speed_units * granular_speed_scale(*g) * static_cast<float>(g->sweep_time);
  a.still_sweeps = k_patience_sweeps;
  a.support = k_support_radii * g->desc.particle_radius;
  a.step = g->sweep_step;
  a.steps = g->sweep_steps;
  a.source_rule = g->desc.reference.blend == SANDGLASS_BLEND_SOURCE ? 1 : 0;
  a.weight_at_radius = 512.0f / 729.0f;  // W(r) = (1 - 1/9)^3
  a.colliders = g->sweep_colliders;
  a.collider_count = g->collider_count;
  a.grain_radius = g->desc.grain_radius;
  a.friction = g->desc.kinetic_friction;
  const uint32_t items = g->grain_group_count * k_lane_group;
  const uint32_t end = items - g->grain_cursor < g->unit ? items : g->grain_cursor + g->unit;
  granular_split(*g, g->grain_cursor, end, &task);
  for (const RefineExtent& e : task.extents) g->quarantined += e.quarantined;
  g->grain_cursor = end;
  if (end < items) return;
  g->grain_cursor = 0;
  g->grain_phase = g->sink_count != 0 ? GrainPhase::drain : GrainPhase::idle;
  g->unswept -= g->sweep_time;
  if (g->unswept < k_time_resolution) g->unswept = 0.0;
  g->sweeps_since_sort += static_cast<float>(items) / static_cast<float>(g->grain_count);
  g->grains_asleep = items == 0 && g->awake_count == 0;
}

void run(void* state, uint32_t level) {
  Granular* g = static_cast<Granular*>(state);
  g->output_cursor = 0;  // what was written is out of date
  if (g->grain_phase == GrainPhase::idle) begin_sweep(g, level);
  switch (g->grain_phase) {
    case GrainPhase::snapshot: {
      const SortTarget target = {as_records(g->snapshot),
                                 {g->snapshot_positions[0], g->snapshot_positions[1], g->snapshot_positions[2]},
                                 true};
      cell_sort_run(&g->snapshot_sort, *g->kernels, as_records(g->records[0]), g->particle_count, g->unit, target);
      if (g->snapshot_sort.phase == k_sort_done) begin_grains(g);
      break;
    }
    case GrainPhase::sort: {
      const SortTarget target = {as_records(g->grains[1]), {nullptr, nullptr, nullptr}, false};
      cell_sort_run(&g->grain_sort, *g->kernels, as_records(g->grains[0]), g->grain_count, g->unit, target);
      if (g->grain_sort.phase == k_sort_done) {
        Grain* sorted = g->grains[1];
        g->grains[1] = g->grains[0];
        g->grains[0] = sorted;
        g->groups_changed = true;
        granular_begin_mark(g);
      }
      break;
    }
    case GrainPhase::mark:
      granular_run_mark(g);
      break;
    case GrainPhase::triage:
      granular_run_triage(g);
      break;
    case GrainPhase::drain:
      granular_run_grain_drain(g);
      break;
    default:
      run_refine(g);
      break;
  }
}

uint32_t forecast(const void* state, uint32_t level, Forecast* entries) {
  const Granular& g = *static_cast<const Granular*>(state);
  if (g.grain_count == 0) return 0;
  uint64_t sweeps = 0;
  if (g.owed >= k_time_resolution || g.unswept >= k_time_resolution) {
    sweeps = k_ladder[level].refine_often
                 ? static_cast<uint64_t>((g.owed + g.unswept) / static_cast<double>(g.desc.refine_step)) + 1
                 : 1;
  }
  if (sweeps == 0) return 0;
  entries[0] = {k_unit_snapshot, sweeps * 2 * g.particle_count};
  const uint64_t refined = g.still_groups == 0 ? g.grain_count : g.grain_group_count * uint64_t{k_lane_group};
  entries[1] = {k_unit_grain_sort, sweeps * 2 * refined / static_cast<uint64_t>(k_sweeps_per_sort)};
  entries[2] = {k_unit_refine, sweeps * refined};
  return 3;
}

// ---- output

uint32_t output_count(const Granular& g) {
  if (g.input == nullptr || g.input->grains == nullptr) return 0;
  const uint32_t all = g.grain_count + g.free_grain_count;
  return all < g.input->grain_capacity ? all : g.input->grain_capacity;
}

bool next_output(const void* state, uint32_t level, WorkUnit* unit) {
  const Granular& g = *static_cast<const Granular*>(state);
  (void)level;
  const uint32_t all = g.grain_count + g.free_grain_count;
  if (output_count(g) == 0 || g.output_cursor >= all) return false;
  const uint32_t left = all - g.output_cursor;
  unit->kind = k_unit_output;
  unit->name = "output.grains";
  unit->items = left < g.unit ? left : g.unit;
  return true;
}

// The grains, then the numbers that stand for none.
struct OutputTask {
  const Grain* grains;
  const uint32_t* removed;
  uint32_t grain_count;
  uint8_t* out;
  uint64_t stride;
  uint32_t capacity;
  float lag;
  void run(uint32_t piece, uint32_t begin, uint32_t end) {
    (void)piece;
    for (uint32_t i = begin; i < end; ++i) {
      sandglass_grain grain = {{0.0f, SANDGLASS_REMOVED_Y, 0.0f}, -1.0f};
      uint32_t number;
      if (i < grain_count) {
        const float *x = grains[i].position, *v = grains[i].velocity;
        number = grains[i].number;
        grain = {{x[0] - lag * v[0], x[1] - lag * v[1], x[2] - lag * v[2]},
                 __builtin_sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])};
      } else {
        number = removed[i - grain_count];
      }
      if (number < capacity) __builtin_memcpy(out + number * stride, &grain, sizeof grain);
    }
  }
};

void run_output(void* state, uint32_t level) {
  (void)level;
  Granular* g = static_cast<Granular*>(state);
  const uint32_t all = g->grain_count + g->free_grain_count;
  const float lag = g->input->output_lag > 0.0f ? (g->input->output_lag < 0.1f ? g->input->output_lag : 0.1f) : 0.0f;
  OutputTask task = {g->grains[0],
                     g->free_grains,
                     g->grain_count,
                     static_cast<uint8_t*>(g->input->grains),
                     g->input->grain_stride,
                     output_count(*g),
                     lag};
  const uint32_t end = all - g->output_cursor < g->unit ? all : g->output_cursor + g->unit;
  granular_split(*g, g->output_cursor, end, &task);
  g->output_cursor = end;
}

uint32_t forecast_output(const void* state, uint32_t level, Forecast* entries) {
  const Granular& g = *static_cast<const Granular*>(state);
  (void)level;
  if (output_count(g) == 0) return 0;
  entries[0] = {k_unit_output, uint64_t{g.grain_count} + g.free_grain_count};
  return 1;
}

}  // namespace

void granular_finish_sweep(Granular* g) {
  while (g->grain_phase != GrainPhase::idle) run(g, 0);
}

double granular_lag_limit(const Granular& g) {
  const float frame = g.frame_step > g.desc.refine_step ? g.frame_step : g.desc.refine_step;
  const double under_way = g.grain_phase == GrainPhase::idle ? 0.0 : g.sweep_time;
  return under_way + k_sweep_steps_max * static_cast<double>(frame);
}

bool granular_grains_behind(const Granular& g) {
  if (g.grain_count == 0 || g.particle_count == 0) return false;  // without particles there is nothing to follow
  return g.unswept >= granular_lag_limit(g) - k_time_resolution;
}

// A unit of grains becomes mandatory when the particles wait for them: whatever the budget, one of the two goes on.
Stage granular_grain_stage(Granular* granular) {
  const bool awaited = granular_grains_behind(*granular) || granular->grain_phase == GrainPhase::snapshot;
  return {granular, next, run, forecast, k_granular_kinds, awaited ? 1u : 0u, 1.0f};
}

Stage granular_output_stage(Granular* granular) {
  return {granular, next_output, run_output, forecast_output, k_granular_kinds, k_all_units, 1.0f};
}

}  // namespace sandglass
