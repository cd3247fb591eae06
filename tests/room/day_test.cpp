// What happens to a phone in a day: lamps switched off and on, a finger over the lens, the flash lamp, metadata that come
// late, clocks that are wrong, lamps at the zenith. The room is known, so is what must come out.
#include <string>

#include "runtime/light/room/room.h"
#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

double level_of(const sandglass_room_light& light) { return static_cast<double>(light.irradiance[1] * light.white); }

// Walls with a pattern, and a lamp.
double patterned(Direction d) {
  const double wall = 0.2 + 0.1 * std::sin(5 * d.x + 1) * std::cos(4 * d.z) + (d.y < 0 ? -0.06 : 0.05 * d.y);
  return angle_deg(d, towards(40, 55)) < 6 ? 12.0 : wall;
}

// A camera that brings the mean of its images to 0.18, by a share of the way in each: ten images a second.
class AdaptingPhone {
 public:
  explicit AdaptingPhone(double speed) : speed_(speed) { room.may_teach_nothing = true; }
  MadeUpRoom room;
  float walked = 0;   // metres
  bool tells = true;  // its exposures
  // What is shown over the last image, comparable with the world's.
  sandglass_room_light shown = {};
  double shown_level = 0;

  void see(const Radiance& radiance, double azimuth, double elevation) {
    now_ += 100'000'000;
    Photograph p = photograph(radiance, azimuth, elevation, gain_, now_);
    p.image.position[0] = walked;
    if (!tells) p.image.exposure = 0;
    room.show(p.image);
    const sandglass_room_light now = light();
    if (shown.struct_size == 0) shown = now;
    sandglass_room_fade(&shown, &now, 0.1f);
    shown_level = static_cast<double>(shown.irradiance[1] * sandglass_room_exposure(&shown, &p.image)) / gain_;
    double sum = 0;
    for (const uint8_t byte : p.bytes) sum += std::pow(byte / 255.0, 2.2);
    const double wanted = gain_ * 0.18 / std::max(sum / static_cast<double>(p.bytes.size()), 1e-3);
    gain_ += speed_ * (std::clamp(wanted, 0.02, 8.0) - gain_);
  }
  void look_around(const Radiance& radiance = patterned) {
    for (int i = 0; i < 150; ++i) see(radiance, 7.2 * i, 60 * std::sin(i / 15.0));
    rest(radiance, 20);
  }
  // It looks at floor and wall.
  void rest(const Radiance& radiance, int images) {
    for (int i = 0; i < images; ++i) see(radiance, 200, -20);
  }
  sandglass_room_light light() const { return room.light(walked); }
  double level() const { return level_of(light()); }

 private:
  double speed_, gain_ = 0.7;
  uint64_t now_ = 1;
};

TEST(RoomDay, LampsThatComeBackGiveWhatTheyGave) {
  for (const double part : {6.0, 0.4, 0.1, 0.03})
    for (const double speed : {0.0, 0.7, 0.2}) {
      SCOPED_TRACE(std::to_string(part) + " " + std::to_string(speed));
      const Radiance dim = [part](Direction d) { return part * patterned(d); };
      AdaptingPhone phone(speed);
      phone.look_around();
      const double before = phone.level();
      for (int turn = 0; turn < 3; ++turn) {
        phone.rest(dim, 40);
        EXPECT_NEAR(phone.level() / before, part, 0.1 * part);
        phone.rest(patterned, 15);
        EXPECT_NEAR(phone.level() / before, 1, 0.05);
      }
    }
}

// A finger's red glow; a grey cloth; black; white; a flash lamp, which lights what is below and near.
TEST(RoomDay, WhatCoversTheLensTeachesNothing) {
  const Radiance covers[] = {[](Direction d) { return 0.02 + 0.008 * d.x; }, [](Direction) { return 0.0; },
                             [](Direction) { return 400.0; },
                             [](Direction d) { return patterned(d) * (d.y < 0 ? 1 - 3 * d.y : 1); }};
  for (int k = 0; k < 4; ++k) {
    SCOPED_TRACE(k);
    AdaptingPhone phone(0.5);
    phone.look_around();
    const double before = phone.level();
    const Direction lamp = main_of(phone.room.light());
    phone.rest(covers[k], 20);
    if (k < 3) {
      EXPECT_NEAR(phone.level() / before, 1, 0.02);
    }
    phone.rest(patterned, 20);
    EXPECT_NEAR(phone.level() / before, 1, 0.05);
    EXPECT_LT(angle_deg(main_of(phone.room.light()), lamp), 2);
  }
}

