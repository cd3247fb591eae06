// Random scenes, with what must hold in every frame of any of them: all numbers are finite, no sand is below the floor,
// nothing is faster than the CFL limit allows, nothing is lost or made, the budget's law and the ledger of time hold,
// and no byte outside the scene's block and the app's buffer is touched. Every fourth scene is replayed from its plans,
// on the scalar kernels and without clock and pool, to the same bits.
//
//   SANDGLASS_SCENES=10000 SANDGLASS_SCENES_STATE=state sandglass_random_scenes_tests
//
// runs so many, and goes on where it was interrupted; the state's file names those that failed. SANDGLASS_SCENE=N runs
// the scene N alone.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <string>

#include "tests/granular/random_scene.h"

namespace sandglass::tests {
namespace {

constexpr uint64_t k_scenes = 20;  // in an ordinary run of the tests

// What is wrong after a frame; empty: nothing.
class Invariants {
 public:
  explicit Invariants(const RandomScene& scene) : s_(scene) {}

  std::string broken(const sandglass_frame_report& report) {
    const uint64_t late = report.elapsed_ns > report.last_unit_ns ? report.elapsed_ns - report.last_unit_ns : 0;
    if (report.clock_fault == 0 && late > std::max(report.target_ns, report.mandatory_ns))
      return "the law of the budget";
    if (report.quarantined != 0) return "something was quarantined";
    if (report.particles != s_.particles_added + report.emitted_particles - report.removed_particles)
      return "particles were lost or made";
    if (report.grains != s_.grains_added + report.emitted_grains - report.removed_grains)
      return "grains were lost or made";
    if (std::fabs(report.simulated_time + report.time_debt - s_.asked) > 1e-6 * (1.0 + s_.asked))
      return "the ledger of time";
    if (!(report.time_debt >= 0.0) || !(report.grain_lag >= 0.0f)) return "a debt below 0";
    if (!s_.block.guards_intact() || !s_.drawn.guards_intact()) return "a byte outside was touched";
    const std::string sand = particles(report);
    return sand.empty() ? grains(report) : sand;
  }

 private:
  static bool finite(const float* v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

  std::string particles(const sandglass_frame_report& report) {
    const sandglass_granular_desc& g = s_.desc.granular;
    positions_.resize(3ull * report.particle_numbers), velocities_.resize(3ull * report.particle_numbers);
    sandglass_granular_particles(s_.scene.get(), positions_.data(), velocities_.data());
    // The limit of a pass, on which a body's rotation comes. Sand of the app or of a nozzle has its own speed at first.
    const double fastest =
        1.001 * static_cast<double>(g.courant * g.particle_radius) / static_cast<double>(report.substep);
    const float low = g.particle_radius * (1.0f - 1e-3f);
    for (uint32_t i = 0; i < report.particle_numbers; ++i) {
      const float *p = &positions_[3 * i], *v = &velocities_[3 * i];
      if (!finite(p) || !finite(v)) return "particle " + std::to_string(i) + " is not finite";
      if (p[1] == SANDGLASS_REMOVED_Y) continue;
      const bool body = i < s_.in_bodies;
      if (p[1] < (body ? -g.particle_radius : low))
        return "particle " + std::to_string(i) + " is below the floor, y = " + std::to_string(p[1]) + " m";
      const double speed = std::hypot(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2]));
      if (report.substeps != 0 && speed > (body ? 3.0 * fastest : std::max(fastest, k_given))) {
        return "particle " + std::to_string(i) + " is too fast: " + std::to_string(speed) + " of " +
               std::to_string(fastest) + " m/s";
      }
    }
    return "";
  }

  std::string grains(const sandglass_frame_report& report) {
    positions_.resize(3ull * report.grain_numbers), velocities_.resize(3ull * report.grain_numbers);
    if (report.grain_numbers == 0) return "";
    sandglass_granular_grains(s_.scene.get(), positions_.data(), velocities_.data());
    for (uint32_t i = 0; i < report.grain_numbers; ++i) {
      const float *p = &positions_[3 * i], *v = &velocities_[3 * i];
      if (!finite(p) || !finite(v)) return "grain " + std::to_string(i) + " is not finite";
      if (s_.grains_have_floor && p[1] != SANDGLASS_REMOVED_Y && p[1] < 0.0f)
        return "grain " + std::to_string(i) + " is below the floor, y = " + std::to_string(p[1]) + " m";
    }
    return "";
  }

  static constexpr double k_given = 3.0;  // m/s: the speed that sand of the app and of nozzles has at most
  const RandomScene& s_;
  std::vector<float> positions_, velocities_;
};

std::string frames_of(uint64_t number) {
  RandomScene s(number);
  Invariants invariants(s);
  std::vector<sandglass_plan> plans;
  for (uint32_t frame = 0; frame < s.frames; ++frame) {
    const sandglass_frame_input input = s.next_input();
    sandglass_frame_report report = frame_report();
    const Status status = s.scene.frame(input, &report);
    const std::string what = status ? invariants.broken(report) : status.reason;
    if (!what.empty()) return "frame " + std::to_string(frame) + ": " + what;
    plans.push_back(report.plan);
  }
  if (number % 4 != 0) return "";
  RandomScene again(number, true);
  for (const sandglass_plan& plan : plans) {
    sandglass_frame_input input = again.next_input();
    input.plan = &plan;
    const Status status = again.scene.frame(input);
    if (!status) return std::string("replay: ") + status.reason;
  }
  return again.scene.hash() == s.scene.hash() ? "" : "the replay ends in other bits";
}

// Runs the scene. Says what was wrong first; empty: nothing.
std::string run_scene(uint64_t number) {
  try {
    return frames_of(number);
  } catch (const std::exception& refused) {
    return refused.what();
  }
}

uint64_t number_of(const char* variable, uint64_t otherwise) {
  const char* text = std::getenv(variable);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

TEST(RandomScenes, KeepEveryInvariant) {
  if (std::getenv("SANDGLASS_SCENE") != nullptr) {
    EXPECT_EQ(run_scene(number_of("SANDGLASS_SCENE", 0)), "");
    return;
  }
  const char* path = std::getenv("SANDGLASS_SCENES_STATE");
  uint64_t first = 0;
  std::string failed, word;
  if (path != nullptr) {
    std::ifstream file(path);
    file >> first;
    while (file >> word) failed += " " + word;
  }
  const uint64_t scenes = number_of("SANDGLASS_SCENES", k_scenes);
  for (uint64_t number = first; number < scenes; ++number) {
    const std::string what = run_scene(number);
    EXPECT_EQ(what, "") << "scene " << number;
    if (!what.empty()) failed += " " + std::to_string(number);
    if (path != nullptr) std::ofstream(path) << number + 1 << failed << "\n";
  }
  EXPECT_EQ(failed, "") << "scenes that failed, those of earlier runs with this state included";
  std::printf("scenes %llu to %llu\n", static_cast<unsigned long long>(first), static_cast<unsigned long long>(scenes));
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
    input.collider_count = 0, input.time_step = 0.02f, input.budget_ns = ~0ull >> 1;
    s.asked = asked + static_cast<double>(input.time_step);
    sandglass_frame_report report = frame_report();
    ASSERT_TRUE(s.scene.frame(input, &report));
    if (invariants.broken(report).find("below the floor") != std::string::npos) return;
  }
  FAIL() << "nothing was found";
}

}  // namespace
}  // namespace sandglass::tests
