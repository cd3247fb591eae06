// Casts against what geometry says of simple shapes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/cast/cast_scene.h"

namespace {

using namespace sandglass::tests;

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

// At the edge of a wide sheet a light overhead is hidden as far as a chord cuts its disk, whose radius on the sheet,
// seen from the floor, is height * tan(half) to first order; exactly, the directions are even in sin.
TEST(Cast, PenumbraOfAnEdgeIsTheDisksShare) {
  const Shape s = square(4, 0.5f);
  for (const double half : {5.0, 10.0, 20.0}) {
    const sandglass_cast_plane plane = floor_between({1.5f, -0.5f}, {2.5f, 0.5f});  // about the edge x = 2
    const sandglass::Cast cast = lit({s.mesh()}, {0, 1, 0}, static_cast<float>(2 * half * k_degree), plane);
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

// Under an even sky a point below the middle of a square loses the square's form factor, four times that of a quarter
// above its corner: with a = half the side over the height, F = 4 / pi * a / sqrt(1 + a^2) * atan(a / sqrt(1 + a^2)).
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
  const sandglass::Cast cast = lit(meshes, turned(towards(50, 30)), 0.3f, wall);
  EXPECT_LE(farthest(light_of(floor), light_of(cast)), 8);  // a texel's edge may round otherwise
  EXPECT_LE(farthest(bytes_of(floor.ambient()), bytes_of(cast.ambient())), 8);
  const auto corner = turned({floor.texture().corner[0], floor.texture().corner[1], floor.texture().corner[2]});
  for (uint32_t i = 0; i < 3; ++i) EXPECT_NEAR(cast.texture().corner[i], corner[i], 1e-5);
}

// A box that reaches through the floor is the part above it.
TEST(Cast, OnlyWhatIsAboveThePlaneCasts) {
  const Shape whole = box({-0.1f, -0.3f, -0.2f}, {0.1f, 0.4f, 0.1f}),
              upper = box({-0.1f, 0, -0.2f}, {0.1f, 0.4f, 0.1f}), below = box({0.5f, -0.4f, 0.5f}, {0.7f, -0.1f, 0.7f});
  const auto of = [](const Shape& s) { return light_of(lit({s.mesh(1)}, towards(40, 200), 0.3f)); };
  EXPECT_EQ(of(whole), of(upper));
  const sandglass::Cast both = lit({upper.mesh(1), below.mesh(1)}, towards(40, 200), 0.3f);
  EXPECT_EQ(of(upper), light_of(both));
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
      const sandglass::Cast cut = lit({s.mesh(1)}, towards(45, 180), 0.1f, plane),
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
  const auto of = [](const sandglass_cast_mesh& m) { return light_of(lit({m}, towards(50, 30), 0.3f)); };
  const Bytes both_sides = of(s.mesh());
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
  Shape separate;
  for (const uint32_t i : s.indices)
    separate.positions.insert(separate.positions.end(),
                              {s.positions[3 * i], s.positions[3 * i + 1], s.positions[3 * i + 2], 0});
  sandglass_cast_mesh without = separate.mesh(1);
  without.indices = nullptr;
  without.stride = 16;
  without.vertex_count = static_cast<uint32_t>(s.indices.size());
  without.triangle_count = without.vertex_count / 3;
  EXPECT_EQ(of(without), of(s.mesh(1)));
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
  EXPECT_EQ(cast.texture().valid, 1u);
  EXPECT_TRUE(are_all(0, light_of(cast)));
  // A low one throws one that goes on beyond five heights, and ends softly there: in a fifth of that.
  const sandglass::Cast low = lit({s.mesh(1)}, towards(6, 0), 0.02f);
  const sandglass_texture t = low.texture();
  const uint32_t fading = static_cast<uint32_t>(0.4 / static_cast<double>(t.along[0]) * t.side);
  const uint8_t* row = t.bytes + t.side / 2 * t.side;
  EXPECT_EQ(row[0], 0);
  EXPECT_EQ(row[fading + 8], 255);
  for (uint32_t u = 0; u < fading; ++u) EXPECT_LE(std::abs(row[u + 1] - row[u]), 255 / 10) << u;
  // One that the horizon cuts does.
  const Bytes half = light_of(lit({s.mesh(1)}, towards(2, 0), 0.3f));
  EXPECT_GT(std::count(half.begin(), half.end(), 255), 100);
}

}  // namespace
