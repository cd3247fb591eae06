// What colliders hold goes with them where they go on without time for it. solver.h has the rules, holding.cpp who is held.
#include "runtime/sand/giving.h"

namespace sandglass {

namespace {

constexpr float k_same_motion = 0.25f;  // radii by which displacements of one motion may differ
constexpr float k_same_share = 0.05f;   // or this share of them: parts that turn fast are given straight velocities
constexpr float k_unseen = 0.5f;        // radii by which sand may lag behind what is drawn
constexpr float k_unseen_alone = 0.7f;  // where one ball or box alone moves
constexpr float k_rubbed = 0.5f;   // of the time given up, what counts for the friction of what only lies on a collider
constexpr float k_pressed = 0.5f;  // radii from another collider; what is nearer is pressed into it
constexpr float k_room_step = 1.5f;    // radii that are looked at at once; no wall of two radii lies between
constexpr uint32_t k_room_steps = 32;  // at most

// ---- moving what is held

// Where to, and what is gained: `more` times the collider's velocity, as the displacement of a point in a second. No
// speed exceeds speed_max, what a sub-step allows.
struct CarriedMotion {
  RigidMotion motion, gain;
  float speed_max;
};

CarriedMotion carried_motion(const Granular& g, const Carrier& carrier, float more) {
  const float* s = carrier.from.angular;
  const float spin[3][3] = {{0, s[2], -s[1]}, {-s[2], 0, s[0]}, {s[1], -s[0], 0}};
  CarriedMotion c = {carrier.motion, {}, g.desc.courant * g.desc.particle_radius / g.substep.length};
  const auto gained = [&](const float u[3]) { return (quad(u) + c.motion.turned(quad(u))) * more; };
  for (int k = 0; k < 3; ++k) c.gain.turn[k] = gained(spin[k]);
  c.gain.from = c.motion.from;
  c.gain.shift = gained(carrier.from.linear);
  return c;
}

// A copy of the particles of the bits, which holds `scale` seconds of their velocities. The motion is copied, too: it
// stays in registers, whatever is written.
void carry_copies(const CarriedMotion& carried, float scale, Particle* records, uint32_t which) {
  const CarriedMotion c = carried;
  const float limit = c.speed_max * scale;
  for_bits(which, records, [&](Particle* p) {
    const uint32_t identity = p->identity;
    Quad at, velocity;
    __builtin_memcpy(&at, p->position, sizeof at);
    __builtin_memcpy(&velocity, p->velocity, sizeof velocity);
    const Quad arm = at - c.motion.from;
    at += c.motion.turned(arm) + c.motion.shift;
    velocity += c.motion.turned(velocity);
    if (scale != 0.0f) {
      velocity += (c.gain.turned(arm) + c.gain.shift) * scale;
      const float speed2 = square_of(velocity);
      if (speed2 > limit * limit) velocity *= limit / __builtin_sqrtf(speed2);
    }
    __builtin_memcpy(p->position, &at, sizeof at);
    __builtin_memcpy(p->velocity, &velocity, sizeof velocity);
    p->identity = identity;  // no number
  });
}

// What a particle's copies hold as velocity while a sub-step is under way: so many seconds of it. 1: a velocity. 0: there
// is none under way.
float second_scale(const Granular& g, uint32_t group, uint32_t active_before) {
  const SubstepPhase phase = g.substep.phase;
  if (phase < SubstepPhase::stabilise || phase > SubstepPhase::bodies) return 0.0f;
  const bool last =
      phase == SubstepPhase::complete || (phase == SubstepPhase::solve && g.contacts.pass + 1 == g.contacts.iterations);
  const bool active = active_before < g.sleep.active_count && g.sleep.active_groups[active_before] == group;
  if (phase == SubstepPhase::stabilise || !active) return 1.0f;
  return last && active_before * k_lane_group < g.substep.cursor ? 1.0f : g.substep.length;
}

void carry_bits(Carry* c, const Granular& g, const Sixteen& it, uint32_t which, const CarriedMotion& carried,
                float gains, bool hollow) {
  for (uint32_t copy = 0; copy < 3; ++copy) {
    if (g.particles.records[copy] == nullptr) continue;
    Particle* const records = g.particles.records[copy] + it.first;
    const float scale = copy == 0 ? 1.0f : it.scale;
    if (scale != 0.0f) carry_copies(carried, gains * scale, records, which & it.awake);
    carry_copies(carried, 0.0f, records, which & ~it.awake);
  }
  const Particle* const records = g.particles.records[0] + it.first;
  for (uint32_t rest = which & ~it.awake; rest != 0; rest &= rest - 1)
    bounds_include(&c->resting, records[__builtin_ctz(rest)].position);
  sleep_carry(g, records, which, carried.motion);
  if (hollow) motion_carry(g.motion, g, records, which, carried.motion);
}

// Moves one that only lies on a collider: with its rise and fall, and else by the share of its displacement that
// the particle has of its velocity. Friction brings that share nearer to 1.
void carry_lying(Carry* c, const Granular& g, const Sixteen& it, uint32_t i, uint32_t holder) {
  const Carrier& carrier = g.colliders.carriers[holder];
  const Particle& p = g.particles.records[0][i];
  CarriedMotion carried = {{}, {}, g.desc.courant * g.desc.particle_radius / g.substep.length};
  const Quad down = quad(scratch_of(g).group.down), displacement = carrier.motion.displacement(quad(p.position));
  float carrier_velocity[3];
  holding_velocity(carrier.from, p.position, carrier_velocity);
  const Quad sinks = dot(displacement, down) * down, level = displacement - sinks,
             falls = dot(quad(carrier_velocity), down) * down;
  const Quad v = quad(carrier_velocity) - falls;
  const float v2 = square_of(v), rate = static_cast<float>(g.time.rate) / c->faster;
  const float with = v2 > 0.0f ? dot(v, quad(p.velocity)) / v2 : 1.0f,
              had = with > 0.0f ? (with < 1.0f ? with : 1.0f) : 0.0f;
  const float rubs =
      k_rubbed * g.desc.kinetic_friction * g.gravity_length * __builtin_sqrtf(square_of(level)) * rate * rate;
  const float share = is_asleep(p) || had * v2 + rubs >= v2 ? 1.0f : had + rubs / v2;
  carried.motion.shift = share * level + sinks;
  carried.gain.shift = (c->faster * share - had) * v + (c->faster - 1.0f) * falls;
  const float length = __builtin_sqrtf(square_of(carried.motion.shift));
  Bounds& held = c->held[c->group_of[holder]];
  bounds_include(&held, p.position);
  carry_bits(c, g, it, 1u << (i - it.first), carried, 1.0f, false);
  bounds_include(&held, p.position);
  c->displacement_max = length > c->displacement_max ? length : c->displacement_max;
  float speed2 = 0.0f;
  for (const float u : p.velocity) speed2 += u * u;
  c->fastest2 = speed2 > c->fastest2 ? speed2 : c->fastest2;
  c->gave_way = c->gave_way || share < 1.0f;
}

// Moves those that one collider holds, in all that is kept of them. Returns the longest displacement; *after holds all
// of them.
float carry_some(Carry* c, const Granular& g, const Sixteen& it, uint32_t holder, uint32_t mask, Bounds* after) {
  const Carrier& carrier = g.colliders.carriers[holder];
  const float more = c->faster - 1.0f, gains = more != 0.0f ? 1.0f : 0.0f;
  const CarriedMotion carried = carried_motion(g, carrier, more);
  const float displacement = carry_box(carrier.motion, it.box, after);
  Bounds& held = c->held[c->group_of[holder]];
  bounds_join(&held, it.box);
  bounds_join(&held, *after);
  c->displacement_max = displacement > c->displacement_max ? displacement : c->displacement_max;
  const bool hollow = c->groups[c->group_of[holder]].hollow;
  carry_bits(c, g, it, mask, carried, gains, hollow);
  return displacement;
}

// ---- what stands

// Those of what only lies on a collider that have room wherever it takes them, between all that goes elsewhere. The
// rest is not pressed into that, nor carried through a wall.
uint32_t find_room(const Granular& g, uint32_t holder, const HeldLanes& lanes, uint32_t mask) {
  const float r = g.desc.particle_radius;
  HeldScratch& scratch = scratch_of(g);
  auto &at = scratch.traced, &displacements = scratch.normal;
  Bounds path = k_nowhere;
  float longest2 = 0.0f;
  for (uint32_t l = 0; l < lanes.count; ++l) {
    const float from[3] = {lanes.at[0][l], lanes.at[1][l], lanes.at[2][l]};
    const Quad displacement = g.colliders.carriers[holder].motion.displacement(quad(from)),
               there = quad(from) + displacement;
    const float end[3] = {there[0], there[1], there[2]}, length2 = square_of(displacement);
    for (int k = 0; k < 3; ++k) displacements[k][l] = displacement[k];
    if ((mask >> l & 1) == 0) continue;
    bounds_include(&path, from);
    bounds_include(&path, end);
    longest2 = length2 > longest2 ? length2 : longest2;
  }
  const float parts = __builtin_sqrtf(longest2) / (k_room_step * r);
  for (uint32_t i = 0; i < g.colliders.solid_count && mask != 0; ++i) {
    const Carrier& other = g.colliders.carriers[i];
    if (g.carry.group_of[i] == g.carry.group_of[holder]) continue;
    Bounds reached = g.carry.reaches[i];
    if (other.moves) bounds_join(&reached, holding_box(other.to));
    if (!holding_overlaps(path, reached, 2.0f * r)) continue;
    const bool flat = other.to.shape == SANDGLASS_SHAPE_HALF_SPACE;
    const uint32_t steps = flat ? 1 : parts < k_room_steps ? static_cast<uint32_t>(parts) + 1 : k_room_steps;
    for (uint32_t s = 1; s <= steps && mask != 0; ++s) {
      const float share = static_cast<float>(s) / static_cast<float>(steps);
      for (int k = 0; k < 3; ++k)
        for (uint32_t l = 0; l < lanes.count; ++l) at[k][l] = lanes.at[k][l] + share * displacements[k][l];
      holding_measure(g, holding_posed(g, other, share), at, scratch.distance, lanes.count);
      for (uint32_t l = 0; l < lanes.count; ++l) mask &= scratch.distance[l] < k_pressed * r ? ~(1u << l) : ~0u;
    }
  }
  return mask;
}

// What was moved is in nothing that stands.
bool may_meet_standing(const Granular& g, uint32_t group, const Bounds& here) {
  const float r = g.desc.particle_radius;
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    const ColliderFrame& c = g.colliders.carriers[i].to;
    if (!carry_stands(g, i, group) || !holding_overlaps(here, g.carry.reaches[i], r)) continue;
    if (c.shape != SANDGLASS_SHAPE_HALF_SPACE) return true;
    float nearest = 0.0f;
    for (int k = 0; k < 3; ++k)
      nearest += c.axes[1][k] * ((c.axes[1][k] > 0.0f ? here.low[k] : here.high[k]) - c.position[k]);
    if (nearest < r) return true;
  }
  return false;
}

// ---- sixteen particles

// Around those of the bits. The fourth sides are mobilities. Returns what is set in one of their identities.
uint32_t find_box(const Particle* records, uint32_t which, Quad* low, Quad* high) {
  typedef uint32_t Words __attribute__((vector_size(16)));
  Quad l = Quad{} + 3e38f, h = Quad{} - 3e38f;
  Words all = {};
  for_bits(which, records, [&](const Particle* p) {
    Quad at;
    Words words;
    __builtin_memcpy(&at, p->position, sizeof at);
    __builtin_memcpy(&words, p->velocity, sizeof words);
    l = at < l ? at : l;
    h = at > h ? at : h;
    all |= words;
  });
  *low = l;
  *high = h;
  return all[3];
}

Bounds box_of(const Quad& low, const Quad& high) { return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}}; }

