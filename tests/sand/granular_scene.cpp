#include "tests/sand/granular_scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace {

uint32_t points_in(const std::vector<float>& coordinates) { return static_cast<uint32_t>(coordinates.size() / 3); }

sandglass_points as_points(const std::vector<float>& positions, const std::vector<float>& velocities) {
  return {positions.data(), velocities.empty() ? nullptr : velocities.data(), points_in(positions)};
}

}  // namespace

void accept(const sandglass::Status& status) {
  if (!status) throw std::runtime_error(status.reason);
}

void GranularScene::add(const std::vector<float>& particles, const std::vector<float>& velocities,
                        const std::vector<float>& fine, const std::vector<float>& fine_velocities) {
  const sandglass_points sand = as_points(particles, velocities), grain_points = as_points(fine, fine_velocities);
  sandglass::Status status;
  status.code = sandglass_scene_add(scene.get(), &sand, &grain_points, &status.reason);
  accept(status);
  particle_count += points_in(particles);
  grains.resize(grains.size() + points_in(fine));
}

uint32_t GranularScene::add_body(const std::vector<float>& points, float density, std::initializer_list<float> velocity,
                                 std::initializer_list<float> spin) {
  sandglass_body body = sandglass::body();
  body.particle_positions = points.data();
  body.particle_count = points_in(points);
  body.density_ratio = density;
  std::copy(velocity.begin(), velocity.end(), body.linear_velocity);
  std::copy(spin.begin(), spin.end(), body.angular_velocity);
  uint32_t index = ~0u;
  accept(scene.add_body(body, &index));
  particle_count += body.particle_count;
  return index;
}

void GranularScene::add_walls(std::array<float, 2> low, std::array<float, 2> high) {
  const float half = std::sqrt(0.5f);
  const struct {
    float x, z, around_x, around_z;
  } walls[] = {{low[0], 0, 0, -half}, {high[0], 0, 0, half}, {0, low[1], half, 0}, {0, high[1], -half, 0}};
  for (const auto& wall : walls) {
    colliders.push_back(sandglass::collider(SANDGLASS_SHAPE_HALF_SPACE, wall.x, 0.0f, wall.z));
    float* const turned = colliders.back().rotation;
    turned[0] = wall.around_x;
    turned[2] = wall.around_z;
    turned[3] = half;
  }
}

sandglass_frame_input GranularScene::input(float time_step, uint64_t budget_ns, const sandglass_plan* plan) {
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = time_step;
  input.budget_ns = budget_ns;
  input.colliders = colliders.data();
  input.collider_count = static_cast<uint32_t>(colliders.size());
  input.emitters = emitters.data();
  input.emitter_count = static_cast<uint32_t>(emitters.size());
  input.sinks = sinks.data();
  input.sink_count = static_cast<uint32_t>(sinks.size());
  input.grains = grains.empty() || !draws ? nullptr : grains.data();
  input.grain_capacity = draws ? static_cast<uint32_t>(grains.size()) : 0;
  input.plan = plan;
  return input;
}

sandglass_frame_report GranularScene::run(const sandglass_frame_input& input) {
  sandglass_frame_report report;
  accept(scene.frame(input, &report));
  particle_count = report.sand.particle_numbers;
  return report;
}

std::vector<float> GranularScene::positions() const {
  std::vector<float> values(3ull * particle_count);
  sandglass_scene_particles(scene.get(), values.data(), nullptr);
  return values;
}

std::vector<float> GranularScene::velocities() const {
  std::vector<float> values(3ull * particle_count);
  sandglass_scene_particles(scene.get(), nullptr, values.data());
  return values;
}

sandglass_frame_report until_asleep(GranularScene* scene, float time_step) {
  for (int frame = 0; frame < 500; ++frame) {
    const sandglass_frame_report report = scene->frame(time_step);
    if (report.sand.awake == 0) return report;
  }
  throw std::runtime_error("the sand does not fall asleep");
}

sandglass_scene_desc description(uint32_t particles, uint32_t grains, uint32_t boundary) {
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.granular.particle_capacity = particles;
  desc.granular.grain_capacity = grains;
  desc.granular.boundary_capacity = boundary;
  return desc;
}

sandglass_scene_desc with_bodies(uint32_t sand, uint32_t bodies, uint32_t in_bodies) {
  sandglass_scene_desc desc = description(sand + in_bodies);
  desc.granular.body_capacity = bodies;
  desc.granular.body_particle_capacity = in_bodies;
  desc.granular.sink_capacity = 1;
  return desc;
}

std::vector<float> lattice(uint32_t x, uint32_t y, uint32_t z, float spacing, float radius) {
  std::vector<float> points;
  for (uint32_t j = 0; j < y; ++j) {
    const float shift = j % 2 == 0 ? 0.0f : 0.25f * spacing;
    for (uint32_t k = 0; k < z; ++k) {
      for (uint32_t i = 0; i < x; ++i) {
        points.push_back(spacing * static_cast<float>(i) + shift);
        points.push_back(radius + spacing * static_cast<float>(j));
        points.push_back(spacing * static_cast<float>(k) + shift);
      }
    }
  }
  return points;
}

std::vector<float> loose_points(const sandglass::Box& box, const std::function<bool(const float*)>& room) {
  constexpr float k_step = 0.021f;
  std::vector<float> points;
  for (float y = box.min[1]; y <= box.max[1]; y += k_step)
    for (float z = box.min[2]; z <= box.max[2]; z += k_step)
      for (float x = box.min[0]; x <= box.max[0]; x += k_step) {
        const float p[3] = {x, y, z};
        if (room(p)) points.insert(points.end(), p, p + 3);
      }
  return points;
}

std::vector<float> grains_about(const std::vector<float>& particles, float offset) {
  std::vector<float> grains;
  for (size_t i = 0; i < particles.size(); i += 3)
    for (int corner = 0; corner < 8; ++corner)
      for (size_t k = 0; k < 3; ++k) grains.push_back(particles[i + k] + ((corner >> k & 1) != 0 ? offset : -offset));
  return grains;
}

std::vector<float> shifted(std::vector<float> points, float x, float y, float z) {
  for (size_t i = 0; i < points.size(); i += 3) {
    points[i] += x;
    points[i + 1] += y;
    points[i + 2] += z;
  }
  return points;
}

std::vector<float> copies(const std::vector<float>& particles, int count, float offset) {
  std::vector<float> points;
  for (int copy = 0; copy < count; ++copy)
    for (const float x : particles) points.push_back(x + offset * static_cast<float>(copy));
  return points;
}

GranularScene loose_sand(const sandglass::Box& box, const std::function<bool(const float*)>& room) {
  const std::vector<float> particles = loose_points(box, room), grains = grains_about(particles, 0.004f);
  GranularScene scene(description(points_in(particles), points_in(grains)));
  scene.add(particles, {}, grains);
  return scene;
}

double distance(const std::vector<float>& a, size_t i, const std::vector<float>& b, size_t j) {
  double sum = 0.0;
  for (size_t k = 0; k < 3; ++k)
    sum += std::pow(static_cast<double>(a[3 * i + k]) - static_cast<double>(b[3 * j + k]), 2);
  return std::sqrt(sum);
}
