// Who rests: which particles sleep, and what wakes them. solver.h has the rules.
#include "kernels/whole.h"
#include "runtime/math/finite.h"
#include "runtime/math/rotation.h"
#include "runtime/sand/granular.h"

namespace sandglass {

namespace {

constexpr float k_rest_radii = 0.1f;  // moving further than this is moving on
// Metres; below it the distance shrinks with the root of the radius, as the speed does at which sand creeps in a corner.
constexpr float k_rest_radius = 0.01f;
// As k_rest_radii, for a rigid body. Friction holds the particles that touch, not the others, so on a slope a body
// creeps by some 2 g dt sin(slope), for ever.
constexpr float k_body_rest_radii = 0.3f;
// What flies stays within h of one place for at most (1 + sqrt 2) sqrt(2 h / g): it passes there, turns h above, and is h
// below soon after. So in a time t it moves on by more than 0.0858 g t^2, however large it is.
constexpr float k_flight_share = 0.08f;
// One check finds a particle that turned in the air where it was 20 ms ago.
constexpr uint32_t k_checks_min = 2;
constexpr float k_touch_gap_radii = 0.1f;   // what is nearer is touched
constexpr float k_wake_speed_units = 0.1f;  // of sqrt(g d)
// Jammed particles, under a heavy body say, tremble faster than the wake speed, but stay within a hundredth of a
// radius.
constexpr float k_stir_radii = 0.05f;

// A carrier is slow where it moves on less than this within sleep_after, in units of what counts as moving on. What is
// carried faster wakes its neighbours by moving on.
constexpr float k_slow_carrier = 3.0f;
constexpr uint8_t k_carried_contacts = 40;  // contacts from the carrier that are kept awake: more than piles are high

// A particle that stands on the top of a single other one tips, but slowly at first: a lattice of 2 r moves on after
// 1.5 s if r is 3 mm, after 2.8 s if r is 1 cm. It is kept awake for twice that, in units of r / sqrt(g d), and not for
// ever, because friction may hold it.
constexpr float k_tipping_units = 243.0f;
constexpr uint16_t k_balanced = 0x8000;  // the bit of Anchor::quiet of what was found so since it moved on
constexpr uint16_t k_look = 0x4000;      // and of what is beside that, and is looked at anew
// A particle that was woken so often at one place falls asleep in the same check as what it touches. Otherwise a
// sleeper is hard, a particle that is pressed into it jumps and wakes it again, for ever.
constexpr uint8_t k_woken_often = 8;
constexpr uint32_t k_touched_max = 16;  // more cannot touch a sphere
constexpr float k_support = 0.3f;       // what is lower by so much of the distance bears
constexpr float k_upright = 0.998f;     // and what bears alone, straight below to 3.6 degrees
constexpr float k_free_aside = 0.05f;   // what is nearer than that along a direction, of the distance, stops it

Particle* particle_at(const Granular& g, uint32_t i) { return &g.particles.records[0][i]; }

void drop_anchor(Anchor* anchor, const float position[3]) {
  for (int k = 0; k < 3; ++k) anchor->position[k] = position[k];
  anchor->quiet = 0;
}

// The particle moves on, and with it all of its body: else its particles would never be quiet at one time.
void move_on(Sleep* sleep, const Granular& g, const Particle& p) {
  drop_anchor(&sleep->anchors[number_of(p)], p.position);
  sleep->anchors[number_of(p)].woken = 0;
  if (!in_body(p)) return;
  const RigidBody& body = g.bodies.all[body_of(p) - 1];
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot)
    drop_anchor(&sleep->anchors[g.bodies.numbers[slot]], particle_at(g, g.bodies.rows[slot])->position);
}

float dot(const FloatVector& a, const FloatVector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

float distance_squared(const float a[3], const float b[3]) { return square_of(quad(a) - quad(b)); }

// Squared distance from where the particle last moved on or woke.
float moved2(const Sleep& sleep, const Particle& p) {
  return distance_squared(p.position, sleep.anchors[number_of(p)].position);
}

// Particle i, whose state is awake already, counts as awake from now on.
void begin_waking_one(Sleep* sleep, const Granular& g, uint32_t i) {
  const Particle& p = *particle_at(g, i);
  Anchor& anchor = sleep->anchors[number_of(p)];
  drop_anchor(&anchor, p.position);
  if (anchor.woken < k_woken_often) ++anchor.woken;
  ++sleep->awake_count;
  GroupState& state = sleep->group_states[i / k_lane_group];
  if (state != GroupState::asleep) return;
  state = GroupState::waking;
  ++sleep->waking_count;
}

// The same, with the rest of its body.
void begin_waking(Sleep* sleep, const Granular& g, uint32_t i) {
  begin_waking_one(sleep, g, i);
  const Particle& woken = *particle_at(g, i);
  if (!in_body(woken)) return;
  const RigidBody& body = g.bodies.all[body_of(woken) - 1];
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
    Particle* p = particle_at(g, g.bodies.rows[slot]);
    if (!is_asleep(*p)) continue;
    wake(p);
    begin_waking_one(sleep, g, g.bodies.rows[slot]);
  }
}

void wake_if_asleep(Sleep* sleep, const Granular& g, uint32_t i) {
  Particle* p = particle_at(g, i);
  if (!is_asleep(*p)) return;
  wake(p);
  begin_waking(sleep, g, i);
}

void wake_neighbours(Sleep* sleep, const Granular& g, uint32_t i) {
  uint32_t count;
  const uint32_t* row = neighbours_of(g, i, &count);
  for (uint32_t s = 0; s < count; ++s) {
    if (row[s] < g.particles.count) wake_if_asleep(sleep, g, row[s]);
  }
}

// A group in which all sleep leaves the passes, which swap the arrays: every array must hold it.
void leave_if_asleep(Sleep* sleep, const Granular& g, uint32_t group) {
  for (uint32_t i = group * k_lane_group; i < (group + 1) * k_lane_group; ++i)
    if (is_awake(*particle_at(g, i))) return;
  sleep->group_states[group] = GroupState::asleep;
  particles_copy_to_all(g.particles, group * k_lane_group, k_lane_group);
}

void fall_asleep(Sleep* sleep, const Granular& g, uint32_t i) {
  Particle* p = particle_at(g, i);
  put_to_sleep(p);
  bounds_include(&sleep->resting, p->position);
  sleep->anchors[number_of(*p)].quiet = k_asleep;
  --sleep->awake_count;
}

// What is farther from where it was has moved on, metres.
float rest_limit(const Granular& g, float radii) {
  const float r = g.desc.particle_radius, time = g.desc.sleep_after;
  const float limit = radii * __builtin_sqrtf(r * (r > k_rest_radius ? r : k_rest_radius));
  const float flight = k_flight_share * g.gravity_length * time * time;
  return g.gravity_length > 0.0f && flight < limit ? flight : limit;
}

// Marks what a slow carrier touches.
void find_carried(Sleep* sleep, const Granular& g, uint32_t group) {
  const float r = g.desc.particle_radius;
  const float slow = k_slow_carrier * rest_limit(g, k_rest_radii) / g.desc.sleep_after;
  for (uint32_t c = 0; c < g.colliders.substep_count; ++c) {
    const ColliderFrame& carrier = g.colliders.substep_frames[c];
    const float *v = carrier.linear, *w = carrier.angular;
    const float v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], w2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    if (w2 == 0.0f && (v2 == 0.0f || v2 > slow * slow)) continue;
    alignas(SANDGLASS_BLOCK_ALIGNMENT) SurfacePoint points[k_lane_group] = {};
    const Particle* p = particle_at(g, group * k_lane_group);
    for (uint32_t l = 0; l < k_lane_group; ++l)
      for (int k = 0; k < 3; ++k) points[l].position[k] = p[l].position[k];
    const SurfaceArgs args = {points, &carrier};
    uint32_t unused = 0;
    g.kernels->surface_at(&args, 0, k_lane_group, &unused);
    for (uint32_t l = 0; l < k_lane_group; ++l) {
      if (!is_awake(p[l]) || points[l].distance > (1.0f + k_touch_gap_radii) * r) continue;
      float at[3];
      for (int k = 0; k < 3; ++k) at[k] = p[l].position[k] - carrier.position[k];
      const float u[3] = {v[0] + w[1] * at[2] - w[2] * at[1], v[1] + w[2] * at[0] - w[0] * at[2],
                          v[2] + w[0] * at[1] - w[1] * at[0]};
      const float u2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
      if (u2 > 0.0f && u2 <= slow * slow) sleep->anchors[number_of(p[l])].carried = k_carried_contacts;
    }
  }
}

