// What the app does to the sand between frames: adds and removes it, sets the boundary and friction, moves the scene,
// adds, places, pushes and removes rigid bodies, saves and restores.
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/rigid_motion.h"
#include "runtime/sand/granular.h"

namespace sandglass {

// ---- Adding sand

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

}  // namespace

static sandglass_status check_add(const Granular* g, const sandglass_points& particles, const sandglass_points& grains,
                                  const char** reason) {
  if ((particles.count != 0 && particles.positions == nullptr) || (grains.count != 0 && grains.positions == nullptr)) {
    return refuse(
        reason,
        "particles.positions or grains.positions is NULL but its count is above 0: pass 3 floats for each item.");
  }
  if (particles.count > g->desc.particle_capacity - g->particles.count) {
    return refuse(reason, SANDGLASS_ERROR_CAPACITY,
                  "more particles than granular.particle_capacity has room for: raise it.");
  }
  if (grains.count > g->desc.grain_capacity - g->grains.count) {
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

static void put_in(Granular* g, const sandglass_points& particles, const sandglass_points& grains) {
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

sandglass_status granular_add(Granular* g, const sandglass_points& particles, const sandglass_points& grains,
                              const char** reason) {
  if (const sandglass_status refused = check_add(g, particles, grains, reason)) return refused;
  if (grains.count != 0 && !sweep_takes_grains(*g)) sweep_end(g);
  put_in(g, particles, grains);
  return SANDGLASS_OK;
}

bool granular_pour_in(Granular* g, const sandglass_points& particles, const sandglass_points& grains) {
  if (check_add(g, particles, grains, nullptr)) return false;
  put_in(g, particles, grains);
  return true;
}

// ---- Removing sand

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

// ---- The boundary, and friction

sandglass_status granular_set_boundary(Granular* g, const float* positions, uint32_t count, const char** reason) {
  if (count != 0 && positions == nullptr) {
    return refuse(reason, "positions is NULL but count is above 0: pass 3 floats for each sample.");
  }
  if (count > g->desc.boundary_capacity) {
    return refuse(reason, SANDGLASS_ERROR_CAPACITY, "more particles than granular.boundary_capacity: raise it.");
  }
  if (!items_within(positions, count, SANDGLASS_COORDINATE_LIMIT)) {
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

// ---- Moving the scene
//
// A scene that is moved rigidly, when the app's coordinates change under it.

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

// What leaves the limit must have left the scene before.
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

// ---- Rigid bodies
//
// What the app does to rigid bodies between frames: adds, removes, places and pushes them, and asks where they are.

namespace {

constexpr float k_body_speed = 1e4f;  // metres or radians a second, along each axis, that a body may be given

// Particles within this of a line, in radii, as a root mean square: the body has no inertia about that line.
constexpr double k_straight_radii = 0.1;

// A particle is caught in a body where it overlaps one of the body's, is nearer than this to others, and the directions
// from all of these to it add up to less than this share. Where it lies on a regular face, the share is 0.7; where it
// is level with the outermost layer, 0.4.
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

// What is within reach of that box wakes, and so does the body.
void wake_around(Granular* g, const RigidBody& body) {
  const Bounds box = box_around(*g, body, neighbours_reach(*g));
  sleep_wake_box(&g->sleep, *g, box.low, box.high);
  neighbours_invalidate(&g->neighbours);
}

// The particles of a body have the velocities that its own say.
void spread_velocities(Granular* g, const RigidBody& body) {
  bodies_spread_velocities(*g, body);
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
    const Particle& p = g->particles.records[0][g->bodies.rows[slot]];
    particles_include(&g->particles, p.position, p.velocity);
  }
}

// An awake particle was put somewhere else: it rests anew from there, and no grain follows it.
void went_nowhere(Granular* g, const Particle& p) {
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
  const double way2 = away.x * away.x + away.y * away.y + away.z * away.z;
  return overlaps && way2 < k_one_sided * k_one_sided * around * around;
}

// How far along an axis of the world, forward or backward, these particles have to go so that none overlaps the body.
// Gives up where that is as far as `least`.
double way_out(const Granular& g, const RigidBody& body, const uint32_t* rows, uint32_t count, int axis, double sign,
               double least) {
  const int other = (axis + 1) % 3, third = (axis + 2) % 3;
  const Particle* particles = g.particles.records[0];
  const double touching = 2.0 * static_cast<double>(g.desc.particle_radius);
  double way = 0.0;
  for (bool moved = true; moved && way < least;) {
    moved = false;
    for (uint32_t i = 0; i < count; ++i) {
      const float* p = particles[rows[i]].position;
      for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
        const float* b = particles[g.bodies.rows[slot]].position;
        const double d = static_cast<double>(b[other] - p[other]), e = static_cast<double>(b[third] - p[third]);
        const double half2 = touching * touching - d * d - e * e;
        if (!(half2 > 0.0)) continue;
        const double along = sign * static_cast<double>(b[axis] - p[axis]), half = __builtin_sqrt(half2);
        if (along - half < way && along + half > way) {
          way = along + half;
          moved = true;
        }
      }
    }
  }
  return way;
}

// Puts these particles beside the body, along the axis of the world on which that is nearest, but not downward: there
// the floor is.
void put_beside(Granular* g, const RigidBody& body, const uint32_t* rows, uint32_t count) {
  double least = 1e30;
  float shift[3] = {};
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const double sign = side % 2 == 0 ? 1.0 : -1.0;
    if (sign * static_cast<double>(g->gravity[axis]) > 0.5 * static_cast<double>(g->gravity_length)) continue;
    const double way = way_out(*g, body, rows, count, axis, sign, least);
    if (!(way < least)) continue;
    least = way;
    shift[0] = shift[1] = shift[2] = 0.0f;
    shift[axis] = static_cast<float>(sign * way);
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
    went_nowhere(g, *p);
  }
}

// What a body is put around is caught between its particles: they push it to and fro for ever, sand at metres a second
// and other bodies at ten times that. It is put beside the body.
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

// The spread of the body as it is turned, and what a push of the whole body at `arm` turns it by.
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
  const RigidBody gone = g->bodies.all[index];
  wake_around(g, gone);
  for (uint32_t slot = gone.first; slot < gone.first + gone.count; ++slot)
    granular_take_out_particle(g, g->bodies.rows[slot]);
  bodies_remove(&g->bodies, *g, index);
  for (uint32_t slot = gone.first; slot < g->bodies.particle_count; ++slot)
    sleep_set_body_slot(&g->sleep, g->bodies.numbers[slot], slot);
  flow_count_removed(&g->flow, gone.count, 0, 1);
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
    went_nowhere(g, g->particles.records[0][g->bodies.rows[slot]]);
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

// ---- Saving and restoring

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
