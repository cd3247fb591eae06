// Casts in layers: each is what an ordinary cast on a plane at its height is, slid along the light.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/cast/cast_scene.h"
#include "tests/reason.h"

namespace {

using namespace sandglass::tests;

sandglass_cast_desc layered(uint32_t layers, uint32_t triangles = 4096) {
  sandglass_cast_desc desc = desc_for(triangles);
  desc.layers = layers;
  return desc;
}

sandglass_cast_plane as_high_as(float height, float lift = 0) {
  sandglass_cast_plane plane = sandglass::cast_plane();
  plane.height = height;
  plane.origin[1] = lift;
  return plane;
}

// One layer as a texture of its own.
sandglass_texture layer_of(sandglass_texture t, uint32_t layer) {
  t.bytes += layer * t.side * t.side;
  t.layers = 1;
  return t;
}

// Between the four texels about a place of the plane; `outside` beyond.
double sampled(const sandglass_texture& t, double x, double z, double outside) {
  const double u = (x - t.corner[0]) / t.along[0] * t.side - 0.5, v = (z - t.corner[2]) / t.across[2] * t.side - 0.5;
  if (!(u >= -0.5 && v >= -0.5 && u <= t.side - 0.5 && v <= t.side - 0.5)) return outside;
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const double a = std::floor(u) + i % 2, b = std::floor(v) + i / 2, last = t.side - 1;
    const auto at =
        static_cast<uint32_t>(std::clamp(b, 0.0, last)) * t.side + static_cast<uint32_t>(std::clamp(a, 0.0, last));
    sum += (1 - std::abs(u - a)) * (1 - std::abs(v - b)) * t.bytes[at] / 255.0;
  }
  return sum;
}

// Root mean square of a layer less what is expected, on a grid of places of the plane.
double off(const sandglass_texture& layer, const sandglass_cast_plane& plane, float height, double outside,
           const std::function<double(double x, double z)>& expected) {
  double sum = 0;
  constexpr int k_side = 80;
  for (int i = 0; i < k_side * k_side; ++i) {
    const auto along = [&](uint32_t axis, int step) {
      const double low = std::max(-0.8, static_cast<double>(plane.low[axis])),
                   high = std::min(0.8, static_cast<double>(plane.high[axis]));
      return low + (step + 0.5) / k_side * (high - low);
    };
    const double x = along(0, i % k_side), z = along(1, i / k_side);
    const double at = sampled(layer, x - height * layer.slide[0], z - height * layer.slide[2], outside);
    sum += (at - expected(x, z)) * (at - expected(x, z));
  }
  return std::sqrt(sum / k_side / k_side);
}

// Images of what lies above move by whole texels, so that but for what rounds otherwise the plane has the bytes of one
// layer: a direction counts 4 of 255. In a plane with an end, where images cannot move, too.
TEST(CastLayers, ThePlaneIsAsWithoutLayers) {
  const Mixed scene;
  for (const double elevation : {70.0, 35.0, 12.0}) {
    const sandglass::Cast one = lit(scene.meshes(), towards(elevation, 70), 0.4f),
                          four = lit(scene.meshes(), towards(elevation, 70), 0.4f, layered(4));
    EXPECT_EQ(one.texture().layers, 1u);
    EXPECT_EQ(four.texture().layers, 4u);
    EXPECT_NEAR(four.report().open, one.report().open, 0.01f);
    const Bytes light = light_of(four), sky = bytes_of(four.ambient());
    ASSERT_EQ(light.size(), 4 * light_of(one).size());
    EXPECT_LE(farthest({light.begin(), light.begin() + 128 * 128}, light_of(one)), 8) << elevation;
    EXPECT_LE(farthest({sky.begin(), sky.begin() + 64 * 64}, bytes_of(one.ambient())), 8) << elevation;
    EXPECT_GT(farthest({light.end() - 128 * 128, light.end()}, light_of(one)), 100) << elevation;
  }
}

