// Sand for the tests of its shadow and of its light: grains that lie in a shape, scattered grains, and sand that falls
// in a scene.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "sandglass/sandglass.hpp"

namespace sandglass::tests {

constexpr float k_grain = 0.0035f;  // radius of grains; a texel is larger

// A hexagonal lattice of spheres in `inside`.
inline std::vector<float> spheres_in(const std::function<bool(const float*)>& inside, float radius, float reach,
                                     float height) {
  std::vector<float> points;
  EXPECT_TRUE(sample_lattice(Box{{-reach, radius, -reach}, {reach, height, reach}}, 2 * radius, inside, &points));
  return points;
}

// 700 grains on the floor, less than one a texel.
inline std::vector<float> scattered() {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<float> grains;
  while (grains.size() < 3 * 700) {
    const float x = 0.15f * unit(random), z = 0.15f * unit(random);
    if (std::hypot(x, z) < 0.15f) grains.insert(grains.end(), {x, k_grain, z});
  }
  return grains;
}

// A scene with a floor, in frames of 1/60 s with time for all of their work.
struct SandOnTheFloor {
  Scene scene;
  sandglass_collider floor = floor_at(0);
  sandglass_frame_input input = frame_input();
  sandglass_frame_report report = frame_report();

  explicit SandOnTheFloor(sandglass_scene_desc desc) {
    desc.granular.collider_capacity = 1;
    EXPECT_TRUE(scene.create(desc));
    input.time_step = 1.0f / 60.0f;
    input.budget_ns = UINT64_MAX;
    input.colliders = &floor;
    input.collider_count = 1;
  }
  void frame() { EXPECT_TRUE(scene.frame(input, &report)); }
};

}  // namespace sandglass::tests
