// Cuts polygons into triangles by their ears: corners that a straight cut takes off without touching another corner.
#include <algorithm>

#include "models/geometry/vec3.h"
#include "models/mesh/readers.h"

namespace sandglass::host {

namespace {

struct Flat {
  double u, v;
};

double area(Flat a, Flat b, Flat c) { return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u); }

// In the plane that is square to the mean normal's longest axis, counter-clockwise.
std::vector<Flat> flattened(const std::vector<uint32_t>& corners, const std::vector<double>& vertices) {
  const auto vertex = [&](size_t i) {
    const double* p = &vertices[3 * size_t{corners[i % corners.size()]}];
    return Vec3{p[0], p[1], p[2]};
  };
  Vec3 normal;
  for (size_t i = 1; i + 1 < corners.size(); ++i)
    normal = normal + cross(vertex(i) - vertex(0), vertex(i + 1) - vertex(0));
  const double x = std::fabs(normal.x), y = std::fabs(normal.y), z = std::fabs(normal.z);
  const double along = x >= y && x >= z ? normal.x : y >= z ? normal.y : normal.z;
  std::vector<Flat> flat;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 p = vertex(i) - vertex(0);
    Flat at = x >= y && x >= z ? Flat{p.y, p.z} : y >= z ? Flat{p.z, p.x} : Flat{p.x, p.y};
    if (along < 0) std::swap(at.u, at.v);
    flat.push_back(at);
  }
  return flat;
}

}  // namespace

void add_polygon(const std::vector<uint32_t>& corners, FileMesh* mesh) {
  constexpr size_t k_corners_max = 512;  // the time grows with their cube at worst
  const auto add = [mesh](uint32_t a, uint32_t b, uint32_t c) { mesh->indices.insert(mesh->indices.end(), {a, b, c}); };
  std::vector<uint32_t> left = corners;
  std::vector<Flat> at;
  if (corners.size() > 3 && corners.size() <= k_corners_max) at = flattened(corners, mesh->vertices);
  while (left.size() > 3 && !at.empty()) {
    const size_t n = left.size();
    size_t ear = n;
    for (size_t i = 1; i <= n && ear == n; ++i) {  // from the second on: a convex polygon becomes a fan
      const Flat a = at[i - 1], b = at[i % n], c = at[(i + 1) % n];
      if (!(area(a, b, c) > 0)) continue;
      const auto is_in = [&](Flat p) {
        const bool is_corner = (p.u == a.u && p.v == a.v) || (p.u == b.u && p.v == b.v) || (p.u == c.u && p.v == c.v);
        return !is_corner && area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0;
      };
      bool is_free = true;
      for (size_t k = 2; k + 1 < n && is_free; ++k) is_free = !is_in(at[(i + k) % n]);
      if (is_free) ear = i % n;
    }
    if (ear == n) break;  // no simple polygon
    add(left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
    at.erase(at.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  for (size_t i = 1; i + 1 < left.size(); ++i) add(left[0], left[i], left[i + 1]);
}

}  // namespace sandglass::host
