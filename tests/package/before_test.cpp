// What the version before saved is read, and goes on to the same bits: a scene and a room. Its recording is replayed in
// tests/golden; baked files and the network of the tree are older still. The hashes are those that it printed.
#include <gtest/gtest.h>

#include <fstream>

#include "sandglass/sandglass.hpp"

namespace {

std::vector<char> saved(const std::string& name) {
  std::ifstream file(SANDGLASS_BEFORE "/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Before, ASavedSceneGoesOnAsItDid) {
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.granular.particle_capacity = 64;
  desc.granular.grain_capacity = 256;
  desc.granular.body_capacity = 1;
  desc.granular.body_particle_capacity = 27;
  sandglass::Scene scene;
  ASSERT_TRUE(scene.create(desc));
  const std::vector<char> bytes = saved("scene.saved");
  const sandglass::Status status = scene.restore(bytes.data(), bytes.size());
  ASSERT_TRUE(status) << status.reason;
  EXPECT_EQ(scene.hash(), 0x1d70401beb3f021eu);
  sandglass_collider colliders[2] = {sandglass::floor_at(0), sandglass::sphere(0.03f, 0, 0.03f, 0.03f)};
  for (int frame = 0; frame < 50; ++frame) {
    colliders[1].position[0] += 0.0005f;
    if (frame < 20) continue;  // then it was saved
    sandglass_frame_input input = sandglass::frame_input(0.016f, ~0ull >> 1);
    input.colliders = colliders;
    input.collider_count = 2;
    ASSERT_TRUE(scene.frame(input));
  }
  EXPECT_EQ(scene.hash(), 0xc69a653ec4a7ffbfu);
}

TEST(Before, ASavedRoomIsAsItWas) {
  sandglass::Room room;
  ASSERT_TRUE(room.create());
  const std::vector<char> bytes = saved("room.saved");
  const sandglass::Status status = room.restore(bytes.data(), bytes.size());
  ASSERT_TRUE(status) << status.reason;
  EXPECT_EQ(room.hash(), 0xfe98a0bc46be2b98u);
}

}  // namespace
