// Sleep. A particle that has stayed near one place for sleep_after seconds sleeps: its w changes sign, it stops, and
// its neighbours see a thing of infinite mass. Record groups in which all sleep are left out of every pass.
//
// What wakes it, always a neighbour in its list or a collider:
//   touch       a collider that moved, appeared or went away since the last frame comes or was within reach
//   wake        after each sub-step: a particle that is fast, and away from where it last rested, runs into it
//   rest        every 20 ms of simulated time: a neighbour has moved on, by more than the distance that counts as rest
// So a heap wakes shell by shell from where it was disturbed, as fast as the disturbance travels, and no further. A
// particle that keeps still to within that distance but trembles does sleep: what counts is where it is.
//
// Lists are kept for active groups only. A group that wakes gets its lists from the grid of the last build, the same
// lists as if it had been awake then.
#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

constexpr float k_rest_radii = 0.1f;        // moving further than this is moving on
constexpr float k_wake_speed_units = 0.1f;  // of sqrt(g d)
// Jammed particles, under a heavy body say, tremble faster than that, but stay within a hundredth of a radius.
constexpr float k_stir_radii = 0.05f;

Particle* particle_at(const Granular& g, uint32_t i) { return &g.records[0][i]; }

// Squared distance from where the particle last moved on or woke.
float moved2(const Granular& g, const Particle& p) {
  const float* anchor = g.rest[number_of(p)].anchor;
  float sum = 0.0f;
  for (int k = 0; k < 3; ++k) sum += (p.position[k] - anchor[k]) * (p.position[k] - anchor[k]);
  return sum;
}

// The particle in record i is awake from now on.
void begin_waking_one(Granular* g, uint32_t i) {
  const Particle& p = *particle_at(*g, i);
  Rest& rest = g->rest[number_of(p)];
  for (int k = 0; k < 3; ++k) rest.anchor[k] = p.position[k];
  rest.quiet = 0;
  ++g->awake_count;
  GroupState& state = g->group_states[i / k_lane_group];
  if (state != GroupState::asleep) return;
  state = GroupState::waking;
  ++g->waking_count;
}

// And so is the rest of its body.
void begin_waking(Granular* g, uint32_t i) {
  begin_waking_one(g, i);
  const Particle& first = *particle_at(*g, i);
  if (!in_body(first)) return;
  const RigidBody& body = g->bodies[body_of(first) - 1];
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
    Particle* p = particle_at(*g, g->body_rows[slot]);
    if (!is_asleep(*p)) continue;
    wake(p);
    begin_waking_one(g, g->body_rows[slot]);
  }
}

void wake_neighbours(Granular* g, uint32_t i) {
  const uint32_t* row = g->lists + static_cast<uint64_t>(i) * k_list_slots;
  for (uint32_t s = 0; s < g->counts[i]; ++s) {
    if (row[s] >= g->particle_count) continue;
    Particle* p = particle_at(*g, row[s]);
    if (!is_asleep(*p)) continue;
    wake(p);
    begin_waking(g, row[s]);
  }
}

// Where all of the group sleep it leaves the passes, so both buffers must hold it.
void settle_group(Granular* g, uint32_t group) {
  for (uint32_t i = group * k_lane_group; i < (group + 1) * k_lane_group; ++i)
    if (is_awake(*particle_at(*g, i))) return;
  g->group_states[group] = GroupState::asleep;
  const uint32_t first = group * k_lane_group;
  for (uint32_t b = 1; b < 3; ++b) {
    if (g->records[b] != nullptr)
      __builtin_memcpy(g->records[b] + first, g->records[0] + first, k_lane_group * sizeof(Particle));
  }
}

bool same(const sandglass_collider& a, const sandglass_collider& b) {
  bool equal = a.shape == b.shape && a.field == b.field;
  for (int k = 0; k < 3; ++k) {
    equal = equal && a.position[k] == b.position[k] && a.size[k] == b.size[k];
    equal = equal && b.linear_velocity[k] == 0.0f && b.angular_velocity[k] == 0.0f;
  }
  for (int k = 0; k < 4; ++k) equal = equal && a.rotation[k] == b.rotation[k];
  return equal;
}

// Half of what any point of the collider near sand can have travelled between two poses.
float half_travel(const sandglass_collider& a, const sandglass_collider& b) {
  float shift2 = 0.0f, turn2 = 0.0f, extent2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    shift2 += (b.position[k] - a.position[k]) * (b.position[k] - a.position[k]);
    extent2 += b.size[k] * b.size[k];
  }
  for (int k = 0; k < 4; ++k) turn2 += (b.rotation[k] - a.rotation[k]) * (b.rotation[k] - a.rotation[k]);
  return 0.5f * __builtin_sqrtf(shift2) + __builtin_sqrtf(turn2 * extent2);
}

