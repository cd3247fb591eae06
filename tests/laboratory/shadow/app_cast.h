// A cast as an app uses it: a mesh that is handed over, and a texture that is sampled.
#pragma once

#include <algorithm>
#include <cmath>

#include "models/geometry/vec3.h"
#include "models/mesh/mesh.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

inline sandglass_cast_mesh cast_mesh_of(const Mesh& mesh, bool closed, bool is_real) {
  sandglass_cast_mesh m = cpp::cast_mesh();
  m.positions = mesh.vertices.data();
  m.vertex_count = mesh.vertex_count();
  m.indices = mesh.indices.data();
  m.triangle_count = mesh.triangle_count();
  m.closed = closed ? 1 : 0;
  m.is_real = is_real ? 1 : 0;
  return m;
}

// 0..1 at a place of the plane, between the four texels about it; `outside` beyond the texture, or where none is valid.
inline double sampled(const sandglass_texture& t, Vec3 p, double outside, uint32_t layer = 0) {
  if (t.valid == 0) return outside;
  const Vec3 along = from_floats(t.along), across = from_floats(t.across), from = p - from_floats(t.corner);
  const double u = dot(from, along) / dot(along, along), v = dot(from, across) / dot(across, across);
  if (!(u >= 0 && u <= 1 && v >= 0 && v <= 1)) return outside;
  const int n = static_cast<int>(t.side);
  const uint8_t* bytes = t.bytes + static_cast<size_t>(layer) * t.side * t.side;
  const double x = u * n - 0.5, y = v * n - 0.5, left = std::floor(x), top = std::floor(y);
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const int a = std::clamp(static_cast<int>(left) + i % 2, 0, n - 1),
              b = std::clamp(static_cast<int>(top) + i / 2, 0, n - 1);
    sum += (1 - std::fabs(x - left - i % 2)) * (1 - std::fabs(y - top - i / 2)) * bytes[b * n + a] / 255.0;
  }
  return sum;
}

// The same of a place above the plane: it slides to the plane, and lies between two layers.
inline double slid(const sandglass_texture& t, Vec3 p, double outside) {
  const Vec3 normal = normalised(cross(from_floats(t.across), from_floats(t.along)));
  const double height = dot(p - from_floats(t.corner), normal);
  const Vec3 at = p - from_floats(t.slide) * height;
  const double layer = std::clamp(height / static_cast<double>(t.height), 0.0, 1.0) * (t.layers - 1);
  const auto lower = static_cast<uint32_t>(layer), upper = std::min(lower + 1, t.layers - 1);
  const double share = layer - lower;
  return (1 - share) * sampled(t, at, outside, lower) + share * sampled(t, at, outside, upper);
}

}  // namespace sandglass::host