// What a carried particle touches is carried too, up to so many contacts from the carrier, and wakes.
void carry_neighbours(Sleep* sleep, const Granular& g, uint32_t i, uint8_t carried) {
  uint32_t count;
  const uint32_t* row = neighbours_of(g, i, &count);
  const float near = (2.0f + k_touch_gap_radii) * g.desc.particle_radius;
  for (uint32_t s = 0; s < count; ++s) {
    if (row[s] >= g.particles.count) continue;
    const Particle& other = *particle_at(g, row[s]);
    if (distance_squared(other.position, particle_at(g, i)->position) > near * near) continue;
    wake_if_asleep(sleep, g, row[s]);
    uint8_t& theirs = sleep->anchors[number_of(other)].carried;
    if (theirs < carried) theirs = carried;
  }
}

}  // namespace

void sleep_layout(Sleep* s, const sandglass_granular_desc& d, uint32_t rows, Layout* layout) {
  const uint64_t groups = rows / k_lane_group + 1;
  s->active_groups = layout_region<uint32_t>(layout, "granular.active_groups", groups);
  s->group_states = layout_region<GroupState>(layout, "granular.group_states", groups);
  s->touched = layout_region<uint8_t>(layout, "granular.touched", groups);
  s->anchors = layout_region<Anchor>(layout, "granular.rest", d.particle_capacity);
}

