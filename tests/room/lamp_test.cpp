// How large the main light is: against round lamps of known size, by images of short exposure.
#include "runtime/light/room/room.h"
#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

// The whole room, and then the lamp, beside the picture's middle, at the exposures that are asked for.
void look_around(MadeUpRoom* room, const Radiance& lit, double azimuth, double elevation) {
  room->may_teach_nothing = true;
  room->look_everywhere(lit);
  for (int i = 0; i < 40; ++i)
    for (const double exposure : {1.0, 1.0 / 64, 1.0 / 4096})
      room->look(lit, azimuth + 3 * std::sin(1.7 * i), elevation + 3 * std::cos(1.1 * i), exposure);
}
double diameter_deg(const sandglass_room_light& light) {
  return static_cast<double>(light.main_angular_diameter) / degrees(1);
}

TEST(MainLight, ItsSizeIsMeasured) {
  // Azimuth and elevation, across parts and in one; the last lamp clips in every image.
  const double lamps[][4] = {{2.5, 40, 50, 900}, {4, 191, 39, 300},   {6, 100, 45, 500},
                             {12, 300, 62, 60},  {20, 250, 45, 20.0}, {5, 10, 40, 9000}};
  for (const auto& [size, azimuth, elevation, radiance] : lamps) {
    SCOPED_TRACE(size);
    MadeUpRoom room, other;
    look_around(&room, lamp_room(towards(azimuth, elevation), size / 2, radiance), azimuth, elevation);
    const sandglass_room_light light = room.light();
    ASSERT_GT(light.main_share, 0.05f);
    EXPECT_NEAR(diameter_deg(light) / size, 1, 0.3);
    EXPECT_LT(std::fabs(diameter_deg(light) - size) * degrees(1), 2 * static_cast<double>(light.main_angular_error));
    EXPECT_GT(light.main_angular_error, 0);
    EXPECT_LT(static_cast<double>(light.main_angular_error), 0.5 * degrees(size));
    // A meter towards it, of the three to the walls, it is half as large again.
    const Direction to = towards(azimuth, elevation);
    const sandglass_room_light nearer =
        room.light(static_cast<float>(to.x), static_cast<float>(to.y), static_cast<float>(to.z));
    EXPECT_NEAR(nearer.main_angular_diameter / light.main_angular_diameter, 1.5, 0.02);
    // In another session, and on its way to what is shown: at once where none was known.
    std::vector<std::byte> saved;
    ASSERT_TRUE(room.save(&saved));
    ASSERT_TRUE(other.restore(saved));
    EXPECT_EQ(other.light().main_angular_diameter, light.main_angular_diameter);
    sandglass_room_light shown = light;
    shown.main_angular_diameter = 0;
    sandglass_room_fade(&shown, &light, 0.01f);
    EXPECT_EQ(shown.main_angular_diameter, light.main_angular_diameter);
    shown.main_angular_diameter *= 2;
    sandglass_room_fade(&shown, &light, 0.01f);
    EXPECT_NEAR(shown.main_angular_diameter / light.main_angular_diameter, 1 + std::exp(-0.02), 1e-4);
    sandglass_room_reset(room.handle());
    EXPECT_EQ(room.light().main_angular_diameter, 0);
  }
}

// The control: in images of the usual exposure a lamp is clipped, and so is a white wall beside it.
TEST(MainLight, ASizeThatIsNotKnownIsNone) {
  MadeUpRoom usual, wall;
  const Direction lamp = towards(40, 50);
  const Radiance lit = lamp_room(lamp, 3, 500, 0.5);
  usual.look_everywhere(lit);
  for (int i = 0; i < 20; ++i) usual.look(lit, 40, 50);
  EXPECT_EQ(usual.light().main_angular_diameter, 0);
  // A wall that is white from rim to rim of the picture has no size.
  look_around(
      &wall, [](Direction d) { return d.x > 0 ? 3 : 0.2; }, 0, 30);
  EXPECT_EQ(wall.light().main_angular_diameter, 0);
}