// A finger's tip over a fifth of the picture could be a dark thing that was put there, and is learned where it stays. One
// image of it moves such parts by their share among the images, not by half.
TEST(RoomDay, OneImageOfAFingersTipHardlyTeaches) {
  AdaptingPhone phone(0.5);
  phone.look_around();
  const RoomPart* parts = phone.room.handle()->room.parts;
  const auto known = [&] { return std::vector<RoomPart>(parts, parts + k_room_parts); };
  const Direction right = towards(290, 0);
  const Radiance tip = [&](Direction d) { return cosine(d, right) > 0.2 ? 0.02 : patterned(d); };
  const std::vector<RoomPart> before = known();
  phone.rest(tip, 1);
  const std::vector<RoomPart> once = known();
  phone.rest(tip, 10);
  double left = 0, count = 0;
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    if (!(parts[i].radiance[1] < 0.75f * before[i].radiance[1])) continue;
    left += static_cast<double>(once[i].radiance[1] / before[i].radiance[1]);
    ++count;
  }
  EXPECT_GE(count, 8);
  EXPECT_GT(left / count, 0.8);
}

// Over an even floor nothing but how dark or bright it is tells a finger or glare from lamps. What is beyond a factor
// of 20 waits; the control, at 10, is a lamp less, and is believed at once.
TEST(RoomDay, WhatIsFarTooDarkOrBrightWaits) {
  const Radiance even = [](Direction d) { return angle_deg(d, towards(40, 55)) < 6 ? 12.0 : 0.3; };
  for (const double factor : {0.02, 50.0, 0.1}) {
    SCOPED_TRACE(factor);
    AdaptingPhone phone(0.5);
    phone.look_around(even);
    const double before = phone.level();
    phone.rest([factor](Direction d) { return 0.3 * factor * (1 + 0.3 * d.x); }, 20);
    if (factor == 0.1) EXPECT_LT(phone.level() / before, 0.2);
    else EXPECT_NEAR(phone.level() / before, 1, 0.02);
  }
}

// The light changes behind a finger. When the finger goes, the exposure returns to what it was over half a second, and
// shows little at first: that must not be learned as if nothing had changed.
TEST(RoomDay, AChangeBehindAFingerIsFollowed) {
  for (const double part : {3.0, 1.42, 0.3}) {
    SCOPED_TRACE(part);
    const Radiance other = [part](Direction d) { return part * patterned(d); };
    AdaptingPhone phone(0.2);
    phone.look_around(patterned);
    const double before = phone.level();
    phone.rest([](Direction d) { return 0.004 + 0.001 * d.x; }, 20);
    phone.rest(other, 40);
    EXPECT_NEAR(phone.level() / before / part, 1, 0.1);
    phone.rest(patterned, 40);
    EXPECT_NEAR(phone.level() / before, 1, 0.1);
  }
}

// Another room, of 1/20 or 20 times the light, behind a door that is 6 m away, or whose place is not told: after a second
// the level is within a factor of 2 of what is known there in the end, or of what a room says that has just begun; in the
// end it is within a quarter of that, and where the way is told the old room is forgotten: the main light is the new one.
TEST(RoomDay, AnotherRoomIsBelieved) {
  for (const double part : {0.05, 20.0})
    for (const float walked : {0.0f, 6.0f}) {
      SCOPED_TRACE(std::to_string(part) + " " + std::to_string(walked));
      const Radiance other = [part](Direction d) {
        return part * (angle_deg(d, towards(160, 50)) < 6 ? 24 : 0.3 + 0.2 * std::sin(6 * d.z) * std::cos(3 * d.x + 2));
      };
      AdaptingPhone there(0.5), begins(0.5), phone(0.5);
      there.look_around(other);
      phone.look_around(patterned);
      EXPECT_GT(std::fabs(std::log(phone.level() / there.level())), std::log(10));
      phone.walked = walked;
      phone.rest(other, 10);
      begins.rest(other, 10);
      EXPECT_LT(phone.level(), 2 * std::max(begins.level(), there.level()));
      EXPECT_GT(phone.level(), 0.5 * std::min(begins.level(), there.level()));
      phone.look_around(other);
      EXPECT_NEAR(phone.level() / there.level(), 1, 0.25);
      if (walked > 0) {
        EXPECT_LT(angle_deg(main_of(phone.light()), towards(160, 50)), 4);
      }
    }
}

