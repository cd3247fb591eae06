// What the tests of casts share: simple shapes, a cast that is lit, and what its textures say.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "sandglass/sandglass.hpp"

namespace sandglass::tests {

constexpr double k_degree = std::numbers::pi / 180;

struct Shape {
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  sandglass_cast_mesh mesh(uint32_t closed = 0) const {
    sandglass_cast_mesh m = cast_mesh();
    m.positions = positions.data();
    m.vertex_count = static_cast<uint32_t>(positions.size() / 3);
    m.indices = indices.data();
    m.triangle_count = static_cast<uint32_t>(indices.size() / 3);
    m.closed = closed;
    return m;
  }
};

// Closed, counter-clockwise from outside.
inline Shape box(std::array<float, 3> low, std::array<float, 3> high) {
  Shape s;
  for (uint32_t i = 0; i < 8; ++i)
    for (uint32_t axis = 0; axis < 3; ++axis) s.positions.push_back((i >> axis & 1) != 0 ? high[axis] : low[axis]);
  s.indices = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
               2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  return s;
}

// A level square of `side` metres, `height` above the floor.
inline Shape square(float side, float height) {
  const float h = 0.5f * side;
  return {{-h, height, -h, h, height, -h, h, height, h, -h, height, h}, {0, 2, 1, 0, 3, 2}};
}

// A ball of triangles.
inline Shape ball(std::array<float, 3> centre, float radius, uint32_t rings) {
  Shape s;
  for (uint32_t i = 0; i <= rings; ++i)
    for (uint32_t j = 0; j < 2 * rings; ++j) {
      const double polar = std::numbers::pi * i / rings, turn = std::numbers::pi * j / rings;
      const double d[3] = {std::sin(polar) * std::cos(turn), std::cos(polar), std::sin(polar) * std::sin(turn)};
      for (uint32_t axis = 0; axis < 3; ++axis)
        s.positions.push_back(static_cast<float>(centre[axis] + radius * d[axis]));
    }
  for (uint32_t i = 0; i < rings; ++i)
    for (uint32_t j = 0; j < 2 * rings; ++j) {
      const uint32_t a = i * 2 * rings + j, b = i * 2 * rings + (j + 1) % (2 * rings), c = a + 2 * rings,
                     d = b + 2 * rings;
      s.indices.insert(s.indices.end(), {a, b, c, b, d, c});
    }
  return s;
}

inline std::array<float, 3> towards(double elevation, double azimuth) {
  const double e = elevation * k_degree, a = azimuth * k_degree;
  return {static_cast<float>(std::cos(e) * std::cos(a)), static_cast<float>(std::sin(e)),
          static_cast<float>(std::cos(e) * std::sin(a))};
}

inline sandglass_cast_mesh as_real(sandglass_cast_mesh mesh) {
  mesh.is_real = 1;
  return mesh;
}

// The floor between two corners (x, z).
inline sandglass_cast_plane floor_between(std::array<float, 2> low, std::array<float, 2> high) {
  sandglass_cast_plane plane = cast_plane();
  for (uint32_t axis = 0; axis < 2; ++axis) {
    plane.low[axis] = low[axis];
    plane.high[axis] = high[axis];
  }
  return plane;
}

inline sandglass_cast_desc desc_for(uint32_t triangles) {
  sandglass_cast_desc desc = cast_desc();
  desc.triangle_capacity = triangles;
  return desc;
}

inline Cast made(const sandglass_cast_desc& desc = cast_desc()) {
  Cast cast;
  EXPECT_TRUE(cast.create(desc));
  return cast;
}

inline Status set_meshes(Cast* cast, const std::vector<sandglass_cast_mesh>& meshes) {
  return cast->set_meshes(meshes.data(), static_cast<uint32_t>(meshes.size()));
}

inline Cast lit(const std::vector<sandglass_cast_mesh>& meshes, std::array<float, 3> light, float diameter,
                const sandglass_cast_desc& desc = cast_desc(), const sandglass_cast_plane& plane = cast_plane()) {
  Cast cast = made(desc);
  EXPECT_TRUE(cast.set_plane(plane) && set_meshes(&cast, meshes) && cast.set_light(light, diameter));
  cast.run();
  return cast;
}
inline Cast lit(const std::vector<sandglass_cast_mesh>& meshes, std::array<float, 3> light, float diameter,
                const sandglass_cast_plane& plane) {
  return lit(meshes, light, diameter, cast_desc(), plane);
}

using Bytes = std::vector<uint8_t>;
inline Bytes bytes_of(const sandglass_texture& t) { return {t.bytes, t.bytes + t.layers * t.side * t.side}; }
inline Bytes light_of(const Cast& cast) { return bytes_of(cast.texture()); }

// Of the light and of the ambient.
inline std::pair<Bytes, Bytes> both_of(const Cast& cast) { return {light_of(cast), bytes_of(cast.ambient())}; }

inline bool are_all(uint8_t value, const Bytes& bytes) { return bytes == Bytes(bytes.size(), value); }

// Where a texel's middle lies, world.
inline std::array<double, 3> place_of(const sandglass_texture& t, uint32_t u, uint32_t v) {
  std::array<double, 3> p = {};
  for (uint32_t axis = 0; axis < 3; ++axis)
    p[axis] = t.corner[axis] + (u + 0.5) / t.side * t.along[axis] + (v + 0.5) / t.side * t.across[axis];
  return p;
}

inline double root_mean_square(const sandglass_texture& t, const std::function<double(double x, double z)>& expected) {
  double sum = 0;
  for (uint32_t v = 0; v < t.side; ++v)
    for (uint32_t u = 0; u < t.side; ++u) {
      const auto p = place_of(t, u, v);
      const double e = t.bytes[v * t.side + u] / 255.0 - expected(p[0], p[2]);
      sum += e * e;
    }
  return std::sqrt(sum / t.side / t.side);
}

inline double farthest(const Bytes& a, const Bytes& b) {
  EXPECT_EQ(a.size(), b.size());
  int difference_max = 0;
  for (size_t i = 0; i < a.size(); ++i) difference_max = std::max(difference_max, std::abs(a[i] - b[i]));
  return difference_max;
}

// A scene with all that has bounds of its own: closed and open, real and virtual, cut by the plane.
struct Mixed {
  Shape chair = box({-0.1f, -0.05f, -0.1f}, {0.1f, 0.4f, 0.1f}), lamp = ball({0.35f, 0.5f, 0.1f}, 0.12f, 12),
        leaf = square(0.3f, 0.25f), table = box({-0.9f, 0.2f, -0.6f}, {-0.1f, 0.23f, 0.6f});
  std::vector<sandglass_cast_mesh> meshes() const {
    return {chair.mesh(1), lamp.mesh(1), leaf.mesh(), as_real(table.mesh(1))};
  }
};

inline std::array<float, SANDGLASS_LIGHT_CELLS> uneven_cells() {
  std::array<float, SANDGLASS_LIGHT_CELLS> cells;
  float sum = 0;
  for (uint32_t i = 0; i < cells.size(); ++i) {
    cells[i] = static_cast<float>(1 + i * i % 17);
    sum += cells[i];
  }
  for (float& cell : cells) cell *= 0.9f / sum;
  return cells;
}

}  // namespace sandglass::tests
