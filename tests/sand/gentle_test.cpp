// Colliders as a tracker, a hand and an impatient user give them: they tremble, jump, tilt, come late, change places. What
// lies stays, what is corrected is lifted, what is pushed goes no faster than what pushes. Floors, presses and jitters
// come for particles of 2 mm, 1 cm and 5 cm.
//
// Controls: collider_band 0, by which every pose is taken as it is told; a new id in every frame, by which a collider has no
// velocity; and the speed at which sand left a collider before, told as a velocity.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_frame = 1.0f / 60.0f;
constexpr double k_gravity = 9.81;

// A heap at rest and what carries it, which is told at the height 0 of its surface.
enum class Ground { half_space, box, field };

sandglass_collider ground_of(Ground kind, float radius, const sandglass::Field& field) {
  const float wide = 60.0f * radius;
  if (kind == Ground::half_space) return sandglass::floor_at(0);
  if (kind == Ground::field) return sandglass::field_at(field, 0, 0, 0);
  return sandglass::box(0, -2.0f * radius, 0, wide, 2.0f * radius, wide);
}

struct Heap {
  explicit Heap(float radius, Ground kind = Ground::half_space, float band = 0.003f, float sleep_after = 0.5f)
      : r(radius), scene([&] {
          sandglass_scene_desc desc = description(300);
          desc.granular.particle_radius = radius;
          desc.granular.collider_band = band;
          desc.granular.sleep_after = sleep_after;
          return desc;
        }()) {
    if (kind == Ground::field) {
      const float wide = 60.0f * r, spacing = 2.0f * r, more = wide + 4.0f * spacing;
      accept(field.from_function(
          {{-more, -16 * r, -more}, {more, 10 * r, more}}, spacing, SANDGLASS_SOLID_INSIDE, [&](const float* p) {
            return std::max({std::fabs(p[0]) - wide, std::fabs(p[1] + 4 * r) - 4 * r, std::fabs(p[2]) - wide});
          }));
    }
    scene.add(shifted(lattice(7, 5, 7, 2.05f * r, r), -7.0f * r, 0.0f, -7.0f * r));
    scene.colliders.push_back(ground_of(kind, r, field));
    for (int f = 0; f < 1200 && (f == 0 || report.sand.awake != 0); ++f) frame();
    at_rest = scene.positions();
  }

  sandglass_collider& ground() { return scene.colliders[0]; }
  void frame(float step = k_frame) { report = scene.frame(step); }
  void run(float seconds) {
    for (int f = 0; f < std::lround(seconds / k_frame); ++f) frame();
  }
  double top() const {
    const std::vector<float> p = scene.positions();
    float top = -1e9f;
    for (size_t i = 1; i < p.size(); i += 3) top = std::max(top, p[i]);
    return static_cast<double>(top);
  }
  // Mean way along an axis since it came to rest, of what lay above this height then.
  double went(int axis, double above = -1.0) const {
    const std::vector<float> p = scene.positions();
    double sum = 0.0, count = 0.0;
    for (size_t i = 0; i < p.size(); i += 3) {
      if (static_cast<double>(at_rest[i + 1]) < above) continue;
      sum += static_cast<double>(p[i + static_cast<size_t>(axis)] - at_rest[i + static_cast<size_t>(axis)]);
      count += 1.0;
    }
    return sum / count;
  }

  float r;
  sandglass::Field field;
  GranularScene scene;
  sandglass_frame_report report = {};
  std::vector<float> at_rest;
};

// The fastest that is gentle: the fall of the correction, and the speed at which pairs of particles part.
double gentle(double radius, double correction) {
  return 0.9 * std::sqrt(k_gravity * 2.0 * radius) + std::sqrt(2.0 * k_gravity * correction);
}

// ---- part by part

