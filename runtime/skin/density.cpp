// Sums to density, and density to what the surface is made of, brick by brick.
//
//   density   the sums through a filter [1 2 1] / 4 along each axis, over the room: a node beside a collider has less
//             room, and its density counts for more
//   calm      once sand is filled, the filter once more; what is solid takes no part in it, so that the surface meets a
//             floor at its slope
#include <cstring>

#include "runtime/skin/rows.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr float k_skin_volume = 6.986f;  // particle radii cubed that a particle takes in a pile (packed to 0.6)
constexpr uint32_t k_density_max = 4 * k_skin_one - 1;  // so that the filter's sums fit 16 bits
constexpr uint32_t k_gain = static_cast<uint32_t>(k_skin_volume / (k_skin_spacing * k_skin_spacing * k_skin_spacing) *
                                                  (65536.0f / k_skin_shares));  // of sums, in 1/65536
constexpr uint32_t k_sum_max = static_cast<uint32_t>(uint64_t{k_density_max} * 65536 / k_gain);
constexpr uint16_t k_reaches = 1376;  // a density that may become surface beside it: 0.34
constexpr uint16_t k_held = 8;        // of the calm density: about a hundredth of a node

// The filter along each axis, which looks through no wall. `value` makes 16 bits of what a node holds.
template <class T, class Value>
void filter(const SkinBricks& bricks, const Brick& brick, T (BrickNodes::*field)[k_brick_nodes], T outside, Value value,
            uint16_t* to) {
  constexpr uint32_t k_pitch = k_brick_side + 2;  // rows
  uint16_t rows[k_pitch * k_pitch * k_brick_side];
  uint8_t walls[k_pitch * k_pitch * k_pitch];
  const bool walled = has_walls(bricks, brick);
  if (walled) brick_block<1>(bricks, brick, &BrickNodes::walls, uint8_t{0}, walls);
  // All bits of eight nodes, or none where a wall stands at the edge that begins there.
  const auto open = [&](uint32_t x, uint32_t y, uint32_t z, uint32_t edge) {
    Row row = ~Row{};
    for (uint32_t i = 0; i < k_brick_side && walled; ++i)
      if ((walls[(y * k_pitch + z) * k_pitch + x + i] & edge) != 0) row[i] = 0;
    return row;
  };
  const auto along = [&](const uint16_t* from, uint32_t step, Row low, Row high, uint16_t* out) {
    const Row own = row_at(from + step);
    set_row(out, ((row_at(from) & low) + own + own + (row_at(from + 2 * step) & high) + 2) >> 2);
  };
  each_row<1>(bricks, brick, field, outside,
              [&](uint32_t y, uint32_t z, const T* before, const T* own, const T* after) {
                uint16_t line[k_brick_side + 2];
                line[0] = value(before[k_brick_side - 1]);
                for (uint32_t x = 0; x < k_brick_side; ++x) line[x + 1] = value(own[x]);
                line[k_brick_side + 1] = value(after[0]);
                along(line, 1, open(0, y, z, 1), open(1, y, z, 1), rows + k_brick_side * (k_pitch * y + z));
              });
  for (uint32_t y = 0; y < k_pitch; ++y)
    for (uint32_t z = 0; z < k_brick_side; ++z) {
      uint16_t* row = rows + k_brick_side * (k_pitch * y + z);
      along(row, k_brick_side, open(1, y, z, 4), open(1, y, z + 1, 4), row);
    }
  for (uint32_t y = 0; y < k_brick_side; ++y)
    for (uint32_t z = 0; z < k_brick_side; ++z)
      along(rows + k_brick_side * (k_pitch * y + z), k_brick_side * k_pitch, open(1, y, z + 1, 2),
            open(1, y + 1, z + 1, 2), to + node_index(0, y, z));
}

bool sand_is_around(const SkinBricks& bricks, const Brick& brick) {
  for (const uint32_t other : brick.around)
    if (other != k_none && bricks.records[other].touches != 0) return true;
  return false;
}

void make_wanted(SkinBricks* bricks, uint32_t number) {
  for (uint32_t k = 0; k < k_bricks_around; ++k) {
    const Brick& brick = bricks->records[number];
    if ((brick.wants >> k & 1) == 0 || brick.around[k] != k_none) continue;
    int32_t at[3];
    brick_beside(brick.at, k, at);
    brick_make(bricks, at);
  }
}

__attribute__((noinline)) void find_density(SkinBricks* bricks, const uint16_t by_free[256], uint32_t number) {
  Brick& brick = bricks->records[number];
  BrickNodes& nodes = bricks->nodes[number];
  uint16_t fresh[k_brick_nodes] = {};
  if (sand_is_around(*bricks, brick))
    filter(
        *bricks, brick, &BrickNodes::sums, 0u,
        [](uint32_t sum) { return static_cast<uint16_t>((sum < k_sum_max ? sum : k_sum_max) * k_gain >> 16); }, fresh);
  Row standing[k_brick_side] = {};
  for (uint32_t i = 0; i < k_brick_nodes; i += k_brick_side) {
    const Row solid = solid_at(nodes.solid + i);
    if (any_of(solid ^ 255))
      for (uint32_t x = i; x < i + k_brick_side; ++x) {
        const uint32_t more = uint32_t{fresh[x]} * by_free[nodes.solid[x]] >> k_skin_one_shift;
        fresh[x] = static_cast<uint16_t>(more < k_skin_one ? more : k_skin_one);
      }
    const Row density = min_of(row_at(fresh + i), Row{} + uint16_t{k_skin_one});
    set_row(fresh + i, density);
    standing[i / k_brick_side % k_brick_side] |= (where_above(density, k_skin_level) | ~where_above(solid, 127)) &
                                                 static_cast<uint16_t>(1u << i / k_brick_layer);
  }
  uint16_t stands[k_brick_layer];
  for (uint32_t z = 0; z < k_brick_side; ++z) set_row(stands + k_brick_side * z, standing[z]);
  if (memcmp(stands, nodes.stands, sizeof stands) != 0) {
    memcpy(nodes.stands, stands, sizeof stands);
    brick.stale |= k_stale_fill;
    const uint32_t above = brick.around[k_brick_itself + k_around_step[1]];
    if (above != k_none) bricks->records[above].stale |= k_stale_fill;
  }
  if (memcmp(fresh, nodes.density, sizeof fresh) == 0) return;
  memcpy(nodes.density, fresh, sizeof fresh);
  brick.dense = any_of(fresh);
  brick.stale |= k_stale_fill;
  brick.wants = reach_of(k_wanted, [&](uint32_t row) { return where_above(row_at(fresh + row), k_reaches); });
  make_wanted(bricks, number);
}

