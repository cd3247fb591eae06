// Random scenes, with what must hold in every frame of any of them (Invariants). Every fourth scene is replayed from its
// plans, on the scalar kernels and without clock and pool, to the same bits.
//
// SANDGLASS_SCENES=10000 runs so many, SANDGLASS_SCENE=N the scene N alone, SANDGLASS_FRAMES=1000000 for so long.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <string>

#include "tests/sand/random_scene.h"

namespace sandglass::tests {
namespace {

bool finite(const float* v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

// m/s: the speed that sand of the app and of nozzles has at most.
constexpr double k_given_speed = 3.0;

// What must hold after every frame of any scene above a floor at y = 0: all numbers are finite, no sand is below the
// floor, nothing is faster than the CFL limit allows, nothing is lost or made, the budget's law and the ledger of time
// hold, and no byte outside the scene's block and the app's buffer is touched.
class Invariants {
 public:
  explicit Invariants(const RandomScene& scene) : s_(scene) {}

  // What is wrong after a frame; empty: nothing.
  std::string broken(const sandglass_frame_report& report);

 private:
  std::string particles(const sandglass_frame_report& report);
  bool alone(uint32_t particle, uint32_t count) const;
  std::string grains(const sandglass_frame_report& report);

  const RandomScene& s_;
  float substep_before_ = 0.0f;  // of the last report
  std::vector<float> positions_, velocities_;
};

std::string Invariants::broken(const sandglass_frame_report& report) {
  const sandglass_time_report& t = report.time;
  const uint64_t late = t.elapsed_ns > t.last_unit_ns ? t.elapsed_ns - t.last_unit_ns : 0;
  if (t.clock_fault == 0 && late > std::max(t.target_ns, t.mandatory_ns)) return "the law of the budget";
  if (report.sand.quarantined != 0) return "something was quarantined";
  if (report.sand.particles != s_.particles_added + report.sand.emitted_particles - report.sand.removed_particles)
    return "particles were lost or made";
  if (report.sand.grains != s_.grains_added + report.sand.emitted_grains - report.sand.removed_grains)
    return "grains were lost or made";
  if (std::fabs(report.time.simulated + report.time.debt - s_.asked) > 1e-6 * (1.0 + s_.asked))
    return "the ledger of time";
  if (!(report.time.debt >= 0.0) || !(report.sand.grain_lag >= 0.0f)) return "a debt below 0";
  if (!s_.block.guards_intact() || !s_.drawn.guards_intact()) return "a byte outside was touched";
  const std::string sand = particles(report);
  return sand.empty() ? grains(report) : sand;
}

std::string Invariants::particles(const sandglass_frame_report& report) {
  const sandglass_granular_desc& g = s_.desc.granular;
  positions_.resize(3ull * report.sand.particle_numbers);
  velocities_.resize(3ull * report.sand.particle_numbers);
  sandglass_scene_particles(s_.scene.get(), positions_.data(), velocities_.data());
  // The limit of a pass, on which a body's rotation comes. Sand of the app or of a nozzle has its own speed at first. The
  // report's sub-step may have just begun: speeds are then of the one before.
  const float substep = substep_before_ > 0.0f ? std::min(report.sand.substep, substep_before_) : report.sand.substep;
  substep_before_ = report.sand.substep;
  const double fastest = 1.001 * static_cast<double>(g.courant * g.particle_radius) / static_cast<double>(substep);
  const float low = g.particle_radius * (1.0f - 1e-3f);
  // granular.courant: what can reach nothing is not slowed, as long as there are at most 64.
  uint32_t far_and_fast = 0;
  for (uint32_t i = 0; i < report.sand.particle_numbers; ++i) {
    const float *p = &positions_[3 * i], *v = &velocities_[3 * i];
    if (!finite(p) || !finite(v)) return "particle " + std::to_string(i) + " is not finite";
    if (p[1] == SANDGLASS_REMOVED_Y) continue;
    const bool body = i < s_.in_bodies;
    if (p[1] < (body ? -g.particle_radius : low) && !(body && !s_.bodies_have_floor))
      return "particle " + std::to_string(i) + " is below the floor, y = " + std::to_string(p[1]) + " m";
    const double speed = std::hypot(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2]));
    if (report.sand.substeps != 0 && speed > (body ? 3.0 * fastest : std::max(fastest, k_given_speed)) &&
        (body || ++far_and_fast > 64 || !alone(i, report.sand.particle_numbers))) {
      return "particle " + std::to_string(i) + " is too fast: " + std::to_string(speed) + " of " +
             std::to_string(fastest) + " m/s";
    }
  }
  return "";
}

// No other particle within the reach of a neighbour list.
bool Invariants::alone(uint32_t particle, uint32_t count) const {
  const float reach = (2.0f + s_.desc.granular.list_margin) * s_.desc.granular.particle_radius;
  const float* p = &positions_[3 * particle];
  for (uint32_t i = 0; i < count; ++i) {
    const float* q = &positions_[3 * i];
    if (i != particle && std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) < reach) return false;
  }
  return true;
}

std::string Invariants::grains(const sandglass_frame_report& report) {
  positions_.resize(3ull * report.sand.grain_numbers);
  velocities_.resize(3ull * report.sand.grain_numbers);
  if (report.sand.grain_numbers == 0) return "";
  sandglass_scene_grains(s_.scene.get(), positions_.data(), velocities_.data());
  for (uint32_t i = 0; i < report.sand.grain_numbers; ++i) {
    const float *p = &positions_[3 * i], *v = &velocities_[3 * i];
    if (!finite(p) || !finite(v)) return "grain " + std::to_string(i) + " is not finite";
    if (s_.grains_have_floor && p[1] != SANDGLASS_REMOVED_Y && p[1] < 0.0f)
      return "grain " + std::to_string(i) + " is below the floor, y = " + std::to_string(p[1]) + " m";
  }
  return "";
}

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