TEST(Gentle, ACorrectedFloorMovesSandByTheCorrection) {
  for (const float r : {0.002f, 0.01f, 0.05f}) {
    for (const float up : {-0.05f, -0.005f, -0.001f, 0.001f, 0.005f, 0.05f}) {
      for (const float tilt : {0.0f, 0.035f}) {  // 2 degrees
        Heap heap(r);
        const double top = heap.top();
        heap.ground().position[1] = up;
        heap.ground().rotation[2] = 0.5f * tilt;
        double highest = 0.0, fastest = 0.0;
        for (int f = 0; f < 90; ++f) {
          heap.frame();
          highest = std::max(highest, heap.top());
          fastest = std::max(fastest, static_cast<double>(heap.report.sand.speed_max));
        }
        const double rise = 14.0 * static_cast<double>(r * tilt), lift = static_cast<double>(std::max(up, 0.0f)) + rise;
        EXPECT_LE(highest, top + lift + 0.2 * static_cast<double>(r)) << r << " m, up " << up << " m, by " << tilt;
        EXPECT_LE(fastest, gentle(static_cast<double>(r), static_cast<double>(std::fabs(up)) + rise))
            << r << " m, up " << up << " m, by " << tilt;
        if (std::fabs(up) > 0.003f) {
          EXPECT_NEAR(heap.went(1), static_cast<double>(up), 0.5 * static_cast<double>(r)) << r << " " << up;
        }
      }
    }
  }
}

// The rule before made speeds of 5 mm: the whole depth in one sub-step, 9 m/s. Told as a velocity a third of that throws.
TEST(Gentle, ControlAFloorWithTheSpeedOfTheRuleBeforeThrows) {
  Heap heap(0.01f, Ground::half_space, 0.0f);
  const double top = heap.top();
  heap.ground().linear_velocity[1] = 3.0f;
  heap.ground().position[1] = 3.0f * k_frame;
  heap.frame();
  heap.ground().position[1] = 0.005f;
  heap.ground().linear_velocity[1] = 0.0f;
  double highest = 0.0;
  for (int f = 0; f < 60; ++f) {
    heap.frame();
    highest = std::max(highest, heap.top());
  }
  EXPECT_GT(highest, top + 0.1);
}

// A hand presses sand against a table of twice the radius and more, in both orders of the list. Of two colliders the
// larger holds: the control is a hand that is larger than the table.
TEST(Gentle, NothingIsPressedThroughATable) {
  uint64_t hash = 0;
  const auto lowest_of = [&](float r, bool hand_first, float hand_radii) {
    Heap heap(r, Ground::box);
    const sandglass_collider table = heap.ground();
    sandglass_collider hand = sandglass::sphere(0.0f, 0.0f, 0.0f, hand_radii * r);
    float lowest = 1e9f;
    for (int stroke = 0; stroke < 4; ++stroke) {
      for (int f = 0; f < 60; ++f) {
        hand.position[0] = 2.0f * r * static_cast<float>(stroke - 2);
        const float above = 7.5f * std::fabs(static_cast<float>(f + 1 - 30)) / 30.0f;
        hand.position[1] = r * (hand_radii - 1.0f + above);         // 1 r into the table
        hand.linear_velocity[1] = f < 30 ? -15.0f * r : 15.0f * r;  // m/s
        heap.scene.colliders = hand_first ? std::vector{hand, table} : std::vector{table, hand};
        heap.frame();
        const std::vector<float> p = heap.scene.positions();
        for (size_t i = 1; i < p.size(); i += 3) lowest = std::min(lowest, p[i]);
      }
    }
    hash = heap.scene.hash();
    return lowest / r;
  };
  for (const float r : {0.002f, 0.01f, 0.05f}) {
    EXPECT_GT(lowest_of(r, false, 5.0f), 0.0f) << r;
    const uint64_t table_first = hash;
    EXPECT_GT(lowest_of(r, true, 5.0f), 0.0f) << r;
    EXPECT_EQ(table_first, hash) << "the order of the list means something";
  }
  EXPECT_LT(lowest_of(0.01f, false, 100.0f), 0.0f) << "the control";
}

// ---- colliders are held still

// Ten seconds of a tracker's noise, without velocities or with those of its poses.
void shake(Heap* heap, float noise, bool velocities, float seconds) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal(0.0f, noise);
  const float middle = heap->ground().position[1];
  for (int f = 0; f < std::lround(seconds / k_frame); ++f) {
    const float before = heap->ground().position[1];
    heap->ground().position[1] = middle + normal(random);
    heap->ground().linear_velocity[1] = velocities ? (heap->ground().position[1] - before) / k_frame : 0.0f;
    heap->frame();
  }
  heap->ground().position[1] = middle;
  heap->ground().linear_velocity[1] = 0.0f;
}

