// Grains keep an even density, in flow and at rest. A heap collapses and comes to rest; inside it the number of grains
// in a small sphere varies less than that of random points, and neighbours keep a distance.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <unordered_map>

#include "tests/granular/granular_scene.h"

namespace {

constexpr float k_radius = 0.01f;
constexpr float k_probe = 0.7f * k_radius;  // radius of the spheres in which grains are counted

struct Evenness {
  double variation;  // of the number in a sphere, over that of as many random points
  double nearest;    // median distance of the nearest neighbour, grain radii
};

// Points by cell, so that those near a place are found.
class Cells {
 public:
  Cells(const std::vector<float>& points, float edge) : points_(points), edge_(edge) {
    for (size_t i = 0; i < points.size(); i += 3) cells_[key(&points[i], 0, 0, 0)].push_back(i);
  }
  // Calls visit(squared distance, point) for the points within an edge, and some others.
  template <class Visit>
  void near(const float* at, const Visit& visit) const {
    for (int c = 0; c < 27; ++c) {
      const auto cell = cells_.find(key(at, c % 3 - 1, c / 3 % 3 - 1, c / 9 - 1));
      if (cell == cells_.end()) continue;
      for (const size_t i : cell->second) {
        double squared = 0;
        for (size_t k = 0; k < 3; ++k) squared += std::pow(static_cast<double>(points_[i + k] - at[k]), 2);
        visit(squared, &points_[i]);
      }
    }
  }