void sleep_reset(Sleep* s) {
  s->active_count = s->awake_count = s->waking_count = 0;
  s->next_check = 0.0;
  s->resting = k_nowhere;
}

void sleep_restore(Sleep* s, const SavedScene& saved) {
  s->next_check = saved.state.next_check;
  s->awake_count = saved.state.awake;
}

void sleep_carry(const Granular& g, const Particle* records, uint32_t which, const RigidMotion& motion) {
  const RigidMotion m = motion;
  Anchor* const anchors = g.sleep.anchors;
  for_bits(which, records, [&](const Particle* p) { m.move(anchors[number_of(*p)].position); });
}

void sleep_include_resting(Sleep* s, const Bounds& carried) { bounds_join(&s->resting, carried); }

void sleep_move(Sleep* s, uint32_t numbers, const SceneMove& move) {
  for (uint32_t i = 0; i < numbers; ++i) move.move(s->anchors[i].position);
}

void sleep_begin_rest(Sleep* s, uint32_t number, const float position[3]) {
  drop_anchor(&s->anchors[number], position);
}

void sleep_add(Sleep* s, uint32_t number, const float position[3]) {
  s->anchors[number].body_slot = 0;
  s->anchors[number].carried = s->anchors[number].woken = 0;
  sleep_begin_rest(s, number, position);
  ++s->awake_count;
}

void sleep_wake_box(Sleep* sleep, const Granular& g, const float low[3], const float high[3]) {
  for (uint32_t i = 0; i < g.particles.count; ++i) {
    const float* p = particle_at(g, i)->position;
    bool inside = true;
    for (int k = 0; k < 3; ++k) inside = inside && within(p[k], low[k], high[k]);
    if (inside) wake_if_asleep(sleep, g, i);
  }
}

void sleep_wake_all(Sleep* sleep, const Granular& g) {
  for (uint32_t i = 0; i < g.particles.count; ++i) wake_if_asleep(sleep, g, i);
}

void sleep_set_body_slot(Sleep* s, uint32_t number, uint32_t slot) { s->anchors[number].body_slot = slot; }