TEST(Held, AFloorThatTremblesLeavesTheHeapAsleep) {
  for (const float r : {0.002f, 0.01f, 0.05f}) {
    for (const Ground kind : {Ground::half_space, Ground::box, Ground::field}) {
      Heap heap(r, kind);
      ASSERT_EQ(heap.report.sand.awake, 0u);
      const double top = heap.top();
      for (const bool velocities : {false, true}) {
        for (const float noise : {2e-5f, 1e-4f, 3e-4f, 1e-3f}) {
          shake(&heap, noise, velocities, 10.0f);
          EXPECT_GE(heap.top(), noise > 5e-4f ? 0.95 * top : top) << r << " m, noise " << noise;
          if (noise < 5e-4f) {
            EXPECT_EQ(heap.report.sand.awake, 0u) << r << " m, noise " << noise;
          }
        }
      }
    }
    Heap control(r, Ground::half_space, 0.0f);
    const double top = control.top();
    shake(&control, 0.03f * r, false, 5.0f);
    EXPECT_LT(control.top(), 0.95 * top) << "the control";
  }
}

// 0.3 degrees about a point two metres away are 10 mm here: the surface counts, not the numbers.
TEST(Held, WhatCountsIsTheSurfaceWhereSandIs) {
  Heap heap(0.01f);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> slide(-3.0f, 3.0f);
  for (int f = 0; f < 120; ++f) {
    heap.ground().position[0] = slide(random);
    heap.ground().position[2] = slide(random);
    heap.frame();
    ASSERT_EQ(heap.report.sand.awake, 0u) << "a plane slides along itself";
  }
  heap.ground().position[0] = 2.0f;
  heap.ground().position[2] = 0.0f;
  heap.ground().rotation[2] = std::sin(0.5f * 0.0052f);
  heap.run(2.0f);
  sandglass_collider held = {};
  ASSERT_TRUE(heap.scene.scene.held_collider(0, &held));
  EXPECT_NEAR(static_cast<double>(held.rotation[2]), std::sin(0.5 * 0.0052), 1e-4) << "it is followed all the way";
  EXPECT_NEAR(heap.went(1), -2.0 * 0.0052, 0.002);
}

TEST(Held, ATableThatGrowsWakesNothing) {
  Heap heap(0.01f, Ground::box);
  for (int f = 0; f < 300; ++f) {
    const float grown = 0.02f * static_cast<float>(f / 20);
    heap.ground().position[0] = grown;
    heap.ground().size[0] = 0.6f + grown;
    heap.ground().position[1] = -0.02f + (f / 20 % 2 != 0 ? 0.001f : 0.0f);
    heap.frame();
    ASSERT_EQ(heap.report.sand.awake, 0u) << f;
  }
  sandglass_collider held = {};
  ASSERT_TRUE(heap.scene.scene.held_collider(0, &held));
  EXPECT_NEAR(static_cast<double>(held.position[0] + held.size[0]), 0.6 + 2 * 0.28, 1e-4)
      << "its edge is where it is told";
  EXPECT_NEAR(static_cast<double>(held.position[1] + held.size[1]), 0.0, 1e-5) << "what sand lies on is held";
}

TEST(Held, OneOutlierIsNotFollowed) {
  Heap heap(0.01f);
  for (int f = 0; f < 200; ++f) {
    heap.ground().position[1] = f % 10 == 0 ? 0.05f : f % 10 == 1 ? -0.02f : 0.0f;
    heap.frame();
    ASSERT_EQ(heap.report.sand.awake, 0u) << f;
  }
}

