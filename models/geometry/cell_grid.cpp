// See cell_grid.h. Points are sorted by cell with a counting sort.
#include "models/geometry/cell_grid.h"

#include <algorithm>

namespace sandglass::host {

constexpr double k_cells_per_point = 8.0;  // at most; a larger table costs more than it saves
constexpr double k_growth = 1.25;          // of the edge, per attempt to stay below

CellGrid::CellGrid(std::span<const float> xyz, double wanted_cell) : cell(wanted_cell) {
  const auto finite = [&](size_t i) {
    return std::isfinite(xyz[3 * i]) && std::isfinite(xyz[3 * i + 1]) && std::isfinite(xyz[3 * i + 2]);
  };
  const size_t count = xyz.size() / 3;
  Vec3 low = {1e30, 1e30, 1e30}, high = {-1e30, -1e30, -1e30};
  size_t kept = 0;
  for (size_t i = 0; i < count; ++i) {
    if (!finite(i)) continue;
    ++kept;
    low = {std::min<double>(low.x, xyz[3 * i]), std::min<double>(low.y, xyz[3 * i + 1]),
           std::min<double>(low.z, xyz[3 * i + 2])};
    high = {std::max<double>(high.x, xyz[3 * i]), std::max<double>(high.y, xyz[3 * i + 1]),
            std::max<double>(high.z, xyz[3 * i + 2])};
  }
  if (kept == 0) low = high = {};
  origin = low;
  const auto cells_along = [&](double extent) { return std::floor(extent / cell) + 1.0; };
  while (cells_along(high.x - low.x) * cells_along(high.y - low.y) * cells_along(high.z - low.z) >
         k_cells_per_point * static_cast<double>(kept) + 64.0)
    cell *= k_growth;
  nx = static_cast<int64_t>(cells_along(high.x - low.x));
  ny = static_cast<int64_t>(cells_along(high.y - low.y));
  nz = static_cast<int64_t>(cells_along(high.z - low.z));
  start.assign(static_cast<size_t>(nx * ny * nz) + 1, 0);
  const auto cell_at = [&](size_t i) {
    return cell_of(coordinate(xyz[3 * i], origin.x, nx), coordinate(xyz[3 * i + 1], origin.y, ny),
                   coordinate(xyz[3 * i + 2], origin.z, nz));
  };
  for (size_t i = 0; i < count; ++i)
    if (finite(i)) ++start[cell_at(i) + 1];
  for (size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
  order.resize(kept);
  std::vector<uint32_t> cursor(start.begin(), start.end() - 1);
  for (size_t i = 0; i < count; ++i)
    if (finite(i)) order[cursor[cell_at(i)]++] = static_cast<uint32_t>(i);
}

}  // namespace sandglass::host
