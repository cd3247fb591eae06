// From sums to a density whose level is the surface, brick by brick.
//
//   solid     the distance to the nearest collider; a node beside one has less room, and its density counts for more
//   density   the sums through a filter [1 2 1] / 4 along each axis, over the room
//   fill      dry sand does not overhang, and stands no steeper than one in one: from above to below a node gets the most of
//             the nodes over it, a little less, where it is not far above sand or a collider
//   calm      the filter once more; what is solid takes no part in it, so that the surface meets a floor at its slope
#include <cstring>

#include "runtime/field/field.h"
#include "runtime/granular/granular.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr uint32_t k_most = 4 * k_skin_one - 1;  // so that the filter's sums fit 16 bits
constexpr uint32_t k_gain = static_cast<uint32_t>(k_skin_volume / (k_skin_spacing * k_skin_spacing * k_skin_spacing) *
                                                  (65536.0f / k_skin_shares));  // of sums, in 1/65536
constexpr uint32_t k_most_sum = static_cast<uint32_t>(uint64_t{k_most} * 65536 / k_gain);
constexpr uint32_t k_fill_less = 410, k_fill_least = 819;  // 0.1 and 0.2
constexpr uint32_t k_reaches = 1376;                       // a density that may become surface beside it: 0.34
constexpr float k_solid_one = 48.0f, k_solid_reach = 2.6f;
constexpr uint32_t k_pitch = k_brick_side + 2, k_block = k_pitch * k_pitch * k_pitch;

// The result stands in `b`.
void filter(uint16_t* a, uint16_t* b) {
  filter_along<k_block, 1>(a, b);
  filter_along<k_block, k_pitch>(b, a);
  filter_along<k_block, k_pitch * k_pitch>(a, b);
}

uint32_t inner(uint32_t y, uint32_t z) { return ((y + 1) * k_pitch + z + 1) * k_pitch + 1; }

uint16_t bounded_whole(uint32_t value) { return static_cast<uint16_t>(value < 0xffff ? value : 0xffff); }

// A block without its apron.
void inner_nodes(const uint16_t* block, uint16_t* nodes) {
  for (uint32_t y = 0; y < 8; ++y)
    for (uint32_t z = 0; z < 8; ++z)
      memcpy(nodes + k_brick_layer * y + k_brick_side * z, block + inner(y, z), k_brick_side * sizeof *nodes);
}

void mark_around(SkinState* s, const Brick& brick, uint32_t stale) {
  for (const uint32_t other : brick.around)
    if (other != k_brick_none) s->bricks[other].stale |= stale;
}

// Whether a collider is so near to a brick that its nodes feel it.
bool is_near(const SkinState& s, const float middle[3], const ColliderFrame& c) {
  const float half = 0.5f * k_brick_side * s.spacing, reach = half + (k_solid_reach + 0.5f) * s.spacing;
  float d[3];
  for (uint32_t k = 0; k < 3; ++k) d[k] = middle[k] - c.position[k];
  if (c.shape == SANDGLASS_SHAPE_HALF_SPACE) {
    float along = 0, width = 0;
    for (uint32_t k = 0; k < 3; ++k) along += d[k] * c.axes[1][k], width += __builtin_fabsf(c.axes[1][k]);
    return along < reach * width;
  }
  if (c.shape == SANDGLASS_SHAPE_FIELD) {
    if (c.field.outward < 0) return true;
    for (uint32_t a = 0; a < 3; ++a) {
      float along = 0, width = 0;
      for (uint32_t k = 0; k < 3; ++k) along += d[k] * c.axes[a][k], width += __builtin_fabsf(c.axes[a][k]);
      const float high = c.field.low[a] + static_cast<float>(c.field.counts[a] - 1) * c.field.spacing;
      if (along < c.field.low[a] - reach * width || along > high + reach * width) return false;
    }
    return true;
  }
  for (uint32_t k = 0; k < 3; ++k)
    if (__builtin_fabsf(d[k]) > c.extent[k] + reach) return false;
  return true;
}

bool stands_as(const ColliderFrame& a, const ColliderFrame& b) {
  bool same = a.shape == b.shape && a.field.values == b.field.values;
  for (uint32_t k = 0; k < 3; ++k) {
    same = same && a.position[k] == b.position[k] && a.size[k] == b.size[k];
    for (uint32_t m = 0; m < 3; ++m) same = same && a.axes[k][m] == b.axes[k][m];
  }
  return same;
}

