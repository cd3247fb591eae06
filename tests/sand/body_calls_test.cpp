// What an app does to rigid bodies while the scene runs: removes them, puts them elsewhere, pushes them, lets a sink
// take them. Numbers and room are used again for ever, and what is near wakes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "models/geometry/vec3.h"
#include "runtime/math/random.h"
#include "tests/sand/granular_scene.h"

namespace {

using namespace sandglass::host;

constexpr float k_radius = 0.01f, k_frame = 0.02f, k_spacing = 2.01f * k_radius;

// x * y * z particles, the lowest layer at `height`.
std::vector<float> block(uint32_t x, uint32_t y, uint32_t z, float at_x = 0.0f, float height = k_radius) {
  return shifted(lattice(x, y, z, k_spacing, height), at_x, 0.0f, 0.0f);
}

// Bodies of 1 to 40 particles come and go 10,000 times. There is room for exactly 100 particles: one that fits is never
// refused, and one particle more always is. All that are there keep their numbers and their places.
TEST(BodyCalls, NumbersAndRoomAreUsedAgainForEver) {
  GranularScene scene(with_bodies(0, 6, 100));
  sandglass::Random random{7};
  std::map<uint32_t, std::pair<uint32_t, float>> present;  // particles and height by index
  uint32_t used = 0, refused = 0, removed = 0, removed_particles = 0, lowest = 0;
  for (int round = 0; round < 10000; ++round) {
    const uint32_t count = 1 + random.below(40);
    std::vector<float> points;
    for (uint32_t i = 0; i < count; ++i)
      for (const float c : {0.03f * static_cast<float>(i), static_cast<float>(round % 97), 0.0f}) points.push_back(c);
    for (lowest = 0; present.count(lowest) != 0;) ++lowest;
    if (lowest == 6 || count > 100 - used) {
      ASSERT_THROW(scene.add_body(points), std::runtime_error);
      ++refused;
      auto gone = std::next(present.begin(), random.below(static_cast<uint32_t>(present.size())));
      accept(scene.scene.remove_body(gone->first));
      EXPECT_FALSE(scene.scene.has_body(gone->first));
      used -= gone->second.first;
      removed_particles += gone->second.first;
      ++removed;
      present.erase(gone);
    } else {
      ASSERT_EQ(scene.add_body(points), lowest);
      present[lowest] = {count, points[1]};
      used += count;
    }
    for (const auto& [index, body] : present) ASSERT_EQ(scene.scene.body_pose(index).position[1], body.second);
  }
  const sandglass_frame_report report = scene.frame(0.0f);
  EXPECT_EQ(report.sand.particles, used);
  EXPECT_LE(report.sand.particle_numbers, 100u);
  EXPECT_EQ(report.sand.removed_bodies, removed);
  EXPECT_EQ(report.sand.removed_particles, removed_particles);
  EXPECT_GT(std::min(refused, removed), 3000u);
}

// Three heaps sleep, a body under the first. Without it its heap falls; moved to the second, it wakes that too. The
// third sleeps on: it is the control, that not everything wakes.
TEST(BodyCalls, WhatIsNearWakesAtBothPlacesAndNothingElse) {
  for (const bool moved : {false, true}) {
    GranularScene scene(with_bodies(75, 1, 75));
    scene.add_floor();
    scene.add_body(block(5, 3, 5));
    for (const float x : {0.0f, 1.0f, 2.0f})
      scene.add(block(5, 1, 5, x, x > 0.0f ? k_radius : k_radius + 3 * k_spacing));
    until_asleep(&scene);
    const std::vector<float> before = scene.positions();
    sandglass_body_pose pose = scene.scene.body_pose(0);
    pose.position[0] += 1.0f;
    pose.position[1] += k_spacing;
    accept(moved ? scene.scene.set_body(0, pose) : scene.scene.remove_body(0));
    EXPECT_EQ(scene.frame(1e-4f).sand.awake, moved ? 125u : 25u);
    for (int frame = 0; frame < 25; ++frame) scene.frame(k_frame);
    const std::vector<float> after = scene.positions();
    for (size_t i = 75; i < 100; ++i) EXPECT_LT(after[3 * i + 1], before[3 * i + 1] - 1.5f * k_spacing) << i;
    for (size_t i = 3 * 125; i < after.size(); ++i) EXPECT_EQ(after[i], before[i]) << "the third heap";
    EXPECT_EQ(scene.scene.has_body(0), moved);
  }
}

// Puts particle i where a double-precision pose does.
TEST(BodyCalls, APlacedBodyIsWhereThePoseSaysAndGoesOnFromThere) {
  sandglass_scene_desc desc = with_bodies(0, 1, 24);
  desc.gravity[1] = 0.0f;
  GranularScene scene(desc);
  const std::vector<float> rest = block(4, 3, 2);
  scene.add_body(rest);
  const sandglass_body_pose start = scene.scene.body_pose(0);
  // 120 degrees about (1, 1, 1), of another length: x goes to y, y to z, z to x.
  accept(scene.scene.set_body(0, {{1, 2, 3}, {2, 2, 2, 2}, {0.5f, 0, -0.25f}, {0, 0, 0}}));
  const auto expect_at = [&](double seconds, double limit) {
    const std::vector<float> p = scene.positions();
    for (size_t i = 0; i < rest.size(); i += 3)
      for (size_t k = 0; k < 3; ++k) {
        const double displacement = seconds * std::array{0.5, 0.0, -0.25}[k];
        const size_t from = (k + 2) % 3;
        const double arm = static_cast<double>(rest[i + from]) - static_cast<double>(start.position[from]);
        EXPECT_NEAR(p[i + k], static_cast<double>(k + 1) + arm + displacement, limit);
      }
  };
  expect_at(0.0, 3e-7);
  for (int frame = 0; frame < 50; ++frame) scene.frame(k_frame);
  expect_at(1.0, 1e-5);  // as for any body that flies: bodies_test.cpp
}

// In the midst of a heap. A pair may separate at 0.9 sqrt(g d); all else is a fall from the heap's height. The control:
// an overlap of a tenth of a radius, resolved within a sub-step, is faster than that. Without its way out, sand between
// the body's particles trembled for ever, at up to 7 m/s.
TEST(BodyCalls, ABodyPutIntoSandPartsItGently) {
  const double limit = 0.9 * std::sqrt(9.81 * 0.02) + std::sqrt(2 * 9.81 * 0.1);
  for (const bool added : {false, true}) {
    GranularScene scene(with_bodies(500, 1, 27));
    scene.add_floor();
    scene.add(block(10, 5, 10));
    if (!added) scene.add_body(block(3, 3, 3, 2.0f));
    until_asleep(&scene);
    if (added) scene.add_body(shifted(block(3, 3, 3, 0.08f, 0.03f), 0.0f, 0.0f, 0.08f));
    else accept(scene.scene.set_body(0, {{0.1f, 0.05f, 0.1f}, {0, 0, 0, 1}, {}, {}}));
    double fastest = 0.0;
    for (int frame = 0; frame < 50; ++frame)
      fastest = std::max(fastest, static_cast<double>(scene.frame(k_frame).sand.speed_max));
    EXPECT_LT(fastest, limit);
    EXPECT_LT(limit, 0.1 * 0.01 / static_cast<double>(scene.frame(k_frame).sand.substep));
    until_asleep(&scene);
  }
}

// Put into another body, by up to all of it, it has that beside it. Interlocked, the two flew about at up to 36 m/s and
// never slept. Nothing is faster now than a fall from a body's height onto the floor, and a separation.
TEST(BodyCalls, ABodyPutIntoAnotherPartsFromItGently) {
  for (const float x : {0.0f, 0.005f, 0.03f, 0.05f, 0.07f})
    for (const float y : {0.0f, 0.03f}) {
      GranularScene scene(with_bodies(0, 2, 128));
      scene.add_floor();
      scene.add_body(block(4, 4, 4));
      scene.add_body(block(4, 4, 4, 2.0f));
      until_asleep(&scene);
      sandglass_body_pose pose = scene.scene.body_pose(0);
      pose.position[0] += x;
      pose.position[1] += y;
      accept(scene.scene.set_body(1, pose));
      for (int frame = 0; frame < 100; ++frame)
        EXPECT_LT(scene.frame(k_frame).sand.speed_max, 0.9 * std::sqrt(9.81 * 0.02) + std::sqrt(2 * 9.81 * 0.08))
            << x << ' ' << y;
      EXPECT_EQ(until_asleep(&scene).sand.particles, 128u);
      const sandglass_body_pose a = scene.scene.body_pose(0), b = scene.scene.body_pose(1);
      EXPECT_GT(std::hypot(a.position[0] - b.position[0], a.position[1] - b.position[1], a.position[2] - b.position[2]),
                0.07f);
    }
}

// Dragged through sand at 60 Hz, with the velocity of its way. It takes away what it meets, which is nowhere faster
// than the body, a separation and the fall from a heap's height together; a body that only stands elsewhere, the
// control, takes nothing with it.
TEST(BodyCalls, ADraggedBodyPushesWhatItMeets) {
  const auto beyond = [](float speed, bool dragged) {
    GranularScene scene(with_bodies(800, 1, 64));
    scene.add_floor();
    scene.add_body(block(4, 4, 4, -0.2f));
    scene.add(block(20, 4, 10));
    until_asleep(&scene);
    sandglass_body_pose pose = scene.scene.body_pose(0);
    pose.position[2] = 0.09f;
    pose.linear_velocity[0] = dragged ? speed : 0.0f;
    for (float displacement = 0.0f; displacement < 0.6f; displacement += speed / 60.0f) {
      if (dragged) pose.position[0] += speed / 60.0f;
      accept(scene.scene.set_body(0, pose));
      EXPECT_LT(scene.frame(1.0f / 60.0f).sand.speed_max,
                speed + 0.9 * std::sqrt(9.81 * 0.02) + std::sqrt(2 * 9.81 * 0.1));
    }
    accept(scene.scene.remove_body(0));
    until_asleep(&scene);
    const std::vector<float> p = scene.positions();
    int count = 0;
    for (size_t i = 0; i < p.size(); i += 3) count += p[i] > 20.0f * k_spacing + 2.0f * k_radius ? 1 : 0;
    return count;
  };
  for (const float speed : {0.3f, 1.0f}) EXPECT_GT(beyond(speed, true), beyond(speed, false) + 64) << speed;
}

// What the body's particles gain is the impulse, and about the centre of mass (point - c) x impulse, in double from
// their own velocities; and they move as the pose says. That is the rigid-body formula. A straight body does not take
// what would spin it about its line. The control: at the centre, it gains no spin.
TEST(BodyCalls, APushIsTheRigidBodyFormula) {
  sandglass::Random random{3};
  const auto number = [&] { return static_cast<float>(random.below(2001)) / 1000.0f - 1.0f; };
  for (int round = 0; round < 60; ++round) {
    const bool straight = round % 6 == 5, at_centre = round % 6 == 4;
    GranularScene scene(with_bodies(0, 1, 48));
    std::vector<float> points = straight ? block(8, 1, 1) : block(6, 4, 2);
    points.resize(points.size() - (straight ? 0 : 3 * random.below(20)));  // so its principal axes are those of no box
    scene.add_body(points, round % 2 == 0 ? 1.0f : 8.0f);
    accept(scene.scene.set_body(0, {{number(), number(), number()},
                                    {number(), number(), number(), 1.5f},
                                    {number(), number(), number()},
                                    {number(), number(), number()}}));
    const std::vector<float> p = scene.positions(), before = scene.velocities();
    const Vec3 centre = from_floats(scene.scene.body_pose(0).position);
    const float at[3] = {p[0] + 0.05f * number(), p[1] + 0.05f * number(), p[2] + 0.05f * number()};
    const std::array<float, 3> impulse = {number(), number(), number()};
    accept(scene.scene.push_body(0, impulse, at_centre ? nullptr : at));
    const std::vector<float> v = scene.velocities();
    const sandglass_body_pose pose = scene.scene.body_pose(0);
    Vec3 gained{}, spin{};
    for (size_t i = 0; i < p.size(); i += 3) {
      const Vec3 r = from_floats(&p[i]) - centre, now = from_floats(&v[i]), more = now - from_floats(&before[i]);
      const Vec3 rigid = from_floats(pose.linear_velocity) + cross(from_floats(pose.angular_velocity), r);
      EXPECT_LT(length(now - rigid), 1e-5);
      gained = gained + more * (3.0 / static_cast<double>(p.size()));
      spin = spin + cross(r, more) * (3.0 / static_cast<double>(p.size()));
    }
    const Vec3 push = from_floats(impulse.data());
    Vec3 expected = at_centre ? Vec3{} : cross(from_floats(at) - centre, push);
    const Vec3 line = normalised(from_floats(p.data()) - centre);
    if (straight) expected = expected - line * dot(line, expected);
    EXPECT_LT(length(gained - push), 1e-6);
    EXPECT_LT(length(spin - expected), 1e-6) << round;
    EXPECT_EQ(length(spin) > 1e-5, !at_centre) << round;
  }
}

TEST(BodyCalls, ASleepingBodyThatIsPushedSlides) {
  GranularScene scene(with_bodies(0, 1, 27));
  scene.add_floor();
  scene.add_body(block(3, 3, 3));
  until_asleep(&scene);
  const float before = scene.scene.body_pose(0).position[0];
  accept(scene.scene.push_body(0, {1.0f, 0.0f, 0.0f}));
  until_asleep(&scene);
  // v^2 / (2 mu g), for mu = 0.16 on the floor; particles' friction is within a tenth of it there.
  EXPECT_NEAR((scene.scene.body_pose(0).position[0] - before) / (1.0 / (2 * 0.16 * 9.81)), 1.0, 0.1);
}

// One wholly in the sink goes, one half in stays, and one that sleeps inside stays until it wakes.
TEST(BodyCalls, ASinkTakesWhatIsWhollyInsideAndAwake) {
  GranularScene scene(with_bodies(0, 3, 81));
  scene.add_floor();
  for (const float x : {0.0f, 0.5f, 1.0f}) scene.add_body(block(3, 3, 3, x));
  until_asleep(&scene);
  scene.sinks = {sandglass::box(0.5f, 0.0f, 0.0f, 0.53f, 0.2f, 0.2f)};  // up to 1.03: half of the last
  const auto drained = [&] {
    sandglass_frame_report report = {};
    for (int frame = 0; frame < 5; ++frame) report = scene.frame(k_frame);
    return report;
  };
  EXPECT_EQ(drained().sand.removed_bodies, 0u) << "all sleep";
  for (const uint32_t index : {1u, 2u}) accept(scene.scene.push_body(index, {0.0f, 0.01f, 0.0f}));
  const sandglass_frame_report report = drained();
  EXPECT_EQ(report.sand.removed_bodies, 1u);
  EXPECT_EQ(report.sand.removed_particles, 27u);
  EXPECT_EQ(report.sand.particles, 54u);
  const std::array<bool, 4> there = {true, false, true, false};
  for (uint32_t index = 0; index < 4; ++index) EXPECT_EQ(scene.scene.has_body(index), there[index]);
  EXPECT_EQ(scene.scene.body_pose(1).position[0], 0.0f);
  EXPECT_EQ(scene.scene.body_pose(1).rotation[3], 1.0f);
  EXPECT_EQ(scene.add_body(block(3, 3, 3, 2.0f)), 1u);
}

// Numbers with a hole, and slots that are not in the order of the numbers, come back from the bytes; a hole that holds
// something is refused.
TEST(BodyCalls, HolesAreSavedAndRestored) {
  GranularScene scene(with_bodies(0, 4, 100)), other(with_bodies(0, 4, 100));
  scene.add_floor();
  other.add_floor();
  for (const float x : {0.0f, 0.2f, 0.4f, 0.6f}) scene.add_body(block(2, 3, 2, x, 0.1f));
  for (const uint32_t index : {0u, 1u}) accept(scene.scene.remove_body(index));
  scene.add_body(block(3, 3, 3, -0.5f, 0.1f), 2.0f);  // number 0, the last slots; 1 stays free
  for (int frame = 0; frame < 5; ++frame) scene.frame(k_frame);
  std::vector<std::byte> saved;
  accept(scene.scene.save(&saved));
  accept(other.scene.restore(saved));
  for (GranularScene* each : {&scene, &other}) {
    for (int frame = 0; frame < 20; ++frame) each->frame(k_frame);
    EXPECT_EQ(each->add_body(block(2, 2, 2, 1.0f)), 1u);
    accept(each->scene.remove_body(3));
    for (int frame = 0; frame < 20; ++frame) each->frame(k_frame);
  }
  EXPECT_EQ(scene.hash(), other.hash());
}

TEST(BodyCalls, WhatIsWrongIsRefusedAndChangesNothing) {
  GranularScene scene(with_bodies(0, 2, 16));
  scene.add_body(block(2, 2, 2));
  scene.add_body(block(2, 2, 2, 1.0f));
  accept(scene.scene.remove_body(0));
  const uint64_t before = scene.hash();
  const sandglass_body_pose good = scene.scene.body_pose(1);
  const auto refused = [&](const sandglass::Status& status, const char* why) {
    EXPECT_EQ(status.code, SANDGLASS_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(std::string(status.reason).find(why), std::string::npos) << status.reason;
    EXPECT_EQ(scene.hash(), before);
  };
  for (const uint32_t none : {0u, 2u, 255u, ~0u}) {
    refused(scene.scene.remove_body(none), "no body has this index");
    refused(scene.scene.set_body(none, good), "no body has this index");
    refused(scene.scene.push_body(none, {1, 0, 0}), "no body has this index");
  }
  const auto wrong = [&](const char* why, const auto& change) {
    sandglass_body_pose pose = good;
    change(&pose);
    refused(scene.scene.set_body(1, pose), why);
  };
  wrong("finite", [](sandglass_body_pose* p) { p->position[2] = NAN; });
  wrong("finite", [](sandglass_body_pose* p) { p->angular_velocity[0] = INFINITY; });
  wrong("length", [](sandglass_body_pose* p) { p->rotation[3] = 0.0f; });
  wrong("above", [](sandglass_body_pose* p) { p->linear_velocity[1] = 10001.0f; });
  wrong("1000 m", [](sandglass_body_pose* p) { p->position[0] = 999.995f; });
  const float far[3] = {1001.0f, 0.0f, 0.0f};
  refused(scene.scene.push_body(1, {NAN, 0, 0}), "finite");
  refused(scene.scene.push_body(1, {1, 0, 0}, far), "1000 m");
  refused(scene.scene.push_body(1, {1e5f, 0, 0}), "faster");
  accept(scene.scene.set_body(1, good));
}

}  // namespace
