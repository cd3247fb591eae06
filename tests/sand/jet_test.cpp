// A steady jet of sand stretches as it falls, without gaps. Every grain falls as if it had left the nozzle at its own
// moment, so the jet is as thin at each height as its speed there says. It is the same jet at every frame rate, and what
// cannot leave the nozzle does not come, instead of being thrown about.
//
// The control is a nozzle as it was before: it places a frame's layers where free fall would have them at the frame's
// end, with a jitter of 0.02 r, whatever is there.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_radius = 0.006f, k_grain_radius = 0.002f, k_nozzle = 0.022f, k_speed = 1.0f;
constexpr double k_gravity = 9.81;
constexpr uint32_t k_grains_per_particle = 16;

// The largest along the jet's axis, in grain radii.
double largest_gap(const std::vector<sandglass_grain>& grains) {
  // Metres below the nozzle: from where the layers are apart to where the first grains are still to come.
  constexpr double k_from = 0.05, k_to = 0.42;
  std::vector<double> below;
  for (const sandglass_grain& grain : grains) {
    const double y = -static_cast<double>(grain.position[1]);
    if (grain.speed >= 0.0f && y >= k_from && y <= k_to) below.push_back(y);
  }
  std::sort(below.begin(), below.end());
  double largest = 0.0;
  for (size_t i = 1; i < below.size(); ++i) largest = std::max(largest, below[i] - below[i - 1]);
  return largest / static_cast<double>(k_grain_radius);
}

// Every grain stays where it is about its particle.
std::vector<sandglass_grain> carried(const std::vector<float>& particles) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  std::vector<sandglass_grain> grains;
  for (size_t p = 0; p < particles.size(); p += 3) {
    for (uint32_t g = 0; g < k_grains_per_particle;) {
      const float offset[3] = {unit(random), unit(random), unit(random)};
      if (std::hypot(offset[0], offset[1], offset[2]) > 1.0f) continue;
      sandglass_grain grain = {};
      for (size_t k = 0; k < 3; ++k) grain.position[k] = particles[p + k] + k_radius * offset[k];
      grains.push_back(grain);
      ++g;
    }
  }
  return grains;
}

// What pours: the library's emitter, or the rule before it.
enum class Rule { emitter, before };

struct Pour {
  float radius, nozzle, speed, rate;  // of a particle and of the nozzle, metres; m/s; frames a second, 0: irregular
  float turned = 0.0f;                // about z, radians
  float moved = 0.0f;                 // m/s along z
  float floor = -100.0f;              // metres below the nozzle
};

// Metres from one layer to the next.
double layer_of(const Pour& pour) { return 2.02 * std::sqrt(2.0 / 3.0) * static_cast<double>(pour.radius); }

// The lattice's sites within the nozzle, in a layer and the next: x and z each.
std::vector<float> sites_of(const Pour& pour, uint32_t layer) {
  const float a = 2.02f * pour.radius, row = a * std::sqrt(0.75f);
  const float shift_x = layer % 2 == 0 ? 0.0f : 0.5f * a, shift_z = layer % 2 == 0 ? 0.0f : row / 3.0f;
  std::vector<float> sites;
  for (int j = -20; j <= 20; ++j) {
    for (int i = -20; i <= 20; ++i) {
      const float x = (static_cast<float>(i) + (j % 2 != 0 ? 0.5f : 0.0f)) * a + shift_x;
      const float z = static_cast<float>(j) * row + shift_z;
      if (x * x + z * z <= pour.nozzle * pour.nozzle) {
        sites.push_back(x);
        sites.push_back(z);
      }
    }
  }
  return sites;
}

// A scene in which a nozzle at the origin pours.
struct Poured {
  explicit Poured(const Pour& what, Rule by = Rule::emitter)
      : pour(what), rule(by), scene([&] {
          sandglass_scene_desc desc = description(12000);
          desc.granular.particle_radius = what.radius;
          desc.granular.emitter_capacity = 1;
          return desc;
        }()) {
    emitter = sandglass::emitter(0, 0, 0, what.nozzle, what.speed, 0);
    emitter.rotation[2] = std::sin(0.5f * what.turned);
    emitter.rotation[3] = std::cos(0.5f * what.turned);
    if (what.floor > -50.0f) scene.add_floor(what.floor);
  }