void read_sixteen(const Granular& g, uint32_t group, uint32_t active_before, Sixteen* it) {
  it->first = group * k_lane_group;
  it->count = g.particles.count - it->first < k_lane_group ? g.particles.count - it->first : k_lane_group;
  it->scale = second_scale(g, group, active_before);
  const Particle* const records = g.particles.records[0] + it->first;
  Quad low, high;
  it->here = it->free = it->awake = (1u << it->count) - 1;
  if (find_box(records, it->here, &low, &high) > k_number_mask) {  // not sand alone
    for (uint32_t l = 0; l < it->count; ++l) {
      it->here &= has_departed(records[l]) ? ~(1u << l) : ~0u;
      it->free &= has_departed(records[l]) || in_body(records[l]) ? ~(1u << l) : ~0u;
    }
    find_box(records, it->here, &low, &high);
  }
  for (uint32_t l = 0; l < it->count && !(low[3] > 0.0f); ++l) it->awake &= is_awake(records[l]) ? ~0u : ~(1u << l);
  it->box = box_of(low, high);
}

// Out of what stands, of each by no more than depth_max.
void leave_standing(const Granular& g, uint32_t group, float depth_max, Quad* at) {
  const float r = g.desc.particle_radius;
  const Bounds here = {{(*at)[0], (*at)[1], (*at)[2]}, {(*at)[0], (*at)[1], (*at)[2]}};
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    const ColliderFrame& c = g.colliders.carriers[i].to;
    const bool flat = c.shape == SANDGLASS_SHAPE_HALF_SPACE;
    if (!carry_stands(g, i, group) || (!flat && !holding_overlaps(here, g.carry.reaches[i], r))) continue;
    Quad normal;
    const float depth = r - holding_distance(g, c, *at, &normal);
    if (depth > 0.0f) *at += (depth < depth_max ? depth : depth_max) * normal;
  }
}

