// The estimate of a phone's frame: that its instructions are those that the emulator counted for a whole frame, by
// another way; that it is what the stated core makes of them; and that it gives the same plans everywhere.
#include "models/phones/phone.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/bench/counted_sand.h"

namespace sandglass::host {
namespace {

// The scene that tests/bench/count_workload.cpp is counted on.
struct PhoneScene {
  PhoneClock clock;
  CountedSand sand;

  explicit PhoneScene(const char* core) : clock(phone_core(core)), sand(SANDGLASS_ISA_AUTOMATIC, clock.clock()) {
    EXPECT_TRUE(sand.status) << sand.status.reason;
    clock.follow(sand.scene.get());
  }
  double frame_ms() {
    EXPECT_TRUE(sand.scene.frame(sand.input, &sand.report));
    return 1e-6 * static_cast<double>(sand.report.time.elapsed_ns);
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
  EXPECT_EQ(fast.sand.scene.hash(), slow.sand.scene.hash());
}

TEST(Phone, ABudgetIsKeptAndTheRunRepeats) {
  uint64_t hash = 0;
  for (int run = 0; run < 2; ++run) {
    PhoneScene phone("cortex-a78");
    phone.sand.input.budget_ns = 4'000'000;
    for (int frame = 0; frame < 20; ++frame) {
      const double took = phone.frame_ms();
      if (frame < 4) continue;  // costs are not known yet
      EXPECT_LE(took, 4.0);
      EXPECT_GE(took, 3.6);
    }
    if (run == 1) {
      EXPECT_EQ(phone.sand.scene.hash(), hash);
    }
    hash = phone.sand.scene.hash();
  }
}

}  // namespace
}  // namespace sandglass::host
