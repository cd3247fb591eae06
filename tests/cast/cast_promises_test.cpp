// The promises of cast.h: the same bytes in any units, what is refused, and its place in the frame.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/cast/cast_scene.h"
#include "tests/reason.h"

namespace {

using namespace sandglass::tests;

TEST(Cast, AnyDivisionIntoUnitsGivesTheSameBytes) {
  const Mixed scene;
  const std::vector<sandglass_cast_mesh> meshes = scene.meshes();
  const sandglass::Cast whole = lit(meshes, towards(35, 70), 0.4f);
  sandglass::Cast parts = made();
  EXPECT_TRUE(set_meshes(&parts, meshes));
  EXPECT_TRUE(parts.set_light(towards(35, 70), 0.4f));
  uint32_t units = 0;
  while (parts.run(1) == 1) {
    ++units;
    EXPECT_TRUE(set_meshes(&parts, meshes));  // as every frame does
    EXPECT_TRUE(parts.set_light(towards(35, 70), 0.4f));
  }
  EXPECT_GT(units, 20u);
  EXPECT_EQ(both_of(whole), both_of(parts));
}

TEST(Cast, BadTrianglesAreLeftOutAndCounted) {
  Shape s = box({-0.1f, 0, -0.1f}, {0.1f, 0.4f, 0.1f});
  const Bytes clean = light_of(lit({s.mesh(1)}, towards(50, 30), 0.3f));
  s.positions.insert(s.positions.end(),
                     {std::nanf(""), 0.1f, 0, std::numeric_limits<float>::infinity(), 0, 0, 3e8f, 1, 1});
  s.indices.insert(s.indices.end(), {0, 1, 8, 0, 9, 1, 10, 1, 2, 0, 1, 4000000000u, 3, 3, 5, 6, 6, 6});
  const sandglass::Cast cast = lit({s.mesh(1)}, towards(50, 30), 0.3f);
  EXPECT_EQ(light_of(cast), clean);
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
  const sandglass_cast_desc desc = desc_for(40000);
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
  EXPECT_TRUE(are_all(0, light_of(cast)));
}

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
      EXPECT_TRUE(set_meshes(&cast, meshes));
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
