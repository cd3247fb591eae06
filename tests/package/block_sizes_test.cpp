// The scene's block, at every size from 0 to the size that is needed. If it is too small, creation fails and touches
// nothing. At the needed size it succeeds, and neither creation nor frames touch a byte outside.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "sandglass/sandglass.h"
#include "tests/guarded_block.h"

namespace {

using sandglass::test::GuardedBlock;

sandglass_scene_desc small_scene() {
  sandglass_scene_desc desc;
  sandglass_scene_desc_default(&desc);
  desc.granular.particle_capacity = 27;
  desc.granular.grain_capacity = 54;
  desc.granular.boundary_capacity = 5;
  desc.granular.collider_capacity = 2;
  return desc;
}

uint64_t need(const sandglass_scene_desc& desc) {
  uint64_t bytes = 0;
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_scene_bytes(&desc, &bytes, &reason), SANDGLASS_OK) << reason;
  return bytes;
}

TEST(BlockSizes, EverySizeBelowTheNeedIsRefusedAndNothingIsTouched) {
  const sandglass_scene_desc desc = small_scene();
  const uint64_t bytes = need(desc);
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
  const sandglass_scene_desc desc = small_scene();
  const uint64_t bytes = need(desc);
  GuardedBlock memory(bytes);
  sandglass_scene* scene = nullptr;
  const char* reason = nullptr;
  ASSERT_EQ(sandglass_scene_create(&desc, memory.data(), bytes, &scene, &reason), SANDGLASS_OK) << reason;
  ASSERT_TRUE(memory.guards_intact()) << "creation wrote outside the block";

  std::vector<float> particles, grains, boundary;
  for (int i = 0; i < 27; ++i)
    for (int cell : {i % 3, i / 3 % 3 + 1, i / 9}) particles.push_back(0.02f * static_cast<float>(cell));
  for (int i = 0; i < 54; ++i)
    for (int cell : {i % 3, i / 3 % 3 + 2, i / 9}) grains.push_back(0.01f * static_cast<float>(cell));
  for (int i = 0; i < 5; ++i)
    for (float x : {0.02f * static_cast<float>(i), -0.01f, 0.0f}) boundary.push_back(x);
  ASSERT_EQ(sandglass_granular_add(scene, particles.data(), nullptr, 27, grains.data(), nullptr, 54, &reason),
            SANDGLASS_OK)
      << reason;
  ASSERT_EQ(sandglass_granular_set_boundary(scene, boundary.data(), 5, &reason), SANDGLASS_OK) << reason;

  sandglass_collider colliders[2] = {};
  for (sandglass_collider& c : colliders) c.rotation[3] = 1.0f;
  colliders[1].shape = SANDGLASS_SHAPE_BOX;
  colliders[1].size[0] = colliders[1].size[1] = colliders[1].size[2] = 0.03f;
  GuardedBlock output(54 * sizeof(sandglass_grain));
  sandglass_frame_input input;
  sandglass_frame_input_default(&input);
  input.time_step = 1.0f / 60.0f;
  input.colliders = colliders;
  input.collider_count = 2;
  input.grains = output.data();
  input.grain_stride = sizeof(sandglass_grain);
  input.grain_capacity = 54;
  for (int frame = 0; frame < 120; ++frame)
    ASSERT_EQ(sandglass_scene_frame(scene, &input, nullptr, &reason), SANDGLASS_OK) << reason;

  EXPECT_TRUE(memory.guards_intact()) << "a frame wrote outside the block";
  EXPECT_TRUE(output.guards_intact()) << "a frame wrote outside the buffer for grains";
}

TEST(BlockSizes, RegionsLieInTheBlockInOrderAndAligned) {
  const sandglass_scene_desc desc = small_scene();
  const uint64_t bytes = need(desc);
  GuardedBlock memory(bytes);
  sandglass_scene* scene = nullptr;
  ASSERT_EQ(sandglass_scene_create(&desc, memory.data(), bytes, &scene, nullptr), SANDGLASS_OK);
  std::vector<sandglass_region> regions(sandglass_scene_regions(scene, nullptr, 0));
  ASSERT_FALSE(regions.empty());
  ASSERT_EQ(sandglass_scene_regions(scene, regions.data(), static_cast<uint32_t>(regions.size())), regions.size());
  uint64_t end = 0;
  for (const sandglass_region& region : regions) {
    EXPECT_STRNE(region.name, "");
    EXPECT_EQ(region.offset % SANDGLASS_BLOCK_ALIGNMENT, 0u) << region.name;
    EXPECT_GE(region.offset, end) << region.name;
    end = region.offset + region.bytes;
  }
  EXPECT_LE(end, bytes);
}

TEST(BlockSizes, MisalignedBlockIsRefusedAndUntouched) {
  const sandglass_scene_desc desc = small_scene();
  const uint64_t bytes = need(desc);
  GuardedBlock memory(bytes + SANDGLASS_BLOCK_ALIGNMENT);
  for (size_t offset = 1; offset < SANDGLASS_BLOCK_ALIGNMENT; ++offset) {
    sandglass_scene* scene = nullptr;
    EXPECT_EQ(sandglass_scene_create(&desc, memory.data() + offset, bytes, &scene, nullptr),
              SANDGLASS_ERROR_MEMORY_ALIGNMENT)
        << offset;
  }
  EXPECT_TRUE(memory.untouched());
}

TEST(BlockSizes, LeavingTheMaterialOutLeavesItsMemoryOut) {
  sandglass_scene_desc desc = small_scene();
  const uint64_t with = need(desc);
  desc.granular.particle_capacity = desc.granular.grain_capacity = desc.granular.boundary_capacity = 0;
  EXPECT_LT(need(desc), with / 2);
}

}  // namespace
