// Which meshes share a texture: what is near is in it, and what is far does not make it coarse.
#include <gtest/gtest.h>

#include <vector>

#include "tests/cast/cast_scene.h"

namespace {

using namespace sandglass::tests;

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
  const Shape joined[] = {together(mug, stray), together(stray, mug)};
  for (const std::vector<sandglass_cast_mesh>& meshes :
       {std::vector{mug.mesh(), second.mesh(1)}, std::vector{mug.mesh(), bird.mesh()}, std::vector{joined[0].mesh()},
        std::vector{joined[1].mesh()}}) {
    const sandglass::Cast cast = lit(meshes, light, 0.35f);
    EXPECT_GT(cast.report().too_far, 0u);
    EXPECT_EQ(both_of(cast), both_of(alone));
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
  const sandglass_cast_desc desc = desc_for(40000);
  const Shape many = ball({0, 0.2f, 0}, 0.2f, 64), more = ball({9, 0.2f, 0}, 0.2f, 64);
  const std::vector<sandglass_cast_mesh> mixed = {many.mesh(), more.mesh(1), more.mesh()};
  sandglass::Cast parts = made(desc);
  EXPECT_TRUE(parts.set_meshes(mixed.data(), 2) && parts.set_light(towards(50, 30), 0.2f));
  while (parts.run(1) == 1) continue;
  EXPECT_GT(parts.report().too_far, 16000u);
  EXPECT_EQ(light_of(parts), light_of(lit({many.mesh()}, towards(50, 30), 0.2f, desc)));
}

}  // namespace
