// Random scenes, with what must hold in every frame of any of them (invariants.h). Every fourth scene is replayed from its
// plans, on the scalar kernels and without clock and pool, to the same bits.
//
// SANDGLASS_SCENES=10000 runs so many, SANDGLASS_SCENE=N the scene N alone, SANDGLASS_FRAMES=1000000 for so long.
#include <gtest/gtest.h>

#include <cstdlib>
#include <exception>
#include <string>

#include "tests/sand/invariants.h"
#include "tests/sand/random_scene.h"

namespace sandglass::tests {
namespace {

constexpr uint64_t k_scenes = 20;  // in an ordinary run of the tests
uint64_t g_units[SANDGLASS_STAGE_COUNT];

uint64_t number_of(const char* variable, uint64_t otherwise) {
  const char* text = std::getenv(variable);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

std::string frames_of(uint64_t number) {
  RandomScene s(number);
  Invariants invariants(s);
  std::vector<sandglass_plan> plans;
  const uint64_t frames = number_of("SANDGLASS_FRAMES", s.frames);
  for (uint64_t frame = 0; frame < frames; ++frame) {
    const sandglass_frame_input input = s.next_input();
    sandglass_frame_report report = frame_report();
    const Status status = s.scene.frame(input, &report);
    std::string what = status ? invariants.broken(report) : status.reason;
    if (what.empty() && s.shadow && !s.shadow->block.guards_intact()) what = "a byte outside the shadow was touched";
    if (!what.empty()) return "frame " + std::to_string(frame) + ": " + what;
    plans.push_back(report.plan);
    for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage) g_units[stage] += report.stages[stage].units;
  }
  if (number % 4 != 0) return "";
  RandomScene again(number, true);
  for (const sandglass_plan& plan : plans) {
    sandglass_frame_input input = again.next_input();
    input.plan = &plan;
    const Status status = again.scene.frame(input);
    if (!status) return std::string("replay: ") + status.reason;
  }
  return again.hash() == s.hash() ? "" : "the replay ends in other bits";
}

// Runs the scene. Says what was wrong first; empty: nothing.
std::string run_scene(uint64_t number) {
  try {
    return frames_of(number);
  } catch (const std::exception& refused) {
    return refused.what();
  }
}

TEST(RandomScenes, KeepEveryInvariant) {
  if (std::getenv("SANDGLASS_SCENE") != nullptr) {
    EXPECT_EQ(run_scene(number_of("SANDGLASS_SCENE", 0)), "");
    return;
  }
  const uint64_t scenes = number_of("SANDGLASS_SCENES", k_scenes);
  for (uint64_t number = 0; number < scenes; ++number) EXPECT_EQ(run_scene(number), "") << "scene " << number;
  for (const uint64_t units : g_units) EXPECT_GT(units, 0u) << "a stage had no work in any scene";
}

// What a scene saves, in whatever state a budget left it, one of its description accepts: in the midst of a list
// build, too, and where lists were built more often than once a sub-step.
TEST(RandomScenes, AreRestoredFromWhatTheySavedAfterAnyFrame) {
  for (uint64_t number = 0; number < 12; ++number) {
    RandomScene s(number);
    Scene other;
    ASSERT_TRUE(other.create(s.desc));
    for (uint32_t frame = 0; frame < s.frames; ++frame) {
      const sandglass_frame_input input = s.next_input();
      std::vector<std::byte> saved;
      ASSERT_TRUE(s.scene.frame(input) && s.scene.save(&saved));
      const Status restored = other.restore(saved);
      ASSERT_TRUE(restored) << "scene " << number << ", frame " << frame << ": " << restored.reason;
      ASSERT_EQ(other.hash(), s.scene.hash()) << "scene " << number << ", frame " << frame;
    }
  }
}

// The control: sand below a floor that was forgotten is found.
TEST(RandomScenes, AForgottenFloorIsFound) {
  RandomScene s(0);
  Invariants invariants(s);
  for (uint32_t frame = 0; frame < 200; ++frame) {
    const double asked = s.asked;
    sandglass_frame_input input = s.next_input();
    input.collider_count = 0;
    input.time_step = 0.02f;
    input.budget_ns = ~0ull >> 1;
    s.asked = asked + static_cast<double>(input.time_step);
    sandglass_frame_report report = frame_report();
    ASSERT_TRUE(s.scene.frame(input, &report));
    if (invariants.broken(report).find("below the floor") != std::string::npos) return;
  }
  FAIL() << "nothing was found";
}

}  // namespace
}  // namespace sandglass::tests
