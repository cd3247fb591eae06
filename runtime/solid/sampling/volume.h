// The random points of Alg. 2: tries in the shell around a sample, and probes, one in each cell, from which growth
// starts again. They stand apart from the sampler so that tests can compare their distributions with theory.
#pragma once

#include "runtime/math/math.h"
#include "runtime/solid/sampling/streams.h"

namespace sandglass {

struct Offset {
  double x, y, z;
};

// A point spread evenly in the shell l..2l. Its radius corrects (3.29): the volume within r grows as
// r^3 - l^3 = 7 l^3 rho, so r = l cuberoot(1 + 7 rho). (3.30) is used without its arccos: cos(theta) = 2 rho - 1.
// (3.31) is as printed.
inline Offset draw_in_shell(Random* random, double distance) {
  const double r = distance * cube_root(1 + 7 * random->uniform());
  const double cosine = 2 * random->uniform() - 1, sine = square_root(1 - cosine * cosine);
  const SinCos azimuth = sin_cos_turns(random->uniform());
  return {r * sine * azimuth.cos, r * cosine, r * sine * azimuth.sin};
}

struct CellGrid {
  double origin[3], far[3];
  double edge;
  uint32_t cells[3];
};

// The cell of a point, (3.25), (3.26). The far face of the box belongs to the last cell.
inline uint32_t cell_along(const CellGrid& grid, int axis, double x) {
  const int64_t i = floor_index((x - grid.origin[axis]) / grid.edge);
  return i < 0 ? 0 : i < grid.cells[axis] ? static_cast<uint32_t>(i) : grid.cells[axis] - 1;
}

// A random point of cell (i, j, k), the same whenever it is asked for.
inline void draw_probe(const CellGrid& grid, uint64_t seed, const uint32_t cell[3], float point[3]) {
  const uint64_t index = (static_cast<uint64_t>(cell[2]) * grid.cells[1] + cell[1]) * grid.cells[0] + cell[0];
  Random random = random_stream(seed, k_stream_probes + (index << 8));
  for (int k = 0; k < 3; ++k) {
    const double low = grid.origin[k] + cell[k] * grid.edge;
    const double high = low + grid.edge < grid.far[k] ? low + grid.edge : grid.far[k];
    point[k] = static_cast<float>(low + random.uniform() * (high - low));
  }
}

// The grid of a box; false if it has more than 2^30 cells.
bool make_cell_grid(const float bounds_min[3], const float bounds_max[3], float distance, CellGrid* grid);

}  // namespace sandglass