  void run(float seconds, bool pours = true) {
    std::uniform_real_distribution<float> irregular(0.4f / 60.0f, 1.6f / 60.0f);
    for (const double end = time + static_cast<double>(seconds); time < end - 1e-6;) {
      float step = pour.rate > 0.0f ? 1.0f / pour.rate : irregular(random);
      step = std::min(step, static_cast<float>(end - time));
      if (pours && rule == Rule::before) add_layers(step);
      emitter.position[2] = pour.moved * static_cast<float>(time);
      scene.emitters.assign(pours && rule == Rule::emitter ? 1 : 0, emitter);
      report = scene.frame(step);
      time += static_cast<double>(step);
      fastest = std::max(fastest, report.sand.speed_max);
    }
  }

  void add_layers(float step) {
    std::uniform_real_distribution<float> jitter(-0.02f * pour.radius, 0.02f * pour.radius);
    const float layer = static_cast<float>(layer_of(pour));
    run_out = layers == 0 ? layer : run_out;
    for (run_out += step * pour.speed; run_out >= layer; ++layers) {
      run_out -= layer;
      const float since = run_out / pour.speed, fallen = 4.905f * since * since;
      std::vector<float> at, velocities;
      const std::vector<float> sites = sites_of(pour, layers);
      for (size_t s = 0; s < sites.size(); s += 2) {
        for (const float c : {sites[s], -run_out - fallen, sites[s + 1]}) at.push_back(c + jitter(random));
        for (const float v : {0.0f, -pour.speed - 9.81f * since, 0.0f}) velocities.push_back(v);
      }
      scene.add(at, velocities);
    }
  }

  Pour pour;
  Rule rule;
  GranularScene scene;
  sandglass_emitter emitter;
  sandglass_frame_report report = {};
  std::mt19937 random{11};
  double time = 0.0;
  float run_out = 0.0f, fastest = 0.0f;
  uint32_t layers = 0;
};

struct Shape {
  double width;   // rms distance from the axis, metres
  double off;     // the largest difference of a speed from that of free fall, m/s
  double widest;  // gap between layers, over what it is in a steady jet
};

// Of a jet that falls.
Shape shape_of(const Poured& poured) {
  const std::vector<float> p = poured.scene.positions(), v = poured.scene.velocities();
  const double start = static_cast<double>(poured.pour.speed);
  Shape shape = {0.0, 0.0, 0.0};
  std::vector<double> heights;
  for (size_t i = 0; i < p.size(); i += 3) {
    const double x = static_cast<double>(p[i]), y = static_cast<double>(p[i + 1]), z = static_cast<double>(p[i + 2]);
    shape.width += x * x + z * z;
    const double speed = std::sqrt(start * start - 2.0 * k_gravity * y);
    shape.off = std::max(shape.off, std::fabs(static_cast<double>(std::hypot(v[i], v[i + 1], v[i + 2])) - speed));
    heights.push_back(-y);
  }
  shape.width = std::sqrt(3.0 * shape.width / static_cast<double>(p.size()));
  std::sort(heights.begin(), heights.end());
  for (size_t i = 1; i < heights.size(); ++i) {
    const double speed =
        std::sqrt(start * start + 2.0 * k_gravity * std::max(0.0, 0.5 * (heights[i - 1] + heights[i])));
    shape.widest = std::max(shape.widest, (heights[i] - heights[i - 1]) * start / speed / layer_of(poured.pour));
  }
  return shape;
}

