// One hash of a session on every compiler and instruction set, by set_image and in frames of a scene.
#include <gtest/gtest.h>

#include <vector>

#include "runtime/math/hash.h"
#include "runtime/math/random.h"
#include "sandglass/sandglass.hpp"

namespace sandglass {
namespace {

constexpr int k_images = 12;
// Of the room and of its answers, known and shown, after the session below. A change that alters it on purpose says so.
constexpr uint64_t k_golden = 0x696d59c0e53f1132ull;

// Bytes of any kind: no libm has a part in them.
std::vector<uint8_t> picture(uint64_t seed) {
  Random random = random_stream(seed, 5);
  std::vector<uint8_t> bytes(64 * 48 * 3 / 2);
  for (size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<uint8_t>(64 + random.below(seed % 3 == 0 ? 192 : 100));
  return bytes;
}

sandglass_camera_image image_of(const std::vector<uint8_t>& bytes, int i) {
  sandglass_camera_image image;
  sandglass_camera_image_default(&image);
  image.format = SANDGLASS_CAMERA_NV12;
  image.width = 64;
  image.height = 48;
  image.planes[0] = bytes.data();
  image.planes[1] = bytes.data() + 64 * 48;
  image.strides[0] = image.strides[1] = 64;
  image.focal_x = 50.0f;
  image.focal_y = 51.0f;
  image.centre_x = 31.0f;
  image.centre_y = 24.0f;
  image.orientation[0] = 0.125f * static_cast<float>(i % 3 - 1);
  image.orientation[1] = 0.25f * static_cast<float>(i % 7 - 3);
  image.orientation[3] = 1.0f;
  image.position[0] = 0.0625f * static_cast<float>(i);
  image.position[2] = -0.125f * static_cast<float>(i % 4);
  image.exposure = i < 2 || i == 7 ? 0.0f : 0.5f;  // told late, and missing once
  image.timestamp_ns = 1 + 150'000'000ull * static_cast<uint64_t>(i);
  return image;
}

uint64_t hash_of(const sandglass_room* room) {
  sandglass_room_light light = {};
  light.struct_size = sizeof light;
  const sandglass_room_place place = {sizeof place, {0.5f, -1.0f, 0.25f}, nullptr, nullptr, nullptr, nullptr, nullptr};
  EXPECT_EQ(sandglass_room_get(room, &place, &light, nullptr), SANDGLASS_OK);
  sandglass_room_light shown = light;
  for (int i = 0; i < 64; ++i) shown.cells[i] = shown.ambient_cells[i] = 1.0f / 64;
  shown.main_share = 0;
  sandglass_room_fade(&shown, &light, 0.1f);
  const uint64_t hash = hash_with(sandglass_room_hash(room), hash_bytes(&light, sizeof light));
  return hash_with(hash, hash_bytes(&shown, sizeof shown));
}

TEST(RoomHash, IsOneOnEveryMachineAndInFramesOfAScene) {
  for (const bool in_frames : {false, true}) {
    cpp::Room room;
    cpp::Scene scene;
    ASSERT_TRUE(room.create());
    ASSERT_TRUE(scene.create(cpp::scene_desc()));
    for (int i = 0; i < k_images; ++i) {
      const std::vector<uint8_t> bytes = picture(static_cast<uint64_t>(i));
      const sandglass_camera_image image = image_of(bytes, i);
      if (!in_frames) {
        ASSERT_EQ(sandglass_room_set_image(room.get(), &image, nullptr, nullptr), SANDGLASS_OK);
        continue;
      }
      sandglass_frame_input input = cpp::frame_input();
      input.room = room.get();
      input.camera = &image;
      input.time_step = 1.0f / 60;
      sandglass_frame_report report = cpp::frame_report();
      ASSERT_TRUE(scene.frame(input, &report));
      // One unit looks at 64 of 512 parts; an image is compared, and then gathered where it teaches something.
      EXPECT_TRUE(report.stages[SANDGLASS_STAGE_LIGHT].units == 8 || report.stages[SANDGLASS_STAGE_LIGHT].units == 16);
    }
    EXPECT_EQ(hash_of(room.get()), k_golden) << std::hex << hash_of(room.get());
  }
}

}  // namespace
}  // namespace sandglass
