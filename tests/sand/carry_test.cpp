// Sand stays in what holds it where a frame's time is not enough: vessels that move, at full budget and at small parts of
// what they need, by a clock that counts its readings; long frames and jumps; and what must not be carried is not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "platform/virtual_clock.h"
#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_radius = 0.006f, k_step = 1.0f / 60.0f, k_half = 0.06f, k_high = 0.14f, k_wall = 0.012f;

// From 0 to 1 in the time from 0 to 1, from rest to rest.
float smooth(float t) {
  t = std::clamp(t, 0.0f, 1.0f);
  return t * t * t * (10 + t * (6 * t - 15));
}

struct Place {
  float x = 0, y = 0;
};
using Motion = Place (*)(float seconds);

Place stands(float) { return {}; }
Place lifted(float t) { return {0.3f * smooth((t - 0.5f) / 0.5f), 0.3f * smooth(t / 0.5f)}; }
Place driven(float t) { return {smooth(t), 0}; }

// A bucket of five boxes on a floor, with sand in it, and sand beside it that no bucket holds.
struct Bucket {
  explicit Bucket(Motion goes, bool clocked = true, int32_t isa = SANDGLASS_ISA_AUTOMATIC, bool grained = false)
      : motion(goes), scene([&] {
          sandglass_scene_desc desc = description(700, grained ? 8 * 384 : 0);
          desc.granular.particle_radius = k_radius;
          desc.unit_items = 128;
          desc.isa = static_cast<sandglass_isa>(isa);
          if (clocked) desc.clock = sandglass::virtual_clock(&clock);
          return desc;
        }()) {
    scene.add_floor();
    const float e = k_wall / 2, h = k_wall + k_high / 2, out = k_half + k_wall;
    boxes = {sandglass::box(0, e, 0, out, e, out), sandglass::box(k_half + e, h, 0, e, k_high / 2, out),
             sandglass::box(-k_half - e, h, 0, e, k_high / 2, out),
             sandglass::box(0, h, k_half + e, out, k_high / 2, e),
             sandglass::box(0, h, -k_half - e, out, k_high / 2, e)};
    for (uint32_t i = 0; i < boxes.size(); ++i) boxes[i].id = i + 1;
    scene.colliders.insert(scene.colliders.end(), boxes.begin(), boxes.end());
    const float d = 2.02f * k_radius;
    std::vector<float> sand;
    for (int y = 0; y < 6; ++y)
      for (int z = 0; z < 8; ++z)
        for (int x = 0; x < 8; ++x)
          for (const float v :
               {d * (static_cast<float>(x) - 3.5f), k_wall + 1.05f * k_radius + d * static_cast<float>(y),
                d * (static_cast<float>(z) - 3.5f)})
            sand.push_back(v);
    held = sand.size() / 3;
    const std::vector<float> grains = grained ? grains_about(sand, 0.5f * k_radius) : std::vector<float>();
    for (int z = 0; z < 6; ++z)
      for (int x = 0; x < 6; ++x)
        for (const float v : {-0.4f + d * static_cast<float>(x), k_radius, d * static_cast<float>(z)})
          sand.push_back(v);
    scene.add(sand, {}, grains);
  }

  // The frame that ends at `time`, `step` after the last one's end.
  sandglass_frame_report frame(float time, uint64_t budget, float step = k_step, bool velocity_given = true,
                               const sandglass_plan* plan = nullptr) {
    const Place now = motion(time), before = motion(time - step);
    at = now;
    for (size_t i = 0; i < boxes.size(); ++i) {
      sandglass_collider& c = scene.colliders[i + 1];
      c.position[0] = boxes[i].position[0] + now.x;
      c.position[1] = boxes[i].position[1] + now.y;
      c.linear_velocity[0] = velocity_given ? (now.x - before.x) / step : 0;
      c.linear_velocity[1] = velocity_given ? (now.y - before.y) / step : 0;
    }
    return scene.frame(step, budget, plan);
  }

