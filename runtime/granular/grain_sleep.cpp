#include "runtime/granular/grain_sleep.h"

#include "kernels/whole.h"
#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

constexpr float k_scattered_cells = 3.0f;  // a group wider than this is not looked up cell by cell
constexpr uint32_t k_cells_per_item = 8;   // as many cells cost what one group costs in triage

uint32_t groups_of(const Granular& g) { return (g.grains.count + k_lane_group - 1) / k_lane_group; }

// Marks the cells that hold an awake particle. Reads the snapshot, because the particles may have gone on.
void mark_awake(Granular* g, uint32_t begin, uint32_t end) {
  const uint32_t* starts = g->grains.snapshot.sort.starts;
  for (uint32_t c = begin; c < end; ++c) {
    bool awake = false;
    for (uint32_t i = starts[c]; i < starts[c + 1]; ++i) awake = awake || is_awake(g->grains.snapshot.particles[i]);
    g->grain_sleep.awake_cells[0][c] = awake ? 1 : 0;
  }
}

// Spreads marks to both neighbours along one axis; the grid wraps round.
void spread(const uint8_t* from, uint8_t* to, uint32_t shift, uint32_t bits, uint32_t begin, uint32_t end) {
  const uint32_t step = 1u << shift, mask = ((1u << bits) - 1) << shift;
  for (uint32_t c = begin; c < end; ++c) {
    const uint32_t before = (c & ~mask) | ((c - step) & mask), after = (c & ~mask) | ((c + step) & mask);
    to[c] = static_cast<uint8_t>(from[c] | from[before] | from[after]);
  }
}

// The sphere around the grains of a group. The kernel that wakes particles wakes such spheres too.
void make_tile(Granular* g, uint32_t group) {
  Sleeper* tile = &g->grain_sleep.tiles[group];
  const uint32_t first = group * k_lane_group;
  const uint32_t last = g->grains.count - first < k_lane_group ? g->grains.count : first + k_lane_group;
  float low[3] = {3e38f, 3e38f, 3e38f}, high[3] = {-3e38f, -3e38f, -3e38f};
  for (uint32_t i = first; i < last; ++i) {
    const float* r = g->grains.records[0][i].position;
    for (int k = 0; k < 3; ++k) low[k] = r[k] < low[k] ? r[k] : low[k], high[k] = r[k] > high[k] ? r[k] : high[k];
  }
  float radius2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    tile->position[k] = 0.5f * (low[k] + high[k]);
    radius2 += 0.25f * (high[k] - low[k]) * (high[k] - low[k]);
  }
  tile->radius = __builtin_sqrtf(radius2);
}

int32_t floor_cell(float scaled) {
  const int32_t truncated = to_whole<int32_t>(scaled);
  return scaled < static_cast<float>(truncated) ? truncated - 1 : truncated;
}

bool near_awake_particle(const Granular& g, const Sleeper& tile) {
  const Grid& grid = g.grains.snapshot.sort.grid;
  // Grains of distant cells that share storage sleep only when all particles do.
  if (tile.radius * grid.inverse_cell > k_scattered_cells) return g.sleep.awake_count != 0;
  int32_t first[3], last[3];
  for (int k = 0; k < 3; ++k) {
    first[k] = floor_cell((tile.position[k] - tile.radius) * grid.inverse_cell);
    last[k] = floor_cell((tile.position[k] + tile.radius) * grid.inverse_cell);
  }
  uint8_t awake = 0;
  for (int32_t z = first[2]; z <= last[2]; ++z) {
    for (int32_t y = first[1]; y <= last[1]; ++y) {
      for (int32_t x = first[0]; x <= last[0]; ++x) {
        const uint32_t c[3] = {static_cast<uint32_t>(x) & ((1u << grid.bits[0]) - 1),
                               static_cast<uint32_t>(y) & ((1u << grid.bits[1]) - 1),
                               static_cast<uint32_t>(z) & ((1u << grid.bits[2]) - 1)};
        awake |= g.grain_sleep.awake_cells[1][c[0] | (c[1] << grid.bits[0]) | (c[2] << (grid.bits[0] + grid.bits[1]))];
      }
    }
  }
  return awake != 0;
}

bool keeps_still(const Granular& g, uint32_t group) {
  const uint32_t first = group * k_lane_group;
  const uint32_t last = g.grains.count - first < k_lane_group ? g.grains.count : first + k_lane_group;
  bool still = true;
  for (uint32_t i = first; i < last; ++i) still = still && g.grains.records[0][i].still_sweeps >= k_patience_sweeps;
  return still;
}