void sleep_removed(Sleep* s) { --s->awake_count; }

void sleep_forget_waking(Sleep* s) { s->waking_count = 0; }

void sleep_find_resting(Sleep* sleep, const Granular& g) {
  sleep->resting = k_nowhere;
  for (uint32_t i = 0; i < g.particles.count; ++i) {
    const Particle& p = *particle_at(g, i);
    if (is_asleep(p)) bounds_include(&sleep->resting, p.position);
  }
}

void sleep_recount(Sleep* sleep, const Granular& g) {
  sleep->awake_count = 0;
  for (uint32_t i = 0; i < g.particles.count; ++i) sleep->awake_count += is_awake(*particle_at(g, i)) ? 1u : 0u;
}

void sleep_begin_count(Sleep* s) {
  s->awake_count = 0;
  s->resting_in_lists = k_nowhere;
}

void sleep_count(Sleep* s, uint32_t awake, const Bounds& resting) {
  s->awake_count += awake;
  bounds_join(&s->resting_in_lists, resting);
}

void sleep_end_count(Sleep* sleep, const Granular& g) {
  sleep->resting = sleep->resting_in_lists;
  sleep->waking_count = 0;
  sleep_collect_groups(sleep, g);
}

bool sleep_sort_group(const Granular& g, uint32_t group, uint32_t* awake_count, Bounds* resting) {
  const uint32_t first = group * k_lane_group;
  uint32_t lanes = 0;
  for (uint32_t i = first; i < first + k_lane_group; ++i) {
    const Particle& p = *particle_at(g, i);
    lanes += is_awake(p) ? 1u : 0u;
    if (g.bodies.count != 0 && in_body(p) && !is_inert(p)) bodies_note_row(g, i);
  }
  for (uint32_t i = first; lanes != k_lane_group && i < first + k_lane_group; ++i) {
    const Particle& p = *particle_at(g, i);
    if (is_asleep(p)) bounds_include(resting, p.position);
  }
  *awake_count += lanes;
  g.sleep.group_states[group] = lanes != 0 ? GroupState::active : GroupState::asleep;
  if (lanes != 0) return false;
  particles_copy_to_all(g.particles, first, k_lane_group);
  return true;
}

void sleep_collect_groups(Sleep* sleep, const Granular& g) {
  const uint32_t groups = (g.particles.count + k_lane_group - 1) / k_lane_group;
  sleep->active_count = 0;
  for (uint32_t group = 0; group < groups; ++group) {
    sleep->touched[group] = 0;
    if (sleep->group_states[group] == GroupState::active) sleep->active_groups[sleep->active_count++] = group;
  }
}

uint32_t sleep_active_items(const Granular& g) { return g.sleep.active_count * k_lane_group; }

bool sleep_check_due(Sleep* sleep, const Granular& g) {
  if (g.time.simulated < sleep->next_check - k_time_resolution) return false;
  sleep->next_check = g.time.simulated + k_sleep_period;
  return true;
}

// ---- touch: near colliders that moved

bool sleep_run_touch(Sleep* sleep, const Granular& g, uint32_t* cursor) {
  const uint32_t count = g.particles.count, end = count - *cursor < g.unit ? count : *cursor + g.unit;
  const MovedColliders& moved = g.colliders.for_particles.moved;
  const WakeArgs args = {as_sleepers(g.particles.records[0]), count, moved.frames, moved.margins, moved.count};
  uint32_t woken = 0;
  g.kernels->wake_near(&args, *cursor, end, &woken);
  for (uint32_t i = *cursor; moved.relief_count != 0 && i < end; ++i) {
    Particle* p = particle_at(g, i);
    if (!is_asleep(*p) || !reliefs_wake(moved, p->position, g.desc.particle_radius)) continue;
    wake(p);
    ++woken;
  }
  for (uint32_t i = *cursor; woken != 0 && i < end; ++i) {
    const Particle& p = *particle_at(g, i);
    if (is_awake(p) && sleep->anchors[number_of(p)].quiet == k_asleep) begin_waking(sleep, g, i);
  }
  *cursor = end;
  return end >= count;
}

