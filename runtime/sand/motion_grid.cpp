// The particles' motion on a grid, for the grains to read.
#include "kernels/whole.h"
#include "runtime/math/random.h"
#include "runtime/sand/granular.h"

namespace sandglass {

namespace {

constexpr float k_spacing_radii = 1.5f;
// Reading linearly between nodes widens a weight: its variance along an axis grows by up to spacing^2 / 6. That of
// (1 - d^2/h^2)^3 is h^2 / 11. The reach makes up for 0.7 of it: with that the grains follow best.
constexpr float k_reach_radii = 2.472f;  // sqrt(3^2 - 11 * 0.7 * 1.5^2 / 6)
// There is room for so many blocks. A pile of 1,500 particles fills 277 and one of 3,250 fills 400. While they are poured,
// 121 need 174, 763 need 287 and 2,538 need 736. Grains that find no room follow means, not their own particles.
constexpr uint32_t k_particles_per_block = 4;
constexpr uint32_t k_blocks_min = 144;
// Places near what moves are cells of 2^k_cell_shift nodes.
constexpr uint32_t k_cell_shift = 1;
// What things cost, where counting a grain costs 1.
constexpr uint32_t k_items_per_particle = 16;
constexpr uint32_t k_items_per_join = 32;  // of a block
constexpr uint32_t k_items_per_smooth = 96;

uint32_t capacity_of(const sandglass_granular_desc& d) {
  return d.particle_capacity / k_particles_per_block + k_blocks_min;
}

uint32_t table_size(uint32_t blocks) {
  uint32_t size = 64;
  while (size < 2 * blocks) size *= 2;
  return size;
}

// The records of block `to` on the side `beyond` are the first nodes of block `from`; without it they are empty.
void copy_nodes(const MotionGrid& grid, uint32_t from, uint32_t to, const uint32_t beyond[3]) {
  constexpr uint32_t k_row = k_block_side + 1;
  const float* planes = from == k_no_block ? grid.planes : grid.planes + static_cast<uint64_t>(from) * k_block_floats;
  float* records = grid.nodes + static_cast<uint64_t>(to) * k_block_records * k_record_floats;
  uint32_t counts[3];
  for (int k = 0; k < 3; ++k) counts[k] = beyond[k] != 0 ? 1 : k_block_side;
  for (uint32_t z = 0; z < counts[2]; ++z) {
    for (uint32_t y = 0; y < counts[1]; ++y) {
      const uint32_t row = (z + k_block_side * beyond[2]) * k_row + y + k_block_side * beyond[1];
      float* record = records + (row * k_row + k_block_side * beyond[0]) * k_record_floats;
      const float* node = planes + (z * k_block_side + y) * k_block_side;
      for (uint32_t x = 0; x < counts[0]; ++x, ++node, record += k_record_floats) {
        for (uint32_t c = 0; c < k_record_floats; ++c)
          record[c] = from != k_no_block                         ? node[c * k_block_nodes]
                      : c >= k_node_nearest && c < k_node_number ? k_inert_position
                                                                 : 0.0f;
      }
    }
  }
}

}  // namespace

void motion_join(MotionGrid* grid, uint32_t number, bool is_read) {
  MotionBlock& block = grid->blocks[number];
  // Half of the blocks around it: those behind it. The others find it.
  for (uint32_t side = k_itself + 1; side < k_blocks_around; ++side) {
    const uint32_t next = motion_find(*grid, block.at[0] + static_cast<int32_t>(side % 3) - 1,
                                      block.at[1] + static_cast<int32_t>(side / 3 % 3) - 1,
                                      block.at[2] + static_cast<int32_t>(side / 9) - 1);
    block.around[side] = next;
    if (next != k_no_block) grid->blocks[next].around[k_blocks_around - 1 - side] = number;
  }
  for (uint32_t side = 0; side < 8; ++side) {
    const uint32_t beyond[3] = {side & 1, (side >> 1) & 1, side >> 2};
    const uint32_t next = block.around[k_itself + beyond[0] + 3 * beyond[1] + 9 * beyond[2]];
    if (next == k_no_block && grid->overflowed != 0) block.state |= k_block_incomplete;
    if (is_read) copy_nodes(*grid, next, number, beyond);
  }
}

namespace {

// A block's cells and two more on either side.
constexpr uint32_t k_cells = k_block_cells + 4, k_cells_plane = k_cells * k_cells;

// The counts of a block and of two cells around it.
void collect_counts(const MotionGrid& grid, uint32_t number, uint8_t* cells) {
  const MotionBlock& block = grid.blocks[number];
  for (uint32_t side = 0; side < k_blocks_around; ++side) {
    const int32_t at = static_cast<int32_t>(side), beyond[3] = {at % 3 - 1, at / 3 % 3 - 1, at / 9 - 1};
    const uint32_t next = block.around[side];
    if (next == k_no_block || (grid.blocks[next].state & k_block_holds) == 0) continue;
    uint32_t first[3], many[3], to[3];
    for (int k = 0; k < 3; ++k) {
      first[k] = beyond[k] < 0 ? k_block_cells - 2 : 0;
      many[k] = beyond[k] == 0 ? k_block_cells : 2;
      to[k] = beyond[k] < 0 ? 0 : beyond[k] == 0 ? 2 : k_block_cells + 2;
    }
    const uint8_t* from = grid.counts + static_cast<uint64_t>(next) * k_block_counts + first[0];
    for (uint32_t z = 0; z < many[2]; ++z) {
      for (uint32_t y = 0; y < many[1]; ++y) {
        const uint8_t* row = from + ((first[2] + z) * k_block_cells + first[1] + y) * k_block_cells;
        uint8_t* into = cells + (to[2] + z) * k_cells_plane + (to[1] + y) * k_cells + to[0];
        if (beyond[0] == 0) __builtin_memcpy(into, row, k_block_cells);
        else {
          into[0] = row[0];
          into[1] = row[1];
        }
      }
    }
  }
}

uint8_t mean(uint8_t a, uint8_t b) { return static_cast<uint8_t>((a + b + 1) >> 1); }

// [1 6 1] / 8 along the axis of which two cells are `step` apart, rounded up three times.
__attribute__((noinline)) void smooth_axis(const uint8_t* __restrict from, uint8_t* __restrict to, uint32_t step) {
  for (uint32_t c = 0; c < k_cells_plane * k_cells - 2 * step; ++c)
    to[c + step] = mean(mean(mean(from[c], from[c + 2 * step]), from[c + step]), from[c + step]);
}

// Without the outermost cells. A row's last two bytes are the next row's first.
void store_density(const uint8_t* cells, uint8_t* density) {
  for (uint32_t z = 1; z <= k_density_cells; ++z) {
    for (uint32_t y = 1; y <= k_density_cells; ++y, density += k_density_cells)
      __builtin_memcpy(density, cells + z * k_cells_plane + y * k_cells + 1, k_cells);
  }
}

}  // namespace

void motion_smooth(const MotionGrid& grid, uint32_t number) {
  if ((grid.blocks[number].state & k_block_holds) == 0) return;  // nobody reads it
  alignas(64) uint8_t cells[k_cells_plane * k_cells] = {}, half_done[sizeof cells] = {};
  collect_counts(grid, number, cells);
  smooth_axis(cells, half_done, 1);
  smooth_axis(half_done, cells, k_cells);
  smooth_axis(cells, half_done, k_cells_plane);
  store_density(half_done, density_of(grid, number));
}

void motion_layout(ParticleMotion* m, const sandglass_granular_desc& d, Layout* layout) {
  if (d.grain_capacity == 0) return;
  MotionGrid& grid = m->grid;
  grid.block_capacity = capacity_of(d);
  const uint64_t blocks = grid.block_capacity;
  grid.slot_mask = table_size(grid.block_capacity) - 1;
  m->starts = layout_region<Place>(layout, "granular.motion_starts", d.particle_capacity);
  m->ends = layout_region<Place>(layout, "granular.motion_ends", d.particle_capacity);
  grid.slots = layout_region<uint32_t>(layout, "granular.motion_slots", grid.slot_mask + 1);
  grid.blocks = layout_region<MotionBlock>(layout, "granular.motion_blocks", blocks);
  grid.counts = layout_region<uint8_t>(layout, "granular.grain_counts", blocks * k_block_counts);
  grid.nodes = layout_region<float>(layout, "granular.motion_nodes", blocks * k_block_records * k_record_floats);
}

void motion_planes_layout(ParticleMotion* m, const sandglass_granular_desc& d, Layout* layout) {
  m->grid.planes = layout_region<float>(layout, "planes", uint64_t{capacity_of(d)} * k_block_floats);
}

void motion_configure(ParticleMotion* m, const sandglass_granular_desc& d) {
  m->grid.spacing = k_spacing_radii * d.particle_radius;
  m->grid.inverse_spacing = 1.0f / m->grid.spacing;
  m->grid.support = k_support_radii * d.particle_radius;
  m->grid.reach = k_reach_radii * d.particle_radius;
  const float wider = k_support_radii / k_reach_radii;
  m->grid.gain = wider * wider * wider;
}

// Seconds since the last sweep's snapshot, and since that of the sweep under way.
static void since_snapshots(const Granular& g, float since[2]) {
  const bool under_way = g.sweep.phase != SweepPhase::idle && g.sweep.phase != SweepPhase::snapshot;
  since[0] = static_cast<float>(g.time.grain_lag);
  since[1] = under_way ? static_cast<float>(g.time.grain_lag - g.sweep.time) : since[0];
}

void motion_add(const ParticleMotion& m, const Granular& g, uint32_t number, const float position[3],
                const float velocity[3]) {
  if (g.desc.grain_capacity == 0) return;
  float since[2];
  since_snapshots(g, since);
  for (int k = 0; k < 3; ++k) {
    m.starts[number].position[k] = position[k] - since[0] * velocity[k];
    m.ends[number].position[k] = position[k] - since[1] * velocity[k];
  }
}

void motion_fall(const ParticleMotion& m, const Granular& g, uint32_t first) {
  if (g.desc.grain_capacity == 0) return;
  float since[2];
  since_snapshots(g, since);
  for (uint32_t i = first; i < g.particles.count; ++i) {
    const uint32_t number = number_of(g.particles.records[0][i]);
    for (int k = 0; k < 3; ++k) {
      m.starts[number].position[k] += 0.5f * since[0] * since[0] * g.gravity[k];
      m.ends[number].position[k] += 0.5f * since[1] * since[1] * g.gravity[k];
    }
  }
}

void motion_carry(const ParticleMotion& m, const Granular& g, const Particle* records, uint32_t which,
                  const RigidMotion& motion) {
  if (g.desc.grain_capacity == 0) return;
  const RigidMotion carrier = motion;
  Place* const places = sweep_has_snapshot(g) ? m.ends : m.starts;
  for_bits(which, records, [&](const Particle* p) { carrier.move(places[number_of(*p)].position); });
}

void motion_begin_here(const ParticleMotion& m, const Granular& g) {
  if (g.desc.grain_capacity == 0) return;
  for (uint32_t i = 0; i < g.particles.count; ++i) {
    const Particle& p = g.particles.records[0][i];
    for (int k = 0; k < 3; ++k) m.starts[number_of(p)].position[k] = p.position[k];
  }
}

void motion_complete(ParticleMotion* m) {
  Place* starts = m->ends;
  m->ends = m->starts;
  m->starts = starts;
}

float motion_free_fall(const float at_end[3], const float mean[3], const float gravity[3], float time) {
  // Shares of what gravity adds, squared: all of it up to 0.2 off, nothing beyond 0.6.
  constexpr float k_all = 0.04f, k_nothing = 0.36f;
  float off = 0.0f, added = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const float half = 0.5f * time * gravity[k], d = at_end[k] - mean[k] - half;
    off += d * d;
    added += half * half;
  }
  const float left = k_nothing * added - off;
  if (!(left > 0.0f)) return 0.0f;  // without gravity nothing falls
  const float t = left / ((k_nothing - k_all) * added);
  return t < 1.0f ? t * t * (3.0f - 2.0f * t) : 1.0f;
}

