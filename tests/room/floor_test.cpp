// What a thing gets from below: the floor that it stands on, as it was seen there. And how lamps are seen by short images.
#include <string>

#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

constexpr double k_pi_double = std::numbers::pi;
constexpr float k_even = 0.4f;

// Radiance L from below alone is sqrt(pi) L in coefficient 0 and -pi sqrt(3 / 4 pi) L in coefficient 1.
TEST(RoomFloor, PassedInItIsTheLowerHalfOfTheHarmonics) {
  MadeUpRoom room;
  room.look_everywhere([](Direction) { return static_cast<double>(k_even); });
  const float same[3] = {k_even, k_even, k_even}, black[3] = {};
  const sandglass_room_light whole = room.light(0, -1, 0, nullptr, nullptr, same);
  const sandglass_room_light above = room.light(0, -1, 0, nullptr, nullptr, black);
  const double half = std::sqrt(k_pi_double) * static_cast<double>(k_even);
  const double tilt = k_pi_double * std::sqrt(3 / (4 * k_pi_double)) * static_cast<double>(k_even);
  for (uint32_t i = 0; i < 27; ++i) {
    EXPECT_NEAR(whole.sh[i], i < 3 ? 2 * half : 0, 0.02) << i;
    EXPECT_NEAR(above.sh[i], i < 3 ? half : i < 6 ? tilt : 0, 0.02) << i;
  }
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(whole.floor[c], k_even);
    EXPECT_EQ(above.floor[c], 0.0f);
    EXPECT_EQ(whole.irradiance[c], above.irradiance[c]);
  }
  // A floor that the app passes is not clamped; one that was seen is.
  const float bright[3] = {5, 5, 5};
  EXPECT_EQ(room.light(0, -1, 0, nullptr, nullptr, bright).floor[0], 5.0f);
  MadeUpRoom glowing;
  glowing.look_everywhere([](Direction d) { return d.y < 0 ? 0.8 : 0.2; });
  const sandglass_room_light light = glowing.light(0, -1.3f, 0);
  EXPECT_NEAR(light.floor[0], 0.9 * static_cast<double>(light.irradiance[0]) / k_pi_double, 1e-4);
}

// A room with a white rug of 0.9 m on a dark floor, 1.3 m below the camera, which looks at it from one place and then at
// the floor 1.5 m farther on, in the same direction. Each foot has the floor that it stands on.
TEST(RoomFloor, IsThatAroundTheFootFromWhereverItWasSeen) {
  constexpr double k_height = 1.3, k_rug = 1.2, k_walk = 1.5;
  MadeUpRoom room;
  const auto look_from = [&](double x, double elevation, uint64_t time) {
    const Radiance seen = [x](Direction d) {
      if (d.y >= 0) return 0.5;
      const double t = -k_height / d.y, at_x = x + t * d.x, at_z = t * d.z;
      return std::hypot(at_x - k_rug, at_z) < 0.9 ? 0.4 : 0.05;
    };
    Photograph p = photograph(seen, 0, elevation, 1, time);
    p.image.position[0] = static_cast<float>(x);
    room.show(p.image);
  };
  uint64_t time = 0;
  for (const double x : {0.0, k_walk})
    for (int i = 0; i < 4; ++i) {
      look_from(x, -47, time += 200'000'000);
      look_from(x, 30, time += 200'000'000);
    }
  const auto floor_at = [&](double x) { return room.light(static_cast<float>(x), -1.3f, 0).floor[1]; };
  EXPECT_NEAR(floor_at(k_rug), 0.4, 0.08);
  EXPECT_NEAR(floor_at(k_rug + k_walk), 0.05, 0.05);
  // Where it was not seen, of those that were: nothing beyond them.
  EXPECT_LT(floor_at(-2), 0.4);
  EXPECT_GT(floor_at(-2), 0.04);
}

TEST(RoomFloor, WhatIsNoFloorIsRefused) {
  const MadeUpRoom room;
  sandglass_room_light light = {};
  light.struct_size = sizeof light;
  for (const float bad : {-0.1f, NAN, INFINITY}) {
    const float floor[3] = {0.1f, bad, 0.1f};
    const sandglass_room_place place = {sizeof place, {0, 0, 0}, nullptr, nullptr, floor, nullptr, nullptr};
    const char* reason = nullptr;
    EXPECT_EQ(sandglass_room_get(room.handle(), &place, &light, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(std::string(reason).find("place.floor"), std::string::npos);
  }
}

// A lamp of 500 clips at 1/64 too; an image of 1/4096 shows it, and everything else as a few steps of a byte.
TEST(ShortImages, TellHowBrightALampIsAndNothingElse) {
  const Direction lamp = towards(40, 60);
  const Radiance lit = lamp_room(lamp, 6, 500, 0.2);
  MadeUpRoom room;
  room.may_teach_nothing = true;
  room.look_everywhere(lit);
  const auto level = [&] {
    return static_cast<double>(room.light().irradiance[1]) * static_cast<double>(room.light().white);
  };
  const double truth = k_pi_double * (0.2 + (500 - 0.2) * std::pow(std::sin(degrees(6)), 2) * lamp.y);
  EXPECT_LT(level(), 0.3 * truth) << "it is clipped";
  std::vector<double> asked;
  for (int i = 0; i < 4; ++i) {
    room.look(lit, 40, 50);
    asked.push_back(static_cast<double>(room.light().short_exposure));
    if (asked.back() < 1) room.look(lit, 40, 50, asked.back());
  }
  EXPECT_EQ(asked, (std::vector<double>{1.0 / 64, 1.0 / 4096, 1, 1}));
  EXPECT_NEAR(level() / truth, 1, 0.15);
  // Many of them, everywhere: it stays bounded, and the dark stays what it was.
  for (int round = 0; round < 10; ++round)
    for (int azimuth = 0; azimuth < 360; azimuth += 30) {
      room.look(lit, azimuth, 50);
      room.look(lit, azimuth, 50, 1.0 / 64);
      room.look(lit, azimuth, 50, 1.0 / 4096);
    }
  EXPECT_NEAR(level() / truth, 1, 0.25) << "at a picture's rim half of it may be seen";
  // Lamps off are followed all the same.
  for (int i = 0; i < 40; ++i) room.look([](Direction) { return 0.2; }, 40, 50);
  EXPECT_NEAR(level() / (k_pi_double * 0.2), 1, 0.15);
  EXPECT_EQ(room.light().short_exposure, 1.0f);
}

// Its exposure is not told, and it shows hardly anything that is known: it cannot be placed, and teaches nothing.
TEST(ShortImages, OfUnknownExposureAreNotTaken) {
  const Radiance lit = lamp_room(towards(40, 60), 6, 500, 0.2);
  MadeUpRoom room;
  for (int i = 0; i < 12; ++i) room.look(lit, 30.0 * i, 20, 1, false);
  room.may_teach_nothing = true;
  const float before = room.light().irradiance[1];
  room.look(lit, 40, 50, 1.0 / 4096, false);
  EXPECT_FALSE(room.taken());
  EXPECT_EQ(room.light().irradiance[1], before);
  EXPECT_EQ(room.light().short_exposure, 1.0f);
}

}  // namespace
}  // namespace sandglass
