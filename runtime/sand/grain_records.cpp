// The grains: their records, who of them sleeps, and how they get into the app's buffer. Where they go:
// kernels/grain_motion.inl.
#include "kernels/whole.h"
#include "runtime/sand/granular.h"

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

void grains_restore(Grains* g, const SavedScene& s) { g->count = s.grains; }

void grains_move(Grains* g, const SceneMove& move) {
  for (uint32_t i = 0; i < g->count; ++i) {
    move.move(g->records[i].position);
    move.turn(g->records[i].velocity);
  }
}

void grains_append(Grains* grains, const float position[3], const float velocity[3], uint32_t number) {
  grains->records[grains->count++] = moving_grain(position, velocity, number);
}

void grains_remove(Grains* grains, uint32_t i) {
  const uint32_t last = --grains->count;
  grains->records[i] = grains->records[last];
}

void grains_begin_snapshot(Grains* grains, const Granular& g) {
  cell_sort_begin(&grains->snapshot.sort, k_support_radii * g.desc.particle_radius, g.particles.low, g.particles.high,
                  3);
}

bool grains_run_snapshot(Grains* grains, const Granular& g) {
  Snapshot& s = grains->snapshot;
  const SortTarget target = {as_records(s.particles), {s.positions[0], s.positions[1], s.positions[2]}, true};
  cell_sort_run(&s.sort, *g.kernels, as_records(g.particles.records[0]), g.particles.count, g.unit, target);
  return s.sort.phase == k_sort_done;
}

void grains_begin_sort(Grains* grains, const Granular& g) {
  // Coarser: more vectors lie in several blocks of the motion grid.
  constexpr float k_grain_cell_radii = 1.3f;
  cell_sort_begin(&grains->sort, k_grain_cell_radii * g.desc.particle_radius, g.particles.low, g.particles.high, 2);
}

bool grains_run_sort(Grains* grains, const Granular& g) {
  const SortTarget in_place = {as_records(grains->records), {nullptr, nullptr, nullptr}, false};
  cell_sort_run(&grains->sort, *g.kernels, in_place.records, grains->count, g.unit, in_place);
  return grains->sort.phase == k_sort_done;
}

// ---- GrainSleep

