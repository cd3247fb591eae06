// The library makes a skin in frames of a scene; so the particles become a scene, which is paused.
#include "models/drawing/sand_shape.h"

#include <algorithm>
#include <cmath>

#include "models/files/failure.h"
#include "models/simulation/simulation.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

bool behind_glass(std::span<const sandglass_collider> colliders) {
  return std::any_of(colliders.begin(), colliders.end(), [](const sandglass_collider& collider) {
    float low[3], high[3];
    return collider.shape == SANDGLASS_SHAPE_FIELD && collider.field != nullptr &&
           sandglass_field_bounds(collider.field, low, high) == SANDGLASS_SOLID_OUTSIDE;
  });
}

SandShape shape_of(const sandglass_skin* skin, float particle_radius) {
  SandShape shape;
  shape.particle_radius = particle_radius;
  sandglass_skin_mesh mesh = {};
  mesh.struct_size = sizeof mesh;
  if (skin != nullptr) sandglass_skin_get_mesh(skin, &mesh);
  for (uint32_t i = 0; i < mesh.chunk_count; ++i) {
    const sandglass_skin_chunk& chunk = mesh.chunks[i];
    const auto first = static_cast<uint32_t>(shape.vertices.size());
    shape.vertices.insert(shape.vertices.end(), chunk.vertices, chunk.vertices + chunk.vertex_count);
    for (uint32_t k = 0; k < chunk.index_count; ++k) shape.indices.push_back(first + chunk.indices[k]);
  }
  shape.loose.assign(mesh.loose, mesh.loose + mesh.flying_count + mesh.lying_count);
  shape.flying = mesh.flying_count;
  return shape;
}

struct SandShaper::State {
  cpp::Skin skin;
  sandglass_skin_desc made = {};
};
SandShaper::SandShaper() : state_(std::make_unique<State>()) {}
SandShaper::~SandShaper() = default;

SandShape SandShaper::shape(const LyingSand& sand, sandglass_pile_shadow* pile) {
  std::vector<float> positions, velocities;
  for (size_t i = 0; i + 2 < sand.positions.size(); i += 3) {
    if (!std::isfinite(sand.positions[i] + sand.positions[i + 1] + sand.positions[i + 2])) continue;
    positions.insert(positions.end(), &sand.positions[i], &sand.positions[i] + 3);
    for (size_t k = 0; k < 3; ++k) velocities.push_back(sand.velocities.empty() ? 0.0f : sand.velocities[i + k]);
  }
  const auto count = static_cast<uint32_t>(positions.size() / 3);
  sandglass_scene_desc desc = cpp::scene_desc();
  desc.granular.particle_capacity = std::max(1u, count);
  desc.granular.particle_radius = sand.particle_radius;
  desc.granular.collider_capacity = std::max(1u, static_cast<uint32_t>(sand.colliders.size()));
  std::copy_n(sand.gravity, 3, desc.gravity);
  Simulation paused(desc);
  if (count > 0) paused.add(positions, velocities);

  auto& [skin, made] = *state_;
  sandglass_skin_desc wanted = cpp::skin_desc(desc.granular);
  wanted.capped = behind_glass(sand.colliders) ? 1 : 0;
  const bool larger =
      wanted.particle_capacity > made.particle_capacity || wanted.collider_capacity > made.collider_capacity;
  if (!skin || larger || wanted.capped != made.capped || wanted.particle_radius != made.particle_radius) {
    if (const cpp::Status status = skin.create(wanted); !status) throw cannot("make", "skin", status.reason);
    made = wanted;
  }
  sandglass_frame_input input;
  sandglass_frame_input_default(&input);
  input.time_step = 0;
  input.budget_ns = UINT64_MAX;
  input.colliders = sand.colliders.data();
  input.collider_count = static_cast<uint32_t>(sand.colliders.size());
  input.skin = skin.get();
  input.pile_shadow = pile;
  // The shadow is of the skin that was there when the frame began.
  for (int i = 0; i < 2; ++i) paused.frame(input);
  return shape_of(skin.get(), sand.particle_radius);
}

}  // namespace sandglass::host
