// Rigid bodies: the motion that fits what the contacts did to their particles.
#include "runtime/math/finite.h"
#include "runtime/math/rotation.h"
#include "runtime/sand/granular.h"

namespace sandglass {

namespace {

Vector rest_of(const Bodies& bodies, uint32_t slot) { return to_vector(bodies.rest_shape + 3ull * slot); }

// The spread of the turned body.
void turn_spread(const double q[4], double spread[9]) {
  for (int pass = 0; pass < 2; ++pass) {  // R S, then R (R S)^T = R S R^T, for S is symmetric
    double next[9];
    for (int j = 0; j < 3; ++j) {
      const Vector column = rotated(q, {spread[j], spread[3 + j], spread[6 + j]});
      next[3 * j] = column.x;  // transposed
      next[3 * j + 1] = column.y;
      next[3 * j + 2] = column.z;
    }
    for (int i = 0; i < 9; ++i) spread[i] = next[i];
  }
}

// The rigid motion of the sub-step from the sums.
void match(BodyMatch* own, const Granular& g, RigidBody* body, FrameCounts* counts) {
  BodyMatch& m = *own;
  const double n = body->count, identity[4] = {0, 0, 0, 1}, dt = static_cast<double>(g.substep.length);
  bool sound = true;
  for (int k = 0; k < 3; ++k) {
    m.shift[k] /= n;
    m.stabilised[k] /= n;
    sound = sound && is_finite(m.shift[k]) && is_finite(m.spin[k]) &&
            __builtin_fabs(body->center[k] + m.shift[k]) < 0.75 * static_cast<double>(k_coordinate_bound);
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      m.a[3 * i + j] -= m.shift[i] * m.offset[j];
      sound = sound && is_finite(m.a[3 * i + j]);
    }
  if (!sound) {  // the body stays where it was, at rest
    counts->quarantined += body->count;
    for (int k = 0; k < 3; ++k) m.shift[k] = m.stabilised[k] = m.spin[k] = 0.0;
  }
  for (int k = 0; k < 4; ++k) m.turn[k] = identity[k];
  if (sound) nearest_rotation(m.a, identity, m.turn);

  double q[4], w[3];
  multiply(m.turn, body->rotation, q);
  const double length = __builtin_sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (int k = 0; k < 4; ++k) body->rotation[k] = q[k] / length;
  turn_spread(m.turn, m.spread);
  angular_velocity(m.spread, m.spin, w);
  for (int k = 0; k < 3; ++k) {
    body->center[k] += m.shift[k];
    body->linear[k] = static_cast<float>((m.shift[k] - m.stabilised[k]) / dt);
    body->angular[k] = static_cast<float>(w[k] / dt);
  }
}

void accumulate(BodyMatch* own, const Granular& g, uint32_t slot) {
  BodyMatch& m = *own;
  const Particle& next = g.particles.records[1][g.bodies.rows[slot]];
  const Particle& now = g.particles.records[0][g.bodies.rows[slot]];
  const RigidBody& body = g.bodies.all[g.bodies.cursor];
  const Vector r = rotated(body.rotation, rest_of(g.bodies, slot));
  const double offset[3] = {r.x, r.y, r.z}, dt = static_cast<double>(g.substep.length);
  double moved[3], carried[3];
  for (int k = 0; k < 3; ++k) {
    const double displacement = static_cast<double>(next.velocity[k]) * dt;
    double stabilised = 0.0;  // the stabilisation moved the start position by this: it changes no velocity
    if (g.desc.reference.stabilisation_iterations != 0)
      stabilised = static_cast<double>(next.position[k]) - static_cast<double>(now.position[k]) - displacement;
    carried[k] = displacement;
    moved[k] = displacement + stabilised;
    m.shift[k] += moved[k];
    m.stabilised[k] += stabilised;
    m.offset[k] += offset[k];
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      m.a[3 * i + j] += (offset[i] + moved[i]) * offset[j];
      m.spread[3 * i + j] += offset[i] * offset[j];
    }
  const Vector spin = cross(r, {carried[0], carried[1], carried[2]});
  m.spin[0] += spin.x;
  m.spin[1] += spin.y;
  m.spin[2] += spin.z;
}

void apply(ContactExtent* own, const Granular& g, uint32_t slot) {
  const BodyMatch& m = g.bodies.match;
  const RigidBody& body = g.bodies.all[g.bodies.cursor];
  Particle* next = &g.particles.records[1][g.bodies.rows[slot]];
  float *position = next->position, *velocity = next->velocity;
  const Vector now = rotated(body.rotation, rest_of(g.bodies, slot));
  const double back[4] = {-m.turn[0], -m.turn[1], -m.turn[2], m.turn[3]};
  const Vector turned = turned_by(back, now);  // the turn of this sub-step, backward
  const Vector spun = cross(to_vector(body.angular), now);
  const double offset[3] = {now.x, now.y, now.z}, turn[3] = {-turned.x, -turned.y, -turned.z};
  const double spin[3] = {spun.x, spun.y, spun.z};
  ContactExtent& e = *own;
  float speed2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const double displacement = m.shift[k] + turn[k];
    position[k] = static_cast<float>(body.center[k] + offset[k]);
    velocity[k] = body.linear[k] + static_cast<float>(spin[k]);
    if (has_departed(*next)) continue;
    const float moved = static_cast<float>(displacement);
    e.displacement_low[k] = moved < e.displacement_low[k] ? moved : e.displacement_low[k];
    e.displacement_high[k] = moved > e.displacement_high[k] ? moved : e.displacement_high[k];
    e.low[k] = position[k] < e.low[k] ? position[k] : e.low[k];
    e.high[k] = position[k] > e.high[k] ? position[k] : e.high[k];
    speed2 += velocity[k] * velocity[k];
  }
  e.speed_squared = speed2 > e.speed_squared ? speed2 : e.speed_squared;
}

}  // namespace

