// What the app does to rigid bodies between frames: adds, removes, places and pushes them, and asks where they are.
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/rotation.h"
#include "runtime/sand/granular.h"

namespace sandglass {
namespace {

constexpr float k_body_speed = 1e4f;  // metres or radians a second, along each axis, that a body may be given

// Particles within this of a line, in radii, as a root mean square: the body has no inertia about that line.
constexpr double k_straight_radii = 0.1;

// A particle is caught in a body if it overlaps one of the body's particles, and the unit vectors to it from all of
// them within k_around_radii have a mean shorter than k_one_sided. Where it lies on a regular face, the mean is 0.7
// long; where it is level with the outermost layer, 0.4.
constexpr double k_overlap_radii = 1.9, k_around_radii = 3.0, k_one_sided = 0.5;

bool speeds_fit(const float linear[3], const float angular[3]) {
  return all_within(linear, 3, -k_body_speed, k_body_speed) && all_within(angular, 3, -k_body_speed, k_body_speed);
}

// The box around the centres of a body's particles, wider by a margin.
Bounds box_around(const Granular& g, const RigidBody& body, float margin) {
  Bounds box = k_nowhere;
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot)
    bounds_include(&box, g.particles.records[0][g.bodies.rows[slot]].position, margin);
  return box;
}

// Wakes a body and what is near it.
void wake_around(Granular* g, const RigidBody& body) {
  const Bounds box = box_around(*g, body, neighbours_reach(*g));
  sleep_wake_box(&g->sleep, *g, box.low, box.high);
  neighbours_invalidate(&g->neighbours);
}

// Gives the particles of a body the velocities of its rigid motion.
void spread_velocities(Granular* g, const RigidBody& body) {
  bodies_spread_velocities(*g, body);
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
    const Particle& p = g->particles.records[0][g->bodies.rows[slot]];
    particles_include(&g->particles, p.position, p.velocity);
  }
}

// An awake particle was put somewhere else: it begins to rest anew there, and grains do not follow that.
void begin_anew(Granular* g, const Particle& p) {
  sleep_begin_rest(&g->sleep, number_of(p), p.position);
  motion_add(g->motion, *g, number_of(p), p.position, p.velocity);
  particles_include(&g->particles, p.position, p.velocity);
}

// Whether a particle at p is caught between those of the body: it overlaps one of them, and those around it are on all
// sides, so that their pushes cancel.
bool caught(const Granular& g, const RigidBody& body, const Vector& p) {
  const double r = static_cast<double>(g.desc.particle_radius);
  Vector away = {};
  double around = 0.0;
  bool overlaps = false;
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
    const Vector b = to_vector(g.particles.records[0][g.bodies.rows[slot]].position);
    const Vector d = {p.x - b.x, p.y - b.y, p.z - b.z};
    const double distance = __builtin_sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    if (!(distance < k_around_radii * r)) continue;
    const double inverse = distance > 0.0 ? 1.0 / distance : 0.0;
    away = {away.x + d.x * inverse, away.y + d.y * inverse, away.z + d.z * inverse};
    around += 1.0;
    overlaps = overlaps || distance < k_overlap_radii * r;
  }
  const double length2 = away.x * away.x + away.y * away.y + away.z * away.z;
  return overlaps && length2 < k_one_sided * k_one_sided * around * around;
}

// How far these particles have to be moved along an axis of the world, forward or backward, so that none overlaps the
// body. Gives up at `limit`.
double distance_out(const Granular& g, const RigidBody& body, const uint32_t* rows, uint32_t count, int axis,
                    double sign, double limit) {
  const int other = (axis + 1) % 3, third = (axis + 2) % 3;
  const Particle* particles = g.particles.records[0];
  const double touching = 2.0 * static_cast<double>(g.desc.particle_radius);
  double distance = 0.0;
  for (bool moved = true; moved && distance < limit;) {
    moved = false;
    for (uint32_t i = 0; i < count; ++i) {
      const float* p = particles[rows[i]].position;
      for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
        const float* b = particles[g.bodies.rows[slot]].position;
        const double d = static_cast<double>(b[other] - p[other]), e = static_cast<double>(b[third] - p[third]);
        const double half2 = touching * touching - d * d - e * e;
        if (!(half2 > 0.0)) continue;
        const double along = sign * static_cast<double>(b[axis] - p[axis]), half = __builtin_sqrt(half2);
        if (along - half < distance && along + half > distance) {
          distance = along + half;
          moved = true;
        }
      }
    }
  }
  return distance;
}

