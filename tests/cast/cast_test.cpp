// Casts: against what geometry says of simple shapes, the promises of the header, and their place in the frame. Against rays:
// `sandglass_lab verify cast`.
#include "sandglass/cast.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "runtime/math/hash.h"
#include "sandglass/sandglass.hpp"
#include "tests/reason.h"

namespace {

using sandglass::tests::expect_refused;
constexpr double k_degree = std::numbers::pi / 180;
constexpr uint64_t k_golden_light = 9354677186882402299u, k_golden_ambient = 13227487374963246401u;
constexpr uint64_t k_masked_light = 11740255921287245747u;  // where the main light's share is not told
constexpr uint64_t k_virtual_light = 11816735309424607936u,
                   k_virtual_ambient = 18222647050159184682u;  // without what is real

// ------------------------------------------------------------------------------------------------ scenes

struct Shape {
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  sandglass_cast_mesh mesh(uint32_t closed = 0) const {
    sandglass_cast_mesh m = sandglass::cast_mesh();
    m.positions = positions.data();
    m.vertex_count = static_cast<uint32_t>(positions.size() / 3);
    m.indices = indices.data();
    m.triangle_count = static_cast<uint32_t>(indices.size() / 3);
    m.closed = closed;
    return m;
  }
};

// Closed, counter-clockwise from outside.
Shape box(std::array<float, 3> low, std::array<float, 3> high) {
  Shape s;
  for (uint32_t i = 0; i < 8; ++i)
    for (uint32_t axis = 0; axis < 3; ++axis) s.positions.push_back((i >> axis & 1) != 0 ? high[axis] : low[axis]);
  s.indices = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
               2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  return s;
}

// A level square of `side` metres, `height` above the floor.
Shape square(float side, float height) {
  const float h = 0.5f * side;
  return {{-h, height, -h, h, height, -h, h, height, h, -h, height, h}, {0, 2, 1, 0, 3, 2}};
}

// A ball of triangles.
Shape ball(std::array<float, 3> centre, float radius, uint32_t rings) {
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

std::array<float, 3> towards(double elevation, double azimuth) {
  const double e = elevation * k_degree, a = azimuth * k_degree;
  return {static_cast<float>(std::cos(e) * std::cos(a)), static_cast<float>(std::sin(e)),
          static_cast<float>(std::cos(e) * std::sin(a))};
}

sandglass::Cast made(const sandglass_cast_desc& desc = sandglass::cast_desc()) {
  sandglass::Cast cast;
  EXPECT_TRUE(cast.create(desc));
  return cast;
}

sandglass::Cast lit(const std::vector<sandglass_cast_mesh>& meshes, std::array<float, 3> light, float diameter,
                    const sandglass_cast_desc& desc = sandglass::cast_desc(),
                    const sandglass_cast_plane& plane = sandglass::cast_plane()) {
  sandglass::Cast cast = made(desc);
  EXPECT_TRUE(cast.set_plane(plane));
  EXPECT_TRUE(cast.set_meshes(meshes.data(), static_cast<uint32_t>(meshes.size())));
  EXPECT_TRUE(cast.set_light(light, diameter));
  cast.run();
  return cast;
}

std::vector<uint8_t> bytes_of(const sandglass_texture& t) { return {t.bytes, t.bytes + t.side * t.side}; }

// Where a texel's middle lies, world.
std::array<double, 3> place_of(const sandglass_texture& t, uint32_t u, uint32_t v) {
  std::array<double, 3> p = {};
  for (uint32_t axis = 0; axis < 3; ++axis)
    p[axis] = t.corner[axis] + (u + 0.5) / t.side * t.along[axis] + (v + 0.5) / t.side * t.across[axis];
  return p;
}

double root_mean_square(const sandglass_texture& t, const std::function<double(double x, double z)>& expected) {
  double sum = 0;
  for (uint32_t v = 0; v < t.side; ++v)
    for (uint32_t u = 0; u < t.side; ++u) {
      const auto p = place_of(t, u, v);
      const double e = t.bytes[v * t.side + u] / 255.0 - expected(p[0], p[2]);
      sum += e * e;
    }
  return std::sqrt(sum / t.side / t.side);
}

double farthest(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  EXPECT_EQ(a.size(), b.size());
  int most = 0;
  for (size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

// A scene with all that has bounds of its own: closed and open, real and virtual, cut by the plane.
struct Mixed {
  Shape chair = box({-0.1f, -0.05f, -0.1f}, {0.1f, 0.4f, 0.1f}), lamp = ball({0.35f, 0.5f, 0.1f}, 0.12f, 12),
        leaf = square(0.3f, 0.25f), table = box({-0.9f, 0.2f, -0.6f}, {-0.1f, 0.23f, 0.6f});
  std::vector<sandglass_cast_mesh> meshes() const {
    std::vector<sandglass_cast_mesh> all = {chair.mesh(1), lamp.mesh(1), leaf.mesh(), table.mesh(1)};
    all[3].is_real = 1;
    return all;
  }
};

std::array<float, SANDGLASS_LIGHT_CELLS> uneven_cells() {
  std::array<float, SANDGLASS_LIGHT_CELLS> cells;
  float sum = 0;
  for (uint32_t i = 0; i < cells.size(); ++i) {
    cells[i] = static_cast<float>(1 + i * i % 17);
    sum += cells[i];
  }
  for (float& cell : cells) cell *= 0.9f / sum;
  return cells;
}

// ------------------------------------------------------------------------------------------------ geometry

// A light of almost no width: the shadow of a level square is that square, moved by its height over the light's slope.
TEST(Cast, SmallLightThrowsTheSquareItself) {
  const Shape s = square(0.4f, 0.5f);
  const sandglass::Cast cast = lit({s.mesh()}, towards(45, 0), 1e-4f);
  const sandglass_texture t = cast.texture();
  ASSERT_EQ(t.valid, 1u);
  const double texel = std::max<double>(std::abs(t.along[0]), std::abs(t.across[2])) / t.side;
  uint32_t inside = 0, outside = 0;
  for (uint32_t v = 0; v < t.side; ++v)
    for (uint32_t u = 0; u < t.side; ++u) {
      const auto p = place_of(t, u, v);
      const double to_edge = 0.2 - std::max(std::abs(p[0] + 0.5), std::abs(p[2]));  // moved by -0.5 along x
      if (std::abs(to_edge) < texel) continue;
      // The three windows reach seven texels, and only where counts differ by less than 8 of 64.
      const int filtered = std::abs(to_edge) < 8 * texel ? 8 * 255 / 64 : 0;
      ASSERT_NEAR(t.bytes[v * t.side + u], to_edge > 0 ? 255 : 0, filtered) << p[0] << " " << p[2];
      ++(to_edge > 0 ? inside : outside);
    }
  EXPECT_GT(inside, 5000u);
  EXPECT_GT(outside, 1000u);
}

// At the edge of a wide sheet a light overhead is hidden as far as a chord cuts its disk, whose radius on the sheet, seen
// from the floor, is height * tan(half) to first order; exactly, the directions are even in sin.
TEST(Cast, PenumbraOfAnEdgeIsTheDisksShare) {
  const Shape s = square(4, 0.5f);
  for (const double half : {5.0, 10.0, 20.0}) {
    sandglass_cast_plane plane = sandglass::cast_plane();
    plane.low[0] = 1.5f;  // about the edge x = 2
    plane.high[0] = 2.5f;
    plane.low[1] = -0.5f;
    plane.high[1] = 0.5f;
    const sandglass::Cast cast =
        lit({s.mesh()}, {0, 1, 0}, static_cast<float>(2 * half * k_degree), sandglass::cast_desc(), plane);
    const auto expected = [&](double x, double) {
      // The direction whose ray passes the edge has the slope (2 - x) / 0.5 along x; its sine is the chord.
      const double slope = (2 - x) / 0.5, chord = slope / std::sqrt(1 + slope * slope) / std::sin(half * k_degree);
      if (std::abs(chord) >= 1) return chord > 0 ? 1.0 : 0.0;
      return 1 - (std::acos(chord) - chord * std::sqrt(1 - chord * chord)) / std::numbers::pi;
    };
    EXPECT_LT(root_mean_square(cast.texture(), expected), 0.02) << half;
    EXPECT_GT(root_mean_square(cast.texture(), [&](double x, double z) { return expected(x + 0.03, z); }), 0.02)
        << half;
  }
}

// Under an even sky a point below the middle of a square loses the square's form factor, four times that of a quarter above
// its corner: with a = half the side over the height, F = 4 / pi * a / sqrt(1 + a^2) * atan(a / sqrt(1 + a^2)).
TEST(Cast, AmbientBelowASquareIsItsFormFactor) {
  for (const float height : {0.3f, 0.5f, 1.0f}) {
    const Shape s = square(1, height);
    sandglass::Cast cast = lit({s.mesh()}, {0, 1, 0}, 0);
    const sandglass_texture t = cast.ambient();
    ASSERT_EQ(t.valid, 1u);
    const double a = 0.5 / height, r = std::sqrt(1 + a * a), factor = 4 / std::numbers::pi * (a / r) * std::atan(a / r);
    double middle = 0;
    for (uint32_t v = t.side / 2 - 1; v <= t.side / 2; ++v)
      for (uint32_t u = t.side / 2 - 1; u <= t.side / 2; ++u) middle += t.bytes[v * t.side + u] / 255.0 / 4;
    EXPECT_NEAR(middle, 1 - factor, 0.02) << height;
  }
}

// What stands before a wall is what stands on a floor, seen in the wall's frame.
TEST(Cast, AnyPlaneIsAFloorOfItsOwn) {
  const Mixed scene;
  const sandglass::Cast floor = lit(scene.meshes(), towards(50, 30), 0.3f);
  // x to z, y to x, z to y.
  const auto turned = [](std::array<float, 3> v) { return std::array<float, 3>{v[1], v[2], v[0]}; };
  sandglass_cast_plane wall = sandglass::cast_plane();
  const auto normal = turned({0, 1, 0}), along = turned({1, 0, 0});
  for (uint32_t i = 0; i < 3; ++i) {
    wall.normal[i] = 3 * normal[i];
    wall.along[i] = along[i] + 0.5f * normal[i];
  }
  std::vector<sandglass_cast_mesh> meshes = scene.meshes();
  for (sandglass_cast_mesh& m : meshes) {
    std::fill(m.world_from_mesh, m.world_from_mesh + 15, 0.0f);
    m.world_from_mesh[2] = m.world_from_mesh[4] = m.world_from_mesh[9] = 1;
  }
  const sandglass::Cast cast = lit(meshes, turned(towards(50, 30)), 0.3f, sandglass::cast_desc(), wall);
  EXPECT_LE(farthest(bytes_of(floor.texture()), bytes_of(cast.texture())), 8);  // a texel's edge may round otherwise
  EXPECT_LE(farthest(bytes_of(floor.ambient()), bytes_of(cast.ambient())), 8);
  const auto corner = turned({floor.texture().corner[0], floor.texture().corner[1], floor.texture().corner[2]});
  for (uint32_t i = 0; i < 3; ++i) EXPECT_NEAR(cast.texture().corner[i], corner[i], 1e-5);
}

// A box that reaches through the floor is the part above it.
TEST(Cast, OnlyWhatIsAboveThePlaneCasts) {
  const Shape whole = box({-0.1f, -0.3f, -0.2f}, {0.1f, 0.4f, 0.1f}),
              upper = box({-0.1f, 0, -0.2f}, {0.1f, 0.4f, 0.1f}), below = box({0.5f, -0.4f, 0.5f}, {0.7f, -0.1f, 0.7f});
  const auto of = [](const Shape& s) { return bytes_of(lit({s.mesh(1)}, towards(40, 200), 0.3f).texture()); };
  EXPECT_EQ(of(whole), of(upper));
  const sandglass::Cast both = lit({upper.mesh(1), below.mesh(1)}, towards(40, 200), 0.3f);
  EXPECT_EQ(of(upper), bytes_of(both.texture()));
  EXPECT_EQ(both.report().left_out, 0u);
}

// A table's end is where its shadows end, with what falls there, whatever the table's size is.
TEST(Cast, ShadowsReachThePlanesEndAndNotBeyond) {
  for (const float scale : {0.1f, 1.0f, 8.0f})
    for (uint32_t i = 0; i < 12; ++i) {
      const float end = scale * (0.3f + 0.031f * static_cast<float>(i)), from = end - 0.13f * scale;
      const Shape s = box({from, 0, -0.04f * scale}, {from + 0.08f * scale, 0.25f * scale, 0.04f * scale});
      sandglass_cast_plane plane = sandglass::cast_plane();
      plane.high[0] = end;
      plane.low[1] = -0.05f * scale;
      plane.high[1] = 0.045f * scale;
      const sandglass::Cast cut = lit({s.mesh(1)}, towards(45, 180), 0.1f, sandglass::cast_desc(), plane),
                            whole = lit({s.mesh(1)}, towards(45, 180), 0.1f);
      for (const bool ambient : {false, true}) {
        const sandglass_texture t = ambient ? cut.ambient() : cut.texture(),
                                all = ambient ? whole.ambient() : whole.texture();
        EXPECT_NEAR(t.corner[0] + t.along[0], end, 1e-5f * scale);
        EXPECT_NEAR(t.corner[2], plane.low[1], 1e-5f * scale);
        EXPECT_NEAR(t.corner[2] + t.across[2], plane.high[1], 1e-5f * scale);
        // The control: without an end the shadow goes on.
        EXPECT_GT(all.corner[0] + all.along[0], end + 0.02f * scale);
        // In the last column there is as much of it as where nothing ends.
        double there = 0, without = 0;
        for (uint32_t v = 0; v < t.side; ++v) {
          const auto p = place_of(t, t.side - 1, v);
          const auto texel = [&](double x, double corner, double extent) {
            return static_cast<uint32_t>((x - corner) / extent * all.side);
          };
          there += t.bytes[v * t.side + t.side - 1] / 255.0 / t.side;
          without += all.bytes[texel(p[2], all.corner[2], all.across[2]) * all.side +
                               texel(p[0], all.corner[0], all.along[0])] /
                     255.0 / t.side;
        }
        EXPECT_NEAR(there, without, 0.04) << ambient << " " << end;
        EXPECT_GT(ambient ? 1 - there : there, 0.05);
      }
    }
}

// Half of a closed mesh is enough; so is a mirrored one, and one with short indices.
TEST(Cast, ClosedMirroredAndShortIndicesAreTheSame) {
  const Shape s = ball({0.1f, 0.3f, 0}, 0.25f, 16);
  const auto of = [](const sandglass_cast_mesh& m) { return bytes_of(lit({m}, towards(50, 30), 0.3f).texture()); };
  const std::vector<uint8_t> both_sides = of(s.mesh());
  EXPECT_LE(farthest(of(s.mesh(1)), both_sides), 8);
  Shape mirrored = s;
  for (size_t i = 0; i < s.positions.size(); i += 3) mirrored.positions[i] = -s.positions[i];
  sandglass_cast_mesh back = mirrored.mesh(1);
  back.world_from_mesh[0] = -1;
  EXPECT_EQ(of(back), of(s.mesh(1)));
  const std::vector<uint16_t> shorts(s.indices.begin(), s.indices.end());
  sandglass_cast_mesh small = s.mesh(1);
  small.indices = shorts.data();
  small.index_bytes = 2;
  EXPECT_EQ(of(small), of(s.mesh(1)));
  Shape apart;
  for (const uint32_t i : s.indices)
    apart.positions.insert(apart.positions.end(),
                           {s.positions[3 * i], s.positions[3 * i + 1], s.positions[3 * i + 2], 0});
  sandglass_cast_mesh without = apart.mesh(1);
  without.indices = nullptr;
  without.stride = 16;
  without.vertex_count = static_cast<uint32_t>(s.indices.size());
  without.triangle_count = without.vertex_count / 3;
  EXPECT_EQ(of(without), of(s.mesh(1)));
}

// ------------------------------------------------------------------------------------------------ real and virtual

TEST(Cast, RealThingsDarkenVirtualPlanesOnly) {
  const Shape s = box({-0.2f, 0.3f, -0.2f}, {0.2f, 0.35f, 0.2f});
  sandglass_cast_mesh real = s.mesh(1);
  real.is_real = 1;
  const sandglass::Cast on_real = lit({real}, towards(60, 0), 0.2f);
  const std::vector<uint8_t> light = bytes_of(on_real.texture()), ambient = bytes_of(on_real.ambient());
  EXPECT_EQ(on_real.texture().valid, 1u);
  EXPECT_EQ(std::count(light.begin(), light.end(), 0), static_cast<long>(light.size()));
  EXPECT_EQ(std::count(ambient.begin(), ambient.end(), 255), static_cast<long>(ambient.size()));
  sandglass_cast_plane plane = sandglass::cast_plane();
  plane.is_virtual = 1;
  const sandglass::Cast on_virtual = lit({real}, towards(60, 0), 0.2f, sandglass::cast_desc(), plane);
  EXPECT_EQ(bytes_of(on_virtual.texture()), bytes_of(lit({s.mesh(1)}, towards(60, 0), 0.2f).texture()));
}

// The floor under a real table that hides half of the light: what a virtual object above it hides of that half is dark already.
// With the light's disk hidden on one side of the edge by the table and wholly by the object, all that is left goes.
TEST(Cast, WhatIsRealMasksWhatIsVirtual) {
  const Shape table = square(4, 0.5f), object = square(6, 0.8f);
  sandglass_cast_mesh real = table.mesh();
  real.is_real = 1;
  sandglass_cast_plane plane = sandglass::cast_plane();
  plane.low[0] = 1.5f;
  plane.high[0] = 2.2f;
  plane.low[1] = -0.5f;
  plane.high[1] = 0.5f;
  const sandglass::Cast cast = lit({real, object.mesh()}, {0, 1, 0}, 0.35f, sandglass::cast_desc(), plane);
  const sandglass_texture t = cast.texture();
  // Well under the table nothing is left to hide, and 0 is said; at its edge all of the rest is hidden.
  for (uint32_t v = 8; v < t.side - 8; ++v)
    for (uint32_t u = 0; u < t.side; ++u) {
      const double x = place_of(t, u, v)[0];
      if (x > 2.2 || std::abs(place_of(t, u, v)[2]) > 0.5) continue;
      if (x < 1.85 || x > 2.0) {
        EXPECT_EQ(t.bytes[v * t.side + u], x < 1.85 ? 0 : 255) << x;
      }
    }
}

// Whatever comes first, and in whatever units: the last textures are the same, into the shade and out of it.
TEST(Cast, ShadeIsTheSameInAnyOrder) {
  const Shape s = box({-0.05f, 0, 0.05f}, {0.05f, 0.12f, 0.15f}), wall = box({-1.5f, 0, 0.3f}, {1.5f, 1.2f, 0.35f});
  std::vector<sandglass_cast_mesh> meshes = {s.mesh(1), wall.mesh(1)};
  meshes[1].is_real = 1;
  std::array<float, SANDGLASS_LIGHT_CELLS> cells;
  cells.fill(0.2f / SANDGLASS_LIGHT_CELLS);
  const auto first = [&](uint32_t order, uint32_t units, bool away) {
    sandglass::Cast cast = made();
    for (uint32_t i = 0; i < 3; ++i) {
      const uint32_t step = (order + i) % 3;
      EXPECT_TRUE(step != 0 || cast.set_meshes(meshes.data(), 2));
      EXPECT_TRUE(step != 1 || cast.set_light(towards(45, 90), 0.16f));
      EXPECT_TRUE(step != 2 || cast.set_cells(cells));
      cast.run(units);
    }
    while (cast.run(1) == 1) continue;
    if (away) {
      EXPECT_TRUE(cast.set_meshes(meshes.data(), 1));
      cast.run();
    }
    std::vector<uint8_t> bytes = bytes_of(cast.texture());
    const std::vector<uint8_t> ambient = bytes_of(cast.ambient());
    bytes.insert(bytes.end(), ambient.begin(), ambient.end());
    return bytes;
  };
  for (const bool away : {false, true}) {
    const std::vector<uint8_t> bytes = first(0, 1000, away);
    for (uint32_t order = 0; order < 3; ++order)
      for (const uint32_t units : {0u, 5u, 1000u}) EXPECT_EQ(first(order, units, away), bytes) << order << " " << units;
  }
}

// Whether a ray meets a box of box().
bool meets(const Shape& box, const std::array<double, 3>& from, const std::array<double, 3>& d) {
  double first = 0, last = 1e9;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double low = (box.positions[axis] - from[axis]) / d[axis],
                 high = (box.positions[21 + axis] - from[axis]) / d[axis];
    first = std::max(first, std::min(low, high));
    last = std::min(last, std::max(low, high));
  }
  return first < last;
}

// What a box takes of a floor that a real wall, or a real table, shades already, in a light from +z and an even sky: the
// library's darkening, summed over the floor, is within 6 % of what rays say, whatever the light's share. The control does
// not tell the share, so each texture is divided by what is left of its own light alone.
TEST(Cast, InRealShadeTheDarkeningIsThatOfRays) {
  constexpr double k_half = 5, k_elevation = 50;
  constexpr int k_side = 24, k_light_rays = 128, k_rays = 512;
  const Shape object = box({-0.04f, 0, -0.05f}, {0.05f, 0.2f, 0.04f});
  for (const Shape& real : {box({-1.5f, 0, 0.3f}, {1.5f, 1.2f, 0.35f}), box({-0.6f, 0.5f, -0.5f}, {0.6f, 0.53f, 1})}) {
    std::vector<std::array<double, 3>> rays;
    for (int i = 0; i < k_rays; ++i) {
      const double a = std::fmod(0.5 + 0.7548776662 * i, 1),
                   turn = 2 * std::numbers::pi * std::fmod(0.5 + 0.569840291 * i, 1);
      const double out = i < k_light_rays ? std::sin(k_half * k_degree) * std::sqrt(a) : std::sqrt(a);
      const double x = out * std::cos(turn), y = std::sqrt(1 - out * out), z = out * std::sin(turn);
      const double c = std::cos(k_elevation * k_degree), s = std::sin(k_elevation * k_degree);
      if (i < k_light_rays) rays.push_back({x, s * y + c * z, c * y - s * z});
      else rays.push_back({x, y, z});
    }
    sandglass_cast_mesh is_real = real.mesh(1);
    is_real.is_real = 1;
    const auto drawn = [&](double share) {
      sandglass::Cast cast =
          lit({object.mesh(1), is_real}, towards(k_elevation, 90), static_cast<float>(2 * k_half * k_degree));
      std::array<float, SANDGLASS_LIGHT_CELLS> cells;
      cells.fill(static_cast<float>((1 - share) / SANDGLASS_LIGHT_CELLS));
      EXPECT_TRUE(cast.set_cells(cells));
      cast.run();
      return cast;
    };
    const auto sampled = [](const sandglass_texture& t, double x, double z, double outside) {
      const double u = (x - t.corner[0]) / t.along[0] * t.side, v = (z - t.corner[2]) / t.across[2] * t.side;
      if (u < 0 || v < 0 || u >= t.side || v >= t.side) return outside;
      return t.bytes[static_cast<uint32_t>(v) * t.side + static_cast<uint32_t>(u)] / 255.0;
    };
    const sandglass::Cast untold = drawn(0);
    double worst = 0, control = 0;
    for (const double share : {0.3, 0.5, 0.7, 0.85, 0.95}) {
      const sandglass::Cast cast = drawn(share);
      double wanted = 0, told = 0, not_told = 0;
      for (int i = 0; i < k_side * k_side; ++i) {
        const double x = (i % k_side - 11.5) / k_side * 0.44, z = (i / k_side - 11.5) / k_side * 0.44;
        double before = 0, after = 0;
        for (int ray = 0; ray < k_rays; ++ray) {
          const double weight = ray < k_light_rays ? share / k_light_rays : (1 - share) / (k_rays - k_light_rays);
          if (meets(real, {x, 1e-5, z}, rays[static_cast<size_t>(ray)])) continue;
          before += weight;
          after += meets(object, {x, 1e-5, z}, rays[static_cast<size_t>(ray)]) ? 0 : weight;
        }
        if (before < 0.01) continue;
        wanted += 1 - after / before;
        told += 1 - share * (1 - sampled(cast.texture(), x, z, 0)) -
                std::max(sampled(cast.ambient(), x, z, 1) - share, 0.0);
        not_told += share * sampled(untold.texture(), x, z, 0) + (1 - share) * (1 - sampled(untold.ambient(), x, z, 1));
      }
      worst = std::max(worst, std::abs(told / wanted - 1));
      control = std::max(control, std::abs(not_told / wanted - 1));
    }
    EXPECT_LE(worst, 0.06);
    EXPECT_GT(control, 0.15);
  }
}

Shape together(const Shape& a, const Shape& b) {
  Shape both = a;
  both.positions.insert(both.positions.end(), b.positions.begin(), b.positions.end());
  for (const uint32_t i : b.indices) both.indices.push_back(static_cast<uint32_t>(a.positions.size() / 3) + i);
  return both;
}

// Beside a mug its shadow is as if it were alone, whatever else is in the cast; and what casts nothing is told.
TEST(Cast, WhatIsFarDoesNotMakeAShadowCoarse) {
  const Shape mug = box({-0.04f, 0, -0.04f}, {0.04f, 0.1f, 0.04f}), second = box({2.96f, 0, 0}, {3.04f, 0.1f, 0.08f});
  const Shape stray = {{0.04f, 0, 0.04f, -0.04f, 0, 0.04f, 3, 40, 2}, {0, 1, 2}}, bird = ball({30, 10, 0}, 0.1f, 12);
  const auto light = towards(54, 31);
  const sandglass::Cast alone = lit({mug.mesh()}, light, 0.35f);
  EXPECT_EQ(alone.report().too_far, 0u);
  const Shape in_one[] = {together(mug, stray), together(stray, mug)};
  for (const std::vector<sandglass_cast_mesh>& meshes :
       {std::vector{mug.mesh(), second.mesh(1)}, std::vector{mug.mesh(), bird.mesh()}, std::vector{in_one[0].mesh()},
        std::vector{in_one[1].mesh()}}) {
    const sandglass::Cast cast = lit(meshes, light, 0.35f);
    EXPECT_GT(cast.report().too_far, 0u);
    EXPECT_EQ(bytes_of(cast.texture()), bytes_of(alone.texture()));
    EXPECT_EQ(bytes_of(cast.ambient()), bytes_of(alone.ambient()));
    sandglass_cast_desc desc = sandglass::cast_desc();
    desc.reach = 0;
    const sandglass::Cast control = lit(meshes, light, 0.35f, desc);
    EXPECT_EQ(control.report().too_far, 0u);
    EXPECT_GT(control.texture().along[0], 10 * alone.texture().along[0]);
  }
}

// What is near, or leads there, casts: a board full of pawns, a street lamp on a base of many triangles, a ring about
// its middle. The first mesh says what near is.
TEST(Cast, WhatIsNearIsInTheRectangle) {
  const auto far = [](const std::vector<sandglass_cast_mesh>& meshes) {
    return lit(meshes, towards(50, 30), 0.2f).report().too_far;
  };
  std::vector<Shape> pawns;
  for (uint32_t i = 0; i < 16; ++i) {
    const float x = 0.06f * static_cast<float>(i % 8), z = i < 8 ? 0 : 0.42f;
    pawns.push_back(box({x, 0, z}, {x + 0.02f, 0.04f, z + 0.02f}));
  }
  std::vector<sandglass_cast_mesh> meshes;
  for (const Shape& pawn : pawns) meshes.push_back(pawn.mesh(1));
  EXPECT_EQ(far(meshes), 0u);
  EXPECT_EQ(far({meshes[0], meshes[15]}), 0u);
  const Shape base = ball({0, 0.05f, 0}, 0.15f, 16), pole = box({-0.05f, 0, -0.05f}, {0.05f, 6, 0.05f}),
              lamp = ball({0, 6, 0}, 0.2f, 8);
  EXPECT_EQ(far({base.mesh(1), pole.mesh(1), lamp.mesh(1)}), 0u);
  EXPECT_EQ(far({together(together(base, pole), lamp).mesh(1)}), 0u);
  EXPECT_EQ(far({base.mesh(1), lamp.mesh(1)}), lamp.indices.size() / 3);
  EXPECT_GT(far({lamp.mesh(1), base.mesh(1)}), 0u);
  Shape ring;
  for (uint32_t i = 0; i < 12; ++i) {
    const auto at = towards(0, 30.0 * i);
    ring = together(ring, box({5 * at[0], 0, 5 * at[2]}, {5 * at[0] + 0.1f, 1, 5 * at[2] + 0.1f}));
  }
  EXPECT_EQ(far({ring.mesh(1)}), 0u);
  EXPECT_EQ(far({ring.mesh(1), pawns[0].mesh(1)}), 0u);
  // In any division into units, where there is much to take out.
  sandglass_cast_desc desc = sandglass::cast_desc();
  desc.triangle_capacity = 40000;
  const Shape many = ball({0, 0.2f, 0}, 0.2f, 64), more = ball({9, 0.2f, 0}, 0.2f, 64);
  const std::vector<sandglass_cast_mesh> mixed = {many.mesh(), more.mesh(1), more.mesh()};
  sandglass::Cast parts = made(desc);
  EXPECT_TRUE(parts.set_meshes(mixed.data(), 2) && parts.set_light(towards(50, 30), 0.2f));
  while (parts.run(1) == 1) continue;
  EXPECT_GT(parts.report().too_far, 16000u);
  EXPECT_EQ(bytes_of(parts.texture()), bytes_of(lit({many.mesh()}, towards(50, 30), 0.2f, desc).texture()));
}

// The mesh of a scan has the floor in it, up to 30 mm over the plane: a virtual box keeps its whole shadow.
TEST(Cast, TheFloorOfAScanIsThePlane) {
  const Shape object = box({-0.1f, 0, -0.1f}, {0.1f, 0.2f, 0.1f});
  std::mt19937 engine(5);
  for (const float offset : {-0.005f, 0.0f, 0.008f, 0.02f})
    for (const float noise : {0.0f, 0.003f, 0.0099f}) {
      constexpr uint32_t k_side = 24;
      Shape scan;
      for (uint32_t i = 0; i < k_side * k_side; ++i) {
        const float random = static_cast<float>(engine() % 2001) * 0.001f - 1;
        scan.positions.insert(scan.positions.end(),
                              {0.08f * static_cast<float>(i % k_side) - 0.96f, offset + noise * random,
                               0.08f * static_cast<float>(i / k_side) - 0.96f});
        const uint32_t a = i, b = i + k_side;
        if (i % k_side + 1 < k_side && b < k_side * k_side)
          scan.indices.insert(scan.indices.end(), {a, b, a + 1, a + 1, b, b + 1});
      }
      sandglass_cast_mesh real = scan.mesh();
      real.is_real = 1;
      const auto of = [&](const std::vector<sandglass_cast_mesh>& meshes, float bias) {
        sandglass_cast_plane plane = sandglass::cast_plane();
        plane.bias = bias;
        const sandglass::Cast cast = lit(meshes, towards(55, 30), 0.3f, sandglass::cast_desc(), plane);
        return std::pair{bytes_of(cast.texture()), bytes_of(cast.ambient())};
      };
      EXPECT_EQ(of({real, object.mesh(1)}, 0.03f), of({object.mesh(1)}, 0.03f)) << offset << " " << noise;
      if (offset < 0.01f) continue;
      const std::vector<uint8_t> none = of({real, object.mesh(1)}, 0).first;  // the control
      EXPECT_EQ(std::count(none.begin(), none.end(), 0), static_cast<long>(none.size()));
    }
}

// ------------------------------------------------------------------------------------------------ promises

TEST(Cast, OneHashOnEveryInstructionSet) {
  const Mixed scene;
  for (uint32_t i = 0; i < 10; ++i) {
    const bool with_table = i % 2 != 0;
    constexpr sandglass_isa k_isas[] = {SANDGLASS_ISA_SCALAR, SANDGLASS_ISA_NEON, SANDGLASS_ISA_AVX2,
                                        SANDGLASS_ISA_AVX512, SANDGLASS_ISA_WASM};
    sandglass_cast_desc desc = sandglass::cast_desc();
    desc.isa = k_isas[i / 2];
    uint64_t bytes = 0;
    if (sandglass_cast_bytes(&desc, &bytes, nullptr) == SANDGLASS_ERROR_UNSUPPORTED) continue;
    std::vector<sandglass_cast_mesh> meshes = scene.meshes();
    if (!with_table) meshes.pop_back();
    sandglass::Cast cast = lit(meshes, towards(35, 70), 0.4f, desc);
    const std::vector<uint8_t> masked = bytes_of(cast.texture());
    EXPECT_EQ(sandglass::hash_bytes(masked.data(), masked.size()), with_table ? k_masked_light : k_virtual_light) << i;
    EXPECT_TRUE(cast.set_cells(uneven_cells()));
    cast.run();
    const std::vector<uint8_t> light = bytes_of(cast.texture()), ambient = bytes_of(cast.ambient());
    EXPECT_EQ(sandglass::hash_bytes(light.data(), light.size()), with_table ? k_golden_light : k_virtual_light) << i;
    EXPECT_EQ(sandglass::hash_bytes(ambient.data(), ambient.size()), with_table ? k_golden_ambient : k_virtual_ambient)
        << i;
    // The control: a flat texture would prove little.
    EXPECT_GT(std::set<uint8_t>(light.begin(), light.end()).size(), 100u);
    EXPECT_GT(std::set<uint8_t>(ambient.begin(), ambient.end()).size(), 50u);
  }
}

TEST(Cast, AnyDivisionIntoUnitsGivesTheSameBytes) {
  const Mixed scene;
  const std::vector<sandglass_cast_mesh> meshes = scene.meshes();
  const sandglass::Cast whole = lit(meshes, towards(35, 70), 0.4f);
  sandglass::Cast parts = made();
  EXPECT_TRUE(parts.set_meshes(meshes.data(), 4));
  EXPECT_TRUE(parts.set_light(towards(35, 70), 0.4f));
  uint32_t units = 0;
  while (parts.run(1) == 1) {
    ++units;
    EXPECT_TRUE(parts.set_meshes(meshes.data(), 4));  // as every frame does
    EXPECT_TRUE(parts.set_light(towards(35, 70), 0.4f));
  }
  EXPECT_GT(units, 20u);
  EXPECT_EQ(bytes_of(whole.texture()), bytes_of(parts.texture()));
  EXPECT_EQ(bytes_of(whole.ambient()), bytes_of(parts.ambient()));
}

TEST(Cast, WhatIsAsItWasCostsNothing) {
  const Mixed scene;
  std::vector<sandglass_cast_mesh> meshes = scene.meshes();
  sandglass::Cast cast = lit(meshes, towards(50, 30), 0.3f);
  const double texel = std::min<double>(cast.texture().along[0], cast.texture().across[2]) / cast.texture().side;
  const auto again = [&] {
    EXPECT_TRUE(cast.set_meshes(meshes.data(), static_cast<uint32_t>(meshes.size())));
    return cast.run();
  };
  EXPECT_EQ(again(), 0u);
  EXPECT_EQ(cast.texture().behind, 0u);
  // An anchor that trembles by a hundredth of a texel, for long, but one that creeps as far is followed.
  for (uint32_t i = 0; i < 100; ++i) {
    meshes[0].world_from_mesh[12] = static_cast<float>((i % 2 == 0 ? 0.01 : -0.01) * texel);
    EXPECT_EQ(again(), 0u);
  }
  uint32_t made_anew = 0;
  for (uint32_t i = 0; i < 100; ++i) {
    meshes[0].world_from_mesh[12] = static_cast<float>(0.01 * i * texel);
    made_anew += again() > 0 ? 1 : 0;
  }
  EXPECT_GE(made_anew, 8u);
  EXPECT_LE(made_anew, 11u);
  EXPECT_TRUE(cast.set_light(towards(50.2, 30), 0.3f));
  EXPECT_EQ(cast.run(), 0u);
  EXPECT_TRUE(cast.set_light(towards(52, 30), 0.3f));
  EXPECT_GT(cast.run(), 0u);
  ++meshes[1].version;
  EXPECT_GT(again(), 0u);
  sandglass_cast_plane plane = sandglass::cast_plane();
  EXPECT_TRUE(cast.set_plane(plane));
  EXPECT_EQ(cast.run(), 0u);
  // A tracker's plane grows; one that cuts the shadow does count.
  for (float& x : plane.high) x = 3;
  EXPECT_TRUE(cast.set_plane(plane));
  EXPECT_EQ(cast.run(), 0u);
  plane.high[0] = 0.2f;
  EXPECT_TRUE(cast.set_plane(plane));
  EXPECT_GT(cast.run(), 0u);
  plane.origin[1] = 0.01f;
  EXPECT_TRUE(cast.set_plane(plane));
  EXPECT_GT(cast.run(), 0u);
}

// A tracker shifts a plane's origin within it; its ends stay in the world, near the shadow or far.
TEST(Cast, AnOriginThatShiftsWithinThePlaneCostsNothing) {
  const Shape s = box({-0.05f, 0, -0.03f}, {0.05f, 0.12f, 0.03f});
  const sandglass_cast_mesh mesh = s.mesh(1);
  const float tilt = std::sqrt(0.5f);
  for (const float half : {0.07f, 5000.0f}) {
    sandglass_cast_plane plane = sandglass::cast_plane();
    plane.normal[0] = plane.normal[1] = plane.along[0] = tilt;
    plane.along[1] = -tilt;
    std::fill_n(plane.low, 2, -half);
    std::fill_n(plane.high, 2, half);
    const sandglass_cast_plane first = plane;
    sandglass::Cast cast = lit({mesh}, towards(50, 30), 0.2f, sandglass::cast_desc(), plane);
    const std::vector<uint8_t> bytes = bytes_of(cast.texture());
    for (uint32_t frame = 1; frame <= 60; ++frame) {
      const float way[2] = {0.037f * static_cast<float>(frame % 40), -0.011f * static_cast<float>(frame)};
      plane.origin[0] = tilt * way[0];
      plane.origin[1] = -tilt * way[0];
      plane.origin[2] = way[1];
      for (uint32_t axis = 0; axis < 2; ++axis) {
        plane.low[axis] = first.low[axis] - way[axis];
        plane.high[axis] = first.high[axis] - way[axis];
      }
      EXPECT_TRUE(cast.set_plane(plane));
      EXPECT_EQ(cast.run(), 0u) << frame;
    }
    // The control: what leaves the plane, and ends that shift with the origin where they cut.
    plane.origin[0] += tilt * 0.01f;
    plane.origin[1] += tilt * 0.01f;
    EXPECT_TRUE(cast.set_plane(plane));
    EXPECT_GT(cast.run(), 0u);
    EXPECT_NE(bytes_of(cast.texture()), bytes);
    plane.high[0] += 0.01f;
    EXPECT_TRUE(cast.set_plane(plane));
    EXPECT_EQ(cast.run() > 0, half < 1);
  }
}

TEST(Cast, ManyTrianglesGetAFirstTextureAhead) {
  sandglass_cast_desc desc = sandglass::cast_desc();
  desc.triangle_capacity = 20000;
  const Shape s = ball({0, 0.4f, 0}, 0.3f, 64);  // 16,384
  const sandglass_cast_mesh mesh = s.mesh(1);
  sandglass::Cast cast = made(desc);
  EXPECT_TRUE(cast.set_meshes(&mesh, 1));
  EXPECT_TRUE(cast.set_light(towards(50, 30)));
  uint32_t first = 0, full = 0;
  for (uint32_t units = 1; full == 0 && cast.run(1) == 1; ++units) {
    const sandglass_texture t = cast.texture();
    if (first == 0 && t.valid != 0) {
      first = units;
      EXPECT_EQ(cast.report().directions, 8u);
      EXPECT_EQ(t.behind, 1u);
    }
    if (cast.report().directions == 64) full = units;
  }
  EXPECT_GT(first, 0u);
  EXPECT_LT(4 * first, full);
  // Where the object only turns, no coarse texture comes between two good ones.
  cast.run();
  sandglass_cast_mesh moved = mesh;
  moved.world_from_mesh[12] = 0.1f;
  EXPECT_TRUE(cast.set_meshes(&moved, 1));
  while (cast.run(1) == 1) EXPECT_EQ(cast.report().directions, 64u);
}

// An engine that skins on a thread hands out another array in every frame, and frees the one before; one that scans, of
// another length. Less than one gathering fits in a frame.
TEST(Cast, ArraysThatTakeTurnsAreAsGoodAsOne) {
  sandglass_cast_desc desc = sandglass::cast_desc();
  desc.triangle_capacity = 20000;
  const Shape s = ball({0, 0.4f, 0}, 0.3f, 64);  // 16,384 triangles: 32 units to gather
  const auto textures = [&](bool turns, uint32_t versions, uint32_t fewer) {
    sandglass::Cast cast = made(desc);
    EXPECT_TRUE(cast.set_light(towards(50, 30)));
    std::vector<float> kept = s.positions, last;
    for (uint32_t f = 0; f < 400; ++f) {
      std::vector<float> fresh = s.positions;
      sandglass_cast_mesh mesh = s.mesh(1);
      mesh.positions = turns ? fresh.data() : kept.data();
      mesh.version = f * versions;
      mesh.triangle_count -= fewer * (f % 3);
      EXPECT_TRUE(cast.set_meshes(&mesh, 1));
      last.swap(fresh);
      cast.run(20);
    }
    EXPECT_EQ(cast.report().directions, 64u);  // no coarse one follows a good one
    const auto completed = static_cast<uint32_t>(cast.texture().version);
    const sandglass_cast_mesh mesh = s.mesh(1);
    EXPECT_TRUE(cast.set_meshes(&mesh, 1));
    cast.run();
    EXPECT_EQ(bytes_of(cast.texture()), bytes_of(lit({mesh}, towards(50, 30), 0, desc).texture()));
    return completed;
  };
  const uint32_t one = textures(false, 1, 0);
  EXPECT_GE(one, 4u);
  EXPECT_EQ(textures(true, 1, 0), one);
  EXPECT_GE(textures(true, 0, 0), one);
  EXPECT_GE(textures(true, 1, 50), one / 2);  // a scan, which grows and is thinned
}

// A tracker tells a plane, and an app a pose, once: whenever that is, the texture that stays is of the last ones.
TEST(Cast, WhatChangesDuringATextureIsFollowed) {
  const Shape s = box({-0.05f, 0, -0.05f}, {0.05f, 0.3f, 0.05f});
  sandglass_cast_plane small = sandglass::cast_plane(), large = small;
  for (uint32_t axis = 0; axis < 2; ++axis) {
    small.low[axis] = -0.1f;
    small.high[axis] = 0.1f;
    large.low[axis] = -1;
    large.high[axis] = 1;
  }
  const sandglass_cast_mesh here = s.mesh(1);
  sandglass_cast_mesh away = here;
  away.world_from_mesh[12] = 0.02f;
  struct State {
    sandglass_cast_plane plane;
    sandglass_cast_mesh mesh;
  };
  const std::pair<State, State> changes[] = {
      {{small, here}, {large, here}}, {{large, here}, {small, here}}, {{large, here}, {large, away}}};
  for (const auto& [first, then] : changes) {
    const sandglass::Cast wanted = lit({then.mesh}, towards(45, 0), 0.1f, sandglass::cast_desc(), then.plane);
    uint32_t units = 0, ran = 0;
    for (;; ++units) {
      sandglass::Cast cast = made();
      EXPECT_TRUE(cast.set_plane(first.plane) && cast.set_meshes(&first.mesh, 1) &&
                  cast.set_light(towards(45, 0), 0.1f));
      ran = cast.run(units);
      EXPECT_TRUE(cast.set_plane(then.plane) && cast.set_meshes(&then.mesh, 1));
      cast.run();
      EXPECT_EQ(bytes_of(cast.texture()), bytes_of(wanted.texture())) << units;
      EXPECT_EQ(bytes_of(cast.ambient()), bytes_of(wanted.ambient())) << units;
      if (ran < units) break;
    }
    EXPECT_GT(units, 20u);
  }
}

// The mean over a convex surface is 1; two parallel squares hide the lower one from all but the light at the side.
TEST(Cast, OpenIsTheShareThatTheSurfaceReceives) {
  const Shape convex = ball({0, 0.4f, 0}, 0.2f, 24);
  EXPECT_GT(lit({convex.mesh(1)}, {0, 1, 0}, 0).report().open, 0.97f);
  const Shape upper = square(1, 0.52f), lower = square(1, 0.5f);
  EXPECT_NEAR(lit({upper.mesh(), lower.mesh()}, {0, 1, 0}, 0).report().open, 0.52f, 0.03f);
}

TEST(Cast, LightBelowThePlaneThrowsNoShadow) {
  const Shape s = box({-0.1f, 0, -0.1f}, {0.1f, 0.4f, 0.1f});
  const sandglass::Cast cast = lit({s.mesh(1)}, towards(-30, 0), 0.3f);
  const std::vector<uint8_t> bytes = bytes_of(cast.texture());
  EXPECT_EQ(cast.texture().valid, 1u);
  EXPECT_EQ(std::count(bytes.begin(), bytes.end(), 0), static_cast<long>(bytes.size()));
  // A low one throws one that goes on beyond five heights, and ends softly there: in a fifth of that.
  const sandglass::Cast low = lit({s.mesh(1)}, towards(6, 0), 0.02f);
  const sandglass_texture t = low.texture();
  const uint32_t fading = static_cast<uint32_t>(0.4 / static_cast<double>(t.along[0]) * t.side);
  const uint8_t* row = t.bytes + t.side / 2 * t.side;
  EXPECT_EQ(row[0], 0);
  EXPECT_EQ(row[fading + 8], 255);
  for (uint32_t u = 0; u < fading; ++u) EXPECT_LE(std::abs(row[u + 1] - row[u]), 255 / 10) << u;
  // One that the horizon cuts does.
  const std::vector<uint8_t> half = bytes_of(lit({s.mesh(1)}, towards(2, 0), 0.3f).texture());
  EXPECT_GT(std::count(half.begin(), half.end(), 255), 100);
}

// ------------------------------------------------------------------------------------------------ what apps get wrong

TEST(Cast, BadTrianglesAreLeftOutAndCounted) {
  Shape s = box({-0.1f, 0, -0.1f}, {0.1f, 0.4f, 0.1f});
  const std::vector<uint8_t> clean = bytes_of(lit({s.mesh(1)}, towards(50, 30), 0.3f).texture());
  s.positions.insert(s.positions.end(),
                     {std::nanf(""), 0.1f, 0, std::numeric_limits<float>::infinity(), 0, 0, 3e8f, 1, 1});
  s.indices.insert(s.indices.end(), {0, 1, 8, 0, 9, 1, 10, 1, 2, 0, 1, 4000000000u, 3, 3, 5, 6, 6, 6});
  const sandglass::Cast cast = lit({s.mesh(1)}, towards(50, 30), 0.3f);
  EXPECT_EQ(bytes_of(cast.texture()), clean);
  EXPECT_EQ(cast.report().left_out, 4u);  // the last two are degenerate, and draw nothing
}

TEST(Cast, RefusesWhatItCannotUse) {
  sandglass::Cast cast = made();
  const Shape s = square(1, 1);
  const auto plane = [&](const char* words, auto change) {
    sandglass_cast_plane p = sandglass::cast_plane();
    change(&p);
    expect_refused(words, [&](const char** reason) { return sandglass_cast_set_plane(cast.get(), &p, reason); });
  };
  plane("normal", [](auto* p) { p->normal[1] = 0; });
  plane("along", [](auto* p) {
    p->along[0] = 0;
    p->along[1] = 2;
  });
  plane("high", [](auto* p) { p->high[0] = p->low[0]; });
  sandglass_cast_desc near = sandglass::cast_desc();
  near.reach = 1;
  expect_refused("reach", [&](const char** reason) {
    uint64_t bytes = 0;
    return sandglass_cast_bytes(&near, &bytes, reason);
  });
  plane("bias", [](auto* p) { p->bias = -0.01f; });
  plane("bias", [](auto* p) { p->bias = std::nanf(""); });
  plane("origin", [](auto* p) { p->origin[2] = std::nanf(""); });
  const auto mesh = [&](const char* words, auto change, sandglass_status status = SANDGLASS_ERROR_INVALID_ARGUMENT) {
    sandglass_cast_mesh m = s.mesh();
    change(&m);
    expect_refused(
        words, [&](const char** reason) { return sandglass_cast_set_meshes(cast.get(), &m, 1, reason); }, status);
  };
  mesh("positions", [](auto* m) { m->positions = nullptr; });
  mesh("stride", [](auto* m) { m->stride = 10; });
  mesh("index_bytes", [](auto* m) { m->index_bytes = 3; });
  mesh("world_from_mesh", [](auto* m) { m->world_from_mesh[13] = std::nanf(""); });
  mesh(
      "triangle_capacity", [](auto* m) { m->triangle_count = 5000; }, SANDGLASS_ERROR_CAPACITY);
  sandglass_cast_mesh kept = s.mesh();
  EXPECT_TRUE(cast.set_meshes(&kept, 1));
  kept.triangle_count = 1;
  expect_refused("version",
                 [&](const char** reason) { return sandglass_cast_set_meshes(cast.get(), &kept, 1, reason); });
  ++kept.version;
  EXPECT_TRUE(cast.set_meshes(&kept, 1));
  const float light[3] = {0, 0, 0}, up[3] = {0, 1, 0};
  expect_refused("zero", [&](const char** reason) { return sandglass_cast_set_light(cast.get(), light, 0, reason); });
  expect_refused("angular_diameter",
                 [&](const char** reason) { return sandglass_cast_set_light(cast.get(), up, 2, reason); });
}

// Meshes that come and go while they are gathered: nothing of what has gone is read. The address sanitizer sees it.
TEST(Cast, MeshesMayGoWhileUnitsReadThem) {
  sandglass_cast_desc desc = sandglass::cast_desc();
  desc.triangle_capacity = 40000;
  sandglass::Cast cast = made(desc);
  EXPECT_TRUE(cast.set_light(towards(50, 30)));
  const Shape small = box({0, 0, 0}, {0.1f, 0.1f, 0.1f});
  for (uint32_t round = 0; round < 20; ++round) {
    const Shape s = ball({0, 0.4f, 0}, 0.3f, 24 + 2 * round);
    const sandglass_cast_mesh both[] = {small.mesh(1), s.mesh(round % 2)};
    EXPECT_TRUE(cast.set_meshes(both, 2));
    cast.run(1 + round % 3);
    EXPECT_TRUE(cast.set_meshes(nullptr, 0));
  }
  cast.run();
  EXPECT_EQ(cast.texture().behind, 0u);
  const std::vector<uint8_t> bytes = bytes_of(cast.texture());
  EXPECT_EQ(std::count(bytes.begin(), bytes.end(), 0), static_cast<long>(bytes.size()));
}

// ------------------------------------------------------------------------------------------------ in a frame

// One unit a frame: all casts arrive in turn, and give way to the shadow of the sand.
TEST(Cast, ArrivesInFramesWithoutTime) {
  sandglass::Scene scene;
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.granular.particle_capacity = 64;
  desc.clock.now_ns = [](void* now) { return *static_cast<uint64_t*>(now) += 1000; };
  uint64_t now = 0;
  desc.clock.user = &now;
  ASSERT_TRUE(scene.create(desc));
  const Mixed made_of;
  const std::vector<sandglass_cast_mesh> meshes = made_of.meshes();
  sandglass::Cast casts[2] = {made(), made()};
  sandglass_cast* const handles[2] = {casts[0].get(), casts[1].get()};
  sandglass::PileShadow sand;
  ASSERT_TRUE(sand.create(sandglass::pile_shadow_desc()));
  sandglass_frame_input input = sandglass::frame_input();
  input.casts = handles;
  input.cast_count = 2;
  input.pile_shadow = sand.get();
  uint32_t frames = 0, sands = 0;
  for (; frames < 3000; ++frames) {
    for (sandglass::Cast& cast : casts) {
      EXPECT_TRUE(cast.set_meshes(meshes.data(), 4));
      EXPECT_TRUE(cast.set_light(towards(30 + 0.02 * frames, 30), 0.3f));
    }
    const auto light = towards(30 + 0.02 * frames, 30);
    EXPECT_TRUE(sand.set_light(light));
    ASSERT_EQ(sandglass_scene_frame(scene.get(), &input, nullptr, nullptr), SANDGLASS_OK);
    sands += sand.texture().valid;
    if (casts[0].texture().version > 2 && casts[1].texture().version > 2 && casts[0].ambient().version > 0 && sands > 0)
      break;
  }
  EXPECT_LT(frames, 1500u);
  EXPECT_GT(casts[0].texture().version + 2, casts[1].texture().version);
}

}  // namespace
