#include "tests/laboratory/room/day_rows.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <numbers>

#include "models/work/thread_pool.h"
#include "runtime/light/room/room.h"
#include "runtime/math/random.h"

namespace sandglass::host {

namespace {

constexpr double k_directions[] = {0, 90, 180, 270};

// What a seed has drawn, of which a row is the worst.
struct Draw {
  const DayChoice* choice;
  uint64_t seed;
  Random random;
  double between(double low, double high) { return low + (high - low) * random.uniform(); }
};

World brighter(const World& world, double factor) {
  return [world, factor](Vec3 d, Vec3 from) { return world(d, from) * factor; };
}

// Walls with a pattern, and a lamp; or walls without one.
World drawn_room(Draw* draw, bool even) {
  const double a = draw->between(3, 6), b = draw->between(3, 5), wall = draw->between(0.2, 0.35);
  const Vec3 lamp = direction_of({draw->between(0, 360), draw->between(40, 70)});
  const double cosine = std::cos(draw->between(4, 8) * std::numbers::pi / 180), bright = draw->between(8, 16);
  return [=](Vec3 d, Vec3) {
    if (dot(d, lamp) > cosine) return Vec3{1, 1, 1} * bright;
    const double pattern = even ? 0 : 0.5 * wall * std::sin(a * d.x + 1) * std::cos(b * d.z);
    return Vec3{1, 1, 1} * (wall + pattern - (d.y < 0 ? 0.3 * wall : -0.2 * wall * d.y));
  };
}

// One that was captured: of three seeds each has a third. Its floor's irradiance is 1.
std::vector<World> captured_rooms(const Draw& draw) {
  std::vector<World> worlds;
  for (size_t i = draw.seed % 3; i < draw.choice->rooms.size(); i += 3) {
    const RadianceMap* map = &draw.choice->rooms[i];
    const World seen = [map](Vec3 d, Vec3) { return look_up(*map, d); };
    worlds.push_back(brighter(seen, 1 / floor_irradiance(seen)));
  }
  return worlds;
}

std::vector<World> rooms_of(Draw* draw) {
  std::vector<World> worlds = captured_rooms(*draw);
  worlds.push_back(drawn_room(draw, false));
  worlds.push_back(drawn_room(draw, true));
  return worlds;
}

// A phone that has looked around, and rests.
std::unique_ptr<DayPhone> settled_phone(const World& world, Gaze gaze) {
  auto phone = std::make_unique<DayPhone>(0.2, true, 1.0);
  phone->resolve(48, 36, 37.5);
  for (int i = 0; i < 100; ++i) phone->see(world, {18.0 * i, 10 + 45 * std::sin(i / 7.0)});
  for (int i = 0; i < 20; ++i) phone->see(world, gaze);
  return phone;
}

void rest(DayPhone* phone, const World& world, Gaze gaze, int images) {
  for (int i = 0; i < images; ++i) phone->see(world, gaze);
}

// Light that changes for four seconds, and returns for four: how far the level is from the world's, beside that of a
// phone for which nothing has changed, at the end of either. The control holds the light of the whole room.
double worst_change(Draw draw, bool control) {
  double worst = 0;
  for (const World& world : rooms_of(&draw))
    for (const double azimuth : k_directions) {
      const Gaze gaze = {azimuth + draw.between(0, 90), -20};
      const auto twin = settled_phone(world, gaze);
      double unchanged[2];
      for (double& level : unchanged) {
        rest(twin.get(), world, gaze, 40);
        level = twin->level();
      }
      for (const double factor : {0.3, 0.1, 6.0}) {
        const auto phone = settled_phone(world, gaze);
        const double held = phone->handle()->room.light;
        for (int back = 0; back < 2; ++back) {
          const double truth = back == 0 ? factor : 1;
          for (int i = 0; i < 40; ++i) {
            phone->see(brighter(world, truth), gaze);
            if (control) phone->handle()->room.light = held;
          }
          worst = std::max(worst, std::fabs(phone->level() / unchanged[back] / truth - 1));
        }
      }
    }
  return worst;
}

// Looks in four directions, at walls with a pattern and without.
using Look = std::function<void(const World&, Gaze, Vec3 right)>;
void in_drawn_rooms(Draw* draw, const Look& look) {
  for (const bool even : {false, true}) {
    const World world = drawn_room(draw, even);
    for (const double azimuth : k_directions) look(world, {azimuth, -20}, direction_of({azimuth + 90, 0}));
  }
}

// A finger or glare for two seconds, far darker or brighter than the room: how far the level moves while it is there.
double worst_cover(Draw draw, double factor) {
  double worst = 0;
  in_drawn_rooms(&draw, [&](const World& world, Gaze gaze, Vec3 right) {
    const auto phone = settled_phone(world, gaze);
    const double before = phone->level();
    const World cover = [=](Vec3 d, Vec3) { return Vec3{0.2, 0.2, 0.2} * (factor * (1 + 0.3 * dot(d, right))); };
    for (int i = 0; i < 20; ++i) {
      phone->see(cover, gaze);
      worst = std::max(worst, std::fabs(std::log(phone->level() / before)));
    }
  });
  return worst;
}

// Light that changes while a finger covers the lens, or half of it, and stays so for four seconds.
double worst_doubt(Draw draw) {
  double worst = 0;
  in_drawn_rooms(&draw, [&](const World& world, Gaze gaze, Vec3 right) {
    const double side = draw.between(-0.3, 0.3);
    for (const double factor : {0.3, 1.42, 3.0})
      for (const bool half : {false, true}) {
        const World now = brighter(world, factor);
        const auto covered = [&](const World& behind) {
          return World([=](Vec3 d, Vec3 from) {
            return half && dot(d, right) > side ? behind(d, from)
                                                : Vec3{0.004, 0.004, 0.004} * (1 + 0.3 * dot(d, right));
          });
        };
        const auto phone = settled_phone(world, gaze);
        const double before = phone->level();
        rest(phone.get(), covered(world), gaze, 8);
        rest(phone.get(), covered(now), gaze, 12);
        rest(phone.get(), now, gaze, 40);
        worst = std::max(worst, std::fabs(phone->level() / before / factor - 1));
        rest(phone.get(), world, gaze, 40);
        worst = std::max(worst, std::fabs(phone->level() / before - 1));
      }
  });
  return worst;
}

// Through a door, 6 m away, into another room of 1/20 or 20 times the light: how far the level is out of what lies between
// the truth and what a room says that was made at the door, `from_s` after it or later. The control walks without a
// position, and no image that is doubted bounds its level.
struct Door {
  bool exposure_known;
  double from_s, until_s;
  bool control;
};
double worst_door(Draw draw, Door door) {
  double worst = 0;
  for (const double azimuth : k_directions)
    for (const double factor : {0.05, 20.0}) {
      const World first = drawn_room(&draw, false), second = drawn_room(&draw, false);
      const double truth = factor * floor_irradiance(first);
      const World other = brighter(second, truth / floor_irradiance(second));
      DayPhone phone(0.3, door.exposure_known, 1.0), fresh(0.3, door.exposure_known, 1.0);
      const auto see = [&](DayPhone* by, const World& world, int i) {
        const Gaze gaze = {azimuth + 1.8 * i, 15 + 35 * std::sin(0.09 * i)};
        by->resolve(48, 36, 37.5);
        if (!door.control) by->position = direction_of({azimuth, 0}) * (0.15 * std::clamp(i - 360, 0, 40));
        if (door.exposure_known) by->see_and_obey(world, gaze);
        else by->see(world, gaze);
        return std::log(by->level(by->position) / truth);
      };
      for (int i = 0; i < 400; ++i) see(&phone, first, i);
      for (int i = 0; i < 10 * door.until_s; ++i) {
        const double there = see(&phone, other, 400 + i), usual = see(&fresh, other, 400 + i);
        if (door.control) phone.handle()->room.shows = 0;
        if (i < 10 * door.from_s) continue;
        worst = std::max({worst, there - std::max(usual, 0.0), std::min(usual, 0.0) - there});
      }
    }
  return worst;
}

// What a seed draws of lamps: how many, how wide, where. The world without lamps has a white wall or window in the
// place of each, that clips with the same bytes: as bright as white is, and a half more.
struct Lamps {
  std::vector<Vec3> at;
  double width_deg, share;  // of the floor's irradiance, all together
  bool are_lamps;

