// Who rests: which particles sleep, and what wakes them. solver.h has the rules.
#include "kernels/whole.h"
#include "runtime/core/finite.h"
#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

constexpr float k_rest_radii = 0.1f;  // moving further than this is moving on
// Metres; below it the distance shrinks with the root of the radius, as the speed does at which sand creeps in a corner.
constexpr float k_rest_radius = 0.01f;
// Of a rigid body. Friction holds the particles that touch, not the others, so on a slope a body creeps by some
// 2 g dt sin(slope), for ever.
constexpr float k_body_rest_radii = 0.3f;
// What flies stays within h of one place for at most (1 + sqrt 2) sqrt(2 h / g): it passes there, turns h above, and is h
// below soon after. So in a time t it moves on by more than 0.0858 g t^2, however large it is.
constexpr float k_flight_share = 0.08f;
// One check finds a particle that turned in the air where it was 20 ms ago.
constexpr uint32_t k_checks_least = 2;
constexpr float k_touch_gap_radii = 0.1f;   // what is nearer is touched
constexpr float k_wake_speed_units = 0.1f;  // of sqrt(g d)
// Jammed particles, under a heavy body say, tremble faster than the wake speed, but stay within a hundredth of a
// radius.
constexpr float k_stir_radii = 0.05f;

// A carrier is slow where it moves on less than this within sleep_after, in units of what counts as moving on. What is
// carried faster wakes its neighbours by moving on.
constexpr float k_slow_carrier = 3.0f;
constexpr uint16_t k_carried_contacts = 40;  // contacts from the carrier that are kept awake: more than piles are high

Particle* particle_at(const Granular& g, uint32_t i) { return &g.particles.records[0][i]; }

void drop_anchor(Anchor* anchor, const float position[3]) {
  for (int k = 0; k < 3; ++k) anchor->position[k] = position[k];
  anchor->quiet = 0;
}

// The particle moves on, and with it all of its body: else its particles would never be quiet at one time.
void move_on(Granular* g, const Particle& p) {
  drop_anchor(&g->sleep.anchors[number_of(p)], p.position);
  if (!in_body(p)) return;
  const RigidBody& body = g->bodies.all[body_of(p) - 1];
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot)
    drop_anchor(&g->sleep.anchors[g->bodies.numbers[slot]], particle_at(*g, g->bodies.rows[slot])->position);
}

float apart2(const float a[3], const float b[3]) {
  float sum = 0.0f;
  for (int k = 0; k < 3; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return sum;
}

// Squared distance from where the particle last moved on or woke.
float moved2(const Granular& g, const Particle& p) {
  return apart2(p.position, g.sleep.anchors[number_of(p)].position);
}

// Particle i, whose state is awake already, counts as awake from now on.
void begin_waking_one(Granular* g, uint32_t i) {
  const Particle& p = *particle_at(*g, i);
  drop_anchor(&g->sleep.anchors[number_of(p)], p.position);
  ++g->sleep.awake_count;
  GroupState& state = g->sleep.group_states[i / k_lane_group];
  if (state != GroupState::asleep) return;
  state = GroupState::waking;
  ++g->sleep.waking_count;
}

// And so does the rest of its body.
void begin_waking(Granular* g, uint32_t i) {
  begin_waking_one(g, i);
  const Particle& woken = *particle_at(*g, i);
  if (!in_body(woken)) return;
  const RigidBody& body = g->bodies.all[body_of(woken) - 1];
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
    Particle* p = particle_at(*g, g->bodies.rows[slot]);
    if (!is_asleep(*p)) continue;
    wake(p);
    begin_waking_one(g, g->bodies.rows[slot]);
  }
}

void wake_if_asleep(Granular* g, uint32_t i) {
  Particle* p = particle_at(*g, i);
  if (!is_asleep(*p)) return;
  wake(p);
  begin_waking(g, i);
}

void wake_neighbours(Granular* g, uint32_t i) {
  uint32_t count;
  const uint32_t* row = neighbours_of(g, i, &count);
  for (uint32_t s = 0; s < count; ++s) {
    if (row[s] < g->particles.count) wake_if_asleep(g, row[s]);
  }
}

