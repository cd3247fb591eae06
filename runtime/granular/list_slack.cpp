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

// Blocks along each axis, as the logarithm.
struct Blocks {
  uint32_t bits[3];
  uint32_t at(uint32_t x, uint32_t y, uint32_t z) const { return (((z << bits[1]) | y) << bits[0]) | x; }
  uint32_t count() const { return 1u << (bits[0] + bits[1] + bits[2]); }
  // Place of a block along an axis.
  uint32_t place(uint32_t block, uint32_t axis) const {
    const uint32_t below = axis == 0 ? 0 : axis == 1 ? bits[0] : bits[0] + bits[1];
    return block >> below & ((1u << bits[axis]) - 1);
  }
  uint32_t next(uint32_t place, uint32_t axis) const { return (place + 1) & ((1u << bits[axis]) - 1); }
};

Blocks blocks_of(const Grid& grid) { return {{grid.bits[0] - 1, grid.bits[1] - 1, grid.bits[2] - 1}}; }

// Where the particles of one block will be after the sub-step that is about to begin, from where the lists saw them.
// Returns how many they are.
uint32_t gather_block(Granular* g, const Blocks& blocks, uint32_t block) {
  const Neighbours& n = g->neighbours;
  const Grid& grid = n.sort.grid;
  const float dt = g->substep.length;
  const uint32_t x = 2 * blocks.place(block, 0), y = 2 * blocks.place(block, 1), z = 2 * blocks.place(block, 2);
  // The boundary stands still, and so may every block be beside it.
  DisplacementBox box = g->boundary.count != 0 ? k_still : k_empty;
  uint32_t count = 0;
  for (uint32_t row = 0; row < 4; ++row) {
    const uint32_t cell = (((z + row / 2) << grid.bits[1] | (y + row % 2)) << grid.bits[0]) | x;
    const uint32_t begin = grid.starts[cell], end = grid.starts[cell + 2];
    count += end - begin;
    for (uint32_t i = begin; i < end; ++i) {
      const Particle& p = g->particles.records[0][i];
      const Quad seen = {n.positions[0][i], n.positions[1][i], n.positions[2][i], 0.0f};
      const Quad moved = (three_of(p.position) - seen) + dt * three_of(p.velocity);
      include(&box, moved, moved);
    }
  }
  g->slack.blocks[block] = box;
  if (!is_empty(box)) include(&g->slack.all, box.low, box.high);
  return count;
}

// The window of a block: itself and the next ones along every axis.
void measure_window(ListSlack* s, const Blocks& blocks, uint32_t block) {
  uint32_t here[3], next[3];
  for (uint32_t k = 0; k < 3; ++k) here[k] = blocks.place(block, k), next[k] = blocks.next(here[k], k);
  DisplacementBox window = k_empty;
  for (uint32_t corner = 0; corner < 8; ++corner) {
    const DisplacementBox& box =
        s->blocks[blocks.at((corner & 1) != 0 ? next[0] : here[0], (corner & 2) != 0 ? next[1] : here[1],
                            (corner & 4) != 0 ? next[2] : here[2])];
    include(&window, box.low, box.high);
  }
  if (is_empty(window)) return;
  const float wide2 = diagonal2(window);
  s->widest2 = wide2 > s->widest2 ? wide2 : s->widest2;
}

}  // namespace

void list_slack_layout(ListSlack* s, const CellSort& sort, Layout* layout) {
  s->blocks = layout_region<DisplacementBox>(layout, "granular.displacements", sort.cells_max / 8);
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
  const uint32_t end = blocks.count();
  uint32_t& cursor = g->substep.cursor;
  for (uint32_t done = 0; cursor < end && done < g->unit; ++cursor, ++done) {
    if (s.step == k_gather) done += gather_block(g, blocks, cursor);
    else measure_window(&s, blocks, cursor);
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
