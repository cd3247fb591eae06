// Poses alone, as ARKit, ARCore and WebXR tell them, do what poses with exact velocities do: what holds sand keeps it.
// (Held still, corrected, noise and outliers: gentle_test.cpp.)
//
// The control of what moves is a collider that has a new id in every frame: it is where it is told to be and has no
// velocity, so sand goes in at all of its way.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/sand/granular_scene.h"

namespace {

using sandglass::Rotation;
using Colliders = std::vector<sandglass_collider>;

constexpr float k_radius = 0.01f, k_pi = 3.14159265f;
enum class Given { poses, poses_without_band, velocities, another };

struct At {
  float position[3], angle;  // about z
};

// What an app gets by differences.
void add_differences(Colliders* now, const Colliders& before, float step) {
  for (size_t i = 0; i < now->size(); ++i) {
    const float *a = before[i].rotation, *b = (*now)[i].rotation;
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3, m = (k + 2) % 3;
      (*now)[i].linear_velocity[k] = ((*now)[i].position[k] - before[i].position[k]) / step;
      (*now)[i].angular_velocity[k] = 2.0f * (b[k] * a[3] - a[k] * b[3] - (b[l] * a[m] - b[m] * a[l])) / step;
    }
  }
}

// ---- what holds sand: walls of 2 r about a room of 12 x 14 x 12 cm, of boxes or of a field

struct Vessel {
  Vessel(bool with_lid, bool of_field) : lid(with_lid) {
    constexpr float k_more = 3.0f * k_wall;
    if (!of_field) return;
    accept(field.from_function(
        {{-k_half - k_more, -k_more, -k_half - k_more}, {k_half + k_more, k_high + k_more, k_half + k_more}},
        0.5f * k_radius, SANDGLASS_SOLID_INSIDE, [&](const float* p) {
          return std::max({room(p), -k_wall - room(p), lid ? -1.0f : p[1] - k_high});
        }));
    is_field = true;
  }

  // Metres to its inner surface; above 0 in it.
  float room(const float* p) const {
    const float across = k_half - std::max(std::fabs(p[0]), std::fabs(p[2]));
    return std::min({across, p[1], lid ? k_high - p[1] : 1e9f});
  }
  Colliders at(const At& pose) const {
    const Rotation turn = sandglass::rotation_about(0, 0, 1, pose.angle);
    constexpr float k_a = k_half + k_wall, k_t = 0.5f * k_wall, k_h = 0.5f * k_high;
    constexpr float k_boxes[6][6] = {{0, -k_t, 0, k_a, k_t, k_a},
                                     {k_half + k_t, k_h, 0, k_t, k_h, k_a},
                                     {-k_half - k_t, k_h, 0, k_t, k_h, k_a},
                                     {0, k_h, k_half + k_t, k_a, k_h, k_t},
                                     {0, k_h, -k_half - k_t, k_a, k_h, k_t},
                                     {0, k_high + k_t, 0, k_a, k_t, k_a}};
    Colliders all;
    if (is_field) all = {sandglass::field_at(field, pose.position[0], pose.position[1], pose.position[2])};
    const float c = std::cos(pose.angle), s = std::sin(pose.angle);
    for (int i = 0; !is_field && i < (lid ? 6 : 5); ++i) {
      const float* b = k_boxes[i];
      all.push_back(sandglass::box(pose.position[0] + c * b[0] - s * b[1], pose.position[1] + s * b[0] + c * b[1],
                                   pose.position[2] + b[2], b[3], b[4], b[5]));
    }
    for (size_t i = 0; i < all.size(); ++i) {
      all[i].id = static_cast<uint32_t>(i + 1);
      std::copy(turn.begin(), turn.end(), all[i].rotation);
    }
    return all;
  }

  static constexpr float k_half = 0.06f, k_high = 0.14f, k_wall = 2.0f * k_radius;
  sandglass::Field field;
  bool lid, is_field = false;
};

