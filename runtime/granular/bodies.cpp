#include "runtime/granular/bodies.h"

#include "runtime/core/finite.h"
#include "runtime/core/refuse.h"
#include "runtime/granular/granular.h"
#include "runtime/granular/rotation.h"

namespace sandglass {

namespace {

struct Vector {
  double x, y, z;
};

Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// (R - 1) r for the rotation by q: exact to the last bits of small turns.
Vector turned_by(const double q[4], const Vector& r) {
  const Vector v = {q[0], q[1], q[2]};
  const Vector t = cross(v, r);
  const Vector u = cross(v, {t.x + q[3] * r.x, t.y + q[3] * r.y, t.z + q[3] * r.z});
  return {2.0 * u.x, 2.0 * u.y, 2.0 * u.z};
}

Vector rotated(const double q[4], const Vector& r) {
  const Vector t = turned_by(q, r);
  return {r.x + t.x, r.y + t.y, r.z + t.z};
}

Vector rest_of(const Bodies& bodies, uint32_t slot) {
  const float* p = bodies.rest_shape + 3ull * slot;
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

// A body sleeps and wakes as a whole: its first particle tells.
bool awake(const Granular& g, const RigidBody& body) {
  return is_awake(g.particles.records[0][g.bodies.rows[body.first]]);
}

// The w with (tr(S) - S) w = l, for the spread S = sum of r r^T. A straight body has no inertia about its own axis. A
// billionth more of the trace on the diagonal keeps the equation solvable, and no spin comes out about that axis,
// because none went in.
void angular_velocity(const double spread[9], const double l[3], double w[3]) {
  const double trace = spread[0] + spread[4] + spread[8];
  double m[9];
  for (int i = 0; i < 9; ++i) m[i] = -spread[i];
  for (int i = 0; i < 9; i += 4) m[i] += trace * (1.0 + 1e-9);
  const double c[3] = {m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6]};
  const double det = m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
  w[0] = w[1] = w[2] = 0.0;
  if (!(det > 1e-300)) return;  // a point
  const double inverse[9] = {c[0], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
                             c[1], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
                             c[2], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) w[i] += inverse[3 * i + j] * l[j] / det;
}

void multiply(const double t[4], const double r[4], double q[4]) {
  q[0] = t[3] * r[0] + t[0] * r[3] + t[1] * r[2] - t[2] * r[1];
  q[1] = t[3] * r[1] + t[1] * r[3] + t[2] * r[0] - t[0] * r[2];
  q[2] = t[3] * r[2] + t[2] * r[3] + t[0] * r[1] - t[1] * r[0];
  q[3] = t[3] * r[3] - t[0] * r[0] - t[1] * r[1] - t[2] * r[2];
}

// The spread of the turned body.
void turn_spread(const double q[4], double spread[9]) {
  for (int pass = 0; pass < 2; ++pass) {  // R S, then R (R S)^T = R S R^T, for S is symmetric
    double next[9];
    for (int j = 0; j < 3; ++j) {
      const Vector column = rotated(q, {spread[j], spread[3 + j], spread[6 + j]});
      next[3 * j] = column.x, next[3 * j + 1] = column.y, next[3 * j + 2] = column.z;  // transposed
    }
    for (int i = 0; i < 9; ++i) spread[i] = next[i];
  }
}

// The rigid motion of the sub-step from the sums.
void match(Granular* g, RigidBody* body) {
  BodyMatch& m = g->bodies.match;
  const double n = body->count, identity[4] = {0, 0, 0, 1}, dt = static_cast<double>(g->substep.length);
  bool sound = true;
  for (int k = 0; k < 3; ++k) {
    m.shift[k] /= n, m.stabilised[k] /= n;
    sound = sound && is_finite(m.shift[k]) && is_finite(m.spin[k]) &&
            __builtin_fabs(body->center[k] + m.shift[k]) < 0.75 * static_cast<double>(k_coordinate_bound);
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m.a[3 * i + j] -= m.shift[i] * m.offset[j], sound = sound && is_finite(m.a[3 * i + j]);
  if (!sound) {  // the body stays where it was, at rest
    g->counts.quarantined += body->count;
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

void accumulate(Granular* g, uint32_t slot) {
  BodyMatch& m = g->bodies.match;
  const Particle& next = g->particles.records[1][g->bodies.rows[slot]];
  const Particle& now = g->particles.records[0][g->bodies.rows[slot]];
  const RigidBody& body = g->bodies.all[g->bodies.cursor];
  const Vector r = rotated(body.rotation, rest_of(g->bodies, slot));
  const double offset[3] = {r.x, r.y, r.z}, dt = static_cast<double>(g->substep.length);
  double moved[3], carried[3];
  for (int k = 0; k < 3; ++k) {
    const double displacement = static_cast<double>(next.velocity[k]) * dt;
    double stabilised = 0.0;  // the stabilisation moved the start position by this: it changes no velocity
    if (g->desc.reference.stabilisation_iterations != 0)
      stabilised = static_cast<double>(next.position[k]) - static_cast<double>(now.position[k]) - displacement;
    carried[k] = displacement;
    moved[k] = displacement + stabilised;
    m.shift[k] += moved[k], m.stabilised[k] += stabilised, m.offset[k] += offset[k];
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      m.a[3 * i + j] += (offset[i] + moved[i]) * offset[j];
      m.spread[3 * i + j] += offset[i] * offset[j];
    }
  const Vector spin = cross(r, {carried[0], carried[1], carried[2]});
  m.spin[0] += spin.x, m.spin[1] += spin.y, m.spin[2] += spin.z;
}

void apply(Granular* g, uint32_t slot) {
  const BodyMatch& m = g->bodies.match;
  const RigidBody& body = g->bodies.all[g->bodies.cursor];
  Particle* next = &g->particles.records[1][g->bodies.rows[slot]];
  float *position = next->position, *velocity = next->velocity;
  const Vector now = rotated(body.rotation, rest_of(g->bodies, slot));
  const double back[4] = {-m.turn[0], -m.turn[1], -m.turn[2], m.turn[3]};
  const Vector turned = turned_by(back, now);  // the turn of this sub-step, backward
  const Vector spun = cross({static_cast<double>(body.angular[0]), static_cast<double>(body.angular[1]),
                             static_cast<double>(body.angular[2])},
                            now);
  const double offset[3] = {now.x, now.y, now.z}, turn[3] = {-turned.x, -turned.y, -turned.z};
  const double spin[3] = {spun.x, spun.y, spun.z};
  ContactExtent& e = g->substep.extent;
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
}

void bodies_reset(Bodies* b) {
  b->count = b->particle_count = 0;
  b->densest = 0.0f;
}

void bodies_note_row(Granular* g, uint32_t index) {
  const uint32_t number = number_of(g->particles.records[0][index]);
  g->bodies.rows[g->sleep.anchors[number].body_slot] = index;
}

void bodies_find_rows(Granular* g) {
  for (uint32_t i = 0; g->bodies.count != 0 && i < g->particles.count; ++i) {
    if (in_body(g->particles.records[0][i])) bodies_note_row(g, i);
  }
}

bool bodies_begin(Granular* g) {
  if (g->bodies.count == 0) return false;
  g->bodies.cursor = g->bodies.particle = 0;
  g->bodies.moves = false;
  g->bodies.match = {};
  while (g->bodies.cursor < g->bodies.count && !awake(*g, g->bodies.all[g->bodies.cursor])) ++g->bodies.cursor;
  return g->bodies.cursor < g->bodies.count;
}

uint32_t bodies_items(const Granular& g) {
  const uint32_t left = 2 * g.bodies.all[g.bodies.cursor].count -
                        (g.bodies.moves ? g.bodies.all[g.bodies.cursor].count : 0) - g.bodies.particle;
  return left < g.unit ? left : g.unit;
}

bool bodies_run(Granular* g) {
  for (uint32_t done = 0; done < g->unit && g->bodies.cursor < g->bodies.count; ++done) {
    RigidBody& body = g->bodies.all[g->bodies.cursor];
    if (g->bodies.moves) apply(g, body.first + g->bodies.particle);
    else accumulate(g, body.first + g->bodies.particle);
    if (++g->bodies.particle < body.count) continue;
    g->bodies.particle = 0;
    if (!g->bodies.moves) {
      match(g, &body);
      g->bodies.moves = true;
      continue;
    }
    g->bodies.moves = false;
    g->bodies.match = {};
    do ++g->bodies.cursor;
    while (g->bodies.cursor < g->bodies.count && !awake(*g, g->bodies.all[g->bodies.cursor]));
  }
  return g->bodies.cursor == g->bodies.count;
}

void bodies_put_to_sleep(Granular* g, uint32_t patience) {
  for (uint32_t b = 0; b < g->bodies.count; ++b) {
    const RigidBody& body = g->bodies.all[b];
    if (!awake(*g, body)) continue;
    bool quiet = true, touches = false;
    for (uint32_t slot = body.first; slot < body.first + body.count; ++slot)
      quiet = quiet && g->sleep.anchors[g->bodies.numbers[slot]].quiet >= patience;
    for (uint32_t slot = body.first; quiet && !touches && slot < body.first + body.count; ++slot)
      touches = sleep_may_rest(g, g->bodies.rows[slot]);
    quiet = quiet && touches;
    for (uint32_t slot = body.first; quiet && slot < body.first + body.count; ++slot)
      sleep_put_one(g, g->bodies.rows[slot]);
    if (!quiet) continue;
    for (int k = 0; k < 3; ++k) g->bodies.all[b].linear[k] = g->bodies.all[b].angular[k] = 0.0f;
  }
}

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
  for (int k = 0; k < 3; ++k) {
    if (!(__builtin_fabsf(desc->linear_velocity[k]) <= 1e4f && __builtin_fabsf(desc->angular_velocity[k]) <= 1e4f))
      return refuse(reason, "sandglass_granular_add_body: a velocity is not finite or above 10000 m/s or rad/s.");
  }
  if (g->bodies.count == g->desc.body_capacity ||
      desc->particle_count > g->desc.body_particle_capacity - g->bodies.particle_count)
    return refuse(reason, SANDGLASS_ERROR_CAPACITY,
                  "sandglass_granular_add_body: more bodies or body particles than granular.body_capacity and "
                  "body_particle_capacity have room for: raise them.");
  const uint32_t first_record = g->particles.count;
  const sandglass_status added =
      granular_add(g, desc->particle_positions, nullptr, desc->particle_count, nullptr, nullptr, 0, reason);
  if (added != SANDGLASS_OK) return added;

  RigidBody& body = g->bodies.all[g->bodies.count];
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
  const Vector spin = {static_cast<double>(body.angular[0]), static_cast<double>(body.angular[1]),
                       static_cast<double>(body.angular[2])};
  float speed2_most = 0.0f;
  for (uint32_t i = 0; i < body.count; ++i) {
    const uint32_t slot = body.first + i;
    Particle* p = &g->particles.records[0][first_record + i];
    for (int k = 0; k < 3; ++k)
      g->bodies.rest_shape[3ull * slot + k] = static_cast<float>(static_cast<double>(p->position[k]) - body.center[k]);
    g->bodies.rows[slot] = first_record + i;
    g->bodies.numbers[slot] = number_of(*p);
    g->sleep.anchors[number_of(*p)].body_slot = slot;
    join_body(p, g->bodies.count + 1, 1.0f / desc->density_ratio);
    const Vector turning = cross(spin, rest_of(g->bodies, slot));
    float* v = p->velocity;
    v[0] = body.linear[0] + static_cast<float>(turning.x);
    v[1] = body.linear[1] + static_cast<float>(turning.y);
    v[2] = body.linear[2] + static_cast<float>(turning.z);
    const float speed2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    speed2_most = speed2 > speed2_most ? speed2 : speed2_most;
  }
  const float speed = __builtin_sqrtf(speed2_most);
  g->particles.speed_max = speed > g->particles.speed_max ? speed : g->particles.speed_max;
  g->bodies.particle_count += body.count;
  if (desc->density_ratio > g->bodies.densest) g->bodies.densest = desc->density_ratio;
  if (index != nullptr) *index = g->bodies.count;
  ++g->bodies.count;
  return SANDGLASS_OK;
}

void bodies_place(const Bodies& bodies, const RigidBody& body, uint32_t slot, float position[3]) {
  const Vector r = rotated(body.rotation, rest_of(bodies, slot));
  const double offset[3] = {r.x, r.y, r.z};
  for (int k = 0; k < 3; ++k) position[k] = static_cast<float>(body.center[k] + offset[k]);
}

void bodies_move(Bodies* bodies, uint32_t index, const double rotation[4], const float shift[3]) {
  RigidBody& body = bodies->all[index];
  const Vector c = rotated(rotation, {body.center[0], body.center[1], body.center[2]});
  const Vector v = rotated(rotation, {static_cast<double>(body.linear[0]), static_cast<double>(body.linear[1]),
                                      static_cast<double>(body.linear[2])});
  const Vector w = rotated(rotation, {static_cast<double>(body.angular[0]), static_cast<double>(body.angular[1]),
                                      static_cast<double>(body.angular[2])});
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