// Puts these particles beside the body, along the axis of the world on which that is nearest, but not downward: there
// the floor is.
void put_beside(Granular* g, const RigidBody& body, const uint32_t* rows, uint32_t count) {
  double nearest = 1e30;
  float shift[3] = {};
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const double sign = side % 2 == 0 ? 1.0 : -1.0;
    if (sign * static_cast<double>(g->gravity[axis]) > 0.5 * static_cast<double>(g->gravity_length)) continue;
    const double distance = distance_out(*g, body, rows, count, axis, sign, nearest);
    if (!(distance < nearest)) continue;
    nearest = distance;
    shift[0] = shift[1] = shift[2] = 0.0f;
    shift[axis] = static_cast<float>(sign * distance);
  }
  const Particle& first = g->particles.records[0][rows[0]];
  if (in_body(first)) {
    RigidBody moved = g->bodies.all[body_of(first) - 1];
    for (int k = 0; k < 3; ++k) moved.center[k] += static_cast<double>(shift[k]);
    bodies_set(&g->bodies, body_of(first) - 1, moved);
  }
  for (uint32_t i = 0; i < count; ++i) {
    Particle* p = &g->particles.records[0][rows[i]];
    for (int k = 0; k < 3; ++k) p->position[k] += shift[k];
    begin_anew(g, *p);
  }
}

// A particle inside a body that was just placed would be caught between the body's particles: they push it to and fro
// for ever, sand at metres a second and other bodies at ten times that. Puts it beside the body.
void free_caught(Granular* g, const RigidBody& body) {
  const Bounds box = box_around(*g, body, 0.0f);
  const auto caught_at = [&](uint32_t row) {
    const float* p = g->particles.records[0][row].position;
    for (int k = 0; k < 3; ++k)
      if (!within(p[k], box.low[k], box.high[k])) return false;
    return caught(*g, body, to_vector(p));
  };
  for (uint32_t index = 0; index < g->bodies.count; ++index) {
    const RigidBody& other = g->bodies.all[index];
    bool any = false;
    for (uint32_t i = 0; i < other.count && other.first != body.first && !any; ++i)
      any = caught_at(g->bodies.rows[other.first + i]);
    if (!any) continue;
    wake_around(g, other);
    put_beside(g, body, g->bodies.rows + other.first, other.count);
  }
  for (uint32_t i = 0; i < g->particles.count; ++i) {
    const Particle& sand = g->particles.records[0][i];
    if (in_body(sand) || !caught_at(i)) continue;
    if (is_asleep(sand)) sleep_wake_box(&g->sleep, *g, sand.position, sand.position);
    put_beside(g, body, &i, 1);
  }
}

// The angular velocity that an impulse at `arm` from the centre gives the body.
Vector spin_of_push(const Granular& g, const RigidBody& body, const Vector& arm, const Vector& impulse) {
  double spread[9] = {};
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
    const Vector r = rotated(body.rotation, to_vector(g.bodies.rest_shape + 3ull * slot));
    const double at[3] = {r.x, r.y, r.z};
    for (int i = 0; i < 9; ++i) spread[i] += at[i / 3] * at[i % 3] / body.count;
  }
  const Vector turn = cross(arm, impulse);
  double l[3] = {turn.x, turn.y, turn.z}, w[3];
  // The longest column points along the line of a straight body.
  int axis = 0;
  for (int i = 1; i < 3; ++i) axis = spread[4 * i] > spread[4 * axis] ? i : axis;
  const double u[3] = {spread[axis], spread[3 + axis], spread[6 + axis]};
  const double length2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], trace = spread[0] + spread[4] + spread[8];
  const double radius = k_straight_radii * static_cast<double>(g.desc.particle_radius);
  if (!(length2 > 0.0)) return {};  // a point
  if (trace - length2 / spread[4 * axis] < radius * radius) {
    const double along = (l[0] * u[0] + l[1] * u[1] + l[2] * u[2]) / length2;
    for (int k = 0; k < 3; ++k) l[k] -= along * u[k];
  }
  angular_velocity(spread, l, w);
  return {w[0], w[1], w[2]};
}

}  // namespace

