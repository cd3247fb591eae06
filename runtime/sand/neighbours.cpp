// Who may touch, and how long that stays true: the neighbour lists, and a measurement of what they are still good for.
#include "runtime/sand/granular.h"

namespace sandglass {

// ---- ListSlack

namespace {

enum : uint32_t { k_gather, k_widest };

// Wide enough to be far from every displacement.
constexpr float k_huge = 3e38f;
constexpr DisplacementBox k_empty = {{k_huge, k_huge, k_huge, 0.0f}, {-k_huge, -k_huge, -k_huge, 0.0f}};
constexpr DisplacementBox k_still = {};

void include(DisplacementBox* box, Quad low, Quad high) {
  box->low = low < box->low ? low : box->low;
  box->high = high > box->high ? high : box->high;
}

bool is_empty(const DisplacementBox& box) { return box.low[0] > box.high[0]; }

// The first three of four floats, and 0.
Quad three_of(const float* four) {
  typedef uint32_t Bits __attribute__((vector_size(16)));
  constexpr Bits k_three = {~0u, ~0u, ~0u, 0};
  Bits bits;
  __builtin_memcpy(&bits, four, sizeof bits);
  bits &= k_three;
  Quad quad;
  __builtin_memcpy(&quad, &bits, sizeof quad);
  return quad;
}

// Blocks along each axis, as the logarithm. They are taken in rows along x.
struct Blocks {
  uint32_t bits[3];
  uint32_t row_length() const { return 1u << bits[0]; }
  uint32_t rows() const { return 1u << (bits[1] + bits[2]); }
  uint32_t row(uint32_t y, uint32_t z) const {
    return (z & ((1u << bits[2]) - 1)) << bits[1] | (y & ((1u << bits[1]) - 1));
  }
};

Blocks blocks_of(const Grid& grid) { return {{grid.bits[0] - 1, grid.bits[1] - 1, grid.bits[2] - 1}}; }

// Where the particles of one row of blocks will be after the sub-step that is about to begin, from where the lists saw
// them. Returns how many they are. What has departed is in no window.
template <bool k_some_departed>
uint32_t gather_row(ListSlack* s, const Granular& g, const Blocks& blocks, uint32_t row) {
  const Neighbours& n = g.neighbours;
  const Grid& grid = n.sort.grid;
  const float dt = g.substep.length;
  const uint32_t y = row & ((1u << blocks.bits[1]) - 1), z = row >> blocks.bits[1];
  // The boundary stands still, and so may every block be beside it.
  const DisplacementBox without = g.boundary.count != 0 ? k_still : k_empty;
  DisplacementBox* const boxes = s->blocks + row * blocks.row_length();
  for (uint32_t x = 0; x < blocks.row_length(); ++x) boxes[x] = without;
  uint32_t count = 0;
  for (uint32_t cell_row = 0; cell_row < 4; ++cell_row) {
    const uint32_t cells = ((2 * z + cell_row / 2) << grid.bits[1] | (2 * y + cell_row % 2)) << grid.bits[0];
    const uint32_t* const starts = grid.starts + cells;
    count += starts[2 * blocks.row_length()] - starts[0];
    if (starts[2 * blocks.row_length()] == starts[0]) continue;
    for (uint32_t x = 0; x < blocks.row_length(); ++x) {
      const uint32_t begin = starts[2 * x], end = starts[2 * x + 2];
      if (begin == end) continue;
      DisplacementBox box = boxes[x];
      for (uint32_t i = begin; i < end; ++i) {
        const Particle& p = g.particles.records[0][i];
        if (k_some_departed && has_departed(p)) continue;
        const Quad seen = {n.positions[0][i], n.positions[1][i], n.positions[2][i], 0.0f};
        const Quad moved = (three_of(p.position) - seen) + dt * three_of(p.velocity);
        include(&box, moved, moved);
      }
      boxes[x] = box;
      include(&s->all, box.low, box.high);
    }
  }
  s->counts[row] = count;
  return count;
}

// The windows of a row of blocks. That of a block is itself and the next ones along every axis.
void measure_row(ListSlack* s, const Blocks& blocks, uint32_t row) {
  const uint32_t y = row & ((1u << blocks.bits[1]) - 1), z = row >> blocks.bits[1];
  const uint32_t rows[4] = {row, blocks.row(y + 1, z), blocks.row(y, z + 1), blocks.row(y + 1, z + 1)};
  const DisplacementBox* boxes[4];
  uint32_t count = 0;
  for (int k = 0; k < 4; ++k) {
    boxes[k] = s->blocks + rows[k] * blocks.row_length();
    count += s->counts[rows[k]];
  }
  if (count == 0) return;
  const auto column = [&](uint32_t x) {  // of the four rows
    DisplacementBox box = boxes[0][x];
    for (int k = 1; k < 4; ++k) include(&box, boxes[k][x].low, boxes[k][x].high);
    return box;
  };
  DisplacementBox next = column(0);
  for (uint32_t x = blocks.row_length(); x-- > 0;) {  // beyond the last block comes the first
    const DisplacementBox here = column(x);
    include(&next, here.low, here.high);
    const float wide2 = square_of(next.high - next.low);
    if (!is_empty(next) && wide2 > s->widest2) s->widest2 = wide2;
    next = here;
  }
}

}  // namespace

static void list_slack_layout(ListSlack* s, const CellSort& sort, Layout* layout) {
  s->blocks = layout_region<DisplacementBox>(layout, "granular.displacements", sort.cells_max / 8);
  s->counts = layout_region<uint32_t>(layout, "granular.displaced", sort.cells_max / 16);
}

static void list_slack_begin(ListSlack* s) {
  s->step = k_gather;
  s->widest2 = 0.0f;
  s->all = k_empty;
}

// Measuring, in units. True once it is done: *metres may then still be closed.
static bool list_slack_run(ListSlack* slack, const Granular& g, uint32_t* cursor, float* metres) {
  ListSlack& s = *slack;
  const Grid& grid = g.neighbours.sort.grid;
  const Blocks blocks = blocks_of(grid);
  const uint32_t end = blocks.rows();
  for (uint32_t done = 0; *cursor < end && done < g.unit; ++*cursor) {
    done += blocks.row_length();
    if (s.step == k_gather)
      done += g.departed.count != 0 ? gather_row<true>(slack, g, blocks, *cursor)
                                    : gather_row<false>(slack, g, blocks, *cursor);
    else measure_row(&s, blocks, *cursor);
  }
  if (*cursor < end) return false;
  *cursor = 0;
  if (s.step++ != k_widest) return false;
  const float reach = neighbours_reach(g), diameter = 2.0f * g.desc.particle_radius;
  const float near = reach - diameter - __builtin_sqrtf(s.widest2);
  const float far = 2.0f * reach - diameter - __builtin_sqrtf(square_of(s.all.high - s.all.low));
  *metres = near < far ? near : far;
  return true;
}

// ---- Neighbours

namespace {

// Pairs that were closer than this when the lists were built come first in them, in radii: contacts, and those of the
// next few sub-steps.
constexpr float k_near_radii = 2.1f;

// A bound on how far a particle strays from the common motion in a sub-step: half the diagonal of the box that holds
// all displacements. Where something stands still, there is no common motion, and the box is made to hold its place
// too.
float spread_of(const Granular& g, const ContactExtent& e) {
  if (e.displacement_low[0] > e.displacement_high[0]) return 0.0f;  // all that moved has departed
  float sum = 0.0f;
  for (int k = 0; k < 3; ++k) {
    float half = 0.5f * (e.displacement_high[k] - e.displacement_low[k]);
    if (g.boundary.count != 0 || g.sleep.awake_count < g.particles.count) {
      const float a = __builtin_fabsf(e.displacement_low[k]), b = __builtin_fabsf(e.displacement_high[k]);
      half = a > b ? a : b;
    }
    sum += half * half;
  }
  return __builtin_sqrtf(sum);
}

ListArgs list_args(const Granular& g) {
  const Neighbours& n = g.neighbours;
  const float reach = neighbours_reach(g);
  ListArgs args = {};
  args.grid = n.sort.grid;
  args.boundary_grid = g.boundary.sort.grid;
  for (int k = 0; k < 3; ++k) {
    args.positions[k] = n.positions[k];
    args.boundary_positions[k] = g.boundary.positions[k];
  }
  args.boundary_count = g.boundary.count;
  args.boundary_first = g.particles.rows;
  args.inert = g.particles.inert;
  args.reach_squared = reach * reach;
  const float near = k_near_radii * g.desc.particle_radius;
  args.near_squared = near * near;
  args.lists = n.lists;
  args.counts = n.counts;
  args.near_counts = n.near_counts;
  args.halves = n.halves ? 1 : 0;
  return args;
}

// Lists for the groups that hold an awake particle.
struct ListTask {
  const Granular* g;
  ListArgs args;
  uint32_t dropped[k_pieces], awake[k_pieces];
  Bounds resting[k_pieces];