void motion_forget(ParticleMotion* m) { m->movers = 0; }

void motion_begin(ParticleMotion* m, const Granular& g) {
  // Somewhere else in every sweep, so that no cell's faces show in the sand.
  uint64_t bits;
  __builtin_memcpy(&bits, &g.time.simulated, sizeof bits);
  for (float& o : m->grid.origin) {
    bits = mix_bits(bits + k_random_step);
    o = m->grid.spacing * static_cast<float>(bits >> 40) * 0x1p-22f;  // up to a block
  }
  m->grid.block_count = 0;
  m->grid.overflowed = 0;
  m->moved = m->wanted = m->read = {};
  m->all_moved = m->movers > g.particles.count / 2;
  m->wanted_groups = m->movers = 0;
  for (PlaceOfBlock& recent : m->recent) recent.at[0] = INT32_MIN;
  for (int k = 0; k < 3; ++k) {
    m->low[k] = INT32_MAX;
    m->high[k] = INT32_MIN;
  }
}

// Empties the part of the table of blocks that goes with the items from `begin` to `end` of `all`.
static void clear_slots(MotionGrid* grid, uint32_t begin, uint32_t end, uint32_t all) {
  const uint64_t slots = uint64_t{grid->slot_mask} + 1;
  for (uint64_t slot = slots * begin / all; slot < slots * end / all; ++slot) grid->slots[slot] = 0;
}