  World world() const {
    double facing = 0;
    for (const Vec3& lamp : at) facing += lamp.y;
    const double half = std::sin(width_deg / 2 * std::numbers::pi / 180), wall = 0.3;
    const double bright = are_lamps ? wall * share / (1 - share) / (half * half * facing) : 5 * wall;
    return [*this, wall, bright](Vec3 d, Vec3) {
      const double cosine = std::cos(width_deg / 2 * std::numbers::pi / 180);
      for (const Vec3& lamp : at)
        if (dot(d, lamp) > cosine) return Vec3{1, 1, 1} * bright;
      return Vec3{1, 1, 1} * (d.y > 0 ? wall : 0.5 * wall);
    };
  }
  double irradiance() const {
    if (are_lamps) return std::numbers::pi * 0.3 / (1 - share);
    return std::numbers::pi * 0.3 / (1 - static_cast<double>(at.size()) * true_share());
  }
  double true_share() const {
    if (are_lamps) return share / static_cast<double>(at.size());
    const double half = std::sin(width_deg / 2 * std::numbers::pi / 180), gives = 4 * half * half * at.front().y;
    return gives / (1 + gives);
  }
};

// What a phone says at the end of 60 s of looking around with lamps before it now and then.
struct LampReport {
  double share = 0, level = 0, swing = 0, jump = 0, goings = 0;
};
LampReport look_at_lamps(const Lamps& lamps, double azimuth, bool obeys) {
  const World world = lamps.world();
  DayPhone phone(0, true, 1.0);
  // A lamp is a few pixels wide at least, as a phone's camera shows it.
  const int fine = lamps.width_deg < 1.5 ? 3 : 1;
  phone.resolve(160 * fine, 120 * fine, 125 * fine);
  const double truth = lamps.irradiance();
  LampReport worst;
  double share_min = 1, share_max = 0, last = -1;
  bool there = false;
  for (int i = 0; i < 600; ++i) {
    const Gaze gaze = {azimuth + 9.0 * i + 20 * std::sin(i / 17.0), 20 + 30 * std::sin(i / 23.0)};
    if (obeys) phone.see_and_obey(world, gaze);
    else phone.see(world, gaze);
    if (i < 300) continue;
    const auto share = static_cast<double>(phone.light().main_share);
    worst.share = std::max(worst.share, std::fabs(share - lamps.true_share()));
    worst.level = std::max(worst.level, std::fabs(phone.level() / truth - 1));
    share_min = std::min(share_min, share);
    share_max = std::max(share_max, share);
    if (last >= 0) worst.jump = std::max(worst.jump, std::fabs(share - last));
    last = share;
    const bool now = static_cast<double>(phone.shown.main_share) > 0.5 * lamps.true_share();
    worst.goings += there && !now ? 2 : 0;  // half a minute
    there = now;
  }
  worst.swing = share_max - share_min;
  return worst;
}

LampReport worst_lamps(Draw draw, size_t count, bool are_lamps, bool obeys) {
  LampReport worst;
  for (const double azimuth : k_directions) {
    Lamps lamps = {{}, std::exp(draw.between(std::log(0.5), std::log(8))), draw.between(0.5, 0.75), are_lamps};
    const double elevation = draw.between(35, 65), first = azimuth + draw.between(0, 90);
    for (size_t k = 0; k < count; ++k)
      lamps.at.push_back(direction_of({first + 110.0 * static_cast<double>(k), elevation}));
    const LampReport report = look_at_lamps(lamps, azimuth, obeys);
    worst.share = std::max(worst.share, report.share);
    worst.level = std::max(worst.level, report.level);
    worst.swing = std::max(worst.swing, report.swing);
    worst.jump = std::max(worst.jump, report.jump);
    worst.goings = std::max(worst.goings, report.goings);
  }
  return worst;
}

// How far main_angular_diameter is from the truth after a minute; the control is what a cast takes where it is not known.
double worst_size(Draw draw, bool control) {
  constexpr double k_radians = std::numbers::pi / 180, k_usual_deg = 20;
  double worst = 0;
  for (const double azimuth : k_directions) {
    Lamps lamps = {{}, std::exp(draw.between(std::log(2), std::log(20))), draw.between(0.5, 0.75), true};
    lamps.at.push_back(direction_of({azimuth + draw.between(0, 90), draw.between(35, 65)}));
    const World world = lamps.world();
    DayPhone phone(0, true, 1.0);
    phone.resolve(160, 120, 125);
    for (int i = 0; i < 600; ++i)
      phone.see_and_obey(world, {azimuth + 9.0 * i + 20 * std::sin(i / 17.0), 20 + 30 * std::sin(i / 23.0)});
    const double found = control ? k_usual_deg * k_radians : static_cast<double>(phone.light().main_angular_diameter);
    worst = std::max(worst, std::fabs(found / (lamps.width_deg * k_radians) - 1));
  }
  return worst;
}

// How far the level is from that of a phone whose values are sRGB, where they are linear, HLG, PQ or of a tone curve; the
// control does not say it.
double worst_transfer(Draw draw, bool transfer_known) {
  double worst = 0;
  const World world = drawn_room(&draw, false);
  for (const double azimuth : k_directions) {
    double srgb = 0;
    for (sandglass_transfer transfer = SANDGLASS_TRANSFER_SRGB; transfer <= SANDGLASS_TRANSFER_CURVE; ++transfer) {
      DayPhone phone(0.2, true, 1.0);
      phone.transfer = transfer;
      phone.tells_transfer = transfer_known;
      for (int i = 0; i < 300; ++i) phone.see_and_obey(world, {azimuth + 9.0 * i, 20 + 40 * std::sin(i / 13.0)});
      if (transfer == SANDGLASS_TRANSFER_SRGB) srgb = phone.level();
      worst = std::max(worst, std::fabs(phone.level() / srgb - 1));
    }
  }
  return worst;
}

// A place in the open: a ground that is near, a sun, and houses, trees and clouds that are far. Or a room of 6 m, whose
// walls and lamp are where they are.
struct Place {
  bool open;
  Vec3 lamp;  // its direction; in a room, where it is
  double phase[3];

