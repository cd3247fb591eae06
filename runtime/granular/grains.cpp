// The grains: their records, who of them sleeps, and their way into the app's buffer.
#include "kernels/whole.h"
#include "runtime/granular/granular.h"

namespace sandglass {

// ---- Grains

void grains_layout(Grains* g, const sandglass_granular_desc& d, uint32_t particle_rows, Layout* layout) {
  if (d.grain_capacity == 0) return;
  const char* const axes[3] = {"granular.snapshot_x", "granular.snapshot_y", "granular.snapshot_z"};
  const uint64_t rows = particle_rows, grain_rows = static_cast<uint64_t>(d.grain_capacity) + k_array_slack;
  Snapshot& s = g->snapshot;
  for (int k = 0; k < 3; ++k) s.positions[k] = layout_region<float>(layout, axes[k], rows + k_array_slack);
  s.particles = layout_region<Particle>(layout, "granular.snapshot", rows);
  cell_sort_layout(&s.sort, layout, "granular.snapshot_cells", "granular.snapshot_keys", rows, 2 * rows);
  g->records = layout_region<Grain>(layout, "granular.grains", grain_rows);
}

void grains_sort_layout(Grains* g, const sandglass_granular_desc& d, Layout* layout) {
  const uint64_t grain_rows = static_cast<uint64_t>(d.grain_capacity) + k_array_slack;
  cell_sort_layout(&g->sort, layout, "cells", "keys", grain_rows, grain_rows);
  g->sort.serpentine = true;
}

void grains_reset(Grains* g) { g->count = 0; }

// ---- GrainSleep

namespace {

uint32_t groups_of(const Granular& g) { return (g.grains.count + k_lane_group - 1) / k_lane_group; }

// The sphere around the grains of a group. The kernel that wakes particles wakes such spheres too.
void make_tile(Granular* g, uint32_t group) {
  Sleeper* tile = &g->grain_sleep.tiles[group];
  const uint32_t first = group * k_lane_group;
  const uint32_t last = g->grains.count - first < k_lane_group ? g->grains.count : first + k_lane_group;
  float low[3] = {3e38f, 3e38f, 3e38f}, high[3] = {-3e38f, -3e38f, -3e38f};
  for (uint32_t i = first; i < last; ++i) {
    const float* r = g->grains.records[i].position;
    for (int k = 0; k < 3; ++k) low[k] = r[k] < low[k] ? r[k] : low[k], high[k] = r[k] > high[k] ? r[k] : high[k];
  }
  float radius2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    tile->position[k] = 0.5f * (low[k] + high[k]);
    radius2 += 0.25f * (high[k] - low[k]) * (high[k] - low[k]);
  }
  tile->radius = __builtin_sqrtf(radius2);
}

bool keeps_still(const Granular& g, uint32_t group) {
  const uint32_t first = group * k_lane_group;
  const uint32_t last = g.grains.count - first < k_lane_group ? g.grains.count : first + k_lane_group;
  for (uint32_t i = first; i < last; ++i) {
    if (!(g.grains.records[i].still_sweeps >= k_patience_sweeps)) return false;
  }
  return true;
}

// A collider came near the sphere of the group: wakes those of its grains that it really came near. False: none.
bool wake_grains(Granular* g, uint32_t group) {
  alignas(SANDGLASS_BLOCK_ALIGNMENT) Sleeper points[k_lane_group] = {};
  Grain* grains = g->grains.records + static_cast<uint64_t>(group) * k_lane_group;
  for (uint32_t l = 0; l < k_lane_group; ++l) {
    for (int k = 0; k < 3; ++k) points[l].position[k] = grains[l].position[k];
    set_asleep(&points[l], true);
  }
  const uint32_t left = g->grains.count - group * k_lane_group;
  const WakeArgs args = {points, left < k_lane_group ? left : k_lane_group, g->colliders.for_grains.moved.frames,
                         g->colliders.for_grains.moved.margins, g->colliders.for_grains.moved.count};
  uint32_t woken = 0;
  g->kernels->wake_near(&args, 0, args.sleeper_count, &woken);
  for (uint32_t l = 0; l < args.sleeper_count; ++l) {
    if (is_awake(points[l])) grains[l].still_sweeps = 0.0f;
  }
  return woken != 0;
}

void wake_groups(Granular* g, uint32_t begin, uint32_t end) {
  for (uint32_t i = begin * k_lane_group; i < end * k_lane_group && i < g->grains.count; ++i)
    g->grains.records[i].still_sweeps = 0.0f;
  for (uint32_t group = begin; group < end; ++group) g->grain_sleep.still[group] = 0;
}

}  // namespace