// Cells that read a node which the particle reaches, as scatter_motion finds its nodes.
static void note_mover(ParticleMotion* m, const Particle& p, float time) {
  const float reach = m->grid.reach * m->grid.inverse_spacing;
  int32_t first[3], last[3];
  for (int k = 0; k < 3; ++k) {
    const float scaled = (p.position[k] - time * p.velocity[k] - m->grid.origin[k]) * m->grid.inverse_spacing;
    first[k] = floor_whole(scaled - reach);
    last[k] = floor_whole(scaled + reach);
    m->low[k] = first[k] < m->low[k] ? first[k] : m->low[k];
    m->high[k] = last[k] > m->high[k] ? last[k] : m->high[k];
  }
  for (int32_t z = first[2] >> k_cell_shift; z <= last[2] >> k_cell_shift; ++z)
    for (int32_t y = first[1] >> k_cell_shift; y <= last[1] >> k_cell_shift; ++y)
      for (int32_t x = first[0] >> k_cell_shift; x <= last[0] >> k_cell_shift; ++x) place_put(&m->moved, x, y, z);
}

bool motion_measure(ParticleMotion* m, const Granular& g, uint32_t* cursor) {
  const uint32_t all = g.sweep.particles, begin = *cursor;
  const uint32_t end = all - begin < g.unit ? all : begin + g.unit;
  const float inverse = static_cast<float>(1.0 / g.sweep.time);
  for (uint32_t i = begin; i < end; ++i) {
    Particle* p = &g.grains.snapshot.particles[i];
    const Place& start = m->starts[number_of(*p)];
    Place* here = &m->ends[number_of(*p)];
    float mean[3];
    for (int k = 0; k < 3; ++k) {
      here->position[k] = p->position[k];
      mean[k] = (p->position[k] - start.position[k]) * inverse;
    }
    set_free_fall(p, motion_free_fall(p->velocity, mean, g.gravity, static_cast<float>(g.sweep.time)));
    for (int k = 0; k < 3; ++k) p->velocity[k] = mean[k];
    if (in_body(*p) || (mean[0] == 0.0f && mean[1] == 0.0f && mean[2] == 0.0f)) continue;
    ++m->movers;
    if (!m->all_moved) note_mover(m, *p, static_cast<float>(g.sweep.time));
  }
  clear_slots(&m->grid, begin, end, all);
  *cursor = end;
  return end >= all;
}

