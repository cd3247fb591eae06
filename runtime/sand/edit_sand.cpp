// What the app does to the sand between frames: adds it, and removes what lies in a shape. A nozzle adds sand during a
// frame.
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/sand/granular.h"

namespace sandglass {
namespace {

constexpr float k_at_rest[3] = {0.0f, 0.0f, 0.0f};

constexpr float k_speed_limit = 1e4f;  // m/s that material may be added with

// The coordinates of `count` positions or velocities.
bool items_within(const float* values, uint32_t count, float limit) {
  return all_within(values, 3ull * count, -limit, limit);
}

void add_particle(Granular* g, const float position[3], const float velocity[3]) {
  const uint32_t number = flow_take_particle_number(&g->flow, g->particles.count);
  particles_append(&g->particles, position, velocity, number);
  sleep_add(&g->sleep, number, position);
  motion_add(g->motion, *g, number, position, velocity);
}

void add_grain(Granular* g, const float position[3], const float velocity[3]) {
  grains_append(&g->grains, position, velocity, flow_take_grain_number(&g->flow, g->grains.count));
}

sandglass_status check_add(const Granular& g, const sandglass_points& particles, const sandglass_points& grains,
                           const char** reason) {
  if ((particles.count != 0 && particles.positions == nullptr) || (grains.count != 0 && grains.positions == nullptr)) {
    return refuse(
        reason,
        "particles.positions or grains.positions is NULL but its count is above 0: pass 3 floats for each item.");
  }
  if (particles.count > g.desc.particle_capacity - g.particles.count) {
    return refuse(reason, SANDGLASS_ERROR_CAPACITY,
                  "more particles than granular.particle_capacity has room for: raise it.");
  }
  if (grains.count > g.desc.grain_capacity - g.grains.count) {
    return refuse(reason, SANDGLASS_ERROR_CAPACITY, "more grains than granular.grain_capacity has room for: raise it.");
  }
  if (!items_within(particles.positions, particles.count, SANDGLASS_COORDINATE_LIMIT) ||
      !items_within(grains.positions, grains.count, SANDGLASS_COORDINATE_LIMIT)) {
    return refuse(reason,
                  "a position is not finite or more than 1000 m from the scene origin: move the "
                  "origin nearer.");
  }
  if ((particles.velocities != nullptr && !items_within(particles.velocities, particles.count, k_speed_limit)) ||
      (grains.velocities != nullptr && !items_within(grains.velocities, grains.count, k_speed_limit))) {
    return refuse(reason, "a velocity is not finite or above 10000 m/s: check where it comes from.");
  }
  return accept(reason);
}

void put_in(Granular* g, const sandglass_points& particles, const sandglass_points& grains) {
  const auto velocity = [](const sandglass_points& points, uint64_t i) {
    return points.velocities == nullptr ? k_at_rest : points.velocities + 3 * i;
  };
  if (particles.count != 0) {
    substep_abandon(g);
    for (uint64_t i = 0; i < particles.count; ++i) add_particle(g, particles.positions + 3 * i, velocity(particles, i));
    neighbours_invalidate(&g->neighbours);
    sweep_particles_changed(&g->sweep);
    granular_seal(g);
  }
  if (grains.count != 0) {
    if (g->grains.count == 0) motion_begin_here(g->motion, *g);
    for (uint64_t i = 0; i < grains.count; ++i) add_grain(g, grains.positions + 3 * i, velocity(grains, i));
    sweep_grains_added(g, grains.count);
  }
}

}  // namespace

sandglass_status granular_add(Granular* g, const sandglass_points& particles, const sandglass_points& grains,
                              const char** reason) {
  if (const sandglass_status refused = check_add(*g, particles, grains, reason)) return refused;
  if (grains.count != 0 && !sweep_takes_grains(*g)) sweep_end(g);
  put_in(g, particles, grains);
  return SANDGLASS_OK;
}

bool granular_pour_in(Granular* g, const sandglass_points& particles, const sandglass_points& grains) {
  if (check_add(*g, particles, grains, nullptr)) return false;
  put_in(g, particles, grains);
  return true;
}

sandglass_status granular_remove(Granular* g, const sandglass_collider* region, uint32_t* particles, uint32_t* grains,
                                 const char** reason) {
  sandglass_collider accepted;
  if (region == nullptr) return refuse(reason, "region is NULL: pass the shape to empty.");
  if (!collider_accept(*region, &accepted)) {
    return refuse(
        reason,
        "region is not a usable shape: its numbers must be finite, its position within "
        "the coordinate limit, its sizes above 0, its rotation not zero, and its field made by this library.");
  }
  ColliderFrame shape;
  colliders_pose(&accepted, 1, 0.0f, &shape);
  granular_wake_all(g);
  sweep_end(g);
  uint32_t removed = 0, removed_grains = 0, found[k_lane_group];
  for (uint32_t group = (g->particles.count + k_lane_group - 1) / k_lane_group; group-- > 0;) {
    const uint32_t inside = flow_find_inside(*g, as_records(g->particles.records[0]), g->particles.count,
                                             group * k_lane_group, &shape, 1, found);
    for (uint32_t k = 0; k < inside; ++k) {
      if (in_body(g->particles.records[0][found[k]])) continue;
      granular_take_out_particle(g, found[k]);
      ++removed;
    }
  }
  for (uint32_t group = (g->grains.count + k_lane_group - 1) / k_lane_group; group-- > 0;) {
    const uint32_t inside =
        flow_find_inside(*g, as_records(g->grains.records), g->grains.count, group * k_lane_group, &shape, 1, found);
    for (uint32_t k = 0; k < inside; ++k) granular_take_out_grain(g, found[k]);
    removed_grains += inside;
  }
  if (g->desc.particle_capacity != 0) granular_after_removal(g);
  if (removed_grains != 0) sweep_grains_removed(g);
  flow_count_removed(&g->flow, removed, removed_grains, 0);
  if (particles != nullptr) *particles = removed;
  if (grains != nullptr) *grains = removed_grains;
  return accept(reason);
}

}  // namespace sandglass