// A phone that lies on its side sees what it saw.
TEST(RoomDay, ATurnedPhoneSeesTheSame) {
  MadeUpRoom room;
  room.may_teach_nothing = true;
  room.look_everywhere(patterned);
  const sandglass_room_light before = room.light();
  for (uint64_t i = 0; i < 30; ++i)
    room.show(photograph(patterned, 200, -20, 1, 1'000'000'000'000 + 100'000'000 * i, 90).image);
  EXPECT_NEAR(level_of(room.light()) / level_of(before), 1, 0.05);
  EXPECT_LT(angle_deg(main_of(room.light()), main_of(before)), 2);
}

// The light, in the terms of the image on the screen, does not care when the system begins to tell exposures.
TEST(RoomDay, ExposuresMayComeLateAndBeMissing) {
  const auto drawn = [](bool (*missing)(int)) {
    MadeUpRoom room;
    double sum = 0;
    for (int i = 0; i < 60; ++i) {
      const double gain = i < 30 ? 1.0 : 0.5;
      Photograph p = photograph(patterned, 12.0 * i, 10, gain, 1 + 100'000'000ull * static_cast<uint64_t>(i));
      p.image.exposure = missing(i) ? 0.0f : static_cast<float>(0.08 * gain);
      room.show(p.image);
      const sandglass_room_light light = room.light();
      const float scale = sandglass_room_exposure(&light, &p.image);
      if (i == 29 || i == 59) sum += static_cast<double>(light.irradiance[1] * scale) / gain;
    }
    return sum;
  };
  const double always = drawn([](int) { return false; });
  EXPECT_NEAR(drawn([](int i) { return i == 0; }) / always, 1, 0.05);
  EXPECT_NEAR(drawn([](int i) { return i < 10; }) / always, 1, 0.05);
  EXPECT_NEAR(drawn([](int i) { return i % 10 == 5; }) / always, 1, 0.05);
}

// What is shown goes on over a reset, and over the first exposure that is told.
TEST(RoomDay, WhatIsShownStaysOverAResetAndTheFirstExposure) {
  MadeUpRoom room;
  sandglass_room_light known = room.light(), shown = known;
  double last = 0;
  for (int i = 0; i < 90; ++i) {
    if (i == 60) sandglass_room_reset(room.handle());
    Photograph p = photograph(patterned, 4.0 * i, 10, 1, 1 + 100'000'000ull * static_cast<uint64_t>(i));
    p.image.exposure = i < 30 ? 0.0f : 0.08f;
    if (i < 60 || i > 65) room.show(p.image);
    known = room.light();
    sandglass_room_fade(&shown, &known, 1.0f / 30);
    const double level = static_cast<double>(shown.irradiance[1] * sandglass_room_exposure(&shown, &p.image));
    if (i > 0) {
      EXPECT_NEAR(level / last, 1, 0.07) << i;
    }
    last = level;
  }
}

