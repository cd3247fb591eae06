// One million frames of a small hourglass that is turned over every ten seconds. There is no drift, no NaN and no
// growth of memory, and every checkpoint leads to the same bits again.
//
// Every 10,000 frames the scene is saved. A second scene, restored from the bytes, then runs beside the first for a
// cycle and must stay equal to it, to the bit. SANDGLASS_SOAK_FRAMES shortens the run.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "models/mesh/generated.h"
#include "tests/granular/granular_scene.h"
#include "tests/granular/mesh_collider.h"
#include "tests/peak_memory.h"

namespace {

constexpr double k_pi = 3.14159265358979323846;
constexpr double k_height = 0.5, k_bulb = 0.13, k_neck = 0.065;
constexpr float k_radius = 0.01f, k_frame = 0.02f;
constexpr uint64_t k_cycle = 500, k_turning = 50, k_checkpoint = 10000;
constexpr uint32_t k_grains_per_particle = 8;

// Turns the glass about its centre, by half a turn in the first second of every cycle. Its speed follows (1 - cos), so
// it starts and ends at rest. The pose depends on the frame's number alone, so no error grows over a million frames.
void turn(uint64_t frame, sandglass_collider* glass) {
  const uint64_t done = (frame + 1) / k_cycle;
  const double t = std::min(1.0, static_cast<double>((frame + 1) % k_cycle) / static_cast<double>(k_turning));
  const double angle = k_pi * (static_cast<double>(done % 2) + t - std::sin(2 * k_pi * t) / (2 * k_pi));
  const double speed = k_pi * (1 - std::cos(2 * k_pi * t)) / (static_cast<double>(k_frame) * k_turning);
  // The origin of the glass is at its foot. It moves on a circle about the centre, which is at height H/2.
  const double lever = -k_height / 2, x = -lever * std::sin(angle), y = lever * std::cos(angle);
  glass->position[0] = static_cast<float>(x), glass->position[1] = static_cast<float>(k_height / 2 + y);
  glass->rotation[2] = static_cast<float>(std::sin(angle / 2));
  glass->rotation[3] = static_cast<float>(std::cos(angle / 2));
  glass->linear_velocity[0] = static_cast<float>(-speed * y), glass->linear_velocity[1] = static_cast<float>(speed * x);
  glass->angular_velocity[2] = static_cast<float>(speed);
}

// The point's distance from the axis of the glass minus the wall's at that height, in the frame of the glass.
double beyond_wall(const sandglass_collider& glass, const float* p) {
  const double s = static_cast<double>(glass.rotation[2]), c = static_cast<double>(glass.rotation[3]);
  const double sine = 2 * s * c, cosine = c * c - s * s;
  const double dx = static_cast<double>(p[0] - glass.position[0]), dy = static_cast<double>(p[1] - glass.position[1]);
  const double x = cosine * dx + sine * dy, y = cosine * dy - sine * dx;
  return std::hypot(x, static_cast<double>(p[2])) - sandglass::host::hourglass_radius(k_height, k_bulb, k_neck, y);
}

struct Hourglass {
  Hourglass()
      : wall(sandglass::host::make_revolved(sandglass::host::hourglass_profile(k_height, k_bulb, k_neck, 32), 96),
             SANDGLASS_SOLID_OUTSIDE, k_radius) {
    particles = loose_points({{-0.12f, 0.33f, -0.12f}, {0.12f, 0.47f, 0.12f}},
                             [&](const float* p) { return beyond_wall(wall.collider, p) <= -0.025; });
    grains = grains_about(particles, 0.004f);
  }
  uint32_t count() const { return static_cast<uint32_t>(particles.size() / 3); }

