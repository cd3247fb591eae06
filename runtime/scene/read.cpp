// Reading the state: positions and velocities of particles and grains and poses of bodies by number, and what a ray
// hits.
#include "runtime/scene/scene.h"

namespace sandglass {
namespace {

uint32_t number_in(const Particle& particle) { return number_of(particle); }
uint32_t number_in(const Grain& grain) { return grain.number; }

// Particles or grains in the order of their numbers; removed ones are known by their place.
template <class Item>
void copy_items(const Item* items, uint32_t count, const uint32_t* removed, uint32_t removed_count, float* positions,
                float* velocities) {
  for (uint32_t i = 0; i < count; ++i) {
    const uint64_t to = 3ull * number_in(items[i]);
    for (int k = 0; k < 3; ++k) {
      if (positions != nullptr) positions[to + k] = items[i].position[k];
      if (velocities != nullptr) velocities[to + k] = items[i].velocity[k];
    }
  }
  for (uint32_t i = 0; i < removed_count; ++i) {
    const uint64_t to = 3ull * removed[i];
    for (int k = 0; k < 3; ++k) {
      if (positions != nullptr) positions[to + k] = k == 1 ? SANDGLASS_REMOVED_Y : 0.0f;
      if (velocities != nullptr) velocities[to + k] = 0.0f;
    }
  }
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

void sandglass_scene_particles(const sandglass_scene* scene, float* positions, float* velocities) {
  if (scene == nullptr) return;
  const Granular& g = scene->granular;
  copy_items(g.particles.records[0], g.particles.count, g.flow.free_particles, g.flow.free_particle_count, positions,
             velocities);
}

void sandglass_scene_grains(const sandglass_scene* scene, float* positions, float* velocities) {
  if (scene == nullptr) return;
  const Granular& g = scene->granular;
  copy_items(g.grains.records, g.grains.count, g.flow.free_grains, g.flow.free_grain_count, positions, velocities);
  const GrainMotions motions = grain_carry_motions(g);
  for (uint32_t i = 0; i < g.grains.count && positions != nullptr; ++i) {
    const RigidMotion* const motion = motions.of(i);
    if (motion == nullptr) continue;
    float* const at = positions + 3ull * g.grains.records[i].number;
    const Quad displacement = motion->displacement(quad(at));
    for (int k = 0; k < 3; ++k) at[k] += displacement[k];
  }
}

int32_t sandglass_scene_held_collider(const sandglass_scene* scene, uint32_t index, sandglass_collider* held) {
  if (scene == nullptr || held == nullptr) return 0;
  return collider_held(scene->granular, index, held) ? 1 : 0;
}

sandglass_body_pose sandglass_scene_body_pose(const sandglass_scene* scene, uint32_t index) {
  sandglass_body_pose pose = {};
  pose.rotation[3] = 1.0f;
  if (sandglass_scene_has_body(scene, index) != 0) granular_body_pose(scene->granular, index, &pose);
  return pose;
}

int32_t sandglass_scene_has_body(const sandglass_scene* scene, uint32_t index) {
  return scene != nullptr && bodies_has(scene->granular.bodies, index) ? 1 : 0;
}

int32_t sandglass_scene_ray(const sandglass_scene* scene, const float origin[3], const float direction[3], float reach,
                            sandglass_ray_hit* hit) {
  if (scene == nullptr || origin == nullptr || direction == nullptr || hit == nullptr) return 0;
  granular_ray(scene->granular, origin, direction, reach, hit);
  return hit->what != SANDGLASS_HIT_NOTHING ? 1 : 0;
}