void bodies_layout(Bodies* b, const sandglass_granular_desc& d, Layout* layout) {
  b->all = layout_region<RigidBody>(layout, "granular.bodies", d.body_capacity);
  b->rest_shape = layout_region<float>(layout, "granular.body_rest", 3ull * d.body_particle_capacity);
  b->rows = layout_region<uint32_t>(layout, "granular.body_rows", d.body_particle_capacity);
  b->numbers = layout_region<uint32_t>(layout, "granular.body_numbers", d.body_particle_capacity);
  b->inside = layout_region<uint32_t>(layout, "granular.bodies_inside", d.body_capacity);
}

void bodies_reset(Bodies* b) {
  b->count = b->particle_count = 0;
  b->densest = 0.0f;
}

void bodies_restore(Bodies* b, const SavedScene& s) {
  b->count = s.bodies;
  b->particle_count = s.body_particles;
  b->densest = s.state.densest_body;
}

bool bodies_has(const Bodies& b, uint32_t index) { return index < b.count && b.all[index].count != 0; }

// A body sleeps and wakes as a whole: its first particle tells.
bool bodies_awake(const Granular& g, const RigidBody& body) {
  return body.count != 0 && is_awake(g.particles.records[0][g.bodies.rows[body.first]]);
}

void bodies_note_row(const Granular& g, uint32_t index) {
  const uint32_t number = number_of(g.particles.records[0][index]);
  g.bodies.rows[g.sleep.anchors[number].body_slot] = index;
}

void bodies_find_rows(const Granular& g) {
  for (uint32_t i = 0; g.bodies.count != 0 && i < g.particles.count; ++i) {
    if (in_body(g.particles.records[0][i])) bodies_note_row(g, i);
  }
}

