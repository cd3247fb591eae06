// Grains go with what holds them until the next sweep finds them again. grains.h has the rules, holding.cpp who is held.
#include "runtime/sand/granular.h"
#include "runtime/sand/holding.h"

namespace sandglass {

namespace {

// In place of a slot. k_free: nothing holds the grain. k_unknown, of a group's first grain: the group has moved since
// its holders were found.
constexpr uint8_t k_free = 255, k_unknown = k_grain_holders;
constexpr uint32_t k_held_together = 4 * k_lane_group;  // grains that are asked for at once

void move_pose(RigidPose* pose, const RigidMotion& motion) {
  motion.move(pose->position);
  for (float(&axis)[3] : pose->axes) motion.rotate(axis);
}

// Whether grains have caught up with the particles.
bool is_current(const Granular& g) {
  const SweepPhase phase = g.sweep.phase;
  const bool idle = phase == SweepPhase::idle || phase == SweepPhase::drain;
  return idle && !g.grain_carry.pending && g.time.grain_lag <= k_time_resolution;
}

// One ball or box alone is no vessel: grains about it are found by the next sweep.
bool may_hold(const Granular& g) {
  return colliders_may_hold(g) || g.grain_carry.drawn || g.grain_carry.pending || g.grain_carry.next_pending;
}

void hold_lanes(const Granular& g, const HeldGroup& group, uint32_t first, uint32_t count, uint8_t* holders) {
  HeldLanes& lanes = scratch_of(g).lanes;
  auto& holder = scratch_of(g).holder;
  holding_read(reinterpret_cast<const Record*>(g.grains.records + first), count, (1u << count) - 1, &lanes);
  holding_find(g, group, lanes, holder);
  for (uint32_t l = 0; l < count; ++l) {
    const uint32_t slot = holder[l] == k_no_holder ? k_free : g.colliders.slots[holder[l]];
    holders[l] = slot < k_unknown ? static_cast<uint8_t>(slot) : k_free;
  }
}

// Finds the holders of up to four groups. True: one answer was good for all of them.
bool hold_together(const Granular& g, uint32_t first, uint32_t count, uint8_t* holders) {
  HeldGroup& group = scratch_of(g).group;
  Quad low = Quad{} + 3e38f, high = Quad{} - 3e38f;
  for (uint32_t i = first; i < first + count; ++i) {
    Quad at;
    __builtin_memcpy(&at, g.grains.records[i].position, sizeof at);
    low = at < low ? at : low;
    high = at > high ? at : high;
  }
  for (int k = 0; k < 3; ++k) {
    group.box.low[k] = low[k];
    group.box.high[k] = high[k];
  }
  holding_find_near(g, &group);
  const uint32_t holder = group.some ? holding_sole(g, group) : k_no_holder;
  if (group.some && holder == k_no_holder) {
    if (count <= k_lane_group) hold_lanes(g, group, first, count, holders);
    return count <= k_lane_group;
  }
  const uint32_t slot = holder == k_no_holder ? k_free : g.colliders.slots[holder];
  for (uint32_t l = 0; l < count; ++l) holders[l] = slot < k_unknown ? static_cast<uint8_t>(slot) : k_free;
  return true;
}

}  // namespace

void grain_carry_layout(GrainCarry* c, const sandglass_granular_desc& d, Layout* layout) {
  if (d.grain_capacity == 0) return;
  c->holders = layout_region<uint8_t>(layout, "granular.grain_holders", d.grain_capacity);
  c->met = layout_region<RigidPose>(layout, "granular.grains_met", d.collider_capacity);
  c->carried = layout_region<RigidPose>(layout, "granular.grains_carried", d.collider_capacity);
  c->next_met = layout_region<RigidPose>(layout, "granular.sweep_met", d.collider_capacity);
  c->next_carried = layout_region<RigidPose>(layout, "granular.sweep_carried", d.collider_capacity);
  c->moves = layout_region<uint8_t>(layout, "granular.grain_carriers", d.collider_capacity);
  c->next_moves = layout_region<uint8_t>(layout, "granular.sweep_carriers", d.collider_capacity);
  for (RigidMotion*& motions : c->motions)
    motions = layout_region<RigidMotion>(layout, "granular.grain_motions", d.collider_capacity);
}

void grain_carry_reset(GrainCarry* c, const Granular& g) {
  c->pending = c->next_pending = c->known = c->drawn = false;
  c->cursor = c->looked = c->unknown = 0;
  for (uint32_t slot = 0; slot < g.desc.collider_capacity && g.desc.grain_capacity != 0; ++slot) {
    c->moves[slot] = c->next_moves[slot] = 0;
    for (RigidMotion* motions : c->motions) motions[slot] = RigidMotion();
  }
}

void grain_carry_forget(GrainCarry* c, const Granular& g, uint32_t first) {
  if (first == 0) c->unknown = 0;
  for (uint32_t i = first / k_lane_group * k_lane_group; i < g.grains.count; i += k_lane_group) {
    c->unknown += i >= first || c->holders[i] != k_unknown ? 1 : 0;
    c->holders[i] = k_unknown;
  }
}

void grain_carry_regrouped(GrainCarry* c, const Granular& g) {
  if (c->unknown != (g.grains.count + k_lane_group - 1) / k_lane_group) grain_carry_forget(c, g, 0);
}

void grain_carry_refined(GrainCarry* c, const Granular& g, uint32_t begin, uint32_t end) {
  for (uint32_t at = begin; at < end; at += k_lane_group) {
    uint8_t* const first = &c->holders[g.grain_sleep.groups[at / k_lane_group] * k_lane_group];
    c->unknown += *first != k_unknown ? 1 : 0;
    *first = k_unknown;
  }
}

void grain_carry_begin_frame(GrainCarry* c, const Granular& g) {
  c->known = false;
  if (g.grains.count == 0) return;
  const bool current = is_current(g);
  bool news = false;
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    const uint32_t slot = g.colliders.slots[i];
    if (!current && g.colliders.jumps[slot] != k_is_new) continue;
    ColliderFrame frame;
    colliders_pose_met(g, i, &frame);
    c->met[slot] = c->carried[slot] = c->next_met[slot] = c->next_carried[slot] = rigid_pose(frame);
    c->moves[slot] = c->next_moves[slot] = 0;
    news = news || g.colliders.jumps[slot] == k_is_new;
  }
  if (news) grain_carry_forget(c, g, 0);
}

