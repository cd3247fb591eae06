// Sorts points into cubic cells and finds all points near a place, for the metrics and the laboratory. It computes in
// double. It is independent of the library's own neighbour search, which it helps to judge.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "models/geometry/vec3.h"

namespace sandglass::host {

struct CellGrid {
  Vec3 origin;
  double cell = 1.0;               // edge, metres
  int64_t nx = 1, ny = 1, nz = 1;  // cells along each axis
  std::vector<uint32_t> start;     // where each cell begins in `order`, and the end of the last cell
  std::vector<uint32_t> order;     // point indices, cell by cell

  // Points with a coordinate that is not finite are left out. The edge grows from `wanted_cell` until there are at most
  // 8 cells per point, plus 64.
  CellGrid(std::span<const float> xyz, double wanted_cell);

  int64_t coordinate(double value, double from, int64_t count) const {
    const double index = std::floor((value - from) / cell);
    return index < 0.0 ? 0 : index >= static_cast<double>(count) ? count - 1 : static_cast<int64_t>(index);
  }
  size_t cell_of(int64_t i, int64_t j, int64_t k) const { return static_cast<size_t>((k * ny + j) * nx + i); }

  // Calls visit(index) for every point in the cells that touch the cube of half edge `reach` about p.
  template <class Visit>
  void near(Vec3 p, double reach, Visit visit) const {
    const int64_t i0 = coordinate(p.x - reach, origin.x, nx), i1 = coordinate(p.x + reach, origin.x, nx);
    const int64_t j0 = coordinate(p.y - reach, origin.y, ny), j1 = coordinate(p.y + reach, origin.y, ny);
    const int64_t k0 = coordinate(p.z - reach, origin.z, nz), k1 = coordinate(p.z + reach, origin.z, nz);
    for (int64_t k = k0; k <= k1; ++k)
      for (int64_t j = j0; j <= j1; ++j)
        for (uint32_t at = start[cell_of(i0, j, k)]; at < start[cell_of(i1, j, k) + 1]; ++at) visit(order[at]);
  }
};

// Calls visit(index, squared distance) for every point less than `reach` away from p. The grid is of these points.
template <class Visit>
void within(const CellGrid& grid, std::span<const float> xyz, Vec3 p, double reach, Visit visit) {
  grid.near(p, reach, [&](uint32_t i) {
    const Vec3 offset = from_floats(&xyz[3 * size_t{i}]) - p;
    const double squared = dot(offset, offset);
    if (squared < reach * reach) visit(i, squared);
  });
}

}  // namespace sandglass::host
