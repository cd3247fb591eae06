// Which side of a mesh is outside. Files mirror parts of a figure, or hold one inside out. Each part, the triangles that
// hang together by edges, is judged by the sign of its own volume. A part that lies in another is a hollow of it where
// its volume has the other sign, so the outermost part decides for all that lie in it.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "models/geometry/vec3.h"
#include "models/mesh/mesh.h"

namespace sandglass::host {

namespace {

struct Part {
  std::vector<uint32_t> triangles;
  Vec3 low, high;
  double volume = 0;
  bool is_closed = true;  // every edge is run along as often one way as the other
  bool is_turned = false;
};

std::array<Vec3, 3> corners_of(const Mesh& mesh, uint32_t triangle) {
  std::array<Vec3, 3> corners;
  for (size_t k = 0; k < 3; ++k) corners[k] = from_floats(&mesh.vertices[3 * size_t{mesh.indices[3 * triangle + k]}]);
  return corners;
}

// The part's winding number about a point: its solid angle there, in whole turns.
double winding(const Mesh& mesh, const Part& part, Vec3 point) {
  double angle = 0;
  for (const uint32_t t : part.triangles) {
    auto [a, b, c] = corners_of(mesh, t);
    a = a - point;
    b = b - point;
    c = c - point;
    const double la = length(a), lb = length(b), lc = length(c);
    angle += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return angle / (4 * 3.14159265358979323846);
}

// Of closed parts.
bool holds(const Mesh& mesh, const Part& outer, const Part& inner) {
  if (!outer.is_closed || !inner.is_closed || std::fabs(outer.volume) <= std::fabs(inner.volume)) return false;
  const bool is_within = outer.low.x <= inner.low.x && outer.low.y <= inner.low.y && outer.low.z <= inner.low.z &&
                         outer.high.x >= inner.high.x && outer.high.y >= inner.high.y && outer.high.z >= inner.high.z;
  return is_within && std::fabs(winding(mesh, outer, corners_of(mesh, inner.triangles[0])[0])) > 0.5;
}

// Counts the edges, too.
std::vector<Part> parts_of(const Mesh& mesh, MeshReport* report) {
  const uint32_t count = mesh.triangle_count();
  std::vector<uint32_t> above(count);  // of each triangle, towards the first one of its part
  std::iota(above.begin(), above.end(), 0u);
  const auto first_of = [&](uint32_t t) {
    while (above[t] != t) t = above[t] = above[above[t]];
    return t;
  };
  struct Side {
    uint64_t edge;
    uint32_t triangle;
    int direction;
  };
  std::vector<Side> sides;
  sides.reserve(mesh.indices.size());
  for (uint32_t t = 0; t < count; ++t)
    for (size_t k = 0; k < 3; ++k) {
      const uint64_t a = mesh.indices[3 * t + k], b = mesh.indices[3 * t + (k + 1) % 3];
      sides.push_back({std::min(a, b) << 32 | std::max(a, b), t, a < b ? 1 : -1});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) { return x.edge < y.edge; });
  std::vector<uint32_t> unequal;  // a triangle of each edge that is not run along as often one way as the other
  for (size_t i = 0, end = 0; i < sides.size(); i = end) {
    int sum = 0;
    for (end = i; end < sides.size() && sides[end].edge == sides[i].edge; ++end) {
      sum += sides[end].direction;
      const uint32_t a = first_of(sides[i].triangle), b = first_of(sides[end].triangle);
      above[std::max(a, b)] = std::min(a, b);
    }
    if (sum != 0) unequal.push_back(sides[i].triangle);
    report->boundary_edges += end - i == 1;
    report->non_manifold_edges += end - i > 2;
    report->inconsistent_edges += end - i == 2 && sum != 0;
    report->odd_edges += (end - i) % 2;
    report->unbalanced_edges += sum != 0;
  }
  std::vector<Part> parts;
  std::vector<size_t> number(count);
  for (uint32_t t = 0; t < count; ++t) {
    const uint32_t first = first_of(t);
    if (first == t) {
      number[t] = parts.size();
      const Vec3 corner = corners_of(mesh, t)[0];
      parts.push_back({{}, corner, corner});
    }
    Part& part = parts[number[first]];
    const auto [a, b, c] = corners_of(mesh, t);
    const Vec3 from = corners_of(mesh, first)[0];
    part.volume += dot(a - from, cross(b - from, c - from)) / 6;
    part.triangles.push_back(t);
    for (const Vec3 p : {a, b, c}) {
      part.low = {std::min(part.low.x, p.x), std::min(part.low.y, p.y), std::min(part.low.z, p.z)};
      part.high = {std::max(part.high.x, p.x), std::max(part.high.y, p.y), std::max(part.high.z, p.z)};
    }
  }
  for (const uint32_t t : unequal) parts[number[first_of(t)]].is_closed = false;
  return parts;
}

}  // namespace

void turn_outward(Mesh* mesh, MeshReport* report) {
  std::vector<Part> parts = parts_of(*mesh, report);
  report->parts = static_cast<uint32_t>(parts.size());
  for (const Part& inward : parts) {
    if (!inward.is_closed || !(inward.volume < 0)) continue;
    if (std::any_of(parts.begin(), parts.end(), [&](const Part& other) { return holds(*mesh, other, inward); }))
      continue;
    for (Part& part : parts) part.is_turned = part.is_turned || &part == &inward || holds(*mesh, inward, part);
  }
  for (const Part& part : parts) {
    if (!part.is_turned) continue;
    ++report->turned_parts;
    for (const uint32_t t : part.triangles) std::swap(mesh->indices[3 * t + 1], mesh->indices[3 * t + 2]);
  }
}

}  // namespace sandglass::host
