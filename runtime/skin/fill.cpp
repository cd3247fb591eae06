// What dry sand fills: it does not overhang, and stands no steeper than one in one. From above to below each node gets
// the maximum of the nodes over it, less a little, unless it is far above sand and colliders.
#include <cstring>

#include "runtime/skin/rows.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr uint16_t k_fill_less = 410, k_fill_min = 819;  // of k_skin_one: 0.1 and 0.2

// Where sand has something to stand on: within four nodes below. Without gravity nothing falls.
void find_where(SkinBricks* bricks, uint32_t number, bool falls) {
  BrickNodes& nodes = bricks->nodes[number];
  const uint32_t below = bricks->records[number].around[k_brick_itself - k_around_step[1]];
  for (uint32_t c = 0; c < k_brick_layer; c += k_brick_side) {
    const Row under = below == k_none ? Row{} : row_at(bricks->nodes[below].stands + c);
    const Row all = row_at(nodes.stands + c) << 8 | under;
    const Row can = (all >> 4 | all >> 5 | all >> 6 | all >> 7 | all >> 8) & 255;
    set_row(nodes.can + c, falls ? can : Row{});
  }
}

int32_t rounded(int64_t v) { return static_cast<int32_t>((v + k_skin_one / 2) >> k_skin_one_shift); }

// How far the layer above is moved against this one where up leans.
int32_t lean_of(int64_t lean, int32_t layer) { return rounded(-lean * layer) - rounded(-lean * (layer + 1)); }

// The layer above one, with as many nodes of the bricks beside it on every side.
constexpr uint32_t k_beside = 2, k_wide = k_brick_side + 2 * k_beside;
template <class T>
void layer_above(const SkinBricks& bricks, const Brick& brick, T (BrickNodes::*field)[k_brick_nodes], uint32_t layer,
                 T* above) {
  constexpr T k_nothing[k_brick_layer] = {};
  const uint32_t y = layer + 1;
  const T* from[3] = {k_nothing, k_nothing, k_nothing};
  for (uint32_t at = 0; at < k_wide; ++at, above += k_wide) {
    const uint32_t z = at + k_brick_side - k_beside;  // from the brick before
    const uint32_t* three = brick.around + around_index(0, 1 + brick_along(y), brick_along(z));
    const uint32_t row = node_index(0, 0, node_along(z));
    if (at == 0 || row == 0)
      for (uint32_t x = 0; x < 3; ++x)
        from[x] = three[x] == k_none ? k_nothing : (bricks.nodes[three[x]].*field) + node_index(0, node_along(y), 0);
    memcpy(above, from[0] + row + k_brick_side - k_beside, k_beside * sizeof *above);
    memcpy(above + k_beside, from[1] + row, k_brick_side * sizeof *above);
    memcpy(above + k_beside + k_brick_side, from[2] + row, k_beside * sizeof *above);
  }
}

// The maximum of the nodes over each of a row. `walls`: of those over it, which bar the step aside.
Row max_over(const uint16_t* up, const uint8_t* walls, bool corners) {
  constexpr int32_t k_next = k_wide;
  Row fullest = row_at(up);
  for (int32_t x = 0; x < static_cast<int32_t>(k_brick_side); ++x)
    for (int32_t side = -1; side <= 1; side += 2) {
      const auto take = [&](bool open, int32_t from) {
        fullest[x] = open && up[from] > fullest[x] ? up[from] : fullest[x];
      };
      // Whether nothing stands between two nodes beside each other.
      const auto along_x = [&](int32_t at) { return (walls[side > 0 ? at : at - 1] & 1) == 0; };
      const auto along_z = [&](int32_t at, int32_t toward) { return (walls[toward > 0 ? at : at - k_next] & 4) == 0; };
      take(along_x(x), x + side);
      take(along_z(x, side), x + side * k_next);
      for (int32_t toward = -1; toward <= 1 && corners; toward += 2)
        take(along_x(x) && along_z(x + side, toward), x + side + toward * k_next);
    }
  return fullest;
}