// A collider came near the sphere of the group: wakes those of its grains that it really came near. False: none.
bool wake_grains(Granular* g, uint32_t group) {
  alignas(SANDGLASS_BLOCK_ALIGNMENT) Sleeper points[k_lane_group] = {};
  Grain* grains = g->grains.records[0] + static_cast<uint64_t>(group) * k_lane_group;
  for (uint32_t l = 0; l < k_lane_group; ++l) {
    for (int k = 0; k < 3; ++k) points[l].position[k] = grains[l].position[k];
    set_asleep(&points[l], true);
  }
  const uint32_t left = g->grains.count - group * k_lane_group;
  const WakeArgs args = {points, left < k_lane_group ? left : k_lane_group, g->colliders.all.moved.frames,
                         g->colliders.all.moved.margins, g->colliders.all.moved.count};
  uint32_t woken = 0;
  g->kernels->wake_near(&args, 0, args.sleeper_count, &woken);
  for (uint32_t l = 0; l < args.sleeper_count; ++l) {
    if (is_awake(points[l])) grains[l].still_sweeps = 0.0f;
  }
  return woken != 0;
}

void wake_groups(Granular* g, uint32_t begin, uint32_t end) {
  for (uint32_t i = begin * k_lane_group; i < end * k_lane_group && i < g->grains.count; ++i)
    g->grains.records[0][i].still_sweeps = 0.0f;
  for (uint32_t group = begin; group < end; ++group) g->grain_sleep.still[group] = 0;
}

}  // namespace

void grain_sleep_layout(GrainSleep* s, const sandglass_granular_desc& d, uint32_t cells_max, Layout* layout) {
  if (d.grain_capacity == 0) return;
  const uint64_t groups = (d.grain_capacity + k_lane_group - 1) / k_lane_group;
  s->groups = layout_region<uint32_t>(layout, "granular.grain_groups", groups);
  s->still = layout_region<uint8_t>(layout, "granular.grain_still", groups);
  s->tiles = layout_region<Sleeper>(layout, "granular.grain_tiles", groups + k_array_slack);
  s->awake_cells[0] = layout_region<uint8_t>(layout, "granular.awake_cells", cells_max);
  s->awake_cells[1] = layout_region<uint8_t>(layout, "granular.awake_cells_spread", cells_max);
}

void grain_sleep_reset(GrainSleep* s) {
  s->group_count = s->still_groups = 0;
  s->marked = s->groups_changed = s->all_asleep = s->wakes = s->waking = false;
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
  if (watch_changed(g->colliders.all, g->colliders.given, g->colliders.count)) g->grain_sleep.all_asleep = false;
  else g->time.grain_lag = 0.0;
}

void grain_sleep_begin_triage(Granular* g) {
  g->grain_sleep.group_count = g->grain_sleep.still_groups = 0;
  g->grain_sleep.waking = g->grain_sleep.wakes;
  ColliderWatch& watch = g->colliders.all;
  watch_find_moved(&watch, g->colliders.given, g->colliders.count, g->desc.grain_radius);
  watch_remember(&watch, g->colliders.given, g->colliders.count);
}

uint32_t grain_sleep_items(const Granular& g) {
  if (g.sweep.phase == SweepPhase::triage) {
    const uint32_t left = groups_of(g) - g.sweep.cursor;
    return left < g.unit ? left : g.unit;
  }
  const uint32_t left = (g.grains.snapshot.sort.cells - g.sweep.cursor) / k_cells_per_item + 1;
  return left < g.unit ? left : g.unit;
}

bool grain_sleep_run_mark(Granular* g) {
  const uint32_t all = g->grains.snapshot.sort.cells, size = g->unit * k_cells_per_item;
  const uint32_t begin = g->sweep.cursor, end = all - begin < size ? all : begin + size;
  const uint32_t* bits = g->grains.snapshot.sort.grid.bits;
  uint8_t* const* cells = g->grain_sleep.awake_cells;
  switch (g->sweep.phase) {
    case SweepPhase::mark:
      mark_awake(g, begin, end);
      break;
    case SweepPhase::spread_x:
      spread(cells[0], cells[1], 0, bits[0], begin, end);
      break;
    case SweepPhase::spread_y:
      spread(cells[1], cells[0], bits[0], bits[1], begin, end);
      break;
    default:
      spread(cells[0], cells[1], bits[0] + bits[1], bits[2], begin, end);
      break;
  }
  g->sweep.cursor = end;
  return end >= all;
}

bool grain_sleep_run_triage(Granular* g) {
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
    if (g->grain_sleep.marked && !near_awake_particle(*g, *tile)) set_asleep(tile, true);
  }
  if (g->colliders.all.moved.count != 0) {
    const WakeArgs args = {g->grain_sleep.tiles, end, g->colliders.all.moved.frames, g->colliders.all.moved.margins,
                           g->colliders.all.moved.count};
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

}  // namespace sandglass
