// Frames of 20 ms without a budget: every frame runs all its work.
#include "models/host/physics_cases.h"

#include <algorithm>
#include <cmath>

#include "models/host/metrics.h"
#include "models/host/scene_fill.h"
#include "models/host/simulation.h"

namespace sandglass::host {

namespace {

constexpr double k_frame = 0.02;              // seconds
constexpr uint64_t k_no_budget = UINT64_MAX;  // nanoseconds
constexpr double k_gravity = 9.81;            // m/s^2, of the default description

sandglass_collider plane_with_slope(double slope) {
  const double angle = std::atan(slope);  // downhill is towards +x
  sandglass_collider plane = {};
  plane.shape = SANDGLASS_SHAPE_HALF_SPACE;
  plane.rotation[2] = static_cast<float>(-std::sin(0.5 * angle));
  plane.rotation[3] = static_cast<float>(std::cos(0.5 * angle));
  return plane;
}

Simulation one_particle_scene(sandglass_scene_desc desc) {
  desc.granular.particle_capacity = 1;
  desc.granular.grain_capacity = 0;
  desc.granular.collider_capacity = 1;
  return Simulation(desc);
}

uint32_t frames_in(double seconds) { return static_cast<uint32_t>(std::lround(seconds / k_frame)); }

}  // namespace

sandglass_scene_desc physics_desc(double mu) {
  sandglass_scene_desc desc;
  sandglass_scene_desc_default(&desc);
  desc.granular.static_friction = desc.granular.kinetic_friction = static_cast<float>(mu);
  return desc;
}

double free_fall_error(const sandglass_scene_desc& desc) {
  Simulation simulation = one_particle_scene(desc);
  const float start[3] = {0.0f, 0.0f, 0.0f}, velocity[3] = {0.5f, 0.0f, 0.0f};
  simulation.add(start, velocity);
  double x = 0.0, y = 0.0, fall_speed = 0.0, worst = 0.0;
  for (uint32_t frame = 0; frame < frames_in(1.0); ++frame) {
    const sandglass_frame_report report = simulation.frame(k_frame, k_no_budget, {});
    const double n = report.substeps, dt = n > 0.0 ? static_cast<double>(static_cast<float>(k_frame)) / n : 0.0;
    x += 0.5 * n * dt;
    y -= n * dt * fall_speed + k_gravity * dt * dt * n * (n + 1.0) / 2.0;
    fall_speed += n * dt * k_gravity;
    const std::vector<float>& at = simulation.particle_positions();
    worst = std::max({worst, std::fabs(at[0] - x), std::fabs(at[1] - y)});
  }
  return worst / std::max(std::fabs(y), 1e-9);
}

double sliding_distance(const sandglass_scene_desc& desc, double* substep) {
  Simulation simulation = one_particle_scene(desc);
  const float start[3] = {0.0f, desc.granular.particle_radius, 0.0f}, velocity[3] = {1.0f, 0.0f, 0.0f};
  simulation.add(start, velocity);
  const sandglass_collider floor = plane_with_slope(0.0);
  *substep = 0.0;
  for (uint32_t frame = 0; frame < frames_in(2.0); ++frame)
    *substep = std::max<double>(*substep, simulation.frame(k_frame, k_no_budget, {&floor, 1}).substep);
  return simulation.particle_positions()[0];
}

double incline_distance(const sandglass_scene_desc& desc, double slope, double seconds) {
  Simulation simulation = one_particle_scene(desc);
  const double angle = std::atan(slope), r = desc.granular.particle_radius;
  const float start[3] = {static_cast<float>(r * std::sin(angle)), static_cast<float>(r * std::cos(angle)), 0.0f};
  const float rest[3] = {0.0f, 0.0f, 0.0f};
  simulation.add(start, rest);
  const sandglass_collider plane = plane_with_slope(slope);
  for (uint32_t frame = 0; frame < frames_in(seconds); ++frame) simulation.frame(k_frame, k_no_budget, {&plane, 1});
  const std::vector<float>& at = simulation.particle_positions();
  return (at[0] - start[0]) * std::cos(angle) - (at[1] - start[1]) * std::sin(angle);
}

double incline_truth(const sandglass_scene_desc& desc, double slope, double seconds) {
  const double angle = std::atan(slope);
  return 0.5 * k_gravity * (std::sin(angle) - desc.granular.kinetic_friction * std::cos(angle)) * seconds * seconds;
}

double stack_height(const sandglass_scene_desc& desc) {
  constexpr uint32_t k_count = 20;
  sandglass_scene_desc stack = desc;
  stack.granular.particle_capacity = k_count;
  stack.granular.grain_capacity = 0;
  stack.granular.collider_capacity = 1;
  Simulation simulation(stack);
  const float r = desc.granular.particle_radius;
  std::vector<float> positions, velocities(3 * k_count, 0.0f);
  for (uint32_t i = 0; i < k_count; ++i)
    positions.insert(positions.end(), {0.0f, r * static_cast<float>(2 * i + 1), 0.0f});
  simulation.add(positions, velocities);
  const sandglass_collider floor = plane_with_slope(0.0);
  for (uint32_t frame = 0; frame < frames_in(2.0); ++frame) simulation.frame(k_frame, k_no_budget, {&floor, 1});
  double top = 0.0;
  const std::vector<float>& end = simulation.particle_positions();
  for (uint32_t i = 0; i < k_count; ++i) top = std::max<double>(top, end[3 * i + 1] + r);
  return top / (2.0 * r * k_count);
}

RestingPile resting_pile(const sandglass_scene_desc& desc) {
  SceneFile scene;
  scene.source = "resting pile";
  scene.particle_radius = desc.granular.particle_radius;
  scene.granular = desc.granular;
  Body column;
  column.shape = BodyShape::lattice;
  column.counts[0] = 10, column.counts[1] = 12, column.counts[2] = 10;
  column.jitter = 0.01;
  column.grains = 9600;
  column.grain_grid = true;
  column.position.y = 1.02 * scene.particle_radius;
  scene.bodies.push_back(column);
  scene.colliders.emplace_back();
  const Material material = fill_scene(&scene, {});
  sandglass_scene_desc full = desc;
  full.granular.particle_capacity = material.particles();
  full.granular.grain_capacity = material.grains();
  full.granular.collider_capacity = 1;
  Simulation simulation(full);
  simulation.add(material);

  const double r = scene.particle_radius;
  const sandglass_collider floor = plane_with_slope(0.0);
  RestingPile pile = {};
  double energy = 0.0, energy_max = 0.0, top_before = 0.0;
  const uint32_t frames = frames_in(5.0);
  for (uint32_t frame = 1; frame <= frames; ++frame) {
    simulation.frame(k_frame, k_no_budget, {&floor, 1});
    const double speed = speed_rms(simulation.particle_velocities());
    energy = speed * speed;
    energy_max = std::max(energy_max, energy);
    if (frame == frames - frames_in(1.0)) top_before = measure_pile(simulation.particle_positions(), r).height;
  }
  const std::vector<float>& particles = simulation.particle_positions();
  const Overlap overlap = measure_overlap(particles, r);
  const Pile shape = measure_pile(particles, r);
  pile.overlap_mean = overlap.mean;
  pile.overlap_max = overlap.max;
  pile.speed = std::sqrt(energy / (k_gravity * 2.0 * r));
  pile.sinking = (top_before - shape.height) / (2.0 * r);
  pile.energy_ratio = energy_max > 0.0 ? energy / energy_max : 0.0;
  pile.angle_deg = shape.angle_deg;
  const double grain_radius = drawn_grain_radius(r, material.particles(), material.grains());
  pile.lowest_grain = 1e30;
  const std::vector<float>& grains = simulation.grain_positions();
  for (size_t i = 1; i < grains.size(); i += 3) {
    pile.grains_below += grains[i] < -grain_radius ? 1.0 : 0.0;
    pile.lowest_grain = std::min(pile.lowest_grain, grains[i] / grain_radius);
  }
  return pile;
}

namespace {

// Whether a result that is no number counts as within the limit: never.
bool within(double result, double truth, double limit) { return std::fabs(result - truth) <= limit; }

}  // namespace

std::vector<Verdict> granular_verdicts(sandglass_isa isa, const std::function<bool(uint32_t, uint32_t)>& done) {
  constexpr double k_mu = 0.6, k_wrong_mu = 0.1, k_slide_seconds = 2.0;
  std::vector<Verdict> table;
  const auto claim = [&](const char* name, const char* unit, double truth, double result, double limit) {
    table.push_back({name, unit, truth, result, limit, within(result, truth, limit), false});
  };
  const auto control = [&](const char* name, const char* unit, double truth, double result, double limit) {
    table.push_back({name, unit, truth, result, limit, !within(result, truth, limit), true});
  };
  const auto desc_with = [&](double mu) {
    sandglass_scene_desc desc = physics_desc(mu);
    desc.isa = isa;
    return desc;
  };
  const sandglass_scene_desc desc = desc_with(k_mu), slippery = desc_with(k_wrong_mu);
  const double d = 2.0 * desc.granular.particle_radius;
  // One long step a frame and one averaged iteration: the solver that DESIGN warns of.
  sandglass_scene_desc coarse = desc;
  coarse.granular.scheme = SANDGLASS_SCHEME_AVERAGED;
  coarse.granular.relaxation = 2.0f;
  coarse.granular.solver_iterations = 1;
  coarse.granular.stabilisation_iterations = 0;
  coarse.granular.substep_max = coarse.granular.substep_min = 0.02f;

  const double slide_truth = 1.0 / (2.0 * k_mu * k_gravity);
  double substep = 0.0;
  const std::function<void()> scenes[] = {
      [&] { claim("free_fall", "relative", 0.0, free_fall_error(desc), 1e-5); },
      [&] {
        const double x = sliding_distance(desc, &substep);
        claim("sliding_block", "m", slide_truth, x, 1.05 * 1.0 * substep / 2.0);
      },
      [&] {
        const double x = sliding_distance(slippery, &substep);
        control("sliding_block mu=0.1", "m", slide_truth, x, 1.05 * 1.0 * substep / 2.0);
      },
      [&] { claim("incline 0.99 mu rests", "d", 0.0, incline_distance(desc, 0.99 * k_mu, 5.0) / d, 0.01); },
      [&] { control("incline 0.99 mu, mu=0.1", "d", 0.0, incline_distance(slippery, 0.99 * k_mu, 1.0) / d, 0.01); },
      [&] {
        for (const double factor : {1.05, 1.5}) {
          const double truth = incline_truth(desc, factor * k_mu, k_slide_seconds);
          const double x = incline_distance(desc, factor * k_mu, k_slide_seconds);
          claim(factor < 1.2 ? "incline 1.05 mu slides" : "incline 1.5 mu slides", "m", truth, x, 0.01 * truth);
        }
      },
      [&] { claim("stack of 20", "height", 0.99, stack_height(desc), 0.01); },
      [&] { control("stack of 20, coarse", "height", 0.99, stack_height(coarse), 0.01); },
      [&] {
        const RestingPile pile = resting_pile(desc);
        claim("overlap at rest, mean", "r", 0.0, pile.overlap_mean, 0.01);
        claim("overlap at rest, max", "r", 0.0, pile.overlap_max, 0.10);
        claim("speed at rest", "sqrt(g d)", 0.0, pile.speed, 0.005);
        claim("sinking at rest", "d/s", 0.0, pile.sinking, 0.01);
        claim("kinetic energy left", "of max", 0.0, pile.energy_ratio, 0.001);
        claim("grains under the floor", "grains", 0.0, pile.grains_below, 0.0);
      },
      [&] {
        const RestingPile pile = resting_pile(coarse);
        control("overlap at rest, coarse", "r", 0.0, pile.overlap_mean, 0.01);
      },
  };
  uint32_t count = 0;
  for (const std::function<void()>& scene : scenes) {
    scene();
    if (!done(++count, static_cast<uint32_t>(std::size(scenes)))) break;
  }
  return table;
}

}  // namespace sandglass::host