// A phone that looks to and fro and tells no exposure: from image to image the level of what is drawn steps by 2.5 % or
// more in one image of twenty at most. The control compares an image with what is remembered alone.
TEST(RoomDay, WhatIsDrawnHardlyStepsWhereNoExposureIsTold) {
  double twentieth[2];
  for (const bool control : {false, true}) {
    std::vector<double> steps;
    for (const double azimuth : {0.0, 90.0, 180.0, 270.0}) {
      AdaptingPhone phone(0.7);
      phone.tells = false;
      double before = 0;
      for (int i = 0; i < 200; ++i) {
        if (control) phone.room.handle()->room.shows_steps = false;
        phone.see(patterned, azimuth + 40 * std::sin(i / 12.0), 10 + 20 * std::sin(i / 9.0));
        const double now = std::log(phone.shown_level);
        if (i > 50) steps.push_back(std::fabs(now - before));
        before = now;
      }
    }
    const auto at = steps.end() - static_cast<ptrdiff_t>(steps.size() / 20);
    std::nth_element(steps.begin(), at, steps.end());
    twentieth[control ? 1 : 0] = *at;
  }
  EXPECT_LE(twentieth[0], 0.025);
  EXPECT_GT(twentieth[1], 0.025);
}

// A short image is for lamps alone: what is drawn over ordinary images is as bright as before, and over the short one as
// dark as that is.
TEST(RoomDay, AShortImageBelongsToItself) {
  MadeUpRoom room;
  room.look_everywhere(patterned);
  const sandglass_room_light before = room.light();
  room.look(patterned, 200, -20, 1.0 / 64);
  const sandglass_room_light after = room.light();
  EXPECT_NEAR(after.irradiance[1] / before.irradiance[1], 1, 0.02);
  const Photograph ordinary = photograph(patterned, 200, -20, 1, 1);
  const Photograph dark = photograph(patterned, 200, -20, 1.0 / 64, 1);
  EXPECT_NEAR(sandglass_room_exposure(&after, &ordinary.image), 1, 1e-5);
  EXPECT_NEAR(sandglass_room_exposure(&after, &dark.image), 1.0 / 64, 1e-6);
}

// Lamps at every height, of many widths. A share of 0.6 of the floor's light.
TEST(RoomDay, ALampAtTheZenithIsFound) {
  for (const double elevation : {15.0, 38.0, 62.0, 84.4, 90.0})
    for (const double radius : {2.0, 5.0, 11.0}) {
      SCOPED_TRACE(std::to_string(elevation) + " " + std::to_string(radius));
      const double wall = 0.3, sine = std::sin(degrees(radius));
      const Direction lamp = towards(128, elevation);
      const double radiance = wall + wall * 0.6 / 0.4 / (sine * sine * lamp.y);
      const Radiance lit = lamp_room(lamp, radius, radiance, wall);
      MadeUpRoom room;
      room.may_teach_nothing = true;
      room.look_everywhere(lit);
      for (int i = 0; i < 30; ++i) {
        room.look(lit, 128 + 12 * i, elevation - 8);
        room.look(lit, 128 + 12 * i, elevation - 8, 0.9 / radiance);
      }
      for (int i = 0; i < 30; ++i) room.look(lit, 128, elevation - 8, i % 2 == 0 ? 1.0 : 0.9 / radiance);
      const sandglass_room_light light = room.light();
      EXPECT_NEAR(light.main_share, 0.6, 0.05);
      EXPECT_NEAR(level_of(light) / (std::numbers::pi * wall / 0.4), 1, 0.1);
      // A low and wide lamp gives the floor more light by its upper half.
      EXPECT_LT(angle_deg(main_of(light), lamp), elevation < 20 && radius > 10 ? 4 : 3);
    }
}

// A white window clips as a lamp does, and is none. The control: a lamp of which no short image is taken.
TEST(RoomDay, WhatIsWhiteIsNoLamp) {
  constexpr double k_wall = 0.3, k_radius = 4;
  const Direction at = towards(128, 50);
  const double facing = std::pow(std::sin(degrees(k_radius)), 2) * at.y;  // of a half space of the same radiance
  const auto share_of = [&](double radiance, bool shorter) {
    const Radiance lit = lamp_room(at, k_radius, radiance, k_wall);
    MadeUpRoom room;
    room.may_teach_nothing = true;
    room.look_everywhere(lit);
    for (int i = 0; i < 30; ++i) room.look(lit, 128, 42, shorter && i % 2 == 0 ? 1.0 / 64 : 1.0);
    return static_cast<double>(room.light().main_share);
  };
  const double white = 1.5, lamp = 60;
  const auto truth = [&](double radiance) { return 1 - 1 / (1 + (radiance / k_wall - 1) * facing); };
  EXPECT_NEAR(share_of(white, true), truth(white), 0.1);
  EXPECT_NEAR(share_of(lamp, true), truth(lamp), 0.1);
  EXPECT_GT(std::fabs(share_of(lamp, false) - truth(lamp)), 0.1);
}