// What a phase has left is cut into equal units: a short last unit would look dear for its items.
static uint32_t next_part(uint32_t left, uint32_t limit) {
  if (left == 0) return 0;
  const uint32_t parts = (left + limit - 1) / limit, part = (left + parts - 1) / parts;
  return part;
}

// Things that the next unit handles: particles, blocks or grains.
static uint32_t motion_part(const Granular& g, uint32_t each) {
  const uint32_t limit = g.unit < each ? 1 : g.unit / each, cursor = g.sweep.cursor;
  if (g.sweep.phase == SweepPhase::scatter) return next_part(g.sweep.particles - cursor, limit);
  if (g.sweep.phase != SweepPhase::count) return next_part(g.motion.grid.block_count - cursor, limit);
  const uint32_t groups = (g.grains.count - cursor + k_lane_group - 1) / k_lane_group;
  return next_part(groups, limit < k_lane_group ? 1 : limit / k_lane_group) * k_lane_group;
}

static uint32_t items_each(SweepPhase phase) {
  if (phase == SweepPhase::scatter) return k_items_per_particle;
  if (phase == SweepPhase::join) return k_items_per_join;
  return phase == SweepPhase::smooth ? k_items_per_smooth : 1;
}

uint32_t motion_items(const Granular& g) {
  const uint32_t each = items_each(g.sweep.phase), part = motion_part(g, each);
  return part == 0 ? 1 : part * each;
}

uint64_t motion_items_of_a_sweep(const Granular& g, bool even) {
  if (g.grain_sleep.group_count == 0 && g.grain_sleep.still_groups != 0) return 0;  // the last one needed none
  const uint64_t blocks = g.motion.grid.block_count;
  return uint64_t{g.particles.count} * k_items_per_particle + blocks * k_items_per_join +
         (even ? blocks * k_items_per_smooth + g.grains.count : 0);
}

static bool is_read(const ParticleMotion& m, uint32_t number) {
  const int32_t* at = m.grid.blocks[number].at;
  return m.all_wanted || place_in(m.read, at[0], at[1], at[2]);
}

