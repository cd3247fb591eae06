// Saving, restoring and moving a running scene. (Forged bytes: tests/fuzz/saved_scene.cpp.)
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>

#include "platform/virtual_clock.h"
#include "tests/damaged_file.h"
#include "tests/sand/granular_scene.h"

namespace {

using Bytes = std::vector<std::byte>;

constexpr float k_radius = 0.01f, k_frame = 0.02f;

// A budget is a number of work units by this clock.
sandglass::VirtualClock g_clock{.step_ns = 1000};

sandglass_scene_desc everything(uint32_t particles = 700, uint32_t grains = 4000) {
  sandglass_scene_desc desc = description(particles, grains, 64);
  desc.granular.body_capacity = 2;
  desc.granular.body_particle_capacity = 40;
  desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;
  desc.clock = sandglass::virtual_clock(&g_clock);
  desc.unit_items = 64;
  return desc;
}

// Sand, grains, a body, a boundary, an emitter and a sink.
struct World {
  explicit World(const sandglass_scene_desc& desc = everything()) : scene(desc) {
    scene.add_floor();
    scene.sinks = {sandglass::floor_at(-0.5f)};
    scene.emitters = {sandglass::emitter(-0.2f, 0.4f, 0.0f, 0.025f, 0.8f, 4)};
    scene.draws = false;
  }

  void fill() {
    const std::vector<float> block = lattice(7, 5, 7, 2.02f * k_radius, k_radius);
    std::vector<float> grains, wall;
    for (size_t i = 0; i < block.size(); ++i) grains.push_back(block[i] + 0.004f);
    for (int i = 0; i < 32; ++i) wall.insert(wall.end(), {-0.03f, k_radius, 0.015f * static_cast<float>(i) - 0.1f});
    scene.add(block, {}, grains);
    scene.add_body(shifted(lattice(3, 3, 3, 2.01f * k_radius, k_radius), 0.05f, 0.15f, 0.05f), 2.0f);
    accept(scene.scene.set_boundary(wall));
  }

  sandglass_frame_report frame(uint64_t budget = ~0ull >> 1) { return scene.frame(k_frame, budget); }

  Bytes save() {
    Bytes data;
    accept(scene.scene.save(&data));
    EXPECT_EQ(data.size(), sandglass_scene_save_bytes(scene.scene.get()));
    return data;
  }

  sandglass_status restore(const Bytes& data) {
    const sandglass::Status status = scene.scene.restore(data);
    EXPECT_EQ(status.reason == nullptr, status.code == SANDGLASS_OK);
    return status.code;
  }

