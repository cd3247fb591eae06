// Determinism: the bits are the same on every instruction set, with any pool, and for any cut into work units. (Random
// scenes replay their plans on other kernels: random_scenes_test.cpp.)
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <thread>

#include "runtime/math/random.h"
#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_frame = 0.02f;
constexpr uint32_t k_particles = 600, k_grains = 2400;

void fill(GranularScene* scene) {
  scene->add_floor();
  const std::vector<float> particles = lattice(10, 6, 10, 0.0203f, 0.05f);
  scene->add(particles, {}, copies(particles, 4, 0.003f));
}

uint64_t run(const sandglass_scene_desc& desc, int frames) {
  GranularScene scene(desc);
  fill(&scene);
  for (int frame = 0; frame < frames; ++frame) scene.frame(k_frame);
  return scene.hash();
}

TEST(InstructionSet, AMissingOneIsUnsupportedAndAnUnknownNumberInvalid) {
  sandglass_scene_desc desc = description(k_particles, k_grains);
  const char* reason = nullptr;
  uint64_t bytes = 0;
  for (sandglass_isa isa = -1; isa <= SANDGLASS_ISA_WASM + 1; ++isa) {
    desc.isa = SANDGLASS_ISA_AUTOMATIC;
    ASSERT_EQ(sandglass_scene_bytes(&desc, &bytes, &reason), SANDGLASS_OK);
    const sandglass::cpp::Block block = sandglass::cpp::allocate_block(bytes);
    desc.isa = isa;
    sandglass_scene* scene = nullptr;
    const sandglass_status status = sandglass_scene_create(&desc, block.get(), bytes, &scene, &reason);
    const sandglass_status expected = sandglass_isa_name(isa) == nullptr  ? SANDGLASS_ERROR_INVALID_ARGUMENT
                                      : sandglass_isa_available(isa) == 0 ? SANDGLASS_ERROR_UNSUPPORTED
                                                                          : SANDGLASS_OK;
    EXPECT_EQ(status, expected) << isa << ": " << reason;
  }
}

