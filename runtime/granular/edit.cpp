// What the app does to the sand between frames: adds it, sets the boundary, moves the scene, and adds, places, pushes and
// removes rigid bodies.
#include "runtime/core/finite.h"
#include "runtime/core/refuse.h"
#include "runtime/core/rigid_motion.h"
#include "runtime/granular/granular.h"

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
  Particles& p = g->particles;
  const uint32_t number = flow_take_particle_number(&g->flow, p.count);
  p.records[0][p.count++] = moving_particle(position, velocity, number);
  sleep_add(&g->sleep, number, position);
  particles_include(&p, position, velocity);
  motion_add(g, number, position, velocity);
}

void add_grain(Granular* g, const float position[3], const float velocity[3]) {
  Grains& grains = g->grains;
  const uint32_t number = flow_take_grain_number(&g->flow, grains.count);
  grains.records[grains.count++] = moving_grain(position, velocity, number);
}

}  // namespace

sandglass_status granular_add(Granular* g, const float* particles, const float* particle_velocities,
                              uint32_t particle_count, const float* grains, const float* grain_velocities,
                              uint32_t grain_count, const char** reason) {
  if ((particle_count != 0 && particles == nullptr) || (grain_count != 0 && grains == nullptr)) {
    return refuse(
        reason, "particle_positions or grain_positions is NULL but its count is above 0: pass 3 floats for each item.");
  }
  if (particle_count > g->desc.particle_capacity - g->particles.count) {
    return refuse(reason, SANDGLASS_ERROR_CAPACITY,
                  "more particles than granular.particle_capacity has room for: raise it.");
  }
  if (grain_count > g->desc.grain_capacity - g->grains.count) {
    return refuse(reason, SANDGLASS_ERROR_CAPACITY, "more grains than granular.grain_capacity has room for: raise it.");
  }
  if (!items_within(particles, particle_count, SANDGLASS_COORDINATE_LIMIT) ||
      !items_within(grains, grain_count, SANDGLASS_COORDINATE_LIMIT)) {
    return refuse(reason,
                  "a position is not finite or more than 1000 m from the scene origin: move the "
                  "origin nearer.");
  }
  if ((particle_velocities != nullptr && !items_within(particle_velocities, particle_count, k_speed_limit)) ||
      (grain_velocities != nullptr && !items_within(grain_velocities, grain_count, k_speed_limit))) {
    return refuse(reason, "a velocity is not finite or above 10000 m/s: check where it comes from.");
  }
  if (particle_count != 0) {
    substep_abandon(g);
    for (uint64_t i = 0; i < particle_count; ++i)
      add_particle(g, particles + 3 * i, particle_velocities == nullptr ? k_at_rest : particle_velocities + 3 * i);
    g->neighbours.valid = false;
    sweep_particles_changed(g);
    particles_seal(g);
  }
  if (grain_count != 0) {
    if (g->grains.count == 0) motion_begin_here(g);
    for (uint64_t i = 0; i < grain_count; ++i)
      add_grain(g, grains + 3 * i, grain_velocities == nullptr ? k_at_rest : grain_velocities + 3 * i);
    sweep_grains_added(g, grain_count);
  }
  return accept(reason);
}

// ---- The boundary

sandglass_status granular_set_boundary(Granular* g, const float* positions, uint32_t count, const char** reason) {
  if (count != 0 && positions == nullptr) {
    return refuse(
        reason,
        "sandglass_granular_set_boundary: positions is NULL but count is above 0: pass 3 floats for each sample.");
  }
  if (count > g->desc.boundary_capacity) {
    return refuse(reason, SANDGLASS_ERROR_CAPACITY,
                  "sandglass_granular_set_boundary: more particles than granular.boundary_capacity: raise it.");
  }
  if (!items_within(positions, count, SANDGLASS_COORDINATE_LIMIT)) {
    return refuse(
        reason,
        "sandglass_granular_set_boundary: a position is not finite or more than 1000 m from the scene origin: "
        "move the origin nearer.");
  }
  sleep_wake_all(g);
  for (uint32_t i = 0; i < count; ++i) boundary_particles(*g)[i] = fixed_particle(positions + 3ull * i, i);
  boundary_sort(g, count);
  return accept(reason);
}

// ---- Moving the scene
//
// A scene that is moved rigidly, when the app's coordinates change under it.

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
struct Box {
  float low[3], high[3];
};

Box box_around(const Granular& g, const RigidBody& body, float margin) {
  Box box;
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
    const float* p = g.particles.records[0][g.bodies.rows[slot]].position;
    for (int k = 0; k < 3; ++k) {
      if (slot == body.first || p[k] - margin < box.low[k]) box.low[k] = p[k] - margin;
      if (slot == body.first || p[k] + margin > box.high[k]) box.high[k] = p[k] + margin;
    }
  }
  return box;
}

// What is within reach of that box wakes, and so does the body.
void wake_around(Granular* g, const RigidBody& body) {
  const Box box = box_around(*g, body, neighbours_reach(*g));
  sleep_wake_box(g, box.low, box.high);
  g->neighbours.valid = false;
}