void grain_carry_begin_sweep(GrainCarry* c, const Granular& g) {
  c->next_pending = false;
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    const uint32_t slot = g.colliders.slots[i];
    c->next_met[slot] = c->next_carried[slot] = rigid_pose(g.colliders.sweep_frames[i]);
    c->next_moves[slot] = 0;
  }
}

void grain_carry_note(GrainCarry* c, const Granular& g) {
  const bool swept = sweep_has_snapshot(g);
  for (uint32_t i = 0; i < g.colliders.solid_count && g.grains.count != 0; ++i) {
    const Carrier& carrier = g.colliders.carriers[i];
    const uint32_t slot = g.colliders.slots[i], group = g.carry.group_of[i];
    if (!carrier.moves) continue;
    const bool holds = group != k_carry_groups && g.carry.groups[group].hollow && !is_empty(g.carry.held[group]);
    if (!holds || !swept) move_pose(&c->carried[slot], carrier.motion);
    if (!holds || swept) move_pose(&c->next_carried[slot], carrier.motion);
    if (!holds) {
      move_pose(&c->met[slot], carrier.motion);
      move_pose(&c->next_met[slot], carrier.motion);
    } else if (swept) c->next_pending = true;
    else c->pending = true;
  }
}

uint32_t grain_carry_moved(const Granular& g) {
  const Sweep& s = g.sweep;
  if (s.phase == SweepPhase::carry) return s.cursor;
  if (s.phase != SweepPhase::refine) return 0;
  const uint32_t at = s.cursor / k_lane_group;
  return at < g.grain_sleep.group_count ? g.grain_sleep.groups[at] * k_lane_group : g.grains.count;
}

GrainStance grain_carry_stance(const Granular& g, bool moved) {
  const GrainCarry& c = g.grain_carry;
  if (!moved) return {c.met, c.moves};
  if (g.sweep.phase == SweepPhase::carry) return {c.carried, c.moves};
  return {c.next_met, c.next_moves};
}

