// Ten seconds of an app's world (app_world.h), and what must hold in any of them:
//
//   speed    nothing is faster than the colliders and nozzles of the last seconds + 1.5 m/s, above free fall
//   walls    nothing goes through a wall that is thicker than 2 r
//   sleep    when the world stands still and what fell has landed, 95 % are asleep after 5 s and all after 30 s; what a
//            held pose wakes that is corrected within its band, again after 5 s
//   depth    nothing is left inside a solid then
//   energy   kinetic and potential energy together rise by at most 1 % a second then
//   calls    none is refused
//
// Left out, as nothing bounds it: the sides of walls where a nozzle pours into one (the header asks for free space), of
// sand that lay in a wall when a lost plane or an older save came back, or that may have gone round a table's edge, and of
// bodies, which cannot obey two colliders that press them.
#include "tests/fuzz/app_world.h"

#include <algorithm>
#include <cstdlib>

namespace sandglass::fuzz {
namespace {

constexpr double k_moving = 10.0, k_soon = 5.0, k_late = 30.0;  // s: of the world; until 95 %, until all sleep
constexpr double k_gentle = 1.5;                                // m/s above what the world moves at
constexpr double k_band = 0.003;                                // m: what is held may lie so far from what was given
constexpr double k_drop = 1.5;                                  // m: nothing starts higher above what it lands on
constexpr double k_edge = 0.25;                                 // m, which nothing goes twice within a frame

// What may have made sand fast in one second: the fastest surface, what was pinched, and the box that sand was in.
struct Second {
  double fastest = 0, pinched = 0;
  Vec3 low = {1e9, 1e9, 1e9}, high = {-1e9, -1e9, -1e9};

  void reaches(Vec3 p) {
    low = {std::fmin(low.x, p.x), std::fmin(low.y, p.y), std::fmin(low.z, p.z)};
    high = {std::fmax(high.x, p.x), std::fmax(high.y, p.y), std::fmax(high.z, p.z)};
  }
};

struct Watch {
  World& w;
  Second seconds[5];
  uint64_t second = 0;
  double slowness = 1.0;
  std::vector<char> inside;  // by number: it was seen on the inner side of the walls

  double height(Vec3 p) const { return -dot(p, w.gravity) / length(w.gravity); }

  // After each frame. step: seconds that it was asked for.
  void check(double step) {
    w.read();
    if (step > 0) check_speed(step);
    check_walls();
  }

  // What is there now counts as a start: its speed and its height are nobody's fault.
  void begin() {
    w.read();
    Second& now = seconds[second % 5];
    for (size_t i = 0; i < w.positions.size(); ++i) {
      if (w.present[i] == 0) continue;
      now.reaches(w.positions[i]);
      now.fastest = std::fmax(now.fastest, length(w.velocities[i]));
    }
    inside.clear();
    w.begins_anew = false;
  }

  bool is_pinched(Vec3 p) const {
    const auto touches = [&](const Solid& s) { return s.distance(p) < w.r + k_band; };
    return std::count_if(w.solids.begin(), w.solids.end(), touches) > 1;
  }

  // Whether it touches a surface that is steeper than a friction of 0.16 holds it on, 9 degrees.
  bool is_on_slope(Vec3 p) const {
    const double step = 0.01 * w.r;
    for (const Solid& s : w.solids) {
      const double d = s.distance(p);
      const Vec3 n = {s.distance(p + Vec3{step, 0, 0}) - d, s.distance(p + Vec3{0, step, 0}) - d,
                      s.distance(p + Vec3{0, 0, step}) - d};
      if (d < w.r + k_band && -dot(n, w.gravity) < 0.988 * length(n) * length(w.gravity)) return true;
    }
    return false;
  }

  // How many slide on a slope, or creep in the edge of two walls or of a field, as friction with one slips while it
  // holds on to the other. They may do so for good; a body does as a whole.
  uint32_t sliding() const {
    uint32_t sand = 0, body = 0;
    for (size_t i = 0; i < w.positions.size(); ++i) {
      if (w.present[i] == 0 || length(w.velocities[i]) == 0 || !is_on_slope(w.positions[i])) continue;
      i < w.in_bodies ? body = w.in_bodies : ++sand;
    }
    return sand + body;
  }

  // Sand that a hand pressed into a body comes out of it slowly, and lifts it; both come to rest later.
  bool is_in_body() const {
    for (size_t i = w.in_bodies; i < w.positions.size(); ++i) {
      for (size_t b = 0; b < w.in_bodies; ++b) {
        if (w.present[i] != 0 && w.present[b] != 0 && length(w.positions[i] - w.positions[b]) < 1.5 * w.r) return true;
      }
    }
    return false;
  }

