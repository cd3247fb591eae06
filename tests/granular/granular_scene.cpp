#include "tests/granular/granular_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace {

void check(sandglass_status status, const char* const* reason) {
  if (status != SANDGLASS_OK) throw std::invalid_argument(*reason);
}

uint32_t points_in(const std::vector<float>& coordinates) { return static_cast<uint32_t>(coordinates.size() / 3); }

const float* data_or_null(const std::vector<float>& values) { return values.empty() ? nullptr : values.data(); }

}  // namespace

GranularScene::GranularScene(const sandglass_scene_desc& desc) {
  const char* reason = nullptr;
  uint64_t bytes = 0;
  check(sandglass_scene_bytes(&desc, &bytes, &reason), &reason);
  block = sandglass::cpp::allocate_block(bytes);
  check(sandglass_scene_create(&desc, block.get(), bytes, &scene, &reason), &reason);
}

void GranularScene::add(const std::vector<float>& particles, const std::vector<float>& velocities,
                        const std::vector<float>& fine, const std::vector<float>& fine_velocities) {
  const char* reason = nullptr;
  check(sandglass_granular_add(scene, particles.data(), data_or_null(velocities), points_in(particles), fine.data(),
                               data_or_null(fine_velocities), points_in(fine), &reason),
        &reason);
  particle_count += points_in(particles);
  grains.resize(grains.size() + points_in(fine));
}

uint32_t GranularScene::add_body(const std::vector<float>& points, float density, std::initializer_list<float> velocity,
                                 std::initializer_list<float> spin) {
  sandglass_body body;
  sandglass_body_default(&body);
  body.particle_positions = points.data();
  body.particle_count = points_in(points);
  body.density_ratio = density;
  std::copy(velocity.begin(), velocity.end(), body.linear_velocity);
  std::copy(spin.begin(), spin.end(), body.angular_velocity);
  uint32_t index = ~0u;
  const char* reason = nullptr;
  check(sandglass_granular_add_body(scene, &body, &index, &reason), &reason);
  particle_count += body.particle_count;
  return index;
}

void GranularScene::add_floor(float height) { colliders.push_back(half_space(height)); }

sandglass_frame_input GranularScene::input(float time_step, uint64_t budget_ns, const sandglass_plan* plan) {
  sandglass_frame_input input;
  sandglass_frame_input_default(&input);
  input.time_step = time_step;
  input.budget_ns = budget_ns;
  input.colliders = colliders.data();
  input.collider_count = static_cast<uint32_t>(colliders.size());
  input.grains = grains.empty() ? nullptr : grains.data();
  input.grain_capacity = static_cast<uint32_t>(grains.size());
  input.plan = plan;
  return input;
}

sandglass_frame_report GranularScene::run(const sandglass_frame_input& input) {
  sandglass_frame_report report;
  report.struct_size = sizeof report;
  const char* reason = nullptr;
  if (sandglass_scene_frame(scene, &input, &report, &reason) != SANDGLASS_OK) throw std::runtime_error(reason);
  return report;
}

std::vector<float> GranularScene::positions() const {
  std::vector<float> values(3ull * particle_count);
  sandglass_granular_particles(scene, values.data(), nullptr);
  return values;
}

std::vector<float> GranularScene::velocities() const {
  std::vector<float> values(3ull * particle_count);
  sandglass_granular_particles(scene, nullptr, values.data());
  return values;
}

std::vector<uint8_t> GranularScene::save() const {
  std::vector<uint8_t> bytes(sandglass_scene_save_bytes(scene));
  uint64_t written = 0;
  const char* reason = nullptr;
  check(sandglass_scene_save(scene, bytes.data(), bytes.size(), &written, &reason), &reason);
  bytes.resize(written);
  return bytes;
}

sandglass_status GranularScene::restore(const std::vector<uint8_t>& bytes, const char** reason) {
  return sandglass_scene_restore(scene, bytes.data(), bytes.size(), reason);
}

sandglass_scene_desc description(uint32_t particles, uint32_t grains, uint32_t boundary) {
  sandglass_scene_desc desc;
  sandglass_scene_desc_default(&desc);
  desc.granular.particle_capacity = particles;
  desc.granular.grain_capacity = grains;
  desc.granular.boundary_capacity = boundary;
  return desc;
}

sandglass_collider half_space(float height) {
  sandglass_collider floor = {};
  floor.shape = SANDGLASS_SHAPE_HALF_SPACE;
  floor.position[1] = height;
  floor.rotation[3] = 1.0f;
  return floor;
}

sandglass_collider sphere(float radius, float x, float y, float z) {
  sandglass_collider ball = {};
  ball.shape = SANDGLASS_SHAPE_SPHERE;
  ball.position[0] = x, ball.position[1] = y, ball.position[2] = z;
  ball.rotation[3] = 1.0f;
  ball.size[0] = radius;
  return ball;
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

std::vector<float> grains_about(const std::vector<float>& particles, float offset) {
  std::vector<float> grains;
  for (size_t i = 0; i < particles.size(); i += 3)
    for (int corner = 0; corner < 8; ++corner)
      for (size_t k = 0; k < 3; ++k) grains.push_back(particles[i + k] + ((corner >> k & 1) != 0 ? offset : -offset));
  return grains;
}

std::vector<float> copies(const std::vector<float>& particles, int count, float offset) {
  std::vector<float> points;
  for (int copy = 0; copy < count; ++copy)
    for (const float x : particles) points.push_back(x + offset * static_cast<float>(copy));
  return points;
}

double distance(const std::vector<float>& a, size_t i, const std::vector<float>& b, size_t j) {
  double sum = 0.0;
  for (size_t k = 0; k < 3; ++k)
    sum += std::pow(static_cast<double>(a[3 * i + k]) - static_cast<double>(b[3 * j + k]), 2);
  return std::sqrt(sum);
}

void expect_one_hash(std::initializer_list<uint32_t> unit_items,
                     const std::function<uint64_t(sandglass_isa isa, uint32_t unit_items)>& run) {
  uint64_t first = 0;
  for (sandglass_isa isa = SANDGLASS_ISA_SCALAR; isa <= SANDGLASS_ISA_AVX512; ++isa) {
    if (sandglass_isa_available(isa) == 0) continue;
    for (const uint32_t items : unit_items) {
      const uint64_t hash = run(isa, items);
      if (first == 0) first = hash;
      EXPECT_EQ(hash, first) << sandglass_isa_name(isa) << ", units of " << items;
    }
  }
}