// ---- wake: what fast particles ran into

float granular_speed_scale(const Granular& g) {
  const float pull = g.gravity_length > 0.1f ? g.gravity_length : 9.81f;
  return __builtin_sqrtf(pull * 2.0f * g.desc.particle_radius);
}

float sleep_wake_speed(const Granular& g) { return k_wake_speed_units * granular_speed_scale(g); }

bool sleep_run_wake(Sleep* sleep, const Granular& g, uint32_t* cursor) {
  const float speed = sleep_wake_speed(g), speed2 = speed * speed;
  const float stir = k_stir_radii * g.desc.particle_radius, stir2 = stir * stir;
  uint32_t done = 0;
  for (; *cursor < sleep->active_count && done < g.unit; ++*cursor) {
    const uint32_t group = sleep->active_groups[*cursor];
    if (sleep->touched[group] == 0) continue;
    sleep->touched[group] = 0;
    done += k_lane_group;
    for (uint32_t i = group * k_lane_group; i < (group + 1) * k_lane_group; ++i) {
      const Particle& p = *particle_at(g, i);
      const float* v = p.velocity;
      if (!is_awake(p) || has_departed(p) || !(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] > speed2)) continue;
      if (moved2(*sleep, p) > stir2) wake_neighbours(sleep, g, i);
    }
  }
  return *cursor >= sleep->active_count;
}

// ---- sleep: who has stayed near its anchor, and who has moved on

static bool is_far_from(const ColliderFrame& c, const float position[3], float margin) {
  if (c.shape == SANDGLASS_SHAPE_HALF_SPACE || c.shape == SANDGLASS_SHAPE_FIELD) return false;
  for (int k = 0; k < 3; ++k)
    if (__builtin_fabsf(position[k] - c.position[k]) > c.extent[k] + margin) return true;
  return false;
}

// Whether a particle touches a collider, and whether its centre lies in one.
static bool touches_collider(const Granular& g, uint32_t i, bool* inside) {
  const Particle& p = *particle_at(g, i);
  const float near = (1.0f + k_touch_gap_radii) * g.desc.particle_radius;
  bool touches = false;
  alignas(SANDGLASS_BLOCK_ALIGNMENT) SurfacePoint points[k_lane_group] = {};
  for (int k = 0; k < 3; ++k) points[0].position[k] = p.position[k];
  for (uint32_t c = 0; c < g.colliders.substep_count; ++c) {
    const ColliderFrame& collider = g.colliders.substep_frames[c];
    if (is_far_from(collider, p.position, near)) continue;
    const SurfaceArgs args = {points, &collider};
    uint32_t unused = 0;
    g.kernels->surface_at(&args, 0, k_lane_group, &unused);
    *inside = *inside || points[0].distance < 0.0f;
    touches = touches || points[0].distance < near;
  }
  return touches;
}

// Whether this is a particle that was found balanced since it moved on.
static bool leans(const Sleep& sleep, const Granular& g, uint32_t i) {
  const Particle& p = *particle_at(g, i);
  return i < g.particles.count && is_awake(p) && (sleep.anchors[number_of(p)].quiet & k_balanced) != 0;
}

// Whether a particle may fall asleep. Without gravity all may. Otherwise it must touch something: the boundary, a
// collider, or a particle that is not of its own body; and its centre must not lie in a collider, which pushes it out.
// Beside a particle that leans it must have been `watched` long enough: what leans would fall differently if this one
// stood fast. It waits for a particle that it touches and that has been quiet for `waits` checks, but not yet for
// `patience`.
static bool may_rest(const Sleep& sleep, const Granular& g, uint32_t i, bool watched, uint32_t waits,
                     uint32_t patience) {
  if (!(g.gravity_length > 0.0f)) return true;
  const Particle& p = *particle_at(g, i);
  const float near = (2.0f + k_touch_gap_radii) * g.desc.particle_radius;
  if (has_departed(p)) return false;  // its list is old
  bool inside = false, touches = touches_collider(g, i, &inside);
  uint32_t count;
  const uint32_t* row = neighbours_of(g, i, &count);
  for (uint32_t s = 0; s < count && !inside; ++s) {
    const Particle& other = *particle_at(g, row[s]);
    if ((in_body(p) && body_of(p) == body_of(other)) || !(distance_squared(other.position, p.position) < near * near))
      continue;
    touches = true;
    if (!watched && leans(sleep, g, row[s])) return false;
    if (row[s] >= g.particles.count || is_asleep(other)) continue;
    const uint32_t quiet = sleep.anchors[number_of(other)].quiet & (k_look - 1u);
    if (quiet >= waits && quiet + 1 < patience) return false;
  }
  return touches && !inside;
}