  // The header has what is deep in a collider leave it faster where a body is denser than sand, and pairs part faster.
  double gentle() const {
    const double unit = std::sqrt(2 * length(w.gravity) * w.r), density = w.body_mass;
    return k_gentle + unit * (0.225 * (density * density - 1) + 0.9 * (density - 1));
  }

  // Sand flies for a second at most, and a friction of 0.16 stops 5 m/s within four: what moves now has its speed from
  // what moved in the last four seconds and from a fall from where sand was then. What falls for ever is let go. A
  // collider that appears or jumps has no speed: the 1.5 m/s are for that, and for sand that comes apart. In slow motion
  // a collider goes its way in less time. Between two colliders sand escapes sideways, faster than they close: twice as fast
  // where they make an angle of 30 degrees.
  void check_speed(double step) {
    const double slow = std::fmin(step, k_longest) / std::fmax(w.step_done, 1e-4);
    slowness = std::fmax(1.0, slowness + 0.1 * (std::fmin(slow, 100.0) - slowness));
    while (second < static_cast<uint64_t>(w.simulated)) seconds[++second % 5] = {};
    Second& now = seconds[second % 5];
    now.fastest = std::fmax(now.fastest, w.fastest * (w.set.budget >= 128 ? 3 * slowness : 1.0));
    w.fastest = 0;
    for (const Vec3& place : w.nozzle_places) now.reaches(place);
    Second all;
    for (const Second& s : seconds) {
      all.fastest = std::fmax(all.fastest, s.fastest);
      all.pinched = std::fmax(all.pinched, s.pinched);
      if (s.low.x < 1e9) {
        all.reaches(s.low);
        all.reaches(s.high);
      }
    }
    const Vec3 g = w.gravity;
    const double top =
        height({g.x > 0 ? all.low.x : all.high.x, g.y > 0 ? all.low.y : all.high.y, g.z > 0 ? all.low.z : all.high.z});
    for (size_t i = 0; i < w.positions.size(); ++i) {
      if (w.present[i] == 0) continue;
      const double fall = std::sqrt(2 * length(g) * std::fmax(top + w.r - height(w.positions[i]), 0.0));
      const double speed = length(w.velocities[i]);
      if (is_pinched(w.positions[i])) now.pinched = std::fmax(now.pinched, std::fmin(speed, 2 * all.fastest));
      if (!(speed <= std::fmax(all.fastest, std::fmax(all.pinched, now.pinched)) + gentle() + fall))
        found("speed: particle %zu has %.2f m/s; the world %.2f m/s, free fall %.2f m/s", i, speed, all.fastest, fall);
      now.reaches(w.positions[i]);
    }
  }

  // Sand that was on the inner side may lag a correction and a lift behind by less than a wall, so what is a whole wall
  // and r further went through. Near a table's edge nothing is said; further in it would have to go out and in again
  // in one frame.
  void check_walls() {
    inside.resize(w.positions.size());
    if (!w.sides_known) std::fill(inside.begin(), inside.end(), 0);
    w.sides_known = true;
    if (!w.thin || w.solids.empty() || (w.set.nozzle & (in_ground | in_hand)) != 0) return;
    for (size_t i = w.in_bodies; i < w.positions.size(); ++i) {
      const double out = w.beyond(w.positions[i]);
      const Vec3 x = w.drawn.inverse()(w.positions[i]) - w.slide;
      const bool at_edge = std::fabs(x.x) > w.extent.x - k_edge || std::fabs(x.z) > w.extent.z - k_edge;
      if (!w.closed && at_edge) inside[i] = 0;
      if (out > w.thick + w.r && inside[i] != 0)
        found("walls: particle %zu is %.1f mm beyond a wall of %.1f mm, r = %.1f mm", i, 1e3 * out, 1e3 * w.thick,
              1e3 * w.r);
      if (out <= 0 && (w.closed || !at_edge)) inside[i] = 1;
    }
  }

  // What is held may lie k_band from what is given, and an overlap of r is more than a heap's weight makes.
  void check_depth() {
    for (size_t i = w.in_bodies; i < w.positions.size(); ++i) {
      for (const Solid& s : w.solids) {
        const double depth = -s.distance(w.positions[i]);
        if (depth > w.r + k_band && w.present[i] != 0)
          found("depth: particle %zu is %.1f mm inside a solid of shape %d, r = %.1f mm", i, 1e3 * depth, s.shape,
                1e3 * w.r);
      }
    }
  }

