// The apparatus of the experiments. A vessel's field takes the exact distance from the outline at every node, as the
// scenes' revolved colliders do.
#include "models/laboratory/sand/apparatus.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <unordered_map>

#include "models/files/failure.h"

namespace sandglass::host {

namespace {

struct Turned {
  const Profile& outline;
  double sign;
};

float turned_distance(void* user, const float p[3]) {
  const Turned& turned = *static_cast<const Turned*>(user);
  return static_cast<float>(turned.sign * revolved_distance(turned.outline, {p[0], p[1], p[2]}));
}

void require(sandglass_status status, const char* const& reason) {
  if (status == SANDGLASS_OK) return;
  throw cannot("make", "field of the vessel", reason);
}

}  // namespace

Vessel::Vessel(const Profile& outline, double spacing, bool solid_inside) {
  const double margin = 3.0 * spacing;
  double reach = 0.0, bottom = 1e30, top = -1e30;
  for (const auto& point : outline)
    reach = std::max(reach, point[0]), bottom = std::min(bottom, point[1]), top = std::max(top, point[1]);
  const float wide = static_cast<float>(reach + margin);
  const float low[3] = {-wide, static_cast<float>(bottom - margin), -wide};
  const float high[3] = {wide, static_cast<float>(top + margin), wide};
  const char* reason = nullptr;
  uint64_t bytes = 0;
  require(sandglass_field_bytes(low, high, static_cast<float>(spacing), &bytes, &reason), reason);
  block_ = new_block(bytes, "the vessel's field", "give it a wider spacing");
  Turned turned = {outline, solid_inside ? 1.0 : -1.0};
  const sandglass_solid solid = solid_inside ? SANDGLASS_SOLID_INSIDE : SANDGLASS_SOLID_OUTSIDE;
  require(sandglass_field_from_function(low, high, static_cast<float>(spacing), solid, turned_distance, &turned,
                                        block_.get(), bytes, &field_, &reason),
          reason);
}

sandglass_collider Vessel::collider() const {
  sandglass_collider collider = {};
  collider.shape = SANDGLASS_SHAPE_FIELD;
  collider.rotation[3] = 1.0f;
  collider.field = field_;
  return collider;
}

sandglass_collider level_floor(double height) {
  sandglass_collider floor = {};
  floor.shape = SANDGLASS_SHAPE_HALF_SPACE;
  floor.position[1] = static_cast<float>(height);
  floor.rotation[3] = 1.0f;
  return floor;
}

std::vector<float> scattered(uint32_t count, const Shaft& shaft, double bottom, double radius, uint64_t seed) {
  constexpr double k_filled = 0.2;
  const double apart = 2.02 * radius, gap = 1.01 * radius;
  const double reach_x = shaft.half_x - gap, reach_z = (shaft.round ? shaft.half_x : shaft.half_z) - gap;
  const double area = (shaft.round ? std::numbers::pi : 4.0) * reach_x * reach_z;
  const double height = count * 4.0 / 3.0 * std::numbers::pi * radius * radius * radius / (k_filled * area);
  std::vector<float> points;
  std::unordered_multimap<int64_t, uint32_t> cells;  // cubes with edges of `apart`
  const auto cell = [&](double x, double y, double z) {
    const auto index = [&](double value) { return static_cast<int64_t>(std::floor(value / apart)) & 0xfffff; };
    return index(x) << 40 | index(y) << 20 | index(z);
  };
  Random random = {seed};
  while (points.size() / 3 < count) {
    const double x = reach_x * (2.0 * random.uniform() - 1.0), z = reach_z * (2.0 * random.uniform() - 1.0);
    const double y = bottom + gap + height * random.uniform();
    if (shaft.round && x * x + z * z > reach_x * reach_x) continue;
    bool taken = false;
    for (int i = 0; i < 27 && !taken; ++i) {
      const auto near =
          cells.equal_range(cell(x + apart * (i % 3 - 1), y + apart * (i / 3 % 3 - 1), z + apart * (i / 9 - 1)));
      for (auto it = near.first; it != near.second && !taken; ++it) {
        const float* p = points.data() + 3 * static_cast<size_t>(it->second);
        const double ex = p[0] - x, ey = p[1] - y, ez = p[2] - z;
        taken = ex * ex + ey * ey + ez * ez < apart * apart;
      }
    }
    if (taken) continue;
    cells.emplace(cell(x, y, z), static_cast<uint32_t>(points.size() / 3));
    for (const double value : {x, y, z}) points.push_back(static_cast<float>(value));
  }
  return points;
}

}  // namespace sandglass::host
