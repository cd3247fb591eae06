// What the app does to the whole scene between frames: sets its boundary and friction, moves it, saves and restores it.
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/sand/granular.h"

namespace sandglass {
namespace {

constexpr char k_moved_too_far[] =
    "the move would leave the coordinate limit, 1000 m from the scene origin; nothing "
    "was moved.";

bool stays_within(const SceneMove& move, const float position[3]) {
  float p[3] = {position[0], position[1], position[2]};
  move.move(p);
  for (const float c : p) {
    if (!(__builtin_fabsf(c) <= SANDGLASS_COORDINATE_LIMIT)) return false;
  }
  return true;
}

// Whether all items stay within the limit. Those that had left the scene before need not.
template <class Item>
bool all_stay(const Granular& g, const SceneMove& move, const Item* items, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    if (!stays_within(move, items[i].position) && !departed_has_left(g, items[i])) return false;
  }
  return true;
}

void remove_leaving(Granular* g, const SceneMove& move) {
  uint64_t particles = 0, grains = 0;
  for (uint32_t i = g->particles.count; i-- > 0;) {
    const Particle& p = g->particles.records[0][i];
    if (!stays_within(move, p.position) && !in_body(p)) {
      granular_take_out_particle(g, i);
      ++particles;
    }
  }
  for (uint32_t i = g->grains.count; i-- > 0;) {
    if (!stays_within(move, g->grains.records[i].position)) {
      granular_take_out_grain(g, i);
      ++grains;
    }
  }
  if (particles != 0) granular_after_removal(g);
  if (grains != 0) sweep_grains_removed(g);
  flow_count_removed(&g->flow, particles, grains, 0);
}

}  // namespace

sandglass_status granular_set_boundary(Granular* g, const float* positions, uint32_t count, const char** reason) {
  if (count != 0 && positions == nullptr) {
    return refuse(reason, "positions is NULL but count is above 0: pass 3 floats for each sample.");
  }
  if (count > g->desc.boundary_capacity) {
    return refuse(reason, SANDGLASS_ERROR_CAPACITY, "more particles than granular.boundary_capacity: raise it.");
  }
  if (!all_within(positions, 3ull * count, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT)) {
    return refuse(reason,
                  "a position is not finite or more than 1000 m from the scene origin: "
                  "move the origin nearer.");
  }
  granular_wake_all(g);
  for (uint32_t i = 0; i < count; ++i) boundary_particles(*g)[i] = fixed_particle(positions + 3ull * i, i);
  boundary_sort(&g->boundary, *g, count);
  return accept(reason);
}

void granular_set_friction(Granular* g, float static_friction, float kinetic_friction) {
  granular_take_friction(g, static_friction, kinetic_friction);
  granular_wake_all(g);
}

// A scene is moved rigidly when the app's coordinates change under it.
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
    return refuse(reason, "rotation or translation is not finite, or the rotation has no length.");
  if (g->desc.particle_capacity == 0) return accept(reason);
  ColliderFrame posed;
  colliders_pose(&accepted, 1, 0.0f, &posed);
  SceneMove move;
  __builtin_memcpy(move.axes, posed.axes, sizeof move.axes);
  for (int k = 0; k < 3; ++k) move.shift[k] = accepted.position[k];
  for (int k = 0; k < 4; ++k) move.rotation[k] = static_cast<double>(accepted.rotation[k]);
  Particle* boundary = boundary_particles(*g);
  if (!all_stay(*g, move, g->particles.records[0], g->particles.count) ||
      !all_stay(*g, move, g->grains.records, g->grains.count) || !all_stay(*g, move, boundary, g->boundary.count)) {
    return refuse(reason, k_moved_too_far);
  }
  granular_settle(g);
  remove_leaving(g, move);
  particles_move(&g->particles, move);
  grains_move(&g->grains, move);
  output_changed(&g->output);
  sleep_move(&g->sleep, g->particles.count + g->flow.free_particle_count, move);
  bodies_move(&g->bodies, move);
  granular_forget_departed(g);
  motion_begin_here(g->motion, *g);
  boundary_move(&g->boundary, *g, move);
  colliders_move(&g->colliders, *g, move);
  float resting[3] = {g->resting_gravity[0], g->resting_gravity[1], g->resting_gravity[2]};
  move.turn(resting);  // what rests has turned under gravity
  granular_set_resting_gravity(g, resting);
  granular_feel_gravity(g);
  return accept(reason);
}

sandglass_status granular_save(Granular* g, void* data, uint64_t bytes, uint64_t* written, const char** reason) {
  if (data == nullptr || written == nullptr)
    return refuse(reason, "data or written is NULL: pass the memory and where to store its length.");
  if (bytes < granular_save_bytes(*g))  // before anything changes
    return refuse(reason, SANDGLASS_ERROR_MEMORY_TOO_SMALL,
                  "bytes is less than the scene needs: ask sandglass_scene_save_bytes.");
  granular_settle(g);
  return saved_write(*g, data, bytes, written, reason);
}

sandglass_status granular_restore(Granular* g, const void* data, uint64_t bytes, const char** reason) {
  if (const sandglass_status status = saved_check(*g, data, bytes, reason)) return status;
  granular_reset(g);
  if (g->desc.particle_capacity == 0) return accept(reason);
  SavedScene saved;
  if (!saved_read(*g, data, &saved)) {
    granular_reset(g);
    return refuse(reason, "the data contradicts itself; the scene was reset.");
  }
  particles_restore(&g->particles, saved);
  flow_restore(&g->flow, saved);
  grains_restore(&g->grains, saved);
  output_changed(&g->output);
  bodies_restore(&g->bodies, saved);
  time_restore(&g->time, saved);
  sleep_restore(&g->sleep, saved);
  neighbours_restore(&g->neighbours, saved);
  contacts_restore(&g->contacts, saved);
  granular_set_resting_gravity(g, saved.state.resting_gravity);
  boundary_sort(&g->boundary, *g, saved.boundary);
  granular_settle(g);
  granular_feel_gravity(g);
  return accept(reason);
}

}  // namespace sandglass
