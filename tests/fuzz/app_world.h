// An app's world: a tracker finds planes, corrects, loses and finds them; hands come with poses alone; lists change their
// order; sand is poured, frames are late, scenes are moved and saved. It stands still in the end.
//
// The bytes say what kind of world it is: a seed, then a byte for each of Settings; those that are missing follow from
// the seed. Everything is reckoned in the app's world. The scene's own coordinates are another pose of it, which only
// sandglass_scene_move changes.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "models/geometry/vec3.h"
#include "runtime/math/random.h"
#include "tests/sand/granular_scene.h"

namespace sandglass::fuzz {

using host::Vec3;

// A turn, then a shift.
struct Pose {
  Vec3 p;
  host::Quaternion q = host::k_no_rotation;

  Vec3 turn(Vec3 v) const { return host::rotate(q, v); }
  Vec3 operator()(Vec3 v) const { return turn(v) + p; }
  Pose operator*(const Pose& b) const { return {(*this)(b.p), host::normalised(host::multiply(q, b.q))}; }
  Pose inverse() const { return {host::rotate(host::conjugate(q), p * -1.0), host::conjugate(q)}; }
};
inline Pose turned(Vec3 by) { return {{}, host::rotation_by(by)}; }

enum Ground : uint8_t { k_plane, k_table, k_table_over_floor, k_room, k_case, k_grounds };

// One bit each.
enum Plane { jumps = 1, tilts = 2, grows = 4, travels = 8, velocity_given = 16, belt = 32, lost = 64, twice = 128 };
enum HandBits {
  first_hand = 1,
  second_hand = 2,
  hand_velocity_given = 4,
  spins = 8,
  flickers = 16,
  not_a_number = 32,
  swells = 64,
  leaps = 128
};
enum Nozzle { above = 1, in_ground = 2, in_hand = 4, fast = 8 };
enum Calls { moves = 1, saves = 2, restores = 4, fresh = 8, old = 16, not_found = 32, removes = 64, turns = 128 };
enum List { order = 1, sign = 2, far_hand = 4, restless = 8, body = 16, sink = 32, ids = 64 };

struct Settings {
  uint8_t seed[4];
  // Of 2 mm to 5 cm; a Ground; the tracker's noise; 30 to 240 Hz, from 64 on irregular, from 128 on with gaps; 0.02 to
  // 2 m/s; from 128 on gravity turns; from 128 on the budget is short.
  uint8_t radius, ground, noise, rate, pace, gravity, budget;
  // Of Plane, HandBits, Nozzle, Calls, List.
  uint8_t plane, hand, nozzle, calls, list;
};

constexpr double k_longest = 0.1;                           // seconds of a frame that the library takes
constexpr double k_floor = 0.75;                            // m, from a table down to the floor
constexpr uint32_t k_second_plane = 20, k_first_hand = 21;  // ids; those of the ground count from 1

struct Solid {
  sandglass_shape shape;
  Pose pose;
  Vec3 size = {}, velocity = {}, spin = {};
  uint32_t id = 0;  // in worlds with ids