// Sand fades within a wall, so that its surface lies a third of a node deep in it.
uint16_t within_wall(uint16_t value, uint8_t solid) {
  constexpr int32_t k_node = 48, k_deepest = 128 - 36;
  const int32_t part = solid - k_deepest;
  return static_cast<uint16_t>(value * (part < 0 ? 0 : part < k_node ? part : k_node) / k_node);
}

void find_calm(SkinBricks* bricks, uint32_t number, bool closed) {
  constexpr uint16_t k_room_min = k_skin_one / 128;
  Brick& brick = bricks->records[number];
  BrickNodes& nodes = bricks->nodes[number];
  uint16_t fresh[k_brick_nodes];
  filter(
      *bricks, brick, &BrickNodes::part, uint16_t{0}, [](uint16_t part) { return part; }, fresh);
  for (uint32_t row = 0; row < k_brick_layer; ++row)
    nodes.beside_sand[row] = bits_of(where_above(row_at(fresh + k_brick_side * row), 0));
  if (!brick.open) {
    if (!brick.room_known)
      filter(
          *bricks, brick, &BrickNodes::solid, uint8_t{255},
          [](uint8_t solid) { return static_cast<uint16_t>(skin_part(solid) << 4); }, nodes.room);
    brick.room_known = true;
    for (uint32_t row = 0; row < k_brick_nodes; row += k_brick_side) {
      if (!any_of(row_at(nodes.room + row) ^ uint16_t{k_skin_one})) continue;
      for (uint32_t i = row; i < row + k_brick_side; ++i) {
        const int32_t room = nodes.room[i], kept = nodes.filled[i], bounded = room > k_room_min ? room : k_room_min;
        const int32_t share =
            static_cast<int32_t>(k_skin_one * static_cast<float>(int32_t{fresh[i]}) / static_cast<float>(bounded));
        const int32_t calm = share < int32_t{k_skin_one} ? share : int32_t{k_skin_one};
        fresh[i] = static_cast<uint16_t>(room > k_room_min ? calm : kept);
      }
    }
    if (closed)
      for (uint32_t i = 0; i < k_brick_nodes; ++i) fresh[i] = within_wall(fresh[i], nodes.solid[i]);
  }
  for (uint32_t i = 0; i < k_brick_nodes; i += k_brick_side) {  // what hardly differs stays
    const Row now = row_at(fresh + i), before = row_at(nodes.calm + i);
    const Row difference = max_of(now, before) - min_of(now, before);
    set_row(fresh + i, difference > k_held ? now : before);
  }
  const uint32_t reach =
      reach_of(k_mesh_reach, [&](uint32_t row) { return row_at(fresh + row) ^ row_at(nodes.calm + row); });
  if (reach == 0) return;
  for (uint32_t row = 0; row < k_brick_layer; ++row) {
    const Row now = row_at(fresh + k_brick_side * row);
    nodes.changed[row] = static_cast<uint8_t>(
        nodes.changed[row] | bits_of(reinterpret_cast<Row>(now != row_at(nodes.calm + k_brick_side * row))));
    nodes.inside[row] = bits_of(where_above(now, k_skin_level));
  }
  memcpy(nodes.calm, fresh, sizeof fresh);
  brick.calm = any_of(fresh);
  mark_around(bricks, brick, reach, k_stale_mesh);
}

// Runs `task` on the next bricks that are stale in this way. True: there are none left.
template <uint32_t bit, class Task>
bool run_stale(uint32_t* next, SkinBricks* bricks, Task task) {
  for (uint32_t done = 0; *next < bricks->count; ++*next) {
    Brick& brick = bricks->records[*next];
    if (!brick.used || (brick.stale & bit) == 0) continue;
    if (done++ == k_skin_unit_bricks) return false;
    brick.stale &= ~bit;
    task(*next);
  }
  for (*next = 0; *next < bricks->count; ++*next)
    if (bricks->records[*next].used && (bricks->records[*next].stale & bit) != 0) return false;
  *next = 0;
  return true;
}

}  // namespace

bool skin_density(SkinFilter* filter, SkinSolids* solids, SkinBricks* bricks, const SkinState& s) {
  return run_stale<k_stale_density>(&filter->next, bricks, [&](uint32_t number) {
    solids_renew(solids, bricks, s, number);
    find_density(bricks, filter->by_free, number);
  });
}

bool skin_calm(SkinFilter* filter, SkinBricks* bricks, bool closed) {
  return run_stale<k_stale_calm>(&filter->next, bricks, [&](uint32_t number) { find_calm(bricks, number, closed); });
}

}  // namespace sandglass