  // Of what was in it: beyond its inner surface by more than a radius.
  size_t outside(Place where, bool drawn = false) const {
    const std::vector<float> p = scene.positions();
    size_t out = 0;
    for (size_t i = 0; i < (drawn ? scene.grains.size() : held); ++i) {
      const float* const q = drawn ? scene.grains[i].position : &p[3 * i];
      const float x = q[0] - where.x, y = q[1] - where.y, z = q[2];
      out += std::fabs(x) > k_half + k_radius || std::fabs(z) > k_half + k_radius || y < k_wall - k_radius ||
             y > k_wall + k_high;
    }
    return out;
  }
  float fastest() const {
    float speed_max = 0;
    const std::vector<float> v = scene.velocities();
    for (size_t i = 0; i < v.size(); i += 3) speed_max = std::max(speed_max, std::hypot(v[i], v[i + 1], v[i + 2]));
    return speed_max;
  }
  // By how far the sand beside it has gone, at most.
  float beside_went(const std::vector<float>& from) const {
    float farthest = 0;
    const std::vector<float> p = scene.positions();
    for (size_t i = 3 * held; i < p.size(); ++i) farthest = std::max(farthest, std::fabs(p[i] - from[i]));
    return farthest;
  }

  sandglass::VirtualClock clock{.step_ns = 10'000};
  Motion motion;
  GranularScene scene;
  std::vector<sandglass_collider> boxes;
  size_t held = 0;
  Place at;
};

constexpr uint64_t k_all = ~0ull >> 2;

// A frame's need while it moves, by the clock, on average; and the sand's greatest speed.
struct Need {
  uint64_t ns = 0;
  float fastest = 0;
  explicit Need(Motion motion, bool grained = false) {
    Bucket b(motion, true, SANDGLASS_ISA_AUTOMATIC, grained);
    for (int f = 1; f <= 90; ++f) {
      const sandglass_frame_report report = b.frame(k_step * static_cast<float>(f - 30), k_all);
      if (f > 30) {
        ns += report.time.elapsed_ns / 60;
        fastest = std::max(fastest, b.fastest());
      }
    }
  }
};

class Carried : public testing::TestWithParam<Motion> {};
INSTANTIATE_TEST_SUITE_P(Motions, Carried, testing::Values(lifted, driven));

// The sand, and its grains as they are drawn.
TEST_P(Carried, SandIsInItsVesselInEveryFrameAtAnyBudget) {
  for (const bool grained : {false, true}) {
    const Need need(GetParam(), grained);
    for (const uint64_t part : {2, 4, 8, 16, 32, 64}) {
      Bucket b(GetParam(), true, SANDGLASS_ISA_AUTOMATIC, grained);
      size_t worst = 0, behind = 0;
      float fastest = 0;
      sandglass_frame_report report = {};
      for (int f = 1; f <= 150; ++f) {
        report = b.frame(k_step * static_cast<float>(f - 30), f > 30 ? need.ns / part : k_all);
        worst = std::max(worst, b.outside(b.at, grained));
        behind = std::max(behind, b.outside(GetParam()(k_step * static_cast<float>(f - 33)), grained));
        fastest = std::max(fastest, b.fastest());
      }
      EXPECT_EQ(worst, 0u) << "at 1/" << part;
      EXPECT_LE(fastest, need.fastest + 0.4f) << "at 1/" << part;
      EXPECT_GT(report.time.debt, 0) << "the budget was enough";
      EXPECT_GT(report.time.simulated, 30 * static_cast<double>(k_step)) << "nothing but the vessel went on";
      EXPECT_GT(behind, 0u) << "the control: a vessel that is drawn three frames late";
    }
  }
}

TEST(Carry, WhatNoVesselHoldsStays) {
  Bucket b(driven);
  const uint64_t small = Need(driven).ns / 16;
  for (int f = 1; f <= 60; ++f) b.frame(0, k_all);
  const std::vector<float> from = b.scene.positions();
  for (int f = 1; f <= 60; ++f) b.frame(k_step * static_cast<float>(f), small);
  EXPECT_LE(b.beside_went(from), 0.1f * k_radius);
}

// Bits, where time is enough: as without a clock.
TEST(Carry, ChangesNothingWhereTimeIsEnough) {
  for (const bool grained : {false, true}) {
    Bucket clocked(lifted, true, SANDGLASS_ISA_AUTOMATIC, grained),
        free(lifted, false, SANDGLASS_ISA_AUTOMATIC, grained);
    for (int f = 1; f <= 90; ++f) {
      clocked.frame(k_step * static_cast<float>(f), k_all);
      free.frame(k_step * static_cast<float>(f), k_all);
    }
    EXPECT_EQ(clocked.scene.hash(), free.scene.hash());
  }
}

bool draw_the_same(const GranularScene& a, const GranularScene& b) {
  return std::memcmp(a.grains.data(), b.grains.data(), a.grains.size() * sizeof a.grains[0]) == 0;
}

TEST(Carry, ReplaysOnEveryInstructionSetAndGoesOnAfterARestore) {
  for (const bool grained : {false, true}) {
    const uint64_t small = Need(lifted, grained).ns / 8;
    Bucket first(lifted, true, SANDGLASS_ISA_AUTOMATIC, grained), scalar(lifted, false, SANDGLASS_ISA_SCALAR, grained),
        restored(lifted, false, SANDGLASS_ISA_AUTOMATIC, grained);
    for (int f = 1; f <= 60; ++f) {
      if (f == 33) {
        std::vector<std::byte> bytes, same;
        accept(first.scene.scene.save(&bytes));
        accept(scalar.scene.scene.save(&same));
        ASSERT_TRUE(bytes == same);
        accept(restored.scene.scene.restore(bytes));
      }
      const float time = k_step * static_cast<float>(f);
      const sandglass_plan plan = first.frame(time, small).plan;
      scalar.frame(time, 0, k_step, true, &plan);
      ASSERT_EQ(scalar.scene.hash(), first.scene.hash()) << f;
      ASSERT_TRUE(draw_the_same(scalar.scene, first.scene)) << f;
      if (f < 33) continue;
      restored.frame(time, 0, k_step, true, &plan);
      ASSERT_EQ(restored.scene.hash(), first.scene.hash()) << f;
      ASSERT_TRUE(draw_the_same(restored.scene, first.scene)) << f;
    }
  }
}

// A tab that comes back: a frame of many is one, with all budget; by velocities, and by poses alone.
TEST(Carry, LongFramesTakeSandAlong) {
  for (const bool velocity_given : {true, false})
    for (const float gap : {0.117f, 0.25f, 0.5f, 2.0f}) {
      Bucket b(driven);
      for (int f = 1; f <= 30; ++f) b.frame(k_step * static_cast<float>(f - 30), k_all, k_step, velocity_given);
      float time = 0;
      for (int f = 0; f < 20; ++f) b.frame(time += k_step, k_all, k_step, velocity_given);
      b.frame(time += gap, k_all, gap, velocity_given);
      if (velocity_given) {
        EXPECT_EQ(b.outside(b.at), 0u) << gap;
      }
      for (int f = 0; f < 60; ++f) b.frame(time += k_step, k_all, k_step, velocity_given);
      EXPECT_EQ(b.outside(b.at), 0u) << gap << velocity_given;
    }
}

Place aside(float t) { return {t > 0 ? 0.3f : 0.0f, 0}; }

// Poses alone wait some frames before they follow a jump; and poses that went on in a pause are one.
TEST(Carry, AVesselThatIsPutAsideKeepsItsSand) {
  for (const bool paused : {false, true}) {
    Bucket b(aside);
    for (int f = 1; f <= 30; ++f) b.frame(0, k_all);
    const std::vector<float> from = b.scene.positions();
    if (paused) b.scene.frame(0.0f);
    for (int f = 0; f < 60; ++f) b.frame(1, k_all, k_step, false);
    EXPECT_EQ(b.outside(b.at), 0u);
    EXPECT_GT(b.outside({}), b.held / 2) << "the control: where it was";
    EXPECT_LE(b.beside_went(from), 0.1f * k_radius);
  }
}

// A hand that appears in sand and goes on, with a part of the time that this takes: the sand within it
// does not lie on it, and what it meets on the floor goes before it.
TEST(Carry, AHandTakesNothingAlongThatIsBeneathIt) {
  constexpr float k_hand = 6 * k_radius, k_speed = 1;
  sandglass::VirtualClock clock{.step_ns = 10'000};
  sandglass_scene_desc desc = description(500);
  desc.granular.particle_radius = k_radius;
  desc.clock = sandglass::virtual_clock(&clock);
  GranularScene scene(desc);
  scene.add_floor();
  scene.add(lattice(40, 1, 12, 2.02f * k_radius, k_radius));
  for (int f = 0; f < 30; ++f) scene.frame(k_step);
  const float middle = 11 * 1.01f * k_radius, reach = 3 * k_hand;
  scene.colliders.push_back(sandglass::sphere(middle, 0.6f * k_hand, middle, k_hand));
  sandglass_collider& hand = scene.colliders.back();
  const auto beneath = [&] {
    const std::vector<float> p = scene.positions();
    size_t some = 0;
    for (size_t i = 0; i < p.size(); i += 3)
      some += std::hypot(p[i] - hand.position[0], p[i + 2] - hand.position[2]) < 0.4f * k_hand;
    return some;
  };
  scene.frame(k_step, 100'000);
  EXPECT_GT(beneath(), 2u) << "the control: nothing was beneath it";
  hand.linear_velocity[0] = k_speed;
  while (hand.position[0] < middle + reach) {
    hand.position[0] += k_speed * k_step;
    scene.frame(k_step, 100'000);
  }
  EXPECT_EQ(beneath(), 0u);
}

// A tray goes up through a shelf, with no time for that: what lies on it stays below, whether the shelf stands or goes
// aside.
TEST(Carry, WhatLiesOnATrayIsTakenThroughNoShelf) {
  for (const float aside : {0.0f, 1.0f}) {
    sandglass::VirtualClock clock{.step_ns = 10'000};
    sandglass_scene_desc desc = description(100);
    desc.granular.particle_radius = k_radius;
    desc.clock = sandglass::virtual_clock(&clock);
    GranularScene scene(desc);
    constexpr float k_top = 0.1f, k_shelf = k_top + 0.06f, k_rises = 2;
    scene.colliders = {sandglass::box(0, k_top - k_wall, 0, 0.2f, k_wall, 0.2f),
                       sandglass::box(0, k_shelf, 0, 0.3f, k_wall / 2, 0.3f)};
    sandglass_collider &tray = scene.colliders[0], &shelf = scene.colliders[1];
    tray.id = 1;
    shelf.id = 2;
    tray.linear_velocity[1] = k_rises;
    shelf.linear_velocity[0] = aside;
    for (const float x : {-0.04f, 0.0f, 0.04f})
      for (const float z : {-0.04f, 0.0f, 0.04f}) scene.add({x, k_top + k_radius, z});
    float highest = 0;
    for (int f = 0; f < 6; ++f) {
      scene.frame(k_step, 10'000);
      tray.position[1] += k_rises * k_step;
      shelf.position[0] += aside * k_step;
      const std::vector<float> p = scene.positions();
      for (size_t i = 1; i < p.size(); i += 3) highest = std::max(highest, p[i]);
    }
    EXPECT_GT(highest, k_top + 0.02f) << "the control: it was not taken along";
    EXPECT_LT(highest, k_shelf) << aside << " m/s aside";
  }
}

TEST(Carry, IsNotThereWhereNothingMoves) {
  Bucket b(stands);
  const uint64_t small = Need(stands).ns / 8 + 50'000;
  for (int f = 1; f <= 30; ++f) b.frame(0, small);
  for (int f = 1; f <= 30; ++f) {
    const sandglass_frame_report report = b.frame(0, small);
    ASSERT_EQ(report.stages[SANDGLASS_STAGE_OUTPUT].units, 0u);
  }
}

}  // namespace