// The most particles that are beyond its inner surface by more than r, after the three frames that are waited for.
int outside_max(const Vessel& vessel, float rate, Given given, float seconds, const std::function<At(float)>& motion) {
  sandglass_scene_desc desc = description(200);
  if (given == Given::poses_without_band) desc.granular.collider_band = 0.0f;
  GranularScene scene(desc);
  const float step = 1.0f / rate;
  scene.add(shifted(lattice(5, 4, 5, 2.05f * k_radius, k_radius), -0.041f, 0.0f, -0.041f));
  scene.colliders = vessel.at(motion(0.0f));
  until_asleep(&scene);
  int highest = 0;
  for (int f = 1; f <= std::lround(seconds * rate); ++f) {
    const Colliders before = scene.colliders;
    const At at = motion(static_cast<float>(f) * step);
    scene.colliders = vessel.at(at);
    if (given == Given::velocities) add_differences(&scene.colliders, before, step);
    for (sandglass_collider& c : scene.colliders) c.id += given == Given::another ? 10u * static_cast<uint32_t>(f) : 0u;
    scene.frame(step);
    const std::vector<float> p = scene.positions();
    const float c = std::cos(at.angle), s = std::sin(at.angle);
    int outside = 0;
    for (size_t i = 0; f > 3 && i < p.size(); i += 3) {
      const float x = p[i] - at.position[0], y = p[i + 1] - at.position[1];
      const float local[3] = {c * x + s * y, c * y - s * x, p[i + 2] - at.position[2]};
      outside += vessel.room(local) < -k_radius ? 1 : 0;
    }
    highest = std::max(highest, outside);
  }
  return highest;
}

// From rest to rest, as a hand goes, in T seconds; to 1.
float dragged(float t, float T) {
  const float s = std::clamp(t / T, 0.0f, 1.0f);
  return s * s * s * (10.0f - 15.0f * s + 6.0f * s * s);
}

TEST(PosesAlone, WhatHoldsSandKeepsIt) {
  const Vessel bucket(false, false), scanned(false, true), jar(true, false), glass(true, true);
  const auto shaken = [](float t, float metres, float hertz) { return metres * std::sin(2.0f * k_pi * hertz * t); };
  struct Case {
    const char* name;
    const Vessel* vessel;
    float seconds;
    std::function<At(float)> motion;
  };
  const Case cases[] = {
      {"a bucket is dragged", &bucket, 1.2f,
       [](float t) {
         return At{{0.6f * dragged(t, 1.0f), 0, 0}, 0};
       }},
      {"a scanned one is dragged fast", &scanned, 0.8f,
       [](float t) {
         return At{{0.6f * dragged(t, 0.6f), 0, 0}, 0};
       }},
      {"and lifted", &scanned, 1.2f,
       [](float t) {
         return At{{0, dragged(t, 1.0f), 0}, 0};
       }},
      {"a jar, 10 cm at 1.5 Hz", &jar, 1.4f,
       [&](float t) {
         return At{{0, shaken(t, 0.1f, 1.5f), 0}, 0};
       }},
      {"a jar, 5 cm at 4 Hz", &jar, 0.8f,
       [&](float t) {
         return At{{0, shaken(t, 0.05f, 4.0f), 0}, 0};
       }},
      {"a glass, 3 cm at 2 Hz", &glass, 1.0f,
       [&](float t) {
         return At{{shaken(t, 0.03f, 2.0f), 0, 0}, 0};
       }},
      {"a glass is rocked", &glass, 1.0f,
       [&](float t) {
         return At{{0, 0, 0}, shaken(t, 0.803f, 2.0f)};
       }},
  };
  for (const Case& c : cases) {
    for (const float rate : {30.0f, 60.0f, 72.0f, 90.0f, 120.0f})
      for (const Given given : {Given::poses, Given::velocities})
        EXPECT_EQ(outside_max(*c.vessel, rate, given, c.seconds, c.motion), 0) << c.name << ", " << rate << " Hz";
    EXPECT_EQ(outside_max(*c.vessel, 60.0f, Given::poses_without_band, c.seconds, c.motion), 0) << c.name;
    EXPECT_GT(outside_max(*c.vessel, 60.0f, Given::another, c.seconds, c.motion), 10) << c.name << ": the control";
  }
}

// ---- where it is held, and with which velocity