// World, metres.
void middle_of(const SkinState& s, const Brick& brick, float middle[3]) {
  for (uint32_t a = 0; a < 3; ++a)
    middle[s.axis[a]] = s.sign[a] * s.spacing * (static_cast<float>(brick.at[a]) + 0.5f) * k_brick_side;
}

void find_solid(SkinState* s, uint32_t number) {
  Brick& brick = s->bricks[number];
  uint8_t* solid = s->nodes[number].solid;
  float middle[3];
  middle_of(*s, brick, middle);
  brick.open = 1;
  memset(solid, 255, k_brick_nodes);
  for (uint32_t c = 0; c < s->collider_count; ++c) {
    if (!is_near(*s, middle, s->colliders[c])) continue;
    for (uint32_t i = 0; i < k_brick_nodes; ++i) {
      const int32_t node[3] = {static_cast<int32_t>(i & 7), static_cast<int32_t>(i >> 6),
                               static_cast<int32_t>(i >> 3 & 7)};
      for (uint32_t a = 0; a < 3; ++a)
        s->points[i].position[s->axis[a]] =
            s->sign[a] * s->spacing * (static_cast<float>(8 * brick.at[a] + node[a]) + 0.5f);
    }
    const SurfaceArgs args = {s->points, &s->colliders[c]};
    uint32_t unused = 0;
    s->kernels->surface_at(&args, 0, k_brick_nodes, &unused);
    for (uint32_t i = 0; i < k_brick_nodes; ++i) {
      const float value = 128.5f + k_solid_one * s->inverse_spacing * s->points[i].distance;
      const uint32_t whole = to_whole<uint32_t>(value < 255.0f ? value : 255.0f);
      if (whole < solid[i]) solid[i] = static_cast<uint8_t>(whole);
      if (whole < 255) brick.open = 0;
    }
  }
}

// How near to a brick's faces a value may be and count beyond them: below and above along each axis.
struct Reach {
  uint16_t least;  // what is above it counts
  uint32_t side, down, up;
};
constexpr Reach k_wanted = {k_reaches, 6, 6, 2}, k_filter_reach = {0, 1, 1, 1}, k_mesh_reach = {0, 4, 4, 4};

// Bits of Brick::around into which values reach; its own one where there are any.
uint32_t reach_of(const uint16_t* values, const Reach& reach) {
  uint16_t columns[k_brick_layer] = {}, along_x[8] = {};  // the most over y; and over z
  uint32_t any_x = 0, any_y = 0, any_z = 0;               // bits of the planes that hold any
  for (uint32_t y = 0; y < 8; ++y) {
    const uint16_t* layer = values + k_brick_layer * y;
    uint16_t most = 0;
    for (uint32_t c = 0; c < k_brick_layer; ++c) {
      columns[c] = layer[c] > columns[c] ? layer[c] : columns[c];
      most = layer[c] > most ? layer[c] : most;
    }
    any_y |= (most > reach.least ? 1u : 0u) << y;
  }
  if (any_y == 0) return 0;
  for (uint32_t z = 0; z < 8; ++z) {
    uint16_t most = 0;
    for (uint32_t x = 0; x < 8; ++x) {
      const uint16_t value = columns[k_brick_side * z + x];
      along_x[x] = value > along_x[x] ? value : along_x[x];
      most = value > most ? value : most;
    }
    any_z |= (most > reach.least ? 1u : 0u) << z;
  }
  for (uint32_t x = 0; x < 8; ++x) any_x |= (along_x[x] > reach.least ? 1u : 0u) << x;
  const auto low = [](uint32_t bits, uint32_t nodes) { return (bits & ((1u << nodes) - 1)) != 0 ? 1u : 0u; };
  const auto high = [](uint32_t bits, uint32_t nodes) { return (bits >> (8 - nodes)) != 0 ? 4u : 0u; };
  const uint32_t x = low(any_x, reach.side) | 2u | high(any_x, reach.side);
  const uint32_t z = low(any_z, reach.side) | 2u | high(any_z, reach.side);
  const uint32_t y = low(any_y, reach.down) | 2u | high(any_y, reach.up);
  uint32_t found = 0;
  for (uint32_t k = 0; k < k_bricks_around; ++k)
    if ((x >> k % 3 & y >> k / 9 & z >> k / 3 % 3 & 1) != 0) found |= 1u << k;
  return found;
}