// Layers fall apart as they fall, so in a free jet nothing touches: it stays as wide as its lattice, R / sqrt(2) for many
// sites and no more than a particle radius wider for few; every particle has the speed of free fall; the layers are
// where the formula has them. Jitter moves a particle by 0.01 r at most. Sub-steps of h let layers fall farther by
// g h t / 2 than free fall, in all a thousandth of their distance.
TEST(Jet, IsTheSameAtEveryFrameRate) {
  struct Nozzle {
    float radius, nozzle, seconds;
  };
  for (const Nozzle n : {Nozzle{0.002f, 0.006f, 0.15f}, Nozzle{0.01f, 0.03f, 0.4f}, Nozzle{0.01f, 0.06f, 0.4f},
                         Nozzle{0.02f, 0.06f, 0.4f}}) {
    for (const float speed : {0.8f, 1.5f, 2.0f, 2.5f, 5.0f}) {
      for (const float rate : {30.0f, 45.0f, 60.0f, 72.0f, 80.0f, 90.0f, 120.0f, 144.0f, 240.0f, 0.0f}) {
        Poured jet({n.radius, n.nozzle, speed, rate});
        jet.run(n.seconds);
        const Shape shape = shape_of(jet);
        const std::string name = std::to_string(n.radius) + " m, " + std::to_string(n.nozzle) + " m, " +
                                 std::to_string(speed) + " m/s, " + std::to_string(rate) + " Hz";
        const double gone = static_cast<double>(n.seconds) * static_cast<double>(speed) / layer_of(jet.pour);
        EXPECT_LE(shape.width, static_cast<double>(n.nozzle) / std::sqrt(2.0) + static_cast<double>(n.radius)) << name;
        EXPECT_LE(shape.off, 0.01 * static_cast<double>(speed)) << name;
        EXPECT_LE(shape.widest, 1.02) << name;
        EXPECT_EQ(jet.report.sand.denied_particles, 0u) << name;
        // As many layers as have come out, the first at once; one may be due in the last sub-step.
        const double pair = static_cast<double>(sites_of(jet.pour, 0).size() + sites_of(jet.pour, 1).size()) / 2.0;
        EXPECT_NEAR(static_cast<double>(jet.report.sand.particles), (gone + 0.5) * 0.5 * pair, pair) << name;
      }
    }
  }
  for (const Pour& pour : {Pour{0.01f, 0.03f, 2.0f, 120.0f}, Pour{0.01f, 0.03f, 2.0f, 0.0f}}) {
    Poured control(pour, Rule::before);
    control.run(0.4f);
    const Shape shape = shape_of(control);
    std::printf("the rule before, %.1f m/s, %.0f Hz: %.1f cm wide, speeds off by %.2f m/s\n",
                static_cast<double>(pour.speed), static_cast<double>(pour.rate), 100.0 * shape.width, shape.off);
    EXPECT_GT(shape.width, 0.03 / std::sqrt(2.0) + 0.01);
    EXPECT_GT(shape.off, 0.01 * static_cast<double>(pour.speed));
  }
}

// Of the centres, above the floor.
double lowest_of(const Poured& poured) {
  const std::vector<float> p = poured.scene.positions();
  float lowest = 1e9f;
  for (size_t i = 1; i < p.size(); i += 3) lowest = std::min(lowest, p[i]);
  return static_cast<double>(lowest - poured.pour.floor);
}

