// `sandglass_lab verify carried`: what holds sand is moved while the budget is short: whether the sand stays in it, still
// flows, and is thrown by nothing. A frame costs the instructions of its work units on a phone's core (models/phones), so
// results are the same everywhere.
//
// One list of scenes, and one function that runs any of them in any way: at a share of the time that its frames need, by
// velocities or poses alone, at any rate, with a frame that is late or a pose that jumps. The rest says what must hold.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "models/geometry/vec3.h"
#include "models/phones/phone.h"
#include "models/simulation/metrics.h"
#include "models/simulation/simulation.h"
#include "tests/laboratory/sand/apparatus.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

constexpr double k_reported = std::numeric_limits<double>::infinity(), k_pi = std::numbers::pi;
constexpr double k_settle = 1.0, k_moving = 2.67;  // seconds
constexpr double k_shares[] = {1.0 / 2, 1.0 / 4, 1.0 / 8, 1.0 / 16, 1.0 / 32, 1.0 / 64};
constexpr double k_rates[] = {60, 30, 72, 90, 120};  // Hz
constexpr uint32_t k_waits = 3;                      // frames
constexpr double k_fine = 0.0035;                    // metres: sand of a glass

struct Pose {
  Vec3 at;
  double angle = 0.0;  // about z
  Quaternion turn() const { return rotation_by({0.0, 0.0, angle}); }
  Vec3 world(Vec3 p) const { return at + rotate(turn(), p); }
  Vec3 local(Vec3 p) const { return rotate(conjugate(turn()), p - at); }
};

