// What must not break a scene: an impact, capacities, damaged memory. More hard cases are in
// tests/laboratory/sand/physics_cases.h, which tests/laboratory/verify_test.cpp asserts.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "kernels/particle.h"
#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_frame = 0.02f;
constexpr float k_nan = std::numeric_limits<float>::quiet_NaN(), k_infinity = std::numeric_limits<float>::infinity();

// A cylinder of close-packed sand hits the floor at 5 m/s with the default settings. Contacts by position are plastic.
// A coefficient of restitution of e = 0.2 is already far beyond them, and it would bounce to e^2 of the height v^2/2g.
// No particle may leave faster than two equal spheres could throw it, at twice the speed of impact. (Without the limit
// on separation the centre of mass rises by 0.054 m. Without the cap on height weighting as well, it rises by 0.58 m.)
TEST(HardCase, AnImpactThrowsNothing) {
  constexpr double k_speed = 5.0;
  constexpr float k_spacing = 0.0202f;
  std::vector<float> body, down;
  for (int layer = 0; layer < 12; ++layer) {
    for (int row = -8; row <= 8; ++row) {
      for (int i = -8; i <= 8; ++i) {
        const float x = k_spacing * (static_cast<float>(i) + 0.5f * static_cast<float>((row + layer) & 1));
        const float z = k_spacing * 0.8660254f * (static_cast<float>(row) + static_cast<float>(layer & 1) / 3.0f);
        if (std::hypot(x, z) >= 0.1f) continue;
        body.insert(body.end(), {x, 0.05f + k_spacing * 0.8164966f * static_cast<float>(layer), z});
        down.insert(down.end(), {0.0f, static_cast<float>(-k_speed), 0.0f});
      }
    }
  }
  const double count = static_cast<double>(body.size() / 3);
  GranularScene scene(description(static_cast<uint32_t>(body.size() / 3)));
  scene.add_floor();
  scene.add(body, down);
  double lowest = 1e9, rise = 0.0, fastest = 0.0;
  for (int frame = 0; frame < 60; ++frame) {
    fastest = std::max(fastest, static_cast<double>(scene.frame(k_frame).sand.speed_max));
    double height = 0.0;
    const std::vector<float> p = scene.positions();
    for (size_t i = 1; i < p.size(); i += 3) height += static_cast<double>(p[i]) / count;
    lowest = std::min(lowest, height);
    rise = std::max(rise, height - lowest);
  }
  EXPECT_LT(rise, 0.04 * k_speed * k_speed / (2.0 * 9.81));
  EXPECT_LT(fastest, 2.0 * k_speed);
}