// Moves lanes that were moved so far out of what stands.
void settle_lanes(Carry* c, const Granular& g, uint32_t group, const Sixteen& it, const float moved[k_lane_group]) {
  for (uint32_t l = 0; l < it.count; ++l) {
    if (!(moved[l] > 0.0f) || (it.free >> l & 1) == 0) continue;
    Quad at = quad(g.particles.records[0][it.first + l].position);
    leave_standing(g, group, moved[l], &at);
    carry_put(c, g, it.first + l, at);
  }
}

// The collider that holds all in the box, for certain; else k_no_holder.
uint32_t sole_holder(const Granular& g, const Bounds& box) {
  HeldGroup& group = scratch_of(g).group;
  group.box = box;
  holding_find_near(g, &group);
  return group.some ? holding_sole(g, group) : k_no_holder;
}

// All by one collider. False: some are of bodies, or departed.
bool carry_all(Carry* c, const Granular& g, const Sixteen& it, uint32_t holder) {
  const uint32_t all = (1u << it.count) - 1;
  if (it.free != all) return false;
  Bounds after = k_nowhere;
  const float displacement = carry_some(c, g, it, holder, all, &after);
  if (!may_meet_standing(g, c->group_of[holder], after)) return true;
  auto& moved = scratch_of(g).moved;
  for (float& m : moved) m = displacement;
  settle_lanes(c, g, c->group_of[holder], it, moved);
  return true;
}

