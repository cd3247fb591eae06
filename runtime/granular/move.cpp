// A scene that is moved rigidly, when the app's coordinates change under it.
#include "runtime/core/finite.h"
#include "runtime/core/refuse.h"
#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

constexpr char k_moved_too_far[] =
    "sandglass_scene_move: the move would leave the coordinate limit, 1000 m from the scene origin; nothing "
    "was moved.";

struct Motion {
  float axes[3][3];  // images of x, y, z
  float shift[3];
  double rotation[4];

  void turn(float v[3]) const {
    const float x = v[0], y = v[1], z = v[2];
    for (int k = 0; k < 3; ++k) v[k] = x * axes[0][k] + y * axes[1][k] + z * axes[2][k];
  }
  void move(float p[3]) const {
    turn(p);
    for (int k = 0; k < 3; ++k) p[k] += shift[k];
  }
};

bool stays_within(const Motion& motion, const float position[3]) {
  float p[3] = {position[0], position[1], position[2]};
  motion.move(p);
  for (const float c : p) {
    if (!(__builtin_fabsf(c) <= SANDGLASS_COORDINATE_LIMIT)) return false;
  }
  return true;
}

// What leaves the limit must have left the scene before.
template <class Item>
bool all_stay(const Granular& g, const Motion& motion, const Item* items, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    if (!stays_within(motion, items[i].position) && !departed_has_left(g, items[i])) return false;
  }
  return true;
}

void remove_leaving(Granular* g, const Motion& motion) {
  uint64_t particles = 0, grains = 0;
  for (uint32_t i = g->particles.count; i-- > 0;) {
    const Particle& p = g->particles.records[0][i];
    if (!stays_within(motion, p.position) && !in_body(p)) flow_remove_particle(g, i), ++particles;
  }
  for (uint32_t i = g->grains.count; i-- > 0;) {
    if (!stays_within(motion, g->grains.records[i].position)) flow_remove_grain(g, i), ++grains;
  }
  if (particles != 0) flow_after_removal(g);
  if (grains != 0) sweep_grains_removed(g);
  g->flow.counts.removed_particles += particles, g->flow.counts.removed_grains += grains;
}

template <class Item>
void move_items(const Motion& motion, Item* items, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    motion.move(items[i].position);
    motion.turn(items[i].velocity);
  }
}

}  // namespace

sandglass_status granular_move(Granular* g, const float rotation[4], const float translation[3], const char** reason) {
  sandglass_collider frame = {}, accepted;
  frame.rotation[3] = 1.0f;
  for (int k = 0; rotation != nullptr && k < 4; ++k) frame.rotation[k] = rotation[k];
  for (int k = 0; translation != nullptr && k < 3; ++k) {
    frame.position[k] = translation[k];
    if (is_finite(translation[k]) && __builtin_fabsf(translation[k]) > k_coordinate_bound)
      return refuse(reason, k_moved_too_far);
  }
  if (!collider_accept(frame, &accepted))
    return refuse(reason,
                  "sandglass_scene_move: rotation or translation is not finite, or the rotation has no length.");
  if (g->desc.particle_capacity == 0) return accept(reason);
  ColliderFrame posed;
  colliders_pose(&accepted, 1, 0.0f, &posed);
  Motion motion;
  __builtin_memcpy(motion.axes, posed.axes, sizeof motion.axes);
  for (int k = 0; k < 3; ++k) motion.shift[k] = accepted.position[k];
  for (int k = 0; k < 4; ++k) motion.rotation[k] = static_cast<double>(accepted.rotation[k]);
  Particle* boundary = boundary_particles(*g);
  if (!all_stay(*g, motion, g->particles.records[0], g->particles.count) ||
      !all_stay(*g, motion, g->grains.records, g->grains.count) || !all_stay(*g, motion, boundary, g->boundary.count)) {
    return refuse(reason, k_moved_too_far);
  }
  granular_settle(g);
  remove_leaving(g, motion);
  move_items(motion, g->particles.records[0], g->particles.count);
  if (g->grains.count != 0) move_items(motion, g->grains.records, g->grains.count);
  for (uint32_t i = 0; i < g->particles.count + g->flow.free_particle_count; ++i)
    motion.move(g->sleep.anchors[i].position);
  for (uint32_t b = 0; b < g->bodies.count; ++b) bodies_move(&g->bodies, b, motion.rotation, motion.shift);
  particles_find_bounds(&g->particles);
  departed_forget(g);
  motion_begin_here(g);
  move_items(motion, boundary, g->boundary.count);
  boundary_sort(g, g->boundary.count);
  colliders_move(g, accepted.rotation, motion.shift);
  motion.turn(g->resting_gravity);  // what rests has turned under gravity
  granular_feel_gravity(g);
  return accept(reason);
}

}  // namespace sandglass
