// See mesh.h.
#include "models/mesh/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <unordered_map>
#include <utility>

#include "models/files/failure.h"
#include "models/geometry/vec3.h"
#include "runtime/math/hash.h"

namespace sandglass::host {
namespace {

struct PositionHash {
  size_t operator()(const std::array<float, 3>& p) const {
    uint64_t hash = k_hash_basis;
    for (float x : p) {
      uint32_t bits;
      std::memcpy(&bits, &x, sizeof bits);
      hash = hash_with(hash, bits);
    }
    return hash ^ hash >> 29;
  }
};

}  // namespace

sandglass_inside_rule inside_rule(const MeshReport& report) {
  return report.watertight() && !report.oriented() ? SANDGLASS_INSIDE_PARITY : SANDGLASS_INSIDE_WINDING;
}

std::string describe_faults(const MeshReport& report) {
  std::string text;
  const auto add = [&](uint32_t count, const char* what) {
    if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + what;
  };
  add(report.boundary_edges, "boundary edges");
  add(report.non_manifold_edges, "edges with three or more triangles");
  add(report.inconsistent_edges, "edges between triangles of opposite orientation");
  add(report.degenerate_triangles, "degenerate triangles dropped");
  return text;
}

MeshResult clean_mesh(const std::vector<float>& vertices, const std::vector<uint32_t>& indices,
                      const std::string& name) {
  MeshResult result;
  const auto fail = [&](const std::string& sentence) {
    result.mesh = {};
    result.error = message("read", name, "it " + sentence);
    return result;
  };
  if (vertices.size() < 9 || indices.size() < 3) return fail("has no triangles. Export it as a surface of polygons.");
  const size_t vertex_count = vertices.size() / 3;
  std::vector<bool> is_used(vertex_count, false);
  for (size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] >= vertex_count)
      return fail("has a triangle (" + std::to_string(i / 3) + ") with index " + std::to_string(indices[i]) +
                  ", but only " + std::to_string(vertex_count) + " vertices. Export it again.");
    is_used[indices[i]] = true;
  }
  std::vector<uint32_t> merged(vertex_count);
  std::unordered_map<std::array<float, 3>, uint32_t, PositionHash> known;
  known.reserve(vertex_count);
  for (uint32_t v = 0; v < vertex_count; ++v) {
    if (!is_used[v]) continue;
    // Adding 0 turns -0 into 0, so that equal positions have equal bytes.
    const std::array<float, 3> p = {vertices[3 * v] + 0.0f, vertices[3 * v + 1] + 0.0f, vertices[3 * v + 2] + 0.0f};
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
      return fail("has a vertex that is not finite (vertex " + std::to_string(v) +
                  "). Repair it in a mesh editor and export it again.");
    const auto [entry, is_new] = known.emplace(p, result.mesh.vertex_count());
    merged[v] = entry->second;
    if (is_new) result.mesh.vertices.insert(result.mesh.vertices.end(), p.begin(), p.end());
    result.report.merged_vertices += !is_new;
  }
  for (size_t t = 0; t + 2 < indices.size(); t += 3) {
    const uint32_t a = merged[indices[t]], b = merged[indices[t + 1]], c = merged[indices[t + 2]];
    if (a == b || b == c || c == a) {
      ++result.report.degenerate_triangles;
      continue;
    }
    // A triangle whose corners lie in line is kept, because its neighbours close against it.
    result.mesh.indices.insert(result.mesh.indices.end(), {a, b, c});
  }
  if (result.mesh.indices.empty()) return fail("has only degenerate triangles. Export it again at a larger scale.");
  turn_outward(&result.mesh, &result.report);
  return result;
}

double signed_volume(const Mesh& mesh) {
  double sum = 0;
  for (size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    std::array<std::array<double, 3>, 3> p;
    for (size_t corner = 0; corner < 3; ++corner)
      for (size_t k = 0; k < 3; ++k) p[corner][k] = mesh.vertices[3 * mesh.indices[t + corner] + k];
    sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
           p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return sum / 6;
}

MeshBox box_of(const Mesh& mesh) {
  MeshBox box;
  box.low.fill(INFINITY);
  box.high.fill(-INFINITY);
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    box.low[i % 3] = std::min(box.low[i % 3], mesh.vertices[i]);
    box.high[i % 3] = std::max(box.high[i % 3], mesh.vertices[i]);
  }
  return box;
}

Mesh with_short_edges(const Mesh& mesh, double longest) {
  Mesh fine = {mesh.vertices, {}};
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
  std::vector<uint32_t> open = mesh.indices;
  while (!open.empty()) {
    uint32_t corners[3];
    for (size_t k = 3; k-- > 0; open.pop_back()) corners[k] = open.back();
    const auto vertex = [&](size_t k) { return from_floats(&fine.vertices[3 * size_t{corners[k % 3]}]); };
    const auto edge = [&](size_t k) { return length(vertex(k + 1) - vertex(k)); };
    const size_t first = edge(0) >= edge(1) && edge(0) >= edge(2) ? 0 : edge(1) >= edge(2) ? 1 : 2;
    const uint32_t a = corners[first], b = corners[(first + 1) % 3], c = corners[(first + 2) % 3];
    if (!(edge(first) > longest)) {
      fine.indices.insert(fine.indices.end(), {a, b, c});
      continue;
    }
    const auto [middle, is_new] = middles.emplace(std::minmax(a, b), fine.vertex_count());
    for (size_t axis = 0; is_new && axis < 3; ++axis)
      fine.vertices.push_back(0.5f * (fine.vertices[3 * a + axis] + fine.vertices[3 * b + axis]));
    open.insert(open.end(), {a, middle->second, c, middle->second, b, c});
  }
  return fine;
}

}  // namespace sandglass::host
