// White balance that follows the picture: what is drawn has the picture's colours, and the room keeps its own.
#include <cmath>

#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

using Colour = std::array<double, 3>;
using Colours = std::function<Colour(const Direction&)>;

double pattern(const Direction& d) { return 0.2 + 0.08 * std::sin(5 * d.x) * std::cos(4 * d.z) + 0.05 * d.y; }

// An image of what has those colours, by a camera of that balance, told or not. A grey one is taken for each channel.
void look(MadeUpRoom* room, const Colours& colours, double azimuth, const Colour& gains, bool known, uint64_t* now) {
  Photograph p;
  std::vector<uint8_t> bytes;
  for (size_t c = 0; c < 3; ++c) {
    p = photograph([&](const Direction& d) { return colours(d)[c] * gains[c]; }, azimuth, 10, 1, *now);
    bytes.resize(p.bytes.size());
    for (size_t i = c; i < bytes.size(); i += 3) bytes[i] = p.bytes[i];
  }
  *now += 100'000'001;
  p.image.planes[0] = bytes.data();
  for (size_t c = 0; c < 3 && known; ++c) p.image.gains[c] = static_cast<float>(gains[c]);
  room->show(p.image);
}

double red_over_blue(const sandglass_room_light& light) {
  return static_cast<double>(light.irradiance[0] / light.irradiance[2]);
}
double balance(const MadeUpRoom& room) {
  const sandglass_room_light light = room.light();
  return static_cast<double>(light.balance[0] / light.balance[2]);
}

TEST(RoomBalance, WhatIsDrawnHasThePicturesBalanceAtOnceAndTheRoomKeepsItsOwn) {
  const Colours grey = [](const Direction& d) { return Colour{pattern(d), pattern(d), pattern(d)}; };
  for (const bool known : {true, false}) {
    MadeUpRoom room;
    uint64_t now = 1;
    for (int i = 0; i < 36; ++i) look(&room, grey, 10 * i, {1.5, 1, 1.5}, known, &now);
    EXPECT_NEAR(std::log(red_over_blue(room.light())), 0, 0.03);
    sandglass_room_light shown = room.light();
    // Half of the room is never seen in this balance. Where it is told, an image of which nothing is known says it, too.
    const Colour gains = {1.8, 1, 1.2};
    for (int i = 0; i < 6; ++i) look(&room, grey, 10 * i, gains, known, &now);
    const sandglass_room_light light = room.light();
    EXPECT_NEAR(std::log(red_over_blue(light) / 1.5), 0, known ? 0.02 : 0.05);
    // So does what is shown, in one frame; without its balance it is that of before: the control.
    sandglass_room_fade(&shown, &light, 1.0f / 60);
    EXPECT_NEAR(std::log(red_over_blue(shown) / 1.5), 0, known ? 0.02 : 0.05);
    EXPECT_NEAR(std::log(red_over_blue(light) / balance(room)), 0, known ? 0.02 : 0.05);
    for (int i = 0; i < 36; ++i) look(&room, grey, 10 * i, {1.5, 1, 1.5}, known, &now);
    EXPECT_NEAR(std::log(red_over_blue(room.light())), 0, known ? 0.02 : 0.08);
  }
}

TEST(RoomBalance, ColoursOfARoomAndOfAFingerAreNoBalance) {
  const Colours mixed = [](const Direction& d) {
    const double warm = 0.5 + 0.5 * d.x;
    return Colour{pattern(d) * (0.8 + 0.6 * warm), pattern(d), pattern(d) * (1.4 - 0.9 * warm)};
  };
  MadeUpRoom room;
  room.may_teach_nothing = true;
  uint64_t now = 1;
  for (int i = 0; i < 108; ++i) look(&room, mixed, 10 * i, {1, 1, 1}, false, &now);
  EXPECT_NEAR(std::log(balance(room)), 0, 0.05);
  const double before = balance(room);
  const Colours finger = [&](const Direction& d) { return d.z > 0.25 ? Colour{0.3, 0.08, 0.05} : mixed(d); };
  for (int i = 0; i < 20; ++i) look(&room, finger, 0, {1, 1, 1}, false, &now);
  EXPECT_NEAR(std::log(balance(room) / before), 0, 0.05);
}

TEST(RoomBalance, IsSavedWithTheRoom) {
  const Colours grey = [](const Direction& d) { return Colour{pattern(d), pattern(d), pattern(d)}; };
  MadeUpRoom room, other;
  uint64_t now = 1;
  for (const double red : {1.0, 2.0})
    for (int i = 0; i < 4; ++i) look(&room, grey, 10 * i, {red, 1, 1}, true, &now);
  std::vector<std::byte> saved;
  ASSERT_TRUE(room.save(&saved));
  ASSERT_TRUE(other.restore(saved));
  EXPECT_EQ(other.light().balance[0], 2.0f);
  look(&other, grey, 0, {3, 1, 1}, true, &now);
  EXPECT_EQ(other.light().balance[0], 3.0f);
}

}  // namespace
}  // namespace sandglass
