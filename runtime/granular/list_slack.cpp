#include "runtime/granular/list_slack.h"

#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

enum : uint32_t { k_clear, k_gather, k_spread, k_widest };

// As many cells are looked at for what one particle costs.
constexpr uint32_t k_cells_per_item = 8;

constexpr DisplacementBox k_empty = {{3e38f, 3e38f, 3e38f}, {-3e38f, -3e38f, -3e38f}};

void include(DisplacementBox* box, const DisplacementBox& other) {
  for (int k = 0; k < 3; ++k) {
    box->low[k] = other.low[k] < box->low[k] ? other.low[k] : box->low[k];
    box->high[k] = other.high[k] > box->high[k] ? other.high[k] : box->high[k];
  }
}

float diagonal2(const DisplacementBox& box) {
  float sum = 0.0f;
  for (int k = 0; k < 3; ++k) sum += (box.high[k] - box.low[k]) * (box.high[k] - box.low[k]);
  return sum;
}

// Blocks along each axis, as the logarithm.
struct Blocks {
  uint32_t bits[3];
  uint32_t at(uint32_t x, uint32_t y, uint32_t z) const { return (((z << bits[1]) | y) << bits[0]) | x; }
  uint32_t count() const { return 1u << (bits[0] + bits[1] + bits[2]); }
};

Blocks blocks_of(const Grid& grid) { return {{grid.bits[0] - 1, grid.bits[1] - 1, grid.bits[2] - 1}}; }

// Where the particles of one cell will be after the sub-step that is about to begin, from where the lists saw them.
void gather_cell(Granular* g, const Blocks& blocks, uint32_t cell) {
  const Neighbours& n = g->neighbours;
  const Grid& grid = n.sort.grid;
  const uint32_t begin = grid.starts[cell], end = grid.starts[cell + 1];
  if (begin == end) return;
  const float dt = g->substep.length;
  DisplacementBox box = k_empty;
  for (uint32_t i = begin; i < end; ++i) {
    const Particle& p = g->particles.records[0][i];
    for (int k = 0; k < 3; ++k) {
      const float d = (p.position[k] - n.positions[k][i]) + dt * p.velocity[k];
      box.low[k] = d < box.low[k] ? d : box.low[k];
      box.high[k] = d > box.high[k] ? d : box.high[k];
    }
  }
  const uint32_t x = cell & ((1u << grid.bits[0]) - 1), y = cell >> grid.bits[0] & ((1u << grid.bits[1]) - 1),
                 z = cell >> (grid.bits[0] + grid.bits[1]);
  include(&g->slack.blocks[blocks.at(x / 2, y / 2, z / 2)], box);
}

// Puts the box of a block into the eight windows that hold the block.
void spread_block(ListSlack* s, const Blocks& blocks, uint32_t block) {
  const DisplacementBox& box = s->blocks[block];
  if (box.low[0] > box.high[0]) return;
  include(&s->all, box);
  uint32_t here[3], before[3];
  for (uint32_t k = 0, shift = 0; k < 3; shift += blocks.bits[k++]) {
    const uint32_t mask = (1u << blocks.bits[k]) - 1;
    here[k] = block >> shift & mask;
    before[k] = (here[k] - 1) & mask;
  }
  for (uint32_t corner = 0; corner < 8; ++corner) {
    include(&s->windows[blocks.at((corner & 1) != 0 ? before[0] : here[0], (corner & 2) != 0 ? before[1] : here[1],
                                  (corner & 4) != 0 ? before[2] : here[2])],
            box);
  }
}

void measure_window(ListSlack* s, uint32_t window) {
  if (s->windows[window].low[0] > s->windows[window].high[0]) return;
  const float wide2 = diagonal2(s->windows[window]);
  s->widest2 = wide2 > s->widest2 ? wide2 : s->widest2;
}

}  // namespace

void list_slack_layout(ListSlack* s, const CellSort& sort, Layout* layout) {
  s->blocks = layout_region<DisplacementBox>(layout, "granular.displacements", sort.cells_max / 8);
  s->windows = layout_region<DisplacementBox>(layout, "granular.displacement_windows", sort.cells_max / 8);
}

void list_slack_begin(ListSlack* s) {
  s->step = k_clear;
  s->widest2 = 0.0f;
  s->all = k_empty;
}

bool list_slack_run(Granular* g, float* metres) {
  ListSlack& s = g->slack;
  const Grid& grid = g->neighbours.sort.grid;
  const Blocks blocks = blocks_of(grid);
  const uint32_t end = s.step == k_gather ? g->neighbours.sort.cells : blocks.count();
  uint32_t& cursor = g->substep.cursor;
  // The boundary stands still, and so may every block be beside it.
  constexpr DisplacementBox k_still = {};
  for (uint32_t done = 0; cursor < end && done < g->unit * k_cells_per_item; ++cursor, ++done) {
    if (s.step == k_clear) s.blocks[cursor] = g->boundary.count != 0 ? k_still : k_empty, s.windows[cursor] = k_empty;
    else if (s.step == k_spread) spread_block(&s, blocks, cursor);
    else if (s.step == k_widest) measure_window(&s, cursor);
    else gather_cell(g, blocks, cursor), done += k_cells_per_item * (grid.starts[cursor + 1] - grid.starts[cursor]);
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