bool bodies_begin(Bodies* b, const Granular& g) {
  if (b->count == 0) return false;
  b->cursor = b->particle = 0;
  b->moves = false;
  b->match = {};
  b->extent = k_extent_of_none;
  while (b->cursor < b->count && !bodies_awake(g, b->all[b->cursor])) ++b->cursor;
  return b->cursor < b->count;
}

uint32_t bodies_items(const Granular& g) {
  const uint32_t left = 2 * g.bodies.all[g.bodies.cursor].count -
                        (g.bodies.moves ? g.bodies.all[g.bodies.cursor].count : 0) - g.bodies.particle;
  return left < g.unit ? left : g.unit;
}

bool bodies_run(Bodies* b, const Granular& g, FrameCounts* counts) {
  for (uint32_t done = 0; done < g.unit && b->cursor < b->count; ++done) {
    RigidBody& body = b->all[b->cursor];
    if (b->moves) apply(&b->extent, g, body.first + b->particle);
    else accumulate(&b->match, g, body.first + b->particle);
    if (++b->particle < body.count) continue;
    b->particle = 0;
    if (!b->moves) {
      match(&b->match, g, &body, counts);
      b->moves = true;
      continue;
    }
    b->moves = false;
    b->match = {};
    do ++b->cursor;
    while (b->cursor < b->count && !bodies_awake(g, b->all[b->cursor]));
  }
  return b->cursor == b->count;
}

void bodies_begin_drain(const Bodies& b) {
  for (uint32_t index = 0; index < b.count; ++index) b.inside[index] = 0;
}

void bodies_note_inside(const Bodies& b, uint32_t index) { ++b.inside[index]; }

bool bodies_all_inside(const Bodies& b, uint32_t index) {
  return b.all[index].count != 0 && b.inside[index] == b.all[index].count;
}

void bodies_stop(Bodies* b, uint32_t index) {
  for (int k = 0; k < 3; ++k) b->all[index].linear[k] = b->all[index].angular[k] = 0.0f;
}

uint32_t bodies_free_number(const Bodies& b, uint32_t capacity) {
  uint32_t number = 0;
  while (number < b.count && b.all[number].count != 0) ++number;
  return number < capacity ? number : capacity;
}

void bodies_add(Bodies* b, const Granular& g, uint32_t number, const sandglass_body& desc, uint32_t first_row) {
  RigidBody& body = b->all[number];
  body = {};
  body.first = b->particle_count;
  body.count = desc.particle_count;
  body.rotation[3] = 1.0;
  for (uint32_t i = 0; i < body.count; ++i)
    for (int k = 0; k < 3; ++k) body.center[k] += static_cast<double>(desc.particle_positions[3ull * i + k]);
  for (int k = 0; k < 3; ++k) {
    body.center[k] /= body.count;
    body.linear[k] = desc.linear_velocity[k];
    body.angular[k] = desc.angular_velocity[k];
  }
  for (uint32_t i = 0; i < body.count; ++i) {
    const uint32_t slot = body.first + i;
    const Particle& p = g.particles.records[0][first_row + i];
    for (int k = 0; k < 3; ++k)
      b->rest_shape[3ull * slot + k] = static_cast<float>(static_cast<double>(p.position[k]) - body.center[k]);
    b->rows[slot] = first_row + i;
    b->numbers[slot] = number_of(p);
  }
  b->particle_count += body.count;
  if (desc.density_ratio > b->densest) b->densest = desc.density_ratio;
  if (number == b->count) ++b->count;
}

