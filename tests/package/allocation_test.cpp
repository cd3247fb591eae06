// No frame allocates: the counting allocator stays at 0 over 10,000 frames of sand, with all hooks. (symbols.sh tests that
// the archive, light and shadows included, has no such symbol. This test also covers what a frame calls in the C library.)
#include <gtest/gtest.h>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/counting_allocator.h"
#include "tests/sand/granular_scene.h"

namespace {

constexpr uint64_t k_half_budget_ns = 300'000;

void on_this_thread(void*, sandglass_task_function task, void* context, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) task(context, i);
}
void ignore(void*, const char*) {}

TEST(Allocation, TheCountersCount) {
  sandglass::host::start_counting_allocations();
  int* volatile number = new int(1);
  delete number;
  const uint64_t calls = sandglass::host::stop_counting_allocations();
  EXPECT_EQ(calls, 2u);
}

TEST(Allocation, TenThousandFramesMakeNoCall) {
  const std::vector<float> particles = lattice(4, 4, 4, 0.02f, 0.01f);
  const std::vector<float> grains = grains_about(particles, 0.005f);
  const std::vector<float> boundary = shifted(lattice(1, 8, 5, 0.02f, 0.01f), 0.3f, 0, 0);
  const auto count = [](const std::vector<float>& points) { return static_cast<uint32_t>(points.size() / 3); };
  sandglass_scene_desc desc = description(count(particles), count(grains), count(boundary));
  desc.clock = sandglass_clock_system();
  desc.parallel.run = on_this_thread;
  desc.trace = {ignore, ignore, nullptr};
  desc.log = {ignore, nullptr};
  desc.granular.collider_capacity = 4;
  const uint64_t bytes = sandglass::Scene::bytes(desc);
  const sandglass::Block block = sandglass::allocate_block(bytes);

  std::vector<sandglass_grain> output(count(grains));

  sandglass_collider colliders[4] = {sandglass::floor_at(0.0f), sandglass::sphere(0.0f, 0.0f, 0.0f, 0.03f),
                                     sandglass::capsule(0.0f, 0.0f, 0.0f, 0.03f, 0.03f),
                                     sandglass::box(0.0f, 0.0f, 0.0f, 0.03f, 0.03f, 0.03f)};
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60.0f;
  input.colliders = colliders;
  input.collider_count = 4;
  input.grains = output.data();
  input.grain_capacity = count(grains);
  sandglass_frame_report report;

  // From creation on there is only the block, and no call to get it.
  sandglass::host::start_counting_allocations();
  sandglass::Scene scene;
  bool fine = bool(scene.create_in(desc, block.get(), bytes));
  for (uint32_t frame = 0; fine && frame < 10000; ++frame) {
    // Every 500 frames the sand starts again from the air, so that most frames have something to do.
    if (frame % 500 == 0) {
      scene.reset();
      fine = scene.add(particles, grains) && scene.set_boundary(boundary) &&
             scene.set_friction(0.5f, frame % 1000 == 0 ? 0.4f : 0.3f);
    }
    // Budgets from nothing to plenty, so that all quality levels, denied units and time debt occur.
    input.budget_ns = frame % 3 * k_half_budget_ns;
    fine = fine && scene.set_gravity({0.01f * static_cast<float>(frame % 300), -9.81f, 0.0f});
    for (uint32_t i = 1; i < 4; ++i) colliders[i].position[0] = 0.001f * static_cast<float>((frame + 50 * i) % 200);
    fine = fine && scene.frame(input, &report);
  }
  const uint64_t calls = sandglass::host::stop_counting_allocations();
  EXPECT_TRUE(fine);
  EXPECT_EQ(calls, 0u);
  EXPECT_EQ(report.sand.particles, count(particles));
}

}  // namespace