  void check_sleep(double seconds_still, uint32_t allowed) {
    uint32_t there = 0;
    for (const char is : w.present) there += is != 0;
    const uint32_t left = w.report.sand.particles - there,
                   awake = w.report.sand.awake > left ? w.report.sand.awake - left : 0;
    if (awake > allowed)
      found("sleep: %u of %u are awake %.0f s after the last has landed", awake, there, seconds_still);
  }

  // J/kg, summed over the particles; heights from `zero`.
  double energy(double zero) const {
    double sum = 0;
    for (size_t i = 0; i < w.positions.size(); ++i) {
      if (w.present[i] == 0) continue;
      const double speed2 = dot(w.velocities[i], w.velocities[i]), lift = height(w.positions[i]) - zero;
      sum += (i < w.in_bodies ? w.body_mass : 1) * (0.5 * speed2 + length(w.gravity) * lift);
    }
    return sum;
  }

  // Seconds until what flies has landed and what is inside a solid has left it: at an eighth of sqrt(g d) at least, half
  // of a quarter of the speed at which pairs come apart.
  double until_landed() const {
    double fastest = 0, deepest = 0;
    for (size_t i = 0; i < w.positions.size(); ++i) {
      if (w.present[i] == 0) continue;
      fastest = std::fmax(fastest, length(w.velocities[i]));
      for (const Solid& s : w.solids) deepest = std::fmax(deepest, -s.distance(w.positions[i]));
    }
    const double g = length(w.gravity);
    return (fastest + std::sqrt(fastest * fastest + 2 * g * k_drop)) / g + deepest / (0.125 * std::sqrt(2 * g * w.r));
  }

  void stand_still() {
    w.stop();
    w.stand();
    check(1 / w.rate);
    const bool exact = (w.set.list & (restless | far_hand)) == 0;  // else sleepers may wake yet
    // A held pose that is nearly its band away from a restless one may still be corrected.
    const bool corrected = (w.set.list & restless) != 0;
    const double landed = w.simulated + until_landed();
    double slept = landed;  // or when all did, before a correction woke them
    double next = landed + 2, before = -1, zero = 0;
    for (bool soon = false; w.simulated < landed + k_late;) {
      w.stand();
      check(1 / w.rate);
      if (corrected && w.report.sand.awake == 0) slept = w.simulated;
      const bool first = !soon && w.simulated > landed + k_soon;
      soon = soon || first;
      if (first) check_depth();
      if ((first || (corrected && soon)) && w.simulated > slept + k_soon && !is_in_body())
        check_sleep(k_soon, std::max({5u, w.report.sand.particles / 20, sliding()}));
      if (!corrected && w.simulated > next) {
        // The solver's own corrections move a particle by a hundredth of r in a second at most.
        const double after = energy(zero), slack = 0.01 * w.r * length(w.gravity) * w.report.sand.particles;
        if (before >= 0 && !is_in_body() && after > 1.01 * before + slack)
          found("energy: %.4g J/kg, a second later %.4g J/kg", before, after);
        zero = 1e9;
        for (size_t i = 0; i < w.positions.size(); ++i)
          if (w.present[i] != 0) zero = std::fmin(zero, height(w.positions[i]) - w.r);
        before = energy(zero);
        next = w.simulated + 1;
      }
      if (exact && soon && w.report.sand.awake == 0 && w.simulated > landed + k_soon + 2) return;
    }
    if (w.simulated > slept + k_soon) check_sleep(k_late, sliding());
  }
};

void run(World* w) {
  Watch watch = {*w, {}, 0, 1.0, {}};
  const double frames_max = 2 * k_moving * w->rate;  // in slow motion fewer seconds pass
  while (w->simulated < k_moving && w->frames < frames_max) {
    w->act();
    if (w->begins_anew) watch.begin();
    watch.check(w->move_on());
  }
  watch.stand_still();
  // Half a minute later the app finds itself elsewhere.
  w->move_scene(Pose{{1, 2, 3}} * Pose{{}, w->scene_pose.q});
}

}  // namespace
}  // namespace sandglass::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  sandglass::fuzz::World world(data, size);
  try {
    sandglass::fuzz::run(&world);
  } catch (const std::string& what) {
    std::printf("%s; frame %u of the world", what.c_str(), world.frames);
    for (size_t i = 0; i < size && i < sizeof world.set; ++i) std::printf(" %02x", data[i]);
    std::printf("\n");
    std::fflush(stdout);
    std::abort();
  }
  return 0;
}
