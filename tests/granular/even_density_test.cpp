// Grains keep an even density, in flow and at rest. A heap collapses and comes to rest; inside it the number of grains
// in a small sphere varies less than that of random points, and neighbours keep a distance.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "models/simulation/metrics.h"
#include "tests/granular/granular_scene.h"

namespace {

using sandglass::host::Evenness;

constexpr float k_radius = 0.01f;

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
  const Evenness even = sandglass::host::measure_evenness(scene.positions(), drawn, static_cast<double>(k_radius),
                                                          static_cast<double>(desc.granular.grain_radius), 5);
  EXPECT_EQ(even.spheres, 2000u);
  return even;
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
