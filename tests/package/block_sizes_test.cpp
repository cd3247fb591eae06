// The scene's block, at every size from 0 to the size that is needed. If it is too small, creation fails and touches
// nothing. At the needed size it succeeds, and neither creation nor frames touch a byte outside.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/guarded_block.h"

namespace {

using sandglass::test::GuardedBlock;

sandglass_scene_desc small_scene() {
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.granular.particle_capacity = 27;
  desc.granular.grain_capacity = 54;
  desc.granular.boundary_capacity = 5;
  desc.granular.collider_capacity = 2;
  // Asking the CPU takes tens of microseconds in a virtual machine, and this makes half a million scenes.
  desc.isa = SANDGLASS_ISA_SCALAR;
  return desc;
}

TEST(BlockSizes, EverySizeBelowTheNeedIsRefusedAndNothingIsTouched) {
  const sandglass_scene_desc desc = small_scene();
  const uint64_t bytes = sandglass::Scene::bytes(desc);
  GuardedBlock memory(bytes);
  sandglass_scene* const unset = reinterpret_cast<sandglass_scene*>(memory.data() + 1);
  for (uint64_t size = 0; size < bytes; ++size) {
    sandglass_scene* scene = unset;
    const char* reason = nullptr;
    ASSERT_EQ(sandglass_scene_create(&desc, memory.data(), size, &scene, &reason), SANDGLASS_ERROR_MEMORY_TOO_SMALL)
        << size;
    ASSERT_NE(reason, nullptr);
    ASSERT_EQ(scene, unset) << "a function that fails has changed nothing";
    // A touched byte stays touched, so looking at all bytes now and then, and at the end, finds every fault.
    if (size % 4096 == 0) {
      ASSERT_TRUE(memory.untouched()) << size;
    }
  }
  EXPECT_TRUE(memory.untouched());
}

TEST(BlockSizes, AtTheNeedItSucceedsAndStaysInside) {
  GuardedBlock memory(sandglass::Scene::bytes(small_scene()));
  sandglass::Scene scene;
  ASSERT_TRUE(scene.create_in(small_scene(), memory.data(), memory.bytes()));
  ASSERT_TRUE(memory.guards_intact()) << "creation wrote outside the block";

  std::vector<float> particles, grains, boundary;
  for (int i = 0; i < 27; ++i)
    for (int cell : {i % 3, i / 3 % 3 + 1, i / 9}) particles.push_back(0.02f * static_cast<float>(cell));
  for (int i = 0; i < 54; ++i)
    for (int cell : {i % 3, i / 3 % 3 + 2, i / 9}) grains.push_back(0.01f * static_cast<float>(cell));
  for (int i = 0; i < 5; ++i)
    for (float x : {0.02f * static_cast<float>(i), -0.01f, 0.0f}) boundary.push_back(x);
  ASSERT_TRUE(scene.add(particles, grains));
  ASSERT_TRUE(scene.set_boundary(boundary));
  const sandglass_collider colliders[2] = {sandglass::floor_at(0.0f),
                                           sandglass::box(0.0f, 0.0f, 0.0f, 0.03f, 0.03f, 0.03f)};
  GuardedBlock output(54 * sizeof(sandglass_grain));
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60.0f;
  input.colliders = colliders;
  input.collider_count = 2;
  input.grains = reinterpret_cast<sandglass_grain*>(output.data());
  input.grain_capacity = 54;
  for (int frame = 0; frame < 120; ++frame) ASSERT_TRUE(scene.frame(input));

  EXPECT_TRUE(memory.guards_intact()) << "a frame wrote outside the block";
  EXPECT_TRUE(output.guards_intact()) << "a frame wrote outside the buffer for grains";
}

TEST(BlockSizes, RegionsLieInTheBlockInOrderAndAligned) {
  sandglass_scene_desc desc = small_scene();  // with all that a scene can have
  desc.granular.body_capacity = desc.granular.body_particle_capacity = 1;
  desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;
  sandglass::Scene scene;
  ASSERT_TRUE(scene.create(desc));
  std::vector<sandglass_region> regions(sandglass_scene_regions(scene.get(), nullptr, 0));
  ASSERT_FALSE(regions.empty());
  ASSERT_EQ(sandglass_scene_regions(scene.get(), regions.data(), static_cast<uint32_t>(regions.size())),
            regions.size());
  uint64_t end = 0;
  for (const sandglass_region& region : regions) {
    EXPECT_STRNE(region.name, "");
    EXPECT_EQ(region.offset % SANDGLASS_BLOCK_ALIGNMENT, 0u) << region.name;
    EXPECT_GE(region.offset, end) << region.name;
    end = region.offset + region.bytes;
  }
  EXPECT_EQ(end, sandglass::Scene::bytes(desc)) << "regions are left out: raise k_region_capacity";
}

TEST(BlockSizes, LeavingTheMaterialOutLeavesItsMemoryOut) {
  sandglass_scene_desc desc = small_scene();
  const uint64_t with = sandglass::Scene::bytes(desc);
  desc.granular.particle_capacity = desc.granular.grain_capacity = desc.granular.boundary_capacity = 0;
  EXPECT_LT(sandglass::Scene::bytes(desc), with / 2);
}

}  // namespace
