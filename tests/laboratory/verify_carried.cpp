// `sandglass_lab verify carried`: what holds sand is moved while the budget is short: whether the sand stays in it,
// still flows, and is thrown by nothing. A frame costs the instructions of its work units on a phone's core
// (models/phones), so results are the same everywhere.
//
// One list of scenes (sand/carried_scenes.cpp), and one function that runs any of them in any way: at a share of the
// time that its frames need, by velocities or poses alone, at any rate, with a frame that is late or a pose that jumps.
// The rest says what must hold.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "models/phones/phone.h"
#include "models/simulation/metrics.h"
#include "models/simulation/simulation.h"
#include "tests/laboratory/sand/carried_scenes.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

constexpr double k_reported = std::numeric_limits<double>::infinity(), k_pi = std::numbers::pi;
constexpr double k_settle = 1.0, k_moving = 2.67;    // seconds
constexpr double k_rates[] = {60, 30, 72, 90, 120};  // Hz
constexpr uint32_t k_waits = 3;                      // frames

enum class Given { velocities, poses };

struct Setup {
  double share = 0.0, need = 0.0;  // its budget is that much of the need; 0: unlimited
  double rate = 60.0;              // Hz
  Given by = Given::velocities;
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
  Setup setup;
  Vessel vessel, standing;
  PhoneClock clock{phone_core("cortex-a78")};
  Simulation scene;
  std::vector<sandglass_collider> colliders;
  Seen seen;
  size_t carried = 0;  // floats of the sand that is, before that of the glass which stands
  uint32_t waiting = 0;