// A block of sand, and a wall beside it. A work unit takes 20 microseconds.
struct WallScene {
  WallScene()
      : scene([&] {
          sandglass_scene_desc desc = description(512);
          desc.clock = {[](void* user) { return *static_cast<uint64_t*>(user); }, &now};
          desc.trace = {nullptr, [](void* user, const char*) { *static_cast<uint64_t*>(user) += 20'000; }, &now};
          desc.finest_level = SANDGLASS_LEVEL_COARSER;
          return desc;
        }()) {
    scene.add_floor();
    scene.add(lattice(8, 8, 8, 0.0202f, 0.01f));
    scene.colliders.push_back(sandglass::box(-0.07f, 0.1f, 0.08f, 0.05f, 0.1f, 0.2f));
    for (int frame = 0; frame < 20; ++frame) enough = scene.frame(k_frame).time.elapsed_ns;
  }
  // A frame in which the wall goes on at this speed.
  sandglass_frame_report push(float speed, float seconds, uint64_t budget) {
    scene.colliders[1].position[0] += speed * seconds;
    scene.colliders[1].linear_velocity[0] = speed;
    return scene.frame(seconds, budget);
  }
  uint64_t now = 0, enough = 0;
  GranularScene scene;
};

// A wall pushes sand at 1 m/s under a budget that leaves a time debt, and stops from one frame to the next. It goes what
// is left of its way with the simulated time that is left. So in simulated time it is faster by the share of time that
// is simulated, before and after the stop. Nothing becomes faster than sand that such a wall pushes without time debt.
// (A wall that jumps at each frame's begin throws sand at the limit of (4.45), at 9 m/s.)
TEST(HardCase, AWallThatStopsUnderTimeDebtThrowsNothing) {
  WallScene wall;
  constexpr float k_speed = 1.0f;
  float pushing = 0.0f, stopped = 0.0f;
  double simulated = 0.0;
  for (int frame = 0; frame < 16; ++frame) {
    const bool moves = frame < 10;
    const sandglass_frame_report report = wall.push(moves ? k_speed : 0.0f, k_frame, wall.enough / 2);
    if (frame == 0) simulated -= report.time.simulated;
    if (frame == 9) simulated += report.time.simulated;
    EXPECT_GT(report.time.debt, 0.0) << frame;
    float& fastest = moves ? pushing : stopped;
    fastest = std::max(fastest, report.sand.speed_max);
  }
  const float share = static_cast<float>(simulated / (9 * static_cast<double>(k_frame)));
  EXPECT_LT(share, 0.9f);
  WallScene free;
  float speed_max = 0.0f;
  for (int frame = 0; frame < 10; ++frame)
    speed_max = std::max(speed_max, free.push(k_speed / share, k_frame * share, ~uint64_t{0} >> 1).sand.speed_max);
  std::printf("%.2f of the time simulated; fastest %.2f m/s, after the stop %.2f m/s; without time debt %.2f m/s\n",
              static_cast<double>(share), static_cast<double>(pushing), static_cast<double>(stopped),
              static_cast<double>(speed_max));
  EXPECT_GT(pushing, k_speed);
  EXPECT_LE(pushing, speed_max);
  EXPECT_LE(stopped, speed_max);
}

// Under a time debt a wall jumps by 50 mm and tells 1 m/s. It goes the new frame's way of 20 mm in all of the time left.
// The control is its velocity as told: that is further.
TEST(HardCase, AWallThatJumpsUnderTimeDebtComesFromNearby) {
  WallScene wall;
  sandglass_frame_report report = {};
  for (int frame = 0; frame < 6; ++frame) report = wall.push(0.0f, k_frame, wall.enough / 8);
  const double debt = std::fmin(report.time.debt + static_cast<double>(k_frame), 0.04);  // two frames' at most
  wall.scene.colliders[1].position[0] += 0.05f;
  wall.scene.colliders[1].linear_velocity[0] = 1.0f;
  wall.scene.frame(k_frame, wall.enough / 8);
  sandglass_collider met = {};
  ASSERT_TRUE(wall.scene.scene.held_collider(1, &met));
  EXPECT_LE(static_cast<double>(met.linear_velocity[0]) * debt, 1.01 * static_cast<double>(k_frame));
  EXPECT_GT(1.0 * debt, 1.5 * static_cast<double>(k_frame)) << "the control";
}

TEST(HardCase, ADamagedParticleIsQuarantinedWithinOneFrame) {
  for (const float damage : {k_nan, k_infinity}) {
    const sandglass_scene_desc desc = description(384);
    const uint64_t bytes = sandglass::Scene::bytes(desc);
    const sandglass::Block block = sandglass::allocate_block(bytes);
    GranularScene scene(desc);
    accept(scene.scene.create_in(desc, block.get(), bytes));
    scene.add_floor();
    scene.add(lattice(8, 6, 8, 0.0204f, 0.0102f));
    scene.frame(k_frame);
    std::vector<sandglass_region> regions(sandglass_scene_regions(scene.scene.get(), nullptr, 0));
    sandglass_scene_regions(scene.scene.get(), regions.data(), static_cast<uint32_t>(regions.size()));
    bool found = false;
    for (const sandglass_region& region : regions) {
      if (std::strcmp(region.name, "granular.particles") != 0 &&
          std::strcmp(region.name, "granular.particles_next") != 0)
        continue;
      auto* particles = reinterpret_cast<sandglass::Particle*>(block.get() + region.offset);
      particles[100].position[1] = damage;  // in whichever buffer holds the state
      found = true;
    }
    ASSERT_TRUE(found);
    EXPECT_GE(scene.frame(k_frame).sand.quarantined, 1u);
    for (int frame = 0; frame < 20; ++frame) EXPECT_EQ(scene.frame(k_frame).sand.quarantined, 0u);
    for (const float x : scene.positions()) ASSERT_LE(std::fabs(x), 50.0f);
    for (const float v : scene.velocities()) ASSERT_TRUE(std::isfinite(v));
  }
}

TEST(HardCase, AnEmptySceneRunsAndAFullOneRefusesAndStaysAsItIs) {
  GranularScene scene(description(27, 8));
  const auto status_of = [&](const std::array<float, 3>& particle, const float* velocity,
                             const float* grain) -> sandglass_status {
    const char* reason = nullptr;
    const sandglass_points particles = {particle.data(), velocity, 1}, grains = {grain, nullptr, 1};
    const sandglass_status status =
        sandglass_scene_add(scene.scene.get(), &particles, grain == nullptr ? nullptr : &grains, &reason);
    EXPECT_EQ(reason == nullptr, status == SANDGLASS_OK);
    return status;
  };
  scene.add_floor();
  EXPECT_EQ(scene.frame(k_frame).sand.particles, 0u);
  uint64_t hash = scene.hash();
  for (const float bad : {k_nan, k_infinity, 1.01f * SANDGLASS_COORDINATE_LIMIT}) {
    const float place[3] = {0.0f, bad, 0.0f};
    EXPECT_EQ(status_of({0.0f, bad, 0.0f}, nullptr, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT) << bad;
    EXPECT_EQ(status_of({0.0f, 1.0f, 0.0f}, nullptr, place), SANDGLASS_ERROR_INVALID_ARGUMENT) << bad;
  }
  const float velocity[3] = {k_nan, 0.0f, 0.0f};
  EXPECT_EQ(status_of({0.0f, 1.0f, 0.0f}, velocity, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(scene.hash(), hash) << "nothing was added";
  scene.add(lattice(3, 3, 3, 0.0204f, 0.0102f));  // the last place counts
  EXPECT_EQ(scene.frame(k_frame).sand.particles, 27u);
  hash = scene.hash();
  EXPECT_EQ(status_of({0.0f, 1.0f, 0.0f}, nullptr, nullptr), SANDGLASS_ERROR_CAPACITY);
  EXPECT_EQ(scene.hash(), hash);
}

// Sub-steps of 1e-11 s would be ten billion a frame; more do not fit a counter.
TEST(HardCase, SubStepsHaveALowerBound) {
  sandglass::Scene scene;
  for (const float seconds : {1e-11f, 1e-30f, 9e-7f, -1e-3f, NAN}) {
    for (float sandglass_granular_desc::*field :
         {&sandglass_granular_desc::substep_max, &sandglass_granular_desc::substep_min}) {
      sandglass_scene_desc desc = description(8);
      desc.granular.*field = seconds;
      EXPECT_FALSE(scene.create(desc)) << seconds;
    }
  }
  for (const float seconds : {0.0f, 1e-6f, 0.1f}) {
    sandglass_scene_desc desc = description(8);
    desc.granular.substep_max = seconds;
    accept(scene.create(desc));
  }
}

// A frame that nothing else bounds ends: a tenth of a second in microseconds would take ten times as long.
TEST(HardCase, AFrameHasAtMostTenThousandSubSteps) {
  sandglass_scene_desc desc = description(8);
  desc.granular.substep_max = 1e-6f;
  GranularScene scene(desc);
  scene.add({0.0f, 1.0f, 0.0f});
  const sandglass_frame_report report = scene.frame(0.1f);
  EXPECT_EQ(report.sand.substeps, 10000u);
  EXPECT_NEAR(report.time.simulated, 0.1, 1e-6);
}

}  // namespace