  GranularScene scene;
};

// With another gravity than at first: the second change is too small to wake what sleeps.
TEST(Save, TheSavedSceneAndTheRestoredOneRunOnAlike) {
  for (const int frames : {0, 40}) {
    // A budget of twenty units or fewer leaves the scene in the middle of a sub-step and of a sweep.
    for (const int starved : {0, 1, 7}) {
      World live;
      live.fill();
      accept(live.scene.scene.set_gravity({0.7f, -9.8f, 0.0f}));
      for (int i = 0; i < frames; ++i) live.frame();
      accept(live.scene.scene.set_gravity({0.8f, -9.8f, 0.0f}));
      for (int i = 0; i < starved; ++i) live.frame(20'000);
      const Bytes data = live.save();
      World other;
      accept(other.scene.scene.set_gravity({0.8f, -9.8f, 0.0f}));
      ASSERT_EQ(other.restore(data), SANDGLASS_OK);
      EXPECT_EQ(other.scene.hash(), live.scene.hash());
      for (int i = 0; i < 12; ++i) {
        const sandglass_frame_report a = live.frame(), b = other.frame();
        ASSERT_EQ(a.time.simulated, b.time.simulated);
        ASSERT_EQ(a.sand.awake, b.sand.awake);
        ASSERT_EQ(a.sand.emitted_grains, b.sand.emitted_grains);
      }
      EXPECT_EQ(other.scene.hash(), live.scene.hash()) << frames << " frames, " << starved << " starved";
      const sandglass_body_pose a = live.scene.scene.body_pose(0), b = other.scene.scene.body_pose(0);
      EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
      EXPECT_EQ(other.save(), live.save());
    }
  }
}

// Not a number, in all memory that a scene holds besides its first region.
void spoil(sandglass_scene* scene) {
  std::vector<sandglass_region> regions(sandglass_scene_regions(scene, nullptr, 0));
  sandglass_scene_regions(scene, regions.data(), static_cast<uint32_t>(regions.size()));
  ASSERT_STREQ(regions.front().name, "scene");
  for (size_t i = 1; i < regions.size(); ++i)
    std::memset(reinterpret_cast<uint8_t*>(scene) + regions[i].offset, 0xff, regions[i].bytes);
}

// Its frames equal those of the other one, bytes and all.
void expect_alike(World* a, World* b) {
  EXPECT_EQ(a->save(), b->save());
  for (int i = 0; i < 12; ++i) {
    a->frame();
    b->frame();
    ASSERT_EQ(a->save(), b->save()) << "frame " << i;
  }
}

TEST(Save, ARefusedOneChangesNothingAndTheBytesAreNeverMoreThanSaid) {
  World live;
  live.fill();
  for (int i = 0; i < 60; ++i) live.frame(i % 3 == 0 ? 20'000 : ~0ull >> 1);
  for (int i = 0; i < 40; ++i) {
    live.frame(20'000);  // in the middle of a sub-step and of a sweep
    const uint64_t bytes = sandglass_scene_save_bytes(live.scene.scene.get()), before = live.scene.hash();
    Bytes data(bytes);
    uint64_t written = 0;
    ASSERT_EQ(sandglass_scene_save(live.scene.scene.get(), data.data(), bytes - 1, &written, nullptr),
              SANDGLASS_ERROR_MEMORY_TOO_SMALL);
    ASSERT_EQ(live.scene.hash(), before) << i;
    ASSERT_EQ(sandglass_scene_save(live.scene.scene.get(), data.data(), bytes, &written, nullptr), SANDGLASS_OK);
    ASSERT_LE(written, bytes);
  }
}

TEST(Restore, WhatTheSceneDidBeforeIsForgotten) {
  World live, other, used;
  live.fill();
  for (int i = 0; i < 40; ++i) live.frame();
  const Bytes data = live.save();
  ASSERT_EQ(other.restore(data), SANDGLASS_OK);
  used.fill();
  used.frame();  // builds lists
  spoil(used.scene.scene.get());
  ASSERT_EQ(used.restore(data), SANDGLASS_OK);
  expect_alike(&used, &other);
}

TEST(Reset, IsTheStateAfterCreate) {
  World fresh, used;
  used.fill();
  accept(used.scene.scene.set_gravity({3.0f, 8.0f, 0.0f}));
  accept(used.scene.scene.set_friction(0.9f, 0.8f));
  for (int i = 0; i < 10; ++i) used.frame();
  used.frame(20'000);
  spoil(used.scene.scene.get());
  used.scene.scene.reset();
  used.fill();
  fresh.fill();
  expect_alike(&used, &fresh);
}

TEST(Save, ALongRunWithoutGrainsIsRestored) {
  sandglass_scene_desc desc = description(2);
  desc.granular.sleep_after = 0.0f;
  GranularScene live(desc), other(desc);
  live.add({0.0f, 0.5f, 0.0f, 0.1f, 0.5f, 0.0f});
  live.add_floor();
  for (int i = 0; i < 600; ++i) live.frame(0.02f);
  Bytes data;
  accept(live.scene.save(&data));
  accept(other.scene.restore(data));
  EXPECT_EQ(other.hash(), live.hash());
}

TEST(Save, RestoresOnAnotherInstructionSetAndIntoALargerScene) {
  World live;
  live.fill();
  for (int i = 0; i < 10; ++i) live.frame();
  const Bytes data = live.save();
  for (int i = 0; i < 10; ++i) live.frame();
  sandglass_scene_desc desc = everything(2000, 9000);
  desc.isa = SANDGLASS_ISA_SCALAR;
  World other(desc);
  ASSERT_EQ(other.restore(data), SANDGLASS_OK);
  for (int i = 0; i < 10; ++i) other.frame();
  // Grids depend on capacities, and the order of sums depends on grids. So the material is equal, but not every bit.
  EXPECT_EQ(other.frame().sand.particles, live.frame().sand.particles);
}

TEST(Restore, EveryTruncationAndFlippedBitIsAnErrorAndChangesNothing) {
  World live, other;
  live.scene.add({0.0f, 0.1f, 0.0f, 0.05f, 0.1f, 0.0f}, {}, {0.0f, 0.1f, 0.0f});
  live.frame();
  other.fill();
  other.frame();
  const uint64_t before = other.scene.hash();
  sandglass::tests::expect_only_whole_taken(live.save(), [&](const Bytes& bytes) {
    if (other.restore(bytes) == SANDGLASS_OK) return true;
    EXPECT_EQ(other.scene.hash(), before);
    return false;
  });
}

TEST(Restore, NeedsTheSameRadiusAndRoom) {
  World live;
  live.fill();
  const Bytes data = live.save();
  World small(everything(100, 100));
  EXPECT_EQ(small.restore(data), SANDGLASS_ERROR_CAPACITY);
  sandglass_scene_desc desc = everything();
  desc.granular.particle_radius = 0.02f;
  World coarse(desc);
  EXPECT_EQ(coarse.restore(data), SANDGLASS_ERROR_INVALID_ARGUMENT);
}

constexpr sandglass::Rotation k_unturned = {0.0f, 0.0f, 0.0f, 1.0f};

TEST(Move, EverythingMovesAlikeAndGoesOnAlike) {
  // A quarter turn about y and a shift: (x, y, z) -> (z + 3, y + 1, -x - 2).
  const sandglass::Rotation turn = {0.0f, std::sqrt(0.5f), 0.0f, std::sqrt(0.5f)};
  World world;
  world.fill();
  for (int i = 0; i < 11; ++i) world.frame();
  const std::vector<float> p = world.scene.positions(), v = world.scene.velocities();
  const sandglass_body_pose before = world.scene.scene.body_pose(0);
  accept(world.scene.scene.move(turn, {3.0f, 1.0f, -2.0f}));
  const std::vector<float> q = world.scene.positions(), u = world.scene.velocities();
  for (size_t i = 0; i < p.size(); i += 3) {
    EXPECT_NEAR(q[i], p[i + 2] + 3.0f, 1e-6);
    EXPECT_NEAR(q[i + 1], p[i + 1] + 1.0f, 1e-6);
    EXPECT_NEAR(q[i + 2], -p[i] - 2.0f, 1e-6);
    EXPECT_NEAR(u[i], v[i + 2], 1e-5);
    EXPECT_NEAR(u[i + 2], -v[i], 1e-5);
  }
  const sandglass_body_pose after = world.scene.scene.body_pose(0);
  EXPECT_NEAR(after.position[0], before.position[2] + 3.0f, 1e-6);
  EXPECT_NEAR(after.linear_velocity[1], before.linear_velocity[1], 1e-6);
}

TEST(Move, WhatSleepsGoesOnSleeping) {
  GranularScene scene(description(300, 300));
  const std::vector<float> bed = lattice(10, 3, 10, 2.02f * k_radius, k_radius);
  scene.add(bed, {}, bed);
  scene.add_floor();
  until_asleep(&scene);
  accept(scene.scene.move(k_unturned, {10.0f, 2.0f, 0.0f}));
  scene.colliders[0] = sandglass::floor_at(2.0f);
  EXPECT_EQ(scene.frame(k_frame).sand.awake, 0u);
  EXPECT_EQ(scene.frame(k_frame).sand.substeps, 0u);
}

TEST(Move, RefusesToLoseAnything) {
  GranularScene scene(description(2));
  scene.add({0.0f, 0.0f, 0.0f, 900.0f, 0.0f, 0.0f});
  const uint64_t before = scene.hash();
  const auto refused = [&](const sandglass::Rotation& rotation, float x, const char* what) {
    const sandglass::Status status = scene.scene.move(rotation, {x, 0.0f, 0.0f});
    EXPECT_EQ(status.code, SANDGLASS_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(std::string(status.reason).find(what), std::string::npos) << x << ": " << status.reason;
  };
  // A far move leaves the coordinate limit; it is finite, and the reason must not say otherwise.
  for (const float far : {200.0f, 1500.0f, 1e30f}) refused(k_unturned, far, "coordinate limit");
  for (const float bad : {NAN, INFINITY}) refused(k_unturned, bad, "not finite");
  refused({0.0f, 0.0f, 0.0f, 0.0f}, 0.0f, "rotation");
  EXPECT_EQ(scene.hash(), before);
}

}  // namespace
