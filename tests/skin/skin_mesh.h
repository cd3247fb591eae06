// The mesh of a skin as one list, and what it holds.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/skin/skin_scene.h"

using Point = std::array<float, 3>;
// What a particle takes in a pile: its volume over a packing of 0.6 (Scott 1960: 0.60 loose, 0.64 close).
constexpr double k_particle = 4.0 / 3 * std::numbers::pi * k_radius * k_radius * k_radius / 0.6;

struct Mesh {
  std::vector<sandglass_skin_vertex> vertices;
  std::vector<uint32_t> triangles;  // three vertices each
  double loose = 0;                 // particles
};

inline Mesh mesh_of(const sandglass::Skin& skin) {
  const sandglass_skin_mesh now = skin.mesh();
  Mesh mesh;
  for (uint32_t c = 0; c < now.chunk_count; ++c) {
    const sandglass_skin_chunk& chunk = now.chunks[c];
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), chunk.vertices, chunk.vertices + chunk.vertex_count);
    for (uint32_t i = 0; i < chunk.index_count; ++i) {
      EXPECT_LT(chunk.indices[i], chunk.vertex_count);
      mesh.triangles.push_back(first + chunk.indices[i]);
    }
  }
  EXPECT_EQ(mesh.vertices.size(), now.vertex_count);
  EXPECT_EQ(mesh.triangles.size(), now.index_count);
  for (uint32_t i = 0; i < now.flying_count + now.lying_count; ++i)
    mesh.loose += static_cast<double>(now.loose[i].weight);
  return mesh;
}

inline double dot(const Point& a, const Point& b) {
  double sum = 0;
  for (size_t k = 0; k < 3; ++k) sum += static_cast<double>(a[k]) * static_cast<double>(b[k]);
  return sum;
}

inline Point place(const sandglass_skin_vertex& v) { return {v.position[0], v.position[1], v.position[2]}; }

// What of the mesh lies over the plane through the origin, after it was lifted: the sum of the prisms between triangles
// and plane. `faults`: edges over it that have not two triangles turned one way.
inline double volume_over(const Mesh& mesh, const Point& up, uint32_t* faults, float lifted = 0) {
  std::map<std::pair<Point, Point>, int> edges;
  double volume = 0;
  *faults = 0;
  for (size_t t = 0; t < mesh.triangles.size(); t += 3) {
    Point p[3];
    for (size_t k = 0; k < 3; ++k) {
      p[k] = place(mesh.vertices[mesh.triangles[t + k]]);
      for (size_t m = 0; m < 3; ++m) p[k][m] += lifted * up[m];
    }
    const auto cross = [&](size_t k) {
      const size_t a = (k + 1) % 3, b = (k + 2) % 3;
      return static_cast<double>(p[1][a] - p[0][a]) * static_cast<double>(p[2][b] - p[0][b]) -
             static_cast<double>(p[1][b] - p[0][b]) * static_cast<double>(p[2][a] - p[0][a]);
    };
    double facing = 0, height = 0;
    for (size_t k = 0; k < 3; ++k) {
      facing += 0.5 * cross(k) * static_cast<double>(up[k]);
      height += std::max(dot(p[k], up), 0.0) / 3;
      const Point &a = p[k], &b = p[(k + 1) % 3];
      if (std::max(dot(a, up), dot(b, up)) > 0) edges[std::minmax(a, b)] += a < b ? 1 : -1;
    }
    volume += facing * height;
  }
  for (const auto& [edge, sum] : edges) *faults += sum != 0 ? 1 : 0;
  return volume;
}

inline bool is_closed(const Mesh& mesh) {
  uint32_t faults = 0;
  volume_over(mesh, {0, 1, 0}, &faults);
  return faults == 0;
}

// As large as the sand is said to be: the closed mesh, and what is loose.
inline double sand_in(const Mesh& mesh, const Point& up = {0, 1, 0}) {
  uint32_t faults = 0;
  const double volume = volume_over(mesh, up, &faults);
  EXPECT_EQ(faults, 0u) << up[0] << " " << up[1] << " " << up[2];
  return volume + mesh.loose * k_particle;
}