// Fills one layer by what falls from the one above. Bits of Brick::around that feel what has changed.
uint32_t fill_layer(SkinBricks* bricks, const SkinLattice& lattice, uint32_t number, uint32_t layer) {
  const Brick& brick = bricks->records[number];
  BrickNodes& nodes = bricks->nodes[number];
  uint16_t above[k_wide * k_wide];
  uint8_t walls[k_wide * k_wide];
  layer_above(*bricks, brick, &BrickNodes::filled, layer, above);
  const bool walled = has_walls(*bricks, brick);
  if (walled) layer_above(*bricks, brick, &BrickNodes::walls, layer, walls);
  const int32_t height = first_node(brick.at[1]) + static_cast<int32_t>(layer);
  const int32_t lean =
      lean_of(lattice.lean[0], height) + static_cast<int32_t>(k_wide) * lean_of(lattice.lean[1], height);
  Row changed = {};
  uint32_t changed_z = 0;
  for (uint32_t z = 0; z < k_brick_side; ++z) {
    const uint16_t *up = above + static_cast<int32_t>(k_wide * (z + k_beside) + k_beside) - lean, *l = up - k_wide,
                   *r = up + k_wide;
    const auto three = [](const uint16_t* row) {
      return max_of(row_at(row), max_of(row_at(row - 1), row_at(row + 1)));
    };
    Row fullest = max_of(three(up), max_of(row_at(l), row_at(r)));
    if ((height & 1) != 0) fullest = max_of(fullest, max_of(three(l), three(r)));
    if (walled) fullest = max_over(up, walls + (up - above), (height & 1) != 0);
    const Row less = max_of(fullest, Row{} + k_fill_less) - k_fill_less;
    const uint32_t row = k_brick_side * z, at = node_index(0, layer, z);
    Row can = -(row_at(nodes.can + row) >> static_cast<uint16_t>(layer) & 1);
    if (walled) can &= where_above(solid_at(nodes.solid + at), 128);  // nothing falls into a wall, and out below
    for (uint32_t x = 0; x < k_brick_side && walled; ++x)
      if ((nodes.walls[at + x] & 2) != 0) can[x] = 0;
    const Row fresh = max_of(row_at(nodes.density + at), less & where_above(less, k_fill_min) & can);
    const Row difference = fresh ^ row_at(nodes.filled + at);
    if (!any_of(difference)) continue;
    changed |= difference;
    changed_z |= 1u << z;
    set_row(nodes.filled + at, fresh);
    take_part(&nodes, at);
  }
  return around_of(changed, changed_z != 0 ? 1u << layer : 0, changed_z, k_filter_reach);
}

// Adds a brick to those of the level.
void add_work(SkinFill* fill, SkinBricks* bricks, uint32_t number, bool falls) {
  find_where(bricks, number, falls);
  fill->work[fill->work_count++] = number;
}

// Adds the bricks beside one, because their next layer depends on its layer.
void join_beside(SkinFill* fill, SkinBricks* bricks, const Brick& brick, bool falls) {
  for (uint32_t k = around_index(0, 1, 0); k < around_index(0, 2, 0); ++k) {
    const uint32_t other = brick.around[k];
    if (other == k_none || (bricks->records[other].stale & k_stale_fill) != 0) continue;
    bricks->records[other].stale |= k_stale_fill;
    add_work(fill, bricks, other, falls);
  }
}

// Whether it holds sand, or sand may fall into it.
bool can_hold(const SkinBricks& bricks, const Brick& brick) {
  if (brick.filled) return true;
  for (uint32_t k = around_index(0, 1, 0); k < k_bricks_around; ++k) {
    const uint32_t other = brick.around[k];
    if (other != k_none && (bricks.records[other].dense || bricks.records[other].filled)) return true;
  }
  return false;
}

void begin_level(SkinFill* fill, SkinBricks* bricks, bool falls) {
  fill->work_count = fill->next = 0;
  fill->layer = k_brick_side - 1;
  for (uint32_t b = 0; b < bricks->count; ++b) {
    Brick& brick = bricks->records[b];
    if (!brick.used || (brick.stale & k_stale_fill) == 0 || brick.at[1] != fill->level) continue;
    if (can_hold(*bricks, brick)) add_work(fill, bricks, b, falls);
    else brick.stale &= ~k_stale_fill;
  }
}

void end_level(SkinFill* fill, SkinBricks* bricks) {
  for (uint32_t i = 0; i < fill->work_count; ++i) {
    Brick& brick = bricks->records[fill->work[i]];
    brick.stale &= ~k_stale_fill;
    brick.filled = any_of(bricks->nodes[fill->work[i]].filled);
  }
  --fill->level;
  fill->layer = k_brick_side;
}

}  // namespace

void skin_begin_fill(SkinFill* fill, const SkinBricks& bricks) {
  int32_t low = 0, high = -1;
  for (uint32_t b = 0; b < bricks.count; ++b) {
    if (!bricks.records[b].used) continue;
    const int32_t y = bricks.records[b].at[1];
    if (low > high) low = high = y;
    low = y < low ? y : low;
    high = y > high ? y : high;
  }
  fill->level_low = low;
  fill->level = high;
  fill->layer = k_brick_side;
}

bool skin_fill(SkinFill* fill, SkinBricks* bricks, const SkinLattice& lattice) {
  constexpr uint32_t k_below = (1u << around_index(0, 1, 0)) - 1;  // those of `around`
  for (uint32_t done = 0; done < k_skin_unit_layers;) {
    if (fill->level < fill->level_low) return true;
    if (fill->layer == k_brick_side) {
      begin_level(fill, bricks, lattice.falls);
      ++done;
    }
    for (; fill->next < fill->work_count && done < k_skin_unit_layers; ++fill->next, ++done) {
      const uint32_t number = fill->work[fill->next];
      const Brick& brick = bricks->records[number];
      const uint32_t changed = fill_layer(bricks, lattice, number, fill->layer);
      if (changed == 0) continue;
      mark_around(bricks, brick, changed, k_stale_calm);
      if (fill->layer != 0) join_beside(fill, bricks, brick, lattice.falls);
      else mark_around(bricks, brick, k_below, k_stale_fill);
    }
    if (fill->next < fill->work_count) continue;
    fill->next = 0;
    if (fill->layer-- != 0 && fill->work_count != 0) continue;
    end_level(fill, bricks);
  }
  return false;
}

}  // namespace sandglass