namespace {

uint32_t groups_of(const Granular& g) { return (g.grains.count + k_lane_group - 1) / k_lane_group; }

// The sphere around the grains of a group. The kernel that wakes particles wakes such spheres too.
void make_tile(GrainSleep* s, const Granular& g, uint32_t group) {
  Sleeper* tile = &s->tiles[group];
  const uint32_t first = group * k_lane_group;
  const uint32_t last = g.grains.count - first < k_lane_group ? g.grains.count : first + k_lane_group;
  float low[3] = {3e38f, 3e38f, 3e38f}, high[3] = {-3e38f, -3e38f, -3e38f};
  for (uint32_t i = first; i < last; ++i) {
    const float* r = g.grains.records[i].position;
    for (int k = 0; k < 3; ++k) {
      low[k] = r[k] < low[k] ? r[k] : low[k];
      high[k] = r[k] > high[k] ? r[k] : high[k];
    }
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
    const Grain& grain = g.grains.records[i];
    if (!(grain.still_sweeps >= k_patience_sweeps)) return false;
    for (const float v : grain.velocity)
      if (v != 0.0f) return false;
  }
  return true;
}

// A collider came near the sphere of the group: wakes those of its grains that it really came near. False: none.
bool wake_grains(const Granular& g, uint32_t group) {
  alignas(SANDGLASS_BLOCK_ALIGNMENT) Sleeper points[k_lane_group] = {};
  Grain* grains = g.grains.records + static_cast<uint64_t>(group) * k_lane_group;
  for (uint32_t l = 0; l < k_lane_group; ++l) {
    for (int k = 0; k < 3; ++k) points[l].position[k] = grains[l].position[k];
    set_asleep(&points[l], true);
  }
  const uint32_t left = g.grains.count - group * k_lane_group;
  const WakeArgs args = {points, left < k_lane_group ? left : k_lane_group, g.colliders.for_grains.moved.frames,
                         g.colliders.for_grains.moved.margins, g.colliders.for_grains.moved.count};
  uint32_t woken = 0;
  g.kernels->wake_near(&args, 0, args.sleeper_count, &woken);
  for (uint32_t l = 0; l < args.sleeper_count; ++l) {
    const bool changed = reliefs_wake(g.colliders.for_grains.moved, points[l].position, g.desc.grain_radius);
    woken += changed ? 1u : 0u;
    if (changed || is_awake(points[l])) grains[l].still_sweeps = 0.0f;
  }
  return woken != 0;
}

void wake_groups(GrainSleep* s, const Granular& g, uint32_t begin, uint32_t end) {
  for (uint32_t i = begin * k_lane_group; i < end * k_lane_group && i < g.grains.count; ++i)
    g.grains.records[i].still_sweeps = 0.0f;
  for (uint32_t group = begin; group < end; ++group) s->still[group] = 0;
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

void grain_sleep_settle(GrainSleep* s, const Granular& g) {
  if (s->wakes) wake_groups(s, g, 0, groups_of(g));
  s->group_count = s->still_groups = 0;
  s->groups_changed = true;
  s->all_asleep = s->wakes = false;
}

void grain_sleep_regrouped(GrainSleep* s) { s->groups_changed = true; }

void grain_sleep_added(GrainSleep* s, const Granular& g, uint32_t count) {
  for (uint32_t group = (g.grains.count - count) / k_lane_group; group * k_lane_group < g.grains.count; ++group)
    s->still[group] = 0;
  s->all_asleep = false;
}

void grain_sleep_removed(GrainSleep* s) {
  s->groups_changed = true;
  s->all_asleep = false;
}

void grain_sleep_carried(GrainSleep* s, uint32_t begin, uint32_t end) {
  for (uint32_t group = begin; group < end; ++group)
    if (s->still[group] == k_tile_made) s->still[group] = 1;
}

void grain_sleep_followed(GrainSleep* s, bool at_rest) { s->all_asleep = at_rest; }

bool grain_sleep_skips_time(GrainSleep* s, const Granular& g) {
  if (!s->all_asleep || s->wakes || g.sweep.phase != SweepPhase::idle) return false;
  s->all_asleep = !watch_changed(g, g.colliders.for_grains);
  return s->all_asleep;
}

void grain_sleep_begin_triage(GrainSleep* s) {
  s->group_count = s->still_groups = 0;
  s->waking = s->wakes;
}

uint32_t grain_sleep_items(const Granular& g) {
  const uint32_t left = groups_of(g) - g.sweep.cursor;
  return left < g.unit ? left : g.unit;
}

bool grain_sleep_run_triage(GrainSleep* s, const Granular& g, uint32_t* cursor) {
  const bool follows = g.desc.reference.blend != SANDGLASS_BLEND_SOURCE;  // else nothing is known of where they move
  const uint32_t groups = groups_of(g);
  const uint32_t begin = *cursor, end = groups - begin < g.unit ? groups : begin + g.unit;
  if (s->waking) wake_groups(s, g, begin, end);
  for (uint32_t group = begin; group < end; ++group) {
    Sleeper* tile = &s->tiles[group];
    set_asleep(tile, false);
    if (s->groups_changed) s->still[group] = keeps_still(g, group) ? 1 : 0;
    if (s->still[group] == 0) continue;
    if (s->still[group] != k_tile_made) {
      make_tile(s, g, group);
      s->still[group] = k_tile_made;
    }
    ++s->still_groups;
    if (follows && !motion_near(g.motion, g, group, *tile)) set_asleep(tile, true);
  }
  if (g.colliders.for_grains.moved.count != 0) {
    const WakeArgs args = {s->tiles, end, g.colliders.for_grains.moved.frames, g.colliders.for_grains.moved.margins,
                           g.colliders.for_grains.moved.count};
    uint32_t woken = 0;
    g.kernels->wake_near(&args, begin / k_lane_group * k_lane_group, end, &woken);
  }
  for (uint32_t group = begin; g.colliders.for_grains.moved.relief_count != 0 && group < end; ++group) {
    Sleeper* tile = &s->tiles[group];
    if (is_awake(*tile) || !reliefs_changed(g.colliders.for_grains.moved, tile->position, tile->radius)) continue;
    tile->mobility = -tile->mobility;
  }
  for (uint32_t group = begin; group < end; ++group) {
    const Sleeper& tile = s->tiles[group];
    if (!is_awake(tile)) continue;
    if (was_woken(tile) && !wake_grains(g, group)) continue;
    s->groups[s->group_count++] = group;
  }
  *cursor = end;
  if (end < groups) return false;
  s->groups_changed = false;
  if (s->waking) s->wakes = false;
  return true;
}

// ---- Output

namespace {

uint32_t output_count(const Granular& g) {
  if (g.output.input == nullptr || g.output.input->grains == nullptr) return 0;
  const uint32_t all = g.grains.count + g.flow.free_grain_count;
  return all < g.output.input->grain_capacity ? all : g.output.input->grain_capacity;
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
  const uint32_t* stamps;  // of the groups; null: all are written
  uint32_t oldest;         // stamps from this one on are written
  GrainMotions motions;
  template <bool k_carried>
  void write(uint32_t begin, uint32_t end) const {
    const OutputTask t = *this;  // what is written may not be this
    for (uint32_t i = begin; i < end; ++i) {
      if (t.stamps != nullptr && t.stamps[i / k_lane_group] < t.oldest) {
        i |= k_lane_group - 1;
        continue;
      }
      const uint32_t number = t.grains[i].number;
      if (number >= t.capacity) continue;
      const Quad* record = reinterpret_cast<const Quad*>(&t.grains[i]);
      Quad grain = record[0] - t.lag * record[1];
      if constexpr (k_carried) {
        const RigidMotion* const motion = t.motions.of(i);
        if (motion != nullptr) grain += motion->displacement(grain);
      }
      grain[3] = __builtin_sqrtf(square_of(record[1]));
      __builtin_memcpy(t.out + number * t.stride, &grain, sizeof grain);
    }
  }
  void run(uint32_t piece, uint32_t begin, uint32_t end) {
    (void)piece;
    const uint32_t last = end < grain_count ? end : grain_count;
    if (motions.holders != nullptr) write<true>(begin, last);
    else write<false>(begin, last);
    for (uint32_t i = begin > grain_count ? begin : grain_count; i < end; ++i) {
      const sandglass_grain grain = {{0.0f, SANDGLASS_REMOVED_Y, 0.0f}, -1.0f};
      const uint32_t number = removed[i - grain_count];
      if (number < capacity) __builtin_memcpy(out + number * stride, &grain, sizeof grain);
    }
  }
};
static_assert(offsetof(sandglass_grain, speed) == 12 && sizeof(sandglass_grain) == sizeof(Quad));

}  // namespace

bool output_next(const Granular& g, WorkUnit* unit) {
  const uint32_t all = g.grains.count + g.flow.free_grain_count;
  if (output_count(g) == 0 || g.output.cursor >= all) return false;
  const Output& o = g.output;
  if (o.oldest != 0 && !o.moved && !o.all_changed && o.last_change < o.oldest) return false;  // the buffer holds it
  const uint32_t left = all - g.output.cursor;
  unit->kind = k_unit_output;
  unit->name = "output.grains";
  unit->items = left < g.unit ? left : g.unit;
  return true;
}

void output_run(Output* output, const Granular& g) {
  const uint32_t all = g.grains.count + g.flow.free_grain_count;
  const float lag =
      output->input->output_lag > 0.0f ? (output->input->output_lag < 0.1f ? output->input->output_lag : 0.1f) : 0.0f;
  OutputTask task = {g.grains.records,
                     g.flow.free_grains,
                     g.grains.count,
                     reinterpret_cast<uint8_t*>(output->input->grains),
                     output->input->grain_stride,
                     output_count(g),
                     lag,
                     output->all_changed || output->all_since >= output->oldest ? nullptr : output->stamps,
                     output->oldest,
                     grain_carry_motions(g)};
  const uint32_t end = all - output->cursor < g.unit ? all : output->cursor + g.unit;
  granular_split(g, output->cursor, end, &task);
  output->cursor = end;
}

uint32_t output_forecast(const Granular& g, Forecast* entries) {
  if (output_count(g) == 0) return 0;
  entries[0] = {k_unit_output, uint64_t{g.grains.count} + g.flow.free_grain_count};
  return 1;
}

void output_layout(Output* o, const sandglass_granular_desc& d, Layout* layout) {
  if (d.grain_capacity == 0) return;
  o->stamps =
      layout_region<uint32_t>(layout, "granular.grain_stamps", (d.grain_capacity + k_lane_group - 1) / k_lane_group);
}

void output_begin_frame(Output* output, const sandglass_frame_input* input) {
  output->input = input;
  output->cursor = 0;
  ++output->frame;
  const uint32_t age = input->grains_age;
  output->oldest = age == 0 || age >= output->frame ? 0 : output->frame - age + 1;
}

void output_end_frame(Output* o) {
  if (o->all_changed) o->all_since = o->frame;
  if (o->all_changed || o->moved) {
    o->last_change = o->frame;
    ++o->version;
  }
  o->all_changed = o->moved = false;
}

void output_moved(Output* o, uint32_t groups) { o->moved = o->moved || groups != 0; }
void output_regrouped(Output* o) { o->all_since = o->frame; }
void output_changed(Output* o) { o->all_changed = true; }
bool output_is_moving(const Output& o) { return o.all_changed || o.last_change + 1 >= o.frame; }

void output_restart(Output* output) { output->cursor = 0; }

}  // namespace sandglass