void fall_asleep(Granular* g, uint32_t i) {
  Particle* p = particle_at(*g, i);
  put_to_sleep(p);
  g->rest[number_of(*p)].quiet = k_asleep;
  --g->awake_count;
}

void remember_colliders(Granular* g) {
  g->collider_before_count = g->solid_count;
  for (uint32_t c = 0; c < g->solid_count; ++c) g->colliders_before[c] = g->colliders[c];
}

}  // namespace

float granular_speed_scale(const Granular& g) {
  const float pull = g.gravity_length > 0.1f ? g.gravity_length : 9.81f;
  return __builtin_sqrtf(pull * 2.0f * g.desc.particle_radius);
}

void granular_sleep_particle(Granular* g, uint32_t record) {
  fall_asleep(g, record);
  settle_group(g, record / k_lane_group);
}

float granular_wake_speed(const Granular& g) { return k_wake_speed_units * granular_speed_scale(g); }

void granular_find_moved(const sandglass_collider* before, uint32_t before_count, const sandglass_collider* now,
                         uint32_t now_count, float margin, MovedColliders* moved) {
  moved->count = 0;
  for (uint32_t c = 0; c < now_count || c < before_count; ++c) {
    const bool is = c < now_count, was = c < before_count;
    if (is && was && same(before[c], now[c])) continue;
    const float reach = margin + (is && was ? half_travel(before[c], now[c]) : 0.0f);
    if (is) colliders_pose(&now[c], 1, 0.0f, &moved->frames[moved->count]), moved->margins[moved->count++] = reach;
    if (was) colliders_pose(&before[c], 1, 0.0f, &moved->frames[moved->count]), moved->margins[moved->count++] = reach;
  }
}

void granular_find_moved_colliders(Granular* g) {
  const float reach = (2.0f + g->desc.list_skin) * g->desc.particle_radius;
  g->moved.count = 0;
  if (g->adopts_colliders) {
    remember_colliders(g);
    g->sweep_collider_before_count = g->collider_count;
    for (uint32_t c = 0; c < g->collider_count; ++c) g->sweep_colliders_before[c] = g->colliders[c];
    g->adopts_colliders = false;
  }
  if (g->awake_count < g->particle_count)
    granular_find_moved(g->colliders_before, g->collider_before_count, g->colliders, g->solid_count, reach, &g->moved);
  g->touch_due = g->moved.count != 0;
  if (!g->touch_due) remember_colliders(g);
}

void granular_collect_groups(Granular* g) {
  const uint32_t groups = (g->particle_count + k_lane_group - 1) / k_lane_group;
  g->active_count = 0;
  for (uint32_t group = 0; group < groups; ++group) {
    g->touched[group] = 0;
    if (g->group_states[group] == GroupState::active) g->active_groups[g->active_count++] = group;
  }
}

void granular_settle(Granular* g) {
  g->cursor = 0;
  if (g->touch_due) {
    g->phase = ParticlePhase::touch;
  } else if (g->wake_due) {
    g->phase = ParticlePhase::wake;
  } else if (g->rest_due) {
    g->phase = ParticlePhase::rest;
  } else if (g->drain_due) {
    g->phase = ParticlePhase::drain;
  } else if (g->waking_count != 0 && g->lists_valid) {
    g->phase = ParticlePhase::wake_lists;
  } else {
    g->phase = ParticlePhase::idle;
    granular_skip_rest(g);
  }
}

void granular_skip_rest(Granular* g) {
  const bool asleep = g->awake_count == 0 && (g->lists_valid || g->particle_count == 0);
  if (!asleep || g->emitter_count != 0 || g->touch_due || g->phase != ParticlePhase::idle) return;
  g->simulated += g->owed;
  if (g->grain_count != 0) {
    // Around sleepers grains only come to rest: what they cannot follow now they need not.
    const double limit = granular_lag_limit(*g);
    g->unswept += g->owed;
    if (g->unswept > limit) g->unswept = limit;
  }
  g->owed = g->interval_owed = 0.0;
  g->interval_left = 0;
  g->speed_max = g->last_spread = 0.0f;
  // Grains that sleep on sleeping particles have nothing to follow.
  if (!g->grains_asleep || g->grain_phase != GrainPhase::idle) return;
  MovedColliders moved = g->moved;
  granular_find_moved(g->sweep_colliders_before, g->sweep_collider_before_count, g->colliders, g->collider_count, 0.0f,
                      &moved);
  if (moved.count == 0) g->unswept = 0.0;
  else g->grains_asleep = false;
}

