// The apparatus of the experiments. A vessel's field takes the exact distance from the outline at every node, as the
// scenes' revolved colliders do.
#include "tests/laboratory/sand/apparatus.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "models/files/failure.h"

namespace sandglass::host {

sandglass_scene_desc with_room(sandglass_scene_desc desc, uint32_t particles, uint32_t grains) {
  desc.granular.particle_capacity = particles;
  desc.granular.grain_capacity = grains;
  desc.granular.collider_capacity = 8;
  return desc;
}

Profile cylinder(double radius, double bottom, double top) {
  return {{0.0, bottom}, {radius, bottom}, {radius, top}, {0.0, top}};
}

cpp::Field vessel(const Profile& outline, double spacing, sandglass_solid solid) {
  const double margin = 3.0 * spacing;
  const auto [reach, bottom, top] = extent_of(outline);
  const float wide = static_cast<float>(reach + margin);
  const cpp::Box box = {{-wide, static_cast<float>(bottom - margin), -wide},
                        {wide, static_cast<float>(top + margin), wide}};
  const double sign = solid == SANDGLASS_SOLID_INSIDE ? 1.0 : -1.0;
  cpp::Field field;
  const cpp::Status made = field.from_function(box, static_cast<float>(spacing), solid, [&](const float* p) {
    return static_cast<float>(sign * revolved_distance(outline, {p[0], p[1], p[2]}));
  });
  if (!made) throw cannot("make", "field of the vessel", made.reason);
  return field;
}

double highest_of(std::span<const float> positions) {
  double top = -1e30;
  for (size_t i = 1; i < positions.size(); i += 3) top = std::max<double>(top, positions[i]);
  return top;
}

std::vector<float> scattered(uint32_t count, double shaft, double bottom, double radius, uint64_t seed) {
  constexpr double k_filled = 0.2;
  const double spacing = 2.02 * radius, gap = 1.01 * radius;
  const double reach = shaft - gap, area = std::numbers::pi * reach * reach;
  const double height = count * 4.0 / 3.0 * std::numbers::pi * radius * radius * radius / (k_filled * area);
  std::vector<float> points;
  std::unordered_multimap<int64_t, uint32_t> cells;  // cubes with edges of `spacing`
  const auto cell = [&](double x, double y, double z) {
    const auto index = [&](double value) { return static_cast<int64_t>(std::floor(value / spacing)) & 0xfffff; };
    return index(x) << 40 | index(y) << 20 | index(z);
  };
  Random random = {seed};
  while (points.size() / 3 < count) {
    const double x = reach * (2.0 * random.uniform() - 1.0), z = reach * (2.0 * random.uniform() - 1.0);
    const double y = bottom + gap + height * random.uniform();
    if (x * x + z * z > reach * reach) continue;
    bool taken = false;
    for (int i = 0; i < 27 && !taken; ++i) {
      const auto near =
          cells.equal_range(cell(x + spacing * (i % 3 - 1), y + spacing * (i / 3 % 3 - 1), z + spacing * (i / 9 - 1)));
      for (auto it = near.first; it != near.second && !taken; ++it) {
        const float* p = points.data() + 3 * static_cast<size_t>(it->second);
        const double ex = p[0] - x, ey = p[1] - y, ez = p[2] - z;
        taken = ex * ex + ey * ey + ez * ez < spacing * spacing;
      }
    }
    if (taken) continue;
    cells.emplace(cell(x, y, z), static_cast<uint32_t>(points.size() / 3));
    for (const double value : {x, y, z}) points.push_back(static_cast<float>(value));
  }
  return points;
}

}  // namespace sandglass::host
