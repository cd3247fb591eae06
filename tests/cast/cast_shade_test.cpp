// What is real and what is virtual: shade that is there already is not drawn twice.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/cast/cast_scene.h"

namespace {

using namespace sandglass::tests;

TEST(Cast, RealThingsDarkenVirtualPlanesOnly) {
  const Shape s = box({-0.2f, 0.3f, -0.2f}, {0.2f, 0.35f, 0.2f});
  const sandglass_cast_mesh real = as_real(s.mesh(1));
  const sandglass::Cast on_real = lit({real}, towards(60, 0), 0.2f);
  EXPECT_EQ(on_real.texture().valid, 1u);
  EXPECT_TRUE(are_all(0, light_of(on_real)));
  EXPECT_TRUE(are_all(255, bytes_of(on_real.ambient())));
  sandglass_cast_plane plane = sandglass::cast_plane();
  plane.is_virtual = 1;
  EXPECT_EQ(light_of(lit({real}, towards(60, 0), 0.2f, plane)), light_of(lit({s.mesh(1)}, towards(60, 0), 0.2f)));
}

// The floor under a real table that hides half of the light: what a virtual object above it hides of that half is dark
// already. With the light's disk hidden on one side of the edge by the table and wholly by the object, all that is left
// goes.
TEST(Cast, WhatIsRealMasksWhatIsVirtual) {
  const Shape table = square(4, 0.5f), object = square(6, 0.8f);
  const sandglass_cast_mesh real = as_real(table.mesh());
  const sandglass::Cast cast = lit({real, object.mesh()}, {0, 1, 0}, 0.35f, floor_between({1.5f, -0.5f}, {2.2f, 0.5f}));
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
  const sandglass_cast_mesh meshes[] = {s.mesh(1), as_real(wall.mesh(1))};
  std::array<float, SANDGLASS_LIGHT_CELLS> cells;
  cells.fill(0.2f / SANDGLASS_LIGHT_CELLS);
  const auto first = [&](uint32_t order, uint32_t units, bool away) {
    sandglass::Cast cast = made();
    for (uint32_t i = 0; i < 3; ++i) {
      const uint32_t step = (order + i) % 3;
      EXPECT_TRUE(step != 0 || cast.set_meshes(meshes, 2));
      EXPECT_TRUE(step != 1 || cast.set_light(towards(45, 90), 0.16f));
      EXPECT_TRUE(step != 2 || cast.set_cells(cells));
      cast.run(units);
    }
    while (cast.run(1) == 1) continue;
    if (away) {
      EXPECT_TRUE(cast.set_meshes(meshes, 1));
      cast.run();
    }
    return both_of(cast);
  };
  for (const bool away : {false, true}) {
    const auto wanted = first(0, 1000, away);
    for (uint32_t order = 0; order < 3; ++order)
      for (const uint32_t units : {0u, 5u, 1000u})
        EXPECT_EQ(first(order, units, away), wanted) << order << " " << units;
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

// What a box takes of a floor that a real wall, or a real table, shades already, in a light from +z and an even sky:
// the library's darkening, summed over the floor, is within 6 % of what rays say, whatever the light's share. The
// control does not tell the share, so each texture is divided by what is left of its own light alone.
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
    const sandglass_cast_mesh is_real = as_real(real.mesh(1));
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
    const sandglass::Cast plain = drawn(0);
    double worst = 0, control = 0;
    for (const double share : {0.3, 0.5, 0.7, 0.85, 0.95}) {
      const sandglass::Cast cast = drawn(share);
      double wanted = 0, known = 0, unknown = 0;
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
        known += 1 - share * (1 - sampled(cast.texture(), x, z, 0)) -
                 std::max(sampled(cast.ambient(), x, z, 1) - share, 0.0);
        unknown += share * sampled(plain.texture(), x, z, 0) + (1 - share) * (1 - sampled(plain.ambient(), x, z, 1));
      }
      worst = std::max(worst, std::abs(known / wanted - 1));
      control = std::max(control, std::abs(unknown / wanted - 1));
    }
    EXPECT_LE(worst, 0.06);
    EXPECT_GT(control, 0.15);
  }
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
      const sandglass_cast_mesh real = as_real(scan.mesh());
      const auto of = [&](const std::vector<sandglass_cast_mesh>& meshes, float bias) {
        sandglass_cast_plane plane = sandglass::cast_plane();
        plane.bias = bias;
        return both_of(lit(meshes, towards(55, 30), 0.3f, plane));
      };
      EXPECT_EQ(of({real, object.mesh(1)}, 0.03f), of({object.mesh(1)}, 0.03f)) << offset << " " << noise;
      if (offset < 0.01f) continue;
      EXPECT_TRUE(are_all(0, of({real, object.mesh(1)}, 0).first));  // the control
    }
}

}  // namespace