sandglass_status granular_add_body(Granular* g, const sandglass_body* desc, uint32_t* index, const char** reason) {
  if (desc == nullptr) return refuse(reason, "body is NULL: pass a body filled by sandglass_body_default.");
  if (desc->struct_size != sizeof *desc)
    return refuse(reason, "body.struct_size is not this library's: fill it with sandglass_body_default.");
  if (desc->particle_count == 0) return refuse(reason, "body.particle_count is 0: a body needs at least one particle.");
  if (desc->particle_positions == nullptr)
    return refuse(reason, "body.particle_positions is NULL: pass 3 floats for each particle.");
  if (!(desc->density_ratio >= 1e-3f && desc->density_ratio <= 1e3f))
    return refuse(reason, "density_ratio must be 0.001 to 1000.");
  if (!speeds_fit(desc->linear_velocity, desc->angular_velocity))
    return refuse(reason, "a velocity is not finite or above 10000 m/s or rad/s.");
  const uint32_t number = bodies_free_number(g->bodies, g->desc.body_capacity);
  if (number == g->desc.body_capacity ||
      desc->particle_count > g->desc.body_particle_capacity - g->bodies.particle_count)
    return refuse(reason, SANDGLASS_ERROR_CAPACITY,
                  "more bodies or body particles than granular.body_capacity and "
                  "body_particle_capacity have room for: raise them.");
  const uint32_t first_record = g->particles.count;
  if (const sandglass_status added =
          granular_add(g, {desc->particle_positions, nullptr, desc->particle_count}, {}, reason))
    return added;

  bodies_add(&g->bodies, *g, number, *desc, first_record);
  const RigidBody& body = g->bodies.all[number];
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
    sleep_set_body_slot(&g->sleep, g->bodies.numbers[slot], slot);
    join_body(&g->particles.records[0][g->bodies.rows[slot]], number + 1, 1.0f / desc->density_ratio);
  }
  spread_velocities(g, body);
  if (index != nullptr) *index = number;
  free_caught(g, body);
  return SANDGLASS_OK;
}

void granular_take_out_body(Granular* g, uint32_t index) {
  const RigidBody removed = g->bodies.all[index];
  wake_around(g, removed);
  for (uint32_t slot = removed.first; slot < removed.first + removed.count; ++slot)
    granular_take_out_particle(g, g->bodies.rows[slot]);
  bodies_remove(&g->bodies, *g, index);
  for (uint32_t slot = removed.first; slot < g->bodies.particle_count; ++slot)
    sleep_set_body_slot(&g->sleep, g->bodies.numbers[slot], slot);
  flow_count_removed(&g->flow, removed.count, 0, 1);
  granular_after_removal(g);
}

sandglass_status granular_remove_body(Granular* g, uint32_t index, const char** reason) {
  if (!bodies_has(g->bodies, index))
    return refuse(reason, "no body has this index: pass that of a body that was added.");
  substep_abandon(g);
  granular_take_out_body(g, index);
  return accept(reason);
}