// A group in which all sleep leaves the passes, which swap the arrays: every array must hold it.
void leave_if_asleep(Granular* g, uint32_t group) {
  for (uint32_t i = group * k_lane_group; i < (group + 1) * k_lane_group; ++i)
    if (is_awake(*particle_at(*g, i))) return;
  g->sleep.group_states[group] = GroupState::asleep;
  particles_copy_to_all(&g->particles, group * k_lane_group, k_lane_group);
}

void fall_asleep(Granular* g, uint32_t i) {
  Particle* p = particle_at(*g, i);
  put_to_sleep(p);
  bounds_include(&g->sleep.resting, p->position);
  g->sleep.anchors[number_of(*p)].quiet = k_asleep;
  --g->sleep.awake_count;
}

// What is farther from where it was has moved on, metres.
float rest_limit(const Granular& g, float radii) {
  const float r = g.desc.particle_radius, time = g.desc.sleep_after;
  const float limit = radii * __builtin_sqrtf(r * (r > k_rest_radius ? r : k_rest_radius));
  const float flight = k_flight_share * g.gravity_length * time * time;
  return g.gravity_length > 0.0f && flight < limit ? flight : limit;
}

// Marks what a slow carrier touches.
void find_carried(Granular* g, uint32_t group) {
  const float r = g->desc.particle_radius;
  const float slow = k_slow_carrier * rest_limit(*g, k_rest_radii) / g->desc.sleep_after;
  for (uint32_t c = 0; c < g->colliders.substep_count; ++c) {
    const ColliderFrame& carrier = g->colliders.substep_frames[c];
    const float *v = carrier.linear, *w = carrier.angular;
    const float v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], w2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    if (w2 == 0.0f && (v2 == 0.0f || v2 > slow * slow)) continue;
    alignas(SANDGLASS_BLOCK_ALIGNMENT) SurfacePoint points[k_lane_group] = {};
    const Particle* p = particle_at(*g, group * k_lane_group);
    for (uint32_t l = 0; l < k_lane_group; ++l)
      for (int k = 0; k < 3; ++k) points[l].position[k] = p[l].position[k];
    const SurfaceArgs args = {points, &carrier};
    uint32_t unused = 0;
    g->kernels->surface_at(&args, 0, k_lane_group, &unused);
    for (uint32_t l = 0; l < k_lane_group; ++l) {
      if (!is_awake(p[l]) || points[l].distance > (1.0f + k_touch_gap_radii) * r) continue;
      float at[3];
      for (int k = 0; k < 3; ++k) at[k] = p[l].position[k] - carrier.position[k];
      const float u[3] = {v[0] + w[1] * at[2] - w[2] * at[1], v[1] + w[2] * at[0] - w[0] * at[2],
                          v[2] + w[0] * at[1] - w[1] * at[0]};
      const float u2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
      if (u2 > 0.0f && u2 <= slow * slow) g->sleep.anchors[number_of(p[l])].carried = k_carried_contacts;
    }
  }
}