// `sole`: holds all of them, if it is known.
void run_group(Carry* c, const Granular& g, const Sixteen& it, uint32_t sole) {
  if (sole != k_no_holder && carry_all(c, g, it, sole)) return;
  HeldGroup& group = scratch_of(g).group;
  group.box = it.box;
  holding_find_near(g, &group);
  if (group.some && sole == k_no_holder) sole = holding_sole(g, group);
  if (sole != k_no_holder && carry_all(c, g, it, sole)) return;
  HeldLanes& lanes = scratch_of(g).lanes;
  auto& holder = scratch_of(g).holder;
  auto& moved = scratch_of(g).moved;
  bool some = group.some || it.here != it.free;
  if (some) {
    holding_read(reinterpret_cast<const Record*>(g.particles.records[0] + it.first), it.count, it.here, &lanes);
    some = holding_find(g, group, lanes, holder) || it.here != it.free;
  }
  if (!some) {
    giving_note(c, g, it.box, it.first, it.free, it.scale);
    return bounds_join(&c->standing, it.box);
  }
  uint32_t held = 0;
  for (float& m : moved) m = 0.0f;
  bool alike = holder[0] != k_no_holder && c->groups[c->group_of[holder[0]]].hollow;
  for (uint32_t l = 1; l < it.count; ++l) alike = alike && holder[l] == holder[0];
  if (alike && carry_all(c, g, it, holder[0])) return;
  for (uint32_t l = 0; l < it.count; ++l) {
    if ((it.here >> l & 1) == 0) continue;
    const Particle& p = g.particles.records[0][it.first + l];
    const uint32_t of_body = in_body(p) ? c->body_holders[body_of(p) - 1] : 0;
    if (in_body(p)) holder[l] = of_body != 0 ? of_body - 1 : k_no_holder;
    held |= holder[l] != k_no_holder ? 1u << l : 0;
  }
  Quad low, high;
  find_box(g.particles.records[0] + it.first, it.here & ~held, &low, &high);
  bounds_join(&c->standing, box_of(low, high));
  uint32_t open = it.free & ~held;
  while (held != 0) {
    const uint32_t by = holder[__builtin_ctz(held)];
    uint32_t mask = 0;
    for (uint32_t l = 0; l < it.count; ++l) mask |= (held >> l & 1) != 0 && holder[l] == by ? 1u << l : 0;
    held &= ~mask;
    const uint32_t lies = c->groups[c->group_of[by]].hollow ? 0 : mask & it.free;
    const uint32_t stays = lies & ~find_room(g, by, lanes, lies);
    open |= stays;
    mask &= ~stays;
    for (uint32_t l = 0; l < it.count; ++l)
      if ((lies & mask) >> l & 1) {
        carry_lying(c, g, it, it.first + l, by);
        moved[l] = c->displacement_max;
      }
    mask &= ~lies;
    if (mask == 0) continue;
    Bounds after = k_nowhere;
    const float displacement = carry_some(c, g, it, by, mask, &after);
    for (uint32_t l = 0; l < it.count; ++l) moved[l] = (mask >> l & 1) != 0 ? displacement : moved[l];
  }
  giving_note(c, g, it.box, it.first, open, it.scale);
  settle_lanes(c, g, carry_group_alone(*c), it, moved);
}

