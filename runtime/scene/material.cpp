// What the app adds, removes, changes and moves between frames. The functions of the sand do the work.
#include "platform/floating_point.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/scene/scene.h"

using namespace sandglass;

sandglass_status sandglass_scene_add(sandglass_scene* scene, const sandglass_points* particles,
                                     const sandglass_points* grains, const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  const sandglass_points none = {};
  return granular_add(&scene->granular, particles != nullptr ? *particles : none, grains != nullptr ? *grains : none,
                      reason);
}

sandglass_status sandglass_scene_remove(sandglass_scene* scene, const sandglass_collider* region, uint32_t* particles,
                                        uint32_t* grains, const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  return granular_remove(&scene->granular, region, particles, grains, reason);
}

sandglass_status sandglass_scene_add_body(sandglass_scene* scene, const sandglass_body* body, uint32_t* index,
                                          const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  return granular_add_body(&scene->granular, body, index, reason);
}

sandglass_status sandglass_scene_remove_body(sandglass_scene* scene, uint32_t index, const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  return granular_remove_body(&scene->granular, index, reason);
}

sandglass_status sandglass_scene_set_body(sandglass_scene* scene, uint32_t index, const sandglass_body_pose* pose,
                                          const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  const ExactFloatingPoint exact;
  return granular_set_body(&scene->granular, index, pose, reason);
}

sandglass_status sandglass_scene_push_body(sandglass_scene* scene, uint32_t index, const float impulse[3],
                                           const float point[3], const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  const ExactFloatingPoint exact;
  return granular_push_body(&scene->granular, index, impulse, point, reason);
}

sandglass_status sandglass_scene_set_boundary(sandglass_scene* scene, const float* positions, uint32_t count,
                                              const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  return granular_set_boundary(&scene->granular, positions, count, reason);
}

sandglass_status sandglass_scene_set_friction(sandglass_scene* scene, float static_friction, float kinetic_friction,
                                              const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  if (!within(static_friction, 0.0f, SANDGLASS_FRICTION_LIMIT) ||
      !within(kinetic_friction, 0.0f, SANDGLASS_FRICTION_LIMIT)) {
    return refuse(reason, "both coefficients must be 0 to 10.");
  }
  granular_set_friction(&scene->granular, static_friction, kinetic_friction);
  return accept(reason);
}

sandglass_status sandglass_scene_set_gravity(sandglass_scene* scene, const float gravity[3], const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  if (gravity == nullptr) return refuse(reason, "gravity is NULL: pass its x, y and z in m/s^2.");
  if (!gravity_fits(gravity)) return refuse(reason, "gravity must be finite and at most 1000 m/s^2.");
  const ExactFloatingPoint exact;
  granular_set_gravity(&scene->granular, gravity);
  return accept(reason);
}

sandglass_status sandglass_scene_move(sandglass_scene* scene, const float rotation[4], const float translation[3],
                                      const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  const ExactFloatingPoint exact;
  return granular_move(&scene->granular, rotation, translation, reason);
}
