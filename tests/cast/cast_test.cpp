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

#include "runtime/core/hash.h"
#include "sandglass/sandglass.hpp"
#include "tests/guarded_block.h"
#include "tests/reason.h"

namespace {

using sandglass::tests::expect_refused;
constexpr double k_degree = std::numbers::pi / 180;
constexpr uint64_t k_golden_light = 11740255921287245747u, k_golden_ambient = 15044381425554822780u;

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

std::vector<uint8_t> bytes_of(const sandglass_cast_texture& t) { return {t.bytes, t.bytes + t.texels * t.texels}; }

// Where a texel's middle lies, world.
std::array<double, 3> place_of(const sandglass_cast_texture& t, uint32_t u, uint32_t v) {
  std::array<double, 3> p = {};
  for (uint32_t axis = 0; axis < 3; ++axis)
    p[axis] = t.corner[axis] + (u + 0.5) / t.texels * t.along[axis] + (v + 0.5) / t.texels * t.across[axis];
  return p;
}

double root_mean_square(const sandglass_cast_texture& t, const std::function<double(double x, double z)>& expected) {
  double sum = 0;
  for (uint32_t v = 0; v < t.texels; ++v)
    for (uint32_t u = 0; u < t.texels; ++u) {
      const auto p = place_of(t, u, v);
      const double e = t.bytes[v * t.texels + u] / 255.0 - expected(p[0], p[2]);
      sum += e * e;
    }
  return std::sqrt(sum / t.texels / t.texels);
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
  for (uint32_t i = 0; i < cells.size(); ++i) cells[i] = static_cast<float>(1 + i * i % 17), sum += cells[i];
  for (float& cell : cells) cell *= 0.9f / sum;
  return cells;
}

// ------------------------------------------------------------------------------------------------ geometry

// A light of almost no width: the shadow of a level square is that square, moved by its height over the light's slope.
TEST(Cast, SmallLightThrowsTheSquareItself) {
  const Shape s = square(0.4f, 0.5f);
  const sandglass::Cast cast = lit({s.mesh()}, towards(45, 0), 1e-4f);
  const sandglass_cast_texture t = cast.texture();
  ASSERT_EQ(t.valid, 1u);
  const double texel = std::max<double>(std::abs(t.along[0]), std::abs(t.across[2])) / t.texels;
  uint32_t inside = 0, outside = 0;
  for (uint32_t v = 0; v < t.texels; ++v)
    for (uint32_t u = 0; u < t.texels; ++u) {
      const auto p = place_of(t, u, v);
      const double to_edge = 0.2 - std::max(std::abs(p[0] + 0.5), std::abs(p[2]));  // moved by -0.5 along x
      if (std::abs(to_edge) < texel) continue;
      // The three windows reach seven texels, and only where counts differ by less than 8 of 64.
      const int filtered = std::abs(to_edge) < 8 * texel ? 8 * 255 / 64 : 0;
      ASSERT_NEAR(t.bytes[v * t.texels + u], to_edge > 0 ? 255 : 0, filtered) << p[0] << " " << p[2];
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
    plane.low[0] = 1.5f, plane.high[0] = 2.5f, plane.low[1] = -0.5f, plane.high[1] = 0.5f;  // about the edge x = 2
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
    const sandglass_cast_texture t = cast.ambient();
    ASSERT_EQ(t.valid, 1u);
    const double a = 0.5 / height, r = std::sqrt(1 + a * a), factor = 4 / std::numbers::pi * (a / r) * std::atan(a / r);
    double middle = 0;
    for (uint32_t v = t.texels / 2 - 1; v <= t.texels / 2; ++v)
      for (uint32_t u = t.texels / 2 - 1; u <= t.texels / 2; ++u) middle += t.bytes[v * t.texels + u] / 255.0 / 4;
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
  for (uint32_t i = 0; i < 3; ++i) wall.normal[i] = 3 * normal[i], wall.along[i] = along[i] + 0.5f * normal[i];
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
  EXPECT_EQ(both.texture().left_out, 0u);
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
  plane.low[0] = 1.5f, plane.high[0] = 2.2f, plane.low[1] = -0.5f, plane.high[1] = 0.5f;
  const sandglass::Cast cast = lit({real, object.mesh()}, {0, 1, 0}, 0.35f, sandglass::cast_desc(), plane);
  const sandglass_cast_texture t = cast.texture();
  // Well under the table nothing is left to hide, and 0 is said; at its edge all of the rest is hidden.
  for (uint32_t v = 8; v < t.texels - 8; ++v)
    for (uint32_t u = 0; u < t.texels; ++u) {
      const double x = place_of(t, u, v)[0];
      if (x > 2.2 || std::abs(place_of(t, u, v)[2]) > 0.5) continue;
      if (x < 1.85 || x > 2.0) {
        EXPECT_EQ(t.bytes[v * t.texels + u], x < 1.85 ? 0 : 255) << x;
      }
    }
}

// ------------------------------------------------------------------------------------------------ promises

TEST(Cast, OneHashOnEveryInstructionSet) {
  const Mixed scene;
  for (const sandglass_isa isa :
       {SANDGLASS_ISA_SCALAR, SANDGLASS_ISA_NEON, SANDGLASS_ISA_AVX2, SANDGLASS_ISA_AVX512, SANDGLASS_ISA_WASM}) {
    sandglass_cast_desc desc = sandglass::cast_desc();
    desc.isa = isa;
    uint64_t bytes = 0;
    if (sandglass_cast_bytes(&desc, &bytes, nullptr) == SANDGLASS_ERROR_UNSUPPORTED) continue;
    sandglass::Cast cast = lit(scene.meshes(), towards(35, 70), 0.4f, desc);
    EXPECT_TRUE(cast.set_cells(uneven_cells()));
    cast.run();
    const std::vector<uint8_t> light = bytes_of(cast.texture()), ambient = bytes_of(cast.ambient());
    EXPECT_EQ(sandglass::hash_bytes(light.data(), light.size()), k_golden_light) << isa;
    EXPECT_EQ(sandglass::hash_bytes(ambient.data(), ambient.size()), k_golden_ambient) << isa;
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
  const double texel = std::min<double>(cast.texture().along[0], cast.texture().across[2]) / cast.texture().texels;
  const auto again = [&] {
    EXPECT_TRUE(cast.set_meshes(meshes.data(), static_cast<uint32_t>(meshes.size())));
    return cast.run();
  };
  EXPECT_EQ(again(), 0u);
  EXPECT_EQ(cast.texture().stale, 0u);
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
    const sandglass_cast_texture t = cast.texture();
    if (first == 0 && t.valid != 0) {
      first = units;
      EXPECT_EQ(t.directions, 8u);
      EXPECT_EQ(t.stale, 1u);
    }
    if (t.directions == 64) full = units;
  }
  EXPECT_GT(first, 0u);
  EXPECT_LT(4 * first, full);
  // Where the object only turns, no coarse texture comes between two good ones.
  cast.run();
  sandglass_cast_mesh moved = mesh;
  moved.world_from_mesh[12] = 0.1f;
  EXPECT_TRUE(cast.set_meshes(&moved, 1));
  while (cast.run(1) == 1) EXPECT_EQ(cast.texture().directions, 64u);
}

// The mean over a convex surface is 1; two parallel squares hide the lower one from all but the light at the side.
TEST(Cast, OpenIsTheShareThatTheSurfaceReceives) {
  const Shape convex = ball({0, 0.4f, 0}, 0.2f, 24);
  EXPECT_GT(lit({convex.mesh(1)}, {0, 1, 0}, 0).ambient().open, 0.97f);
  const Shape upper = square(1, 0.52f), lower = square(1, 0.5f);
  EXPECT_NEAR(lit({upper.mesh(), lower.mesh()}, {0, 1, 0}, 0).ambient().open, 0.52f, 0.03f);
}

TEST(Cast, LightBelowThePlaneThrowsNoShadow) {
  const Shape s = box({-0.1f, 0, -0.1f}, {0.1f, 0.4f, 0.1f});
  const sandglass::Cast cast = lit({s.mesh(1)}, towards(-30, 0), 0.3f);
  const std::vector<uint8_t> bytes = bytes_of(cast.texture());
  EXPECT_EQ(cast.texture().valid, 1u);
  EXPECT_EQ(std::count(bytes.begin(), bytes.end(), 0), static_cast<long>(bytes.size()));
  // A low one throws one that goes on beyond five heights, and ends softly there: in a fifth of that.
  const sandglass::Cast low = lit({s.mesh(1)}, towards(6, 0), 0.02f);
  const sandglass_cast_texture t = low.texture();
  const uint32_t fading = static_cast<uint32_t>(0.4 / static_cast<double>(t.along[0]) * t.texels);
  const uint8_t* row = t.bytes + t.texels / 2 * t.texels;
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
  EXPECT_EQ(cast.texture().left_out, 4u);  // the last two are degenerate, and draw nothing
}

TEST(Cast, AnyIndicesAndNumbersStayInTheBlock) {
  std::mt19937 engine(11);
  const auto random = [&engine] { return static_cast<uint32_t>(engine()); };
  sandglass_cast_desc desc = sandglass::cast_desc();
  desc.texels = 64;
  desc.directions = 32;
  desc.triangle_capacity = 300;
  uint64_t bytes = 0;
  ASSERT_EQ(sandglass_cast_bytes(&desc, &bytes, nullptr), SANDGLASS_OK);
  sandglass::test::GuardedBlock block(bytes);
  sandglass_cast* cast = nullptr;
  ASSERT_EQ(sandglass_cast_create(&desc, block.data(), bytes, &cast, nullptr), SANDGLASS_OK);
  const float odd[] = {0,    1e-30f, -1e-30f,       1,
                       -1,   1e3f,   1e5f,          -1e6f,
                       1e7f, 1e38f,  std::nanf(""), -std::numeric_limits<float>::infinity()};
  for (uint32_t round = 0; round < 200; ++round) {
    std::vector<float> positions(90);
    for (float& x : positions)
      x = random() % 4 != 0 ? static_cast<float>(random() % 2000) * 1e-3f - 1 : odd[random() % std::size(odd)];
    std::vector<uint32_t> indices(3 * (random() % 300 + 1));
    for (uint32_t& i : indices) i = random() % (round % 3 == 0 ? 40 : 30);
    sandglass_cast_mesh mesh = sandglass::cast_mesh();
    mesh.positions = positions.data();
    mesh.vertex_count = 30;
    mesh.indices = indices.data();
    mesh.triangle_count = static_cast<uint32_t>(indices.size() / 3);
    mesh.version = round;
    mesh.closed = random() % 2;
    mesh.is_real = random() % 4 == 0 ? 1 : 0;
    ASSERT_EQ(sandglass_cast_set_meshes(cast, &mesh, 1, nullptr), SANDGLASS_OK);
    const float light[3] = {static_cast<float>(random() % 200) - 100, static_cast<float>(random() % 100) - 5, 1};
    ASSERT_EQ(sandglass_cast_set_light(cast, light, static_cast<float>(random() % 150) * 0.01f, nullptr), SANDGLASS_OK);
    sandglass_cast_run(&cast, 1, random() % 3 == 0 ? random() % 40 : UINT32_MAX);
    ASSERT_TRUE(block.guards_intact());
  }
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
  plane("along", [](auto* p) { p->along[0] = 0, p->along[1] = 2; });
  plane("high", [](auto* p) { p->high[0] = p->low[0]; });
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
  for (uint32_t round = 0; round < 20; ++round) {
    const Shape s = ball({0, 0.4f, 0}, 0.3f, 24 + 2 * round);
    const sandglass_cast_mesh mesh = s.mesh(round % 2);
    EXPECT_TRUE(cast.set_meshes(&mesh, 1));
    cast.run(1 + round % 3);
    EXPECT_TRUE(cast.set_meshes(nullptr, 0));
  }
  cast.run();
  EXPECT_EQ(cast.texture().stale, 0u);
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
    if (casts[0].texture().completed > 2 && casts[1].texture().completed > 2 && casts[0].ambient().completed > 0 &&
        sands > 0)
      break;
  }
  EXPECT_LT(frames, 1500u);
  EXPECT_GT(casts[0].texture().completed + 2, casts[1].texture().completed);
}

}  // namespace