// ---- the colliders

// Groups of colliders that share one motion.
void find_groups(Carry* c, const Granular& g) {
  const float same = k_same_motion * g.desc.particle_radius;
  c->group_count = 0;
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    const Carrier& carrier = g.colliders.carriers[i];
    c->group_of[i] = k_carry_groups;
    c->reaches[i] = holding_box(carrier.from);
    if (!carrier.moves) continue;
    uint32_t at = 0;
    for (; at < c->group_count; ++at) {
      const Carrier& first = g.colliders.carriers[c->groups[at].first];
      const float* const places[] = {carrier.from.position, first.from.position};
      bool alike = true;
      for (const float* place : places) {
        const Quad displacement = carrier.motion.displacement(quad(place));
        const float squared = square_of(displacement - first.motion.displacement(quad(place)));
        alike = alike && (squared <= same * same || squared <= k_same_share * k_same_share * square_of(displacement));
      }
      if (alike) break;
    }
    if (at == k_carry_groups) continue;
    if (at == c->group_count) {
      Bounds near = c->reaches[i], unused = k_nowhere;
      for (int k = 0; k < 3; ++k) {
        near.low[k] = near.low[k] > g.particles.low[k] ? near.low[k] : g.particles.low[k];
        near.high[k] = near.high[k] < g.particles.high[k] ? near.high[k] : g.particles.high[k];
      }
      c->groups[c->group_count++] = {i, 0, k_nowhere, false, carry_box(carrier.motion, near, &unused) < same};
    }
    CarryGroup& group = c->groups[at];
    c->group_of[i] = static_cast<uint8_t>(at);
    if (carrier.from.shape == SANDGLASS_SHAPE_HALF_SPACE || carrier.from.shape == SANDGLASS_SHAPE_RELIEF) continue;
    ++group.members;
    group.hollow = group.members > 1 || carrier.from.shape == SANDGLASS_SHAPE_FIELD;
    holding_join(&group.box, g.colliders.carriers[group.first].from, carrier.from);
  }
  for (Bounds& held : c->held) held = k_nowhere;
}