bool motion_run_scatter(ParticleMotion* m, const Granular& g, uint32_t* cursor) {
  const uint32_t all = g.sweep.particles, begin = *cursor, end = begin + motion_part(g, k_items_per_particle);
  const ScatterMotionArgs args = {&m->grid,
                                  g.grains.snapshot.particles,
                                  end,
                                  static_cast<float>(g.sweep.time),
                                  m->all_wanted ? nullptr : &m->wanted,
                                  m->all_wanted ? nullptr : &m->read};
  uint32_t unused = 0;
  g.kernels->scatter_motion(&args, begin, end, &unused);
  *cursor = end;
  return end >= all;
}

bool motion_run_count(ParticleMotion* m, const Granular& g, uint32_t* cursor) {
  const uint32_t all = g.grains.count, begin = *cursor, end = begin + motion_part(g, 1);
  const CountGrainsArgs args = {&m->grid, g.grains.records, all};
  uint32_t unused = 0;
  g.kernels->count_grains(&args, begin, end, &unused);
  *cursor = end;
  return end >= all;
}

bool motion_run_smooth(ParticleMotion* m, const Granular& g, uint32_t* cursor) {
  const uint32_t end = *cursor + motion_part(g, k_items_per_smooth);
  for (uint32_t number = *cursor; number < end; ++number)
    if (is_read(*m, number)) motion_smooth(m->grid, number);
  *cursor = end;
  return end >= m->grid.block_count;
}

bool motion_run_join(ParticleMotion* m, const Granular& g, uint32_t* cursor) {
  const uint32_t end = *cursor + motion_part(g, k_items_per_join);
  for (uint32_t number = *cursor; number < end; ++number) motion_join(&m->grid, number, is_read(*m, number));
  *cursor = end;
  return end >= m->grid.block_count;
}

bool motion_near(const ParticleMotion& m, const Granular& g, uint32_t group, const Sleeper& tile) {
  if (m.all_moved) return true;
  if (m.low[0] > m.high[0]) return false;  // nothing moves
  for (int k = 0; k < 3; ++k) {
    const float middle = (tile.position[k] - m.grid.origin[k]) * m.grid.inverse_spacing;
    const float radius = tile.radius * m.grid.inverse_spacing + 1.0f;
    if (middle + radius < static_cast<float>(m.low[k]) || middle - radius > static_cast<float>(m.high[k])) return false;
  }
  const uint32_t first = group * k_lane_group;
  for (uint32_t i = first; i < first + k_lane_group && i < g.grains.count; ++i) {
    int32_t cell[3];
    for (int k = 0; k < 3; ++k)
      cell[k] =
          floor_whole((g.grains.records[i].position[k] - m.grid.origin[k]) * m.grid.inverse_spacing) >> k_cell_shift;
    if (place_in(m.moved, cell[0], cell[1], cell[2])) return true;
  }
  return false;
}

// If more groups than this are refined, looking up which blocks they need costs more than it saves.
static uint32_t wanted_max(const Granular& g) { return g.grains.count / (4 * k_lane_group); }

void motion_begin_wanting(ParticleMotion* m, const Granular& g) {
  m->all_wanted = g.grain_sleep.group_count > wanted_max(g);
}

void motion_want(ParticleMotion* m, const Granular& g, uint32_t group) {
  if (m->all_wanted) return;
  if (++m->wanted_groups > wanted_max(g)) {
    m->all_wanted = true;
    return;
  }
  const uint32_t first = group * k_lane_group;
  for (uint32_t i = first; i < first + k_lane_group && i < g.grains.count; ++i) {
    int32_t at[3];
    for (int k = 0; k < 3; ++k)
      at[k] = floor_whole((g.grains.records[i].position[k] - m->grid.origin[k]) * m->grid.inverse_spacing * 0.25f);
    int32_t* recent = m->recent[(at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2].at;
    if (at[0] == recent[0] && at[1] == recent[1] && at[2] == recent[2]) continue;
    for (int k = 0; k < 3; ++k) recent[k] = at[k];
    for (int32_t z = at[2] - 1; z <= at[2] + 1; ++z)
      for (int32_t y = at[1] - 1; y <= at[1] + 1; ++y)
        for (int32_t x = at[0] - 1; x <= at[0] + 1; ++x) {
          place_put(&m->wanted, x, y, z);
          if (x >= at[0] && y >= at[1] && z >= at[2]) place_put(&m->read, x, y, z);
        }
  }
}

}  // namespace sandglass