void add_point(std::vector<float>* points, Vec3 p) {
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

// Boxes about a room from y = `wall`, of this half width and height; its bottom is at y = 0.
Vessel boxes(double r, double half, double high, double wall, double filled, bool lid = false) {
  Vessel v;
  const double middle = wall + 0.5 * high, out = half + 0.5 * wall, wide = half + wall;
  v.part(0, 0.5 * wall, 0, wide, 0.5 * wall, wide);
  for (const double side : {1.0, -1.0}) {
    v.part(side * out, middle, 0, 0.5 * wall, 0.5 * high, wide);
    v.part(0, middle, side * out, wide, 0.5 * high, 0.5 * wall);
  }
  if (lid) v.part(0, wall + high + 0.5 * wall, 0, wide, 0.5 * wall, wide);
  v.room = [=](Vec3 p) {
    const double open = std::min({half - std::fabs(p.x), half - std::fabs(p.z), p.y - wall});
    return lid ? std::min(open, wall + high - p.y) : open;
  };
  const double in = half - 1.05 * r;
  v.fill(r, {-in, wall + 1.05 * r, -in}, {in, wall + filled, in}, [](double, double, double) { return true; });
  return v;
}

// A heap that slopes by this much, on a box or within its rims.
void pile(Vessel* v, double r, double bottom, double wide, double slope) {
  v->sand.clear();
  v->fill(r, {-wide, bottom + 1.05 * r, -wide}, {wide, bottom + 0.2, wide},
          [=](double x, double y, double z) { return std::hypot(x, z) < wide - (y - bottom) * slope; });
}

constexpr double k_glass = 0.115, k_stand = k_glass + 0.012;  // half its height; where its middle stands
constexpr double k_wide = 0.052;
Profile glass_line() {
  constexpr double k_neck = 0.0125;
  Profile line;
  for (int i = -48; i <= 48; ++i) {
    const double t = std::fabs(i / 48.0), cap = t > 0.72 ? std::sqrt(1.0 - 0.5 * std::pow((t - 0.72) / 0.28, 2)) : 1.0;
    const double open = std::pow(std::sin(0.5 * k_pi * std::min(1.0, t / 0.6)), 2.2);
    line.push_back({(k_neck + (k_wide - k_neck) * open) * cap, k_glass * i / 48.0});
  }
  return line;
}
Vessel glass(double r) {
  Vessel v;
  Profile outline = glass_line();
  outline.insert(outline.begin(), {0.0, -k_glass});
  outline.push_back({0.0, k_glass});
  v.field = vessel(outline, r);
  v.parts = {cpp::field_at(v.field, 0, 0, 0)};
  const sandglass_field* field = v.field.get();
  v.room = [field](Vec3 p) {
    float at[3];
    to_floats(p, at);
    return static_cast<double>(sandglass_field_distance(field, at, nullptr));
  };
  v.fill(r, {-k_wide, -k_glass + 1.05 * r, -k_wide}, {k_wide, 0.0, k_wide}, [&](double x, double y, double z) {
    return v.room({x, y, z}) > 1.05 * r;
  });
  return v;
}

// The same with walls, so that there is room beside it; its lower end is open.
Vessel open_glass(double r) {
  Vessel v = glass(r);
  Profile outline = {{0.0, k_glass}}, line = glass_line();
  outline.insert(outline.end(), line.rbegin(), line.rend());
  for (const auto& at : line) outline.push_back({at[0] + 2 * r, at[1]});
  outline.push_back({0.0, k_glass + 2 * r});
  v.room = [](Vec3) { return 0.0; };  // nobody asks
  v.field = vessel(outline, r, SANDGLASS_SOLID_INSIDE);
  v.parts = {cpp::field_at(v.field, 0, 0, 0)};
  return v;
}

Vessel cup(double r) {
  constexpr double k_in = 0.06, k_out = 0.072, k_top = 0.152, k_bottom = 0.012;
  Vessel v;
  v.field = vessel({{0, 0}, {k_out, 0}, {k_out, k_top}, {k_in, k_top}, {k_in, k_bottom}, {0, k_bottom}}, 0.004,
                   SANDGLASS_SOLID_INSIDE);
  v.parts = {cpp::field_at(v.field, 0, 0, 0)};
  v.room = [](Vec3 p) { return std::min(k_in - std::hypot(p.x, p.z), p.y - k_bottom); };
  v.fill(r, {-k_in, k_bottom + 1.05 * r, -k_in}, {k_in, 0.1, k_in},
         [=](double x, double, double z) { return std::hypot(x, z) < k_in - 1.05 * r; });
  return v;
}

Vessel bucket(double r) { return boxes(r, 0.06, 0.14, 2 * r, 0.088); }
Vessel jar(double r) { return boxes(r, 12 * r, 20 * r, 2 * r, 11 * r, true); }
Vessel spoon(double r) { return boxes(r, 0.03, 0.03, 2 * r, 0.015); }
Vessel tray(double r) {
  Vessel v = boxes(r, 0.12, 0.02, 2 * r, 0.0);
  pile(&v, r, 2 * r, 0.085, 1.3);
  return v;
}
Vessel plate(double r) {
  Vessel v;
  v.part(0, 0, 0, 0.15, 0.01, 0.15);
  v.room = [](Vec3 p) { return std::min({0.15 - std::fabs(p.x), 0.15 - std::fabs(p.z), p.y - 0.01}); };
  pile(&v, r, 0.01, 0.09, 1.5);
  return v;
}
Vessel ball(double r, double size) {
  Vessel v;
  v.parts = {cpp::sphere(0, 0, 0, static_cast<float>(size))};
  v.room = [=](Vec3 p) { return length(p) - size; };
  v.pushes = true;
  pile(&v, r, 0.0, 0.11, 1.3);
  return v;
}

Vessel hand(double r) { return ball(r, 0.04); }
Vessel finger(double r) { return ball(r, 0.01); }
// A jar in a jar, and a ball beside it.
Vessel nested_jars(double r) {
  Vessel v = jar(r);
  const Vessel inner = boxes(r, 5 * r, 8 * r, 2 * r, 4 * r, true);
  const Vec3 at = {-4 * r, 2 * r, 0}, ball = {7 * r, 6 * r, 0};
  const auto moved = [&](const float* p) { return from_floats(p) + at; };
  v.sand.clear();
  v.fill(r, {-11 * r, 3.1 * r, -11 * r}, {11 * r, 13 * r, 11 * r}, [&](double x, double y, double z) {
    return std::max(std::fabs(x - at.x), std::fabs(z)) > 8.1 * r && length(Vec3{x, y, z} - ball) > 5.1 * r;
  });
  for (size_t i = 0; i < inner.sand.size(); i += 3) add_point(&v.sand, moved(&inner.sand[i]));
  for (sandglass_collider c : inner.parts) {
    to_floats(moved(c.position), c.position);
    v.parts.push_back(c);
  }
  v.parts.push_back(cpp::sphere(0, 0, 0, static_cast<float>(4 * r)));
  to_floats(ball, v.parts.back().position);
  return v;
}

double eased(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (10.0 + t * (6.0 * t - 15.0));
}
double wave(double hertz, double t) { return t > 0.0 ? std::sin(2.0 * k_pi * hertz * t) : 0.0; }

// Where each is after so many seconds; before, it stands.
Pose turned(double t) {
  const double lift = 0.03 * std::pow(std::sin(k_pi * std::clamp(t / 1.2, 0.0, 1.0)), 2);
  return {{0, k_stand + lift, 0}, k_pi * eased(t / 1.2)};
}
Pose shaken(double t) { return {{t < 2.0 ? 0.05 * wave(2, t) : 0.0, k_stand, 0}}; }
Pose lifted(double t) { return {{0.3 * eased(2 * t - 1), 0.3 * eased(2 * t), 0}}; }
Pose driven(double t) { return {{eased(t), 0.05, 0}}; }
Pose tilted(double t) { return {{0, 0.2, 0}, 0.5 * (eased(2 * t) - eased(2 * t - 2))}; }
Pose pulled(double t) {
  return {{0.2 * eased(t / 0.4), 0.2 + 0.15 * (eased(t / 0.4 - 1.5) - eased(t / 0.4 - 3.5)), 0}};
}
double pushed(double t) { return 0.5 * std::clamp(t, 0.0, 1.0) - 0.25; }
Pose handed(double t) { return {{pushed(t), 0.045, 0}}; }
Pose fingered(double t) { return {{pushed(t), 0.015, 0}}; }
Pose rocked(double t) { return {{0.06 * wave(1.5, t), 0.1 * eased(t), 0}, 1.2 * eased(t)}; }
Pose spooned(double t) { return {{0.3 * eased((t - 0.4) / 0.8), 0.1 * eased(t / 0.4), 0}, 0.1 * eased(t)}; }
Pose marked(double t) {  // by a hand that tilts the marker about a point half a metre away
  const double angle = 0.06 * wave(0.5, t);
  return {Vec3{-0.5, 0.2, 0} + rotate(rotation_by({0, 0, angle}), {0.5, 0, 0}), angle};
}
Pose rising(double t) { return {{0, k_stand + 0.05 * std::max(t, 0.0), 0}, k_pi}; }

enum class Told { velocities, poses };
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

const CarriedScene k_scenes[] = {
    {"glass", k_fine, glass, turned, k_stays, true, true, {2.669, 1.438, 0.696, 0.276, 0.112, 0.061}},
    {"shaken", k_fine, glass, shaken, k_stays, false, false, {2.683, 1.053, 0.446, 0.247, 0.13, 0.065}},
    {"cup", 0.006, cup, lifted, k_rests, false, false, {2.563, 0.947, 0.272, 0.15, 0.079, 0.048}},
    {"bucket", 0.006, bucket, lifted, k_rests, true, true, {2.667, 0.796, 0.319, 0.155, 0.086, 0.046}},
    {"car", 0.006, bucket, driven, k_rests, true, false, {2.54, 0.936, 0.381, 0.208, 0.11, 0.055}},
    {"tray", 0.006, tray, tilted, k_spills, false, false, {2.683, 1.516, 0.7, 0.345, 0.181, 0.098}},
    {"plate", 0.006, plate, pulled, k_spills, false, false, {2.683, 1.411, 0.563, 0.265, 0.139, 0.079}},
    {"hand", 0.006, hand, handed, k_rests, false, false, {2.6, 1.293, 0.328, 0.172, 0.09, 0.045}},
    {"finger", 0.006, finger, fingered, k_rests, false, false, {2.667, 1.374, 0.465, 0.21, 0.117, 0.053}},
    {"jar4", 0.004, jar, rocked, k_stays, true, false, {2.683, 1.083, 0.404, 0.189, 0.092, 0.058}},
    {"jar10", 0.010, jar, rocked, k_stays, false, false, {2.631, 0.944, 0.44, 0.21, 0.104, 0.06}},
    {"spoon", 0.004, spoon, spooned, k_rests, false, false, {2.448, 1.089, 0.453, 0.227, 0.076, 0.06}},
    {"marker", 0.006, tray, marked, k_rests, false, false, {2.498, 1.263, 0.605, 0.307, 0.125, 0.114}},
};
const CarriedScene k_rising = {"rising", k_fine, glass, rising, k_stays, false, false, {}};
Pose stands(double) { return {{0, k_stand, 0}, k_pi}; }
const CarriedScene k_alone = {"alone", k_fine, open_glass, stands, k_stays, false, false, {}};
const CarriedScene k_two_jars = {"two jars", k_fine, nested_jars, rocked, k_stays, false, false, {}};

struct Way {
  double share = 0.0, need = 0.0;  // its budget is that much of the need; 0: unlimited
  double rate = 60.0;              // Hz
  Told told = Told::velocities;
  double late = 0.0;     // seconds that one frame takes longer
  bool clamped = false;  // and its time step does not say so
  Pose jump = {};        // by which its pose is told elsewhere at once
  bool jumps = false;
  bool flows = false;      // a glass beside it that stands, or else its own, runs from the start until half is through
  uint32_t finest = 0;     // quality level
  double lag = 0.0;        // control: seconds by which the velocities that are told are old
  double squeezed = 1.0;   // control: the way of a frame in this much of its time
  bool unlimited = false;  // control: every unit runs
  bool grains = false;     // eight a particle are drawn
  uint64_t seed = 0;
};

struct Seen {
  uint32_t outside = 0, at_end = 0, sand = 0, grains = 0;  // grains: outside, as drawn
  double fastest = 0.0, simulated = 0.0, need = 0.0;
  double over = 0.0;  // microseconds beyond the budget and a unit, or what may be mandatory
  Vec3 place;
};

struct Carried {
  const CarriedScene& what;
  Way way;
  Vessel vessel, standing;
  PhoneClock clock{phone_core("cortex-a78")};
  Simulation scene;
  std::vector<sandglass_collider> colliders;
  Seen seen;
  size_t carried = 0;  // floats of the sand that is, before that of the glass which stands
  uint32_t waiting = 0;

  static constexpr Pose k_beside = {{-0.4, k_stand, 0}, k_pi};
  Carried(const CarriedScene& s, const Way& w, sandglass_isa isa)
      : what(s),
        way(w),
        vessel(s.make(s.radius)),
        standing(s.make == nested_jars ? open_glass(s.radius) : Vessel()),
        scene([&] {
          const size_t sand = vessel.sand.size() + standing.sand.size();
          sandglass_scene_desc desc = with_room(cpp::scene_desc(), static_cast<uint32_t>(sand / 3),
                                                static_cast<uint32_t>(way.grains ? 8 * sand / 3 : 0));
          desc.isa = isa;
          desc.clock = clock.clock();
          desc.finest_level = way.finest;
          desc.granular.collider_capacity = 16;
          desc.granular.particle_radius = static_cast<float>(s.radius);
          if (s.radius == k_fine) desc.granular.static_friction = desc.granular.kinetic_friction = 0.3f;
          return desc;
        }()) {
    clock.follow(scene.handle());
    const Pose first = vessel.pushes ? Pose() : pose(-k_settle);
    std::vector<float> sand;
    for (const auto& [of, at] : {std::pair(&vessel, first), std::pair(&standing, k_beside)})
      for (size_t i = 0; i < of->sand.size(); i += 3) add_point(&sand, at.world(from_floats(&of->sand[i])));
    carried = vessel.sand.size();
    seen.sand = static_cast<uint32_t>(carried / 3);
    Material material;
    for (size_t i = 0; way.grains && i < 8 * sand.size(); ++i) {
      const size_t particle = i / 24, axis = i % 3, corner = i / 3 % 8;
      const float aside = 0.5f * static_cast<float>(s.radius);
      material.grain_positions.push_back(sand[3 * particle + axis] + ((corner >> axis & 1) != 0 ? aside : -aside));
    }
    material.grain_velocities.resize(material.grain_positions.size());
    material.particle_velocities.resize(sand.size());
    material.particle_positions = sand;
    scene.add(material);
    colliders.push_back(cpp::floor_at(0));
    colliders.insert(colliders.end(), vessel.parts.begin(), vessel.parts.end());
    for (sandglass_collider c : standing.parts) {
      place(&c, Vec3(), k_beside);
      colliders.push_back(c);
    }
    for (size_t i = 0; i < colliders.size(); ++i) colliders[i].id = static_cast<uint32_t>(i + 1);
  }

  static void place(sandglass_collider* c, Vec3 part, const Pose& pose) {
    to_floats(pose.world(part), c->position);
    for (size_t k = 0; k < 4; ++k) c->rotation[k] = static_cast<float>(pose.turn()[k]);
  }
  Pose pose(double t) const {
    if (!way.jumps) return what.pose(t);
    const Pose stands = what.pose(-1.0);
    return t > 0.15 ? Pose{stands.at + way.jump.at, stands.angle + way.jump.angle} : stands;
  }
  // Where the vessel is held, by its first part.
  Pose held(const Pose& told) const {
    sandglass_collider c = {};
    if (way.told == Told::velocities || sandglass_scene_held_collider(scene.handle(), 1, &c) == 0) return told;
    const double turned = 2.0 * std::atan2(static_cast<double>(c.rotation[2]), static_cast<double>(c.rotation[3]));
    Pose pose = {{}, told.angle + std::remainder(turned - told.angle, 2.0 * k_pi)};
    pose.at = from_floats(c.position) - rotate(pose.turn(), from_floats(vessel.parts[0].position));
    return pose;
  }

  sandglass_frame_report frame(double from, double to, uint64_t budget) {
    const Pose a = pose(from - way.lag), later = pose(to - way.lag), b = pose(to);
    const double step = (way.clamped ? std::min(to - from, 1.0 / 30) : to - from) * way.squeezed;
    const double per = way.told == Told::velocities ? 1.0 / step : 0.0;
    for (size_t i = 0; i < vessel.parts.size(); ++i) {
      sandglass_collider& c = colliders[i + 1];
      const Vec3 part = from_floats(vessel.parts[i].position), spin = {0, 0, (later.angle - a.angle) * per};
      place(&c, part, b);
      to_floats((later.at - a.at) * per + cross(spin, b.world(part) - b.at), c.linear_velocity);
      to_floats(spin, c.angular_velocity);
    }
    return scene.frame(step, budget, colliders);
  }

  uint32_t beyond(const Pose& pose) {
    const std::vector<float>& p = scene.particle_positions();
    uint32_t sum = 0;
    for (size_t i = 0; i < carried; i += 3) {
      const Vec3 q = from_floats(&p[i]);
      sum += vessel.room(pose.local(q)) < -what.radius || (vessel.pushes && q.y < -what.radius);
    }
    return sum;
  }
  // After a jump, or a start as sudden, which a held pose waits for, sand may be in that for some frames.
  void look(const Pose& told) {
    seen.at_end = beyond(told);
    waiting = seen.at_end != 0 && way.told == Told::poses ? waiting + 1 : 0;
    const Pose shown = waiting != 0 && waiting <= k_waits ? held(told) : told;
    if (waiting != 0) seen.at_end = beyond(shown);
    seen.outside = std::max(seen.outside, seen.at_end);
    const std::vector<float>&p = scene.particle_positions(), &v = scene.particle_velocities();
    Vec3 sum;
    for (size_t i = 0; i < carried; i += 3) {
      sum = sum + (vessel.pushes ? from_floats(&p[i]) : told.local(from_floats(&p[i])));
      seen.fastest = std::max(seen.fastest, length(from_floats(&v[i])));
    }
    uint32_t grains = 0;
    const std::vector<float>& drawn = scene.grain_positions();
    for (size_t i = 0; i < drawn.size(); i += 3)
      grains += vessel.room(shown.local(from_floats(&drawn[i]))) < -what.radius;
    seen.grains = std::max(seen.grains, grains);
    seen.place = sum * (3.0 / static_cast<double>(carried));
  }
  // Whether half of the sand that runs is below the neck.
  bool half_through(const Pose& told) {
    const std::vector<float>& p = scene.particle_positions();
    const double neck = standing.sand.empty() ? told.at.y : k_stand;
    const size_t first = standing.sand.empty() ? 0 : carried;
    size_t below = 0;
    for (size_t i = first; i < p.size(); i += 3) below += p[i + 1] < neck;
    return 2 * below > (p.size() - first) / 3;
  }

  Seen run() {
    const double step = 1.0 / way.rate;
    double t = way.flows ? -step : -k_settle, start = 0.0;
    for (; t < -0.5 * step; t += step) start = frame(t - step, t, k_no_budget).time.simulated;
    const uint64_t budget = way.share > 0.0 ? static_cast<uint64_t>(way.share * way.need) : k_no_budget;
    const double carrying = 20e3 + 100.0 * seen.sand;  // ns, of the mandatory part, beside one unit
    std::vector<double> times;
    double from = t, ahead = step * static_cast<double>(way.seed % 21) / 21.0;
    for (int f = 0; t < (way.flows ? 100.0 : k_moving); ++f) {
      if (f == 10) ahead += way.late;
      t += step;
      const sandglass_frame_report report = frame(from, t + ahead, way.unlimited ? k_no_budget : budget);
      from = t + ahead;
      times.push_back(static_cast<double>(report.time.elapsed_ns));
      const sandglass_time_report& took = report.time;
      const double allowed = std::max(static_cast<double>(budget) + static_cast<double>(took.last_unit_ns),
                                      carrying + static_cast<double>(took.longest_unit_ns));
      seen.over = std::max(seen.over, 1e-3 * (times.back() - allowed));
      seen.simulated = report.time.simulated - start;
      look(pose(from));
      if (way.flows && half_through(pose(from))) break;
    }
    seen.need = quantile(times, 0.9);
    return seen;
  }
};

struct Stopped {};

struct Judge {
  const VerdictChoice& choice;
  const std::function<bool(uint64_t, uint64_t)>& progress;
  std::vector<Verdict> rows = {};
  uint64_t done = 0, total = 0;
  std::string group = {};

  Seen run(const CarriedScene& scene, Way way) {
    if (!progress(done++, total)) throw Stopped();
    way.seed += choice.seed;
    return Carried(scene, way, choice.isa).run();
  }
  void row(const std::string& name, const char* unit, double truth, double result, double limit, bool control = false) {
    const bool within = std::fabs(result - truth) <= limit;
    rows.push_back({group, name, unit, truth, result, limit, within != control, control});
  }

  static std::string name_of(const CarriedScene& scene, Told told) {
    return std::string(scene.name) + (told == Told::poses ? ", poses" : "");
  }
  uint32_t grains_outside(const CarriedScene& scene, Told told) {
    Seen seen = run(scene, {.told = told, .grains = true});
    uint32_t outside = seen.grains;
    for (const double share : k_shares) {
      if (choice.quick && share != 1.0 / 4 && share != 1.0 / 16) continue;
      outside = std::max(outside, run(scene, {.share = share, .need = seen.need, .told = told, .grains = true}).grains);
    }
    return outside;
  }
  // Every budget and rate, folded into one row a claim.
  void budgets(const CarriedScene& scene, Told told) {
    const std::string who = name_of(scene, told);
    uint32_t outside = 0;
    double lost = 0.0, faster = 0.0, flows = 1.0, place = 0.0, over = -k_reported;
    for (const double rate : k_rates) {
      if (choice.quick && rate != 60.0) continue;
      const Seen full = run(scene, {.rate = rate, .told = told});
      if (scene.judged != k_spills) outside = std::max(outside, full.outside);
      for (size_t i = 0; i < std::size(k_shares); ++i) {
        if (choice.quick && k_shares[i] != 1.0 / 4 && k_shares[i] != 1.0 / 16) continue;
        const Seen s = run(scene, {.share = k_shares[i], .need = full.need, .rate = rate, .told = told});
        if (rate == 60.0) flows = std::min(flows, s.simulated / scene.before[i]);
        outside = std::max(outside, s.outside);
        over = std::max(over, s.over);
        lost = std::max(lost, std::fabs(1.0 * s.at_end - full.at_end) / s.sand);
        faster = std::max(faster, s.fastest - full.fastest);
        place = std::max(place, length(s.place - full.place));
      }
    }
    if (scene.judged == k_spills) row(who + ": lost, beside full", "of all", 0.0, lost, 0.1);
    else row(who + ": outside", "particles", 0.0, outside, 0.0);
    row(who + ": faster than at full", "m/s", 0.0, std::max(faster, 0.0), 0.4);
    row(who + ": simulated, of before", "", 1.0, flows, 0.15);
    if (scene.judged == k_rests) row(who + ": place", "m", 0.0, place, 0.02);
    row(who + ": over its budget", "us", 0.0, std::max(over, 0.0), 0.0);
    if (scene.grained) row(who + ": grains outside", "grains", 0.0, grains_outside(scene, told), 0.0);
  }

  // One frame takes longer, and tells it or not: then that is a jump.
  void hitches(const CarriedScene& scene, Told told) {
    for (const bool clamped : {false, true}) {
      uint32_t outside = 0, lost = 0;
      for (const double late : {0.117, 0.25, 0.5, 1.0, 2.0}) {
        const Seen s = run(scene, {.told = told, .late = late, .clamped = clamped});
        outside = std::max(outside, s.outside);
        lost = std::max(lost, s.at_end);
      }
      const std::string who = name_of(scene, told) + (clamped ? ", hitch that no step tells" : ", hitch");
      if (!clamped) row(who + ": outside", "particles", 0.0, outside, 0.0);
      row(who + ": lost", "particles", 0.0, lost, 0.0);
    }
  }
  void jumps(const CarriedScene& scene) {
    const std::pair<const char*, Pose> all[] = {
        {"5 cm", {{0.05, 0, 0}}}, {"30 cm", {{0.3, 0, 0}}}, {"30 degrees", {{}, k_pi / 6}}};
    for (const auto& [what, jump] : all) {
      if (jump.angle != 0.0 && scene.judged == k_rests) continue;  // a bucket spills
      const Seen s = run(scene, {.told = Told::poses, .jump = jump, .jumps = true});
      row(std::string(scene.name) + ", jump of " + what + ": outside", "particles", 0.0, s.outside, 0.0);
    }
  }
  // The mean of many starts: of one alone it varies by 3 %. Slow motion has the sub-steps of the level before it.
  Seen half_through(const CarriedScene& scene, Way way) {
    constexpr uint64_t k_starts = 21;
    Seen mean;
    way.flows = true;
    for (way.seed = 0; way.seed < k_starts; ++way.seed) {
      const Seen s = run(scene, way);
      mean.simulated += s.simulated / k_starts;
      mean.outside = std::max(mean.outside, s.outside);
    }
    return mean;
  }
  void flow() {
    const auto compare = [&](const CarriedScene& scene, const CarriedScene& alone, Told told,
                             std::initializer_list<int> parts) {
      const double truth = half_through(alone, {.finest = SANDGLASS_LEVEL_COARSER}).simulated;
      const double need = run(scene, {.told = told, .flows = true}).need;
      for (const int part : parts) {
        const Seen s = half_through(scene, {.share = 1.0 / part, .need = need, .told = told});
        const std::string who = std::string(scene.name) + " at 1/" + std::to_string(part);
        row(who + ": half through", "s", truth, s.simulated, 0.02 * truth);
        row(who + ": outside", "particles", 0.0, s.outside, 0.0);
      }
    };
    compare(k_rising, k_rising, Told::velocities, {2, 4, 8, 16});
    compare(k_two_jars, k_alone, Told::poses, {16});
  }
  void controls() {
    const CarriedScene &glass = k_scenes[0], &bucket = k_scenes[3];
    const Seen all = run(glass, {.share = 1.0 / 16, .need = run(glass, {}).need, .unlimited = true});
    row("every unit runs: over its budget", "us", 0.0, std::max(all.over, 0.0), 0.0, true);
    const Seen still = run(glass, {.told = Told::poses, .squeezed = 0.0});
    row("no time passes: simulated, of before", "", 1.0, still.simulated / glass.before[0], 0.15, true);
    row("velocities that lag: outside", "particles", 0.0, run(bucket, {.lag = 0.1}).outside, 0.0, true);
    // What is done without a carry: the way of a frame in a sixteenth of its time.
    row("no carry: outside", "particles", 0.0, run(bucket, {.squeezed = 1.0 / 16}).outside, 0.0, true);
  }
};

std::vector<std::string> carried_groups() {
  std::vector<std::string> groups;
  for (const CarriedScene& scene : k_scenes) groups.emplace_back(scene.name);
  groups.insert(groups.end(), {"flow", "control"});
  return groups;
}

// `quick`: three scenes at 60 Hz. `seed` moves the start of every way by less than a frame. For `progress` see
// granular_verdicts: in runs.
std::vector<Verdict> carried_verdicts(const VerdictChoice& choice,
                                      const std::function<bool(uint64_t, uint64_t)>& progress) {
  Judge judge{.choice = choice, .progress = progress};
  std::vector<std::string> quick = carried_groups();
  if (choice.quick) quick = {"glass", "bucket", "control"};  // a hand is not yet as it must be
  const auto among = [](const std::vector<std::string>& all, const std::string& one) {
    return std::find(all.begin(), all.end(), one) != all.end();
  };
  const auto runs = [&](const std::string& group) {
    judge.group = group;
    return among(quick, group) && (choice.groups.empty() || among(choice.groups, group));
  };
  judge.total = choice.quick ? 42 : std::size(k_scenes) * 2 * std::size(k_rates) * (1 + std::size(k_shares)) + 269;
  try {
    for (const CarriedScene& scene : k_scenes) {
      if (!runs(scene.name)) continue;
      for (const Told told : {Told::velocities, Told::poses}) {
        judge.budgets(scene, told);
        if (scene.hitches && (!choice.quick || scene.judged == k_rests)) judge.hitches(scene, told);
      }
      if (!choice.quick && scene.hitches) judge.jumps(scene);
    }
    if (runs("flow")) judge.flow();
    if (runs("control")) judge.controls();
  } catch (const Stopped&) {
  }
  return judge.rows;
}

Options options_of(VerifyOptions& o) {
  return {cases_option(o, "Only these", carried_groups()),
          {"--quick", &o.quick, "", "Three scenes, two budgets, 60 Hz"},
          seed_option(o.seed, "By which part of a frame a way begins later"),
          isa_option(o.isa),
          json_option(o.json)};
}

int run(const VerifyOptions& options) {
  const VerdictChoice choice = {options.cases, options.quick, find_isa(options.isa), options.seed};
  const std::vector<Verdict> rows =
      with_progress("verifying", [&](const auto& progress) { return carried_verdicts(choice, progress); });
  return tell(options, "carried", kernels_of(choice.isa), rows);
}

}  // namespace

Command verify_carried_suite() {
  return command<VerifyOptions>(
      "carried", "Sand in what is moved: whether it stays and flows where the budget is short", options_of, run);
}

}  // namespace sandglass::host