// Of two lamps that are as good as equal, now this one stronger by a fifth and now that one, the one that is shown
// stays. The control: without `shown` another one is chosen.
TEST(RoomDay, OfTwoEqualLampsOneStays) {
  const Direction lamps[] = {towards(60, 50), towards(240, 50)};
  int changes[2] = {};
  for (const bool shown_given : {false, true}) {
    MadeUpRoom room;
    sandglass_room_light shown = room.light();
    Direction last = {};
    for (int i = 0; i < 480; ++i) {
      const Radiance radiance = [&](Direction d) {
        for (const int k : {0, 1})
          if (angle_deg(d, lamps[k]) < 6) return i / 120 % 2 == k ? 36.0 : 30.0;
        return 0.2;
      };
      room.look(radiance, 9.0 * i, 35 + 20 * std::sin(i / 9.0), i % 3 == 0 ? 1.0 : 1.0 / 64);
      const sandglass_room_light now = room.light(0, 0, 0, nullptr, shown_given ? &shown : nullptr);
      sandglass_room_fade(&shown, &now, 0.1f);
      if (i > 80 && angle_deg(main_of(now), last) > 20) ++changes[shown_given ? 1 : 0];
      last = main_of(now);
    }
  }
  EXPECT_GT(changes[0], 1);
  EXPECT_EQ(changes[1], 0);
}

TEST(RoomDay, ClocksThatAreWrongAgeNothingAndAreTold) {
  const Radiance even = [](Direction) { return 0.3; };
  const auto offer = [&](MadeUpRoom& room, double azimuth, double elevation, uint64_t ns) {
    const Photograph p = photograph(even, azimuth, elevation, 1, ns);
    const char* reason = nullptr;
    const sandglass_status status = sandglass_room_set_image(room.handle(), &p.image, nullptr, &reason);
    if (status != SANDGLASS_OK) {
      EXPECT_NE(std::string(reason).find("nanoseconds"), std::string::npos);
    }
    return status == SANDGLASS_OK;
  };
  // A kiosk that has run for 25 days forgets as it did on its first: by half in a half-life.
  MadeUpRoom kiosk(10.0f);
  offer(kiosk, 0, 20, 1);
  constexpr uint64_t k_day = 86'400'000'000'000;
  offer(kiosk, 0, 20, 25 * k_day);
  const float before = kiosk.light().seen;
  for (uint64_t i = 1; i <= 100; ++i) offer(kiosk, 0, -80, 25 * k_day + i * 100'000'000);
  EXPECT_NEAR(kiosk.light().seen, 0.5f * before, 0.05f * before);
  // One stamp of the far future: what was seen stays, and ages on.
  MadeUpRoom bogus(10.0f);
  for (uint64_t i = 1; i <= 20; ++i) offer(bogus, 0, 20, i * 100'000'000);
  const float there = bogus.light().seen;
  offer(bogus, 0, -80, 0xffffffffffff0000ull);
  EXPECT_GT(bogus.light().seen, 0.9f * there);
  for (uint64_t i = 21; i <= 125; ++i) offer(bogus, 0, -80, i * 100'000'000);
  EXPECT_LT(bogus.light().seen, 0.5f * there);
  // Microseconds or milliseconds are told within a second of a session; nanoseconds are not.
  for (const uint64_t step : {33'333ull, 33ull, 33'333'333ull}) {
    MadeUpRoom room;
    bool all = true;
    for (uint64_t i = 1; i <= 30; ++i) all = offer(room, 0, 0, i * step) && all;
    EXPECT_EQ(all, step > 1'000'000) << step;
  }
}

}  // namespace
}  // namespace sandglass