// A light of almost no width: slid, a square's shadow lies in the same texels in each layer below it, and in none above.
TEST(CastLayers, ASmallLightsShadowSlidesOntoItself) {
  const Shape s = square(0.4f, 0.5f);
  const sandglass::Cast cast = lit({s.mesh()}, towards(45, 0), 1e-4f, layered(5), as_high_as(0.6f));
  const sandglass_texture t = cast.texture();
  EXPECT_NEAR(t.height, 0.6, 1e-6);
  EXPECT_NEAR(t.slide[0], 1, 1e-3);
  EXPECT_NEAR(t.slide[1], 1, 1e-6);
  EXPECT_NEAR(t.slide[2], 0, 1e-3);
  const double texel = std::max<double>(std::abs(t.along[0]), std::abs(t.across[2])) / t.side;
  for (uint32_t layer = 0; layer < 5; ++layer) {
    const sandglass_texture here = layer_of(t, layer);
    uint32_t inside = 0;
    for (uint32_t i = 0; i < t.side * t.side; ++i) {
      const auto p = place_of(t, i % t.side, i / t.side);
      const double to_edge = 0.2 - std::max(std::abs(p[0] + 0.5), std::abs(p[2]));
      if (std::abs(to_edge) < 8 * texel) continue;
      ASSERT_EQ(here.bytes[i], to_edge > 0 && layer < 4 ? 255 : 0) << layer << " " << p[0] << " " << p[2];
      inside += to_edge > 0;
    }
    EXPECT_GT(inside, 1000u);
  }
}

// As in PenumbraOfAnEdgeIsTheDisksShare: in a layer the edge is as much nearer. Control: the plane's height.
TEST(CastLayers, APenumbraNarrowsByTheLayersHeight) {
  const Shape s = square(4, 0.5f);
  sandglass_cast_plane plane = floor_between({-0.5f, -0.5f}, {0.5f, 0.5f});
  plane.height = 0.4f;
  sandglass_cast_mesh mesh = s.mesh();
  mesh.world_from_mesh[12] = -2;  // about the edge x = 0
  const double sine = std::sin(20 * k_degree);
  const sandglass::Cast cast = lit({mesh}, {0, 1, 0}, static_cast<float>(40 * k_degree), layered(3), plane);
  for (uint32_t layer = 0; layer < 3; ++layer) {
    const auto away = [&](double height) {
      return off(layer_of(cast.texture(), layer), plane, 0.2f * static_cast<float>(layer), 0, [=](double x, double) {
        const double slope = -x / (0.5 - height), chord = slope / std::sqrt(1 + slope * slope) / sine;
        if (std::abs(chord) >= 1) return chord > 0 ? 1.0 : 0.0;
        return 1 - (std::acos(chord) - chord * std::sqrt(1 - chord * chord)) / std::numbers::pi;
      });
    };
    EXPECT_LT(away(0.2 * layer), 0.02) << layer;
    if (layer > 0) {
      EXPECT_GT(away(0), 0.02) << layer;
    }
  }
}

// Each layer is the cast of a plane at its height, with what is real and what is cut, and where the object stands beyond
// the plane's end. Two drawings of one direction lie less than a texel apart, which is an error of a fiftieth at most on
// penumbrae; where something real leaves half of the light, one of twice that. Control: the layer below.
TEST(CastLayers, ALayerIsTheCastOfALiftedPlane) {
  const Mixed scene;
  for (const bool real : {false, true})
    for (const bool ends : {false, true})
      for (const double elevation : {60.0, 30.0}) {
        sandglass_cast_plane plane = as_high_as(0.33f);
        if (ends) {
          plane.low[0] = -0.5f;
          plane.high[0] = -0.08f;
          plane.high[1] = 0.3f;
        }
        std::vector<sandglass_cast_mesh> meshes = scene.meshes();
        if (!real) meshes.pop_back();
        const auto light = towards(elevation, 20);
        const sandglass::Cast cast = lit(meshes, light, 0.35f, layered(4), plane);
        for (uint32_t layer = 1; layer < 4; ++layer) {
          const float height = 0.11f * static_cast<float>(layer);
          sandglass_cast_plane high = plane;
          high.origin[1] = height;
          const sandglass::Cast lifted = lit(meshes, light, 0.35f, high);
          const auto within = [&](const sandglass_texture& all, const sandglass_texture& one, double outside) {
            const auto away = [&](uint32_t of) {
              return off(layer_of(all, of), plane, height, outside,
                         [&](double x, double z) { return sampled(one, x, z, outside); });
            };
            const double limit = real ? 0.04 : 0.02;
            EXPECT_LT(away(layer), limit) << real << ends << " " << elevation << " " << layer << " " << outside;
            if (outside > 0 && layer == 1) return;  // of the whole sky there is as little between the first two
            EXPECT_GT(away(layer - 1), limit) << real << ends << " " << elevation << " " << layer << " " << outside;
          };
          within(cast.texture(), lifted.texture(), 0);
          within(cast.ambient(), lifted.ambient(), 1);
        }
      }
}

