// A walk in the open, where the sun and the houses are far and the ground is near, and one in a room, whose walls and lamp
// are where they are. Nobody tells which of them it is.
#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

double Direction::*const k_axes[] = {&Direction::x, &Direction::y, &Direction::z};

Direction along(Direction from, Direction d, double distance) {
  return {from.x + distance * d.x, from.y + distance * d.y, from.z + distance * d.z};
}
Direction unit(Direction d) {
  const double n = std::sqrt(cosine(d, d));
  return {d.x / n, d.y / n, d.z / n};
}

struct Place {
  bool open;
  Direction lamp;  // its direction; in a room, where it is
  double phase;

  Direction towards_lamp(Direction from) const { return open ? lamp : unit(along(lamp, from, -1)); }
  // The ground, or what is so far away that it stays where it is.
  static Direction ground(Direction d, Direction from) {
    constexpr double k_eye = 1.4, k_far = 40;
    const double distance = d.y < 0 ? (from.y + k_eye) / -d.y : k_far;
    return distance < k_far ? along(from, d, distance) : Direction{2 * d.x, 2 * d.y, 2 * d.z};
  }
  static Direction wall(Direction d, Direction from) {
    const Direction low = {-3, -1.4, -3}, high = {3, 1.6, 3};
    double distance = 1e9;
    for (const auto axis : k_axes)
      if (d.*axis != 0) distance = std::min(distance, ((d.*axis > 0 ? high.*axis : low.*axis) - from.*axis) / d.*axis);
    return along(from, d, distance);
  }
  double radiance(Direction d, Direction from) const {
    if (cosine(d, towards_lamp(from)) > std::cos(degrees(2))) return 900;  // two thirds of the light
    const Direction at = open ? ground(d, from) : wall(d, from);
    const double pattern =
        std::sin(3 * at.x + phase) * std::cos(2.5 * at.z + 2 * phase) + 0.5 * std::sin(4 * at.y + 3 * phase + 2 * at.x);
    return (0.3 + 0.12 * pattern) * (d.y < 0 ? 0.6 : 1.0);
  }
};

// How far the main light's direction is off, in degrees, at what stands before a camera that has looked around and then
// walked for 2 m. It takes a short image where it is asked for one.
double worst_walk(bool open, float radius) {
  double worst = 0;
  for (const double azimuth : {0.0, 120.0, 240.0}) {
    const double elevation = 30 + azimuth / 10;
    const Direction sun = towards(1.3 * azimuth + 40, elevation), ahead = towards(azimuth, 0);
    const double ceiling = 1.5 / std::sin(degrees(elevation));
    const Direction lamp = {std::clamp(ceiling * sun.x, -2.5, 2.5), 1.5, std::clamp(ceiling * sun.z, -2.5, 2.5)};
    const Place place = {open, open ? sun : lamp, 1 + azimuth / 90};
    MadeUpRoom room(1e6f, false, false, radius);
    room.may_teach_nothing = true;
    Direction at = {};
    uint64_t now = 1;
    for (int i = 0; i < 300; ++i) {
      at = along({}, ahead, 2 * std::clamp((i - 240) / 50.0, 0.0, 1.0));
      const Radiance seen = [&](Direction d) { return place.radiance(d, at); };
      const auto look = [&](double exposure) {
        Photograph p = photograph(seen, azimuth + 4.5 * i, 20 + 25 * std::sin(i / 9.0), exposure, now += 100'000'000);
        for (size_t k = 0; k < 3; ++k) p.image.position[k] = static_cast<float>(at.*k_axes[k]);
        room.show(p.image);
      };
      look(1);
      const auto shorter = static_cast<double>(room.light().short_exposure);
      if (shorter < 1) look(shorter);
    }
    const Direction object = along(along(at, ahead, 1), {0, 1, 0}, -1.2);
    const sandglass_room_light light =
        room.light(static_cast<float>(object.x), static_cast<float>(object.y), static_cast<float>(object.z));
    worst = std::max(worst, angle_deg(main_of(light), place.towards_lamp(object)));
  }
  return worst;
}

// The control: an app that says 3 m.
TEST(RoomInTheOpen, TheSunStaysWhereItIsOverAWalk) {
  EXPECT_LE(worst_walk(true, 0), 3);
  EXPECT_GT(worst_walk(true, 3), 3);
}

TEST(RoomInTheOpen, ALampInARoomIsFoundAsWellAsWhereTheRadiusIsTold) {
  EXPECT_LE(worst_walk(false, 0), worst_walk(false, 3) + 0.1);
}

}  // namespace
}  // namespace sandglass
