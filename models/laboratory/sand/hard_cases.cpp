// Hard cases for the solver. Beds are small, because each case tests an event, not bulk behaviour.
#include "models/laboratory/sand/hard_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "models/files/failure.h"
#include "models/geometry/vec3.h"
#include "models/laboratory/sand/apparatus.h"
#include "models/simulation/metrics.h"
#include "models/simulation/simulation.h"
#include "runtime/granular/rotation.h"

namespace sandglass::host {

namespace {

sandglass_scene_desc with_room(sandglass_scene_desc desc, uint32_t particles) {
  desc.granular.particle_capacity = particles;
  desc.granular.grain_capacity = 0;
  desc.granular.collider_capacity = 8;
  return desc;
}

constexpr int k_layers = 6;

// A bed of `side` x 6 x `side` particles that stands on y = 0. Each layer is shifted by a quarter of the spacing.
std::vector<float> bed(double radius, int side = 8) {
  std::vector<float> points;
  const double spacing = 2.02 * radius;
  for (int k = 0; k < k_layers; ++k)
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i)
        for (const double value :
             {(i + 0.25 * (k % 2)) * spacing, k * spacing + 1.02 * radius, (j + 0.25 * (k % 2)) * spacing})
          points.push_back(static_cast<float>(value));
  return points;
}

double highest_of(const std::vector<float>& positions) {
  double top = -1e30;
  for (size_t i = 1; i < positions.size(); i += 3) top = std::max<double>(top, positions[i]);
  return top;
}

// Returns `result`, or 1e30 if one of the positions or velocities is not finite. Then no claim about them holds.
double sound(const std::vector<float>& values, double result) {
  for (const float value : values)
    if (!std::isfinite(value)) return 1e30;
  return result;
}

void add_body(Simulation* simulation, const std::vector<float>& points, double density) {
  Material material;
  material.rigid.push_back({points, density, {}, {}});
  simulation->add(material);
}

}  // namespace

Coincident coincident(const sandglass_scene_desc& desc, uint32_t count) {
  constexpr double k_height = 0.3;  // metres
  Simulation simulation(with_room(desc, count));
  std::vector<float> points;
  for (uint32_t i = 0; i < count; ++i) points.insert(points.end(), {0.0f, static_cast<float>(k_height), 0.0f});
  simulation.add(points, {});
  const sandglass_collider floor = level_floor();
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
  const sandglass_collider floor = level_floor();
  Stack result;
  for (int frame = 0; frame < static_cast<int>(seconds / k_frame); ++frame) {
    simulation.frame(k_frame, k_no_budget, {&floor, 1});
    result.height = (highest_of(simulation.particle_positions()) + r) / (2.0 * r * count);
    result.highest = std::max(result.highest, result.height);
  }
  result.height = sound(simulation.particle_positions(), result.height);
  return result;
}

HeavyCube heavy_cube(const sandglass_scene_desc& desc, double ratio) {
  constexpr int k_side = 14, k_cube = 3, k_sand = k_side * k_side * k_layers, k_body = k_cube * k_cube * k_cube;
  const double r = desc.granular.particle_radius, spacing = 2.01 * r;
  sandglass_scene_desc room = with_room(desc, k_sand + k_body);
  room.granular.body_capacity = 1;
  room.granular.body_particle_capacity = k_body;
  Simulation simulation(room);
  simulation.add(bed(r, k_side), {});
  std::vector<float> cube;
  for (int i = 0; i < k_body; ++i)
    for (const double value : {11.0 * r + i % k_cube * spacing, 15.0 * r + i / (k_cube * k_cube) * spacing,
                               11.0 * r + i / k_cube % k_cube * spacing})
      cube.push_back(static_cast<float>(value));
  add_body(&simulation, cube, ratio);
  const sandglass_collider floor = level_floor();
  HeavyCube result;
  for (int frame = 0; frame < 150; ++frame) {
    simulation.frame(k_frame, k_no_budget, {&floor, 1});
    result.highest_d = std::max(result.highest_d, highest_of(simulation.particle_positions()) / (2.0 * r));
  }
  // The body's own particles start 2.01 r apart and never touch.
  result.overlap_max = sound(simulation.particle_positions(), measure_overlap(simulation.particle_positions(), r).max);
  return result;
}

