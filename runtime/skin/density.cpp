// From sums to a density whose level is the surface, brick by brick.
//
//   solid     the distance to the nearest collider; a node beside one has less room, and its density counts for more; and
//             walls, which may be thinner than nodes are apart: nothing passes from node to node through one
//   density   the sums through a filter [1 2 1] / 4 along each axis, over the room
//   fill      dry sand does not overhang, and stands no steeper than one in one: from above to below a node gets the most of
//             the nodes over it, a little less, where it is not far above sand or a collider
//   calm      the filter once more; what is solid takes no part in it, so that the surface meets a floor at its slope
#include <cstring>

#include "runtime/sand/granular.h"
#include "runtime/skin/skin.h"
#include "runtime/solid/field/field.h"

namespace sandglass {
namespace {

constexpr uint32_t k_most = 4 * k_skin_one - 1;  // so that the filter's sums fit 16 bits
constexpr uint32_t k_gain = static_cast<uint32_t>(k_skin_volume / (k_skin_spacing * k_skin_spacing * k_skin_spacing) *
                                                  (65536.0f / k_skin_shares));  // of sums, in 1/65536
constexpr uint32_t k_most_sum = static_cast<uint32_t>(uint64_t{k_most} * 65536 / k_gain);
constexpr uint16_t k_fill_less = 410, k_fill_least = 819;  // 0.1 and 0.2
constexpr uint16_t k_reaches = 1376;                       // a density that may become surface beside it: 0.34
constexpr uint16_t k_held = 8;                             // of the calm density: about a hundredth of a node
constexpr float k_solid_one = 48.0f, k_solid_reach = 2.6f;

Row most_of(Row a, Row b) { return a > b ? a : b; }
Row least_of(Row a, Row b) { return a < b ? a : b; }
Row where_above(Row a, uint16_t level) { return reinterpret_cast<Row>(a > level); }  // all bits of a node, or none

bool any_of(Row row) {
  uint64_t half[2];
  memcpy(half, &row, sizeof row);
  return (half[0] | half[1]) != 0;
}

// A bit for each node.
uint8_t bits_of(Row row) {
  constexpr Row k_bits = {1, 2, 4, 8, 16, 32, 64, 128};
  row &= k_bits;
  uint32_t sum = 0;
  for (uint32_t x = 0; x < k_brick_side; ++x) sum += row[x];
  return static_cast<uint8_t>(sum);
}

bool any_of(const uint16_t* values) {
  Row any = {};
  for (uint32_t i = 0; i < k_brick_nodes; i += k_brick_side) any |= row_at(values + i);
  return any_of(any);
}

// The filter along each axis, which looks through no wall. `value` makes 16 bits of what a node holds.
template <class T, class Value>
void filter(const SkinState& s, const Brick& brick, T (BrickNodes::*field)[k_brick_nodes], T outside, Value value,
            uint16_t* to) {
  constexpr uint32_t k_pitch = k_brick_side + 2;  // rows
  uint16_t rows[k_pitch * k_pitch * k_brick_side];
  uint8_t walls[k_pitch * k_pitch * k_pitch];
  const bool walled = has_walls(s, brick);
  if (walled) brick_block<1>(s, brick, &BrickNodes::walls, uint8_t{0}, walls);
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
  each_row<1>(s, brick, field, outside, [&](uint32_t y, uint32_t z, const T* before, const T* own, const T* after) {
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
            open(1, y + 1, z + 1, 2), to + k_brick_layer * y + k_brick_side * z);
}

void mark(SkinState* s, const Brick& brick, uint32_t around, uint32_t stale) {
  for (; around != 0; around &= around - 1) {
    const uint32_t other = brick.around[__builtin_ctz(around)];
    if (other != k_brick_none) s->bricks[other].stale |= stale;
  }
}
constexpr uint32_t k_all_around = (1u << k_bricks_around) - 1;

bool stands_as(const ColliderFrame& a, const ColliderFrame& b) {
  bool same = a.shape == b.shape && a.field.values == b.field.values;
  for (uint32_t k = 0; k < 3; ++k) {
    same = same && a.position[k] == b.position[k] && a.size[k] == b.size[k];
    for (uint32_t m = 0; m < 3; ++m) same = same && a.axes[k][m] == b.axes[k][m];
  }
  return same;
}

// What stands for a field that may be gone: a box of its reach.
ColliderFrame box_of(const ColliderFrame& collider) {
  ColliderFrame box = collider;
  if (box.shape == SANDGLASS_SHAPE_FIELD) {
    box.shape = SANDGLASS_SHAPE_BOX;
    find_extent(&box);
  }
  return box;
}

// World, metres; `node` in nodes from the brick's first.
void place_of(const SkinState& s, const Brick& brick, const float node[3], float place[3]) {
  for (uint32_t a = 0; a < 3; ++a)
    place[s.axis[a]] = s.sign[a] * s.spacing * (static_cast<float>(8 * brick.at[a]) + node[a] + 0.5f);
}

// Whether a collider is so near to a brick that its nodes may feel it.
bool is_near(const SkinState& s, const Brick& brick, const ColliderFrame& collider) {
  constexpr float k_middle[3] = {3.5f, 3.5f, 3.5f}, k_half = 6.1f;  // to the outermost node
  place_of(s, brick, k_middle, s.points[0].position);
  const SurfaceArgs args = {s.points, &collider};
  uint32_t unused = 0;
  s.kernels->surface_at(&args, 0, 1, &unused);
  return s.points[0].distance < (k_half + k_solid_reach + 0.5f) * s.spacing;
}

// Whether sand of a brick feels a collider: it changes what is made of a node beside sand. First rows of nodes are looked
// at, then the nodes of those that are near.
bool feels(SkinState* s, uint32_t number, const ColliderFrame& collider) {
  constexpr float k_felt = k_solid_reach + 0.25f, k_half_row = 3.5f;
  const Brick& brick = s->bricks[number];
  const uint8_t* beside = s->nodes[number].beside_sand;
  const SurfaceArgs args = {s->points, &collider};
  uint8_t rows[k_brick_layer];
  uint32_t count = 0, near = 0, unused = 0;
  const auto look_at = [&](float x, uint32_t row) {
    const float node[3] = {x, static_cast<float>(row >> 3), static_cast<float>(row & 7)};
    place_of(*s, brick, node, s->points[count++].position);
  };
  const auto is_felt = [&](uint32_t i, float reach) { return s->points[i].distance < reach * s->spacing; };
  for (uint32_t row = 0; row < k_brick_layer; ++row)
    if (beside[row] != 0) {
      rows[count] = static_cast<uint8_t>(row);
      look_at(k_half_row, row);
    }
  s->kernels->surface_at(&args, 0, count, &unused);
  for (uint32_t i = 0; i < count; ++i)
    if (is_felt(i, k_felt + k_half_row)) rows[near++] = rows[i];
  count = 0;
  for (uint32_t i = 0; i < near; ++i)
    for (uint32_t bits = beside[rows[i]]; bits != 0; bits &= bits - 1)
      look_at(static_cast<float>(__builtin_ctz(bits)), rows[i]);
  s->kernels->surface_at(&args, 0, count, &unused);
  for (uint32_t i = 0; i < count; ++i)
    if (is_felt(i, k_felt)) return true;
  return false;
}

void mark_near(SkinState* s, const ColliderFrame& collider) {
  for (uint32_t b = 0; b < s->brick_count && collider.shape != k_no_shape; ++b) {
    Brick& brick = s->bricks[b];
    if (!brick.used || !is_near(*s, brick, collider)) continue;
    brick.stale |= k_stale_solid;
    if (s->phase != SkinPhase::take && !s->asked) s->asked = s->phase != SkinPhase::idle || feels(s, b, collider);
  }
}

// Whether a solid lies between two nodes: its distance falls from either towards the other, and would be below 0 where
// both meet. So it does in a wall of any thickness, and not beside a floor or an edge that both look at.
bool is_between(const SurfacePoint& a, const SurfacePoint& b, uint32_t axis, float sign, float apart) {
  if (a.distance + b.distance >= apart) return false;
  const float from_a = -sign * a.normal[axis], from_b = sign * b.normal[axis];
  return from_a > 0 && from_b > 0 && a.distance * from_b + b.distance * from_a < from_a * from_b * apart;
}

void find_solid(SkinState* s, uint32_t number) {
  constexpr float k_walls_within = 7.1f;  // nodes from a brick's middle: to the outermost one, and one more
  Brick& brick = s->bricks[number];
  uint8_t *solid = s->nodes[number].solid, *walls = s->nodes[number].walls;
  brick.open = true;
  brick.walled = false;
  memset(solid, 255, k_brick_nodes);
  memset(walls, 0, k_brick_nodes);
  for (uint32_t c = 0; c < s->desc.collider_capacity; ++c) {
    if (s->colliders[c].shape == k_no_shape || !is_near(*s, brick, s->colliders[c])) continue;
    const bool walls_too =
        s->colliders[c].shape != SANDGLASS_SHAPE_HALF_SPACE && s->points[0].distance < k_walls_within * s->spacing;
    const uint32_t side = walls_too ? k_edges_side : k_brick_side, steps[3] = {1, side * side, side};
    SurfacePoint* next = s->points;
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t z = 0; z < side; ++z)
        for (uint32_t x = 0; x < side; ++x) {
          const float node[3] = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
          place_of(*s, brick, node, next++->position);
        }
    const SurfaceArgs args = {s->points, &s->colliders[c]};
    uint32_t unused = 0;
    s->kernels->surface_at(&args, 0, side * side * side, &unused);
    for (uint32_t i = 0; i < k_brick_nodes; ++i) {
      const SurfacePoint* point = s->points + (i & 7) + steps[2] * (i >> 3 & 7) + steps[1] * (i >> 6);
      const float value = 128.5f + k_solid_one * s->inverse_spacing * point->distance;
      const uint32_t whole = to_whole<uint32_t>(value < 255.0f ? value : 255.0f);
      if (whole < solid[i]) solid[i] = static_cast<uint8_t>(whole);
      if (whole < 255) brick.open = false;
      for (uint32_t a = 0; a < 3 && walls_too && point->distance < s->spacing; ++a)
        if (is_between(*point, point[steps[a]], s->axis[a], s->sign[a], s->spacing)) {
          walls[i] = static_cast<uint8_t>(walls[i] | 1u << a);
          brick.walled = true;
        }
    }
  }
}

// How near to a brick's faces a node may be and count beyond them: below and above along an axis.
struct Reach {
  uint32_t low, high, down, up;
};
constexpr Reach k_wanted = {6, 6, 6, 2}, k_filter_reach = {1, 1, 1, 1}, k_mesh_reach = {2, 1, 2, 1};

// Bits of Brick::around that nodes reach, by the planes along each axis in which they are; its own one where there are any.
uint32_t around_of(Row any_x, uint32_t any_y, uint32_t any_z, const Reach& reach) {
  if (any_y == 0) return 0;
  uint32_t bits_x = 0, bits = 0;
  for (uint32_t k = 0; k < 8; ++k) bits_x |= (any_x[k] != 0 ? 1u : 0u) << k;
  const auto along = [](uint32_t any, uint32_t low, uint32_t high) {
    return ((any & ((1u << low) - 1)) != 0 ? 1u : 0u) | 2u | ((any >> (8 - high)) != 0 ? 4u : 0u);
  };
  const uint32_t x = along(bits_x, reach.low, reach.high), z = along(any_z, reach.low, reach.high);
  const uint32_t y = along(any_y, reach.down, reach.up);
  for (uint32_t k = 0; k < k_bricks_around; ++k) bits |= (x >> k % 3 & y >> k / 9 & z >> k / 3 % 3 & 1) << k;
  return bits;
}

// `found` tells of a row which nodes count.
template <class Found>
uint32_t reach_of(const Reach& reach, Found found) {
  Row any_x = {}, along_y[8] = {}, along_z[8] = {};
  for (uint32_t y = 0; y < 8; ++y)
    for (uint32_t z = 0; z < 8; ++z) {
      const Row row = found(k_brick_layer * y + k_brick_side * z);
      along_y[y] |= row;
      along_z[z] |= row;
    }
  uint32_t any_y = 0, any_z = 0;
  for (uint32_t k = 0; k < 8; ++k) {
    any_x |= along_y[k];
    any_y |= (any_of(along_y[k]) ? 1u : 0u) << k;
    any_z |= (any_of(along_z[k]) ? 1u : 0u) << k;
  }
  return around_of(any_x, any_y, any_z, reach);
}

bool sand_is_around(const SkinState& s, const Brick& brick) {
  for (const uint32_t other : brick.around)
    if (other != k_brick_none && s.bricks[other].touches != 0) return true;
  return false;
}

void make_wanted(SkinState* s, uint32_t number) {
  for (uint32_t k = 0; k < k_bricks_around; ++k) {
    const Brick& brick = s->bricks[number];
    if ((brick.wants >> k & 1) == 0 || brick.around[k] != k_brick_none) continue;
    int32_t at[3];
    brick_beside(brick.at, k, at);
    brick_make(s, at);
  }
}

// Eight nodes of BrickNodes::solid.
Row solid_at(const uint8_t* solid) {
  uint8_t __attribute__((vector_size(8))) eight;
  memcpy(&eight, solid, sizeof eight);
  return __builtin_convertvector(eight, Row);
}

__attribute__((noinline)) void find_density(SkinState* s, uint32_t number) {
  Brick& brick = s->bricks[number];
  BrickNodes& nodes = s->nodes[number];
  uint16_t fresh[k_brick_nodes] = {};
  if (sand_is_around(*s, brick))
    filter(
        *s, brick, &BrickNodes::sums, 0u,
        [](uint32_t sum) { return static_cast<uint16_t>((sum < k_most_sum ? sum : k_most_sum) * k_gain >> 16); },
        fresh);
  Row standing[k_brick_side] = {};
  for (uint32_t i = 0; i < k_brick_nodes; i += k_brick_side) {
    const Row solid = solid_at(nodes.solid + i);
    if (any_of(solid ^ 255))
      for (uint32_t x = i; x < i + k_brick_side; ++x) {
        const uint32_t more = uint32_t{fresh[x]} * s->by_free[nodes.solid[x]] >> 12;
        fresh[x] = static_cast<uint16_t>(more < k_skin_one ? more : k_skin_one);
      }
    const Row density = least_of(row_at(fresh + i), Row{} + uint16_t{k_skin_one});
    set_row(fresh + i, density);
    standing[i / k_brick_side % k_brick_side] |= (where_above(density, k_skin_level) | ~where_above(solid, 127)) &
                                                 static_cast<uint16_t>(1u << i / k_brick_layer);
  }
  uint16_t stands[k_brick_layer];
  for (uint32_t z = 0; z < k_brick_side; ++z) set_row(stands + k_brick_side * z, standing[z]);
  if (memcmp(stands, nodes.stands, sizeof stands) != 0) {
    memcpy(nodes.stands, stands, sizeof stands);
    brick.stale |= k_stale_fill;
    const uint32_t above = brick.around[k_brick_itself + 9];
    if (above != k_brick_none) s->bricks[above].stale |= k_stale_fill;
  }
  if (memcmp(fresh, nodes.density, sizeof fresh) == 0) return;
  memcpy(nodes.density, fresh, sizeof fresh);
  brick.dense = any_of(fresh);
  brick.stale |= k_stale_fill;
  brick.wants = reach_of(k_wanted, [&](uint32_t row) { return where_above(row_at(fresh + row), k_reaches); });
  make_wanted(s, number);
}

// ---- fill

// Where sand has something to stand on: within four nodes below. Without gravity nothing falls.
void find_where(const SkinState& s, const Brick& brick, BrickNodes* nodes) {
  const uint32_t below = brick.around[k_brick_itself - 9];
  for (uint32_t c = 0; c < k_brick_layer; c += k_brick_side) {
    const Row under = below == k_brick_none ? Row{} : row_at(s.nodes[below].stands + c);
    const Row all = row_at(nodes->stands + c) << 8 | under;
    const Row can = (all >> 4 | all >> 5 | all >> 6 | all >> 7 | all >> 8) & 255;
    set_row(nodes->can + c, s.falls ? can : Row{});
  }
}

int32_t rounded(int64_t v) { return static_cast<int32_t>((v + k_skin_one / 2) >> 12); }

// How far the layer above is moved against this one where up leans.
int32_t lean_of(const SkinState& s, uint32_t k, int32_t layer) {
  const int64_t lean = s.lean[k];
  return rounded(-lean * layer) - rounded(-lean * (layer + 1));
}

// The layer above one, with two nodes of the bricks beside it on every side.
constexpr uint32_t k_wide = 12;
template <class T>
void layer_above(const SkinState& s, const Brick& brick, T (BrickNodes::*field)[k_brick_nodes], uint32_t layer,
                 T* above) {
  constexpr T k_nothing[k_brick_layer] = {};
  const uint32_t first = layer == 7 ? 18 : 9, from_layer = layer == 7 ? 0 : layer + 1;
  const T* from[3] = {k_nothing, k_nothing, k_nothing};
  for (uint32_t z = 0; z < k_wide; ++z, above += k_wide) {
    const uint32_t from_z = z + k_brick_side - 2;
    const uint32_t* three = brick.around + first + 3 * (from_z / k_brick_side);
    const uint32_t row = k_brick_side * (from_z % k_brick_side);
    if (z == 0 || row == 0)
      for (uint32_t x = 0; x < 3; ++x)
        from[x] = three[x] == k_brick_none ? k_nothing : (s.nodes[three[x]].*field) + k_brick_layer * from_layer;
    memcpy(above, from[0] + row + k_brick_side - 2, 2 * sizeof *above);
    memcpy(above + 2, from[1] + row, k_brick_side * sizeof *above);
    memcpy(above + 2 + k_brick_side, from[2] + row, 2 * sizeof *above);
  }
}

// What takes part in the filter.
void take_part(BrickNodes* nodes, uint32_t row) {
  for (uint32_t i = row; i < row + k_brick_side; ++i)
    nodes->part[i] = static_cast<uint16_t>(uint32_t{nodes->filled[i]} * skin_part(nodes->solid[i]) >> 8);
}

// The most of the nodes over each of a row. `walls`: of those over it, from which way aside is barred.
Row most_over(const uint16_t* up, const uint8_t* walls, bool corners) {
  constexpr int32_t k_next = k_wide;
  Row most = row_at(up);
  for (int32_t x = 0; x < static_cast<int32_t>(k_brick_side); ++x)
    for (int32_t side = -1; side <= 1; side += 2) {
      const auto take = [&](bool way, int32_t from) { most[x] = way && up[from] > most[x] ? up[from] : most[x]; };
      // Whether nothing stands between two nodes beside each other.
      const auto along_x = [&](int32_t at) { return (walls[side > 0 ? at : at - 1] & 1) == 0; };
      const auto along_z = [&](int32_t at, int32_t way) { return (walls[way > 0 ? at : at - k_next] & 4) == 0; };
      take(along_x(x), x + side);
      take(along_z(x, side), x + side * k_next);
      for (int32_t way = -1; way <= 1 && corners; way += 2)
        take(along_x(x) && along_z(x + side, way), x + side + way * k_next);
    }
  return most;
}

// Fills one layer by what falls from the one above. Bits of Brick::around that feel what has changed.
uint32_t fill_layer(SkinState* s, uint32_t number, uint32_t layer) {
  const Brick& brick = s->bricks[number];
  BrickNodes& nodes = s->nodes[number];
  uint16_t above[k_wide * k_wide];
  uint8_t walls[k_wide * k_wide];
  layer_above(*s, brick, &BrickNodes::filled, layer, above);
  const bool walled = has_walls(*s, brick);
  if (walled) layer_above(*s, brick, &BrickNodes::walls, layer, walls);
  const int32_t height = 8 * brick.at[1] + static_cast<int32_t>(layer);
  const int32_t lean = lean_of(*s, 0, height) + static_cast<int32_t>(k_wide) * lean_of(*s, 1, height);
  Row changed = {};
  uint32_t changed_z = 0;
  for (uint32_t z = 0; z < k_brick_side; ++z) {
    const uint16_t *up = above + static_cast<int32_t>(k_wide * (z + 2) + 2) - lean, *l = up - k_wide, *r = up + k_wide;
    const auto three = [](const uint16_t* row) {
      return most_of(row_at(row), most_of(row_at(row - 1), row_at(row + 1)));
    };
    Row most = most_of(three(up), most_of(row_at(l), row_at(r)));
    if ((height & 1) != 0) most = most_of(most, most_of(three(l), three(r)));
    if (walled) most = most_over(up, walls + (up - above), (height & 1) != 0);
    const Row less = most_of(most, Row{} + k_fill_less) - k_fill_less;
    const uint32_t row = k_brick_side * z, at = k_brick_layer * layer + row;
    Row can = -(row_at(nodes.can + row) >> static_cast<uint16_t>(layer) & 1);
    if (walled) can &= where_above(solid_at(nodes.solid + at), 128);  // nothing falls into a wall, and out below
    for (uint32_t x = 0; x < k_brick_side && walled; ++x)
      if ((nodes.walls[at + x] & 2) != 0) can[x] = 0;
    const Row fresh = most_of(row_at(nodes.density + at), less & where_above(less, k_fill_least) & can);
    const Row difference = fresh ^ row_at(nodes.filled + at);
    if (!any_of(difference)) continue;
    changed |= difference;
    changed_z |= 1u << z;
    set_row(nodes.filled + at, fresh);
    take_part(&nodes, at);
  }
  return around_of(changed, changed_z != 0 ? 1u << layer : 0, changed_z, k_filter_reach);
}

// The bricks beside one read its layer for their next one.
void join_beside(SkinState* s, const Brick& brick) {
  for (uint32_t k = 9; k < 18; ++k) {
    const uint32_t other = brick.around[k];
    if (other == k_brick_none || (s->bricks[other].stale & k_stale_fill) != 0) continue;
    s->bricks[other].stale |= k_stale_fill;
    find_where(*s, s->bricks[other], &s->nodes[other]);
    s->work[s->work_count++] = other;
  }
}

// Whether it holds sand, or sand may fall into it.
bool can_hold(const SkinState& s, const Brick& brick) {
  if (brick.filled) return true;
  for (uint32_t k = 9; k < k_bricks_around; ++k) {
    const uint32_t other = brick.around[k];
    if (other != k_brick_none && (s.bricks[other].dense || s.bricks[other].filled)) return true;
  }
  return false;
}

void collect_level(SkinState* s) {
  s->work_count = s->cursor = 0;
  s->layer = 7;
  for (uint32_t b = 0; b < s->brick_count; ++b) {
    Brick& brick = s->bricks[b];
    if (!brick.used || (brick.stale & k_stale_fill) == 0 || brick.at[1] != s->level) continue;
    if (!can_hold(*s, brick)) {
      brick.stale &= ~k_stale_fill;
      continue;
    }
    find_where(*s, brick, &s->nodes[b]);
    s->work[s->work_count++] = b;
  }
}

void end_level(SkinState* s) {
  for (uint32_t i = 0; i < s->work_count; ++i) {
    Brick& brick = s->bricks[s->work[i]];
    brick.stale &= ~k_stale_fill;
    brick.filled = any_of(s->nodes[s->work[i]].filled);
  }
}

// ---- calm

// Sand fades within a wall, so that its surface lies a third of a node deep in it.
uint16_t within_wall(uint16_t value, uint8_t solid) {
  constexpr int32_t k_one = 48, k_deepest = 128 - 36;
  const int32_t part = solid - k_deepest;
  return static_cast<uint16_t>(value * (part < 0 ? 0 : part < k_one ? part : k_one) / k_one);
}

void find_calm(SkinState* s, uint32_t number) {
  constexpr uint16_t k_least = k_skin_one / 128;
  Brick& brick = s->bricks[number];
  BrickNodes& nodes = s->nodes[number];
  uint16_t fresh[k_brick_nodes];
  filter(
      *s, brick, &BrickNodes::part, uint16_t{0}, [](uint16_t part) { return part; }, fresh);
  for (uint32_t row = 0; row < k_brick_layer; ++row)
    nodes.beside_sand[row] = bits_of(where_above(row_at(fresh + k_brick_side * row), 0));
  if (!brick.open) {
    if (!brick.room_known)
      filter(
          *s, brick, &BrickNodes::solid, uint8_t{255},
          [](uint8_t solid) { return static_cast<uint16_t>(skin_part(solid) << 4); }, nodes.room);
    brick.room_known = true;
    for (uint32_t row = 0; row < k_brick_nodes; row += k_brick_side) {
      if (!any_of(row_at(nodes.room + row) ^ uint16_t{k_skin_one})) continue;
      for (uint32_t i = row; i < row + k_brick_side; ++i) {
        const int32_t room = nodes.room[i], kept = nodes.filled[i], most = room > k_least ? room : k_least;
        const int32_t share =
            static_cast<int32_t>(k_skin_one * static_cast<float>(int32_t{fresh[i]}) / static_cast<float>(most));
        const int32_t calm = share < int32_t{k_skin_one} ? share : int32_t{k_skin_one};
        fresh[i] = static_cast<uint16_t>(room > k_least ? calm : kept);
      }
    }
    if (s->desc.capped != 0)
      for (uint32_t i = 0; i < k_brick_nodes; ++i) fresh[i] = within_wall(fresh[i], nodes.solid[i]);
  }
  for (uint32_t i = 0; i < k_brick_nodes; i += k_brick_side) {  // what hardly differs stays
    const Row now = row_at(fresh + i), before = row_at(nodes.calm + i);
    const Row apart = most_of(now, before) - least_of(now, before);
    set_row(fresh + i, apart > k_held ? now : before);
  }
  const uint32_t reach =
      reach_of(k_mesh_reach, [&](uint32_t row) { return row_at(fresh + row) ^ row_at(nodes.calm + row); });
  if (reach == 0) return;
  for (uint32_t row = 0; row < k_brick_layer; ++row) {
    const Row now = row_at(fresh + 8 * row);
    nodes.changed[row] =
        static_cast<uint8_t>(nodes.changed[row] | bits_of(reinterpret_cast<Row>(now != row_at(nodes.calm + 8 * row))));
    nodes.inside[row] = bits_of(where_above(now, k_skin_level));
  }
  memcpy(nodes.calm, fresh, sizeof fresh);
  brick.calm = any_of(fresh);
  mark(s, brick, reach, k_stale_mesh);
}

// Runs `task` on the next bricks that are stale in this way. True: there are none left.
template <uint32_t bit, class Task>
bool run_stale(SkinState* s, Task task) {
  for (uint32_t done = 0; s->cursor < s->brick_count; ++s->cursor) {
    Brick& brick = s->bricks[s->cursor];
    if (!brick.used || (brick.stale & bit) == 0) continue;
    if (done++ == k_skin_unit_bricks) return false;
    brick.stale &= ~bit;
    task(s->cursor);
  }
  for (uint32_t b = 0; b < s->brick_count; ++b)
    if (s->bricks[b].used && (s->bricks[b].stale & bit) != 0) {
      s->cursor = b;
      return false;
    }
  s->cursor = 0;
  return true;
}

}  // namespace

// A collider that has come, gone or moved changes the bricks near where it was and near where it is. Only where sand feels
// it is a skin asked for; other bricks wait until one is made.
void skin_take_colliders(SkinState* s, float before) {
  const Colliders& given = s->granular->colliders;
  skin_drop_gone_fields(s);
  s->mover_count = 0;
  for (uint32_t slot = 0; slot < s->desc.collider_capacity; ++slot) {
    uint32_t i = 0;
    while (i < given.count && given.slots[i] != slot) ++i;
    ColliderFrame now = {}, &was = s->colliders[slot];
    now.shape = k_no_shape;
    uint64_t version = 0;
    if (i < given.count) {
      const sandglass_collider& collider = given.given[i];
      colliders_pose(&collider, 1, before, &now);
      if (collider.shape == SANDGLASS_SHAPE_FIELD) version = collider.field->version;
      memcpy(now.extent, box_of(now).extent, sizeof now.extent);
    }
    const bool same = version == s->fields[slot] && stands_as(now, was);
    if (!same) mark_near(s, box_of(was));
    was = now;
    s->fields[slot] = version;
    if (!same) mark_near(s, now);
    bool moves = false;
    for (uint32_t k = 0; k < 3; ++k) moves = moves || now.linear[k] != 0 || now.angular[k] != 0;
    if (moves) s->movers[s->mover_count++] = slot;
  }
}

void skin_drop_gone_fields(SkinState* s) {
  const Colliders& given = s->granular->colliders;
  for (uint32_t slot = 0; slot < s->desc.collider_capacity; ++slot) {
    ColliderFrame& was = s->colliders[slot];
    bool there = was.shape != SANDGLASS_SHAPE_FIELD;
    for (uint32_t i = 0; i < given.count && !there; ++i)
      there = given.given[i].shape == SANDGLASS_SHAPE_FIELD && given.given[i].field->version == s->fields[slot] &&
              grid_of(given.given[i].field).values == was.field.values;
    if (there) continue;
    mark_near(s, box_of(was));
    was.shape = k_no_shape;
    s->fields[slot] = 0;
  }
}

// Finds what is solid in a brick, and what that changes. Its own frame, as find_density has: kernels are called from here.
static __attribute__((noinline)) void renew_solid(SkinState* s, uint32_t number) {
  Brick& brick = s->bricks[number];
  BrickNodes& nodes = s->nodes[number];
  uint8_t *solid = s->blocks->solid, *walls = s->blocks->walls;  // as they were
  memcpy(solid, nodes.solid, sizeof nodes.solid);
  memcpy(walls, nodes.walls, sizeof nodes.walls);
  if ((brick.stale & k_stale_solid) != 0) find_solid(s, number);
  brick.stale &= ~k_stale_solid;
  const bool other_walls = memcmp(walls, nodes.walls, sizeof nodes.walls) != 0;
  if (other_walls) mark(s, brick, k_all_around, k_stale_density | k_stale_fill);
  if (!other_walls && memcmp(solid, nodes.solid, sizeof nodes.solid) == 0) return;
  for (uint32_t row = 0; row < k_brick_nodes; row += k_brick_side) take_part(&nodes, row);
  memset(nodes.changed, 255, sizeof nodes.changed);
  brick.stale |= k_stale_fill;
  mark(s, brick, k_all_around, k_stale_calm | k_stale_mesh);
  for (const uint32_t other : brick.around)
    if (other != k_brick_none) s->bricks[other].room_known = false;
}

bool skin_density(SkinState* s) {
  return run_stale<k_stale_density>(s, [&](uint32_t number) {
    renew_solid(s, number);
    find_density(s, number);
  });
}

void skin_begin_fill(SkinState* s) {
  int32_t low = 0, high = -1;
  for (uint32_t b = 0; b < s->brick_count; ++b) {
    if (!s->bricks[b].used) continue;
    const int32_t y = s->bricks[b].at[1];
    if (low > high) low = high = y;
    low = y < low ? y : low;
    high = y > high ? y : high;
  }
  s->level_low = low;
  s->level = high;
  s->layer = 8;
}

bool skin_fill(SkinState* s) {
  for (uint32_t done = 0; done < 8 * k_skin_unit_bricks;) {
    if (s->level < s->level_low) {
      s->cursor = 0;
      return true;
    }
    if (s->layer == 8) {
      collect_level(s);
      ++done;
    }
    for (; s->cursor < s->work_count && done < 8 * k_skin_unit_bricks; ++s->cursor, ++done) {
      const uint32_t number = s->work[s->cursor];
      const Brick& brick = s->bricks[number];
      const uint32_t changed = fill_layer(s, number, s->layer);
      if (changed == 0) continue;
      mark(s, brick, changed, k_stale_calm);
      if (s->layer != 0) join_beside(s, brick);
      else mark(s, brick, 0x1ff, k_stale_fill);  // those below
    }
    if (s->cursor < s->work_count) continue;
    s->cursor = 0;
    if (s->layer-- != 0 && s->work_count != 0) continue;
    end_level(s);
    --s->level;
    s->layer = 8;
  }
  return false;
}

bool skin_calm(SkinState* s) {
  return run_stale<k_stale_calm>(s, [&](uint32_t number) { find_calm(s, number); });
}

}  // namespace sandglass
