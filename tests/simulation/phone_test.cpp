// The estimate of a phone's frame: that its instructions are those that the emulator counted for a whole frame, by
// another way; that it is what the stated core makes of them; and that it gives the same plans everywhere.
#include "models/phones/phone.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "sandglass/sandglass.hpp"

namespace sandglass::host {
namespace {

// The scene that tests/bench/count_workload.cpp is counted on: 1,560 particles, 27,000 grains, all moving.
struct PhoneScene {
  Scene scene;
  PhoneClock clock;
  sandglass_collider colliders[2] = {floor_at(0.0f), floor_at(0.0f)};
  std::vector<sandglass_grain> drawn;
  sandglass_frame_input input = frame_input();
  sandglass_frame_report report = frame_report();

  explicit PhoneScene(const char* core) : clock(phone_core(core)) {
    const float r = 0.01f, edge = 0.0068f;
    std::vector<float> particles, grains;
    const Box box{{-0.10f, r, -0.10f}, {0.10f, 0.21f, 0.10f}};
    EXPECT_TRUE(sample_lattice(
        box, 2.02f * r, [](const float*) { return true; }, &particles));
    uint32_t random = 1;
    for (float y = r; y < 0.21f; y += edge)
      for (float z = -0.1f; z < 0.1f; z += edge)
        for (float x = -0.1f; x < 0.1f; x += edge)
          for (const float at : {x, y, z}) {
            random = random * 1664525u + 1013904223u;
            grains.push_back(at + 0.5f * edge * static_cast<float>(random >> 8) / 16777216.0f);
          }
    sandglass_scene_desc desc = scene_desc();
    desc.clock = clock.clock();
    desc.granular.particle_radius = r;
    desc.granular.particle_capacity = static_cast<uint32_t>(particles.size() / 3);
    desc.granular.grain_capacity = static_cast<uint32_t>(grains.size() / 3);
    desc.granular.collider_capacity = 2;
    EXPECT_TRUE(scene.create(desc));
    EXPECT_TRUE(scene.add(particles, grains));
    clock.follow(scene.get());
    colliders[1].shape = SANDGLASS_SHAPE_BOX;
    colliders[1].position[0] = 0.2f;
    for (float& side : colliders[1].size) side = 0.08f;
    drawn.resize(desc.granular.grain_capacity);
    input.time_step = 0.016667f;
    input.budget_ns = ~0ull;
    input.colliders = colliders;
    input.collider_count = 2;
    input.grains = drawn.data();
    input.grain_capacity = desc.granular.grain_capacity;
  }
  double frame_ms() {
    EXPECT_TRUE(scene.frame(input, &report));
    return 1e-6 * static_cast<double>(report.time.elapsed_ns);
  }
};

// Instructions of a frame, from the emulator's count of the whole.
double counted_frame() {
  std::ifstream file(SANDGLASS_COUNTS "/counts_sand.txt");
  for (std::string line; std::getline(file, line);)
    if (line.find(" whole frame") != std::string::npos) return std::stod(line);
  return 0;
}

TEST(Phone, AFrameOfSandCostsWhatTheEmulatorCounted) {
  PhoneScene phone("cortex-a78");
  for (int frame = 0; frame < 6; ++frame) phone.frame_ms();
  double sum = 0;
  for (int frame = 0; frame < 4; ++frame) sum += phone.frame_ms();
  const double instructions = sum / 4 * phone.clock.core().ghz * 1e6 * phone.clock.core().middle_ipc();
  // A unit costs more where sand lies densely. The table is made of other frames of this scene.
  EXPECT_NEAR(instructions / counted_frame(), 1, 0.1);
  EXPECT_TRUE(phone.clock.guessed().empty()) << phone.clock.guessed().begin()->first;
}

TEST(Phone, TimesAreThoseOfTheStatedCore) {
  PhoneScene fast("cortex-x3"), slow("cortex-a55");
  const double ratio = slow.frame_ms() / fast.frame_ms();
  // Both did all the work: 2.9 GHz at sqrt(2 * 4) a cycle, 1.8 GHz at sqrt(0.5 * 1.2).
  EXPECT_NEAR(ratio, 2.9 * 2.8284271 / (1.8 * 0.7745967), 0.001);
  EXPECT_EQ(fast.scene.hash(), slow.scene.hash());
}

TEST(Phone, ABudgetIsKeptAndTheRunRepeats) {
  uint64_t hash = 0;
  for (int run = 0; run < 2; ++run) {
    PhoneScene phone("cortex-a78");
    phone.input.budget_ns = 4'000'000;
    for (int frame = 0; frame < 20; ++frame) {
      const double took = phone.frame_ms();
      if (frame < 4) continue;  // costs are not known yet
      EXPECT_LE(took, 4.0);
      EXPECT_GE(took, 3.6);
    }
    if (run == 1) {
      EXPECT_EQ(phone.scene.hash(), hash);
    }
    hash = phone.scene.hash();
  }
}

}  // namespace
}  // namespace sandglass::host
