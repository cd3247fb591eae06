// What changes between frames, and within a texture, is followed; what does not costs nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/cast/cast_scene.h"

namespace {

using namespace sandglass::tests;

// The work units that a cast takes on this plane.
uint32_t units_on(const sandglass_cast_plane& plane, sandglass::Cast* cast) {
  EXPECT_TRUE(cast->set_plane(plane));
  return cast->run();
}

TEST(Cast, WhatIsAsItWasCostsNothing) {
  const Mixed scene;
  std::vector<sandglass_cast_mesh> meshes = scene.meshes();
  sandglass::Cast cast = lit(meshes, towards(50, 30), 0.3f);
  const double texel = std::min<double>(cast.texture().along[0], cast.texture().across[2]) / cast.texture().side;
  const auto again = [&] {
    EXPECT_TRUE(set_meshes(&cast, meshes));
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
  EXPECT_EQ(units_on(plane, &cast), 0u);
  // A tracker's plane grows; one that cuts the shadow does count.
  for (float& x : plane.high) x = 3;
  EXPECT_EQ(units_on(plane, &cast), 0u);
  plane.high[0] = 0.2f;
  EXPECT_GT(units_on(plane, &cast), 0u);
  plane.origin[1] = 0.01f;
  EXPECT_GT(units_on(plane, &cast), 0u);
}

// A tracker shifts a plane's origin within it; its ends stay in the world, near the shadow or far.
TEST(Cast, AnOriginThatShiftsWithinThePlaneCostsNothing) {
  const Shape s = box({-0.05f, 0, -0.03f}, {0.05f, 0.12f, 0.03f});
  const sandglass_cast_mesh mesh = s.mesh(1);
  const float tilt = std::sqrt(0.5f);
  for (const float half : {0.07f, 5000.0f}) {
    sandglass_cast_plane plane = floor_between({-half, -half}, {half, half});
    plane.normal[0] = plane.normal[1] = plane.along[0] = tilt;
    plane.along[1] = -tilt;
    const sandglass_cast_plane first = plane;
    sandglass::Cast cast = lit({mesh}, towards(50, 30), 0.2f, plane);
    const Bytes bytes = light_of(cast);
    for (uint32_t frame = 1; frame <= 60; ++frame) {
      const float shift[2] = {0.037f * static_cast<float>(frame % 40), -0.011f * static_cast<float>(frame)};
      plane.origin[0] = tilt * shift[0];
      plane.origin[1] = -tilt * shift[0];
      plane.origin[2] = shift[1];
      for (uint32_t axis = 0; axis < 2; ++axis) {
        plane.low[axis] = first.low[axis] - shift[axis];
        plane.high[axis] = first.high[axis] - shift[axis];
      }
      EXPECT_EQ(units_on(plane, &cast), 0u) << frame;
    }
    // The control: what leaves the plane, and ends that shift with the origin where they cut.
    plane.origin[0] += tilt * 0.01f;
    plane.origin[1] += tilt * 0.01f;
    EXPECT_GT(units_on(plane, &cast), 0u);
    EXPECT_NE(light_of(cast), bytes);
    plane.high[0] += 0.01f;
    EXPECT_EQ(units_on(plane, &cast) > 0, half < 1);
  }
}

TEST(Cast, ManyTrianglesGetAFirstTextureAhead) {
  const sandglass_cast_desc desc = desc_for(20000);
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
  const sandglass_cast_desc desc = desc_for(20000);
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
    EXPECT_EQ(light_of(cast), light_of(lit({mesh}, towards(50, 30), 0, desc)));
    return completed;
  };
  const uint32_t steady = textures(false, 1, 0);
  EXPECT_GE(steady, 4u);
  EXPECT_EQ(textures(true, 1, 0), steady);
  EXPECT_GE(textures(true, 0, 0), steady);
  EXPECT_GE(textures(true, 1, 50), steady / 2);  // a scan, which grows and is thinned
}

// A tracker tells a plane, and an app a pose, once: whenever that is, the texture that stays is of the last ones.
TEST(Cast, WhatChangesDuringATextureIsFollowed) {
  const Shape s = box({-0.05f, 0, -0.05f}, {0.05f, 0.3f, 0.05f});
  const sandglass_cast_plane small = floor_between({-0.1f, -0.1f}, {0.1f, 0.1f}),
                             large = floor_between({-1, -1}, {1, 1});
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
    const sandglass::Cast wanted = lit({then.mesh}, towards(45, 0), 0.1f, then.plane);
    uint32_t units = 0, ran = 0;
    for (;; ++units) {
      sandglass::Cast cast = made();
      EXPECT_TRUE(cast.set_plane(first.plane) && cast.set_meshes(&first.mesh, 1) &&
                  cast.set_light(towards(45, 0), 0.1f));
      ran = cast.run(units);
      EXPECT_TRUE(cast.set_plane(then.plane) && cast.set_meshes(&then.mesh, 1));
      cast.run();
      EXPECT_EQ(both_of(cast), both_of(wanted)) << units;
      if (ran < units) break;
    }
    EXPECT_GT(units, 20u);
  }
}

}  // namespace