TEST(CastLayers, AnyDivisionIntoUnitsGivesTheSameBytes) {
  const Mixed scene;
  sandglass_cast_plane end = as_high_as(0.25f);
  end.high[0] = 0.05f;
  for (const sandglass_cast_plane& plane : {as_high_as(0.25f), end}) {
    const auto cast_in = [&](uint32_t units) {
      sandglass::Cast cast = made(layered(5));
      EXPECT_TRUE(cast.set_plane(plane) && set_meshes(&cast, scene.meshes()) && cast.set_cells(uneven_cells()) &&
                  cast.set_light(towards(35, 70), 0.4f));
      while (cast.run(units) == units) continue;
      return both_of(cast);
    };
    const auto whole = cast_in(UINT32_MAX);
    for (const uint32_t units : {1u, 2u, 7u}) EXPECT_EQ(cast_in(units), whole) << units;
  }
}

// Coarse triangles, of which each layer cuts each, have room; and a fine mesh has.
TEST(CastLayers, WhatIsCutHasRoom) {
  const Shape coarse = box({-0.1f, 0, -0.1f}, {0.1f, 0.4f, 0.1f}), fine = ball({0, 0.15f, 0}, 0.14f, 60);
  for (const Shape* shape : {&coarse, &fine}) {
    const auto count = static_cast<uint32_t>(shape->indices.size() / 3);
    for (const uint32_t closed : {0u, 1u})
      EXPECT_EQ(
          lit({shape->mesh(closed)}, towards(50, 30), 0.3f, layered(8, count), as_high_as(0.3f)).report().left_out, 0u);
  }
}

TEST(CastLayers, AnotherHeightIsAnotherTexture) {
  const Shape s = box({-0.1f, 0, -0.1f}, {0.1f, 0.4f, 0.1f});
  for (const uint32_t layers : {1u, 3u}) {
    sandglass::Cast cast = lit({s.mesh(1)}, towards(50, 30), 0.3f, layered(layers), as_high_as(0.2f));
    const uint64_t before = cast.texture().version;
    EXPECT_TRUE(cast.set_plane(as_high_as(0.2f)));
    EXPECT_EQ(cast.run(), 0u);
    EXPECT_TRUE(cast.set_plane(as_high_as(0.3f)));
    cast.run();
    EXPECT_EQ(cast.texture().version, layers > 1 ? before + 1 : before);
  }
}

TEST(CastLayers, RefusesOtherNumbersAndHeights) {
  for (const uint32_t layers : {0u, 9u, UINT32_MAX})
    expect_refused("desc.layers", [&](const char** reason) {
      const sandglass_cast_desc desc = layered(layers);
      uint64_t bytes = 0;
      return sandglass_cast_bytes(&desc, &bytes, reason);
    });
  sandglass::Cast cast = made(layered(2));
  for (const float height : {0.0f, -1.0f, 101.0f, std::nanf(""), std::numeric_limits<float>::infinity()})
    expect_refused("plane.height", [&](const char** reason) {
      const sandglass_cast_plane plane = as_high_as(height);
      return sandglass_cast_set_plane(cast.get(), &plane, reason);
    });
}

}  // namespace