void granular_wake_all(Granular* g) {
  granular_abandon_substep(g);
  for (uint32_t i = 0; i < g->particle_count; ++i) {
    Particle* p = particle_at(*g, i);
    if (!is_asleep(*p)) continue;
    wake(p);
    begin_waking(g, i);
  }
  g->lists_valid = false;
}

uint32_t granular_rest_items(const Granular& g) {
  uint32_t left = g.active_count * k_lane_group;
  if (g.phase == ParticlePhase::idle) left = g.particle_count;  // touch is due, then
  if (g.phase == ParticlePhase::touch) left = g.particle_count - g.cursor;
  if (g.phase == ParticlePhase::rest) left -= g.cursor;
  if (g.phase == ParticlePhase::wake_lists) left = g.waking_count * k_lane_group;
  return left < g.unit ? left : g.unit;
}

void granular_run_touch(Granular* g) {
  const uint32_t end = g->particle_count - g->cursor < g->unit ? g->particle_count : g->cursor + g->unit;
  WakeArgs args = {as_sleepers(g->records[0]), g->particle_count, g->moved.frames, g->moved.margins, g->moved.count};
  uint32_t woken = 0;
  g->kernels->wake_near(&args, g->cursor, end, &woken);
  for (uint32_t i = g->cursor; woken != 0 && i < end; ++i) {
    const Particle& p = *particle_at(*g, i);
    if (is_awake(p) && g->rest[number_of(p)].quiet == k_asleep) begin_waking(g, i);
  }
  g->cursor = end;
  if (end < g->particle_count) return;
  g->touch_due = false;
  remember_colliders(g);
  granular_settle(g);
}

void granular_run_wake(Granular* g) {
  const float speed = granular_wake_speed(*g), speed2 = speed * speed;
  const float stir = k_stir_radii * g->desc.particle_radius, stir2 = stir * stir;
  uint32_t done = 0;
  for (; g->cursor < g->active_count && done < g->unit; ++g->cursor) {
    const uint32_t group = g->active_groups[g->cursor];
    if (g->touched[group] == 0) continue;
    g->touched[group] = 0;
    done += k_lane_group;
    for (uint32_t i = group * k_lane_group; i < (group + 1) * k_lane_group; ++i) {
      const Particle& p = *particle_at(*g, i);
      const float* v = p.velocity;
      if (!is_awake(p) || !(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] > speed2)) continue;
      if (moved2(*g, p) > stir2) wake_neighbours(g, i);
    }
  }
  if (g->cursor < g->active_count) return;
  g->wake_due = false;
  granular_settle(g);
}

void granular_run_rest(Granular* g) {
  const float limit = k_rest_radii * g->desc.particle_radius, limit2 = limit * limit;
  const uint32_t patience = static_cast<uint32_t>(g->desc.sleep_after * static_cast<float>(1.0 / k_rest_period));
  const uint32_t items = g->active_count * k_lane_group;
  const uint32_t end = items - g->cursor < g->unit ? items : g->cursor + g->unit;
  for (uint32_t at = g->cursor; at < end; at += k_lane_group) {
    const uint32_t group = g->active_groups[at / k_lane_group];
    for (uint32_t i = group * k_lane_group; i < (group + 1) * k_lane_group; ++i) {
      const Particle& p = *particle_at(*g, i);
      if (!is_awake(p)) continue;
      Rest& rest = g->rest[number_of(p)];
      if (moved2(*g, p) > limit2) {
        for (int k = 0; k < 3; ++k) rest.anchor[k] = p.position[k];
        rest.quiet = 0;
        wake_neighbours(g, i);
      } else if (++rest.quiet >= patience && !in_body(p)) {
        fall_asleep(g, i);
      }
    }
    settle_group(g, group);
  }
  g->cursor = end;
  if (end < items) return;
  granular_rest_bodies(g, patience);
  g->rest_due = false;
  granular_collect_groups(g);
  granular_settle(g);
}

void granular_run_wake_lists(Granular* g) {
  uint32_t done = 0;
  for (; g->cursor < g->particle_count && g->waking_count != 0 && done < g->unit; g->cursor += k_lane_group) {
    GroupState& state = g->group_states[g->cursor / k_lane_group];
    if (state != GroupState::waking) continue;
    const uint32_t left = g->particle_count - g->cursor;
    g->dropped_contacts += granular_build_lists(g, g->cursor, g->cursor + (left < k_lane_group ? left : k_lane_group));
    state = GroupState::active;
    --g->waking_count;
    done += k_lane_group;
  }
  if (g->waking_count != 0) return;
  granular_collect_groups(g);
  granular_settle(g);
}

}  // namespace sandglass
