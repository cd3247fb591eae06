// The sphere caster without Embree. Every sphere is listed in each cell that its box touches. A ray walks the cells in
// order.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "models/tracing/sphere_caster.h"

namespace sandglass::host {

constexpr double k_cell_in_radii = 3.0;      // a sphere then lies in about five cells
constexpr double k_cells_at_most = 1 << 24;  // 64 MiB of cell starts
constexpr double k_growth = 1.25;

struct SphereCaster::State {
  std::vector<float> centres, radii;
  std::vector<uint32_t> start, listed;
  std::array<double, 3> low = {}, high = {};
  std::array<int64_t, 3> cells = {1, 1, 1};
  double cell = 1.0;

  int64_t index_along(size_t axis, double value) const {
    const double index = std::floor((value - low[axis]) / cell);
    return static_cast<int64_t>(std::clamp(index, 0.0, static_cast<double>(cells[axis] - 1)));
  }
  size_t cell_of(int64_t i, int64_t j, int64_t k) const {
    return static_cast<size_t>((k * cells[1] + j) * cells[0] + i);
  }

  template <class Visit>
  void cells_of(uint32_t sphere, Visit visit) const {
    std::array<int64_t, 3> from, to;
    const double radius = radii[sphere];
    for (size_t axis = 0; axis < 3; ++axis) {
      from[axis] = index_along(axis, centres[3 * sphere + axis] - radius);
      to[axis] = index_along(axis, centres[3 * sphere + axis] + radius);
    }
    for (int64_t k = from[2]; k <= to[2]; ++k)
      for (int64_t j = from[1]; j <= to[1]; ++j)
        for (int64_t i = from[0]; i <= to[0]; ++i) visit(cell_of(i, j, k));
  }

  bool walk(Vec3 origin, Vec3 direction, bool any, SphereHit* hit) const;
};

const char* SphereCaster::engine() { return "grid"; }

SphereCaster::SphereCaster(std::span<const float> centres, float radius, std::span<const float> sizes)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.centres.assign(centres.begin(), centres.end());
  s.radii.assign(centres.size() / 3, radius);
  for (size_t i = 0; i < sizes.size() && i < s.radii.size(); ++i) s.radii[i] *= sizes[i];
  s.cell = k_cell_in_radii * radius;
  std::vector<uint32_t> kept;
  s.low.fill(std::numeric_limits<double>::max());
  s.high.fill(std::numeric_limits<double>::lowest());
  for (uint32_t i = 0; i < centres.size() / 3; ++i) {
    if (!std::isfinite(centres[3 * i]) || !std::isfinite(centres[3 * i + 1]) || !std::isfinite(centres[3 * i + 2]))
      continue;
    kept.push_back(i);
    for (size_t axis = 0; axis < 3; ++axis) {
      s.low[axis] = std::min<double>(s.low[axis], centres[3 * i + axis] - s.radii[i]);
      s.high[axis] = std::max<double>(s.high[axis], centres[3 * i + axis] + s.radii[i]);
    }
  }
  if (kept.empty()) {
    s.start = {0, 0};
    s.low.fill(0.0);
    s.high.fill(0.0);
    return;
  }
  const auto cells_along = [&](size_t axis) { return std::floor((s.high[axis] - s.low[axis]) / s.cell) + 1.0; };
  while (cells_along(0) * cells_along(1) * cells_along(2) > k_cells_at_most) s.cell *= k_growth;
  for (size_t axis = 0; axis < 3; ++axis) s.cells[axis] = static_cast<int64_t>(cells_along(axis));
  s.start.assign(static_cast<size_t>(s.cells[0] * s.cells[1] * s.cells[2]) + 1, 0);
  for (const uint32_t i : kept) s.cells_of(i, [&](size_t c) { ++s.start[c + 1]; });
  for (size_t c = 1; c < s.start.size(); ++c) s.start[c] += s.start[c - 1];
  s.listed.resize(s.start.back());
  std::vector<uint32_t> cursor(s.start.begin(), s.start.end() - 1);
  for (const uint32_t i : kept) s.cells_of(i, [&](size_t c) { s.listed[cursor[c]++] = i; });
}

SphereCaster::~SphereCaster() = default;

bool SphereCaster::State::walk(Vec3 origin, Vec3 direction, bool any, SphereHit* hit) const {
  if (listed.empty()) return false;
  const double o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
  double enter = 0.0, leave = hit->distance;
  for (size_t axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0.0) {
      if (o[axis] < low[axis] || o[axis] > high[axis]) return false;
      continue;
    }
    const double a = (low[axis] - o[axis]) / d[axis], b = (high[axis] - o[axis]) / d[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave) return false;
  int64_t at[3], step[3];
  double next[3], width[3];
  for (size_t axis = 0; axis < 3; ++axis) {
    at[axis] = index_along(axis, o[axis] + d[axis] * enter);
    step[axis] = d[axis] < 0.0 ? -1 : 1;
    const double wall = low[axis] + static_cast<double>(at[axis] + (d[axis] < 0.0 ? 0 : 1)) * cell;
    next[axis] = d[axis] == 0.0 ? std::numeric_limits<double>::infinity() : (wall - o[axis]) / d[axis];
    width[axis] = d[axis] == 0.0 ? 0.0 : std::fabs(cell / d[axis]);
  }
  bool found = false;
  while (true) {
    const size_t c = cell_of(at[0], at[1], at[2]);
    for (uint32_t entry = start[c]; entry < start[c + 1]; ++entry) {
      const uint32_t i = listed[entry];
      const Vec3 to = Vec3{centres[3 * i], centres[3 * i + 1], centres[3 * i + 2]} - origin;
      const double radius = radii[i];
      const double along = dot(to, direction), gap = radius * radius - (dot(to, to) - along * along);
      if (gap < 0.0) continue;
      const double distance = along - std::sqrt(gap);
      if (distance <= 0.0 || distance >= hit->distance) continue;
      if (any) return true;
      *hit = {distance, i};
      found = true;
    }
    const size_t axis = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
    if (next[axis] > leave || (found && next[axis] > hit->distance)) return found;
    at[axis] += step[axis];
    if (at[axis] < 0 || at[axis] >= cells[axis]) return found;
    next[axis] += width[axis];
  }
}

bool SphereCaster::closest(Vec3 origin, Vec3 direction, SphereHit* hit) const {
  return state_->walk(origin, direction, false, hit);
}

bool SphereCaster::occluded(Vec3 origin, Vec3 direction, double limit) const {
  SphereHit hit = {limit, 0};
  return state_->walk(origin, direction, true, &hit);
}

}  // namespace sandglass::host