// A body goes by its centre, whole.
void carry_bodies(Carry* c, const Granular& g) {
  for (uint32_t b = 0; b < g.bodies.count; ++b) {
    c->body_holders[b] = 0;
    if (!bodies_has(g.bodies, b) || c->group_count == 0) continue;
    HeldLanes& lanes = scratch_of(g).lanes;
    HeldGroup& group = scratch_of(g).group;
    lanes = {};
    auto& holder = scratch_of(g).holder;
    lanes.count = 1;
    for (int k = 0; k < 3; ++k) {
      lanes.at[k][0] = group.box.low[k] = group.box.high[k] = static_cast<float>(g.bodies.all[b].center[k]);
    }
    lanes.velocities = g.bodies.all[b].linear;
    holding_find_near(g, &group);
    holding_find(g, group, lanes, holder);
    if (holder[0] == k_no_holder) continue;
    const Carrier& carrier = g.colliders.carriers[holder[0]];
    const float center[3] = {lanes.at[0][0], lanes.at[1][0], lanes.at[2][0]};
    float gain[3];
    holding_velocity(carrier.from, center, gain);
    carrier.motion.rotate(gain);
    for (float& v : gain) v *= c->faster - 1.0f;
    bodies_carry(g, b, carrier.motion, gain);
    c->body_holders[b] = static_cast<uint16_t>(holder[0] + 1);
  }
}

// Cut evenly: a short last unit would look dear for its items.
uint32_t unit_of(const Granular& g) {
  const uint32_t count = g.particles.count, parts = count / g.unit + 1, part = (count + parts - 1) / parts;
  return (part + k_lane_group - 1) / k_lane_group * k_lane_group;
}

}  // namespace

float carry_box(const RigidMotion& motion, const Bounds& box, Bounds* after) {
  const auto sizes = [](const Quad& v) { return v < 0.0f ? -v : v; };
  const Quad half = 0.5f * (quad(box.high) - quad(box.low)), middle = quad(box.low) + half,
             displacement = motion.displacement(middle);
  Quad reach = {}, more = {};  // of what is beside the middle: how far from it; how much more it moves
  for (int k = 0; k < 3; ++k) {
    Quad axis = {};
    axis[k] = half[k];
    reach += sizes(axis + half[k] * motion.turn[k]);
    more += sizes(half[k] * motion.turn[k]);
  }
  const Quad low = middle + displacement - reach, high = middle + displacement + reach;
  bounds_join(after, {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}});
  return __builtin_sqrtf(square_of(displacement)) + __builtin_sqrtf(square_of(more));
}

bool carry_stands(const Granular& g, uint32_t i, uint32_t group) {
  const uint32_t its = g.carry.group_of[i];
  return its == k_carry_groups || (its != group && g.carry.groups[its].slow);
}

void carry_put(Carry* c, const Granular& g, uint32_t i, const Quad& to) {
  const Particle& p = g.particles.records[0][i];
  const Quad displacement = to - quad(p.position);
  const float squared = square_of(displacement), length = __builtin_sqrtf(squared);
  if (squared == 0.0f) return;
  for (Particle* records : g.particles.records)
    for (int k = 0; k < 3 && records != nullptr; ++k) records[i].position[k] += displacement[k];
  c->displacement_max = length > c->displacement_max ? length : c->displacement_max;
  c->gave_way = true;
  bounds_include(&c->pushed, p.position);
  if (is_asleep(p)) bounds_include(&c->resting, p.position);
}

void carry_layout(Carry* c, const sandglass_granular_desc& d, Layout* layout) {
  c->group_of = layout_region<uint8_t>(layout, "granular.carry_groups", d.collider_capacity);
  c->reaches = layout_region<Bounds>(layout, "granular.carry_reaches", d.collider_capacity);
  c->scratch = layout_region<HeldScratch>(layout, "granular.carry_scratch", 1);
  giving_layout(c, d, layout);
}

void carry_reset(Carry* c) {
  *c->scratch = {};
  c->due = Carry::Moment::none;
  c->moving = c->may_lag = c->closing = c->known = c->usual = c->holds = false;
  c->cursor = 0;
}

// Whether sand that stays behind is seen to.
static bool lag_is_seen(const Granular& g) {
  return colliders_lag(g) > (colliders_may_hold(g) ? k_unseen : k_unseen_alone) * g.desc.particle_radius;
}

void carry_begin_frame(Carry* c, const Granular& g, bool jumped, bool moving) {
  c->due = jumped ? Carry::Moment::jump : Carry::Moment::none;
  c->moving = moving;
  c->may_lag = moving && lag_is_seen(g);
  c->closing = c->known = false;
  c->cursor = 0;
}

void carry_close(Carry* c, const Granular& g) {
  const bool over = g.time.rate < 1.0 && g.time.debt < k_time_resolution;  // slow motion ends
  if (c->moving && !c->closing && (lag_is_seen(g) || over)) c->due = Carry::Moment::close;
  c->closing = true;
  c->known = false;
}