void mark_reached(SkinState* s, const Brick& brick, uint32_t reach, uint32_t stale) {
  for (; reach != 0; reach &= reach - 1) {
    const uint32_t other = brick.around[__builtin_ctz(reach)];
    if (other != k_brick_none) s->bricks[other].stale |= stale;
  }
}

uint8_t holds_any(const uint16_t* values) {
  uint32_t any = 0;
  for (uint32_t i = 0; i < k_brick_nodes; ++i) any |= values[i];
  return any != 0 ? 1 : 0;
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

void find_density(SkinState* s, uint32_t number) {
  Brick& brick = s->bricks[number];
  BrickNodes& nodes = s->nodes[number];
  uint16_t fresh[k_brick_nodes];
  if (!sand_is_around(*s, brick)) {
    memset(fresh, 0, sizeof fresh);
  } else {
    uint32_t* sums = s->blocks->sums;
    uint16_t a[k_block], b[k_block];
    brick_block<1>(*s, brick, &BrickNodes::sums, 0u, sums);
    for (uint32_t i = 0; i < k_block; ++i) {
      const uint32_t sum = sums[i] < k_most_sum ? sums[i] : k_most_sum;
      a[i] = static_cast<uint16_t>(sum * k_gain >> 16);
    }
    filter(a, b);
    inner_nodes(b, fresh);
    if (brick.open == 0)
      for (uint32_t i = 0; i < k_brick_nodes; ++i)
        fresh[i] = bounded_whole(uint32_t{fresh[i]} * s->by_free[nodes.solid[i]] >> 12);
    for (uint16_t& value : fresh) value = value < k_skin_one ? value : uint16_t{k_skin_one};
  }
  uint8_t stands[k_brick_layer] = {};
  for (uint32_t y = 0; y < 8; ++y) {
    const uint16_t* layer = fresh + k_brick_layer * y;
    const uint8_t* solid = nodes.solid + k_brick_layer * y;
    for (uint32_t c = 0; c < k_brick_layer; ++c) {  // above the level, by the sign of the difference; below 128
      const uint8_t sand = static_cast<uint8_t>(static_cast<uint16_t>(k_skin_level - layer[c]) >> 15);
      const uint8_t wall = static_cast<uint8_t>(static_cast<uint8_t>(~solid[c]) >> 7);
      stands[c] = static_cast<uint8_t>(stands[c] | static_cast<uint8_t>((sand | wall) << y));
    }
  }
  if (memcmp(stands, nodes.stands, sizeof stands) != 0) {
    memcpy(nodes.stands, stands, sizeof stands);
    brick.stale |= k_stale_fill;
    const uint32_t above = brick.around[k_brick_itself + 9];
    if (above != k_brick_none) s->bricks[above].stale |= k_stale_fill;
  }
  if (memcmp(fresh, nodes.density, sizeof fresh) == 0) return;
  memcpy(nodes.density, fresh, sizeof fresh);
  brick.dense = holds_any(fresh);
  brick.stale |= k_stale_fill;
  brick.wants = reach_of(fresh, k_wanted);
  make_wanted(s, number);
}

// ---- fill

// Where sand has something to stand on: within four nodes below. Without gravity nothing falls.
void find_where(const SkinState& s, const Brick& brick, BrickNodes* nodes) {
  constexpr uint8_t k_nothing[k_brick_layer] = {};
  const uint32_t below = brick.around[k_brick_itself - 9];
  const uint8_t *under = below == k_brick_none ? k_nothing : s.nodes[below].stands, *here = nodes->stands;
  uint8_t can[k_brick_layer];
  for (uint32_t c = 0; c < k_brick_layer; ++c) {
    const uint16_t all = static_cast<uint16_t>(here[c] << 8 | under[c]);
    can[c] = static_cast<uint8_t>(all >> 4 | all >> 5 | all >> 6 | all >> 7 | all >> 8);
  }
  if (!s.falls) memset(can, 0, sizeof can);
  memcpy(nodes->can, can, sizeof can);
}

int32_t rounded(int64_t v) { return static_cast<int32_t>((v + k_skin_one / 2) >> 12); }

// How far the layer above is moved against this one where up leans.
int32_t lean_of(const SkinState& s, uint32_t k, int32_t layer) {
  const int64_t lean = s.lean[k];
  return rounded(-lean * layer) - rounded(-lean * (layer + 1));
}

// The layer above one, with two nodes of the bricks beside it on every side.
constexpr uint32_t k_wide = 12;
void layer_above(const SkinState& s, const Brick& brick, uint32_t layer, uint16_t* above) {
  constexpr uint16_t k_nothing[k_brick_side] = {};
  const uint32_t first = layer == 7 ? 18 : 9, from_layer = layer == 7 ? 0 : layer + 1;
  for (uint32_t z = 0; z < k_wide; ++z, above += k_wide) {
    const uint32_t from_z = z + k_brick_side - 2;
    const uint32_t* three = brick.around + first + 3 * (from_z / k_brick_side);
    const uint32_t row = k_brick_layer * from_layer + k_brick_side * (from_z % k_brick_side);
    const uint16_t* from[3];
    for (uint32_t x = 0; x < 3; ++x) from[x] = three[x] == k_brick_none ? k_nothing : s.nodes[three[x]].filled + row;
    memcpy(above, from[0] + k_brick_side - 2, 2 * sizeof *above);
    memcpy(above + 2, from[1], k_brick_side * sizeof *above);
    memcpy(above + 2 + k_brick_side, from[2], 2 * sizeof *above);
  }
}

uint16_t more(uint16_t a, uint16_t b) { return a > b ? a : b; }

// What falls from the nodes over a row: `up` is the one over its first node.
template <bool wide>
void fill_row(const uint16_t* __restrict up, const uint16_t* __restrict density, const uint8_t* __restrict can,
              uint32_t layer, uint16_t* __restrict fresh) {
  const uint16_t *l = up - k_wide, *r = up + k_wide;
  for (int32_t x = 0; x < static_cast<int32_t>(k_brick_side); ++x) {
    uint16_t most = more(more(up[x], more(up[x - 1], up[x + 1])), more(l[x], r[x]));
    if (wide) most = more(most, more(more(l[x - 1], l[x + 1]), more(r[x - 1], r[x + 1])));
    const uint16_t less = static_cast<uint16_t>(more(most, k_fill_less) - k_fill_less);
    const uint16_t falls = (can[x] >> layer & 1) != 0 && less > k_fill_least ? less : uint16_t{0};
    fresh[x] = more(density[x], falls);
  }
}

// Fills one layer. Whether it has changed.
bool fill_layer(SkinState* s, uint32_t number, uint32_t layer) {
  const Brick& brick = s->bricks[number];
  BrickNodes& nodes = s->nodes[number];
  uint16_t above[k_wide * k_wide], fresh[k_brick_layer];
  layer_above(*s, brick, layer, above);
  const int32_t height = 8 * brick.at[1] + static_cast<int32_t>(layer);
  const int32_t lean = lean_of(*s, 0, height) + static_cast<int32_t>(k_wide) * lean_of(*s, 1, height);
  for (uint32_t z = 0; z < k_brick_side; ++z) {
    const uint16_t* up = above + static_cast<int32_t>(k_wide * (z + 2) + 2) - lean;
    const uint32_t row = k_brick_side * z;
    const auto fill = (height & 1) != 0 ? fill_row<true> : fill_row<false>;
    fill(up, nodes.density + k_brick_layer * layer + row, nodes.can + row, layer, fresh + row);
  }
  uint16_t* filled = nodes.filled + k_brick_layer * layer;
  if (memcmp(fresh, filled, sizeof fresh) == 0) return false;
  memcpy(filled, fresh, sizeof fresh);
  return true;
}

// The bricks beside one read its layer for their next one.
void join_beside(SkinState* s, uint32_t number, uint32_t layer) {
  for (uint32_t k = 9; k < 18; ++k) {
    const uint32_t other = s->bricks[number].around[k];
    if (other == k_brick_none || other == number) continue;
    Brick& beside = s->bricks[other];
    if ((beside.stale & k_stale_fill) == 0) {
      beside.stale |= k_stale_fill;
      beside.fill_from = layer;
      beside.filled = 0;
      find_where(*s, beside, &s->nodes[other]);
      s->work[s->work_count++] = other;
    } else if (beside.fill_from < layer) {
      beside.fill_from = layer;
    }
  }
}

// Whether it holds sand, or sand may fall into it.
bool can_hold(const SkinState& s, const Brick& brick) {
  if (brick.filled_reach != 0) return true;
  for (uint32_t k = 9; k < k_bricks_around; ++k) {
    const uint32_t other = brick.around[k];
    if (other != k_brick_none && (s.bricks[other].dense != 0 || s.bricks[other].filled_reach != 0)) return true;
  }
  return false;
}

void collect_level(SkinState* s) {
  s->work_count = s->cursor = 0;
  s->layer = 7;
  for (uint32_t b = 0; b < s->brick_count; ++b) {
    Brick& brick = s->bricks[b];
    if (brick.used == 0 || (brick.stale & k_stale_fill) == 0 || brick.at[1] != static_cast<int32_t>(s->level)) continue;
    brick.fill_from = 8;
    brick.filled = 0;
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
    if (brick.filled != 0) {
      const uint32_t before = brick.filled_reach;
      brick.filled_reach = reach_of(s->nodes[s->work[i]].filled, k_filter_reach);
      mark_reached(s, brick, before | brick.filled_reach, k_stale_calm);
    }
  }
}

// ---- calm

// The free shares through the filter.
void find_room(const uint8_t* solid, uint16_t* room) {
  uint16_t a[k_block], b[k_block];
  for (uint32_t i = 0; i < k_block; ++i) a[i] = static_cast<uint16_t>(skin_part(solid[i]) << 4);
  filter(a, b);
  inner_nodes(b, room);
}

// Sand fades within a wall, so that its surface lies a third of a node deep in it.
uint16_t within_wall(uint16_t value, uint8_t solid) {
  constexpr int32_t k_one = 48, k_deepest = 128 - 36;
  const int32_t part = solid - k_deepest;
  return static_cast<uint16_t>(value * (part < 0 ? 0 : part < k_one ? part : k_one) / k_one);
}

void find_calm(SkinState* s, uint32_t number) {
  Brick& brick = s->bricks[number];
  BrickNodes& nodes = s->nodes[number];
  uint16_t a[k_block], b[k_block], fresh[k_brick_nodes];
  brick_block<1>(*s, brick, &BrickNodes::filled, uint16_t{0}, a);
  if (brick.open != 0) {
    filter(a, b);
    inner_nodes(b, fresh);
  } else {
    constexpr uint16_t k_least = k_skin_one / 128;
    uint8_t solid[k_block];
    brick_block<1>(*s, brick, &BrickNodes::solid, uint8_t{255}, solid);
    for (uint32_t i = 0; i < k_block; ++i) a[i] = static_cast<uint16_t>(uint32_t{a[i]} * skin_part(solid[i]) >> 8);
    filter(a, b);
    if (brick.room_known == 0) find_room(solid, nodes.room);
    brick.room_known = 1;
    inner_nodes(b, fresh);
    for (uint32_t i = 0; i < k_brick_nodes; ++i) {
      const int32_t room = nodes.room[i], kept = nodes.filled[i], most = room > k_least ? room : k_least;
      const int32_t share =
          static_cast<int32_t>(k_skin_one * static_cast<float>(int32_t{fresh[i]}) / static_cast<float>(most));
      const int32_t calm = share < int32_t{k_skin_one} ? share : int32_t{k_skin_one};
      fresh[i] = static_cast<uint16_t>(room > k_least ? calm : kept);
    }
    if (s->desc.closed != 0)
      for (uint32_t i = 0; i < k_brick_nodes; ++i) fresh[i] = within_wall(fresh[i], nodes.solid[i]);
  }
  if (memcmp(fresh, nodes.calm, sizeof fresh) == 0) return;
  memcpy(nodes.calm, fresh, sizeof fresh);
  for (uint32_t row = 0; row < k_brick_layer; ++row) {
    constexpr uint16_t k_bits[8] = {1, 2, 4, 8, 16, 32, 64, 128};
    uint16_t inside = 0;
    for (uint32_t x = 0; x < 8; ++x)
      inside = static_cast<uint16_t>(inside + (fresh[8 * row + x] > k_skin_level ? k_bits[x] : uint16_t{0}));
    nodes.inside[row] = static_cast<uint8_t>(inside);
  }
  const uint32_t before = brick.calm_reach;
  brick.calm_reach = reach_of(fresh, k_mesh_reach);
  mark_reached(s, brick, before | brick.calm_reach, k_stale_mesh);
}

// Runs `task` on the next bricks that are stale in this way. True: there are none left.
template <uint32_t bit, class Task>
bool run_stale(SkinState* s, Task task) {
  for (uint32_t done = 0; s->cursor < s->brick_count; ++s->cursor) {
    Brick& brick = s->bricks[s->cursor];
    if (brick.used == 0 || (brick.stale & bit) == 0) continue;
    if (done++ == k_skin_unit_bricks) return false;
    brick.stale &= ~bit;
    task(s->cursor);
  }
  for (uint32_t b = 0; b < s->brick_count; ++b)
    if (s->bricks[b].used != 0 && (s->bricks[b].stale & bit) != 0) {
      s->cursor = b;
      return false;
    }
  s->cursor = 0;
  return true;
}

}  // namespace