  // Metres from the surface, below 0 inside; in a room, which is solid beyond `size`, above 0.
  double distance(Vec3 world) const {
    Vec3 x = pose.inverse()(world);
    if (shape == SANDGLASS_SHAPE_HALF_SPACE) return x.y;
    if (shape == SANDGLASS_SHAPE_SPHERE) return length(x) - size.x;
    if (shape == SANDGLASS_SHAPE_CAPSULE)
      return length(Vec3{x.x, std::fmax(std::fabs(x.y) - size.y, 0.0), x.z}) - size.x;
    x = Vec3{std::fabs(x.x), std::fabs(x.y), std::fabs(x.z)} - size;
    const double deepest = std::fmax(x.x, std::fmax(x.y, x.z));
    if (shape == SANDGLASS_SHAPE_FIELD) return -deepest;
    return deepest < 0 ? deepest : length(Vec3{std::fmax(x.x, 0.0), std::fmax(x.y, 0.0), std::fmax(x.z, 0.0)});
  }
};

// A finding: which invariant, then its numbers.
template <class... Numbers>
[[noreturn]] void found(const char* format, Numbers... numbers) {
  char text[400];
  std::snprintf(text, sizeof text, format, numbers...);
  throw std::string(text);
}
inline void must(const Status& status) {
  if (!status) found("calls: %s", status.reason);
}

struct World {
  World(const uint8_t* data, size_t size) {
    uint8_t bytes[sizeof set] = {};
    std::memcpy(bytes, data, size < sizeof bytes ? size : sizeof bytes);
    uint32_t seed;
    std::memcpy(&seed, bytes, sizeof seed);
    random = random_stream(seed, 0);
    for (size_t i = sizeof seed; i < sizeof bytes; ++i) {
      // Of the flags three in eight are set, so that worlds differ.
      const uint64_t bits = random.next(), few = bits >> 8 & (bits >> 16 | (bits >> 24 & bits >> 32));
      if (i >= size) bytes[i] = static_cast<uint8_t>(i < offsetof(Settings, plane) ? bits : few);
    }
    std::memcpy(&set, bytes, sizeof set);
    random = random_stream(seed, 1);
    constexpr double k_noise[] = {0, 0.00002, 0.0001, 0.0003, 0.001};
    r = 0.002 * std::pow(25.0, set.radius / 255.0);
    sd = k_noise[set.noise % 5];
    rate = 30.0 * std::pow(8.0, (set.rate & 63) / 63.0);
    pace = 0.02 * std::pow(100.0, set.pace / 255.0);
    kind = set.ground % k_grounds;
    closed = kind >= k_room;
    thin = kind != k_plane && kind != k_room;
    make_ground();
    make_scene();
    make_hands();
  }

  // What an app does before a frame.
  void act() {
    if ((set.calls & moves) != 0 && one_in(100))
      move_scene(Pose{anywhere(2, -2, 2)} *
                 turned((set.calls & turns) != 0 ? anywhere(2, -2, 2) : Vec3{0, between(-3, 3), 0}) *
                 Pose{{}, scene_pose.q});
    const bool now = one_in(60), back = (set.calls & (restores | fresh)) != 0;
    if (now && (back || (set.calls & saves) != 0) && ((set.calls & old) == 0 || saved.empty() || one_in(4))) {
      must(scene.save(&saved));
      saved_pose = scene_pose;
    }
    if (now && back && !one_in(3)) {
      if ((set.calls & fresh) != 0) must(scene.create(desc));
      scene_pose = saved_pose;
      set_gravity(gravity);
      must(scene.restore(saved));
      // An app finds its planes later. Sand falls by 11 cm until then at most.
      if ((set.calls & not_found) != 0) empty_frames = random.below(static_cast<uint32_t>(0.15 * rate));
      report.sand.particle_numbers = desc.granular.particle_capacity;
      begins_anew = restored = true;
    }
    if ((set.calls & removes) != 0 && one_in(200)) must(scene.remove(ball(anywhere(5 * r, 0, 5 * r), 4 * r)));
    if ((set.plane & lost) != 0 && one_in(200)) lost_frames = 1 + random.below(static_cast<uint32_t>(0.1 * rate));
    if ((set.plane & twice) != 0 && kind <= k_table && one_in(100)) second_plane = !second_plane;
    if (set.gravity < 128 || !one_in(2)) return;
    // An open heap is tilted by 2 degrees and shaken by a sensor's noise, a closed one turned.
    const double tilt_max = closed ? (set.gravity - 127) / 128.0 * 3.0 : 0.035;
    set_gravity(turned(normalised(Vec3{axis.x, 0, axis.z}) * (tilt_max * std::sin(simulated)))
                    .turn({0, -9.81 + 0.02 * normal(), 0}));
  }

  // One frame of the moving world; the seconds that were asked for.
  double move_on() {
    double real = 1 / rate, step = 0;
    if ((set.rate & 64) != 0) real *= between(0.5, 1.5);
    step = real;
    if ((set.rate & 128) != 0 && one_in(50)) one_in(2) ? step = 0 : step = real = log_between(0.03, 0.5);
    move_ground(step);
    for (Hand& hand : hands) move_hand(&hand, real, step);
    list_colliders();
    const uint64_t removed = report.sand.removed_particles;
    frame(step, true);
    // A number that was given up may already be another particle's.
    sides_known = sides_known && report.sand.removed_particles == removed;
    return step;
  }

