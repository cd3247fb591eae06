// Physics of the particles against closed forms: one particle where a formula exists, small piles for
// invariants.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/granular/granular_scene.h"

namespace {

constexpr double k_gravity = 9.81;
constexpr float k_frame = 0.02f;

TEST(Physics, FreeFallIsSymplecticEuler) {
  GranularScene scene(description(1));
  scene.add({0.0f, 5.0f, 0.0f}, {1.0f, 2.0f, 0.0f});
  double x = 0, y = 5, vy = 2, time = 0;
  for (int frame = 0; frame < 25; ++frame) {
    const sandglass_frame_report report = scene.frame(k_frame);
    for (uint32_t s = 0; s < report.substeps; ++s) {
      vy -= k_gravity * static_cast<double>(report.substep);
      y += vy * static_cast<double>(report.substep);
      x += static_cast<double>(report.substep);
      time += static_cast<double>(report.substep);
    }
  }
  EXPECT_NEAR(time, 0.5, 1e-6);
  EXPECT_NEAR(scene.positions()[1], y, 1e-5 * 5.0);
  EXPECT_NEAR(scene.positions()[0], x, 1e-5);
  EXPECT_NEAR(scene.velocities()[1], vy, 1e-5 * std::fabs(vy));
}

// x = v0^2 / (2 mu g), within the half sub-step that any integrator of this order may be off.
double slide(float mu, float speed) {
  sandglass_scene_desc desc = description(1);
  desc.granular.static_friction = desc.granular.kinetic_friction = mu;
  GranularScene scene(desc);
  scene.add_floor();
  scene.add({0.0f, desc.granular.particle_radius, 0.0f}, {speed, 0.0f, 0.0f});
  for (int frame = 0; frame < 100; ++frame) scene.frame(k_frame);
  return static_cast<double>(scene.positions()[0]);
}

TEST(Physics, SlidingBlockStopsWhereCoulombSays) {
  const double step = 0.02 / 64.0;
  for (const float mu : {0.2f, 0.5f, 0.9f}) {
    const double truth = 1.0 / (2.0 * static_cast<double>(mu) * k_gravity);
    EXPECT_NEAR(slide(mu, 1.0f), truth, 1.05 * 1.0 * step / 2.0) << "mu " << mu;
  }
  // Negative control: another coefficient's distance is not within the bound.
  EXPECT_GT(std::fabs(slide(0.45f, 1.0f) - 1.0 / (2.0 * 0.5 * k_gravity)), 1.05 * step / 2.0);
}

// Distance a particle has slid down a plane of this slope after `frames`, metres.
double incline(float mu, double slope, int frames) {
  sandglass_scene_desc desc = description(1);
  desc.granular.static_friction = desc.granular.kinetic_friction = mu;
  const float r = desc.granular.particle_radius;
  GranularScene scene(desc);
  sandglass_collider plane = half_space(0.0f);
  plane.rotation[2] = static_cast<float>(std::sin(slope / 2));  // about z: the normal leans towards -x
  plane.rotation[3] = static_cast<float>(std::cos(slope / 2));
  scene.colliders.push_back(plane);
  const float nx = static_cast<float>(-std::sin(slope)), ny = static_cast<float>(std::cos(slope));
  scene.add({nx * r, ny * r, 0.0f});
  for (int frame = 0; frame < frames; ++frame) scene.frame(k_frame);
  const std::vector<float> p = scene.positions();
  return std::hypot(static_cast<double>(p[0] - nx * r), static_cast<double>(p[1] - ny * r));
}

TEST(Physics, InclineHoldsBelowTheFrictionAngleAndSlidesAbove) {
  const float mu = 0.5f;
  EXPECT_LE(incline(mu, std::atan(0.99 * 0.5), 250), 0.01 * 0.02) << "at most 1 % d in 5 s";
  const double slope = std::atan(1.05 * 0.5), time = 1.0;
  const double truth = 0.5 * k_gravity * (std::sin(slope) - 0.5 * std::cos(slope)) * time * time;
  EXPECT_NEAR(incline(mu, slope, 50), truth, 0.01 * truth + 1e-4);
}

TEST(Physics, CollisionsConserveMomentumWithoutHeightWeighting) {
  sandglass_scene_desc desc = description(64);
  desc.gravity[1] = 0.0f;
  desc.granular.height_weighting = 0.0f;
  GranularScene scene(desc);
  std::vector<float> positions = lattice(4, 4, 4, 0.0202f, 0.5f), velocities;
  for (uint32_t i = 0; i < 64; ++i) {
    for (int k = 0; k < 3; ++k)
      velocities.push_back(static_cast<float>((i * 2654435761u >> (8 * k)) % 256u) / 256.0f - 0.5f);
  }
  double before[3] = {}, after[3] = {}, speed = 0;
  scene.add(positions, velocities);
  for (int frame = 0; frame < 10; ++frame) scene.frame(k_frame);
  const std::vector<float> v = scene.velocities();
  for (uint32_t i = 0; i < 64; ++i) {
    for (uint32_t k = 0; k < 3; ++k)
      before[k] += static_cast<double>(velocities[3 * i + k]), after[k] += static_cast<double>(v[3 * i + k]);
    speed += std::fabs(static_cast<double>(velocities[3 * i]));
  }
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(after[k], before[k], 1e-4 * speed);
  EXPECT_NE(v, velocities) << "there were collisions";
}

// A pile of poured particles, 2 s after it was let go.
struct Pile {
  GranularScene scene;
  std::vector<float> p, v;
  explicit Pile(const sandglass_scene_desc& desc) : scene(desc) {
    scene.add_floor();
    std::vector<float> grains;
    const std::vector<float> particles = lattice(8, 12, 8, 0.0204f, 0.0102f);
    for (size_t i = 0; i < particles.size(); i += 3) {
      for (int g = 0; g < 4; ++g) {
        for (int k = 0; k < 3; ++k)
          grains.push_back(particles[i + static_cast<size_t>(k)] + 0.004f * static_cast<float>((g + k) % 3 - 1));
      }
    }
    scene.add(particles, {}, grains);
    for (int frame = 0; frame < 100; ++frame) scene.frame(k_frame);
    p = scene.positions();
    v = scene.velocities();
  }
};

// Rough sand, which stays a pile: overlap is what layers press into each other.
sandglass_scene_desc rough() {
  sandglass_scene_desc desc = description(768, 4096);
  desc.granular.static_friction = 0.6f, desc.granular.kinetic_friction = 0.55f;
  return desc;
}

TEST(Physics, APileRestsOnTheFloorWithoutOverlap) {
  Pile pile(rough());
  const float r = 0.01f;
  double sum = 0, largest = 0, contacts = 0, speed2 = 0;
  for (size_t i = 0; i < pile.p.size(); i += 3) {
    EXPECT_GE(pile.p[i + 1], 0.999f * r);
    for (size_t k = 0; k < 3; ++k) speed2 += static_cast<double>(pile.v[i + k]) * static_cast<double>(pile.v[i + k]);
    for (size_t j = i + 3; j < pile.p.size(); j += 3) {
      const double d = std::hypot(pile.p[i] - pile.p[j], pile.p[i + 1] - pile.p[j + 1], pile.p[i + 2] - pile.p[j + 2]);
      const double overlap = (2.0 * 0.01 - d) / 0.01;
      if (overlap > 0) sum += overlap, contacts += 1, largest = std::max(largest, overlap);
    }
  }
  EXPECT_LE(sum / contacts, 0.01);
  EXPECT_LE(largest, 0.10);
  EXPECT_LE(std::sqrt(speed2 / 768), 0.05 * std::sqrt(k_gravity * 0.02));
  for (const sandglass_grain& grain : pile.scene.grains) EXPECT_GE(grain.position[1], 0.0f);
}

TEST(Physics, AveragingWithoutSmallStepsLeavesOverlap) {
  // Negative control of the test above: one long averaged step a frame does not resolve the pile.
  sandglass_scene_desc desc = rough();
  desc.granular.reference.scheme = SANDGLASS_SCHEME_AVERAGED;
  desc.granular.reference.relaxation = 1.0f;
  desc.granular.substep_max = desc.granular.substep_min = 0.02f;
  desc.granular.courant = 1.0f;
  Pile pile(desc);
  double sum = 0, contacts = 0;
  for (size_t i = 0; i < pile.p.size(); i += 3) {
    for (size_t j = i + 3; j < pile.p.size(); j += 3) {
      const double d = std::hypot(pile.p[i] - pile.p[j], pile.p[i + 1] - pile.p[j + 1], pile.p[i + 2] - pile.p[j + 2]);
      if (d < 0.02) sum += (0.02 - d) / 0.01, contacts += 1;
    }
  }
  EXPECT_GT(sum / contacts, 0.01);
}

TEST(Physics, AMovingColliderPushesSandAndAStillOneDoesNot) {
  for (const float speed : {0.0f, 0.2f}) {
    GranularScene scene(description(768));
    scene.add_floor();
    sandglass_collider hand = {};
    hand.shape = SANDGLASS_SHAPE_SPHERE;
    hand.rotation[3] = 1.0f;
    hand.size[0] = 0.04f;
    hand.position[0] = -0.06f, hand.position[1] = 0.05f, hand.position[2] = 0.08f;
    hand.linear_velocity[0] = speed;
    scene.colliders.push_back(hand);
    scene.add(lattice(8, 6, 8, 0.0204f, 0.0102f));
    for (int frame = 0; frame < 50; ++frame) {
      scene.colliders[1].position[0] += speed * k_frame;
      scene.frame(k_frame);
    }
    const std::vector<float> p = scene.positions();
    double mean = 0;
    for (size_t i = 0; i < p.size(); i += 3) {
      mean += static_cast<double>(p[i]);
      const double d = std::hypot(p[i] - scene.colliders[1].position[0], p[i + 1] - 0.05f, p[i + 2] - 0.08f);
      EXPECT_GE(d, 0.0499) << "no particle inside the hand";
    }
    mean /= 384.0;
    if (speed > 0) EXPECT_GT(mean, 0.09);
    else EXPECT_LT(mean, 0.09);
  }
}

TEST(Physics, BoundaryParticlesHoldSand) {
  GranularScene scene(description(64, 0, 1600));
  std::vector<float> ground;
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 40; ++k)
      ground.insert(ground.end(), {0.015f * static_cast<float>(i - 20), 0.0f, 0.015f * static_cast<float>(k - 20)});
  }
  const char* reason = nullptr;
  ASSERT_EQ(sandglass_granular_set_boundary(scene.scene, ground.data(), 1600, &reason), SANDGLASS_OK) << reason;
  scene.add(lattice(4, 4, 4, 0.0204f, 0.05f));
  for (int frame = 0; frame < 100; ++frame) scene.frame(k_frame);
  const std::vector<float> p = scene.positions();
  for (size_t i = 1; i < p.size(); i += 3) EXPECT_GT(p[i], 0.010f) << "sunk between boundary particles";
}

}  // namespace
