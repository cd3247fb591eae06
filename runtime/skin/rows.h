// Eight nodes along x at once: compilers know vectors, and do the same to each lane. And which bricks feel what has
// changed in the rows of one.
#pragma once

#include "runtime/skin/bricks.h"

namespace sandglass {

using Row = uint16_t __attribute__((vector_size(16)));
inline Row row_at(const uint16_t* nodes) {
  Row row;
  memcpy(&row, nodes, sizeof row);
  return row;
}
inline void set_row(uint16_t* nodes, Row row) { memcpy(nodes, &row, sizeof row); }

inline Row max_of(Row a, Row b) { return a > b ? a : b; }
inline Row min_of(Row a, Row b) { return a < b ? a : b; }
inline Row where_above(Row a, uint16_t level) {
  return reinterpret_cast<Row>(a > level);
}  // all bits of a node, or none

inline bool any_of(Row row) {
  uint64_t half[2];
  memcpy(half, &row, sizeof row);
  return (half[0] | half[1]) != 0;
}

// A bit for each node.
inline uint8_t bits_of(Row row) {
  constexpr Row k_bits = {1, 2, 4, 8, 16, 32, 64, 128};
  row &= k_bits;
  uint32_t sum = 0;
  for (uint32_t x = 0; x < k_brick_side; ++x) sum += row[x];
  return static_cast<uint8_t>(sum);
}

inline bool any_of(const uint16_t* values) {
  Row any = {};
  for (uint32_t i = 0; i < k_brick_nodes; i += k_brick_side) any |= row_at(values + i);
  return any_of(any);
}

// Eight nodes of BrickNodes::solid.
inline Row solid_at(const uint8_t* solid) {
  uint8_t __attribute__((vector_size(8))) eight;
  memcpy(&eight, solid, sizeof eight);
  return __builtin_convertvector(eight, Row);
}

// How many nodes from a brick's faces what is there counts for the next brick: low and high along x and z, down and up.
struct Reach {
  uint32_t low, high, down, up;
};
constexpr Reach k_wanted = {6, 6, 6, 2}, k_filter_reach = {1, 1, 1, 1}, k_mesh_reach = {2, 1, 2, 1};

// Bits of Brick::around: the bricks that some nodes reach, given the planes along each axis in which these nodes are.
// The brick itself is among them if there are any nodes.
inline uint32_t around_of(Row any_x, uint32_t any_y, uint32_t any_z, const Reach& reach) {
  if (any_y == 0) return 0;
  uint32_t bits_x = 0, bits = 0;
  for (uint32_t k = 0; k < k_brick_side; ++k) bits_x |= (any_x[k] != 0 ? 1u : 0u) << k;
  const auto along = [](uint32_t any, uint32_t low, uint32_t high) {
    return ((any & ((1u << low) - 1)) != 0 ? 1u : 0u) | 2u | ((any >> (k_brick_side - high)) != 0 ? 4u : 0u);
  };
  const uint32_t x = along(bits_x, reach.low, reach.high), z = along(any_z, reach.low, reach.high);
  const uint32_t y = along(any_y, reach.down, reach.up);
  for (uint32_t k = 0; k < k_bricks_around; ++k)
    bits |= (x >> around_x(k) & y >> around_y(k) & z >> around_z(k) & 1) << k;
  return bits;
}

// The same for the nodes that `found` returns of each row.
template <class Found>
inline uint32_t reach_of(const Reach& reach, Found found) {
  Row any_x = {}, along_y[k_brick_side] = {}, along_z[k_brick_side] = {};
  for (uint32_t y = 0; y < k_brick_side; ++y)
    for (uint32_t z = 0; z < k_brick_side; ++z) {
      const Row row = found(node_index(0, y, z));
      along_y[y] |= row;
      along_z[z] |= row;
    }
  uint32_t any_y = 0, any_z = 0;
  for (uint32_t k = 0; k < k_brick_side; ++k) {
    any_x |= along_y[k];
    any_y |= (any_of(along_y[k]) ? 1u : 0u) << k;
    any_z |= (any_of(along_z[k]) ? 1u : 0u) << k;
  }
  return around_of(any_x, any_y, any_z, reach);
}

}  // namespace sandglass