// A pool that starts new threads for every call. It is slow, and its order is as random as the system makes it.
void run_on_threads(void*, sandglass_task_function task, void* context, uint32_t count) {
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < 4; ++t) {
    threads.emplace_back([=] {
      for (uint32_t i = t; i < count; i += 4) task(context, i);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

void run_backward(void*, sandglass_task_function task, void* context, uint32_t count) {
  for (uint32_t i = count; i-- > 0;) task(context, i);
}

// ---- the same bits

// With the averaged scheme.
uint64_t averaged(sandglass_scene_desc desc) {
  desc.granular.particle_capacity = k_particles;
  desc.granular.grain_capacity = k_grains;
  desc.granular.reference = {SANDGLASS_SCHEME_AVERAGED, SANDGLASS_BLEND_SOURCE, 3, 2, 1.0f};
  return run(desc, 12);
}

// A bed falls asleep and is hit.
uint64_t woken(sandglass_scene_desc desc) {
  const std::vector<float> bed = lattice(16, 3, 16, 0.0202f, 0.01f);
  desc.granular.particle_capacity = 800;
  desc.granular.grain_capacity = 16 * 3 * 16 * 8;
  GranularScene scene(desc);
  scene.add(bed, {}, grains_about(bed, 0.005f));
  scene.add_floor();
  bool slept = false;
  for (int frame = 0; frame < 150; ++frame) slept = scene.frame(k_frame).sand.awake < 400 || slept;
  EXPECT_TRUE(slept);
  scene.add({0.15f, 0.3f, 0.15f}, {0.0f, -3.0f, 0.0f});
  for (int frame = 0; frame < 20; ++frame) scene.frame(k_frame);
  return scene.hash();
}

// Sand, grains and three bodies: one is thrown, pushed and removed, one is put elsewhere, one goes into a sink. A nozzle
// pours onto a ball and beside a table, from which sand falls for good. Gravity turns and grows. Half-way another scene
// goes on from what the first one saves.
uint64_t everything(sandglass_scene_desc desc) {
  sandglass_granular_desc& g = desc.granular;
  g.particle_capacity = 1400;
  g.grain_capacity = 6000;
  g.lowest = 0.3f;
  g.body_capacity = 3;
  g.body_particle_capacity = 81;
  g.emitter_capacity = g.sink_capacity = 1;
  GranularScene first(desc), second(desc);
  const std::vector<float> sand = lattice(7, 4, 7, 0.0203f, 0.01f);
  for (GranularScene* scene : {&first, &second}) {
    scene->colliders = {sandglass::box(0.1f, -0.05f, 0.1f, 0.4f, 0.05f, 0.4f),
                        sandglass::sphere(0.1f, 0.2f, 0.1f, 0.05f)};
    scene->sinks = {sandglass::box(0.43f, 0.0f, 0.03f, 0.08f, 0.1f, 0.2f)};
    scene->emitters = {sandglass::emitter(0.42f, 0.4f, 0.42f, 0.06f, 1.0f, 3)};
    scene->draws = false;
  }
  first.add(sand, {}, copies(sand, 2, 0.003f));
  for (const float x : {-0.15f, 0.3f, 0.4f})
    first.add_body(shifted(lattice(3, 3, 3, 0.0201f, 0.1f), x, 0.0f, 0.0f), 2.0f, {x < 0.0f ? 2.0f : 0.0f, 0.0f, 0.0f});
  sandglass_frame_report report = {};
  const auto frame_of = [&](GranularScene* scene, int frame) {
    const float turn = 0.01f * static_cast<float>(frame);
    accept(scene->scene.set_gravity({9.81f * std::sin(turn), -9.81f * (1.0f + turn), 0.0f}));
    report = scene->frame(k_frame);
  };
  for (int frame = 0; frame < 20; ++frame) {
    if (frame == 5) accept(first.scene.push_body(0, {0.5f, 1.0f, 0.1f}, first.scene.body_pose(0).position));
    if (frame == 10) accept(first.scene.set_body(1, {{0.1f, 0.3f, 0.1f}, {1, 0, 0, 2}, {0, -1, 0}, {3, 0, 0}}));
    frame_of(&first, frame);
  }
  std::vector<std::byte> saved;
  accept(first.scene.save(&saved));
  accept(second.scene.restore(saved));
  accept(second.scene.remove_body(1));
  for (int frame = 20; frame < 50; ++frame) frame_of(&second, frame);
  EXPECT_EQ(report.sand.removed_bodies, 3u) << "the others fell or went into the sink";
  EXPECT_GT(report.sand.emitted_particles, 100u);
  EXPECT_GT(report.sand.removed_particles, 2 * 27u) << "sand fell, too";
  return second.hash();
}

struct SameBits {
  const char* name;
  uint64_t (*run)(sandglass_scene_desc desc);
};
class Determinism : public testing::TestWithParam<SameBits> {};
INSTANTIATE_TEST_SUITE_P(Scenes, Determinism,
                         testing::Values(SameBits{"averaged", averaged}, SameBits{"woken", woken},
                                         SameBits{"everything", everything}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST_P(Determinism, EveryInstructionSetUnitSizeAndPoolGivesTheSameBits) {
  const uint64_t alone = GetParam().run(description(0));
  sandglass_scene_desc desc = description(0);
  desc.unit_items = 4096;
  for (const auto pool : {run_backward, run_on_threads}) {
    desc.parallel.run = pool;
    EXPECT_EQ(GetParam().run(desc), alone) << (pool == run_backward ? "backward" : "on threads");
  }
  desc.parallel.run = nullptr;
  for (desc.isa = SANDGLASS_ISA_SCALAR; desc.isa <= SANDGLASS_ISA_AVX512; ++desc.isa)
    for (const uint32_t items : {16u, 1024u}) {
      desc.unit_items = items;
      if (sandglass_isa_available(desc.isa) == 0) continue;
      EXPECT_EQ(GetParam().run(desc), alone) << sandglass_isa_name(desc.isa) << ", units of " << items;
    }
}

// Grains are moved in place, so a piece that ran twice would show.
TEST(Pool, ThatDoesNotKeepItsWordDoesNoHarm) {
  using Pool = void (*)(void*, void (*)(void*, uint32_t), void*, uint32_t);
  const Pool faulty[] = {[](void*, void (*)(void*, uint32_t), void*, uint32_t) {},
                         [](void*, void (*task)(void*, uint32_t), void* context, uint32_t count) {
                           for (uint32_t i = 1; i < count; i += 2) task(context, i);
                         },
                         [](void*, void (*task)(void*, uint32_t), void* context, uint32_t count) {
                           for (uint32_t i = 0; i < 2 * count; ++i) task(context, i / 2);
                           for (uint32_t i = count; i-- > 0;) task(context, i);
                         },
                         [](void*, void (*task)(void*, uint32_t), void* context, uint32_t count) {
                           for (uint32_t i = 0; i < 3 * count; ++i) task(context, i);
                           task(context, ~0u);
                         },
                         [](void* random, void (*task)(void*, uint32_t), void* context, uint32_t count) {
                           for (uint32_t i = 0; i < count; ++i)
                             task(context, static_cast<sandglass::Random*>(random)->below(count));
                         }};
  sandglass_scene_desc desc = description(k_particles, k_grains);
  desc.unit_items = 4096;
  const uint64_t alone = run(desc, 4);
  sandglass::Random random{1};
  desc.parallel.user = &random;
  for (const sandglass_parallel_function pool : faulty) {
    desc.parallel.run = pool;
    EXPECT_EQ(run(desc, 4), alone) << "pool " << &pool - faulty;
  }
}

TEST(Plans, APlanThatDoesNotFitIsRefused) {
  GranularScene scene(description(k_particles, k_grains));
  fill(&scene);
  sandglass_plan plan = scene.frame(k_frame).plan;
  plan.runs[0].units += 1000000;
  EXPECT_THROW(scene.frame(k_frame, 0, &plan), std::runtime_error);
  plan.run_count = SANDGLASS_PLAN_RUNS + 1;
  EXPECT_THROW(scene.frame(k_frame, 0, &plan), std::runtime_error);
}

}  // namespace