  static constexpr Pose k_beside = {{-0.4, k_stand, 0}, k_pi};
  Carried(const CarriedScene& s, const Setup& w, sandglass_isa isa)
      : what(s),
        setup(w),
        vessel(s.make(s.radius)),
        standing(&s == &k_two_jars ? open_glass(s.radius) : Vessel()),
        scene([&] {
          const size_t sand = vessel.sand.size() + standing.sand.size();
          sandglass_scene_desc desc = with_room(cpp::scene_desc(), static_cast<uint32_t>(sand / 3),
                                                static_cast<uint32_t>(setup.grains ? 8 * sand / 3 : 0));
          desc.isa = isa;
          desc.clock = clock.clock();
          desc.finest_level = setup.finest;
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
    for (size_t i = 0; setup.grains && i < 8 * sand.size(); ++i) {
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
    if (!setup.jumps) return what.pose(t);
    const Pose stands = what.pose(-1.0);
    return t > 0.15 ? Pose{stands.at + setup.jump.at, stands.angle + setup.jump.angle} : stands;
  }
  // Where the vessel is held, by its first part.
  Pose held(const Pose& given) const {
    sandglass_collider c = {};
    if (setup.by == Given::velocities || sandglass_scene_held_collider(scene.handle(), 1, &c) == 0) return given;
    const double turned = 2.0 * std::atan2(static_cast<double>(c.rotation[2]), static_cast<double>(c.rotation[3]));
    Pose pose = {{}, given.angle + std::remainder(turned - given.angle, 2.0 * k_pi)};
    pose.at = from_floats(c.position) - rotate(pose.turn(), from_floats(vessel.parts[0].position));
    return pose;
  }

  sandglass_frame_report frame(double from, double to, uint64_t budget) {
    const Pose a = pose(from - setup.lag), later = pose(to - setup.lag), b = pose(to);
    const double step = (setup.clamped ? std::min(to - from, 1.0 / 30) : to - from) * setup.squeezed;
    const double per = setup.by == Given::velocities ? 1.0 / step : 0.0;
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
  void look(const Pose& given) {
    seen.at_end = beyond(given);
    waiting = seen.at_end != 0 && setup.by == Given::poses ? waiting + 1 : 0;
    const Pose shown = waiting != 0 && waiting <= k_waits ? held(given) : given;
    if (waiting != 0) seen.at_end = beyond(shown);
    seen.outside = std::max(seen.outside, seen.at_end);
    const std::vector<float>&p = scene.particle_positions(), &v = scene.particle_velocities();
    Vec3 sum;
    for (size_t i = 0; i < carried; i += 3) {
      sum = sum + (vessel.pushes ? from_floats(&p[i]) : given.local(from_floats(&p[i])));
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
  bool half_through(const Pose& given) {
    const std::vector<float>& p = scene.particle_positions();
    const double neck = standing.sand.empty() ? given.at.y : k_stand;
    const size_t first = standing.sand.empty() ? 0 : carried;
    size_t below = 0;
    for (size_t i = first; i < p.size(); i += 3) below += p[i + 1] < neck;
    return 2 * below > (p.size() - first) / 3;
  }

  Seen run() {
    const double step = 1.0 / setup.rate;
    double t = setup.flows ? -step : -k_settle, start = 0.0;
    for (; t < -0.5 * step; t += step) start = frame(t - step, t, k_no_budget).time.simulated;
    const uint64_t budget = setup.share > 0.0 ? static_cast<uint64_t>(setup.share * setup.need) : k_no_budget;
    const double carrying = 20e3 + 100.0 * seen.sand;  // ns, of the mandatory part, beside one unit
    std::vector<double> times;
    double from = t, ahead = step * static_cast<double>(setup.seed % 21) / 21.0;
    for (int f = 0; t < (setup.flows ? 100.0 : k_moving); ++f) {
      if (f == 10) ahead += setup.late;
      t += step;
      const sandglass_frame_report report = frame(from, t + ahead, setup.unlimited ? k_no_budget : budget);
      from = t + ahead;
      times.push_back(static_cast<double>(report.time.elapsed_ns));
      const sandglass_time_report& took = report.time;
      const double allowed = std::max(static_cast<double>(budget) + static_cast<double>(took.last_unit_ns),
                                      carrying + static_cast<double>(took.longest_unit_ns));
      seen.over = std::max(seen.over, 1e-3 * (times.back() - allowed));
      seen.simulated = report.time.simulated - start;
      look(pose(from));
      if (setup.flows && half_through(pose(from))) break;
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

  Seen run(const CarriedScene& scene, Setup setup) {
    if (!progress(done++, total)) throw Stopped();
    setup.seed += choice.seed;
    return Carried(scene, setup, choice.isa).run();
  }
  void row(const std::string& name, const char* unit, double truth, double result, double limit, bool control = false) {
    const bool within = std::fabs(result - truth) <= limit;
    rows.push_back({group, name, unit, truth, result, limit, within != control, control});
  }

  static std::string name_of(const CarriedScene& scene, Given given) {
    return std::string(scene.name) + (given == Given::poses ? ", poses" : "");
  }
  uint32_t grains_outside(const CarriedScene& scene, Given given) {
    Seen seen = run(scene, {.by = given, .grains = true});
    uint32_t outside = seen.grains;
    for (const double share : k_shares) {
      if (choice.quick && share != 1.0 / 4 && share != 1.0 / 16) continue;
      outside = std::max(outside, run(scene, {.share = share, .need = seen.need, .by = given, .grains = true}).grains);
    }
    return outside;
  }
  // Every budget and rate, folded into one row a claim.
  void budgets(const CarriedScene& scene, Given given) {
    const std::string who = name_of(scene, given);
    uint32_t outside = 0;
    double lost = 0.0, faster = 0.0, flows = 1.0, place = 0.0, over = -k_reported;
    for (const double rate : k_rates) {
      if (choice.quick && rate != 60.0) continue;
      const Seen full = run(scene, {.rate = rate, .by = given});
      if (scene.judged != k_spills) outside = std::max(outside, full.outside);
      for (size_t i = 0; i < std::size(k_shares); ++i) {
        if (choice.quick && k_shares[i] != 1.0 / 4 && k_shares[i] != 1.0 / 16) continue;
        const Seen s = run(scene, {.share = k_shares[i], .need = full.need, .rate = rate, .by = given});
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
    if (scene.grained) row(who + ": grains outside", "grains", 0.0, grains_outside(scene, given), 0.0);
  }

  // One frame takes longer, and tells it or not: then that is a jump.
  void hitches(const CarriedScene& scene, Given given) {
    for (const bool clamped : {false, true}) {
      uint32_t outside = 0, lost = 0;
      for (const double late : {0.117, 0.25, 0.5, 1.0, 2.0}) {
        const Seen s = run(scene, {.by = given, .late = late, .clamped = clamped});
        outside = std::max(outside, s.outside);
        lost = std::max(lost, s.at_end);
      }
      const std::string who = name_of(scene, given) + (clamped ? ", hitch that no step tells" : ", hitch");
      if (!clamped) row(who + ": outside", "particles", 0.0, outside, 0.0);
      row(who + ": lost", "particles", 0.0, lost, 0.0);
    }
  }
  void jumps(const CarriedScene& scene) {
    const std::pair<const char*, Pose> all[] = {
        {"5 cm", {{0.05, 0, 0}}}, {"30 cm", {{0.3, 0, 0}}}, {"30 degrees", {{}, k_pi / 6}}};
    for (const auto& [what, jump] : all) {
      if (jump.angle != 0.0 && scene.judged == k_rests) continue;  // a bucket spills
      const Seen s = run(scene, {.by = Given::poses, .jump = jump, .jumps = true});
      row(std::string(scene.name) + ", jump of " + what + ": outside", "particles", 0.0, s.outside, 0.0);
    }
  }
  // The mean of many starts: of one alone it varies by 3 %. Slow motion has the sub-steps of the level before it.
  Seen half_through(const CarriedScene& scene, Setup setup) {
    constexpr uint64_t k_starts = 21;
    Seen mean;
    setup.flows = true;
    for (setup.seed = 0; setup.seed < k_starts; ++setup.seed) {
      const Seen s = run(scene, setup);
      mean.simulated += s.simulated / k_starts;
      mean.outside = std::max(mean.outside, s.outside);
    }
    return mean;
  }
  void flow() {
    const auto compare = [&](const CarriedScene& scene, const CarriedScene& alone, Given given,
                             std::initializer_list<int> parts) {
      const double truth = half_through(alone, {.finest = SANDGLASS_LEVEL_COARSER}).simulated;
      const double need = run(scene, {.by = given, .flows = true}).need;
      for (const int part : parts) {
        const Seen s = half_through(scene, {.share = 1.0 / part, .need = need, .by = given});
        const std::string who = std::string(scene.name) + " at 1/" + std::to_string(part);
        row(who + ": half through", "s", truth, s.simulated, 0.02 * truth);
        row(who + ": outside", "particles", 0.0, s.outside, 0.0);
      }
    };
    compare(k_rising, k_rising, Given::velocities, {2, 4, 8, 16});
    compare(k_two_jars, k_alone, Given::poses, {16});
  }
  void controls() {
    const CarriedScene &glass = carried_scenes()[0], &bucket = carried_scenes()[3];
    const Seen all = run(glass, {.share = 1.0 / 16, .need = run(glass, {}).need, .unlimited = true});
    row("every unit runs: over its budget", "us", 0.0, std::max(all.over, 0.0), 0.0, true);
    const Seen still = run(glass, {.by = Given::poses, .squeezed = 0.0});
    row("no time passes: simulated, of before", "", 1.0, still.simulated / glass.before[0], 0.15, true);
    row("velocities that lag: outside", "particles", 0.0, run(bucket, {.lag = 0.1}).outside, 0.0, true);
    // What is done without a carry: the way of a frame in a sixteenth of its time.
    row("no carry: outside", "particles", 0.0, run(bucket, {.squeezed = 1.0 / 16}).outside, 0.0, true);
  }
};

std::vector<std::string> carried_groups() {
  std::vector<std::string> groups;
  for (const CarriedScene& scene : carried_scenes()) groups.emplace_back(scene.name);
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
  const auto among = [](const std::vector<std::string>& all, const std::string& name) {
    return std::find(all.begin(), all.end(), name) != all.end();
  };
  const auto runs = [&](const std::string& group) {
    judge.group = group;
    return among(quick, group) && (choice.groups.empty() || among(choice.groups, group));
  };
  judge.total = choice.quick ? 42 : carried_scenes().size() * 2 * std::size(k_rates) * (1 + std::size(k_shares)) + 269;
  try {
    for (const CarriedScene& scene : carried_scenes()) {
      if (!runs(scene.name)) continue;
      for (const Given given : {Given::velocities, Given::poses}) {
        judge.budgets(scene, given);
        if (scene.hitches && (!choice.quick || scene.judged == k_rests)) judge.hitches(scene, given);
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
