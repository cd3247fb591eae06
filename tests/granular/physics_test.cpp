// Colliders and boundary particles act on sand. models/laboratory/sand compares single particles and piles with closed
// forms, and tests/laboratory/verify_test.cpp asserts these cases.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/granular/granular_scene.h"

namespace {

constexpr float k_frame = 0.02f;

TEST(Physics, AMovingColliderPushesSandAndAStillOneDoesNot) {
  for (const float speed : {0.0f, 0.2f}) {
    GranularScene scene(description(768));
    scene.add_floor();
    scene.colliders.push_back(sandglass::sphere(-0.06f, 0.05f, 0.08f, 0.04f));
    scene.colliders.back().linear_velocity[0] = speed;
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
  accept(scene.scene.set_boundary(ground));
  scene.add(lattice(4, 4, 4, 0.0204f, 0.05f));
  for (int frame = 0; frame < 100; ++frame) scene.frame(k_frame);
  const std::vector<float> p = scene.positions();
  for (size_t i = 1; i < p.size(); i += 3) EXPECT_GT(p[i], 0.010f) << "sunk between boundary particles";
}

}  // namespace