bool carry_is_due(const Granular& g) {
  if (g.carry.due != Carry::Moment::close) return g.carry.due == Carry::Moment::jump;
  return g.carry.known || g.time.debt >= k_time_resolution || g.time.rate < 1.0;
}

bool carry_is_expected(const Granular& g) { return g.carry.may_lag; }

uint32_t carry_units(const Granular& g) { return (g.particles.count + unit_of(g) - 1) / unit_of(g); }

// All have been looked at, and some are to give way.
static bool gives_way(const Granular& g) {
  return g.carry.known && g.carry.cursor >= g.particles.count && giving_items(g.carry) != 0;
}

static uint32_t carry_items(const Granular& g) {
  const uint32_t begun = g.carry.known ? g.carry.cursor : 0, left = g.particles.count - begun, unit = unit_of(g);
  return left < unit ? left : unit;
}

void carry_unit(const Granular& g, WorkUnit* unit) {
  *unit = {k_unit_carry, carry_items(g), "granular.carry"};
  if (gives_way(g)) *unit = {k_unit_push, giving_items(g.carry), "granular.push"};
}

void carry_find_groups(Carry* c, const Granular& g) { find_groups(c, g); }

void carry_begin(Carry* c, const Granular& g, float faster) {
  c->known = true;
  c->faster = faster;
  c->cursor = 0;
  c->gave_way = false;
  c->pushed = c->resting = c->standing = k_nowhere;
  c->displacement_max = c->fastest2 = 0.0f;
  find_groups(c, g);
  giving_begin(c, g);
  carry_bodies(c, g);
}

bool carry_run(Carry* c, const Granular& g) {
  if (gives_way(g)) return giving_run(c, g);
  const uint32_t end = c->cursor + carry_items(g);
  const Sleep& sleep = g.sleep;
  uint32_t active = 0;
  while (active < sleep.active_count && sleep.active_groups[active] < c->cursor / k_lane_group) ++active;
  for (uint32_t group = c->cursor / k_lane_group; group * k_lane_group < end && c->group_count != 0;) {
    auto& sixteens = scratch_of(g).sixteens;
    Bounds box = k_nowhere;
    uint32_t count = 0;
    for (; count < k_together && group * k_lane_group < end; ++count, ++group) {
      read_sixteen(g, group, active, &sixteens[count]);
      bounds_join(&box, sixteens[count].box);
      if (active < sleep.active_count && sleep.active_groups[active] == group) ++active;
    }
    const uint32_t sole = is_empty(box) ? k_no_holder : sole_holder(g, box);
    for (uint32_t i = 0; i < count; ++i)
      if (sixteens[i].here != 0) run_group(c, g, sixteens[i], sole);
  }
  c->cursor = end;
  return c->group_count == 0 || (end >= g.particles.count && giving_items(*c) == 0);
}

void carry_end(Carry* c) {
  if (c->due == Carry::Moment::close) {
    c->usual = true;
    c->holds = false;
    for (uint32_t i = 0; i < c->group_count; ++i) c->holds = c->holds || (c->groups[i].hollow && !is_empty(c->held[i]));
  }
  c->due = Carry::Moment::none;
  c->known = false;
}

Bounds carry_bounds(const Carry& c, float margin) {
  Bounds all = c.pushed;
  for (uint32_t i = 0; i < c.group_count; ++i) bounds_join(&all, c.held[i]);
  for (int k = 0; k < 3 && !is_empty(all); ++k) {
    all.low[k] -= margin;
    all.high[k] += margin;
  }
  return all;
}

bool carry_mixes(const Granular& g) {
  const Carry& c = g.carry;
  const float reach = neighbours_reach(g);
  for (uint32_t a = 0; a < c.group_count && !c.gave_way; ++a) {
    if (is_empty(c.held[a])) continue;
    if (!is_empty(c.standing) && holding_overlaps(c.held[a], c.standing, reach)) return true;
    for (uint32_t b = 0; b < a; ++b)
      if (!is_empty(c.held[b]) && holding_overlaps(c.held[a], c.held[b], reach)) return true;
  }
  return c.gave_way;
}

}  // namespace sandglass