bool grain_carry_take_motions(GrainCarry* c, const Granular& g, bool moved) {
  uint8_t* const moves = moved && g.sweep.phase != SweepPhase::carry ? c->next_moves : c->moves;
  bool more = false, any = false;
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    const Carrier& carrier = g.colliders.carriers[i];
    const uint32_t slot = g.colliders.slots[i];
    c->motions[moved ? 1 : 0][slot] = carrier.motion;
    const uint32_t group = g.carry.group_of[i];
    const bool holds = c->pending || c->next_pending || (group != k_carry_groups && g.carry.groups[group].hollow);
    any = any || (carrier.moves && holds);
    more = more || (carrier.moves && moves[slot] == 0);
    if (carrier.moves) moves[slot] = 1;
  }
  if (more) grain_carry_forget(c, g, 0);
  return any;
}

bool grain_carry_is_due(const Granular& g) {
  const GrainCarry& c = g.grain_carry;
  if (g.grains.count == 0 || !g.carry.closing) return false;
  if (c.known || !may_hold(g)) return c.known && c.cursor < g.grains.count;
  return c.drawn || !is_current(g) || g.time.debt >= k_time_resolution;
}

void grain_carry_begin(GrainCarry* c, const Granular& g, bool any) {
  c->known = true;
  c->drawn = any;
  c->cursor = any && c->unknown != 0 && !time_paused(g) ? 0 : g.grains.count;
  c->looked = 0;
}

uint32_t grain_carry_find(GrainCarry* c, const Granular& g, uint32_t begin, uint32_t end) {
  uint32_t looked = 0;
  while (begin < end && looked < g.unit) {
    const uint32_t count = end - begin < k_held_together ? end - begin : k_held_together;
    bool all = true;
    for (uint32_t i = 0; i < count; i += k_lane_group) all = all && c->holders[begin + i] == k_unknown;
    if (!all || !hold_together(g, begin, count, c->holders + begin)) {
      for (uint32_t i = begin; i < begin + count; i += k_lane_group) {
        const uint32_t left = begin + count - i;
        if (c->holders[i] == k_unknown) {
          hold_together(g, i, left < k_lane_group ? left : k_lane_group, c->holders + i);
          looked += k_lane_group;
        }
      }
    } else {
      looked += count;
    }
    begin += count;
  }
  c->looked += looked;
  c->unknown -= (looked + k_lane_group - 1) / k_lane_group;
  return begin;
}

void grain_carry_found(GrainCarry* c, uint32_t cursor) { c->cursor = cursor; }

bool grain_carry_take(GrainCarry* c, const Granular& g, uint32_t begin, uint32_t end) {
  bool any = false;
  RigidMotion* const motions = c->motions[1];
  for (uint32_t slot = 0; slot < g.desc.collider_capacity; ++slot) {
    const RigidPose &from = c->met[slot], &to = c->carried[slot];
    motions[slot] = rigid_motion(from, to);
  }
  for (uint32_t i = begin; i < end; ++i) {
    const uint8_t holder = c->holders[i];
    if (holder >= k_unknown || __builtin_memcmp(&c->met[holder], &c->carried[holder], sizeof *c->met) == 0) continue;
    Grain* grain = &g.grains.records[i];
    Quad halves[2];
    static_assert(sizeof halves == sizeof *grain);
    const uint32_t number = grain->number;
    const float still = grain->still_sweeps;
    __builtin_memcpy(halves, grain, sizeof halves);
    halves[0] += motions[holder].displacement(halves[0]);
    halves[1] += motions[holder].turned(halves[1]);
    __builtin_memcpy(grain, halves, sizeof halves);
    grain->number = number;
    grain->still_sweeps = still;
    any = true;
  }
  return any;
}

void grain_carry_taken(GrainCarry* c) {
  RigidPose* const met = c->carried;
  c->carried = c->met;
  c->met = met;
  c->pending = false;
}

void grain_carry_complete(GrainCarry* c) {
  RigidPose *const met = c->met, *const carried = c->carried;
  uint8_t* const moves = c->moves;
  c->met = c->next_met;
  c->carried = c->next_carried;
  c->moves = c->next_moves;
  c->next_met = met;
  c->next_carried = carried;
  c->next_moves = moves;
  c->pending = c->next_pending;
  c->next_pending = false;
}

void grain_carry_settle(GrainCarry* c, const Granular& g) {
  c->known = c->drawn = false;
  grain_carry_forget(c, g, 0);
}

GrainMotions grain_carry_motions(const Granular& g) {
  const GrainCarry& c = g.grain_carry;
  return {c.known && c.drawn ? c.holders : nullptr, {c.motions[0], c.motions[1]}, grain_carry_moved(g)};
}

}  // namespace sandglass