// A hand that has poses alone moves aside what one with velocities does, held or not. The control is another in every
// frame.
TEST(Held, AHandByPosesAlonePushes) {
  const auto moved = [](bool velocity, float band, float rate, bool another = false) {
    Heap heap(0.01f, Ground::half_space, band);
    heap.scene.colliders.push_back(sandglass::sphere(-0.3f, 0.02f, 0.0f, 0.04f));
    double fastest = 0.0;
    for (int f = 1; f <= std::lround(0.6f / 0.3f * rate); ++f) {
      heap.scene.colliders[1].position[0] = -0.3f + 0.3f * static_cast<float>(f) / rate;
      heap.scene.colliders[1].linear_velocity[0] = velocity ? 0.3f : 0.0f;
      if (another) heap.scene.colliders[1].id = static_cast<uint32_t>(f);
      heap.frame(1.0f / rate);
      fastest = std::max(fastest, static_cast<double>(heap.report.sand.speed_max));
    }
    EXPECT_LE(fastest, 0.3 + gentle(0.01, 0.04));
    const std::vector<float> p = heap.scene.positions();
    double sum = 0.0;
    for (size_t i = 0; i < p.size() / 3; ++i) sum += distance(p, i, heap.at_rest, i);
    return sum;
  };
  for (const float rate : {30.0f, 60.0f, 120.0f}) {
    const double with_velocity = moved(true, 0.003f, rate);
    for (const float band : {0.003f, 0.0f}) EXPECT_GE(moved(false, band, rate), 0.5 * with_velocity) << rate << " Hz";
  }
  EXPECT_LT(moved(false, 0.003f, 120.0f, true), 0.5 * moved(true, 0.003f, 120.0f)) << "the control";
}

// A tracker loses a hand, whose box it makes larger, and finds it where a grain falls. Its way meanwhile took as long
// as it was lost, not a frame: beside that are five frames of free fall, and the speed at which sand leaves.
TEST(Held, AHandThatIsLostForAWhileComesBackAtItsOwnSpeed) {
  constexpr float k_hand = 0.2f, k_grows = 0.03f;  // m/s
  constexpr long k_seen = 6;                       // frames until it is lost
  for (const long lost : {9, 12}) {
    sandglass_scene_desc desc = description(300);
    desc.granular.particle_radius = 0.006f;
    GranularScene scene(desc);
    scene.colliders.push_back(sandglass::floor_at(0));
    float fastest = 0.0f;
    for (long f = 1; f <= k_seen + lost + 3; ++f) {
      const float seconds = static_cast<float>(f) * k_frame, side = 0.03f + k_grows * seconds;
      sandglass_collider hand = sandglass::box(-0.05f + k_hand * seconds, 0.2f, 0.0f, side, side, side);
      hand.id = 5;
      scene.colliders.resize(1);
      if (f <= k_seen || f > k_seen + lost) scene.colliders.push_back(hand);
      if (f == k_seen + lost - 2) scene.add({0.0f, 0.2f, 0.0f});
      fastest = std::max(fastest, scene.frame(k_frame).sand.speed_max);
    }
    EXPECT_LE(fastest, 1.3f * (k_hand + k_grows) + 0.1f + 5 * k_frame * static_cast<float>(k_gravity)) << lost;
  }
}

// A lift that has poses alone goes evenly, not in steps of the band, and carries what lies on it.
TEST(Held, ALiftByPosesAloneIsFollowedEvenly) {
  for (const float speed : {0.001f, 0.005f, 0.05f}) {
    Heap heap(0.01f);
    float before = 0.0f, fastest = 0.0f;
    const int frames = static_cast<int>(std::lround(0.05f / speed / k_frame));
    for (int f = 1; f <= frames + 120; ++f) {
      heap.ground().position[1] = 0.05f * std::min(1.0f, static_cast<float>(f) / static_cast<float>(frames));
      heap.frame();
      sandglass_collider held = {};
      ASSERT_TRUE(heap.scene.scene.held_collider(0, &held));
      if (f > frames / 2 && f < frames) fastest = std::max(fastest, (held.position[1] - before) / k_frame);
      before = held.position[1];
    }
    EXPECT_LE(fastest, 1.1f * speed) << speed;
    EXPECT_NEAR(static_cast<double>(before), 0.05, 0.001) << speed;
    EXPECT_GE(heap.went(1), 0.9 * (0.05 - 0.003)) << speed;
  }
}

// ---- what is told by poses alone, or by their differences

// A velocity by differences of a collider that is not turned.
void tell_difference(sandglass_collider* now, const sandglass_collider& before, float step) {
  for (int k = 0; k < 3; ++k) now->linear_velocity[k] = (now->position[k] - before.position[k]) / step;
}