// Whether a particle stands upright on a single other one, and some direction aside leads past all that it touches.
// What is balanced itself stops nothing: so a lattice leans as a whole, and between walls it stands.
static bool is_balanced(const Sleep& sleep, const Granular& g, uint32_t i) {
  if (!(g.gravity_length > 0.0f)) return false;
  const float* at = particle_at(g, i)->position;
  const float near = (2.0f + k_touch_gap_radii) * g.desc.particle_radius, pull = -1.0f / g.gravity_length;
  const FloatVector up = {g.gravity[0] * pull, g.gravity[1] * pull, g.gravity[2] * pull};
  FloatVector normals[k_touched_max];  // of what might stop it
  uint32_t count, supports = 0, stops = 0;
  const uint32_t* row = neighbours_of(g, i, &count);
  for (uint32_t s = 0; s < count && stops < k_touched_max; ++s) {
    const float* other = particle_at(g, row[s])->position;
    const float gap2 = distance_squared(other, at);
    if (!(gap2 < near * near) || !(gap2 > 0.0f)) continue;
    const float scale = 1.0f / __builtin_sqrtf(gap2);
    const FloatVector n = {(at[0] - other[0]) * scale, (at[1] - other[1]) * scale, (at[2] - other[2]) * scale};
    const float height = dot(n, up);
    if (height > k_support && (height < k_upright || ++supports > 1)) return false;
    if (height > -k_support && !leans(sleep, g, row[s])) normals[stops++] = n;
  }
  // If any direction is free, one along the side of a particle beside this one is, or there is none beside it.
  bool beside = false, free = false;
  for (uint32_t s = 0; s < 2 * stops && !free; ++s) {
    const FloatVector direction = s % 2 == 0 ? cross(up, normals[s / 2]) : cross(normals[s / 2], up);
    if (dot(direction, direction) < k_free_aside) continue;
    beside = free = true;
    for (uint32_t t = 0; t < stops; ++t) free = free && dot(direction, normals[t]) > -k_free_aside;
  }
  return supports != 0 && (free || !beside) && !touches_collider(g, i, &beside);
}

// From now on the particle counts as balanced. Its neighbours are looked at anew, because they may be balanced, too.
// Their checks go on counting: particles that do not fall asleep together push each other, and wake.
static void begin_leaning(Sleep* sleep, const Granular& g, uint32_t i) {
  sleep->anchors[number_of(*particle_at(g, i))].quiet |= k_balanced;
  uint32_t count;
  const uint32_t* row = neighbours_of(g, i, &count);
  for (uint32_t s = 0; s < count; ++s)
    if (row[s] < g.particles.count && is_awake(*particle_at(g, row[s])) && !leans(*sleep, g, row[s]))
      sleep->anchors[number_of(*particle_at(g, row[s]))].quiet |= k_look;
}

// Checks in a row that must find a particle near one place before it sleeps.
static uint32_t patience_of(const Granular& g) {
  const uint32_t checks = to_whole<uint32_t>(g.desc.sleep_after * static_cast<float>(1.0 / k_sleep_period));
  return checks > k_checks_min ? checks : k_checks_min;
}

// Checks in a row for which a particle beside one that leans is watched.
static uint32_t tipping_of(const Granular& g) {
  const float time = k_tipping_units * g.desc.particle_radius / granular_speed_scale(g);
  const float checks = time * static_cast<float>(1.0 / k_sleep_period), limit = static_cast<float>(k_look - 2);
  return to_whole<uint32_t>(checks < limit ? checks : limit);
}