 private:
  uint64_t key(const float* at, int x, int y, int z) const {
    const auto along = [&](int k, int beside) {
      return static_cast<uint64_t>(static_cast<int64_t>(std::floor(at[k] / edge_)) + beside + (1 << 20));
    };
    return along(0, x) << 42 | along(1, y) << 21 | along(2, z);
  }
  const std::vector<float>& points_;
  float edge_;
  std::unordered_map<uint64_t, std::vector<size_t>> cells_;
};

// Spheres inside: with particles on all sides within 3 r, and away from the floor.
Evenness evenness(const std::vector<float>& particles, const std::vector<float>& grains, double grain_radius) {
  const Cells about(particles, 3.0f * k_radius), near(grains, k_probe);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  std::vector<double> numbers;
  for (int tries = 0; numbers.size() < 2000 && tries < 200000; ++tries) {
    const float* particle = &particles[random() % (particles.size() / 3) * 3];
    const float at[3] = {particle[0] + k_radius * unit(random), particle[1] + k_radius * unit(random),
                         particle[2] + k_radius * unit(random)};
    if (at[1] < 1.5f * k_radius) continue;
    uint32_t sides = 0;
    about.near(at, [&](double squared, const float* p) {
      if (squared < 9e-4) sides |= 1u << ((p[0] > at[0]) + 2 * (p[1] > at[1]) + 4 * (p[2] > at[2]));
    });
    if (sides != 255) continue;
    double number = 0;
    near.near(at, [&](double squared, const float*) { number += std::sqrt(squared) < static_cast<double>(k_probe); });
    numbers.push_back(number);
  }
  EXPECT_EQ(numbers.size(), 2000u);
  double mean = 0, variance = 0;
  for (const double n : numbers) mean += n / 2000;
  for (const double n : numbers) variance += (n - mean) * (n - mean) / 2000;
  std::vector<double> nearest;
  for (size_t i = 0; i < grains.size(); i += 3) {
    double least = static_cast<double>(k_probe) * static_cast<double>(k_probe);
    near.near(&grains[i], [&](double squared, const float* p) {
      if (p != &grains[i]) least = std::min(least, squared);
    });
    nearest.push_back(std::sqrt(least) / grain_radius);
  }
  std::nth_element(nearest.begin(), nearest.begin() + nearest.size() / 2, nearest.end());
  std::printf("variation %.2f of random points, nearest %.2f radii\n", std::sqrt(variance / mean),
              nearest[nearest.size() / 2]);
  return {std::sqrt(variance / mean), nearest[nearest.size() / 2]};  // of random points the variance is the mean
}

// For full quality, for quality level 3, and for slow motion.
enum class Budget { plenty, coarser, slow };

// 1,560 particles collapse for 1.5 s of simulated time; a grain every `edge` metres.
Evenness heap(float edge, uint32_t blend, Budget budget = Budget::plenty) {
  std::vector<float> particles, grains;
  const sandglass::Box box{{-0.10f, k_radius, -0.10f}, {0.10f, 0.21f, 0.10f}};
  accept(sandglass::sample_lattice(
      box, 2.02f * k_radius, [](const float*) { return true; }, &particles));
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0.0f, 0.5f);
  for (float y = box.min[1]; y < box.max[1]; y += edge) {
    for (float z = box.min[2]; z < box.max[2]; z += edge) {
      for (float x = box.min[0]; x < box.max[0]; x += edge) {
        for (const float at : {x, y, z}) grains.push_back(at + edge * unit(random));
      }
    }
  }
  const uint32_t count = static_cast<uint32_t>(grains.size() / 3);
  sandglass_scene_desc desc = description(static_cast<uint32_t>(particles.size() / 3), count);
  desc.granular.grain_radius = 0.35f * k_radius * std::cbrt(27000.0f / static_cast<float>(count));
  desc.granular.static_friction = 0.6f, desc.granular.kinetic_friction = 0.55f;  // else it spreads to a carpet
  desc.granular.reference.blend = blend;
  uint64_t now = 0;
  if (budget != Budget::plenty) desc.finest_level = SANDGLASS_LEVEL_COARSER;
  if (budget == Budget::slow) {
    desc.clock = {[](void* user) { return *static_cast<uint64_t*>(user); }, &now};
    desc.trace = {nullptr, [](void* user, const char*) { *static_cast<uint64_t*>(user) += 20'000; }, &now};
  }
  GranularScene scene(desc);
  scene.add(particles, {}, grains);
  scene.add_floor();
  sandglass_frame_report report = {};
  uint32_t frames = 0;
  while (report.simulated_time < 1.5 && frames < 2000) {
    report = scene.frame(1.0f / 60.0f, budget == Budget::slow ? 1'000'000 : ~0ull >> 1), ++frames;
  }
  EXPECT_GE(report.simulated_time, 1.5);
  EXPECT_EQ(frames > 180, budget == Budget::slow) << "no slow motion: it took no more than 90 frames";
  std::vector<float> drawn;
  for (const sandglass_grain& g : scene.grains) drawn.insert(drawn.end(), g.position, g.position + 3);
  return evenness(scene.positions(), drawn, static_cast<double>(desc.granular.grain_radius));
}

TEST(EvenDensity, GrainsOfAHeapAtRestLieMoreEvenlyThanAtRandom) {
  if (SANDGLASS_EMULATED != 0) GTEST_SKIP() << "minutes under emulation; the kernels are compared there to the bit";
  const Evenness coarse = heap(0.0068f, SANDGLASS_BLEND_CONTINUOUS);  // 27,000
  EXPECT_LE(coarse.variation, 1.0);
  EXPECT_GE(coarse.nearest, 1.2);
  for (const Budget budget : {Budget::coarser, Budget::slow}) {
    const Evenness short_of_time = heap(0.0068f, SANDGLASS_BLEND_CONTINUOUS, budget);
    EXPECT_LE(short_of_time.variation, 1.0);
    EXPECT_GE(short_of_time.nearest, 1.2);
  }
  const Evenness fine = heap(0.0038f, SANDGLASS_BLEND_CONTINUOUS);  // 149,000
  EXPECT_LE(fine.variation, 1.2);
  EXPECT_GE(fine.nearest, 1.2);
  const Evenness source = heap(0.0038f, SANDGLASS_BLEND_SOURCE);
  EXPECT_GT(source.variation, 1.2) << "the control: the dissertation's rule lets grains clump";
  EXPECT_LT(source.nearest, 1.2);
}

}  // namespace