// What a carried particle touches is carried too, up to so many contacts from the carrier, and wakes.
void carry_neighbours(Granular* g, uint32_t i, uint16_t carried) {
  uint32_t count;
  const uint32_t* row = neighbours_of(g, i, &count);
  const float near = (2.0f + k_touch_gap_radii) * g->desc.particle_radius;
  for (uint32_t s = 0; s < count; ++s) {
    if (row[s] >= g->particles.count) continue;
    const Particle& other = *particle_at(*g, row[s]);
    if (apart2(other.position, particle_at(*g, i)->position) > near * near) continue;
    wake_if_asleep(g, row[s]);
    uint16_t& theirs = g->sleep.anchors[number_of(other)].carried;
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

void sleep_begin_rest(Sleep* s, uint32_t number, const float position[3]) {
  drop_anchor(&s->anchors[number], position);
}

void sleep_add(Sleep* s, uint32_t number, const float position[3]) {
  s->anchors[number].body_slot = 0;
  s->anchors[number].carried = 0;
  sleep_begin_rest(s, number, position);
  ++s->awake_count;
}

void sleep_wake_box(Granular* g, const float low[3], const float high[3]) {
  for (uint32_t i = 0; i < g->particles.count; ++i) {
    const float* p = particle_at(*g, i)->position;
    bool inside = true;
    for (int k = 0; k < 3; ++k) inside = inside && within(p[k], low[k], high[k]);
    if (inside) wake_if_asleep(g, i);
  }
}

void sleep_wake_all(Granular* g) {
  substep_abandon(g);
  for (uint32_t i = 0; i < g->particles.count; ++i) wake_if_asleep(g, i);
  g->neighbours.valid = false;
}

void sleep_put_one(Granular* g, uint32_t index) {
  fall_asleep(g, index);
  leave_if_asleep(g, index / k_lane_group);
}

bool sleep_sort_group(Granular* g, uint32_t group, uint32_t* awake_count, Bounds* resting) {
  const uint32_t first = group * k_lane_group;
  uint32_t lanes = 0;
  for (uint32_t i = first; i < first + k_lane_group; ++i) {
    const Particle& p = *particle_at(*g, i);
    lanes += is_awake(p) ? 1u : 0u;
    if (g->bodies.count != 0 && in_body(p) && !is_inert(p)) bodies_note_row(g, i);
  }
  for (uint32_t i = first; lanes != k_lane_group && i < first + k_lane_group; ++i) {
    const Particle& p = *particle_at(*g, i);
    if (is_asleep(p)) bounds_include(resting, p.position);
  }
  *awake_count += lanes;
  g->sleep.group_states[group] = lanes != 0 ? GroupState::active : GroupState::asleep;
  if (lanes != 0) return false;
  particles_copy_to_all(&g->particles, first, k_lane_group);
  return true;
}

void sleep_collect_groups(Granular* g) {
  Sleep& s = g->sleep;
  const uint32_t groups = (g->particles.count + k_lane_group - 1) / k_lane_group;
  s.active_count = 0;
  for (uint32_t group = 0; group < groups; ++group) {
    s.touched[group] = 0;
    if (s.group_states[group] == GroupState::active) s.active_groups[s.active_count++] = group;
  }
}

uint32_t sleep_active_items(const Granular& g) { return g.sleep.active_count * k_lane_group; }

void sleep_skip_time(Granular* g) {
  const bool asleep = g->sleep.awake_count == 0 && (g->neighbours.valid || g->particles.count == 0);
  if (!asleep || g->flow.emitter_count != 0 || !substep_idle(*g)) return;
  time_skip(g);
  g->substep.interval_left = 0;
  g->particles.speed_max = g->neighbours.last_spread = 0.0f;
  grain_sleep_skip_time(g);
}

// ---- touch: near colliders that moved

bool sleep_run_touch(Granular* g) {
  uint32_t& cursor = g->substep.cursor;
  const uint32_t count = g->particles.count, end = count - cursor < g->unit ? count : cursor + g->unit;
  const MovedColliders& moved = g->colliders.for_particles.moved;
  const WakeArgs args = {as_sleepers(g->particles.records[0]), count, moved.frames, moved.margins, moved.count};
  uint32_t woken = 0;
  g->kernels->wake_near(&args, cursor, end, &woken);
  for (uint32_t i = cursor; woken != 0 && i < end; ++i) {
    const Particle& p = *particle_at(*g, i);
    if (is_awake(p) && g->sleep.anchors[number_of(p)].quiet == k_asleep) begin_waking(g, i);
  }
  cursor = end;
  if (end < count) return false;
  watch_remember(g, &g->colliders.for_particles);
  return true;
}

// ---- wake: what fast particles ran into

float granular_speed_scale(const Granular& g) {
  const float pull = g.gravity_length > 0.1f ? g.gravity_length : 9.81f;
  return __builtin_sqrtf(pull * 2.0f * g.desc.particle_radius);
}

float sleep_wake_speed(const Granular& g) { return k_wake_speed_units * granular_speed_scale(g); }

bool sleep_run_wake(Granular* g) {
  Sleep& s = g->sleep;
  uint32_t& cursor = g->substep.cursor;
  const float speed = sleep_wake_speed(*g), speed2 = speed * speed;
  const float stir = k_stir_radii * g->desc.particle_radius, stir2 = stir * stir;
  uint32_t done = 0;
  for (; cursor < s.active_count && done < g->unit; ++cursor) {
    const uint32_t group = s.active_groups[cursor];
    if (s.touched[group] == 0) continue;
    s.touched[group] = 0;
    done += k_lane_group;
    for (uint32_t i = group * k_lane_group; i < (group + 1) * k_lane_group; ++i) {
      const Particle& p = *particle_at(*g, i);
      const float* v = p.velocity;
      if (!is_awake(p) || has_departed(p) || !(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] > speed2)) continue;
      if (moved2(*g, p) > stir2) wake_neighbours(g, i);
    }
  }
  return cursor >= s.active_count;
}

// ---- sleep: who has stayed near its anchor, and who has moved on

bool sleep_may_rest(Granular* g, uint32_t i) {
  if (!(g->gravity_length > 0.0f)) return true;
  const Particle& p = *particle_at(*g, i);
  const float r = g->desc.particle_radius, gap = k_touch_gap_radii * r, near2 = (2.0f * r + gap) * (2.0f * r + gap);
  if (has_departed(p)) return false;  // its list is old
  uint32_t count;
  const uint32_t* row = neighbours_of(g, i, &count);
  for (uint32_t s = 0; s < count; ++s) {
    const Particle& other = *particle_at(*g, row[s]);
    if (in_body(p) && body_of(p) == body_of(other)) continue;
    if (apart2(other.position, p.position) < near2) return true;
  }
  alignas(SANDGLASS_BLOCK_ALIGNMENT) SurfacePoint points[k_lane_group] = {};
  for (uint32_t c = 0; c < g->colliders.substep_count; ++c) {
    const SurfaceArgs args = {points, &g->colliders.substep_frames[c]};
    for (int k = 0; k < 3; ++k) points[0].position[k] = p.position[k];
    uint32_t unused = 0;
    g->kernels->surface_at(&args, 0, k_lane_group, &unused);
    if (points[0].distance < r + gap) return true;
  }
  return false;
}

bool sleep_run_sleep(Granular* g) {
  uint32_t& cursor = g->substep.cursor;
  const float limit = rest_limit(*g, k_rest_radii), body_limit = rest_limit(*g, k_body_rest_radii);
  const uint32_t checks = to_whole<uint32_t>(g->desc.sleep_after * static_cast<float>(1.0 / k_sleep_period));
  const uint32_t patience = checks > k_checks_least ? checks : k_checks_least;
  const uint32_t items = sleep_active_items(*g);
  const uint32_t end = items - cursor < g->unit ? items : cursor + g->unit;
  for (uint32_t at = cursor; at < end; at += k_lane_group) {
    const uint32_t group = g->sleep.active_groups[at / k_lane_group];
    find_carried(g, group);
    for (uint32_t i = group * k_lane_group; i < (group + 1) * k_lane_group; ++i) {
      const Particle& p = *particle_at(*g, i);
      if (!is_awake(p)) continue;
      Anchor& anchor = g->sleep.anchors[number_of(p)];
      const uint16_t carried = anchor.carried;
      const float most = in_body(p) ? body_limit : limit;
      if (moved2(*g, p) > most * most) {
        move_on(g, p);
        if (!has_departed(p)) wake_neighbours(g, i);
      } else if (carried != 0) {
        anchor.quiet = 0;
      } else if (++anchor.quiet >= patience && !in_body(p) && sleep_may_rest(g, i)) {
        fall_asleep(g, i);
      }
      if (carried == 0) continue;
      anchor.carried = carried - 1;
      if (carried > 1 && !has_departed(p)) carry_neighbours(g, i, carried - 1);
    }
    leave_if_asleep(g, group);
  }
  cursor = end;
  if (end < items) return false;
  bodies_put_to_sleep(g, patience);
  sleep_collect_groups(g);
  return true;
}

// ---- wake_lists: lists for the groups that woke

bool sleep_run_wake_lists(Granular* g) {
  Sleep& s = g->sleep;
  uint32_t& cursor = g->substep.cursor;
  const uint32_t count = g->particles.count;
  uint32_t done = 0;
  for (; cursor < count && s.waking_count != 0 && done < g->unit; cursor += k_lane_group) {
    GroupState& state = s.group_states[cursor / k_lane_group];
    if (state != GroupState::waking) continue;
    const uint32_t left = count - cursor;
    g->counts.dropped_contacts += neighbours_build(g, cursor, cursor + (left < k_lane_group ? left : k_lane_group));
    state = GroupState::active;
    g->neighbours.listed[cursor / k_lane_group] = 1;
    --s.waking_count;
    done += k_lane_group;
  }
  if (s.waking_count != 0) return false;
  pair_colours_forget(&g->colours);
  sleep_collect_groups(g);
  return true;
}

}  // namespace sandglass