bool sleep_run_sleep(Sleep* sleep, const Granular& g, uint32_t* cursor) {
  const float limit = rest_limit(g, k_rest_radii), body_limit = rest_limit(g, k_body_rest_radii);
  const uint32_t patience = patience_of(g), tipping = tipping_of(g);
  const uint32_t items = sleep_active_items(g);
  const uint32_t end = items - *cursor < g.unit ? items : *cursor + g.unit;
  for (uint32_t at = *cursor; at < end; at += k_lane_group) {
    const uint32_t group = sleep->active_groups[at / k_lane_group];
    find_carried(sleep, g, group);
    for (uint32_t i = group * k_lane_group; i < (group + 1) * k_lane_group; ++i) {
      const Particle& p = *particle_at(g, i);
      if (!is_awake(p)) continue;
      Anchor& anchor = sleep->anchors[number_of(p)];
      const uint8_t carried = anchor.carried;
      const float distance_max = in_body(p) ? body_limit : limit;
      if (moved2(*sleep, p) > distance_max * distance_max) {
        move_on(sleep, g, p);
        if (!has_departed(p)) wake_neighbours(sleep, g, i);
      } else if (carried != 0) {
        anchor.quiet = 0;
      } else {
        const uint32_t quiet = anchor.quiet & (k_look - 1u);
        if (quiet < k_look - 2u) ++anchor.quiet;
        if (in_body(p)) continue;
        const bool looks = quiet + 1 == patience / 2 || ((anchor.quiet & k_look) != 0 && quiet + 1 > patience / 2);
        if (looks) anchor.quiet &= static_cast<uint16_t>(~k_look);
        if (looks && (anchor.quiet & k_balanced) == 0 && is_balanced(*sleep, g, i)) {
          begin_leaning(sleep, g, i);
        } else if (const bool waits = anchor.woken == k_woken_often && quiet < 2 * patience;
                   quiet + 1 >= patience &&
                   may_rest(*sleep, g, i, quiet + 1 >= tipping, waits ? patience / 2 : patience, patience)) {
          fall_asleep(sleep, g, i);
        }
      }
      if (carried == 0) continue;
      anchor.carried = carried - 1;
      if (carried > 1 && !has_departed(p)) carry_neighbours(sleep, g, i, carried - 1);
    }
    leave_if_asleep(sleep, g, group);
  }
  *cursor = end;
  return end >= items;
}

bool sleep_put_body(Sleep* sleep, const Granular& g, const RigidBody& body) {
  if (!bodies_awake(g, body)) return false;
  const uint32_t patience = patience_of(g);
  bool quiet = true, touches = false;
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot)
    quiet = quiet && sleep->anchors[g.bodies.numbers[slot]].quiet >= patience;
  for (uint32_t slot = body.first; quiet && !touches && slot < body.first + body.count; ++slot)
    touches = may_rest(*sleep, g, g.bodies.rows[slot], true, patience, patience);
  quiet = quiet && touches;
  for (uint32_t slot = body.first; quiet && slot < body.first + body.count; ++slot) {
    fall_asleep(sleep, g, g.bodies.rows[slot]);
    leave_if_asleep(sleep, g, g.bodies.rows[slot] / k_lane_group);
  }
  return quiet;
}

// ---- wake_lists: lists for the groups that woke

bool sleep_run_wake_lists(Sleep* sleep, const Granular& g, uint32_t* cursor, FrameCounts* counts) {
  const uint32_t count = g.particles.count;
  uint32_t done = 0;
  for (; *cursor < count && sleep->waking_count != 0 && done < g.unit; *cursor += k_lane_group) {
    GroupState& state = sleep->group_states[*cursor / k_lane_group];
    if (state != GroupState::waking) continue;
    counts->dropped_contacts += neighbours_build_group(g, *cursor / k_lane_group);
    state = GroupState::active;
    --sleep->waking_count;
    done += k_lane_group;
  }
  return sleep->waking_count == 0;
}

}  // namespace sandglass
