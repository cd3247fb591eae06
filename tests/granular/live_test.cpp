// Saving, restoring and moving a running scene.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "runtime/core/hash.h"
#include "runtime/core/random.h"
#include "tests/granular/granular_scene.h"

namespace {

constexpr float k_radius = 0.01f, k_frame = 0.02f;

// A clock that advances by a microsecond a reading. A budget then means a number of work units.
uint64_t counting_clock(void* user) { return *static_cast<uint64_t*>(user) += 1000; }
uint64_t g_time = 0;

sandglass_scene_desc everything(uint32_t particles = 700, uint32_t grains = 4000) {
  sandglass_scene_desc desc = description(particles, grains, 64);
  desc.granular.body_capacity = 2;
  desc.granular.body_particle_capacity = 40;
  desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;
  desc.clock = {counting_clock, &g_time};
  desc.unit_items = 64;
  return desc;
}

// Sand, grains, a body, a boundary, an emitter and a sink.
struct World {
  explicit World(const sandglass_scene_desc& desc = everything()) : scene(desc) {}

  void fill() {
    const std::vector<float> block = lattice(7, 5, 7, 2.02f * k_radius, k_radius);
    std::vector<float> grains, body = lattice(3, 3, 3, 2.01f * k_radius, k_radius), wall;
    for (size_t i = 0; i < block.size(); ++i) grains.push_back(block[i] + 0.004f);
    for (size_t i = 0; i < body.size(); i += 3) body[i] += 0.05f, body[i + 1] += 0.15f, body[i + 2] += 0.05f;
    for (int i = 0; i < 32; ++i) wall.insert(wall.end(), {-0.03f, k_radius, 0.015f * static_cast<float>(i) - 0.1f});
    scene.add(block, {}, grains);
    scene.add_body(body, 2.0f);
    const char* reason = nullptr;
    ASSERT_EQ(sandglass_granular_set_boundary(scene.scene, wall.data(), 32, &reason), SANDGLASS_OK) << reason;
  }

  sandglass_frame_report frame(uint64_t budget = ~0ull >> 1) {
    const sandglass_collider floor = half_space(0.0f), sink = half_space(-0.5f);
    sandglass_emitter emitter = {};
    emitter.position[0] = -0.2f, emitter.position[1] = 0.4f;
    emitter.rotation[3] = 1.0f;
    emitter.radius = 0.025f, emitter.speed = 0.8f, emitter.grains_per_particle = 4;
    sandglass_frame_input input = scene.input(k_frame, budget);
    input.grains = nullptr, input.grain_capacity = 0;
    input.colliders = &floor, input.collider_count = 1;
    input.emitters = &emitter, input.emitter_count = 1;
    input.sinks = &sink, input.sink_count = 1;
    return scene.run(input);
  }

  std::vector<uint8_t> save() {
    const std::vector<uint8_t> data = scene.save();
    EXPECT_EQ(data.size(), sandglass_scene_save_bytes(scene.scene));
    return data;
  }

  sandglass_status restore(const std::vector<uint8_t>& data) {
    const char* reason = nullptr;
    const sandglass_status status = scene.restore(data, &reason);
    EXPECT_EQ(reason == nullptr, status == SANDGLASS_OK);
    return status;
  }

