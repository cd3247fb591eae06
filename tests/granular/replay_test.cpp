// Determinism: the bits are the same on every instruction set, with any pool, and for any cut into work units. A frame
// that was recorded under a short budget replays to the bit without a clock.
#include <gtest/gtest.h>

#include <thread>

#include "platform/virtual_clock.h"
#include "runtime/core/random.h"
#include "tests/granular/granular_scene.h"

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

TEST(Determinism, EveryInstructionSetGivesTheSameBits) {
  for (const sandglass_scheme scheme : {SANDGLASS_SCHEME_SMALL_STEP, SANDGLASS_SCHEME_AVERAGED}) {
    sandglass_scene_desc desc = description(k_particles, k_grains);
    desc.granular.reference.scheme = scheme;
    desc.granular.reference.relaxation = 0.3f;
    if (scheme == SANDGLASS_SCHEME_AVERAGED) desc.granular.reference = {scheme, SANDGLASS_BLEND_SOURCE, 3, 2, 1.0f};
    expect_one_hash({0}, [&](sandglass_isa isa, uint32_t) {
      desc.isa = isa;
      return run(desc, 12);
    });
  }
}

TEST(Determinism, AMissingInstructionSetIsUnsupportedAndAnUnknownNumberInvalid) {
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

TEST(Determinism, PoolAndUnitSizeDoNotShow) {
  sandglass_scene_desc desc = description(k_particles, k_grains);
  desc.unit_items = 4096;
  const uint64_t alone = run(desc, 4);
  desc.parallel.run = run_backward;
  EXPECT_EQ(run(desc, 4), alone);
  desc.parallel.run = run_on_threads;
  EXPECT_EQ(run(desc, 4), alone);
  desc.parallel.run = nullptr;
  for (const uint32_t items : {16u, 128u, 65536u}) {
    desc.unit_items = items;
    EXPECT_EQ(run(desc, 4), alone) << items << " items a unit";
  }
}

// Grains are moved in place, so a piece that ran twice would show.
TEST(Determinism, APoolThatDoesNotKeepItsWordDoesNoHarm) {
  const sandglass_parallel_function faulty[] = {
      [](void*, sandglass_task_function, void*, uint32_t) {},
      [](void*, sandglass_task_function task, void* context, uint32_t count) {
        for (uint32_t i = 1; i < count; i += 2) task(context, i);
      },
      [](void*, sandglass_task_function task, void* context, uint32_t count) {
        for (uint32_t i = 0; i < 2 * count; ++i) task(context, i / 2);
        for (uint32_t i = count; i-- > 0;) task(context, i);
      },
      [](void*, sandglass_task_function task, void* context, uint32_t count) {
        for (uint32_t i = 0; i < 3 * count; ++i) task(context, i);
        task(context, ~0u);
      },
      [](void* random, sandglass_task_function task, void* context, uint32_t count) {
        for (uint32_t i = 0; i < count; ++i) task(context, static_cast<sandglass::Random*>(random)->below(count));
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

TEST(Determinism, AShortBudgetIsKeptReportedAndReplayed) {
  sandglass::VirtualClock clock{.step_ns = 10'000};  // a budget is a number of readings
  sandglass_scene_desc desc = description(k_particles, k_grains);
  desc.unit_items = 128;
  desc.clock = sandglass::virtual_clock(&clock);
  GranularScene recorded(desc);
  fill(&recorded);
  std::vector<sandglass_plan> plans;
  double debt = 0.0;
  for (int frame = 0; frame < 30; ++frame) {
    const sandglass_frame_report report = recorded.frame(k_frame, 2'000'000);
    const uint64_t bound = std::max(report.time.budget_ns, report.time.mandatory_ns) + report.time.last_unit_ns;
    EXPECT_LE(report.time.elapsed_ns, bound);
    EXPECT_GE(report.time.debt, debt) << "time is not made up for while the budget stays too short";
    debt = report.time.debt;
    plans.push_back(report.plan);
  }
  EXPECT_GT(debt, 0.1);

  desc.clock = {};
  desc.isa = SANDGLASS_ISA_SCALAR;
  GranularScene replayed(desc);
  fill(&replayed);
  for (const sandglass_plan& plan : plans) replayed.frame(k_frame, 0, &plan);
  EXPECT_EQ(replayed.hash(), recorded.hash());
}

TEST(Determinism, APlanThatDoesNotFitIsRefused) {
  GranularScene scene(description(k_particles, k_grains));
  fill(&scene);
  sandglass_plan plan = scene.frame(k_frame).plan;
  plan.runs[0].units += 1000000;
  EXPECT_THROW(scene.frame(k_frame, 0, &plan), std::runtime_error);
  plan.run_count = SANDGLASS_PLAN_RUNS + 1;
  EXPECT_THROW(scene.frame(k_frame, 0, &plan), std::runtime_error);
}

// Work units of a millisecond and no budget: every frame goes on in the midst of a step.
TEST(Determinism, AStepEndsWithTheCollidersWithWhichItBegan) {
  uint64_t now_ns = 0;
  sandglass_scene_desc desc = description(k_particles, k_grains);
  desc.clock = {[](void* user) { return *static_cast<uint64_t*>(user); }, &now_ns};
  desc.trace = {nullptr, [](void* user, const char*) { *static_cast<uint64_t*>(user) += 1'000'000; }, &now_ns};
  uint64_t hashes[2];
  for (const bool used_before : {false, true}) {
    GranularScene scene(desc);
    if (used_before) {  // what memory held before must not show
      fill(&scene);
      const sandglass_collider ball = sandglass::sphere(0.0f, 0.05f, 0.0f, 0.1f);
      scene.colliders.assign(3, ball);
      scene.frame(k_frame);
      scene.scene.reset();
      scene.colliders.clear(), scene.grains.clear();
      scene.particle_count = 0;
    }
    fill(&scene);
    const sandglass_collider floor = scene.colliders.front(), far = sandglass::sphere(50.0f, 0.0f, 0.0f, 0.1f);
    bool went_on = false;
    for (int frame = 0; frame < 60; ++frame) {
      scene.colliders = {floor};
      if (frame % 2 == 1) scene.colliders = {floor, far, far};
      went_on |= scene.frame(k_frame, 0).sand.substeps == 0;
    }
    EXPECT_TRUE(went_on);
    hashes[used_before] = scene.hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Determinism, ResetForgetsEverything) {
  GranularScene scene(description(k_particles, k_grains));
  fill(&scene);
  for (int frame = 0; frame < 5; ++frame) scene.frame(k_frame);
  const uint64_t hash = scene.hash();
  scene.scene.reset();
  scene.colliders.clear(), scene.grains.clear();
  scene.particle_count = 0;
  fill(&scene);
  for (int frame = 0; frame < 5; ++frame) scene.frame(k_frame);
  EXPECT_EQ(scene.hash(), hash);
}

}  // namespace
