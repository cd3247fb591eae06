// A version stands if and only if no byte of what is drawn differs; and a buffer that says how old it is holds what a
// whole write would. By scenes that pour, drain, add, remove, move, save and restore, with one buffer and with three that
// take turns, with and without a pool.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "runtime/math/random.h"
#include "runtime/scene/scene.h"
#include "tests/sand/granular_scene.h"

namespace {

using sandglass::Random;

void backwards(void*, sandglass_task_function task, void* context, uint32_t count) {
  while (count-- > 0) task(context, count);
}

struct Drawn {
  std::vector<sandglass_grain> grains;
  std::vector<sandglass_body_pose> bodies;
  template <class Item>
  static bool same(const std::vector<Item>& a, const std::vector<Item>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Item)) == 0);
  }
};

// What a whole write gives, by the calls for tests.
Drawn drawn(const GranularScene& scene, const sandglass_frame_report& report) {
  Drawn now;
  std::vector<float> x(3 * report.sand.grain_numbers), v(x.size());
  sandglass_scene_grains(scene.scene.get(), x.data(), v.data());
  for (uint32_t i = 0; i < report.sand.grain_numbers; ++i) {
    sandglass_grain grain = {{x[3 * i], x[3 * i + 1], x[3 * i + 2]}, 0};
    grain.speed = std::sqrt(v[3 * i] * v[3 * i] + v[3 * i + 1] * v[3 * i + 1] + v[3 * i + 2] * v[3 * i + 2]);
    if (grain.position[1] == SANDGLASS_REMOVED_Y) grain.speed = -1;
    now.grains.push_back(grain);
  }
  for (uint32_t i = 0; i < 2; ++i)
    if (sandglass_scene_has_body(scene.scene.get(), i) != 0)
      now.bodies.push_back(sandglass_scene_body_pose(scene.scene.get(), i));
  return now;
}

struct Counts {
  uint32_t wrong_versions = 0, wrong_bytes = 0, stood = 0, grew = 0;
};

// `forgets`: a control, in which the stamps of groups are lost when they are sorted.
Counts run(uint64_t seed, uint32_t buffers, bool pooled, bool forgets) {
  Random random{seed};
  sandglass_scene_desc desc = description(900, 6000);
  desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;
  desc.granular.body_capacity = 2;
  desc.granular.body_particle_capacity = 64;
  desc.unit_items = 256;
  if (pooled) desc.parallel.run = backwards;
  GranularScene scene(desc);
  scene.add_floor();
  const std::vector<float> sand = lattice(8, 6, 8, 0.0204f, 0.01f);
  scene.add(sand, {}, grains_about(sand, 0.005f));
  scene.add_body(shifted(lattice(3, 3, 3, 0.02f, 0.01f), 0.3f, 0.0f, 0.0f));
  const sandglass_emitter emitter = sandglass::emitter(0, 0.3f, 0, 0.02f, 0.5f, 8);
  const sandglass_collider drain = sandglass::sphere(0.1f, 0.0f, 0.1f, 0.03f);
  std::vector<std::vector<sandglass_grain>> rings(buffers, std::vector<sandglass_grain>(6000));
  std::vector<uint32_t> written(buffers, 0);  // frame after which each was written
  std::vector<std::byte> saved;
  Drawn before;
  sandglass_version_report versions = {};
  Counts counts;
  bool pours = false, drains = false;
  for (uint32_t frame = 1; frame <= 260; ++frame) {
    const uint32_t act = random.below(frame < 130 ? 12 : 40);  // in its second half it comes to rest at times
    if (act == 0) pours = !pours && frame < 100;
    if (frame > 120) pours = false;
    if (act == 1) drains = !drains;
    if (act == 2) accept(scene.scene.remove(drain));
    if (act == 3) {
      const float at = 0.2f * static_cast<float>(random.uniform());
      accept(scene.scene.add(std::vector<float>{at, 0.4f, 0.0f}, std::vector<float>{at, 0.4f, 0.003f}));
    }
    if (act == 4) accept(scene.scene.move({0, 0, 0, 1}, {0.01f, 0, 0}));
    if (act == 5) accept(scene.scene.save(&saved));
    if (act == 6 && !saved.empty()) accept(scene.scene.restore(saved));
    const uint32_t ring = frame % buffers;
    sandglass_frame_input input = scene.input(act == 7 ? 0.0f : 0.02f, act == 8 ? 0 : ~0ull >> 1);
    input.grains = rings[ring].data();
    input.grain_capacity = 6000;
    input.grains_age = written[ring] == 0 || random.below(40) == 0 ? 0 : frame - written[ring];
    input.emitters = &emitter;
    input.emitter_count = pours ? 1 : 0;
    input.sinks = &drain;
    input.sink_count = drains ? 1 : 0;
    sandglass::Output& output = scene.scene.get()->granular.output;
    if (forgets)
      for (uint32_t i = 0; i < 6000 / 16; ++i) output.stamps[i] = 0;
    const sandglass_frame_report report = scene.run(input);
    written[ring] = frame;
    const Drawn now = drawn(scene, report);
    rings[ring].resize(6000);
    if (std::memcmp(rings[ring].data(), now.grains.data(), now.grains.size() * sizeof(sandglass_grain)) != 0)
      ++counts.wrong_bytes;
    if (frame > 1) {
      const bool grains_stood = report.versions.grains == versions.grains;
      const bool bodies_stood = report.versions.bodies == versions.bodies;
      const bool again = act == 6 && !grains_stood;  // a restored scene may come to what was there
      counts.wrong_versions += !again && grains_stood != Drawn::same(before.grains, now.grains) ? 1 : 0;
      counts.wrong_versions += bodies_stood != Drawn::same(before.bodies, now.bodies) ? 1 : 0;
      counts.stood += grains_stood && bodies_stood ? 1 : 0;
      counts.grew += !grains_stood ? 1 : 0;
    }
    versions = report.versions;
    before = now;
  }
  return counts;
}

}  // namespace