double projectile_depth(const sandglass_scene_desc& desc) {
  const double r = desc.granular.particle_radius;
  Simulation simulation(with_room(desc, 385));
  simulation.add(bed(r), {});
  const float from[3] = {static_cast<float>(8.0 * r), 1.0f, static_cast<float>(8.0 * r)};
  const float velocity[3] = {0.0f, -40.0f, 0.0f};
  simulation.add(from, velocity);
  const sandglass_collider floor = level_floor();
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
  sandglass_collider colliders[2] = {level_floor(), {}};
  for (int frame = 0; frame < 20; ++frame) simulation.frame(k_frame, k_no_budget, {colliders, 1});
  colliders[1].shape = SANDGLASS_SHAPE_BOX;
  colliders[1].rotation[3] = 1.0f;
  for (int k = 0; k < 3; ++k) {
    colliders[1].position[k] = static_cast<float>((k == 1 ? 5.0 : 8.0) * r);
    colliders[1].size[k] = static_cast<float>(4.0 * r);
  }
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
  const sandglass_collider floor = level_floor();
  double late = 0.0;
  for (int frame = 0; frame < 100; ++frame) {
    const sandglass_frame_report report = simulation.frame(k_frame, k_no_budget, {&floor, 1});
    if (frame >= 80 && report.substeps > 0) late = std::max<double>(late, report.speed_max);
  }
  return sound(simulation.particle_positions(), late);
}

Refusals refusals(const sandglass_scene_desc& desc) {
  constexpr float k_nan = std::numeric_limits<float>::quiet_NaN(), k_infinity = std::numeric_limits<float>::infinity();
  Refusals result;
  Simulation simulation(with_room(desc, 384));
  const std::vector<float> points = bed(desc.granular.particle_radius);
  simulation.add({points.data(), points.size() - 3}, {});
  const auto attempt = [&](sandglass_status expected, const float* position, const float* velocity, uint32_t count) {
    const char* reason = nullptr;
    const sandglass_status status =
        sandglass_granular_add(simulation.handle(), position, velocity, count, nullptr, nullptr, 0, &reason);
    ++result.attempts;
    result.refused += status == expected && (reason == nullptr) == (status == SANDGLASS_OK) ? 1 : 0;
  };
  const float fine[3] = {0.0f, 1.0f, 0.0f};
  for (const float bad : {k_nan, k_infinity, 1.01f * SANDGLASS_COORDINATE_LIMIT}) {
    const float position[3] = {0.0f, bad, 0.0f};
    attempt(SANDGLASS_ERROR_INVALID_ARGUMENT, position, nullptr, 1);
  }
  const float velocity[3] = {k_nan, 0.0f, 0.0f};
  attempt(SANDGLASS_ERROR_INVALID_ARGUMENT, fine, velocity, 1);
  const float two[6] = {0.0f, 1.0f, 0.0f, 0.0f, 1.1f, 0.0f};
  attempt(SANDGLASS_ERROR_CAPACITY, two, nullptr, 2);
  attempt(SANDGLASS_OK, fine, nullptr, 1);  // the last free place can be used
  attempt(SANDGLASS_ERROR_CAPACITY, fine, nullptr, 1);

  std::vector<sandglass_collider> colliders(5, level_floor());
  colliders[1].position[1] = k_nan;
  colliders[2].rotation[3] = 0.0f;
  colliders[3].shape = SANDGLASS_SHAPE_SPHERE, colliders[3].size[0] = -1.0f;
  colliders[4].shape = 77;
  result.attempts += 4;
  result.refused += static_cast<int>(simulation.frame(k_frame, k_no_budget, colliders).ignored_colliders);
  if (sound(simulation.particle_positions(), 0.0) > 0.0) result.refused = -1;
  return result;
}

double simulated_time(const sandglass_scene_desc& desc, std::span<const double> time_steps) {
  Simulation simulation(with_room(desc, 384));
  simulation.add(bed(desc.granular.particle_radius), {});
  const sandglass_collider floor = level_floor();
  double time = 0.0;
  for (const double step : time_steps) time = simulation.frame(step, k_no_budget, {&floor, 1}).simulated_time;
  return sound(simulation.particle_positions(), time);
}