// A collider that has come, gone or moved changes the bricks near where it was and near where it is.
void skin_take_colliders(SkinState* s) {
  const Colliders& given = s->granular->colliders;
  const uint32_t count = given.count < s->desc.collider_capacity ? given.count : s->desc.collider_capacity;
  const auto mark = [&](const ColliderFrame& collider) {
    for (uint32_t b = 0; b < s->brick_count; ++b) {
      Brick& brick = s->bricks[b];
      float middle[3];
      if (brick.used == 0) continue;
      middle_of(*s, brick, middle);
      if (is_near(*s, middle, collider)) brick.stale |= k_stale_solid | k_stale_density, s->asked = true;
    }
  };
  for (uint32_t i = 0; i < count || i < s->collider_count; ++i) {
    ColliderFrame now = {};
    uint64_t version = 0;
    if (i < count) {
      const sandglass_collider& collider = given.given[i];
      colliders_pose(&collider, 1, 0.0f, &now);
      version = collider.shape == SANDGLASS_SHAPE_FIELD ? collider.field->version : 0;
      if (i < s->collider_count && version == s->fields[i] && stands_as(now, s->colliders[i])) continue;
    }
    if (i < s->collider_count) mark(s->colliders[i]);
    s->colliders[i] = now;
    s->fields[i] = version;
    if (i < count) mark(now);
  }
  s->collider_count = count;
}

