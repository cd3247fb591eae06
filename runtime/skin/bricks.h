// The lattice's nodes, in bricks of 8^3 where there is sand. Each brick knows those around it, and lies in a chunk of
// 4^3: what is drawn at once.
#pragma once

#include <cstdint>
#include <cstring>

namespace sandglass {

// Instead of a number: no brick, no chunk, no particle, no motion.
constexpr uint32_t k_none = ~0u;

constexpr uint32_t k_brick_shift = 3, k_brick_side = 1u << k_brick_shift;
constexpr uint32_t k_brick_layer = k_brick_side * k_brick_side, k_brick_nodes = k_brick_side * k_brick_layer;
constexpr uint32_t k_chunk_shift = 2, k_chunk_bricks = 1u << k_chunk_shift;  // along an axis
constexpr uint16_t k_vertex_none = 0xffff;

// A node's place along an axis, counted in nodes, gives the brick along that axis and the node's place in the brick.
template <class T>
constexpr T brick_along(T node) {
  return node >> k_brick_shift;
}
template <class T>
constexpr uint32_t node_along(T node) {
  return static_cast<uint32_t>(node) & (k_brick_side - 1);
}

// The place of a brick's first node.
constexpr int32_t first_node(int32_t brick) { return brick * static_cast<int32_t>(k_brick_side); }

// Indices into the arrays of BrickNodes by a node's place in its brick: of the node, and of its row along x. The index
// of a column along y is that of its node in the layer y = 0.
constexpr uint32_t k_node_step[3] = {1, k_brick_layer, k_brick_side};
constexpr uint32_t node_index(uint32_t x, uint32_t y, uint32_t z) { return x + k_brick_layer * y + k_brick_side * z; }
constexpr uint32_t row_index(uint32_t y, uint32_t z) { return k_brick_side * y + z; }
inline uint32_t node_of(const int32_t cell[3]) {
  return node_index(node_along(cell[0]), node_along(cell[1]), node_along(cell[2]));
}

// Indices into Brick::around: of a brick of the 3^3 about one, which itself is at 1, 1, 1. The next brick along x, y or
// z has an index larger by k_around_step.
constexpr uint32_t k_around_step[3] = {1, 9, 3};
constexpr uint32_t around_index(uint32_t x, uint32_t y, uint32_t z) {
  return k_around_step[0] * x + k_around_step[1] * y + k_around_step[2] * z;
}
constexpr uint32_t around_x(uint32_t k) { return k % 3; }
constexpr uint32_t around_y(uint32_t k) { return k / 9; }
constexpr uint32_t around_z(uint32_t k) { return k / 3 % 3; }
constexpr uint32_t k_brick_itself = around_index(1, 1, 1), k_bricks_around = 27;
constexpr uint32_t k_all_around = (1u << k_bricks_around) - 1;
// The index of the brick in which a node lies whose place is counted on from the first node of the brick itself:
// 0..2 * k_brick_side - 1 along each axis.
constexpr uint32_t brick_around(uint32_t x, uint32_t y, uint32_t z) {
  return around_index(1 + brick_along(x), 1 + brick_along(y), 1 + brick_along(z));
}
// The index of the brick itself among those around the brick at `around`.
constexpr uint32_t seen_from(uint32_t around) { return k_bricks_around - 1 - around; }

// What of a brick has to be made anew, as bits.
enum : uint32_t { k_stale_solid = 1, k_stale_density = 2, k_stale_fill = 4, k_stale_calm = 8, k_stale_mesh = 16 };

struct Brick {
  int32_t at[3];  // its first node is at k_brick_side * at
  bool used;
  uint32_t around[k_bricks_around];  // by around_index; k_none where there is none
  uint32_t chunk;
  uint32_t stale;
  uint32_t touches;          // particles that are in its sums
  uint32_t wants;            // bits of `around`: the bricks that its density reaches
  uint32_t first, count;     // its vertices, from the chunk's first
  bool open;                 // no collider is near
  bool walled;               // some of BrickNodes::walls is not 0
  bool room_known;           // BrickNodes::room is up to date
  bool dense, filled, calm;  // some of BrickNodes::density, filled, calm is above 0
};

// What one brick holds, in the order of node_index, row_index or columns.
struct BrickNodes {
  uint32_t sums[k_brick_nodes];
  uint16_t density[k_brick_nodes], filled[k_brick_nodes], calm[k_brick_nodes];
  uint16_t part[k_brick_nodes];        // the part of `filled` that goes into the filter
  uint16_t room[k_brick_nodes];        // what the filter makes of the free shares, in k_skin_one
  uint8_t solid[k_brick_nodes];        // 128 + 48 times the distance to the nearest collider, in nodes
  uint8_t walls[k_brick_nodes];        // bits: a solid lies between this node and the next one along x, y, z
  uint16_t stands[k_brick_layer];      // of each column: bits of the nodes that hold sand or are solid
  uint16_t can[k_brick_layer];         // of each column: bits of the nodes that sand may fill
  uint8_t inside[k_brick_layer];       // of each row: bits of the nodes whose calm density is above the level
  uint8_t beside_sand[k_brick_layer];  // of each row: bits of the nodes with sand within a node
  uint8_t changed[k_brick_layer];  // of each row: bits of the nodes that have changed since the mesh was made of them
  uint32_t particles[k_brick_nodes];  // the first of each cell, or k_none
  uint16_t vertices[k_brick_nodes];   // of each cell, from the brick's first, or k_vertex_none
};

struct SkinChunk {
  int32_t at[3];
  uint32_t bricks;  // that lie in it; 0: free
};

// ---- SkinBricks (bricks.cpp)

struct SkinChunks {
  SkinChunk* records;
  // Numbers of chunks, sorted by place.
  uint32_t* order;
  uint32_t capacity, count;
};

// Which bricks there are. All phases work on what records and nodes hold.
struct SkinBricks {
  Brick* records;
  BrickNodes* nodes;
  // Room for so many; and how many were ever used.
  uint32_t capacity, count;
  // Numbers that are free again.
  uint32_t* free;
  uint32_t free_count;
  // An open hash table: the number of a brick, plus 1.
  uint32_t* slots;
  uint32_t slot_mask;
  SkinChunks chunks;
};

// The place of the brick with index k around a brick at `at`.
void brick_beside(const int32_t at[3], uint32_t k, int32_t other[3]);
uint32_t brick_find(const SkinBricks& bricks, const int32_t at[3]);
// Finds or makes a brick; k_none: there is no room.
uint32_t brick_make(SkinBricks* bricks, const int32_t at[3]);
void brick_release(SkinBricks* bricks, uint32_t brick);
// From now on there are none.
void bricks_forget(SkinBricks* bricks);

// Marks the bricks around one: those of the bits of `around`.
inline void mark_around(SkinBricks* bricks, const Brick& brick, uint32_t around, uint32_t stale) {
  for (; around != 0; around &= around - 1) {
    const uint32_t other = brick.around[__builtin_ctz(around)];
    if (other != k_none) bricks->records[other].stale |= stale;
  }
}

// ---- reading a brick and those around it

// Calls task(y, z, before, own, after) for each row along x of a brick, and of the bricks around up to `apron` nodes
// beyond it. `own` points to the row's eight values in the middle; `before` and `after` to those of the bricks at lower
// and higher x. Where there is no brick they are `outside`.
template <uint32_t apron, class T, class Task>
void each_row(const SkinBricks& bricks, const Brick& brick, T (BrickNodes::*field)[k_brick_nodes], T outside,
              Task task) {
  constexpr uint32_t k_first[3] = {k_brick_side - apron, 0, 0}, k_count[3] = {apron, k_brick_side, apron};
  constexpr uint32_t k_to[3] = {0, apron, apron + k_brick_side};
  T nothing[k_brick_side];
  for (T& value : nothing) value = outside;
  for (uint32_t by = 0; by < 3; ++by)
    for (uint32_t bz = 0; bz < 3; ++bz) {
      const uint32_t* three = brick.around + around_index(0, by, bz);
      const T* from[3];
      uint32_t step_y[3], step_z[3];  // 0: the same row again
      for (uint32_t x = 0; x < 3; ++x) {
        const bool there = three[x] != k_none;
        from[x] = there ? (bricks.nodes[three[x]].*field) + node_index(0, k_first[by], k_first[bz]) : nothing;
        step_y[x] = there ? k_brick_layer : 0;
        step_z[x] = there ? k_brick_side : 0;
      }
      for (uint32_t y = 0; y < k_count[by]; ++y) {
        const T *before = from[0] + y * step_y[0], *own = from[1] + y * step_y[1], *after = from[2] + y * step_y[2];
        for (uint32_t z = 0; z < k_count[bz]; ++z) {
          task(k_to[by] + y, k_to[bz] + z, before, own, after);
          before += step_z[0];
          own += step_z[1];
          after += step_z[2];
        }
      }
    }
}

// A field of a brick's nodes and of the nodes up to `apron` beyond it: a cube of k_brick_side + 2 * apron, in the order
// of nodes.
template <uint32_t apron, class T>
void brick_block(const SkinBricks& bricks, const Brick& brick, T (BrickNodes::*field)[k_brick_nodes], T outside,
                 T* block) {
  constexpr uint32_t k_pitch = k_brick_side + 2 * apron;
  each_row<apron>(bricks, brick, field, outside,
                  [&](uint32_t y, uint32_t z, const T* before, const T* own, const T* after) {
                    T* to = block + (y * k_pitch + z) * k_pitch;
                    memcpy(to, before + k_brick_side - apron, apron * sizeof(T));
                    memcpy(to + apron, own, k_brick_side * sizeof(T));
                    memcpy(to + apron + k_brick_side, after, apron * sizeof(T));
                  });
}

// Whether walls stand between nodes of a brick, or of those around it.
inline bool has_walls(const SkinBricks& bricks, const Brick& brick) {
  for (const uint32_t other : brick.around)
    if (other != k_none && bricks.records[other].walled) return true;
  return false;
}

// Eight values of a cell, linear between them.
struct CellValues {
  float v[8] = {};
  CellValues() = default;
  // The first node's address, and how far the next ones are along x, y and z.
  template <class T>
  CellValues(const T* node, const uint32_t step[3]) {
    for (uint32_t c = 0; c < 8; ++c)
      v[c] = static_cast<float>(node[(c & 1) * step[0] + (c >> 1 & 1) * step[1] + (c >> 2) * step[2]]);
  }

  float sum() const { return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7])); }
  float at(const float u[3]) const {
    float w[4];
    for (uint32_t c = 0; c < 4; ++c) w[c] = v[c] + u[2] * (v[c + 4] - v[c]);
    const float low = w[0] + u[1] * (w[2] - w[0]), high = w[1] + u[1] * (w[3] - w[1]);
    return low + u[0] * (high - low);
  }
  void gradient(const float u[3], float out[3]) const {
    for (uint32_t m = 0; m < 3; ++m) {
      const uint32_t a = 1u << m, b = m == 0 ? 2 : 1, c = m == 2 ? 2 : 4;
      const float ub = m == 0 ? u[1] : u[0], uc = m == 2 ? u[1] : u[2];
      const float d0 = v[a] - v[0], d1 = v[a + b] - v[b], d2 = v[a + c] - v[c], d3 = v[a + b + c] - v[b + c];
      const float low = d0 + ub * (d1 - d0), high = d2 + ub * (d3 - d2);
      out[m] = low + uc * (high - low);
    }
  }
};

}  // namespace sandglass