double degenerate_body_softness(const sandglass_scene_desc& desc) {
  const double r = desc.granular.particle_radius, s = 2.0 * r;
  std::vector<std::vector<Vec3>> shapes = {{{}}, {{}, {s, 0, 0}}, {{}, {s, 0, 0}, {2 * s, 0, 0}, {3 * s, 0, 0}}, {}};
  for (int i = 0; i < 9; ++i) shapes.back().push_back({i % 3 * s, 0.0, i / 3 * s});
  double softest = 0.0;
  for (const std::vector<Vec3>& shape : shapes) {
    sandglass_scene_desc room = with_room(desc, 64);
    room.granular.body_capacity = 1;
    room.granular.body_particle_capacity = 64;
    Simulation simulation(room);
    std::vector<float> points;
    const Quaternion tilt = rotation_by({0.3, 0.2, 0.9});
    for (const Vec3& at : shape) {
      const Vec3 p = rotate(tilt, at) + Vec3{0.0, 0.3, 0.0};
      for (const double value : {p.x, p.y, p.z}) points.push_back(static_cast<float>(value));
    }
    add_body(&simulation, points, 1.0);
    const sandglass_collider floor = level_floor();
    for (int frame = 0; frame < 100; ++frame) {
      simulation.frame(k_frame, k_no_budget, {&floor, 1});
      const std::vector<float>& p = simulation.particle_positions();
      for (size_t i = 0; i < shape.size(); ++i)
        for (size_t j = i + 1; j < shape.size(); ++j) {
          const double now = std::hypot(static_cast<double>(p[3 * i]) - static_cast<double>(p[3 * j]),
                                        static_cast<double>(p[3 * i + 1]) - static_cast<double>(p[3 * j + 1]),
                                        static_cast<double>(p[3 * i + 2]) - static_cast<double>(p[3 * j + 2]));
          softest = std::max(softest, std::fabs(now - length(shape[i] - shape[j])) / r);
        }
      softest = sound(p, softest);
    }
  }
  return softest;
}

double rotation_gap(double scale) {
  const double factors[][3] = {{3, 2, 1}, {3, 2, -1}, {1, 1, 1},       {1, 1e-3, 1e-6}, {1, 1, 0},       {2, 1, -0.5},
                               {1, 0, 0}, {0, 0, 0},  {1, 1e-9, 1e-9}, {5, 5, -5},      {3, 1e-4, -1e-5}};
  Random random = {7};
  double worst = 0.0;
  for (const auto& factor : factors)
    for (int trial = 0; trial < 50; ++trial) {
      // A = Q U diag(factor) U^T. The best rotation is Q, and its trace is the sum of the factors. Only the smallest
      // factor may be negative.
      const auto any = [&] {
        return rotation_by(Vec3{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5} * 6.0);
      };
      const Quaternion q = trial == 0 ? Quaternion{0.0, 1.0, 0.0, 0.0} : any(), u = any();
      double a[9] = {};
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 unit = {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0};
        const Vec3 right = rotate(u, unit), left = rotate(q, right);
        const double l[3] = {left.x, left.y, left.z}, m[3] = {right.x, right.y, right.z};
        for (int i = 0; i < 9; ++i) a[i] += scale * factor[axis] * l[i / 3] * m[i % 3];
      }
      const double start[4] = {0.0, 0.0, 0.0, 1.0};
      double found[4];
      nearest_rotation(a, start, found);
      const Quaternion r = {found[0], found[1], found[2], found[3]};
      double trace = 0.0;
      for (int column = 0; column < 3; ++column) {
        const Vec3 v = rotate(r, {column == 0 ? 1.0 : 0.0, column == 1 ? 1.0 : 0.0, column == 2 ? 1.0 : 0.0});
        trace += v.x * a[column] + v.y * a[3 + column] + v.z * a[6 + column];
      }
      const double best = factor[0] + factor[1] + factor[2];
      const double size = std::fabs(factor[0]) + std::fabs(factor[1]) + std::fabs(factor[2]);
      const double gap = size > 0.0 ? (best - trace / scale) / size : 0.0;
      const double norm = found[0] * found[0] + found[1] * found[1] + found[2] * found[2] + found[3] * found[3];
      if (!std::isfinite(gap)) return 1e30;
      worst = std::max({worst, std::fabs(gap), std::fabs(norm - 1.0)});
    }
  return worst;
}

}  // namespace sandglass::host