  GranularScene scene;
};

TEST(Save, TheSavedSceneAndTheRestoredOneRunOnAlike) {
  for (const int frames : {0, 40}) {
    // A budget of twenty units or fewer leaves the scene in the middle of a sub-step and of a sweep.
    for (const int starved : {0, 1, 7}) {
      World live;
      live.fill();
      for (int i = 0; i < frames; ++i) live.frame();
      for (int i = 0; i < starved; ++i) live.frame(20'000);
      const std::vector<uint8_t> data = live.save();
      World other;
      ASSERT_EQ(other.restore(data), SANDGLASS_OK);
      EXPECT_EQ(other.scene.hash(), live.scene.hash());
      for (int i = 0; i < 12; ++i) {
        const sandglass_frame_report a = live.frame(), b = other.frame();
        ASSERT_EQ(a.simulated_time, b.simulated_time);
        ASSERT_EQ(a.awake, b.awake);
        ASSERT_EQ(a.emitted_grains, b.emitted_grains);
      }
      EXPECT_EQ(other.scene.hash(), live.scene.hash()) << frames << " frames, " << starved << " starved";
      const sandglass_body_pose a = sandglass_granular_body_pose(live.scene.scene, 0),
                                b = sandglass_granular_body_pose(other.scene.scene, 0);
      EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
    }
  }
}

TEST(Save, ALongRunWithoutGrainsIsRestored) {
  sandglass_scene_desc desc = description(2);
  desc.granular.sleep_after = 0.0f;
  GranularScene live(desc), other(desc);
  live.add({0.0f, 0.5f, 0.0f, 0.1f, 0.5f, 0.0f});
  live.add_floor();
  for (int i = 0; i < 600; ++i) live.frame(0.02f);
  ASSERT_EQ(other.restore(live.save()), SANDGLASS_OK);
  EXPECT_EQ(other.hash(), live.hash());
}

TEST(Save, RestoresOnAnotherInstructionSetAndIntoALargerScene) {
  World live;
  live.fill();
  for (int i = 0; i < 10; ++i) live.frame();
  const std::vector<uint8_t> data = live.save();
  for (int i = 0; i < 10; ++i) live.frame();
  sandglass_scene_desc desc = everything(2000, 9000);
  desc.isa = SANDGLASS_ISA_SCALAR;
  World other(desc);
  ASSERT_EQ(other.restore(data), SANDGLASS_OK);
  for (int i = 0; i < 10; ++i) other.frame();
  // Grids depend on capacities, and the order of sums depends on grids. So the material is equal, but not every bit.
  EXPECT_EQ(other.frame().particles, live.frame().particles);
}

TEST(Restore, EveryTruncationAndEveryFlippedByteIsAnErrorAndChangesNothing) {
  World live, other;
  live.scene.add({0.0f, 0.1f, 0.0f, 0.05f, 0.1f, 0.0f}, {}, {0.0f, 0.1f, 0.0f});
  live.frame();
  std::vector<uint8_t> data = live.save();
  other.fill();
  other.frame();
  const uint64_t before = other.scene.hash();
  for (size_t length = 0; length < data.size(); ++length) {
    ASSERT_NE(other.restore({data.begin(), data.begin() + static_cast<std::ptrdiff_t>(length)}), SANDGLASS_OK)
        << length;
  }
  for (size_t at = 0; at < data.size(); ++at) {
    data[at] ^= 0x41;
    ASSERT_NE(other.restore(data), SANDGLASS_OK) << at;
    data[at] ^= 0x41;
  }
  EXPECT_EQ(other.scene.hash(), before);
  EXPECT_EQ(other.restore(data), SANDGLASS_OK);
}

// Wrong bytes with a right checksum are either refused or give a scene that can run.
TEST(Restore, BytesThatLieNeverBreakAnything) {
  World live, other;
  live.fill();
  for (int i = 0; i < 5; ++i) live.frame();
  const std::vector<uint8_t> data = live.save();
  sandglass::Random random{1};
  uint32_t refused = 0;
  for (int round = 0; round < 1000; ++round) {
    std::vector<uint8_t> forged = data;
    for (int flips = 0; flips < 1 + round % 3; ++flips) {
      const size_t at = 64 + random.below(static_cast<uint32_t>(forged.size() - 64));
      forged[at] = static_cast<uint8_t>(random.below(256));
    }
    const uint64_t sum = sandglass::hash_bytes(&forged[64], forged.size() - 64);
    std::memcpy(&forged[16], &sum, sizeof sum);
    if (other.restore(forged) != SANDGLASS_OK) {
      ++refused;
    } else if (round % 20 == 0) {
      for (int i = 0; i < 2; ++i) other.frame();
    }
  }
  EXPECT_GT(refused, 30u);
  EXPECT_EQ(other.restore(data), SANDGLASS_OK);
}

TEST(Restore, NeedsTheSameRadiusAndRoom) {
  World live;
  live.fill();
  const std::vector<uint8_t> data = live.save();
  World small(everything(100, 100));
  EXPECT_EQ(small.restore(data), SANDGLASS_ERROR_CAPACITY);
  sandglass_scene_desc desc = everything();
  desc.granular.particle_radius = 0.02f;
  World coarse(desc);
  EXPECT_EQ(coarse.restore(data), SANDGLASS_ERROR_INVALID_ARGUMENT);
  uint64_t written = 0;
  std::vector<uint8_t> tight(data.size() - 1);
  EXPECT_EQ(sandglass_scene_save(live.scene.scene, tight.data(), tight.size(), &written, nullptr),
            SANDGLASS_ERROR_MEMORY_TOO_SMALL);
}

TEST(Move, EverythingMovesAlikeAndGoesOnAlike) {
  // A quarter turn about y and a shift: (x, y, z) -> (z + 3, y + 1, -x - 2).
  const float turn[4] = {0.0f, std::sqrt(0.5f), 0.0f, std::sqrt(0.5f)}, shift[3] = {3.0f, 1.0f, -2.0f};
  World world;
  world.fill();
  for (int i = 0; i < 10; ++i) world.frame();
  world.scene.particle_count = world.frame().particle_numbers;
  const std::vector<float> p = world.scene.positions(), v = world.scene.velocities();
  const sandglass_body_pose before = sandglass_granular_body_pose(world.scene.scene, 0);
  const char* reason = nullptr;
  ASSERT_EQ(sandglass_scene_move(world.scene.scene, turn, shift, &reason), SANDGLASS_OK) << reason;
  const std::vector<float> q = world.scene.positions(), u = world.scene.velocities();
  for (size_t i = 0; i < p.size(); i += 3) {
    EXPECT_NEAR(q[i], p[i + 2] + 3.0f, 1e-6);
    EXPECT_NEAR(q[i + 1], p[i + 1] + 1.0f, 1e-6);
    EXPECT_NEAR(q[i + 2], -p[i] - 2.0f, 1e-6);
    EXPECT_NEAR(u[i], v[i + 2], 1e-5);
    EXPECT_NEAR(u[i + 2], -v[i], 1e-5);
  }
  const sandglass_body_pose after = sandglass_granular_body_pose(world.scene.scene, 0);
  EXPECT_NEAR(after.position[0], before.position[2] + 3.0f, 1e-6);
  EXPECT_NEAR(after.linear_velocity[1], before.linear_velocity[1], 1e-6);
}

TEST(Move, WhatSleepsGoesOnSleeping) {
  GranularScene scene(description(300, 300));
  const std::vector<float> bed = lattice(10, 3, 10, 2.02f * k_radius, k_radius);
  scene.add(bed, {}, bed);
  scene.add_floor();
  for (int i = 0; i < 300 && scene.frame(k_frame).awake != 0; ++i) {
  }
  ASSERT_EQ(scene.frame(k_frame).awake, 0u);
  const float shift[3] = {10.0f, 2.0f, 0.0f};
  ASSERT_EQ(sandglass_scene_move(scene.scene, nullptr, shift, nullptr), SANDGLASS_OK);
  scene.colliders[0] = half_space(2.0f);
  EXPECT_EQ(scene.frame(k_frame).awake, 0u);
  EXPECT_EQ(scene.frame(k_frame).substeps, 0u);
}

TEST(Move, RefusesToLoseAnything) {
  GranularScene scene(description(2));
  scene.add({0.0f, 0.0f, 0.0f, 900.0f, 0.0f, 0.0f});
  const uint64_t before = scene.hash();
  const float far[3] = {200.0f, 0.0f, 0.0f}, bad[3] = {NAN, 0.0f, 0.0f}, none[4] = {0.0f, 0.0f, 0.0f, 0.0f};
  EXPECT_EQ(sandglass_scene_move(scene.scene, nullptr, far, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(sandglass_scene_move(scene.scene, nullptr, bad, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(sandglass_scene_move(scene.scene, none, nullptr, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(scene.hash(), before);
}

}  // namespace
