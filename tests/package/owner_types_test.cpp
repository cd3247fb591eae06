// sandglass.hpp: the owner types do what the C API does, own the block they allocate and leave a lent one alone.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/package/filled_struct.h"

namespace {

const std::vector<float> k_two_particles = {0.0f, 0.05f, 0.0f, 0.05f, 0.05f, 0.0f};

sandglass_scene_desc small_scene() {
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.granular.particle_capacity = 2;
  desc.granular.collider_capacity = 1;
  return desc;
}

sandglass::Scene made() {
  sandglass::Scene scene;
  EXPECT_TRUE(scene.create(small_scene()));
  return scene;
}

// Half a second of sand on a floor; returns the scene's hash.
uint64_t fall(sandglass::Scene& scene) {
  EXPECT_TRUE(scene.add(k_two_particles));
  const sandglass_collider floor = sandglass::floor_at(0.0f);
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60.0f;
  input.colliders = &floor;
  input.collider_count = 1;
  sandglass_frame_report report = sandglass::frame_report();
  for (int frame = 0; frame < 30; ++frame) EXPECT_TRUE(scene.frame(input, &report));
  EXPECT_EQ(report.sand.particles, 2u);
  return scene.hash();
}

// Runs frames of the same scene from its beginning and fills the reports of apps with older and newer headers. Then
// tests the report's plan, which the library reads, and the levels, which the library owns.
TEST(OwnerTypes, AReportIsFilledWithinItsSizeAndItsPlanReadWhole) {
  sandglass::Scene scene = made();
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60.0f;
  const auto begin = [&] {
    sandglass_scene_reset(scene.get());
    EXPECT_TRUE(scene.add(k_two_particles));
  };
  sandglass::tests::expect_filled_within_its_size<sandglass_frame_report>(
      [&](sandglass_frame_report* report) {
        begin();
        return sandglass_scene_frame(scene.get(), &input, report, nullptr) == SANDGLASS_OK;
      },
      true);
  begin();
  const uint64_t before = scene.hash();
  sandglass_frame_report report = {};
  EXPECT_EQ(sandglass_scene_frame(scene.get(), &input, &report, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(scene.hash(), before);  // refused before anything moved
  report.struct_size = sizeof report;
  ASSERT_EQ(sandglass_scene_frame(scene.get(), &input, &report, nullptr), SANDGLASS_OK);
  EXPECT_EQ(report.plan.struct_size, sizeof report.plan);
  sandglass_plan plan = report.plan;
  input.plan = &plan;
  begin();
  for (const uint32_t size : {0u, 8u, static_cast<uint32_t>(sizeof plan) - 4, static_cast<uint32_t>(sizeof plan) + 4}) {
    plan.struct_size = size;
    EXPECT_EQ(sandglass_scene_frame(scene.get(), &input, &report, nullptr), SANDGLASS_ERROR_REPLAY) << size;
  }
  plan.struct_size = sizeof plan;
  EXPECT_EQ(sandglass_scene_frame(scene.get(), &input, &report, nullptr), SANDGLASS_OK);
  for (uint32_t level = 0; level < SANDGLASS_LEVEL_COUNT; ++level)
    EXPECT_EQ(sandglass_level_describe(level)->struct_size, sizeof(sandglass_level)) << level;
}

TEST(OwnerTypes, OwnedAndLentBlocksGiveTheSameBits) {
  sandglass::Scene owned = made(), lent;
  const uint64_t bytes = sandglass::Scene::bytes(small_scene());
  const sandglass::Block block = sandglass::allocate_block(bytes);
  ASSERT_TRUE(lent.create_in(small_scene(), block.get(), bytes));
  EXPECT_EQ(fall(owned), fall(lent));
}

TEST(OwnerTypes, AMovedSceneGoesOnWhereItWas) {
  sandglass::Scene first = made();
  sandglass_scene* const handle = first.get();
  sandglass::Scene second(std::move(first));
  EXPECT_FALSE(first);  // NOLINT(bugprone-use-after-move): that it is empty is the claim
  EXPECT_EQ(second.get(), handle);
  fall(second);
}

TEST(OwnerTypes, AFailedCreateKeepsTheSceneThatWasThere) {
  sandglass::Scene scene = made();
  sandglass_scene* const handle = scene.get();
  sandglass_scene_desc bad = small_scene();
  bad.granular.particle_radius = -1.0f;
  const sandglass::Status status = scene.create(bad);
  EXPECT_EQ(status.code, SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(status.reason, nullptr);
  EXPECT_EQ(sandglass::Scene::bytes(bad), 0u);
  EXPECT_EQ(scene.get(), handle);
}

TEST(OwnerTypes, PointsComeFromAnyContiguousFloats) {
  const std::array<float, 7> floats{};
  EXPECT_EQ(sandglass::Points(floats).count, 2u) << "the trailing incomplete point is left out";
  EXPECT_EQ(sandglass::Points(k_two_particles).xyz, k_two_particles.data());
  EXPECT_EQ(sandglass::Points().count, 0u);
}

TEST(OwnerTypes, AMovedPileShadowKeepsItsTexture) {
  sandglass::PileShadow first;
  ASSERT_TRUE(first.create(sandglass::pile_shadow_desc()));
  ASSERT_TRUE(first.set_light({0.5f, 1.0f, 0.0f}));
  EXPECT_GT(first.run(k_two_particles, 0.01f), 0u);
  const uint64_t hash = first.hash();
  const sandglass::PileShadow second = std::move(first);
  EXPECT_EQ(second.texture().valid, 1u);
  EXPECT_EQ(second.hash(), hash);
  EXPECT_EQ(first.texture().valid, 0u);  // NOLINT(bugprone-use-after-move): that it is empty is the claim
  EXPECT_EQ(first.run(k_two_particles, 0.01f), 0u);
}

// An owner type that nothing was created in follows the rule for NULL.
TEST(OwnerTypes, EmptyOnesRefuseOrDoNothing) {
  sandglass::Scene scene;
  sandglass::Estimator light;
  sandglass::Shadow shadow;
  EXPECT_EQ(scene.add(k_two_particles).code, SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(scene.frame(sandglass::frame_input()).code, SANDGLASS_ERROR_INVALID_ARGUMENT);
  std::vector<std::byte> saved;
  EXPECT_FALSE(scene.save(&saved));
  EXPECT_TRUE(saved.empty());
  scene.reset();
  light.reset();
  EXPECT_EQ(scene.hash(), 0u);
  EXPECT_EQ(light.light().valid, 0u);
  EXPECT_EQ(shadow.run(), 0u);
  EXPECT_EQ(shadow.texture().valid, 0u);
  EXPECT_FALSE(shadow.set_light({0, 1, 0}));
}

}  // namespace