  // From here on nothing moves but what no sleeper must see: places and signs in the list, a far hand, and noise that
  // stays within the band.
  void stop() {
    sd = (set.list & restless) != 0 ? std::fmin(sd, 0.0001) : 0.0;
    // Also where sand has rolled to: farther away the same angle is a longer way.
    for (size_t i = 0; i < positions.size(); ++i)
      if (present[i] != 0) reach = std::fmax(reach, length(positions[i] - drawn.p));
    // What has no pose is left out: it goes away and comes back.
    set.hand &= static_cast<uint8_t>(~not_a_number);
    stands_still = true;
    lost_frames = empty_frames = 0;
    travel = belt_speed = {};
    turn_rate = 0;
    next_correction = 1e9;
    move_ground(0);
    // A hand stays if sand has room between it and all else.
    std::vector<Solid> others = ground_solids();
    for (Hand& hand : hands) {
      Solid& s = hand.solid;
      s.velocity = s.spin = {};
      for (const Solid& other : others) hand.here = hand.here && other.distance(s.pose.p) > length(s.size) + 4 * r;
      others.push_back(s);
    }
  }
  void stand() {
    move_ground(0);
    list_colliders();
    frame(1 / rate, false);
  }

  void move_scene(const Pose& next) {
    const Pose by = next * scene_pose.inverse();
    std::array<float, 3> p;
    host::to_floats(by.p, p.data());
    must(scene.move({static_cast<float>(by.q[0]), static_cast<float>(by.q[1]), static_cast<float>(by.q[2]),
                     static_cast<float>(by.q[3])},
                    p));
    scene_pose = next;
    set_gravity(gravity);
  }

  // Positions and velocities by number; a removed one is not `present`.
  void read() {
    const uint32_t numbers = report.sand.particle_numbers;
    std::vector<float> p(3ull * numbers, SANDGLASS_REMOVED_Y), v(p.size());
    sandglass_scene_particles(scene.get(), p.data(), v.data());
    positions.resize(numbers);
    velocities.resize(numbers);
    present.resize(numbers);
    away.resize(numbers);
    const Pose back = scene_pose.inverse();
    for (size_t i = 0; i < numbers; ++i) {
      positions[i] = back(host::from_floats(&p[3 * i]));
      velocities[i] = back.turn(host::from_floats(&v[3 * i]));
      const bool there = p[3 * i + 1] != SANDGLASS_REMOVED_Y, out = there && has_left(positions[i]);
      // What had left and comes back, as gravity has turned, is as fast as its fall elsewhere.
      if (away[i] != 0 && there && !out) moves_at(length(velocities[i]));
      away[i] = out;
      present[i] = there && !out;
    }
  }

  // Metres beyond the inner surface of the walls, or below the ground, in their own frame.
  double beyond(Vec3 world) const {
    const Vec3 x = drawn.inverse()(world);
    if (!closed) return -x.y;
    return std::fmax(std::fmax(std::fabs(x.x), std::fabs(x.z)), std::fabs(x.y - cavity)) - cavity;
  }
  // Nothing is there that it could land on.
  bool has_left(Vec3 world) const { return (kind == k_table || kind == k_case) && beyond(world) > thick + 2 * r; }

  Settings set;
  double r, sd, rate, pace;
  uint8_t kind;
  bool closed, thin;
  Scene scene;
  sandglass_frame_report report = frame_report();
  Vec3 gravity = {0, -9.81, 0};
  double simulated = 0, step_done = 0;  // seconds; of the last frame
  double body_mass = 1;                 // of a body's particle over that of sand
  uint32_t frames = 0, in_bodies = 0;
  // Of this frame: the speed of what moves, and the highest nozzle. Jumps have none: they are the tracker's.
  double fastest = 0;
  std::vector<Vec3> nozzle_places;
  // What was given in this frame and is no mistake, the ground first.
  std::vector<Solid> solids;
  // false: on which side of a wall a particle was tells nothing. true: sand came from elsewhere than the last frame.
  bool sides_known = true, begins_anew = true;
  Pose scene_pose, drawn;  // the world in the scene; the ground with this frame's noise, y = 0 is where sand lies
  double thick = 0, cavity = 0;
  Vec3 extent, slide;  // of a table: half its edges, the middle
  std::vector<Vec3> positions, velocities;
  std::vector<char> present, away;

 private:
  struct Hand {
    Solid solid;
    Vec3 target, axis;
    bool here = true;
    double swells = 0;  // seconds
  };

