// Every frame counts for how grains move; where they are is measured at twelve instants while the sand flows, and at the
// end.
#include "tests/laboratory/sand/follow_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "models/files/failure.h"
#include "models/simulation/metrics.h"
#include "models/simulation/scene_meshes.h"
#include "models/simulation/simulation.h"
#include "tests/laboratory/sand/apparatus.h"
#include "tests/laboratory/sand/follow_measures.h"

namespace sandglass::host {

namespace {

enum class Pace { full, coarser, slow };  // all work, quality level 3, and slow motion at that level

SceneFile at_60_frames(double radius) {
  SceneFile scene;
  scene.frame_step = 1.0 / 60.0;
  scene.particle_radius = radius;
  scene.granular = cpp::scene_desc().granular;
  return scene;
}

// For two seconds a nozzle pours onto a floor.
SceneFile pour(double radius, double nozzle, double height) {
  constexpr uint32_t k_particles = 6000, k_grains_per_particle = 16;
  SceneFile scene = at_60_frames(radius);
  scene.granular.particle_capacity = k_particles;
  scene.granular.grain_capacity = k_particles * k_grains_per_particle;
  scene.emitters = {
      {cpp::emitter(0, static_cast<float>(height), 0, static_cast<float>(nozzle), 0.5f, k_grains_per_particle), 0.0,
       2.0}};
  scene.colliders.emplace_back();
  return scene;
}

// A block of 1,560 particles, rough enough to stay a heap after it has collapsed.
SceneFile heap(uint32_t grains = 27'000) {
  SceneFile scene = at_60_frames(0.01);
  scene.granular.static_friction = 0.6f;
  scene.granular.kinetic_friction = 0.55f;
  Body& block = scene.bodies.emplace_back();
  block.size = {0.2, 0.2, 0.2};
  block.grains = grains;
  scene.colliders.emplace_back();
  return scene;
}

// A ball or capsule goes along x.
SceneFile pushed(SceneFile scene, sandglass_shape shape, Vec3 size, Vec3 from, double speed, double start, double end) {
  ColliderTrack& hand = scene.colliders.emplace_back();
  hand.shape = shape;
  hand.size = size;
  hand.position = from;
  hand.motion = {{start, end, {speed, 0.0, 0.0}, {}}};
  return scene;
}

SceneFile stirred_heap() {
  return pushed(heap(), SANDGLASS_SHAPE_CAPSULE, {0.03, 0.08, 0}, {-0.5, 0.06, 0}, 0.5, 2.0, 4.0);
}

SceneFile tilted_heap() {
  SceneFile scene = heap();
  scene.colliders[0].motion = {{2.0, 3.0, {}, {0.0, 0.0, -0.35}}};  // to 20 degrees
  return scene;
}

SceneFile small_glass() {
  SceneFile scene = at_60_frames(0.0035);
  Body& sand = scene.bodies.emplace_back();
  sand.shape = BodyShape::revolved;
  sand.grains = 40'000;
  sand.profile = {{0, 0.012}, {0.0165, 0.012}, {0.05, 0.045}, {0.062, 0.075}, {0, 0.075}};
  sand.size.y = 0.075 - 0.012;
  ColliderTrack& glass = scene.colliders.emplace_back();
  glass.shape = SANDGLASS_SHAPE_FIELD;
  glass.solid_outside = true;
  glass.profile = {{0, -0.13},      {0.05, -0.13}, {0.065, -0.115}, {0.065, -0.06}, {0.0175, -0.007},
                   {0.0175, 0.007}, {0.065, 0.06}, {0.065, 0.115},  {0.05, 0.13},   {0, 0.13}};
  return scene;
}

SceneFile pour_10() { return pour(0.01, 0.04, 0.4); }
SceneFile fine_pour() { return pour(0.003, 0.012, 0.25); }
// It sleeps before the ball comes.
SceneFile woken_pour() {
  return pushed(fine_pour(), SANDGLASS_SHAPE_SPHERE, {0.02, 0, 0}, {-0.2, 0.018, 0}, 0.2, 5.0, 6.0);
}

struct FollowScene {
  const char *group, *name;
  SceneFile (*make)();
  double seconds, flow_from, flow_to;  // simulated
  uint32_t cost;                       // about how many tenths of a second it takes
  Pace pace = Pace::full;
  double variation = 0.0;  // at most, inside, over that of random points; 0: only reported
  bool source = false;     // grains follow the rule of the dissertation as printed
};

constexpr double k_fine_variation = 0.87;  // of 149,000 grains

const FollowScene k_scenes[] = {
    {"pour", "pour 10 mm", pour_10, 6.0, 0.5, 2.8, 6, Pace::full, 0.66},
    {"pour", "pour 3 mm", fine_pour, 6.0, 0.5, 2.8, 22, Pace::full, 0.66},
    {"pour", "pour 20 mm", [] { return pour(0.02, 0.08, 0.6); }, 6.0, 0.5, 2.8, 6, Pace::full, 0.66},
    {"pour", "thin stream", [] { return pour(0.01, 0.02, 0.4); }, 6.0, 0.5, 2.8, 2},
    {"glass", "small glass", small_glass, 5.0, 0.5, 4.5, 24},
    {"glass", "hourglass", [] { return load_scene("hourglass"); }, 8.0, 0.8, 7.5, 300},
    {"glass", "source, glass", small_glass, 5.0, 0.5, 4.5, 24, Pace::full, 0.0, true},
    {"heap", "heap", [] { return heap(); }, 1.5, 0.2, 0.75, 6, Pace::full, 0.62},
    {"heap", "fine heap", [] { return heap(149'000); }, 1.5, 0.2, 0.75, 20, Pace::full, k_fine_variation},
    {"heap", "level 3, heap", [] { return heap(); }, 1.5, 0.2, 0.75, 6, Pace::coarser},
    {"heap", "slow, heap", [] { return heap(); }, 1.5, 0.2, 0.75, 20, Pace::slow},
    {"heap", "source, fine heap", [] { return heap(149'000); }, 1.5, 0.2, 0.75, 40, Pace::full, 0.0, true},
    {"slope", "slope", [] { return load_scene("slope"); }, 4.0, 0.4, 3.8, 300},
    {"knot", "knot", [] { return load_scene("demo"); }, 3.6, 0.2, 3.4, 12},
    {"hand", "hand", stirred_heap, 5.0, 2.6, 3.6, 15},
    {"tilt", "tilt", tilted_heap, 5.0, 2.2, 3.8, 20},
    {"wake", "wake", woken_pour, 7.5, 5.4, 6.0, 25},
    {"level_3", "level 3, pour", fine_pour, 6.0, 0.5, 2.8, 20, Pace::coarser},
    {"level_3", "level 3, glass", small_glass, 5.0, 0.5, 4.5, 20, Pace::coarser},
    {"slow", "slow, pour", fine_pour, 6.0, 0.5, 2.8, 30, Pace::slow},
    {"slow", "slow, glass", small_glass, 5.0, 0.5, 4.5, 30, Pace::slow},
    {"source", "source, pour", pour_10, 6.0, 0.5, 2.8, 6, Pace::full, 0.0, true},
};

struct Followed {
  Placement flow, end;  // flow: the means of what is bare and in the wrong cell
  GrainMoves moves;
  Evenness even;
  uint32_t awake = 0;  // particles, before the hand comes
};

void turn(SceneFile* scene, uint64_t seed) {
  // The golden angle: no seed comes near the turn of another one soon.
  const double turns = static_cast<double>(seed) * (0.5 * (3.0 - std::sqrt(5.0)));
  const Quaternion by = rotation_by({0.0, 2.0 * std::numbers::pi * (turns - std::floor(turns)), 0.0});
  scene->seed += seed;
  for (Body& body : scene->bodies) body.rotation = multiply(by, body.rotation);
  for (EmitterTrack& track : scene->emitters)
    for (size_t k = 0; k < 4; ++k) track.emitter.rotation[k] = static_cast<float>(by[k]);
}

Followed follow(const FollowScene& what, sandglass_blend blend, uint64_t seed, sandglass_isa isa,
                const std::function<void(double)>& step) {
  constexpr int k_looks = 12;
  constexpr uint64_t k_short_budget = 3'000'000, k_unit = 20'000;  // ns; a third of the work units that are wanted
  constexpr double k_slowest = 20.0, k_lead = 0.4;  // times the scene's own time; seconds that a hand takes to the sand
  SceneFile scene = what.make();
  turn(&scene, seed);
  const LoadedMeshes meshes(scene);
  const Material material = fill_scene(&scene, meshes.bodies());
  const CollisionFields fields(&scene);
  sandglass_scene_desc desc = describe_scene(scene, material.particles(), material.grains());
  desc.isa = isa;
  desc.granular.reference.blend = blend;
  if (what.pace != Pace::full) desc.finest_level = SANDGLASS_LEVEL_COARSER;
  uint64_t now = 0;
  if (what.pace == Pace::slow) {
    desc.clock = {[](void* user) { return *static_cast<uint64_t*>(user); }, &now};
    desc.trace = {nullptr, [](void* user, const char*) { *static_cast<uint64_t*>(user) += k_unit; }, &now};
  }
  Simulation simulation(desc);
  simulation.add(material);
  Followed result;
  double time = 0.0;
  int looks = 0;
  uint32_t frames = 0;
  const auto look = [&] {
    return measure_placement(simulation.particle_positions(), simulation.grain_positions(), scene.particle_radius, 3);
  };
  for (; time < what.seconds - 0.5 * scene.frame_step && frames * scene.frame_step < k_slowest * what.seconds;
       ++frames) {
    simulation.flow(flow_over_frame(scene, time));
    const sandglass_frame_report report = simulation.frame(
        scene.frame_step, what.pace == Pace::slow ? k_short_budget : k_no_budget, colliders_over_frame(scene, frames));
    time = report.time.simulated;
    result.moves.frame(simulation.particle_positions(), simulation.grain_positions(), scene.particle_radius,
                       scene.frame_step);
    if (time < what.flow_from - k_lead) result.awake = report.sand.awake;
    if (looks < k_looks && time >= what.flow_from + looks * (what.flow_to - what.flow_from) / (k_looks - 1)) {
      const Placement here = look();
      result.flow.bare += here.bare / k_looks;
      result.flow.wrong += here.wrong / k_looks;
      ++looks;
    }
    step(std::min(time / what.seconds, 1.0));
  }
  if (looks < k_looks) throw cannot("measure", what.name, "its time stands nearly still", "Report this");
  result.end = look();
  result.even = measure_evenness(simulation.particle_positions(), simulation.grain_positions(), scene.particle_radius,
                                 static_cast<double>(desc.granular.grain_radius), 5);
  return result;
}

struct Judge {
  const FollowScene& scene;
  std::vector<Verdict>* rows;

  // A heap is there for how evenly its grains lie.
  bool settles() const { return std::string(scene.group) == "heap"; }
  void row(const char* what, const char* unit, double truth, double result, double limit, bool control = false) {
    const bool within = std::fabs(result - truth) <= limit;
    const std::string who = control && !scene.source ? "means, " : "";
    rows->push_back(
        {scene.group, who + scene.name + ": " + what, unit, truth, result, limit, within != control, control});
  }
  // Another rule: not where the particles are.
  void control(const Followed& f) {
    if (settles()) {
      row("variation inside", "of random", 0.0, f.even.variation, k_fine_variation, true);
      row("nearest grain", "grain radii", 2.0, f.even.nearest, k_near, true);
      return;
    }
    row("bare, flow", "%", 0.0, f.flow.bare, k_bare_flow, true);
    row("bare, end", "%", 0.0, f.end.bare, k_bare_end, true);
    if (scene.source) row("wrong cell, flow", "%", 0.0, f.flow.wrong, k_wrong, true);
  }
  void claims(const Followed& f) {
    const bool full = scene.pace == Pace::full, thin = std::string(scene.name) == "thin stream";
    const auto claim = [&](const char* what, const char* unit, double truth, double result, double limit) {
      row(what, unit, truth, result, full ? limit : k_reported);
    };
    claim("bare, flow", "%", 0.0, f.flow.bare, k_bare_flow);
    claim("bare, end", "%", 0.0, f.end.bare, k_bare_end);
    claim("beyond, end", "%", 0.0, f.end.beyond, thin ? 14.0 : 4.0);
    claim("half, end", "of R", 0.99, f.end.half, 0.06);  // 0.93 to 1.05
    claim("P95, end", "of R", 0.985, f.end.p95, 0.065);  // 0.92 to 1.05
    claim("wrong cell, flow", "%", 0.0, f.flow.wrong, thin ? 17.0 : k_wrong);
    claim("slow grain's way", "r", 0.0, f.moves.slow_displacement(), 1.0);
    if (f.even.variation > 0.0) {
      // At 2 they touch; without a push it is below 1.2.
      const bool even = scene.variation > 0.0, settled = settles();
      row("variation inside", "of random", 0.0, f.even.variation, even ? scene.variation : settled ? 1.0 : k_reported);
      row("nearest grain", "grain radii", 2.0, f.even.nearest, even ? k_near : settled ? 0.8 : k_reported);
    }
    if (std::string(scene.group) == "wake") claim("awake before", "particles", 0.0, f.awake, 0.0);
  }
  // What own particles mend of what means alone do.
  void compare(const Followed& f, const Followed& means) {
    constexpr double k_much = 8.0;  // %
    if (scene.pace != Pace::full) {
      row("bare, flow, of means'", "", 0.0, f.flow.bare / means.flow.bare, 0.5);
      row("bare, end, of means'", "", 0.0, f.end.bare / means.end.bare, 0.5);
      return;
    }
    row("wrong cell, flow, of means'", "", 0.0, f.flow.wrong / means.flow.wrong,
        means.flow.wrong > k_much ? 0.5 : 0.65);
    row("jumps, of means'", "", 0.0, f.moves.jumps_per_million() / means.moves.jumps_per_million(), 0.25);
    const std::string group = scene.group;
    if (group == "pour" || group == "glass") control(means);
  }

 private:
  static constexpr double k_reported = std::numeric_limits<double>::infinity();
  static constexpr double k_bare_flow = 3.0, k_bare_end = 2.0, k_wrong = 10.0;  // %
  static constexpr double k_near = 0.55;                                        // grain radii nearer than touching
};

struct Stopped {};

}  // namespace

std::vector<std::string> follow_groups() {
  std::vector<std::string> groups;
  for (const FollowScene& scene : k_scenes)
    if (groups.empty() || groups.back() != scene.group) groups.emplace_back(scene.group);
  return groups;
}

std::vector<Verdict> follow_verdicts(const std::vector<std::string>& groups, uint64_t seed, sandglass_isa isa,
                                     const std::function<bool(uint64_t, uint64_t)>& progress) {
  std::vector<Verdict> rows;
  uint64_t total = 0, before = 0;
  const auto chosen = [&](const FollowScene& scene) {
    return groups.empty() || std::find(groups.begin(), groups.end(), scene.group) != groups.end();
  };
  for (const FollowScene& scene : k_scenes) total += chosen(scene) ? scene.cost : 0;
  for (const FollowScene& scene : k_scenes) {
    if (!chosen(scene)) continue;
    const auto step = [&](double share) {
      if (!progress(before + static_cast<uint64_t>(share * scene.cost), total)) throw Stopped();
    };
    Judge judge = {scene, &rows};
    try {
      if (scene.source) {
        judge.control(follow(scene, SANDGLASS_BLEND_SOURCE, seed, isa, step));
      } else {
        const auto first = [&](double share) { step(0.5 * share); };
        const Followed own = follow(scene, SANDGLASS_BLEND_CONTINUOUS, seed, isa, first);
        judge.claims(own);
        const auto second = [&](double share) { step(0.5 + 0.5 * share); };
        if (!judge.settles()) judge.compare(own, follow(scene, SANDGLASS_BLEND_MEANS, seed, isa, second));
      }
    } catch (const Stopped&) {
      break;
    }
    before += scene.cost;
  }
  return rows;
}

}  // namespace sandglass::host