// A lamp that comes in at the picture's rim is asked for there, and again once it is whole, until its size is known. One
// that cannot be measured, as its wall is white, too, is asked for a few times.
TEST(MainLight, ItsSizeIsAskedFor) {
  const auto shorts = [](MadeUpRoom* room, const Radiance& lit) {
    room->may_teach_nothing = true;
    uint32_t count = 0;
    for (int i = 0; i < 100; ++i) {
      const double azimuth = 40 + std::fmax(0, 60 - 2 * i);
      room->look(lit, azimuth, 45, 1);
      const auto shorter = static_cast<double>(room->light().short_exposure);
      if (shorter < 1) {
        room->look(lit, azimuth, 45, shorter);
        ++count;
      }
    }
    return count;
  };
  const Direction lamp = towards(40, 50);
  MadeUpRoom room, white;
  EXPECT_LT(shorts(&room, lamp_room(lamp, 3, 300)), 20u);
  EXPECT_NEAR(diameter_deg(room.light()) / 6, 1, 0.3);
  EXPECT_LT(shorts(&white, [](Direction d) { return d.x > 0 ? 1.3 : 0.2; }), 30u);
}

// Of two lamps each has its own; the weaker one is asked for where it is the main light of a plane.
TEST(MainLight, TwoLampsKeepTheirSizes) {
  const Direction large = towards(40, 50), small = towards(220, 45);
  const Radiance lit = [&](Direction d) { return angle_deg(d, large) < 8 ? 60 : angle_deg(d, small) < 2 ? 300 : 0.2; };
  MadeUpRoom room;
  look_around(&room, lit, 40, 50);
  look_around(&room, lit, 220, 45);
  EXPECT_NEAR(diameter_deg(room.light()), 16, 3);
  sandglass_room_place place;
  sandglass_room_place_default(&place);
  const float wall[3] = {static_cast<float>(small.x), 0, static_cast<float>(small.z)};
  place.normal = wall;
  sandglass_room_light light = {};
  light.struct_size = sizeof light;
  ASSERT_EQ(sandglass_room_get(room.handle(), &place, &light, nullptr), SANDGLASS_OK);
  EXPECT_NEAR(diameter_deg(light), 4, 1.2);
}

// What the lamps of a room give its floor, over what all gives it.
double given_by(const std::vector<Direction>& lamps, double half_deg, double radiance, double dim) {
  double lit = 0;
  for (const Direction& lamp : lamps) lit += radiance * std::pow(std::sin(degrees(half_deg)), 2) * lamp.y;
  return lit / (lit + dim);
}

// Two equal lamps near the zenith, 40 degrees apart: one of them is the main light, not what lies between.
TEST(MainLight, OneOfTwoHighLampsIsShown) {
  const std::vector<Direction> lamps = {towards(20, 65), towards(130, 65)};
  const Radiance lit = [&](Direction d) {
    return angle_deg(d, lamps[0]) < 2 || angle_deg(d, lamps[1]) < 2 ? 150 : 0.2;
  };
  MadeUpRoom room;
  look_around(&room, lit, 20, 65);
  look_around(&room, lit, 130, 65);
  const sandglass_room_light light = room.light();
  EXPECT_NEAR(light.main_share, 0.5 * given_by(lamps, 2, 150, 0.2), 0.1);
  EXPECT_LT(std::min(angle_deg(main_of(light), lamps[0]), angle_deg(main_of(light), lamps[1])), 5);
}

// The first short image shows a lamp at its rim: that is a lower bound, and it is asked for again where it is whole.
TEST(MainLight, WhatTheRimCutIsAskedForAgain) {
  const std::vector<Direction> lamp = {towards(28, 45.6)};  // across two rows of parts, of which one is cut
  const Radiance lit = lamp_room(lamp[0], 1.84, 900, 0.3);
  MadeUpRoom room;
  room.may_teach_nothing = true;
  const auto obey = [&](double elevation) {
    room.look(lit, 28, elevation);
    const auto asked = static_cast<double>(room.light().short_exposure);
    if (asked < 1) room.look(lit, 28, elevation, asked);
    return asked < 1;
  };
  for (int i = 0; i < 12; ++i) obey(18.4);
  room.look_everywhere(lit);
  int asked = 0;
  for (int i = 0; i < 8; ++i) asked += obey(35) ? 1 : 0;
  EXPECT_GT(asked, 0);
  double known = 0;  // irradiance of the floor from all parts, as if their light came from their middles
  for (uint32_t i = k_room_below; i < k_room_parts; ++i) {
    const double elevation = std::numbers::pi * ((i / k_room_columns + 0.5) / k_room_rows - 0.5);
    const double facing = std::sin(elevation) * std::cos(elevation) * std::pow(std::numbers::pi / k_room_rows, 2);
    known += static_cast<double>(room.handle()->room.parts[i].radiance[1]) * room.handle()->room.light * facing;
  }
  EXPECT_NEAR(known / (std::numbers::pi * 0.3 / (1 - given_by(lamp, 1.84, 900, 0.3))), 1, 0.1);
}

}  // namespace
}  // namespace sandglass