void grain_sleep_layout(GrainSleep* s, const sandglass_granular_desc& d, Layout* layout) {
  if (d.grain_capacity == 0) return;
  const uint64_t groups = (d.grain_capacity + k_lane_group - 1) / k_lane_group;
  s->groups = layout_region<uint32_t>(layout, "granular.grain_groups", groups);
  s->still = layout_region<uint8_t>(layout, "granular.grain_still", groups);
  s->tiles = layout_region<Sleeper>(layout, "granular.grain_tiles", groups + k_array_slack);
}

void grain_sleep_reset(GrainSleep* s) {
  s->group_count = s->still_groups = 0;
  s->groups_changed = s->all_asleep = s->wakes = s->waking = false;
}

void grain_sleep_wake_all(GrainSleep* s) { s->wakes = true; }

void grain_sleep_settle(Granular* g) {
  GrainSleep& s = g->grain_sleep;
  if (s.wakes) wake_groups(g, 0, groups_of(*g));
  s.group_count = s.still_groups = 0;
  s.groups_changed = true;
  s.all_asleep = s.wakes = false;
}

void grain_sleep_skip_time(Granular* g) {
  if (!g->grain_sleep.all_asleep || g->grain_sleep.wakes || g->sweep.phase != SweepPhase::idle) return;
  if (watch_changed(*g, g->colliders.for_grains)) g->grain_sleep.all_asleep = false;
  else g->time.grain_lag = 0.0;
}

void grain_sleep_begin_triage(Granular* g) {
  g->grain_sleep.group_count = g->grain_sleep.still_groups = 0;
  g->grain_sleep.waking = g->grain_sleep.wakes;
  ColliderWatch& watch = g->colliders.for_grains;
  watch_find_moved(*g, &watch, g->desc.grain_radius);
  if (!g->colliders.waits) watch_remember(g, &watch);
}

uint32_t grain_sleep_items(const Granular& g) {
  const uint32_t left = groups_of(g) - g.sweep.cursor;
  return left < g.unit ? left : g.unit;
}

bool grain_sleep_run_triage(Granular* g) {
  const bool follows = g->desc.reference.blend != SANDGLASS_BLEND_SOURCE;  // else nothing is known of where they move
  const uint32_t groups = groups_of(*g);
  const uint32_t begin = g->sweep.cursor, end = groups - begin < g->unit ? groups : begin + g->unit;
  if (g->grain_sleep.waking) wake_groups(g, begin, end);
  for (uint32_t group = begin; group < end; ++group) {
    Sleeper* tile = &g->grain_sleep.tiles[group];
    set_asleep(tile, false);
    if (g->grain_sleep.groups_changed) g->grain_sleep.still[group] = keeps_still(*g, group) ? 1 : 0;
    if (g->grain_sleep.still[group] == 0) continue;
    make_tile(g, group);
    ++g->grain_sleep.still_groups;
    if (follows && !motion_near(g->motion.grid, tile->position, tile->radius)) set_asleep(tile, true);
  }
  if (g->colliders.for_grains.moved.count != 0) {
    const WakeArgs args = {g->grain_sleep.tiles, end, g->colliders.for_grains.moved.frames,
                           g->colliders.for_grains.moved.margins, g->colliders.for_grains.moved.count};
    uint32_t woken = 0;
    g->kernels->wake_near(&args, begin / k_lane_group * k_lane_group, end, &woken);
  }
  for (uint32_t group = begin; group < end; ++group) {
    const Sleeper& tile = g->grain_sleep.tiles[group];
    if (!is_awake(tile)) continue;
    if (was_woken(tile) && !wake_grains(g, group)) continue;
    g->grain_sleep.groups[g->grain_sleep.group_count++] = group;
  }
  g->sweep.cursor = end;
  if (end < groups) return false;
  g->grain_sleep.groups_changed = false;
  if (g->grain_sleep.waking) g->grain_sleep.wakes = false;
  return true;
}

