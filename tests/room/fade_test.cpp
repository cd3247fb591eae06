// What is shown, frame by frame, beside what is known: no jump while a session goes on.
#include <cstring>

#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

constexpr float k_frame = 1.0f / 60;
const double k_share = 1 - std::exp(-1.0 / 30);  // what a frame may move: 1 - exp(-frame / half a second)

// The most by which the floor's ratio can change anywhere: half the sum of the changes of all shares of light.
double moved(const sandglass_room_light& a, const sandglass_room_light& b) {
  double sum = std::fabs(static_cast<double>(a.main_share - b.main_share));
  for (int i = 0; i < 64; ++i) sum += std::fabs(static_cast<double>(a.ambient_cells[i] - b.ambient_cells[i]));
  return 0.5 * sum;
}
double all_shares(const sandglass_room_light& light) {
  double sum = static_cast<double>(light.main_share);
  for (const float c : light.ambient_cells) sum += static_cast<double>(c);
  return sum;
}
// Ten images a second, sixty frames: the camera turns around once in ten seconds, its exposure swings by a factor of
// four, and after twelve seconds the lamp is switched off while the camera looks at it.
TEST(RoomFade, NothingJumpsInASession) {
  const Direction lamp = towards(120, 40);
  MadeUpRoom room;
  sandglass_room_light now = room.light(), shown = now;
  double known_max = 0, shown_max = 0, level_max = 0;
  for (int frame = 0; frame < 15 * 60; ++frame) {
    const sandglass_room_light known = now, before = shown;
    if (frame % 6 == 0) {
      const bool on = frame < 12 * 60;
      const double azimuth = on ? 0.6 * frame : 120, exposure = std::exp2(std::sin(frame / 60.0));
      room.look(lamp_room(lamp, 6, on ? 30 : 0.2, 0.2), azimuth, 30, (frame % 18 == 0 ? 1.0 / 64 : 1.0) * exposure);
      now = room.light();
    }
    sandglass_room_fade(&shown, &now, k_frame);
    known_max = std::max(known_max, moved(known, now));
    shown_max = std::max(shown_max, moved(before, shown));
    ASSERT_LE(moved(before, shown), k_share * 1.01) << frame;
    ASSERT_NEAR(all_shares(shown), 1.0, 1e-4);
    if (before.valid == 0) continue;
    const auto level = [](const sandglass_room_light& l) { return static_cast<double>(l.irradiance[1] * l.white); };
    const double gap = std::fabs(level(now) - level(before)), step = std::fabs(level(shown) - level(before));
    ASSERT_LE(step, k_share * 1.01 * gap + 1e-5) << frame;
    level_max = std::max(level_max, step);
  }
  EXPECT_GT(known_max, 0.1);  // the control: without the fade it jumps
  EXPECT_LT(shown_max, 0.02);
  EXPECT_GT(level_max, 0.0);
}

TEST(RoomFade, AnotherMainLightComesOutOnlyWhenTheOldOneIsGone) {
  const Direction first = towards(30, 50), second = towards(200, 50);
  const auto seen = [](Direction lamp) {
    MadeUpRoom room;
    for (int turn = 0; turn < 3; ++turn) room.look_everywhere(lamp_room(lamp, 6, 60), 1.0 / 64);
    return room.light();
  };
  const sandglass_room_light from = seen(first), to = seen(second);
  ASSERT_GT(from.main_share, 0.3f);
  ASSERT_GT(to.main_share, 0.3f);
  sandglass_room_light shown = from;
  bool gone = false;
  for (int frame = 0; frame < 10 * 60; ++frame) {
    const sandglass_room_light before = shown;
    sandglass_room_fade(&shown, &to, k_frame);
    ASSERT_LE(moved(before, shown), k_share * 1.01);
    if (angle_deg(main_of(before), main_of(shown)) < 1) continue;
    gone = true;
    EXPECT_LE(before.main_share, 0.011f);  // it turns where nobody can see it
  }
  EXPECT_TRUE(gone);
  EXPECT_LT(moved(shown, to), 0.001);
  EXPECT_LT(angle_deg(main_of(shown), main_of(to)), 0.1);
}

// A lamp that an object is carried past moves with it: its shadow turns, and does not go away.
TEST(RoomFade, AMainLightThatMovesALittleTurns) {
  MadeUpRoom room;
  for (int turn = 0; turn < 3; ++turn) room.look_everywhere(lamp_room(towards(90, 50), 6, 60), 1.0 / 64);
  sandglass_room_light shown = room.light();
  const sandglass_room_light now = room.light(0.5f, 0, 0);
  const double angle = angle_deg(main_of(shown), main_of(now));
  ASSERT_GT(angle, 3.0);
  ASSERT_LT(angle, 20.0);
  const float share_min = std::min(shown.main_share, now.main_share) - 0.001f;
  for (int frame = 0; frame < 5 * 60; ++frame) {
    const Direction before = main_of(shown);
    sandglass_room_fade(&shown, &now, k_frame);
    EXPECT_LT(angle_deg(before, main_of(shown)), 1.1 * k_share * angle);
    EXPECT_GE(shown.main_share, share_min);
  }
  EXPECT_LT(angle_deg(main_of(shown), main_of(now)), 0.1);
}

TEST(RoomFade, AChangeOfExposureIsFollowedAtOnce) {
  MadeUpRoom room;
  const Radiance even = [](Direction) { return 0.2; };
  room.look_everywhere(even);
  sandglass_room_light shown = room.light();
  const float before = shown.irradiance[1], harmonic = shown.sh[1];
  room.look(even, 0, 0, 2.0);
  const sandglass_room_light now = room.light();
  sandglass_room_fade(&shown, &now, k_frame);
  EXPECT_NEAR(shown.irradiance[1], 2 * before, 0.02f * before);
  EXPECT_NEAR(shown.sh[1], 2 * harmonic, 0.02f * harmonic);
}

TEST(RoomFade, WhatItCannotUseChangesNothing) {
  MadeUpRoom room;
  const sandglass_room_light prior = room.light();
  room.look([](Direction) { return 0.3; }, 0, 0);
  const sandglass_room_light now = room.light();
  sandglass_room_light shown = prior;
  for (const float seconds : {NAN, INFINITY, -1.0f, 1e9f, 0.0f}) sandglass_room_fade(&shown, &now, seconds);
  EXPECT_EQ(std::memcmp(shown.cells, prior.cells, sizeof prior.cells), 0);
  EXPECT_EQ(shown.irradiance[1], prior.irradiance[1]);
  const sandglass_room_light still = shown;
  for (float* number : {&shown.cells[5], &shown.main_share, &shown.sh[26], &shown.white}) {
    sandglass_room_light broken = now;
    *reinterpret_cast<float*>(reinterpret_cast<char*>(&broken) +
                              (reinterpret_cast<char*>(number) - reinterpret_cast<char*>(&shown))) = NAN;
    sandglass_room_fade(&shown, &broken, k_frame);
    EXPECT_EQ(std::memcmp(&shown, &still, sizeof still), 0) << "a number that is none would stay for ever";
  }
  sandglass_room_light not_filled = {};
  sandglass_room_fade(&shown, &not_filled, 1.0f);
  EXPECT_EQ(shown.irradiance[1], prior.irradiance[1]);
  sandglass_room_fade(&not_filled, &now, k_frame);  // nothing was shown: it becomes what is known
  EXPECT_EQ(std::memcmp(&not_filled, &now, sizeof now), 0);
}

}  // namespace
}  // namespace sandglass