void turn_about_y(sandglass_collider* c, float angle) {
  const sandglass::Rotation turn = sandglass::rotation_about(0, 1, 0, angle);
  std::copy(turn.begin(), turn.end(), c->rotation);
}

// A plane whose origin slides or that turns about its normal, and a table that grows or turns, as trackers refine them.
TEST(Corrected, WhatIsRefinedTakesNoSandAlong) {
  struct Case {
    float up, slide, grow, turn;
    int frames;
  };
  for (const Ground kind : {Ground::half_space, Ground::box}) {
    const bool table = kind == Ground::box;
    for (const Case& c :
         {Case{0.005f, 0.1f, 0.2f, 0, 1}, Case{0.005f, 1.0f, 0.1f, 0, 30}, Case{-0.004f, 3.0f, 0.1f, 0, 1},
          Case{0.004f, 0.37f, 0.1f, 0.17f, 1}, Case{0.002f, 0, 0, 1.57f, 1}}) {
      Heap heap(0.01f, kind);
      const sandglass_collider at = heap.ground();
      for (int f = 1; f <= 120; ++f) {
        const float done = std::min(1.0f, static_cast<float>(f) / static_cast<float>(c.frames));
        heap.ground().position[0] = done * (table ? 0.5f * c.grow : c.slide);
        heap.ground().position[1] = at.position[1] + done * c.up;
        if (table) heap.ground().size[0] = at.size[0] + done * 0.5f * c.grow;
        turn_about_y(&heap.ground(), done * c.turn);
        heap.frame();
      }
      for (const int axis : {0, 2})
        EXPECT_NEAR(heap.went(axis), 0.0, 0.002) << table << " " << c.slide << " " << c.turn;
      double turned = 0.0;
      const std::vector<float> p = heap.scene.positions(), &q = heap.at_rest;
      for (size_t i = 0; i < p.size(); i += 3) {
        const float swept = q[i + 2] * (p[i] - q[i]) - q[i] * (p[i + 2] - q[i + 2]);
        turned += static_cast<double>(swept / (q[i] * q[i] + q[i + 2] * q[i + 2] + 1e-4f)) /
                  static_cast<double>(p.size() / 3);
      }
      EXPECT_NEAR(turned, 0.0, 0.01) << table << " " << c.slide << " " << c.turn;
    }
  }
}

// It costs a heap what it costs when the app tells it exactly, over 20 frames.
TEST(Corrected, AHeapLosesWhatAnExactCorrectionCosts) {
  for (const float up : {0.005f, 0.012f, -0.005f}) {
    const auto lost = [&](bool exact) {
      Heap heap(0.01f);
      const double top = heap.top();
      for (int f = 1; f <= 300; ++f) {
        heap.ground().position[1] = exact ? up * std::min(1.0f, static_cast<float>(f) / 20.0f) : up;
        heap.ground().linear_velocity[1] = exact && f <= 20 ? up / 20.0f / k_frame : 0.0f;
        heap.frame();
      }
      return top + static_cast<double>(up) - heap.top();
    };
    EXPECT_LE(lost(false), lost(true) + 0.004) << up;
  }
}

// Within the band along the normal, beyond it aside; and a ball in the heap that turns.
TEST(Held, NoiseThatMovesNoSurfaceWakesNothing) {
  for (const bool velocities : {false, true}) {
    Heap heap(0.01f);
    std::mt19937 random(1);
    std::uniform_real_distribution<float> noise(-0.0025f, 0.0025f);
    heap.scene.colliders.push_back(sandglass::sphere(0, heap.r, 0, 0.04f));
    heap.run(10.0f);
    ASSERT_EQ(heap.report.sand.awake, 0u);
    for (int f = 0; f < 300; ++f) {
      const sandglass_collider before = heap.ground();
      for (float& x : heap.ground().position) x = noise(random);
      const float angle = 20.0f * noise(random);
      if (velocities) tell_difference(&heap.ground(), before, k_frame);
      turn_about_y(&heap.scene.colliders[1], angle);
      heap.frame();
      ASSERT_EQ(heap.report.sand.awake, 0u) << velocities << ", frame " << f;
    }
  }
}