  void run(uint32_t piece, uint32_t begin, uint32_t end) {
    uint32_t from = begin, lost = 0, lanes = 0;
    for (uint32_t i = begin; i < end; i += k_lane_group) {
      const bool asleep = sleep_sort_group(*g, i / k_lane_group, &lanes, &resting[piece]),
                 listed = !asleep || args.halves != 0;
      g->neighbours.listed[i / k_lane_group] = listed ? 1 : 0;
      if (listed) continue;
      if (from < i) {
        g->kernels->neighbour_lists(&args, from, i, &lost);
        dropped[piece] += lost;
      }
      from = i + k_lane_group;
    }
    if (from < end) {
      g->kernels->neighbour_lists(&args, from, end, &lost);
      dropped[piece] += lost;
    }
    awake[piece] = lanes;
  }
};

}  // namespace

void neighbours_layout(Neighbours* n, uint32_t rows, Layout* layout) {
  const char* const axes[3] = {"granular.sorted_x", "granular.sorted_y", "granular.sorted_z"};
  for (int k = 0; k < 3; ++k) n->positions[k] = layout_region<float>(layout, axes[k], rows + k_array_slack);
  n->lists = layout_region<uint32_t>(layout, "granular.lists", static_cast<uint64_t>(rows) * k_list_slots);
  n->counts = layout_region<uint8_t>(layout, "granular.list_counts", rows);
  n->near_counts = layout_region<uint8_t>(layout, "granular.near_counts", rows);
  n->listed = layout_region<uint8_t>(layout, "granular.listed_groups", rows / k_lane_group);
  cell_sort_layout(&n->sort, layout, "granular.cells", "granular.cell_keys", rows, 4ull * rows);
  list_slack_layout(&n->measurement, n->sort, layout);
}

void neighbours_reset(Neighbours* n, float substep) {
  neighbours_forget(n, substep);
  n->builds_per_substep = 0.25f;
}

void neighbours_forget(Neighbours* n, float substep) {
  n->valid = false;
  n->slack = n->last_spread = n->worn = 0.0f;
  n->measured = false;
  n->last_substep = substep;
}

float neighbours_reach(const Granular& g) { return (2.0f + g.desc.list_margin) * g.desc.particle_radius; }

bool neighbours_stale(const Granular& g, uint32_t level, float substep) {
  const Neighbours& n = g.neighbours;
  // The pass looks ahead by one sub-step of about the last one's motion. A measurement has done that already.
  const float extra = (k_ladder[level].list_reuse - 1.0f) * g.desc.list_margin * g.desc.particle_radius;
  const float ahead = n.measured ? 0.0f : 2.0f * n.last_spread * (substep / n.last_substep);
  return !n.valid || ahead > n.slack + extra;
}

bool neighbours_doubt(const Granular& g) { return g.neighbours.valid && !g.neighbours.measured; }

void neighbours_begin_measuring(Neighbours* n) { list_slack_begin(&n->measurement); }

bool neighbours_run_measuring(Neighbours* n, const Granular& g, uint32_t* cursor) {
  if (!list_slack_run(&n->measurement, g, cursor, &n->slack)) return false;
  n->measured = true;
  return true;
}

void neighbours_begin_sort(Neighbours* n, const Granular& g) {
  // A sleeper has no list that could hold its pairs; and the source's passes need all neighbours of a particle.
  n->halves =
      solves_pairs(g) && g.desc.reference.stabilisation_iterations == 0 && g.sleep.awake_count == g.particles.count;
  n->worn = 0.0f;
  cell_sort_begin(&n->sort, neighbours_reach(g), g.particles.low, g.particles.high, 2);
}

bool neighbours_run_sort(Neighbours* n, const Granular& g) {
  const Particles& p = g.particles;
  const SortTarget target = {as_records(p.records[1]), {n->positions[0], n->positions[1], n->positions[2]}, false};
  cell_sort_run(&n->sort, *g.kernels, as_records(p.records[0]), p.count, g.unit, target);
  return n->sort.phase == k_sort_done;
}

bool neighbours_run_lists(Neighbours* n, const Granular& g, uint32_t* cursor, ListsSeen* seen) {
  ListTask task = {&g, list_args(g), {}, {}, {}};
  for (Bounds& resting : task.resting) resting = k_nowhere;
  const uint32_t count = g.particles.count, begin = *cursor;
  const uint32_t end = count - begin < g.unit ? count : begin + g.unit;
  granular_split(g, begin, end, &task);
  *seen = {0, 0, k_nowhere};
  for (const uint32_t dropped : task.dropped) seen->dropped += dropped;
  for (const uint32_t awake : task.awake) seen->awake += awake;
  for (const Bounds& resting : task.resting) bounds_join(&seen->resting, resting);
  *cursor = end;
  if (end < count) return false;
  n->valid = true;
  n->slack = g.desc.list_margin * g.desc.particle_radius - n->worn;
  n->worn = 0.0f;
  return true;
}

void neighbours_invalidate(Neighbours* n) { n->valid = false; }

uint32_t neighbours_build(const Granular& g, uint32_t begin, uint32_t end) {
  ListArgs args = list_args(g);
  args.halves = 0;
  uint32_t dropped = 0;
  g.kernels->neighbour_lists(&args, begin, end, &dropped);
  return dropped;
}

uint32_t neighbours_build_group(const Granular& g, uint32_t group) {
  const uint32_t begin = group * k_lane_group, left = g.particles.count - begin;
  g.neighbours.listed[group] = 1;
  return neighbours_build(g, begin, begin + (left < k_lane_group ? left : k_lane_group));
}

const uint32_t* neighbours_of(const Granular& g, uint32_t i, uint32_t* count) {
  const Neighbours& n = g.neighbours;
  // A whole list in place of half of it changes no pairs: see colour_row.
  if (n.halves) neighbours_build(g, i, i + 1);
  *count = n.counts[i];
  return n.lists + static_cast<uint64_t>(i) * k_list_slots;
}

void neighbours_wear(Neighbours* n, const Granular& g) {
  n->last_spread = spread_of(g, g.contacts.extent);
  n->last_substep = g.substep.length;
  n->slack -= 2.0f * n->last_spread;
  n->measured = false;
}

void neighbours_carried(Neighbours* n, float metres) {
  n->slack -= metres;
  n->worn += metres;
  n->measured = false;
}

void neighbours_stand(Neighbours* n) { n->last_spread = 0.0f; }

void neighbours_restore(Neighbours* n, const SavedScene& s) { n->builds_per_substep = s.state.builds_per_substep; }

void neighbours_learn(Neighbours* n, uint32_t builds, uint32_t substeps) {
  if (substeps == 0) return;
  const float fresh = static_cast<float>(builds) / static_cast<float>(substeps);
  n->builds_per_substep += 0.25f * (fresh - n->builds_per_substep);
}

void neighbours_seal(const Neighbours& n, const Particles& p) {
  for (uint32_t row = p.count; row < p.rows && row < p.count + k_array_slack; ++row) {
    n.counts[row] = 0;
    for (uint32_t s = 0; s < k_list_slots; ++s) n.lists[static_cast<uint64_t>(row) * k_list_slots + s] = p.inert;
  }
}

}  // namespace sandglass