TEST(PosesAlone, TheHeldVelocityIsThatOfTheHeldWayAndNeverAhead) {
  for (const float speed : {0.1f, 0.5f, 2.0f}) {
    for (const int each : {1, 2, 4}) {  // frames from one told pose to the next
      GranularScene scene(description(100));
      scene.add(lattice(4, 2, 4, 2.05f * k_radius, k_radius));
      scene.colliders = {sandglass::floor_at(0), sandglass::box(0.0f, 0.2f, 0.0f, 0.05f, 0.05f, 0.05f)};
      scene.colliders[1].id = 1;
      const float step = 1.0f / 60.0f, stop = 1.0f;
      sandglass_collider held = scene.colliders[1], before = held;
      for (int f = 0; f < 120; ++f) {
        if (f % each == 0) scene.colliders[1].position[0] = speed * std::min(static_cast<float>(f) * step, stop);
        scene.frame(step);
        before = held;
        ASSERT_TRUE(scene.scene.held_collider(1, &held));
        const float given = scene.colliders[1].position[0];
        EXPECT_LE(held.position[0], given + 1e-4f) << speed << " m/s, frame " << f;
        if (f < 2 * each + 4) continue;  // the first way of a tracker whose pace is not known may be a jump
        EXPECT_NEAR(held.position[0] - before.position[0], held.linear_velocity[0] * step, 1e-5f) << "frame " << f;
        EXPECT_LE(held.linear_velocity[0], 1.3f * speed) << "frame " << f;
        // No further behind than the band and one way of the tracker's, once what was waited for is made up.
        const float behind = 0.0031f + speed * step * static_cast<float>(each - 1);
        EXPECT_GE(held.position[0], f > 40 ? given - behind : -1.0f) << f;
      }
    }
  }
}

// What jumps in motion, as in a pause, goes on beside what it jumped to, and is there after three frames, at its own speed.
TEST(PosesAlone, AJumpInMotionIsThereAfterThreeFrames) {
  for (const float jump : {0.05f, 0.2f, -0.1f}) {
    GranularScene scene(description(100));
    scene.add(lattice(4, 2, 4, 2.05f * k_radius, k_radius));
    scene.colliders = {sandglass::floor_at(0), sandglass::box(0.0f, 0.2f, 0.0f, 0.05f, 0.05f, 0.05f)};
    scene.colliders[1].id = 1;
    for (int f = 0; f < 60; ++f) {
      scene.colliders[1].position[0] = static_cast<float>(f) / 60.0f + (f < 30 ? 0.0f : jump);
      scene.frame(1.0f / 60.0f);
      sandglass_collider held = {};
      ASSERT_TRUE(scene.scene.held_collider(1, &held));
      EXPECT_LE(std::fabs(held.linear_velocity[0]), 1.3f) << jump << " m, frame " << f;
      if (f > 32) {
        EXPECT_NEAR(held.position[0], scene.colliders[1].position[0], 0.0031f) << jump << " m, frame " << f;
      }
    }
  }
}

// ---- a belt: a velocity that the pose does not go

// Heaps against both ends of a box that stands. What lies on it goes along.
TEST(Belt, ItsEndsSwallowNothingAndItsTopCarries) {
  for (const float speed : {0.12f, 0.5f, 3.0f}) {
    GranularScene scene(description(400));
    scene.colliders = {sandglass::floor_at(0), sandglass::box(0, 0.05f, 0, 0.2f, 0.05f, 0.1f)};
    scene.colliders[1].id = 1;
    for (const float at : {-0.29f, 0.22f})
      scene.add(shifted(lattice(4, 4, 8, 2.05f * k_radius, k_radius), at, 0, -0.07f));
    scene.add({-0.1f, 0.11f, 0.0f});
    until_asleep(&scene);
    scene.colliders[1].linear_velocity[0] = speed;
    for (int f = 0; f < 180; ++f) scene.frame(1.0f / 60.0f);
    EXPECT_GT(scene.positions()[3 * 256], -0.1f + 0.1f) << speed;
    const std::vector<float> p = scene.positions();
    for (size_t i = 0; i < p.size(); i += 3)
      EXPECT_FALSE(std::fabs(p[i]) < 0.195f && std::fabs(p[i + 2]) < 0.095f && p[i + 1] < 0.095f) << speed << " m/s";
  }
}

}  // namespace