// A floor that is followed, because it was just corrected: an outlier of two frames throws nothing, velocities or not.
TEST(Corrected, AnOutlierThrowsNothing) {
  for (const bool velocities : {false, true}) {
    Heap heap(0.01f);
    heap.ground().position[1] = 0.005f;
    heap.run(1.4f);
    const double top = heap.top();
    float fastest = 0.0f;
    for (int f = 0; f < 60; ++f) {
      const sandglass_collider before = heap.ground();
      heap.ground().position[1] = f == 10 || f == 11 ? 0.055f : 0.005f;
      if (velocities) tell_difference(&heap.ground(), before, k_frame);
      heap.frame();
      fastest = std::max(fastest, heap.report.sand.speed_max);
    }
    EXPECT_LE(heap.top(), top + 0.001) << velocities;
    EXPECT_LE(fastest, 0.3f) << velocities << ": what flows by itself is no faster";
  }
}

// A tracker that is slower than the frames, told with velocities by differences, 0, 0, 0, 4 v: a ball goes through a heap.
TEST(Held, ASlowTrackersDifferencesThrowNoMoreThanExactVelocities) {
  const auto fastest = [](float rate, int each) {
    float speed_max = 0.0f;
    for (const float start : {-0.3f, -0.32f}) {
      Heap heap(0.01f);
      heap.scene.colliders.push_back(sandglass::sphere(start, 0.05f, 0, 0.04f));
      for (int f = 1; f <= std::lround(0.6f * rate); ++f) {
        const sandglass_collider before = heap.scene.colliders[1];
        if (f % each == 0) heap.scene.colliders[1].position[0] = start + static_cast<float>(f) / rate;
        tell_difference(&heap.scene.colliders[1], before, 1.0f / rate);
        heap.frame(1.0f / rate);
        speed_max = std::max(speed_max, heap.report.sand.speed_max);
      }
    }
    return speed_max;
  };
  const float exact = fastest(60.0f, 1);
  EXPECT_LE(fastest(120.0f, 4), 1.3f * exact);
  EXPECT_LE(fastest(60.0f, 2), 1.3f * exact);
  EXPECT_LE(fastest(120.0f, 2), 1.3f * exact);
}

// ---- identity

// Two equal tables change places, and are told apart by their ids alone.
TEST(Identity, AnIdKeepsACollidersPose) {
  for (const bool ids : {false, true}) {
    Heap heap(0.01f, Ground::box);
    sandglass_collider table = heap.ground(), other = table;
    other.position[1] += 0.002f;  // within the band, as two trackers of one plane tell it
    if (ids) {
      table.id = 7;
      other.id = 9;
    }
    heap.scene.colliders = {table, other};
    heap.run(4.0f);
    heap.scene.colliders = {other, table};
    heap.run(1.0f);
    EXPECT_EQ(heap.report.sand.awake, 0u);
    sandglass_collider held = {};
    ASSERT_TRUE(heap.scene.scene.held_collider(0, &held));
    EXPECT_NEAR(static_cast<double>(held.position[1]), static_cast<double>(other.position[1]), 1e-6);
    EXPECT_EQ(held.id, ids ? 9u : 0u);
  }
}

// ---- slow carriers

// A heap that wakes creeps. It does so whichever way the carrier goes, so half of the difference of two ways is what was
// carried.
TEST(Carrier, WhatLiesOnASlowCarrierGoesWithIt) {
  const auto share_moved = [](float speed, bool turns, float sleep_after) {
    Heap heap(0.01f, Ground::half_space, 0.003f, sleep_after);
    const double above = 0.025;
    (turns ? heap.ground().angular_velocity[1] : heap.ground().linear_velocity[0]) = turns ? 10.0f * speed : speed;
    heap.run(15.0f);
    if (!turns) return heap.went(0, above) / (15.0 * static_cast<double>(speed));
    const std::vector<float> p = heap.scene.positions();
    double sum = 0.0, count = 0.0;
    for (size_t i = 0; i < p.size(); i += 3) {
      const float x = heap.at_rest[i], z = heap.at_rest[i + 2];
      if (std::hypot(x, z) < 0.02f) continue;
      sum += std::atan2(static_cast<double>(p[i] * z - p[i + 2] * x), static_cast<double>(p[i] * x + p[i + 2] * z));
      count += 1;
    }
    return sum / count / (150.0 * static_cast<double>(speed));
  };
  const auto carried = [&](float speed, bool turns, float sleep_after) {
    return 0.5 * (share_moved(speed, turns, sleep_after) + share_moved(-speed, turns, sleep_after));
  };
  for (const float speed : {0.0005f, 0.002f, 0.005f})
    for (const bool turns : {false, true}) EXPECT_NEAR(carried(speed, turns, 0.5f), 1.0, 0.1) << speed << turns;
  EXPECT_NEAR(carried(0.002f, false, 0.0f), 1.0, 0.1) << "without any sleep";
}

