// Which grains a sweep refines. A group of 16 grains (neighbours in storage, so mostly in space) is left out when all
// of it has kept still for some sweeps, no awake particle is near enough to be in its sums, and no collider that moved
// since the last sweep comes near.
//
//   mark     the cells of the snapshot that hold an awake particle, spread to the 26 cells around each: a cell is as
//   wide
//            as the support radius, so what lies in an unmarked cell hears of sleepers only
//   triage   every group is either listed for refinement or left alone
//
// The refinement itself leaves a still grain where it is while all particles in its sums sleep, so leaving its group
// out changes no bit.
//
// Where nothing keeps still there is nothing to decide: all groups are listed, without looking.
#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

enum : uint32_t { k_mark_none, k_mark_awake, k_spread_x, k_spread_y, k_spread_z, k_mark_done };

constexpr float k_scattered_cells = 3.0f;  // a group wider than this is not looked up cell by cell
constexpr uint32_t k_cells_per_item = 8;   // a cell costs that much less than a grain's share of triage

uint32_t groups_of(const Granular& g) { return (g.grain_count + k_lane_group - 1) / k_lane_group; }

// From the snapshot, not from the particles: those may have gone on.
void mark_awake(Granular* g, uint32_t begin, uint32_t end) {
  const uint32_t* starts = g->snapshot_sort.starts;
  for (uint32_t c = begin; c < end; ++c) {
    bool awake = false;
    for (uint32_t i = starts[c]; i < starts[c + 1]; ++i) awake = awake || is_awake(g->snapshot[i]);
    g->awake_cells[0][c] = awake ? 1 : 0;
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
  Sleeper* tile = &g->grain_tiles[group];
  const uint32_t first = group * k_lane_group;
  const uint32_t last = g->grain_count - first < k_lane_group ? g->grain_count : first + k_lane_group;
  float low[3] = {3e38f, 3e38f, 3e38f}, high[3] = {-3e38f, -3e38f, -3e38f};
  for (uint32_t i = first; i < last; ++i) {
    const float* r = g->grains[0][i].position;
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
  const int32_t truncated = static_cast<int32_t>(scaled);
  return scaled < static_cast<float>(truncated) ? truncated - 1 : truncated;
}

bool near_awake_particle(const Granular& g, const Sleeper& tile) {
  const Grid& grid = g.snapshot_sort.grid;
  // Grains of distant cells that share storage: they rest when everything does.
  if (tile.radius * grid.inverse_cell > k_scattered_cells) return g.awake_count != 0;
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
        awake |= g.awake_cells[1][c[0] | (c[1] << grid.bits[0]) | (c[2] << (grid.bits[0] + grid.bits[1]))];
      }
    }
  }
  return awake != 0;
}

bool keeps_still(const Granular& g, uint32_t group) {
  const uint32_t first = group * k_lane_group;
  const uint32_t last = g.grain_count - first < k_lane_group ? g.grain_count : first + k_lane_group;
  bool still = true;
  for (uint32_t i = first; i < last; ++i) still = still && g.grains[0][i].still_sweeps >= k_patience_sweeps;
  return still;
}

// The collider that came near the group: which of its grains are really near? Those have to find their rest anew.
bool wake_grains(Granular* g, uint32_t group) {
  alignas(SANDGLASS_BLOCK_ALIGNMENT) Sleeper points[k_lane_group] = {};
  Grain* grains = g->grains[0] + static_cast<uint64_t>(group) * k_lane_group;
  for (uint32_t l = 0; l < k_lane_group; ++l) {
    for (int k = 0; k < 3; ++k) points[l].position[k] = grains[l].position[k];
    set_asleep(&points[l], true);
  }
  const uint32_t left = g->grain_count - group * k_lane_group;
  const WakeArgs args = {points, left < k_lane_group ? left : k_lane_group, g->sweep_moved.frames,
                         g->sweep_moved.margins, g->sweep_moved.count};
  uint32_t woken = 0;
  g->kernels->wake_near(&args, 0, args.sleeper_count, &woken);
  for (uint32_t l = 0; l < args.sleeper_count; ++l) {
    if (is_awake(points[l])) grains[l].still_sweeps = 0.0f;
  }
  return woken != 0;
}