  double between(double low, double high) { return low + (high - low) * random.uniform(); }
  double log_between(double low, double high) { return low * std::pow(high / low, random.uniform()); }
  bool one_in(uint32_t n) { return random.below(n) == 0; }
  Vec3 anywhere(double sideways, double low, double high) {
    const double x = between(-sideways, sideways), y = between(low, high);
    return {x, y, between(-sideways, sideways)};
  }
  // About normal, of deviation 1.
  double normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += random.uniform();
    return sum;
  }
  Vec3 noise() {
    const double x = sd * normal(), y = sd * normal();
    return {x, y, sd * normal()};
  }
  void moves_at(double speed) { fastest = std::fmax(fastest, speed); }

  // Walls are so thick that corrections and lifts leave sand nearer to the side that it was on, as a shape alone does not
  // say which way is out: a correction is at most a quarter of a wall, a lift takes half a second for one.
  void make_ground() {
    thick = std::fmax(between(2.5, 5) * r, std::fmax(20 * sd, between(0.015, 0.05)));
    cavity = 9 * r + 0.04;
    reach = closed ? 3 * cavity : 0.15 + 10 * r;
    extent = {between(0.3, 0.6) + 12 * r, 0.5 * thick, between(0.3, 0.6) + 12 * r};
    if (one_in(3)) slide.x = extent.x - between(1, 5) * r;  // sand lies at the edge
    // Sand of the default friction, 0.16, slides from 9 degrees on: 2 for this, 2 for corrections, 2 for gravity.
    ground = Pose{anywhere(0.5, -0.5, 0.5)} * turned({0, between(0, 6), 0}) * turned(anywhere(0.025, 0, 0));
    axis = anywhere(1, 0.1, 1);
    const double speed = std::fmin(pace, thin ? 2 * thick : 0.3);
    if ((set.plane & travels) != 0)
      closed ? turn_rate = speed / reach : one_in(2) ? travel.y = speed : travel.x = speed;
    if ((set.plane & belt) != 0 && !closed) belt_speed.x = std::fmin(pace, 0.3);
    if (kind != k_room) return;
    const float a = static_cast<float>(cavity), spacing = std::fmax(static_cast<float>(r), a / 12),
                out = a + 2 * spacing;
    must(field.from_function(
        {{-out, -out, -out}, {out, out, out}}, spacing, SANDGLASS_SOLID_OUTSIDE,
        [a](const float* p) { return a - std::fmax(std::fabs(p[0]), std::fmax(std::fabs(p[1]), std::fabs(p[2]))); }));
  }

