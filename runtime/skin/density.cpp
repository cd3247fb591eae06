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

// [1 2 1] / 4 along one axis. What is beyond the block counts as anything: only its inner nodes are right.
template <uint32_t count, uint32_t step>
void filter_along(const uint16_t* from, uint16_t* to) {
  for (uint32_t i = step; i < count - step; ++i)
    to[i] = static_cast<uint16_t>(static_cast<uint16_t>(from[i - step] + 2 * from[i] + from[i + step] + 2) >> 2);
}

// The result stands in `b`.
void filter(uint16_t* a, uint16_t* b) {
  filter_along<k_block, 1>(a, b);
  filter_along<k_block, k_pitch>(b, a);
  filter_along<k_block, k_pitch * k_pitch>(a, b);
}

uint32_t inner(uint32_t y, uint32_t z) { return ((y + 1) * k_pitch + z + 1) * k_pitch + 1; }

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
      const int32_t node[3] = {static_cast<int32_t>(i & 7), static_cast<int32_t>(i >> 6), static_cast<int32_t>(i >> 3 & 7)};
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

// Around which bricks its density reaches, so that there must be bricks.
uint32_t find_wants(const uint16_t* density) {
  uint32_t low[3] = {8, 8, 8}, high[3] = {0, 0, 0};
  for (uint32_t y = 0; y < 8; ++y)
    for (uint32_t z = 0; z < 8; ++z) {
      const uint16_t* row = density + k_brick_layer * y + k_brick_side * z;
      uint32_t any = 0;
      for (uint32_t x = 0; x < 8; ++x) any |= (row[x] > k_reaches ? 1u : 0u) << x;
      if (any == 0) continue;
      const uint32_t first = static_cast<uint32_t>(__builtin_ctz(any)), last = 31 - static_cast<uint32_t>(__builtin_clz(any));
      low[0] = first < low[0] ? first : low[0], high[0] = last > high[0] ? last : high[0];
      low[1] = y < low[1] ? y : low[1], high[1] = y > high[1] ? y : high[1];
      low[2] = z < low[2] ? z : low[2], high[2] = z > high[2] ? z : high[2];
    }
  if (low[0] == 8) return 0;
  uint32_t wants = 0;
  for (uint32_t k = 0; k < k_bricks_around; ++k) {
    const uint32_t x = k % 3, y = k / 9, z = k / 3 % 3;
    const bool reaches = (x == 1 || (x == 0 ? low[0] < 6 : high[0] > 1)) && (z == 1 || (z == 0 ? low[2] < 6 : high[2] > 1)) &&
                         (y == 1 || (y == 0 ? low[1] < 6 : high[1] > 5));
    if (reaches) wants |= 1u << k;
  }
  return wants;
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
    const int32_t at[3] = {brick.at[0] + static_cast<int32_t>(k % 3) - 1, brick.at[1] + static_cast<int32_t>(k / 9) - 1,
                           brick.at[2] + static_cast<int32_t>(k / 3 % 3) - 1};
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
    uint32_t sums[k_block];
    uint16_t a[k_block], b[k_block];
    brick_block<1>(*s, brick, &BrickNodes::sums, 0u, sums);
    for (uint32_t i = 0; i < k_block; ++i) {
      const uint32_t sum = sums[i] < k_most_sum ? sums[i] : k_most_sum;
      a[i] = static_cast<uint16_t>(sum * k_gain >> 16);
    }
    filter(a, b);
    for (uint32_t y = 0; y < 8; ++y)
      for (uint32_t z = 0; z < 8; ++z) {
        const uint16_t* from = b + inner(y, z);
        const uint32_t row = k_brick_layer * y + k_brick_side * z;
        for (uint32_t x = 0; x < 8; ++x) {
          const uint32_t value = from[x] * uint32_t{s->by_free[nodes.solid[row + x]]} >> 12;
          fresh[row + x] = static_cast<uint16_t>(value < k_skin_one ? value : k_skin_one);
        }
      }
  }
  uint8_t stands[k_brick_layer] = {};
  for (uint32_t y = 0; y < 8; ++y)
    for (uint32_t c = 0; c < k_brick_layer; ++c) {
      const bool there = fresh[k_brick_layer * y + c] > k_skin_level || nodes.solid[k_brick_layer * y + c] < 128;
      stands[c] = static_cast<uint8_t>(stands[c] | (there ? 1u : 0u) << y);
    }
  if (memcmp(stands, nodes.stands, sizeof stands) != 0) {
    memcpy(nodes.stands, stands, sizeof stands);
    brick.stale |= k_stale_fill;
    const uint32_t above = brick.around[k_brick_itself + 9];
    if (above != k_brick_none) s->bricks[above].stale |= k_stale_fill;
  }
  if (memcmp(fresh, nodes.density, sizeof fresh) == 0) return;
  memcpy(nodes.density, fresh, sizeof fresh);
  brick.stale |= k_stale_fill;
  brick.wants = find_wants(fresh);
  make_wanted(s, number);
}