void begin_triage(Granular* g) {
  g->grain_phase = GrainPhase::triage;
  g->grain_cursor = g->grain_group_count = g->still_groups = 0;
  granular_find_moved(g->sweep_colliders_before, g->sweep_collider_before_count, g->colliders, g->collider_count,
                      g->desc.grain_radius, &g->sweep_moved);
  g->sweep_collider_before_count = g->collider_count;
  for (uint32_t c = 0; c < g->collider_count; ++c) g->sweep_colliders_before[c] = g->colliders[c];
}

}  // namespace

void granular_begin_mark(Granular* g) {
  g->grain_cursor = 0;
  g->mark_pass = k_mark_none;
  if (g->still_groups == 0) return begin_triage(g);
  g->mark_pass = k_mark_awake;
  g->grain_phase = GrainPhase::mark;
}

uint32_t granular_mark_items(const Granular& g) {
  if (g.grain_phase == GrainPhase::triage) {
    const uint32_t left = groups_of(g) - g.grain_cursor;
    return left < g.unit ? left : g.unit;
  }
  const uint32_t left = (g.snapshot_sort.cells - g.grain_cursor) / k_cells_per_item + 1;
  return left < g.unit ? left : g.unit;
}

void granular_run_mark(Granular* g) {
  const uint32_t all = g->snapshot_sort.cells, size = g->unit * k_cells_per_item;
  const uint32_t begin = g->grain_cursor, end = all - begin < size ? all : begin + size;
  const uint32_t* bits = g->snapshot_sort.grid.bits;
  uint8_t* const* cells = g->awake_cells;
  switch (g->mark_pass) {
    case k_mark_awake:
      mark_awake(g, begin, end);
      break;
    case k_spread_x:
      spread(cells[0], cells[1], 0, bits[0], begin, end);
      break;
    case k_spread_y:
      spread(cells[1], cells[0], bits[0], bits[1], begin, end);
      break;
    default:
      spread(cells[0], cells[1], bits[0] + bits[1], bits[2], begin, end);
      break;
  }
  g->grain_cursor = end;
  if (end < all) return;
  g->grain_cursor = 0;
  if (++g->mark_pass == k_mark_done) begin_triage(g);
}

void granular_run_triage(Granular* g) {
  const uint32_t groups = groups_of(*g);
  const uint32_t begin = g->grain_cursor, end = groups - begin < g->unit ? groups : begin + g->unit;
  for (uint32_t group = begin; group < end; ++group) {
    Sleeper* tile = &g->grain_tiles[group];
    set_asleep(tile, false);
    tile->untouched[0] = tile->mobility;
    if (g->groups_changed) g->grain_still[group] = keeps_still(*g, group) ? 1 : 0;
    if (g->grain_still[group] == 0) continue;
    make_tile(g, group);
    ++g->still_groups;
    if (g->mark_pass == k_mark_done && !near_awake_particle(*g, *tile)) set_asleep(tile, true);
    tile->untouched[0] = tile->mobility;
  }
  if (g->sweep_moved.count != 0) {
    const WakeArgs args = {g->grain_tiles, end, g->sweep_moved.frames, g->sweep_moved.margins, g->sweep_moved.count};
    uint32_t woken = 0;
    g->kernels->wake_near(&args, begin / k_lane_group * k_lane_group, end, &woken);
  }
  for (uint32_t group = begin; group < end; ++group) {
    const Sleeper& tile = g->grain_tiles[group];
    if (!is_awake(tile)) continue;
    if (tile.untouched[0] < 0.0f && !wake_grains(g, group)) continue;
    g->grain_groups[g->grain_group_count++] = group;
  }
  g->grain_cursor = end;
  if (end < groups) return;
  g->grain_cursor = 0;
  g->groups_changed = false;
  g->grain_phase = GrainPhase::refine;
}

}  // namespace sandglass
