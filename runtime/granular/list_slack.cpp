#include "runtime/granular/list_slack.h"

#include "runtime/granular/granular.h"

namespace sandglass {

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

float diagonal2(const DisplacementBox& box) {
  const Quad wide = box.high - box.low, squares = wide * wide;
  return squares[0] + squares[1] + squares[2];
}

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
uint32_t gather_row(Granular* g, const Blocks& blocks, uint32_t row) {
  const Neighbours& n = g->neighbours;
  const Grid& grid = n.sort.grid;
  const float dt = g->substep.length;
  const uint32_t y = row & ((1u << blocks.bits[1]) - 1), z = row >> blocks.bits[1];
  // The boundary stands still, and so may every block be beside it.
  const DisplacementBox without = g->boundary.count != 0 ? k_still : k_empty;
  DisplacementBox* const boxes = g->slack.blocks + row * blocks.row_length();
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
        const Particle& p = g->particles.records[0][i];
        if (k_some_departed && has_departed(p)) continue;
        const Quad seen = {n.positions[0][i], n.positions[1][i], n.positions[2][i], 0.0f};
        const Quad moved = (three_of(p.position) - seen) + dt * three_of(p.velocity);
        include(&box, moved, moved);
      }
      boxes[x] = box;
      include(&g->slack.all, box.low, box.high);
    }
  }
  g->slack.counts[row] = count;
  return count;
}

// The windows of a row of blocks. That of a block is itself and the next ones along every axis.
void measure_row(ListSlack* s, const Blocks& blocks, uint32_t row) {
  const uint32_t y = row & ((1u << blocks.bits[1]) - 1), z = row >> blocks.bits[1];
  const uint32_t rows[4] = {row, blocks.row(y + 1, z), blocks.row(y, z + 1), blocks.row(y + 1, z + 1)};
  const DisplacementBox* boxes[4];
  uint32_t count = 0;
  for (int k = 0; k < 4; ++k) boxes[k] = s->blocks + rows[k] * blocks.row_length(), count += s->counts[rows[k]];
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
    const float wide2 = diagonal2(next);
    if (!is_empty(next) && wide2 > s->widest2) s->widest2 = wide2;
    next = here;
  }
}

}  // namespace

void list_slack_layout(ListSlack* s, const CellSort& sort, Layout* layout) {
  s->blocks = layout_region<DisplacementBox>(layout, "granular.displacements", sort.cells_max / 8);
  s->counts = layout_region<uint32_t>(layout, "granular.displaced", sort.cells_max / 16);
}

void list_slack_begin(ListSlack* s) {
  s->step = k_gather;
  s->widest2 = 0.0f;
  s->all = k_empty;
}

bool list_slack_run(Granular* g, float* metres) {
  ListSlack& s = g->slack;
  const Grid& grid = g->neighbours.sort.grid;
  const Blocks blocks = blocks_of(grid);
  const uint32_t end = blocks.rows();
  uint32_t& cursor = g->substep.cursor;
  for (uint32_t done = 0; cursor < end && done < g->unit; ++cursor) {
    done += blocks.row_length();
    if (s.step == k_gather)
      done += g->departed.count != 0 ? gather_row<true>(g, blocks, cursor) : gather_row<false>(g, blocks, cursor);
    else measure_row(&s, blocks, cursor);
  }
  if (cursor < end) return false;
  cursor = 0;
  if (s.step++ != k_widest) return false;
  const float reach = neighbours_reach(*g), diameter = 2.0f * g->desc.particle_radius;
  const float near = reach - diameter - __builtin_sqrtf(s.widest2);
  const float far = 2.0f * reach - diameter - __builtin_sqrtf(diagonal2(s.all));
  *metres = near < far ? near : far;
  return true;
}

}  // namespace sandglass
