#include "tests/granular/granular_scene.h"

#include <cstdlib>
#include <stdexcept>

void GranularScene::Free::operator()(void* memory) const { std::free(memory); }

GranularScene::GranularScene(const sandglass_scene_desc& desc) {
  const char* reason = nullptr;
  if (sandglass_scene_bytes(&desc, &bytes, &reason) != SANDGLASS_OK) throw std::invalid_argument(reason);
  block.reset(std::aligned_alloc(SANDGLASS_BLOCK_ALIGNMENT, bytes));
  if (sandglass_scene_create(&desc, block.get(), bytes, &scene, &reason) != SANDGLASS_OK)
    throw std::invalid_argument(reason);
}

void GranularScene::add(const std::vector<float>& particles, const std::vector<float>& velocities,
                        const std::vector<float>& fine) {
  const char* reason = nullptr;
  const uint32_t count = static_cast<uint32_t>(particles.size() / 3),
                 fine_count = static_cast<uint32_t>(fine.size() / 3);
  if (sandglass_granular_add(scene, particles.data(), velocities.empty() ? nullptr : velocities.data(), count,
                             fine.data(), nullptr, fine_count, &reason) != SANDGLASS_OK) {
    throw std::invalid_argument(reason);
  }
  particle_count += count;
  grains.resize(grains.size() + fine_count);
}

void GranularScene::add_floor(float height) { colliders.push_back(half_space(height)); }

sandglass_frame_report GranularScene::frame(float time_step, uint64_t budget_ns, const sandglass_plan* plan) {
  sandglass_frame_input input;
  sandglass_frame_input_default(&input);
  input.time_step = time_step;
  input.budget_ns = budget_ns;
  input.colliders = colliders.data();
  input.collider_count = static_cast<uint32_t>(colliders.size());
  input.grains = grains.empty() ? nullptr : grains.data();
  input.grain_capacity = static_cast<uint32_t>(grains.size());
  input.plan = plan;
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