  void make_scene() {
    // Small particles take many sub-steps.
    desc = description(96 + set.radius * 160u / 255u);
    sandglass_granular_desc& g = desc.granular;
    g.particle_radius = static_cast<float>(r);
    g.collider_capacity = 32;
    g.emitter_capacity = 2;
    g.sink_capacity = 1;
    g.body_capacity = 1;
    g.body_particle_capacity = 27;
    if (set.budget >= 128) {
      desc.unit_items = 64;
      unit_ns = 10'000 + random.below(40'000);
      desc.clock = {[](void* user) { return static_cast<World*>(user)->clock_ns; }, this};
      desc.trace = {
          nullptr,
          [](void* user, const char*) { static_cast<World*>(user)->clock_ns += static_cast<World*>(user)->unit_ns; },
          this};
    }
    must(scene.create(desc));
    if ((set.calls & turns) != 0) scene_pose = Pose{anywhere(2, -2, 2)} * turned(anywhere(2, -2, 2));
    set_gravity(gravity);
    const float spacing = 2.02f * g.particle_radius;
    const uint32_t wide = 3 + random.below(3), high = 1 + random.below(closed ? 3 : 6) * g.particle_capacity / 256;
    const auto placed = [&](std::vector<float> points, double rise) {
      const double middle = 0.5 * (wide - 1) * static_cast<double>(spacing);
      for (size_t i = 0; i < points.size(); i += 3)
        to_floats(scene_pose(ground(host::from_floats(&points[i]) + Vec3{-middle, rise, -middle})), &points[i]);
      return points;
    };
    // Sand that is poured into a body stays in it: the header asks for free space.
    if ((set.list & body) != 0 && set.nozzle == 0) {
      const auto box = placed(lattice(3, 3, 3, spacing, g.particle_radius), (2.1 * high + 2) * r);
      sandglass_body b = sandglass::body();
      b.particle_positions = box.data();
      b.particle_count = in_bodies = 27;
      body_mass = log_between(1, 4);
      b.density_ratio = static_cast<float>(body_mass);
      must(scene.add_body(b));
    }
    must(scene.add(placed(lattice(wide, high, wide, spacing, g.particle_radius), 0)));
    report.sand.particle_numbers = in_bodies + wide * high * wide;
  }

  void make_hands() {
    for (uint32_t i = (set.hand & first_hand) + (set.hand >> 1 & first_hand); i > 0; --i) {
      const double size = std::fmin(std::fmax(log_between(0.008, 0.06), r), closed ? cavity / 3 : 1.0);
      Hand hand = {{static_cast<sandglass_shape>(1 + random.below(3)), {ground(anywhere(0.2, 0.1, 0.3))}}, {}, {}};
      hand.solid.id = i == first_hand ? k_first_hand : 0;  // the other has none
      hand.solid.size = {size, size * between(0.3, 1), size * between(0.3, 1)};
      hand.axis = anywhere(1, 0.1, 1);
      hands.push_back(hand);
    }
    for (const int which : {above | 0, in_ground | in_hand}) {
      if ((set.nozzle & which) == 0) continue;
      // What is poured in a long frame appears as far away as it has gone: it must not be below the ground then.
      const double speed = (set.nozzle & fast) != 0 && which == above && !closed ? between(0.5, 3) : between(0.05, 0.3);
      const double height = which != above ? between(-2, 2) * r : closed ? cavity : 0.1 + speed * k_longest;
      nozzles.push_back(emitter(0, static_cast<float>(height), 0, static_cast<float>(between(1, 4) * r),
                                static_cast<float>(closed ? std::fmin(speed, cavity) : speed), 0));
    }
  }

  // The tracker's new mind: up or down, tilted, larger. The next comes when this one can have been followed.
  void correct_ground() {
    double left = std::fmin(thin ? thick / 4 : 0.05, log_between(0.001, 0.05));
    if ((set.plane & tilts) != 0) {
      const double angle = std::fmin(tilt_left, 0.5 * left / std::fmax(reach, closed || !thin ? 0.0 : length(extent)));
      ground = ground * turned(normalised(anywhere(1, 0, 0) + Vec3{1e-3, 0, 0}) * angle);
      tilt_left -= angle;
      left *= 0.5;
    }
    if ((set.plane & jumps) != 0) ground.p.y += one_in(2) ? left : -left;
    if ((set.plane & grows) != 0) {
      slide = slide + anywhere(0.1, 0, 0);
      extent = extent + Vec3{between(0, 0.1), 0, between(0, 0.1)};
    }
    next_correction = simulated + 1.5 + between(0, 3);
  }

  // Lifts and turns go no further in a frame than the sand has had time for.
  void move_ground(double step) {
    if (simulated > next_correction) correct_ground();
    const double real = std::fmin(step, k_longest);
    const double by = std::fmod(simulated, 4.0) > 2.0 ? std::fmin(real, 2 * step_done) : 0.0;
    const Vec3 before = drawn.p;
    ground.p = ground.p + travel * by;
    ground = ground * turned(axis * (by * turn_rate / length(axis)));
    if (by > 0) moves_at(length(travel) + turn_rate * reach);
    drawn = Pose{noise()} * ground * turned({sd * normal() / reach, 0, 0});
    given_velocity = ground.turn(belt_speed);
    given_spin = {};
    if ((set.plane & velocity_given) != 0 && real > 0 && frames > 0) {
      given_velocity = given_velocity + (drawn.p - before) * (1 / real);
      given_spin = ground.turn(axis) * (by / real * turn_rate / length(axis));
    }
    moves_at(length(given_velocity) + length(given_spin) * reach);
  }

  // A hand is as fast as its poses are in the time that is simulated. In a pause it goes on: that is a jump.
  void move_hand(Hand* hand, double real, double step) {
    Solid& s = hand->solid;
    const Vec3 offset = ground(hand->target) - s.pose.p;
    if (length(offset) < pace * real || length(offset) > 1.0)
      hand->target = closed ? anywhere(0.8 * cavity, 0, 2 * cavity) : anywhere(0.1 + 6 * r, -0.03, 0.1 + 6 * r);
    const Vec3 velocity = offset * (pace / std::fmax(length(offset), 1e-6));
    s.pose.p = s.pose.p + velocity * real;
    double speed = pace;
    Vec3 spin;
    if ((set.hand & spins) != 0) {
      spin = normalised(hand->axis) * std::fmin(pace / length(s.size), 5.0);
      speed += length(spin) * length(s.size);
      s.pose = Pose{s.pose.p} * turned(spin * real) * Pose{{}, s.pose.q};
    }
    if ((set.hand & swells) != 0) {
      constexpr double k_swelling = 0.02;  // m/s
      // By what was swollen, not by frames: where those are uneven, a hand would grow larger than the case.
      const auto swollen = [&] { return k_swelling * (1 - std::fabs(std::fmod(hand->swells, 2.0) - 1)); };
      const double before = swollen();
      hand->swells += real;
      const double by = swollen() - before;
      s.size = {std::fmax(s.size.x + by, 0.004), std::fmax(s.size.y + by, 0.004), std::fmax(s.size.z + by, 0.004)};
      speed += 2 * k_swelling;  // sqrt(3) at the corner of a box
    }
    if ((set.hand & leaps) != 0 && one_in(100)) {
      const Vec3 before = s.pose.p;
      s.pose.p = ground(anywhere(0.1 + 4 * r, 0, 0.1));
      // What 50 m/s^2 can do in a long frame is no jump: the hand went there.
      const double leap = length(s.pose.p - before);
      if (leap <= ((set.list & ids) != 0 ? 1.0 : 0.25) && 2 * leap <= 50 * real * real) speed += leap / real;
    }
    if ((set.hand & flickers) != 0 && one_in(40)) hand->here = !hand->here;
    const bool says = (set.hand & hand_velocity_given) != 0;
    s.velocity = says ? velocity : Vec3{};
    s.spin = says ? spin : Vec3{};
    if (step > 0) moves_at(speed * std::fmax(1.0, real / std::fmin(step, k_longest)));
  }

  std::vector<Solid> ground_solids() const {
    std::vector<Solid> made;
    uint32_t id = 0;
    const auto add = [&](sandglass_shape shape, Vec3 place, Vec3 size) {
      made.push_back(
          {shape, drawn * Pose{place}, size, given_velocity + cross(given_spin, drawn.turn(place)), given_spin, ++id});
    };
    const double a = cavity, t = 0.5 * thick, b = a + 2 * t;
    if (kind == k_plane) add(SANDGLASS_SHAPE_HALF_SPACE, slide, {});
    if (kind == k_table || kind == k_table_over_floor) add(SANDGLASS_SHAPE_BOX, slide - Vec3{0, t, 0}, extent);
    if (kind == k_table_over_floor) add(SANDGLASS_SHAPE_HALF_SPACE, {0, -k_floor, 0}, {});
    if (kind == k_room) add(SANDGLASS_SHAPE_FIELD, {0, a, 0}, {a, a, a});
    for (const double side : {-a - t, a + t}) {
      if (kind != k_case) break;
      add(SANDGLASS_SHAPE_BOX, {0, a + side, 0}, {b, t, b});
      add(SANDGLASS_SHAPE_BOX, {side, a, 0}, {t, b, b});
      add(SANDGLASS_SHAPE_BOX, {0, a, side}, {b, b, t});
    }
    return made;
  }

  // As the scene is given it.
  sandglass_collider given(const Solid& s) {
    sandglass_collider c = collider(s.shape, 0, 0, 0);
    const Pose pose = scene_pose * s.pose;
    const double flip = (set.list & sign) != 0 && one_in(2) ? -1.0 : 1.0;
    for (size_t k = 0; k < 4; ++k) c.rotation[k] = static_cast<float>(flip * pose.q[k]);
    to_floats(pose.p, c.position);
    to_floats(scene_pose.turn(s.velocity), c.linear_velocity);
    to_floats(scene_pose.turn(s.spin), c.angular_velocity);
    if (s.size.x > 0) to_floats(s.size, c.size);
    // An anchor may be lost for a frame.
    if ((set.list & ids) != 0) c.id = !stands_still && one_in(50) ? 0 : s.id;
    c.field = s.shape == SANDGLASS_SHAPE_FIELD ? field.get() : nullptr;
    return c;
  }
  sandglass_collider ball(Vec3 place, double radius) {
    return given({SANDGLASS_SHAPE_SPHERE, {ground(place)}, {radius, radius, radius}});
  }

  void list_colliders() {
    colliders.clear();
    solids = lost_frames == 0 && empty_frames == 0 ? ground_solids() : std::vector<Solid>();
    sides_known = !solids.empty();
    for (const Solid& s : solids) colliders.push_back(given(s));
    if (second_plane && !solids.empty()) {
      Solid again = solids[0];
      again.id = k_second_plane;
      again.pose = Pose{noise()} * again.pose;
      colliders.push_back(given(again));
    }
    for (const Hand& hand : hands) {
      if (!hand.here || empty_frames > 0) continue;
      solids.push_back(hand.solid);
      colliders.push_back(given(hand.solid));
      if ((set.hand & not_a_number) != 0 && one_in(50))
        colliders.back().position[1] = std::numeric_limits<float>::quiet_NaN();
    }
    if ((set.list & order) != 0 && one_in(5))
      for (size_t i = colliders.size(); i > 1; --i)
        std::swap(colliders[i - 1], colliders[random.below(static_cast<uint32_t>(i))]);
    // A hand that nothing can touch comes and goes, at the front.
    if ((set.list & far_hand) != 0 && empty_frames == 0 && one_in(2))
      colliders.insert(colliders.begin(), ball({2 + extent.x, 2, 0.1 * normal()}, 0.05));
    lost_frames -= lost_frames > 0;
    empty_frames -= empty_frames > 0;
  }

  void set_gravity(Vec3 g) {
    gravity = g;
    std::array<float, 3> v;
    host::to_floats(scene_pose.turn(g), v.data());
    must(scene.set_gravity(v));
  }

  void frame(double step, bool pours) {
    sandglass_frame_input input = frame_input();
    input.time_step = static_cast<float>(step);
    input.budget_ns = ~0ull >> 1;
    if (set.budget >= 128 && pours) input.budget_ns = static_cast<uint64_t>(log_between(3e5, 1e7));
    input.colliders = colliders.data();
    input.collider_count = static_cast<uint32_t>(colliders.size());
    nozzle_places.clear();
    std::vector<sandglass_emitter> open;
    for (sandglass_emitter e : nozzles) {
      if (!pours || simulated < 0.5) break;
      const bool held = (set.nozzle & in_hand) != 0 && &e != &nozzles[0] && !hands.empty() && e.speed <= 0.3f;
      const Pose pose = scene_pose * Pose{held ? hands[0].solid.pose.p : ground({0, e.position[1], 0})};
      nozzle_places.push_back(scene_pose.inverse()(pose.p));
      to_floats(pose.p, e.position);
      for (size_t k = 0; k < 4; ++k) e.rotation[k] = static_cast<float>(pose.q[k]);
      moves_at(static_cast<double>(e.speed));
      open.push_back(e);
    }
    input.emitters = open.data();
    input.emitter_count = static_cast<uint32_t>(open.size());
    const sandglass_collider drain = ball({8 * r, 0, 0}, 3 * r);
    if ((set.list & sink) != 0 && pours) {
      input.sinks = &drain;
      input.sink_count = 1;
    }
    must(scene.frame(input, &report));
    // A restored scene counts from another time.
    step_done = restored ? std::fmin(step, k_longest) : report.time.simulated - scene_time;
    scene_time = report.time.simulated;
    simulated += step_done;
    restored = false;
    ++frames;
  }

  Random random = {0};
  sandglass_scene_desc desc;
  Field field;
  uint64_t clock_ns = 0, unit_ns = 0;
  Pose ground;  // without noise
  Vec3 travel, belt_speed, axis, given_velocity, given_spin;
  double reach = 0, tilt_left = 0.035, turn_rate = 0, next_correction = 0.5, scene_time = 0;
  uint32_t lost_frames = 0, empty_frames = 0;
  bool second_plane = false, restored = false, stands_still = false;
  std::vector<Hand> hands;
  std::vector<sandglass_emitter> nozzles;
  std::vector<sandglass_collider> colliders;
  std::vector<std::byte> saved;
  Pose saved_pose;
};

}  // namespace sandglass::fuzz