// ---- fill

// Where sand has something to stand on: within four nodes below.
void find_where(const SkinState& s, const Brick& brick, BrickNodes* nodes) {
  const uint32_t below = brick.around[k_brick_itself - 9];
  for (uint32_t c = 0; c < k_brick_layer; ++c) {
    const uint32_t under = below == k_brick_none ? 0u : s.nodes[below].stands[c];
    const uint32_t all = static_cast<uint32_t>(nodes->stands[c]) << 8 | under;
    nodes->can[c] = static_cast<uint8_t>(all >> 4 | all >> 5 | all >> 6 | all >> 7 | all >> 8);
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
void layer_above(const SkinState& s, const Brick& brick, uint32_t layer, uint16_t above[k_wide * k_wide]) {
  const uint32_t row = layer == 7 ? 18 : 9, from_layer = layer == 7 ? 0 : layer + 1;
  for (uint32_t bz = 0; bz < 3; ++bz)
    for (uint32_t bx = 0; bx < 3; ++bx) {
      const uint32_t number = brick.around[row + 3 * bz + bx];
      const uint32_t nx = bx == 1 ? 8 : 2, nz = bz == 1 ? 8 : 2, fx = bx == 0 ? 6 : 0, fz = bz == 0 ? 6 : 0;
      const uint32_t tx = bx == 0 ? 0 : bx == 1 ? 2 : 10, tz = bz == 0 ? 0 : bz == 1 ? 2 : 10;
      for (uint32_t z = 0; z < nz; ++z) {
        uint16_t* to = above + (tz + z) * k_wide + tx;
        if (number == k_brick_none) {
          memset(to, 0, nx * sizeof *to);
          continue;
        }
        const uint16_t* from = s.nodes[number].filled + k_brick_layer * from_layer + k_brick_side * (fz + z) + fx;
        memcpy(to, from, nx * sizeof *to);
      }
    }
}

uint16_t more(uint16_t a, uint16_t b) { return a > b ? a : b; }

// Fills one layer. Whether it has changed.
bool fill_layer(SkinState* s, uint32_t number, uint32_t layer) {
  const Brick& brick = s->bricks[number];
  BrickNodes& nodes = s->nodes[number];
  uint16_t above[k_wide * k_wide], fresh[k_brick_layer];
  layer_above(*s, brick, layer, above);
  const int32_t height = 8 * brick.at[1] + static_cast<int32_t>(layer);
  const int32_t lean = lean_of(*s, 0, height) + static_cast<int32_t>(k_wide) * lean_of(*s, 1, height);
  const uint16_t* density = nodes.density + k_brick_layer * layer;
  const bool wide = (height & 1) != 0;
  for (uint32_t z = 0; z < 8; ++z) {
    const uint16_t* up = above + static_cast<int32_t>(k_wide * (z + 2) + 2) - lean;
    for (uint32_t x = 0; x < 8; ++x) {
      const uint16_t *m = up + x, *l = m - k_wide, *r = m + k_wide;
      uint16_t most = more(more(more(m[0], m[-1]), more(m[1], l[0])), r[0]);
      if (wide) most = more(most, more(more(l[-1], l[1]), more(r[-1], r[1])));
      const uint16_t less = most > k_fill_less + k_fill_least ? static_cast<uint16_t>(most - k_fill_less) : uint16_t{0};
      const bool can = (nodes.can[k_brick_side * z + x] >> layer & 1) != 0;
      fresh[k_brick_side * z + x] = can ? more(density[k_brick_side * z + x], less) : density[k_brick_side * z + x];
    }
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

void collect_level(SkinState* s) {
  s->work_count = s->cursor = 0;
  s->layer = 7;
  for (uint32_t b = 0; b < s->brick_count; ++b) {
    Brick& brick = s->bricks[b];
    if (brick.used == 0 || (brick.stale & k_stale_fill) == 0 || brick.at[1] != static_cast<int32_t>(s->level)) continue;
    brick.fill_from = 8;
    brick.filled = 0;
    find_where(*s, brick, &s->nodes[b]);
    s->work[s->work_count++] = b;
  }
}

void end_level(SkinState* s) {
  for (uint32_t i = 0; i < s->work_count; ++i) {
    Brick& brick = s->bricks[s->work[i]];
    brick.stale &= ~k_stale_fill;
    if (brick.filled != 0) mark_around(s, brick, k_stale_calm);
    brick.fill_from = 8;
  }
}

// ---- calm

void find_calm(SkinState* s, uint32_t number) {
  Brick& brick = s->bricks[number];
  BrickNodes& nodes = s->nodes[number];
  uint16_t a[k_block], b[k_block], fresh[k_brick_nodes];
  brick_block<1>(*s, brick, &BrickNodes::filled, uint16_t{0}, a);
  if (brick.open != 0) {
    filter(a, b);
    for (uint32_t y = 0; y < 8; ++y)
      for (uint32_t z = 0; z < 8; ++z)
        memcpy(fresh + k_brick_layer * y + k_brick_side * z, b + inner(y, z), 8 * sizeof *b);
  } else {
    uint8_t solid[k_block];
    uint16_t c[k_block], d[k_block];
    brick_block<1>(*s, brick, &BrickNodes::solid, uint8_t{255}, solid);
    for (uint32_t i = 0; i < k_block; ++i) {
      const uint32_t free = skin_free(solid[i]);
      c[i] = static_cast<uint16_t>(16 * free);
      a[i] = static_cast<uint16_t>(a[i] * free >> 8);
    }
    filter(a, b);
    filter(c, d);
    for (uint32_t y = 0; y < 8; ++y)
      for (uint32_t z = 0; z < 8; ++z)
        for (uint32_t x = 0; x < 8; ++x) {
          const uint32_t i = inner(y, z) + x, at = k_brick_layer * y + k_brick_side * z + x;
          fresh[at] = d[i] > k_skin_one / 16 ? static_cast<uint16_t>(b[i] * k_skin_one / d[i]) : nodes.filled[at];
          if (fresh[at] > k_skin_one) fresh[at] = k_skin_one;
        }
  }
  if (memcmp(fresh, nodes.calm, sizeof fresh) == 0) return;
  memcpy(nodes.calm, fresh, sizeof fresh);
  uint16_t low = fresh[0], high = fresh[0];
  for (const uint16_t value : fresh) low = value < low ? value : low, high = value > high ? value : high;
  brick.low = low, brick.high = high;
  for (uint32_t row = 0; row < k_brick_layer; ++row) {
    uint32_t inside = 0;
    for (uint32_t x = 0; x < 8; ++x) inside |= (fresh[8 * row + x] > k_skin_level ? 1u : 0u) << x;
    nodes.inside[row] = static_cast<uint8_t>(inside);
  }
  mark_around(s, brick, k_stale_mesh);
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

uint32_t skin_free(uint8_t solid) {
  // The ramp of a wall through the sums' spread and the filter: its slope is 0.49 a node.
  const int32_t free = 128 + (static_cast<int32_t>(solid) - 128) * 21 / 8;
  return free > 0 ? (free < 256 ? static_cast<uint32_t>(free) : 256u) : 0u;
}

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
      for (uint32_t k = 0; k < 3; ++k) now.linear[k] = now.angular[k] = 0;
      if (i < s->collider_count && version == s->fields[i] && memcmp(&now, &s->colliders[i], sizeof now) == 0) continue;
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
