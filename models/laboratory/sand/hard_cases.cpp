// Hard cases for the solver. Beds are small, because each case tests an event, not bulk behaviour.
#include "models/laboratory/sand/hard_cases.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "models/laboratory/sand/apparatus.h"
#include "models/simulation/metrics.h"
#include "models/simulation/simulation.h"

namespace sandglass::host {

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

double teleport_speed(const sandglass_scene_desc& desc) {
  const double r = desc.granular.particle_radius;
  Simulation simulation(with_room(desc, 384));
  simulation.add(bed(r), {});
  const float middle = static_cast<float>(8.0 * r), side = static_cast<float>(4.0 * r);
  const sandglass_collider colliders[2] = {cpp::floor_at(0.0f),
                                           cpp::box(middle, static_cast<float>(5.0 * r), middle, side, side, side)};
  for (int frame = 0; frame < 20; ++frame) simulation.frame(k_frame, k_no_budget, {colliders, 1});
  double fastest = 0.0;
  for (int frame = 0; frame < 50; ++frame) {
    const sandglass_frame_report report = simulation.frame(k_frame, k_no_budget, colliders);
    const double limit = desc.granular.courant * r / std::max<double>(report.substep, 1e-9);
    fastest = std::max(fastest, report.speed_max / limit);
  }
  return sound(simulation.particle_positions(), fastest);
}

double weighting_speed(sandglass_scene_desc desc, double k) {
  desc.granular.height_weighting = static_cast<float>(k);
  Simulation simulation(with_room(desc, 384));
  simulation.add(bed(desc.granular.particle_radius), {});
  const sandglass_collider floor = cpp::floor_at(0.0f);
  double late = 0.0;
  for (int frame = 0; frame < 100; ++frame) {
    const sandglass_frame_report report = simulation.frame(k_frame, k_no_budget, {&floor, 1});
    if (frame >= 80 && report.substeps > 0) late = std::max<double>(late, report.speed_max);
  }
  return sound(simulation.particle_positions(), late);
}

double simulated_time(const sandglass_scene_desc& desc, std::span<const double> time_steps) {
  Simulation simulation(with_room(desc, 384));
  simulation.add(bed(desc.granular.particle_radius), {});
  const sandglass_collider floor = cpp::floor_at(0.0f);
  double time = 0.0;
  for (const double step : time_steps) time = simulation.frame(step, k_no_budget, {&floor, 1}).simulated_time;
  return sound(simulation.particle_positions(), time);
}

}  // namespace sandglass::host