void bodies_remove(Bodies* b, const Granular& g, uint32_t index) {
  const RigidBody removed = b->all[index];
  // The slots behind it close the gap.
  b->particle_count -= removed.count;
  for (uint32_t to = removed.first; to < b->particle_count; ++to) {
    const uint32_t from = to + removed.count;
    for (int k = 0; k < 3; ++k) b->rest_shape[3ull * to + k] = b->rest_shape[3ull * from + k];
    b->rows[to] = b->rows[from];
    b->numbers[to] = b->numbers[from];
  }
  b->all[index] = {};
  while (b->count != 0 && b->all[b->count - 1].count == 0) --b->count;
  b->densest = 0.0f;
  for (uint32_t i = 0; i < b->count; ++i) {
    RigidBody& other = b->all[i];
    if (other.count == 0) continue;
    if (other.first > removed.first) other.first -= removed.count;
    const float density = 1.0f / inverse_mass(g.particles.records[0][b->rows[other.first]]);
    if (density > b->densest) b->densest = density;
  }
}

void bodies_set(Bodies* b, uint32_t index, const RigidBody& changed) { b->all[index] = changed; }

void bodies_place(const Bodies& bodies, const RigidBody& body, uint32_t slot, float position[3]) {
  const Vector r = rotated(body.rotation, rest_of(bodies, slot));
  const double offset[3] = {r.x, r.y, r.z};
  for (int k = 0; k < 3; ++k) position[k] = static_cast<float>(body.center[k] + offset[k]);
}

void bodies_spread_velocities(const Granular& g, const RigidBody& body) {
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
    Particle* p = &g.particles.records[0][g.bodies.rows[slot]];
    const Vector turning = cross(to_vector(body.angular), rotated(body.rotation, rest_of(g.bodies, slot)));
    p->velocity[0] = body.linear[0] + static_cast<float>(turning.x);
    p->velocity[1] = body.linear[1] + static_cast<float>(turning.y);
    p->velocity[2] = body.linear[2] + static_cast<float>(turning.z);
  }
}

static void move_body(RigidBody* moved, const double rotation[4], const float shift[3]) {
  RigidBody& body = *moved;
  if (body.count == 0) return;
  const Vector c = rotated(rotation, {body.center[0], body.center[1], body.center[2]});
  const Vector v = rotated(rotation, to_vector(body.linear)), w = rotated(rotation, to_vector(body.angular));
  const double center[3] = {c.x, c.y, c.z}, linear[3] = {v.x, v.y, v.z}, angular[3] = {w.x, w.y, w.z};
  double q[4];
  multiply(rotation, body.rotation, q);
  for (int k = 0; k < 4; ++k) body.rotation[k] = q[k];
  for (int k = 0; k < 3; ++k) {
    body.center[k] = center[k] + static_cast<double>(shift[k]);
    body.linear[k] = static_cast<float>(linear[k]);
    body.angular[k] = static_cast<float>(angular[k]);
  }
}

void bodies_carry(const Granular& g, uint32_t index, const RigidMotion& motion, const float faster[3]) {
  RigidBody& body = g.bodies.all[index];
  const double straight[4] = {0, 0, 0, 1};
  float center[3];
  double a[9], turn[4], turned[4], length2 = 0.0;
  for (int k = 0; k < 3; ++k) center[k] = static_cast<float>(body.center[k]);
  const Quad u = motion.displacement(quad(center));
  for (int i = 0; i < 9; ++i) a[i] = static_cast<double>(motion.turn[i % 3][i / 3]) + (i % 4 == 0 ? 1.0 : 0.0);
  nearest_rotation(a, straight, turn);
  multiply(turn, body.rotation, turned);
  for (const double q : turned) length2 += q * q;
  for (int k = 0; k < 4; ++k) body.rotation[k] = turned[k] / __builtin_sqrt(length2);
  motion.rotate(body.linear);
  motion.rotate(body.angular);
  const bool awake = bodies_awake(g, body);
  for (int k = 0; k < 3; ++k) {
    body.center[k] += static_cast<double>(u[k]);
    body.linear[k] += awake ? faster[k] : 0.0f;
  }
}

void bodies_move(Bodies* b, const SceneMove& move) {
  for (uint32_t index = 0; index < b->count; ++index) move_body(&b->all[index], move.rotation, move.shift);
}

}  // namespace sandglass
