// The candidate grid of Alg. 1. Candidates are grouped by cells of edge l, and cells are found by hashing: memory
// follows the number of candidates, not the bounding box. Within a bucket the live candidates come first. One that
// dies, because it became a sample or lies too close to one, is swapped behind them and never moves again. So the index
// of a sample's record stays its name.
#pragma once

#include <cstdint>

#include "runtime/math/math.h"
#include "runtime/solid/sampling/candidates.h"

namespace sandglass {

struct CandidateGrid {
  double origin[3];
  double cells_per_metre;
  uint32_t bucket_bits;
  uint32_t* first;  // of each bucket
  uint32_t* live;   // one past its last live candidate
  Candidate* records;
};

// Cells are slightly wider than l. So rounding cannot put two points closer than l into cells that are not neighbours.
inline double cells_per_metre(float distance) { return (1 - 0x1p-30) / static_cast<double>(distance); }

inline void cell_of(const CandidateGrid& grid, const float position[3], int64_t cell[3]) {
  for (int k = 0; k < 3; ++k)
    cell[k] = floor_index((static_cast<double>(position[k]) - grid.origin[k]) * grid.cells_per_metre);
}

inline uint32_t bucket_of(const CandidateGrid& grid, int64_t x, int64_t y, int64_t z) {
  const uint64_t key =
      static_cast<uint64_t>(x + 1) | static_cast<uint64_t>(y + 1) << 21 | static_cast<uint64_t>(z + 1) << 42;
  return static_cast<uint32_t>(mix_bits(key) >> (64 - grid.bucket_bits));
}

inline uint32_t bucket_of(const CandidateGrid& grid, const float position[3]) {
  int64_t cell[3];
  cell_of(grid, position, cell);
  return bucket_of(grid, cell[0], cell[1], cell[2]);
}

// The buckets of a point's cell and its 26 neighbours. Cells may share a bucket; each is listed once.
inline uint32_t neighbour_buckets(const CandidateGrid& grid, const float position[3], uint32_t buckets[27]) {
  int64_t cell[3];
  cell_of(grid, position, cell);
  uint32_t count = 0;
  for (int n = 0; n < 27; ++n) {
    const uint32_t bucket = bucket_of(grid, cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1);
    bool known = false;
    for (uint32_t i = 0; i < count; ++i) known = known || buckets[i] == bucket;
    if (!known) buckets[count++] = bucket;
  }
  return count;
}

// Retires a live candidate and returns where its record now lies.
inline uint32_t retire(const CandidateGrid& grid, uint32_t bucket, uint32_t record) {
  const uint32_t last = --grid.live[bucket];
  const Candidate candidate = grid.records[record];
  grid.records[record] = grid.records[last];
  grid.records[last] = candidate;
  return last;
}

inline double distance_squared(const float a[3], const float b[3]) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double d = static_cast<double>(a[k]) - static_cast<double>(b[k]);
    sum += d * d;
  }
  return sum;
}

}  // namespace sandglass
