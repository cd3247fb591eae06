#include "runtime/granular/grain_sleep.h"

#include "kernels/whole.h"
#include "runtime/granular/granular.h"

namespace sandglass {

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

}  // namespace sandglass