// An awake particle was put somewhere else: it rests anew from there, and no grain follows it.
void went_nowhere(Granular* g, const Particle& p) {
  sleep_begin_rest(&g->sleep, number_of(p), p.position);
  motion_add(g, number_of(p), p.position, p.velocity);
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
    around += 1.0, overlaps = overlaps || distance < k_overlap_radii * r;
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
        if (along - half < way && along + half > way) way = along + half, moved = true;
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
  if (in_body(first))
    for (int k = 0; k < 3; ++k) g->bodies.all[body_of(first) - 1].center[k] += static_cast<double>(shift[k]);
  for (uint32_t i = 0; i < count; ++i) {
    Particle* p = &g->particles.records[0][rows[i]];
    for (int k = 0; k < 3; ++k) p->position[k] += shift[k];
    went_nowhere(g, *p);
  }
}

// What a body is put around is caught between its particles: they push it to and fro for ever, sand at metres a second
// and other bodies at ten times that. It is put beside the body.
void free_caught(Granular* g, const RigidBody& body) {
  const Box box = box_around(*g, body, 0.0f);
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
    if (is_asleep(sand)) sleep_wake_box(g, sand.position, sand.position);
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

bool bodies_has(const Bodies& bodies, uint32_t index) { return index < bodies.count && bodies.all[index].count != 0; }

sandglass_status granular_add_body(Granular* g, const sandglass_body* desc, uint32_t* index, const char** reason) {
  if (desc == nullptr)
    return refuse(reason, "sandglass_granular_add_body: body is NULL: pass a body filled by sandglass_body_default.");
  if (desc->struct_size != sizeof *desc)
    return refuse(
        reason,
        "sandglass_granular_add_body: body.struct_size is not this library's: fill it with sandglass_body_default.");
  if (desc->particle_count == 0)
    return refuse(reason, "sandglass_granular_add_body: body.particle_count is 0: a body needs at least one particle.");
  if (desc->particle_positions == nullptr)
    return refuse(reason,
                  "sandglass_granular_add_body: body.particle_positions is NULL: pass 3 floats for each particle.");
  if (!(desc->density_ratio >= 1e-3f && desc->density_ratio <= 1e3f))
    return refuse(reason, "sandglass_granular_add_body: density_ratio must be 0.001 to 1000.");
  if (!speeds_fit(desc->linear_velocity, desc->angular_velocity))
    return refuse(reason, "sandglass_granular_add_body: a velocity is not finite or above 10000 m/s or rad/s.");
  uint32_t number = 0;
  while (number < g->bodies.count && g->bodies.all[number].count != 0) ++number;
  if (number == g->desc.body_capacity ||
      desc->particle_count > g->desc.body_particle_capacity - g->bodies.particle_count)
    return refuse(reason, SANDGLASS_ERROR_CAPACITY,
                  "sandglass_granular_add_body: more bodies or body particles than granular.body_capacity and "
                  "body_particle_capacity have room for: raise them.");
  const uint32_t first_record = g->particles.count;
  const sandglass_status added =
      granular_add(g, desc->particle_positions, nullptr, desc->particle_count, nullptr, nullptr, 0, reason);
  if (added != SANDGLASS_OK) return added;

  RigidBody& body = g->bodies.all[number];
  body = {};
  body.first = g->bodies.particle_count;
  body.count = desc->particle_count;
  body.rotation[3] = 1.0;
  for (uint32_t i = 0; i < body.count; ++i)
    for (int k = 0; k < 3; ++k) body.center[k] += static_cast<double>(desc->particle_positions[3ull * i + k]);
  for (int k = 0; k < 3; ++k) {
    body.center[k] /= body.count;
    body.linear[k] = desc->linear_velocity[k], body.angular[k] = desc->angular_velocity[k];
  }
  for (uint32_t i = 0; i < body.count; ++i) {
    const uint32_t slot = body.first + i;
    Particle* p = &g->particles.records[0][first_record + i];
    for (int k = 0; k < 3; ++k)
      g->bodies.rest_shape[3ull * slot + k] = static_cast<float>(static_cast<double>(p->position[k]) - body.center[k]);
    g->bodies.rows[slot] = first_record + i;
    g->bodies.numbers[slot] = number_of(*p);
    g->sleep.anchors[number_of(*p)].body_slot = slot;
    join_body(p, number + 1, 1.0f / desc->density_ratio);
  }
  bodies_set_velocities(g, body);
  g->bodies.particle_count += body.count;
  if (desc->density_ratio > g->bodies.densest) g->bodies.densest = desc->density_ratio;
  if (index != nullptr) *index = number;
  if (number == g->bodies.count) ++g->bodies.count;
  free_caught(g, body);
  return SANDGLASS_OK;
}

void bodies_remove(Granular* g, uint32_t index) {
  Bodies& b = g->bodies;
  const RigidBody gone = b.all[index];
  wake_around(g, gone);
  for (uint32_t slot = gone.first; slot < gone.first + gone.count; ++slot) flow_remove_particle(g, b.rows[slot]);
  // The slots behind it close the gap.
  b.particle_count -= gone.count;
  for (uint32_t to = gone.first; to < b.particle_count; ++to) {
    const uint32_t from = to + gone.count;
    for (int k = 0; k < 3; ++k) b.rest_shape[3ull * to + k] = b.rest_shape[3ull * from + k];
    b.rows[to] = b.rows[from], b.numbers[to] = b.numbers[from];
    g->sleep.anchors[b.numbers[to]].body_slot = to;
  }
  b.all[index] = {};
  while (b.count != 0 && b.all[b.count - 1].count == 0) --b.count;
  b.densest = 0.0f;
  for (uint32_t i = 0; i < b.count; ++i) {
    RigidBody& other = b.all[i];
    if (other.count == 0) continue;
    if (other.first > gone.first) other.first -= gone.count;
    const float density = 1.0f / inverse_mass(g->particles.records[0][b.rows[other.first]]);
    if (density > b.densest) b.densest = density;
  }
  g->flow.counts.removed_particles += gone.count;
  ++g->flow.counts.removed_bodies;
  flow_after_removal(g);
}

sandglass_status granular_remove_body(Granular* g, uint32_t index, const char** reason) {
  if (!bodies_has(g->bodies, index))
    return refuse(reason,
                  "sandglass_granular_remove_body: no body has this index: pass that of a body that was added.");
  substep_abandon(g);
  bodies_remove(g, index);
  return accept(reason);
}

sandglass_status granular_set_body(Granular* g, uint32_t index, const sandglass_body_pose* pose, const char** reason) {
  if (pose == nullptr)
    return refuse(reason, "sandglass_granular_set_body: pose is NULL: pass where the body shall be.");
  if (!bodies_has(g->bodies, index))
    return refuse(reason, "sandglass_granular_set_body: no body has this index: pass that of a body that was added.");
  sandglass_collider frame = {}, accepted;
  for (int k = 0; k < 3; ++k) frame.position[k] = pose->position[k];
  for (int k = 0; k < 4; ++k) frame.rotation[k] = pose->rotation[k];
  if (!speeds_fit(pose->linear_velocity, pose->angular_velocity) || !collider_accept(frame, &accepted))
    return refuse(
        reason,
        "sandglass_granular_set_body: a number of the pose is not finite, a velocity is above 10000 m/s or rad/s, or "
        "the rotation has no length.");
  RigidBody placed = g->bodies.all[index];
  double length2 = 0.0;
  for (const float q : pose->rotation) length2 += static_cast<double>(q) * static_cast<double>(q);
  for (int k = 0; k < 4; ++k) placed.rotation[k] = static_cast<double>(pose->rotation[k]) / __builtin_sqrt(length2);
  for (int k = 0; k < 3; ++k) {
    placed.center[k] = static_cast<double>(pose->position[k]);
    placed.linear[k] = pose->linear_velocity[k], placed.angular[k] = pose->angular_velocity[k];
  }
  for (uint32_t slot = placed.first; slot < placed.first + placed.count; ++slot) {
    float at[3];
    bodies_place(g->bodies, placed, slot, at);
    if (!all_within(at, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
      return refuse(reason,
                    "sandglass_granular_set_body: a particle of the body would be more than 1000 m from the scene "
                    "origin: move the origin nearer.");
  }
  substep_abandon(g);
  wake_around(g, placed);  // where its particles still are
  g->bodies.all[index] = placed;
  for (uint32_t slot = placed.first; slot < placed.first + placed.count; ++slot)
    bodies_place(g->bodies, placed, slot, g->particles.records[0][g->bodies.rows[slot]].position);
  bodies_set_velocities(g, placed);
  for (uint32_t slot = placed.first; slot < placed.first + placed.count; ++slot)
    went_nowhere(g, g->particles.records[0][g->bodies.rows[slot]]);
  wake_around(g, placed);
  free_caught(g, placed);
  sweep_particles_changed(g);
  return accept(reason);
}

sandglass_status granular_push_body(Granular* g, uint32_t index, const float impulse[3], const float* point,
                                    const char** reason) {
  if (impulse == nullptr)
    return refuse(reason, "sandglass_granular_push_body: impulse is NULL: pass its x, y and z in m/s.");
  if (!bodies_has(g->bodies, index))
    return refuse(reason, "sandglass_granular_push_body: no body has this index: pass that of a body that was added.");
  if (!all_finite(impulse, 3) ||
      (point != nullptr && !all_within(point, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT)))
    return refuse(reason,
                  "sandglass_granular_push_body: impulse or point is not finite, or the point is more than 1000 m from "
                  "the scene origin.");
  RigidBody& body = g->bodies.all[index];
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
    return refuse(
        reason,
        "sandglass_granular_push_body: the body would be faster than 10000 m/s or rad/s along an axis: push it "
        "less, or nearer to its centre.");
  substep_abandon(g);  // which may end a sub-step: then the body has new velocities
  add_push();
  for (int k = 0; k < 3; ++k) body.linear[k] = linear[k], body.angular[k] = angular[k];
  wake_around(g, body);
  bodies_set_velocities(g, body);
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