  World world() const {
    return [*this](Vec3 d, Vec3 from) {
      const double half = 2 * std::numbers::pi / 180, bright = 900;  // two thirds of the light
      if (dot(d, open ? lamp : normalised(lamp - from)) > std::cos(half)) return Vec3{1, 1, 1} * bright;
      const Vec3 low = {-3, -1.4, -3}, high = {3, 1.6, 3}, at = open ? ground(d, from) : wall(d, from, low, high);
      const double pattern = std::sin(3 * at.x + phase[0]) * std::cos(2.5 * at.z + phase[1]) +
                             0.5 * std::sin(4 * at.y + phase[2] + 2 * at.x);
      return Vec3{1, 1, 1} * (0.3 + 0.12 * pattern) * (d.y < 0 ? 0.6 : 1.0);
    };
  }

 private:
  static Vec3 ground(Vec3 d, Vec3 from) {
    constexpr double k_eye = 1.4, k_far = 40;
    const double distance = d.y < 0 ? (from.y + k_eye) / -d.y : k_far;
    return distance < k_far ? from + d * distance : d * 2;
  }
  static Vec3 wall(Vec3 d, Vec3 from, Vec3 low, Vec3 high) {
    double distance = 1e9;
    for (double Vec3::*k : {&Vec3::x, &Vec3::y, &Vec3::z})
      if (d.*k != 0) distance = std::min(distance, ((d.*k > 0 ? high.*k : low.*k) - from.*k) / d.*k);
    return from + d * distance;
  }
};

// How far the main light's direction is off, in degrees, at what stands before a camera that has looked around and then
// walked for 2 m. `radius`: as the app tells it.
double worst_walk(Draw draw, bool open, double radius) {
  double worst = 0;
  for (const double azimuth : k_directions) {
    const Gaze sun = {draw.between(0, 360), draw.between(25, 60)};
    const Vec3 lamp =
        open ? direction_of(sun) : direction_of(sun) * (1.5 / std::sin(sun.elevation_deg * std::numbers::pi / 180));
    const Place place = {open,
                         open ? lamp : Vec3{std::clamp(lamp.x, -2.5, 2.5), 1.5, std::clamp(lamp.z, -2.5, 2.5)},
                         {draw.between(0, 6), draw.between(0, 6), draw.between(0, 6)}};
    const World world = place.world();
    DayPhone phone(0.2, true, 1.0, radius);
    phone.resolve(96, 72, 75);
    for (int i = 0; i < 300; ++i) {
      phone.position = direction_of({azimuth, 0}) * (2 * std::clamp((i - 240) / 50.0, 0.0, 1.0));
      phone.see_and_obey(world, {azimuth + 4.5 * i, 20 + 25 * std::sin(i / 9.0)});
    }
    const Vec3 object = phone.position + direction_of({azimuth, 0}) + Vec3{0, -1.2, 0};
    const sandglass_room_light light = phone.light(object);
    const Vec3 truth = open ? lamp : normalised(place.lamp - object);
    const double cosine = dot(normalised(from_floats(light.main_direction)), truth);
    worst = std::max(worst, std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi);
  }
  return worst;
}

// By how much the level of what is drawn steps from image to image while a phone looks to and fro, in one image of
// twenty. The control compares with what is remembered alone.
double common_step(Draw draw, bool control) {
  std::vector<double> steps;
  for (const World& world : rooms_of(&draw))
    for (const double azimuth : k_directions) {
      DayPhone phone(0.2, false, 1.0);
      phone.resolve(48, 36, 37.5);
      double before = 0;
      for (int i = 0; i < 200; ++i) {
        if (control) phone.handle()->room.shows_steps = false;
        phone.see_and_obey(world, {azimuth + 40 * std::sin(i / 12.0), 10 + 20 * std::sin(i / 9.0)});
        const double now = std::log(phone.shown_level());
        if (i > 50) steps.push_back(std::fabs(now - before));
        before = now;
      }
    }
  const auto twentieth = steps.end() - static_cast<ptrdiff_t>(steps.size() / 20);
  std::nth_element(steps.begin(), twentieth, steps.end());
  return *twentieth;
}

Vec3 floor_colour(const World& world) {
  const auto of = [&](double Vec3::*c) {
    return floor_irradiance([&](Vec3 d, Vec3 from) { return Vec3{1, 1, 1} * (world(d, from).*c); });
  };
  return {of(&Vec3::x), of(&Vec3::y), of(&Vec3::z)};
}

// A room that is warm on one side and cold on the other, and a camera that makes each image nine tenths grey: how far
// red over blue of the light that is shown is from that of a grey thing in the picture. `follows`: 0 is a light that does
// not follow.
double worst_balance(Draw draw, bool gains_known, bool follows) {
  double worst = 0;
  for (const double azimuth : k_directions) {
    const World grey = drawn_room(&draw, false);
    const Vec3 to = direction_of({draw.between(0, 360), 0});
    const double warm = draw.between(1.2, 1.5), cold = draw.between(1.2, 1.5);
    const World world = [=](Vec3 d, Vec3 from) {
      const double side = std::tanh(3 * dot(d, to)), red = 0.5 * (1 + side) * warm + 0.5 * (1 - side) / cold;
      const Vec3 c = grey(d, from);
      return Vec3{c.x * red, c.y, c.z / red};
    };
    const Vec3 truth = floor_colour(world);
    DayPhone phone(0.2, true, 1.0);
    phone.resolve(80, 60, 62);
    phone.follows = 0.9;
    phone.tells_gains = gains_known;
    for (int i = 0; i < 600; ++i) {
      phone.see_and_obey(world, {azimuth + 1.8 * i, 10 + 45 * std::sin(i / 14.0)});
      if (i < 200) continue;
      const sandglass_room_light& light = phone.shown;
      const auto drawn = [&](int c) {
        return static_cast<double>(follows ? light.irradiance[c] : light.irradiance[c] / light.balance[c]);
      };
      const double real = truth.x * phone.gains.x / (truth.z * phone.gains.z);
      worst = std::max(worst, std::fabs(std::log(drawn(0) / drawn(2) / real)));
    }
  }
  return worst;
}

// A row: the worst of the seeds. A control has to fail on one of them at least.
struct Row {
  const char *group, *name, *unit;
  double limit;
  std::function<double(Draw)> measure;
  bool control = false;
};

std::vector<Row> all_rows() {
  std::vector<Row> rows;
  for (const bool control : {false, true})
    rows.push_back({"change", control ? "control: the room's light is held" : "x .3, .1, 6 for 4 s, and back", "of it",
                    0.1, [=](Draw draw) { return worst_change(draw, control); }, control});
  rows.push_back({"cover", "finger, x 1/50, 2 s", "|log|", 0.05, [](Draw draw) { return worst_cover(draw, 0.02); }});
  rows.push_back({"cover", "glare, x 50, 2 s", "|log|", 0.05, [](Draw draw) { return worst_cover(draw, 50); }});
  rows.push_back(
      {"cover", "control: x 1/10, a lamp less", "|log|", 0.05, [](Draw draw) { return worst_cover(draw, 0.1); }, true});
  rows.push_back({"cover", "a change behind a finger", "of it", 0.1, worst_doubt});
  const auto door_row = [&](const char* name, double limit, Door door) {
    rows.push_back({"door", name, "|log|", limit, [=](Draw draw) { return worst_door(draw, door); }, door.control});
  };
  door_row("1 s on, exposure told", std::log(2), {true, 1, 20, false});
  door_row("1 s on, exposure not told", std::log(2), {false, 1, 20, false});
  door_row("5 s on, exposure told", std::log(1.25), {true, 5, 7, false});
  door_row("control: the old room, 1 s on", std::log(2), {true, 1, 20, true});
  for (const bool gains_known : {true, false})
    rows.push_back({"balance", gains_known ? "red over blue, gains told" : "red over blue, gains not told", "|log|",
                    0.1625, [=](Draw draw) { return worst_balance(draw, gains_known, true); }});
  rows.push_back({"balance", "control: colours that stay", "|log|", 0.1625,
                  [](Draw draw) { return worst_balance(draw, true, false); }, true});
  rows.push_back(
      {"open", "the sun after 2 m of walking", "deg", 3, [](Draw draw) { return worst_walk(draw, true, 0); }});
  rows.push_back({"open", "a lamp in a room of 6 m, beside radius 3", "deg", 0.1,
                  [](Draw draw) { return worst_walk(draw, false, 0) - worst_walk(draw, false, 3); }});
  rows.push_back({"open", "control: radius 3", "deg", 3, [](Draw draw) { return worst_walk(draw, true, 3); }, true});
  for (const bool control : {false, true})
    rows.push_back({"step", control ? "control: by what is remembered" : "of the level in 1 image of 20, not told",
                    "|log|", 0.05, [=](Draw draw) { return common_step(draw, control); }, control});
  const auto lamp_row = [&](const char* name, const char* unit, double limit, size_t count, bool are, bool obeys,
                            double LampReport::*of, bool control = false) {
    rows.push_back({count == 1 ? "lamps" : "two", name, unit, limit,
                    [=](Draw draw) { return worst_lamps(draw, count, are, obeys).*of; }, control});
  };
  lamp_row("0.5 to 8 degrees, share", "", 0.1, 1, true, true, &LampReport::share);
  lamp_row("the level", "of it", 0.15, 1, true, true, &LampReport::level);
  lamp_row("white as clipped, no lamp, share", "", 0.1, 1, false, true, &LampReport::share);
  lamp_row("control: no short image", "", 0.1, 1, true, false, &LampReport::share, true);
  lamp_row("two equal lamps, jump of the share", "", 0.1, 2, true, true, &LampReport::jump);
  lamp_row("shadow goes, a minute", "times", 1, 2, true, true, &LampReport::goings);
  for (const bool control : {false, true})
    rows.push_back({"size", control ? "control: 20 degrees" : "a lamp of 2 to 20 degrees, its diameter", "of it", 0.3,
                    [=](Draw draw) { return worst_size(draw, control); }, control});
  for (const bool control : {false, true})
    rows.push_back({"transfer", control ? "control: it is not told" : "linear, HLG, PQ, a curve: the level", "of it",
                    0.15, [=](Draw draw) { return worst_transfer(draw, !control); }, control});
  return rows;
}

}  // namespace

std::vector<std::string> day_cases() {
  std::vector<std::string> names;
  for (const Row& row : all_rows())
    if (names.empty() || names.back() != row.group) names.emplace_back(row.group);
  return names;
}

std::vector<Verdict> day_verdicts(const DayChoice& choice, const std::function<bool(uint64_t, uint64_t)>& progress) {
  std::vector<Row> rows;
  for (Row& row : all_rows())
    if (choice.cases.empty() || std::find(choice.cases.begin(), choice.cases.end(), row.group) != choice.cases.end())
      rows.push_back(row);
  const uint64_t seeds = choice.quick ? 1 : 3;
  std::vector<double> results(rows.size() * seeds);
  std::mutex mutex;
  uint64_t done = 0;
  bool goes_on = true;
  ThreadPool pool(choice.threads);
  pool.run(static_cast<uint32_t>(results.size()), [&](uint32_t i) {
    if (!goes_on) return;
    const uint64_t seed = choice.seed + i % seeds;
    results[i] = rows[i / seeds].measure({&choice, seed, random_stream(seed, 57)});
    const std::lock_guard lock(mutex);
    goes_on = progress(++done, results.size()) && goes_on;
  });
  std::vector<Verdict> verdicts;
  for (size_t k = 0; k < rows.size() && goes_on; ++k) {
    const auto first = results.begin() + static_cast<ptrdiff_t>(k * seeds);
    const double worst = *std::max_element(first, first + static_cast<ptrdiff_t>(seeds));
    const Row& row = rows[k];
    const bool pass = row.control ? !(worst <= row.limit) : worst <= row.limit;
    verdicts.push_back({row.group, row.name, row.unit, 0.0, worst, row.limit, pass, row.control});
  }
  return verdicts;
}

}  // namespace sandglass::host
