// The scenes of `sandglass_lab verify carried`: what holds sand, how it moves, and what must hold of it.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "models/geometry/vec3.h"
#include "tests/laboratory/sand/apparatus.h"

namespace sandglass::host {

constexpr double k_shares[] = {1.0 / 2, 1.0 / 4, 1.0 / 8, 1.0 / 16, 1.0 / 32, 1.0 / 64};
constexpr double k_fine = 0.0035;                             // metres: sand of a glass
constexpr double k_glass = 0.115, k_stand = k_glass + 0.012;  // half the height of a glass; where its middle stands

struct Pose {
  Vec3 at;
  double angle = 0.0;  // about z
  Quaternion turn() const { return rotation_by({0.0, 0.0, angle}); }
  Vec3 world(Vec3 p) const { return at + rotate(turn(), p); }
  Vec3 local(Vec3 p) const { return rotate(conjugate(turn()), p - at); }
};

inline void add_point(std::vector<float>* points, Vec3 p) {
  for (const double v : {p.x, p.y, p.z}) points->push_back(static_cast<float>(v));
}

// What moves, and the sand about it in its own frame; for a hand, the world's.
struct Vessel {
  std::vector<sandglass_collider> parts;
  cpp::Field field;
  std::function<double(Vec3)> room;  // how far a point is from leaving the room for sand; below 0 it is outside
  std::vector<float> sand;
  bool pushes = false;

  template <class Inside>
  void fill(double r, Vec3 low, Vec3 high, const Inside& inside) {
    const double step = 2.02 * r;
    for (double y = low.y; y < high.y; y += step)
      for (double z = low.z; z < high.z; z += step)
        for (double x = low.x; x < high.x; x += step)
          if (inside(x, y, z)) add_point(&sand, {x, y, z});
  }
  void part(double x, double y, double z, double a, double b, double c) {
    const auto f = [](double v) { return static_cast<float>(v); };
    parts.push_back(cpp::box(f(x), f(y), f(z), f(a), f(b), f(c)));
  }
};

enum Judged { k_stays, k_rests, k_spills };  // in it; and where it lies; some is lost at full budget too
struct CarriedScene {
  const char* name;
  double radius;
  Vessel (*make)(double r);
  Pose (*pose)(double t);
  Judged judged;
  bool hitches;  // and jumps are judged too
  bool grained;  // once more with grains
  // Seconds that were simulated of 2.67 at 1/2 to 1/64 of the need, before sand was carried. At 60 Hz, by velocities.
  double before[std::size(k_shares)];
};

std::span<const CarriedScene> carried_scenes();
// A glass that turns over as it rises; one with an open end that stands; and two jars, one in the other.
extern const CarriedScene k_rising, k_alone, k_two_jars;
Vessel open_glass(double r);

}  // namespace sandglass::host
