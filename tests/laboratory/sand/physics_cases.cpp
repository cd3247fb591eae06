// Single particles and piles with known results. Frames take 20 ms and have no budget, so every frame does all its
// work.
#include "tests/laboratory/sand/physics_cases.h"

#include <algorithm>
#include <cmath>

#include "models/simulation/metrics.h"
#include "models/simulation/scene_fill.h"
#include "models/simulation/simulation.h"
#include "tests/laboratory/sand/apparatus.h"

namespace sandglass::host {

namespace {

sandglass_collider plane_with_slope(double slope) {
  const double angle = std::atan(slope);  // downhill is towards +x
  sandglass_collider plane = cpp::floor_at(0.0f);
  plane.rotation[2] = static_cast<float>(-std::sin(0.5 * angle));
  plane.rotation[3] = static_cast<float>(std::cos(0.5 * angle));
  return plane;
}

}  // namespace

sandglass_scene_desc physics_desc(double mu) {
  sandglass_scene_desc desc = cpp::scene_desc();
  desc.granular.static_friction = desc.granular.kinetic_friction = static_cast<float>(mu);
  return desc;
}

double free_fall_error(const sandglass_scene_desc& desc) {
  Simulation simulation(with_room(desc, 1));
  const float start[3] = {0.0f, 0.0f, 0.0f}, velocity[3] = {0.5f, 0.0f, 0.0f};
  simulation.add(start, velocity);
  double x = 0.0, y = 0.0, fall_speed = 0.0, worst = 0.0;
  for (uint32_t frame = 0; frame < frames_in(1.0); ++frame) {
    const sandglass_frame_report report = simulation.frame(k_frame, k_no_budget, {});
    const double n = report.sand.substeps, dt = n > 0.0 ? static_cast<double>(static_cast<float>(k_frame)) / n : 0.0;
    x += 0.5 * n * dt;
    y -= n * dt * fall_speed + k_gravity * dt * dt * n * (n + 1.0) / 2.0;
    fall_speed += n * dt * k_gravity;
    const std::vector<float>& at = simulation.particle_positions();
    worst = std::max({worst, std::fabs(at[0] - x), std::fabs(at[1] - y)});
  }
  return worst / std::max(std::fabs(y), 1e-9);
}

double sliding_distance(const sandglass_scene_desc& desc, double* substep) {
  Simulation simulation(with_room(desc, 1));
  const float start[3] = {0.0f, desc.granular.particle_radius, 0.0f}, velocity[3] = {1.0f, 0.0f, 0.0f};
  simulation.add(start, velocity);
  const sandglass_collider floor = plane_with_slope(0.0);
  *substep = 0.0;
  for (uint32_t frame = 0; frame < frames_in(2.0); ++frame)
    *substep = std::max<double>(*substep, simulation.frame(k_frame, k_no_budget, {&floor, 1}).sand.substep);
  return simulation.particle_positions()[0];
}

double incline_distance(const sandglass_scene_desc& desc, double slope, double seconds) {
  Simulation simulation(with_room(desc, 1));
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

RestingPile resting_pile(const sandglass_scene_desc& desc) {
  SceneFile scene;
  scene.source = "resting pile";
  scene.particle_radius = desc.granular.particle_radius;
  scene.granular = desc.granular;
  Body column;
  column.shape = BodyShape::lattice;
  column.counts[0] = 10;
  column.counts[1] = 12;
  column.counts[2] = 10;
  column.jitter = 0.01;
  column.grains = 9600;
  column.grain_grid = true;
  column.position.y = 1.02 * scene.particle_radius;
  scene.bodies.push_back(column);
  scene.colliders.emplace_back();
  const Material material = fill_scene(&scene, {});
  Simulation simulation(with_room(desc, material.particles(), material.grains()));
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
  pile.overlap_mean = overlap.mean;
  pile.overlap_max = overlap.max;
  pile.speed = std::sqrt(energy / (k_gravity * 2.0 * r));
  pile.sinking = (top_before - measure_pile(particles, r).height) / (2.0 * r);
  pile.energy_ratio = energy_max > 0.0 ? energy / energy_max : 0.0;
  const double grain_radius = drawn_grain_radius(r, material.particles(), material.grains());
  const std::vector<float>& grains = simulation.grain_positions();
  for (size_t i = 1; i < grains.size(); i += 3) pile.grains_below += grains[i] < -grain_radius ? 1.0 : 0.0;
  return pile;
}

namespace {

// Touching particles on a cubic lattice, `count` on a side. The lowest corner is at the origin.
std::vector<float> block(int count, double radius) {
  std::vector<float> points;
  for (int k = 0; k < count * count * count; ++k)
    for (const int at : {k % count, k / count % count, k / count / count})
      points.push_back(static_cast<float>(2.0 * radius * at));
  return points;
}

sandglass_scene_desc weightless(sandglass_scene_desc desc, uint32_t particles, uint32_t grains) {
  for (float& g : desc.gravity) g = 0.0f;
  desc.granular.sleep_after = 0.0f;
  return with_room(desc, particles, grains);
}

}  // namespace

Cloud free_cloud(const sandglass_scene_desc& desc) {
  constexpr uint32_t k_side = 8, k_count = k_side * k_side * k_side;
  constexpr double k_spacing = 3.0, k_seconds = 0.4;  // spacing in radii; speeds up to 1 m/s along each axis
  const double r = desc.granular.particle_radius;
  Simulation simulation(weightless(desc, k_count, 0));
  Random random = {11};
  std::vector<float> positions, velocities;
  for (uint32_t i = 0; i < k_count; ++i)
    for (const uint32_t at : {i % k_side, i / k_side % k_side, i / k_side / k_side}) {
      positions.push_back(static_cast<float>((at + 0.2 * random.uniform()) * k_spacing * r));
      velocities.push_back(static_cast<float>(2.0 * random.uniform() - 1.0));
    }
  simulation.add(positions, velocities);
  uint64_t steps = 0;
  for (uint32_t frame = 0; frame < frames_in(k_seconds); ++frame)
    steps += simulation.frame(k_frame, k_no_budget, {}).sand.substeps;
  const std::vector<float>& after = simulation.particle_velocities();
  double change[3] = {}, size = 0.0;
  Cloud cloud;
  for (size_t i = 0; i < after.size(); i += 3) {
    double along = 0.0;
    for (size_t k = 0; k < 3; ++k) {
      const double before = velocities[i + k], now = after[i + k];
      change[k] += now - before;
      size += std::fabs(before);
      along += before * now;
    }
    cloud.collisions += along < 0.9 * (static_cast<double>(velocities[i]) * static_cast<double>(velocities[i]) +
                                       static_cast<double>(velocities[i + 1]) * static_cast<double>(velocities[i + 1]) +
                                       static_cast<double>(velocities[i + 2]) * static_cast<double>(velocities[i + 2]))
                            ? 1.0
                            : 0.0;
  }
  cloud.drift = std::sqrt(change[0] * change[0] + change[1] * change[1] + change[2] * change[2]) / size;
  cloud.drift_per_step = cloud.drift / static_cast<double>(std::max<uint64_t>(steps, 1));
  return cloud;
}

double uniform_field_error(const sandglass_scene_desc& desc, double shear) {
  constexpr int k_side = 10;
  constexpr uint32_t k_grains = 2000;
  constexpr double k_velocity[3] = {0.3, -0.2, 0.5}, k_speed = 0.61644140029689765;
  const double r = desc.granular.particle_radius, d = 2.0 * r;
  Simulation simulation(weightless(desc, k_side * k_side * k_side, k_grains));
  Material material;
  material.particle_positions = block(k_side, r * 1.01);  // apart, so that nothing but the field acts
  Random random = {5};
  for (uint32_t i = 0; i < k_grains; ++i)
    for (int k = 0; k < 3; ++k)
      material.grain_positions.push_back(static_cast<float>((2.0 + (k_side - 5.0) * random.uniform()) * d));
  const auto add_velocities = [&](const std::vector<float>& positions, std::vector<float>* velocities) {
    for (size_t i = 0; i < positions.size(); i += 3)
      for (const double u : k_velocity)
        velocities->push_back(
            static_cast<float>(u * (1.0 + shear * (static_cast<double>(positions[i + 1]) / (k_side * d) - 0.5))));
  };
  add_velocities(material.particle_positions, &material.particle_velocities);
  add_velocities(material.grain_positions, &material.grain_velocities);
  simulation.add(material);
  for (uint32_t frame = 0; frame < frames_in(0.5); ++frame) simulation.frame(k_frame, k_no_budget, {});
  double worst = 0.0;
  const std::vector<float>& now = simulation.grain_velocities();
  for (size_t i = 0; i < now.size(); i += 3) {
    double off = 0.0;
    for (size_t k = 0; k < 3; ++k)
      off += (now[i + k] - material.grain_velocities[i + k]) * (now[i + k] - material.grain_velocities[i + k]);
    worst = std::max(worst, std::sqrt(off) / k_speed);
  }
  return worst;
}

double threshold_jump(const sandglass_scene_desc& desc) {
  constexpr uint32_t k_grains = 1024;
  constexpr int k_side = 4;
  const double r = desc.granular.particle_radius, d = 2.0 * r;
  float low = static_cast<float>(-3.0 * d), high = static_cast<float>(1.5 * d);
  double jump = 0.0;
  while (std::nextafterf(low, high) < high) {
    std::vector<float> starts;
    for (uint32_t i = 0; i < k_grains; ++i) {
      const float x = static_cast<float>(low + (static_cast<double>(high) - low) * i / (k_grains - 1));
      if (starts.empty() || x > starts.back()) starts.push_back(x);
    }
    Simulation simulation(weightless(desc, k_side * k_side * k_side, k_grains));
    Material material;
    material.particle_positions = block(k_side, r * 1.01);
    for (size_t i = 0; i < material.particle_positions.size(); i += 3)
      material.particle_velocities.insert(material.particle_velocities.end(), {0.0f, 1.0f, 0.0f});
    for (const float x : starts)
      material.grain_positions.insert(material.grain_positions.end(),
                                      {x, static_cast<float>(2.3 * r), static_cast<float>(1.9 * r)});
    material.grain_velocities.resize(material.grain_positions.size());
    simulation.add(material);
    simulation.frame(desc.granular.refine_step, k_no_budget, {});
    const std::vector<float>& end = simulation.grain_positions();
    size_t worst = 0;
    double largest = -1.0;
    for (size_t i = 0; i + 1 < starts.size(); ++i) {
      const double change = std::fabs(static_cast<double>(end[3 * i + 4]) - static_cast<double>(end[3 * i + 1]));
      if (change > largest) {
        largest = change;
        worst = i;
      }
    }
    jump = largest / d;
    if (worst + 1 >= starts.size()) break;
    low = starts[worst];
    high = starts[worst + 1];
  }
  return jump;
}

PushOnALine push_on_a_line(const sandglass_scene_desc& desc) {
  // Neighbours on the line have the same last four bits of their numbers, by which grains come back to lone particles,
  // but where one stretch of the line ends.
  constexpr uint32_t k_grains = 16384, k_kinds = 16, k_stretch = k_grains / k_kinds;
  constexpr int k_side = 4, k_frames = 2;  // the first one does not push
  const double r = desc.granular.particle_radius, d = 2.0 * r;
  Simulation simulation(weightless(desc, k_side * k_side * k_side, k_grains));
  Material material;
  material.particle_positions = block(k_side, r * 1.01);
  for (uint32_t i = 0; i < k_grains; ++i)
    material.grain_positions.insert(
        material.grain_positions.end(),
        {static_cast<float>((-3.0 + 10.0 * (i % k_kinds * k_stretch + i / k_kinds) / k_grains) * d),
         static_cast<float>(2.3 * r), static_cast<float>(1.9 * r)});
  simulation.add(material);
  for (int frame = 0; frame < k_frames; ++frame) simulation.frame(desc.granular.refine_step, k_no_budget, {});
  const std::vector<float>& end = simulation.grain_positions();
  PushOnALine push;
  double before = 0.0;
  for (uint32_t place = 0; place < k_grains; ++place) {
    const size_t y = 3 * size_t{place % k_stretch * k_kinds + place / k_stretch} + 1;
    const double here = (static_cast<double>(end[y]) - static_cast<double>(material.grain_positions[y])) / d;
    push.max = std::max(push.max, std::fabs(here));
    if (place % k_stretch != 0) push.change = std::max(push.change, std::fabs(here - before));
    before = here;
  }
  return push;
}

namespace {

constexpr int k_layers = 6, k_side = 8;

// A bed of 8 x 6 x 8 particles that stands on y = 0. Each layer is shifted by a quarter of the spacing.
std::vector<float> bed(double radius) {
  std::vector<float> points;
  const double spacing = 2.02 * radius;
  for (int k = 0; k < k_layers; ++k)
    for (int j = 0; j < k_side; ++j)
      for (int i = 0; i < k_side; ++i)
        for (const double value :
             {(i + 0.25 * (k % 2)) * spacing, k * spacing + 1.02 * radius, (j + 0.25 * (k % 2)) * spacing})
          points.push_back(static_cast<float>(value));
  return points;
}

// Returns `result`, or 1e30 if one of the positions or velocities is not finite. Then no claim about them holds.
double sound(const std::vector<float>& values, double result) {
  for (const float value : values)
    if (!std::isfinite(value)) return 1e30;
  return result;
}

}  // namespace

Coincident coincident(const sandglass_scene_desc& desc, uint32_t count) {
  constexpr double k_height = 0.3;  // metres
  Simulation simulation(with_room(desc, count));
  std::vector<float> points;
  for (uint32_t i = 0; i < count; ++i) points.insert(points.end(), {0.0f, static_cast<float>(k_height), 0.0f});
  simulation.add(points, {});
  const sandglass_collider floor = cpp::floor_at(0.0f);
  Coincident result;
  for (int frame = 0; frame < 100; ++frame) {
    simulation.frame(k_frame, k_no_budget, {&floor, 1});
    const double top = highest_of(simulation.particle_positions());
    result.rise_d = std::max(result.rise_d, (top - k_height) / (2.0 * desc.granular.particle_radius));
  }
  const double overlap = measure_overlap(simulation.particle_positions(), desc.granular.particle_radius).max;
  result.overlap = sound(simulation.particle_positions(), overlap);
  return result;
}

Stack stack(const sandglass_scene_desc& desc, uint32_t count, double seconds) {
  Simulation simulation(with_room(desc, count));
  const double r = desc.granular.particle_radius;
  std::vector<float> points;
  for (uint32_t i = 0; i < count; ++i) points.insert(points.end(), {0.0f, static_cast<float>(r * (2 * i + 1)), 0.0f});
  simulation.add(points, {});
  const sandglass_collider floor = cpp::floor_at(0.0f);
  Stack result;
  for (int frame = 0; frame < static_cast<int>(seconds / k_frame); ++frame) {
    simulation.frame(k_frame, k_no_budget, {&floor, 1});
    result.height = (highest_of(simulation.particle_positions()) + r) / (2.0 * r * count);
    result.highest = std::max(result.highest, result.height);
  }
  result.height = sound(simulation.particle_positions(), result.height);
  return result;
}

double projectile_depth(const sandglass_scene_desc& desc) {
  const double r = desc.granular.particle_radius;
  Simulation simulation(with_room(desc, 385));
  simulation.add(bed(r), {});
  const float from[3] = {static_cast<float>(8.0 * r), 1.0f, static_cast<float>(8.0 * r)};
  const float velocity[3] = {0.0f, -40.0f, 0.0f};
  simulation.add(from, velocity);
  const sandglass_collider floor = cpp::floor_at(0.0f);
  double depth = 0.0;
  for (int frame = 0; frame < 50; ++frame) {
    simulation.frame(k_frame, k_no_budget, {&floor, 1});
    const std::vector<float>& p = simulation.particle_positions();
    for (size_t i = 1; i < p.size(); i += 3) depth = std::max(depth, (r - static_cast<double>(p[i])) / r);
  }
  return sound(simulation.particle_positions(), depth);
}

double weighting_speed(sandglass_scene_desc desc, double k) {
  desc.granular.height_weighting = static_cast<float>(k);
  Simulation simulation(with_room(desc, 384));
  simulation.add(bed(desc.granular.particle_radius), {});
  const sandglass_collider floor = cpp::floor_at(0.0f);
  double late = 0.0;
  for (int frame = 0; frame < 100; ++frame) {
    const sandglass_frame_report report = simulation.frame(k_frame, k_no_budget, {&floor, 1});
    if (frame >= 80 && report.sand.substeps > 0) late = std::max<double>(late, report.sand.speed_max);
  }
  return sound(simulation.particle_positions(), late);
}

double simulated_time(const sandglass_scene_desc& desc, std::span<const double> time_steps) {
  Simulation simulation(with_room(desc, 384));
  simulation.add(bed(desc.granular.particle_radius), {});
  const sandglass_collider floor = cpp::floor_at(0.0f);
  double time = 0.0;
  for (const double step : time_steps) time = simulation.frame(step, k_no_budget, {&floor, 1}).time.simulated;
  return sound(simulation.particle_positions(), time);
}

}  // namespace sandglass::host