sandglass_status granular_set_body(Granular* g, uint32_t index, const sandglass_body_pose* pose, const char** reason) {
  if (pose == nullptr) return refuse(reason, "pose is NULL: pass where the body shall be.");
  if (!bodies_has(g->bodies, index))
    return refuse(reason, "no body has this index: pass that of a body that was added.");
  sandglass_collider frame = {}, accepted;
  for (int k = 0; k < 3; ++k) frame.position[k] = pose->position[k];
  for (int k = 0; k < 4; ++k) frame.rotation[k] = pose->rotation[k];
  if (!speeds_fit(pose->linear_velocity, pose->angular_velocity) || !collider_accept(frame, &accepted))
    return refuse(reason,
                  "a number of the pose is not finite, a velocity is above 10000 m/s or rad/s, or "
                  "the rotation has no length.");
  RigidBody placed = g->bodies.all[index];
  double length2 = 0.0;
  for (const float q : pose->rotation) length2 += static_cast<double>(q) * static_cast<double>(q);
  for (int k = 0; k < 4; ++k) placed.rotation[k] = static_cast<double>(pose->rotation[k]) / __builtin_sqrt(length2);
  for (int k = 0; k < 3; ++k) {
    placed.center[k] = static_cast<double>(pose->position[k]);
    placed.linear[k] = pose->linear_velocity[k];
    placed.angular[k] = pose->angular_velocity[k];
  }
  for (uint32_t slot = placed.first; slot < placed.first + placed.count; ++slot) {
    float at[3];
    bodies_place(g->bodies, placed, slot, at);
    if (!all_within(at, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
      return refuse(reason,
                    "a particle of the body would be more than 1000 m from the scene "
                    "origin: move the origin nearer.");
  }
  substep_abandon(g);
  wake_around(g, placed);  // where its particles still are
  bodies_set(&g->bodies, index, placed);
  for (uint32_t slot = placed.first; slot < placed.first + placed.count; ++slot)
    bodies_place(g->bodies, placed, slot, g->particles.records[0][g->bodies.rows[slot]].position);
  spread_velocities(g, placed);
  for (uint32_t slot = placed.first; slot < placed.first + placed.count; ++slot)
    begin_anew(g, g->particles.records[0][g->bodies.rows[slot]]);
  wake_around(g, placed);
  free_caught(g, placed);
  sweep_particles_changed(&g->sweep);
  return accept(reason);
}

sandglass_status granular_push_body(Granular* g, uint32_t index, const float impulse[3], const float* point,
                                    const char** reason) {
  if (impulse == nullptr) return refuse(reason, "impulse is NULL: pass its x, y and z in m/s.");
  if (!bodies_has(g->bodies, index))
    return refuse(reason, "no body has this index: pass that of a body that was added.");
  if (!all_finite(impulse, 3) ||
      (point != nullptr && !all_within(point, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT)))
    return refuse(reason,
                  "impulse or point is not finite, or the point is more than 1000 m from "
                  "the scene origin.");
  const RigidBody& body = g->bodies.all[index];
  Vector arm = {};
  if (point != nullptr) {
    const Vector p = to_vector(point);
    arm = {p.x - body.center[0], p.y - body.center[1], p.z - body.center[2]};
  }
  const Vector w = spin_of_push(*g, body, arm, to_vector(impulse));
  const double turned[3] = {w.x, w.y, w.z};
  float linear[3], angular[3];
  const auto add_push = [&] {
    for (int k = 0; k < 3; ++k) {
      linear[k] = body.linear[k] + impulse[k];
      angular[k] = static_cast<float>(static_cast<double>(body.angular[k]) + turned[k]);
    }
  };
  add_push();
  if (!speeds_fit(linear, angular))
    return refuse(reason,
                  "the body would be faster than 10000 m/s or rad/s along an axis: push it "
                  "less, or nearer to its centre.");
  substep_abandon(g);  // which may end a sub-step: then the body has new velocities
  add_push();
  RigidBody pushed = body;
  __builtin_memcpy(pushed.linear, linear, sizeof pushed.linear);
  __builtin_memcpy(pushed.angular, angular, sizeof pushed.angular);
  bodies_set(&g->bodies, index, pushed);
  wake_around(g, body);
  spread_velocities(g, body);
  return accept(reason);
}

void granular_body_pose(const Granular& g, uint32_t index, sandglass_body_pose* pose) {
  const RigidBody& body = g.bodies.all[index];
  for (int k = 0; k < 3; ++k) {
    pose->position[k] = static_cast<float>(body.center[k]);
    pose->linear_velocity[k] = body.linear[k];
    pose->angular_velocity[k] = body.angular[k];
  }
  for (int k = 0; k < 4; ++k) pose->rotation[k] = static_cast<float>(body.rotation[k]);
}

}  // namespace sandglass