TEST(Versions, StandIfAndOnlyIfNoByteDiffers) {
  uint32_t stood = 0, forgotten = 0;
  for (uint64_t seed = 1; seed <= 4; ++seed)
    for (const uint32_t buffers : {1u, 3u}) {
      const Counts counts = run(seed, buffers, seed % 2 == 0, false);
      EXPECT_EQ(counts.wrong_versions, 0u) << seed << " " << buffers;
      EXPECT_EQ(counts.wrong_bytes, 0u) << seed << " " << buffers;
      EXPECT_GT(counts.grew, 50u);
      stood += counts.stood;
      forgotten += run(seed, buffers, false, true).wrong_bytes;
    }
  EXPECT_GT(stood, 20u) << "nothing ever rests";
  EXPECT_GT(forgotten, 0u) << "the control: stamps that are lost are seen";
}

// What rests costs no unit and no byte; and so does a pile beside which one particle falls that carries no grain.
TEST(Versions, WhatRestsIsNotTouched) {
  GranularScene scene(description(600, 4000));
  scene.add_floor();
  const std::vector<float> sand = lattice(8, 6, 8, 0.0204f, 0.01f);
  scene.add(sand, {}, grains_about(sand, 0.005f));
  sandglass_pile_shadow_desc of_pile = sandglass::pile_shadow_desc();
  of_pile.sky_texels = 64;
  sandglass::PileShadow pile;
  accept(pile.create(of_pile));
  std::vector<sandglass_grain> buffer(4000), poison(4000);
  const auto frame = [&](std::vector<sandglass_grain>* into) {
    sandglass_frame_input input = scene.input(0.02f);
    input.grains = into->data();
    input.grain_capacity = 4000;
    input.grains_age = 1;
    input.pile_shadow = pile.get();
    return scene.run(input);
  };
  sandglass_frame_report report = frame(&buffer);
  for (int i = 0; i < 600 && (report.sand.awake != 0 || report.sand.awake_grains != 0); ++i) report = frame(&buffer);
  for (int i = 0; i < 5; ++i) report = frame(&buffer);
  ASSERT_EQ(report.sand.awake, 0u);
  std::memset(static_cast<void*>(poison.data()), 0x5a, poison.size() * sizeof(sandglass_grain));
  const std::vector<sandglass_grain> untouched = poison;
  const auto rests = [&](const char* what) {
    const uint64_t grains = report.versions.grains, light = pile.texture().version,
                   sky = pile.texture(SANDGLASS_PILE_SHADOW_SKY_FLOOR).version;
    report = frame(&poison);
    EXPECT_TRUE(Drawn::same(poison, untouched)) << what;
    EXPECT_EQ(report.versions.grains, grains) << what;
    EXPECT_EQ(pile.texture().version, light) << what;
    EXPECT_EQ(pile.texture(SANDGLASS_PILE_SHADOW_SKY_FLOOR).version, sky) << what;
    EXPECT_EQ(report.stages[SANDGLASS_STAGE_SHADOW].units, 0u) << what;
    EXPECT_EQ(report.sand.awake_grains, 0u) << what;
  };
  for (int i = 0; i < 10; ++i) rests("asleep");
  for (const sandglass_stage_report& stage : report.stages) EXPECT_EQ(stage.units, 0u);
  scene.add({1.0f, 1.5f, 1.0f});
  report = frame(&buffer);
  for (int i = 0; i < 10; ++i) {
    rests("one falls");
    EXPECT_EQ(report.sand.awake, 1u);
  }
}