  MeshCollider wall;
  std::vector<float> particles, grains;
};

struct Twin {
  explicit Twin(const Hourglass& glass) : scene(description(glass.count(), k_grains_per_particle * glass.count())) {
    scene.colliders.push_back(glass.wall.collider);
    scene.add(glass.particles, {}, glass.grains);
  }
  sandglass_frame_report frame(uint64_t number) {
    turn(number, &scene.colliders[0]);
    return scene.frame(k_frame);
  }
  double mean_height() const {
    double sum = 0.0;
    const std::vector<float> p = scene.positions();
    for (size_t i = 1; i < p.size(); i += 3) sum += static_cast<double>(p[i]);
    return sum / static_cast<double>(p.size() / 3);
  }
  GranularScene scene;
};

// Mean heights of the settled sand at the ends of cycles, in blocks of a hundred. If nothing drifts, the mean of every
// block agrees with that of the first within the scatter of such means.
struct Heights {
  static constexpr uint32_t k_block = 100;
  static constexpr double k_deviations = 4.0;  // of a difference of two means
  double sum = 0.0, squares = 0.0, first_mean = 0.0, first_variance = 0.0;
  uint32_t cycles = 0, blocks = 0;

  bool add(double height) {
    sum += height, squares += height * height;
    if (++cycles < k_block) return true;
    const double mean = sum / k_block, variance = (squares - sum * mean) / (k_block - 1);
    sum = squares = 0.0, cycles = 0;
    if (blocks++ == 0) first_mean = mean, first_variance = variance;
    return std::fabs(mean - first_mean) <= k_deviations * std::sqrt((variance + first_variance) / k_block);
  }
};

TEST(Soak, MillionFramesOfASmallHourglass) {
  const char* wanted = std::getenv("SANDGLASS_SOAK_FRAMES");
  const uint64_t frames = wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 1000000;
  ASSERT_GT(frames, 0u);
  const Hourglass glass;
  ASSERT_GE(glass.count(), 300u);
  ASSERT_LE(glass.count(), 500u);
  Twin run(glass), again(glass);
  Heights heights;
  int64_t memory_at_first = 0;
  std::vector<std::byte> saved;
  uint64_t compare_until = 0, slept = 0;
  for (uint64_t frame = 0; frame < frames; ++frame) {
    const sandglass_frame_report report = run.frame(frame);
    ASSERT_EQ(report.sand.particles, glass.count()) << "frame " << frame;
    ASSERT_EQ(report.sand.grains, k_grains_per_particle * glass.count()) << "frame " << frame;
    ASSERT_EQ(report.sand.quarantined, 0u) << "frame " << frame;
    ASSERT_EQ(report.sand.dropped_contacts, 0u) << "frame " << frame;
    ASSERT_EQ(report.time.debt, 0.0) << "frame " << frame;
    slept += report.sand.awake == 0 ? 1 : 0;
    if (frame < compare_until) {
      again.frame(frame);
      if ((frame + 1) % 50 == 0) {
        ASSERT_EQ(again.scene.hash(), run.scene.hash()) << "after its restoration, frame " << frame;
      }
    }
    if (frame % 97 == 0) {
      for (const sandglass_grain& grain : run.scene.grains)
        ASSERT_LT(beyond_wall(run.scene.colliders[0], grain.position), 0.0) << "outside, frame " << frame;
    }
    if ((frame + 1) % k_cycle == 0) {
      const double height = run.mean_height();
      ASSERT_LT(height, k_height / 4) << "it has not run through, frame " << frame;
      ASSERT_TRUE(heights.add(height)) << "the height of the pile drifts, frame " << frame;
    }
    if ((frame + 1) % k_checkpoint == 0) {
      accept(run.scene.scene.save(&saved));
      accept(again.scene.scene.restore(saved));
      ASSERT_EQ(again.scene.hash(), run.scene.hash());
      compare_until = frame + 1 + k_cycle;
      const int64_t memory = sandglass::tests::peak_memory_kib();
      if (memory_at_first == 0) memory_at_first = memory;
      ASSERT_LE(memory, memory_at_first + 1024) << "KiB; memory grows, frame " << frame;
    }
  }
  RecordProperty("hash", std::to_string(run.scene.hash()));
  RecordProperty("asleep_frames", std::to_string(slept));
  std::printf("mean height of the pile %.4f m, from cycle to cycle +-%.4f m\n", heights.first_mean,
              std::sqrt(heights.first_variance));
  std::printf("%llu frames, hash 0x%016llx, everything asleep in %llu of the frames of this run\n",
              static_cast<unsigned long long>(frames), static_cast<unsigned long long>(run.scene.hash()),
              static_cast<unsigned long long>(slept));
}

}  // namespace