bool skin_density(SkinState* s) {
  return run_stale<k_stale_density>(s, [&](uint32_t number) {
    Brick& brick = s->bricks[number];
    if ((brick.stale & k_stale_solid) != 0) {
      find_solid(s, number);
      brick.stale = (brick.stale & ~k_stale_solid) | k_stale_mesh;
      mark_around(s, brick, k_stale_calm);
      for (const uint32_t other : brick.around)
        if (other != k_brick_none) s->bricks[other].room_known = 0;
    }
    find_density(s, number);
  });
}

void skin_begin_fill(SkinState* s) {
  int32_t low = 0, high = -1;
  for (uint32_t b = 0; b < s->brick_count; ++b) {
    if (s->bricks[b].used == 0) continue;
    const int32_t y = s->bricks[b].at[1];
    if (low > high) low = high = y;
    low = y < low ? y : low, high = y > high ? y : high;
  }
  s->level_low = static_cast<uint32_t>(low), s->level = static_cast<uint32_t>(high);
  s->layer = 8;
}

bool skin_fill(SkinState* s) {
  for (uint32_t done = 0; done < 8 * k_skin_unit_bricks;) {
    if (static_cast<int32_t>(s->level) < static_cast<int32_t>(s->level_low)) {
      s->cursor = 0;
      return true;
    }
    if (s->layer == 8) {
      collect_level(s);
      ++done;
    }
    for (; s->cursor < s->work_count && done < 8 * k_skin_unit_bricks; ++s->cursor) {
      const uint32_t number = s->work[s->cursor];
      Brick& brick = s->bricks[number];
      if (brick.fill_from <= s->layer) continue;
      ++done;
      if (!fill_layer(s, number, s->layer)) continue;
      brick.filled = 1;
      if (s->layer != 0) {
        join_beside(s, number, s->layer);
        continue;
      }
      for (uint32_t k = 0; k < 9; ++k)
        if (brick.around[k] != k_brick_none) s->bricks[brick.around[k]].stale |= k_stale_fill;
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
