// The sphere caster without Embree: a ray goes on by a diameter at a time, past the spheres that the grid has near it.
#include <algorithm>
#include <cmath>
#include <vector>

#include "models/geometry/cell_grid.h"
#include "models/tracing/sphere_caster.h"

namespace sandglass::host {

struct SphereCaster::State {
  std::vector<float> centres, radii;
  double largest;  // radius
  CellGrid grid;   // of the centres

  bool walk(Vec3 origin, Vec3 direction, bool any, SphereHit* hit) const;
};

const char* SphereCaster::engine() { return "grid"; }

SphereCaster::SphereCaster(std::span<const float> centres, float radius, std::span<const float> sizes) {
  std::vector<float> radii(centres.size() / 3, radius);
  for (size_t i = 0; i < sizes.size() && i < radii.size(); ++i) radii[i] *= sizes[i];
  const double largest = radii.empty() ? radius : *std::max_element(radii.begin(), radii.end());
  state_ = std::make_unique<State>(
      State{{centres.begin(), centres.end()}, std::move(radii), largest, CellGrid(centres, 2.0 * largest)});
}

SphereCaster::~SphereCaster() = default;

bool SphereCaster::State::walk(Vec3 origin, Vec3 direction, bool any, SphereHit* hit) const {
  // The part of the ray in the grid's box and a radius around it.
  double at = 0.0, end = hit->distance;
  const auto cut = [&](double o, double d, double low, int64_t cells) {
    const double a = (low - largest - o) / d, b = (low + static_cast<double>(cells) * grid.cell + largest - o) / d;
    if (d == 0.0) return;
    at = std::max(at, std::min(a, b));
    end = std::min(end, std::max(a, b));
  };
  cut(origin.x, direction.x, grid.origin.x, grid.nx);
  cut(origin.y, direction.y, grid.origin.y, grid.ny);
  cut(origin.z, direction.z, grid.origin.z, grid.nz);
  bool found = false;
  for (; at < end && !(found && (any || hit->distance < at)); at += 2.0 * largest)
    grid.near(origin + direction * (at + largest), 2.0 * largest, [&](uint32_t i) {
      const Vec3 to = from_floats(&centres[3 * size_t{i}]) - origin;
      const double radius = radii[i], along = dot(to, direction), gap = radius * radius - (dot(to, to) - along * along);
      if (gap < 0.0) return;
      const double distance = along - std::sqrt(gap);
      if (distance <= 0.0 || distance >= hit->distance) return;
      *hit = {distance, i};
      found = true;
    });
  return found;
}

bool SphereCaster::closest(Vec3 origin, Vec3 direction, SphereHit* hit) const {
  return state_->walk(origin, direction, false, hit);
}

bool SphereCaster::occluded(Vec3 origin, Vec3 direction, double limit) const {
  SphereHit hit = {limit, 0};
  return state_->walk(origin, direction, true, &hit);
}

}  // namespace sandglass::host