// ---- Output

namespace {

uint32_t output_count(const Granular& g) {
  if (g.output.input == nullptr || g.output.input->grains == nullptr) return 0;
  const uint32_t all = g.grains.count + g.flow.free_grain_count;
  return all < g.output.input->grain_capacity ? all : g.output.input->grain_capacity;
}

bool next(const void* state, uint32_t level, WorkUnit* unit) {
  const Granular& g = *static_cast<const Granular*>(state);
  (void)level;
  const uint32_t all = g.grains.count + g.flow.free_grain_count;
  if (output_count(g) == 0 || g.output.cursor >= all) return false;
  const uint32_t left = all - g.output.cursor;
  unit->kind = k_unit_output;
  unit->name = "output.grains";
  unit->items = left < g.unit ? left : g.unit;
  return true;
}

// Half a grain's record: a position and a number, or a velocity. Four lanes, which the compiler makes one register.
typedef float HalfRecord __attribute__((vector_size(16), may_alias));

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
    const OutputTask t = *this;  // what is written may not be this
    const uint32_t last = end < t.grain_count ? end : t.grain_count;
    uint32_t i = begin;
    for (; i < last; ++i) {
      const uint32_t number = t.grains[i].number;
      if (number >= t.capacity) continue;
      const HalfRecord* record = reinterpret_cast<const HalfRecord*>(&t.grains[i]);
      const HalfRecord v = record[1], squares = v * v;
      HalfRecord grain = record[0] - t.lag * v;
      grain[3] = __builtin_sqrtf(squares[0] + squares[1] + squares[2]);
      __builtin_memcpy(t.out + number * t.stride, &grain, sizeof grain);
    }
    for (; i < end; ++i) {
      const sandglass_grain grain = {{0.0f, SANDGLASS_REMOVED_Y, 0.0f}, -1.0f};
      const uint32_t number = t.removed[i - t.grain_count];
      if (number < t.capacity) __builtin_memcpy(t.out + number * t.stride, &grain, sizeof grain);
    }
  }
};
static_assert(offsetof(sandglass_grain, speed) == 12 && sizeof(sandglass_grain) == sizeof(HalfRecord));

void run_output(void* state, uint32_t level) {
  (void)level;
  Granular* g = static_cast<Granular*>(state);
  const uint32_t all = g->grains.count + g->flow.free_grain_count;
  const float lag = g->output.input->output_lag > 0.0f
                        ? (g->output.input->output_lag < 0.1f ? g->output.input->output_lag : 0.1f)
                        : 0.0f;
  OutputTask task = {g->grains.records,
                     g->flow.free_grains,
                     g->grains.count,
                     static_cast<uint8_t*>(g->output.input->grains),
                     g->output.input->grain_stride,
                     output_count(*g),
                     lag};
  const uint32_t end = all - g->output.cursor < g->unit ? all : g->output.cursor + g->unit;
  granular_split(*g, g->output.cursor, end, &task);
  g->output.cursor = end;
}

uint32_t forecast(const void* state, uint32_t level, Forecast* entries) {
  const Granular& g = *static_cast<const Granular*>(state);
  (void)level;
  if (output_count(g) == 0) return 0;
  entries[0] = {k_unit_output, uint64_t{g.grains.count} + g.flow.free_grain_count};
  return 1;
}

}  // namespace

void output_begin_frame(Output* output, const sandglass_frame_input* input) {
  output->input = input;
  output->cursor = 0;
}

void output_restart(Output* output) { output->cursor = 0; }

Stage granular_output_stage(Granular* granular) {
  return {granular, next, run_output, forecast, k_granular_kinds, k_all_units, 1.0f};
}

}  // namespace sandglass