// ---- saved and restored

std::vector<std::byte> saved(Heap* heap) {
  std::vector<std::byte> bytes;
  accept(heap->scene.scene.save(&bytes));
  return bytes;
}

// The angle at which a heap on a table that is tipped by 2 degrees a second has gone 2 r, degrees.
double flows_at(int save_every) {
  Heap heap(0.01f);
  for (int f = 1; f < 60 * 20; ++f) {
    const float angle = 2.0f * static_cast<float>(f) * k_frame * 0.01745329f;
    accept(heap.scene.scene.set_gravity({9.81f * std::sin(angle), -9.81f * std::cos(angle), 0.0f}));
    if (save_every != 0 && f % save_every == 0) saved(&heap);
    heap.frame();
    if (heap.went(0) > 0.02) return static_cast<double>(angle) * 57.29578;
  }
  return 90.0;
}

TEST(Adopted, AnAutosaveChangesNothingOfATilt) {
  const double alone = flows_at(0);
  EXPECT_LT(alone, 40.0);
  EXPECT_NEAR(flows_at(1), alone, 2.0);
  EXPECT_NEAR(flows_at(60), alone, 2.0);
}

TEST(Adopted, SandIsRestoredOntoTheFloorThatIsThere) {
  Heap heap(0.01f);
  const std::vector<std::byte> bytes = saved(&heap);
  for (const float floor : {0.0f, -0.02f, -0.1f, 0.02f}) {
    for (const int late : {0, 60}) {
      Heap later(0.01f);
      accept(later.scene.scene.restore(bytes));
      later.scene.colliders.clear();
      for (int f = 0; f < late; ++f) later.frame();
      EXPECT_NEAR(later.went(1), 0.0, 1e-6) << "it waits for the planes";
      later.scene.colliders = {sandglass::floor_at(floor)};
      double fastest = 0.0;
      for (int f = 0; f < 480; ++f) {
        later.frame();
        fastest = std::max(fastest, static_cast<double>(later.report.sand.speed_max));
      }
      EXPECT_NEAR(later.went(1), static_cast<double>(floor), 0.003) << floor;
      EXPECT_LE(fastest, gentle(0.01, std::fabs(static_cast<double>(floor)))) << floor;
      if (floor == 0.0f) {
        EXPECT_EQ(fastest, 0.0) << "the same floor wakes nothing";
      }
    }
  }
}

TEST(Adopted, AnotherGravityWakesWhatRests) {
  Heap heap(0.01f);
  const std::vector<std::byte> bytes = saved(&heap);
  for (const bool before : {false, true}) {
    Heap later(0.01f);
    const std::array<float, 3> tipped = {9.81f * std::sin(1.0f), -9.81f * std::cos(1.0f), 0.0f};
    if (before) accept(later.scene.scene.set_gravity(tipped));
    accept(later.scene.scene.restore(bytes));
    if (!before) accept(later.scene.scene.set_gravity(tipped));
    later.run(0.5f);
    EXPECT_GT(later.went(0), 0.1);
  }
  // A move that tilts the sand against gravity by as much.
  const std::array<float, 4> turn = {0.0f, 0.0f, std::sin(0.5f), std::cos(0.5f)};
  accept(heap.scene.scene.move(turn, {0.0f, 0.0f, 0.0f}));
  for (int k = 0; k < 4; ++k) heap.ground().rotation[k] = turn[static_cast<size_t>(k)];
  heap.frame();
  EXPECT_EQ(heap.report.sand.awake, heap.report.sand.particles);
}

}  // namespace