// Sand that is in its own way is driven apart by no more than 0.9 sqrt(g d), the speed at which pairs separate.
TEST(Jet, ThatIsBlockedNeitherSpraysNorThrows) {
  int controls = 0, buried = 0;
  for (const float radius : {0.002f, 0.01f}) {
    const double separation = 0.9 * std::sqrt(k_gravity * 2.0 * static_cast<double>(radius));
    for (const float speed : {0.8f, 2.0f, 5.0f}) {
      for (const float below : {0.5f, 1.5f, 3.0f, 6.0f, 15.0f}) {
        for (const float rate : {30.0f, 240.0f}) {
          const Pour pour = {radius, 4.0f * radius, speed, rate, 0.0f, 0.0f, -below * radius};
          const double free = std::sqrt(static_cast<double>(speed * speed) +
                                        2.0 * k_gravity * static_cast<double>((below + 2.0f) * radius));
          Poured poured(pour);
          poured.run(0.2f);
          EXPECT_LE(static_cast<double>(poured.fastest), free + separation)
              << radius << " m, " << speed << " m/s, " << below << " r, " << rate << " Hz";
          EXPECT_EQ(poured.report.sand.particles > 20, below > 2.0f) << "below that is no room for one";
          EXPECT_TRUE(below > 10.0f || poured.report.sand.denied_particles > 0);
          EXPECT_GE(lowest_of(poured), 0.0) << "nothing is in the floor";
          if (below > 1.0f) continue;
          Poured control(pour, Rule::before);
          control.run(0.05f);
          ++controls;
          buried += lowest_of(control) < 0.0 ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(2 * buried, controls) << "the control";
}

TEST(Jet, FromANozzleInsideAColliderWaitsUntilItIsFree) {
  Poured poured({0.01f, 0.03f, 1.0f, 60.0f});
  poured.scene.colliders.push_back(sandglass::sphere(0.0f, 0.0f, 0.0f, 0.1f));
  poured.run(0.5f);
  EXPECT_EQ(poured.report.sand.particles, 0u);
  EXPECT_GT(poured.report.sand.denied_particles, 50u);
  poured.scene.colliders.clear();
  poured.run(0.5f);
  EXPECT_LE(shape_of(poured).off, 0.01);
  EXPECT_NEAR(static_cast<double>(poured.report.sand.particles),
              static_cast<double>(poured.report.sand.denied_particles), 20.0);
}

// A nozzle that moves aside, lies or points up: the layers fall apart less or not at all. Nothing is lost, and contacts
// make nothing faster than the nozzle, its fall and the separation of a pair.
TEST(Jet, KeepsItsRateFromANozzleThatIsMovedOrTurned) {
  constexpr float k_pi = 3.14159265f;
  for (const Pour& pour : {Pour{0.01f, 0.03f, 2.0f, 0.0f, 0.0f, 0.3f}, Pour{0.01f, 0.03f, 2.0f, 0.0f, 0.0f, 1.0f},
                           Pour{0.01f, 0.03f, 0.8f, 0.0f, k_pi / 2}, Pour{0.01f, 0.03f, 2.0f, 0.0f, k_pi / 2},
                           Pour{0.01f, 0.03f, 2.0f, 0.0f, k_pi / 4}, Pour{0.01f, 0.03f, 4.0f, 0.0f, 2.8f}}) {
    for (const float rate : {30.0f, 60.0f, 90.0f, 120.0f, 240.0f}) {
      Pour at_rate = pour;
      at_rate.rate = rate;
      Poured poured(at_rate);
      poured.run(0.5f);
      // 0.5 R^2 v / r^3 particles a second, less or more by the rim: half of 2 pi R / a sites of pi R^2 / (a^2 sqrt(3/4)).
      const double a = 2.02 * 0.01, reach = 0.03,
                   rim = 0.5 * (2.0 * reach / a) / (reach * reach / (a * a * std::sqrt(0.75)));
      const double volume = M_PI * reach * reach * (0.5 * static_cast<double>(pour.speed) + layer_of(pour));
      EXPECT_NEAR(static_cast<double>(poured.report.sand.emitted_particles) / (volume * std::sqrt(2.0) / (a * a * a)),
                  1.0, rim);
      EXPECT_LE(static_cast<double>(poured.report.sand.denied_particles),
                0.02 * static_cast<double>(poured.report.sand.emitted_particles))
          << pour.speed << " " << pour.turned << " " << rate;
      double lowest = 0.0;
      const std::vector<float> p = poured.scene.positions();
      for (size_t i = 1; i < p.size(); i += 3) lowest = std::min(lowest, static_cast<double>(p[i]));
      const double free = std::sqrt(static_cast<double>(pour.speed * pour.speed) - 2.0 * k_gravity * lowest);
      EXPECT_LE(static_cast<double>(poured.fastest), free + 0.9 * std::sqrt(k_gravity * 0.02));
    }
  }
}

// The control: grains that stay where they are about their particles.
TEST(Jet, StretchesWithoutGaps) {
  for (const float rate : {30.0f, 60.0f, 90.0f, 144.0f}) {
    sandglass_scene_desc desc = description(1000, 1000 * k_grains_per_particle);
    desc.granular.particle_radius = k_radius;
    desc.granular.grain_radius = k_grain_radius;
    desc.granular.emitter_capacity = 1;
    GranularScene scene(desc);
    scene.emitters = {sandglass::emitter(0.0f, 0.0f, 0.0f, k_nozzle, k_speed, k_grains_per_particle)};
    scene.grains.resize(1000 * k_grains_per_particle);
    // Of 19,000 grains a second there are 5 a millimetre where they fall at 3 m/s and between two layers are a fifth
    // fewer. Of 3,000 grains that lie there at random, a gap of more than 3 mm is between two of one picture in 1,000.
    constexpr double k_widest = 1.5;
    const int frames = static_cast<int>(0.5f * rate), first = static_cast<int>(0.35f * rate);
    for (int frame = 1; frame <= frames; ++frame) {
      const sandglass_frame_report report = scene.frame(1.0f / rate);
      if (frame < first) continue;  // the first of it have fallen to the end of what is measured
      EXPECT_LE(largest_gap({scene.grains.begin(), scene.grains.begin() + report.sand.grain_numbers}), k_widest)
          << rate << " Hz, frame " << frame;
      EXPECT_GT(largest_gap(carried(scene.positions())), k_widest) << "the control: " << rate << " Hz, frame " << frame;
    }
  }
}

}  // namespace
