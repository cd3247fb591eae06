// Which collider of a frame's list is which of those that are known, and what sand meets of it in this frame.
#include "runtime/sand/collider_placement.h"

namespace sandglass {
namespace {

constexpr double k_distance_min = 1e-6;  // metres or radians; what is shorter counts as none
constexpr float k_gone_seconds = 0.25f;  // after so long, one that is not passed is no longer recognised by its place
constexpr float k_as_large = 2.0f;       // of what has no id: a size may grow so much in a frame
constexpr float k_recognised = 0.25f;    // metres that a collider may have gone since the last frame
constexpr float k_recognised_id = 1.0f;  // and one with an id
constexpr float k_found_again = 0.01f;   // and that one without an id may, if it was not passed then
constexpr float k_lost_id = 0.05f;       // metres that one may go while it has lost its id
constexpr float k_in_place = 0.003f;     // metres; at its place in the list, one that is so near is the same

// ---- recognising

bool equal3(const float a[3], const float b[3]) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }

bool free_slot(const Colliders& c, uint32_t slot, const sandglass_collider& now) {
  const KnownCollider& known = c.known[slot];
  return known.used != 0 && c.seen_by[slot] == SeenBy::none && known.shape == now.shape && known.id == now.id;
}

bool equal_pose(const KnownCollider& known, const sandglass_collider& now) {
  const Pose& given = known.pose.given;
  return equal3(given.position, now.position) && equal3(given.size, now.size) &&
         same_turn(given.rotation, now.rotation);
}

// Square of about how far a collider has gone since it was known.
float distance_squared(const KnownCollider& known, const sandglass_collider& now) {
  const Pose& given = known.pose.given;
  if (same_pose(given, pose_of(now))) return 0.0f;
  float sum = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const float shift = now.position[k] - given.position[k], more = now.size[k] - given.size[k];
    sum += (now.shape == SANDGLASS_SHAPE_HALF_SPACE ? 0.0f : shift * shift + more * more);
  }
  if (now.shape != SANDGLASS_SHAPE_HALF_SPACE) return sum;
  // A half-space may have slid along itself: what counts is how its plane lies.
  HoldRule at = {};
  for (int k = 0; k < 3; ++k) at.low[k] = at.high[k] = now.position[k];
  const float distance = surface_distance(now.shape, given, pose_of(now), at);
  return distance * distance;
}

// Whether sizes are about as they were: a hand is no table, though it lay where the table is given.
bool as_large(const Pose& given, const sandglass_collider& now) {
  const int sizes = now.shape == SANDGLASS_SHAPE_SPHERE    ? 1
                    : now.shape == SANDGLASS_SHAPE_CAPSULE ? 2
                    : now.shape == SANDGLASS_SHAPE_BOX     ? 3
                                                           : 0;
  bool as = true;
  for (int k = 0; k < sizes; ++k)
    as = as && now.size[k] <= k_as_large * given.size[k] && given.size[k] <= k_as_large * now.size[k];
  return as;
}

bool recognisable(const KnownCollider& known, const sandglass_collider& now, const SimulatedTime& t) {
  if (now.id == 0 && !as_large(known.pose.given, now)) return false;
  const bool passed = known.absent <= t.frame_step;
  float limit = now.id != 0 ? k_recognised_id : passed ? k_recognised : k_found_again;
  if (passed && t.left_out > 0.0f) limit += 2.0f * length_of(now.linear_velocity) * (t.frame_step + t.left_out);
  return known.absent < k_gone_seconds && distance_squared(known, now) <= limit * limit;
}

// The slot of a collider, by id or by an equal pose, the last passed if there are several; k_no_slot: neither.
uint32_t slot_by_identity(const Colliders& c, uint32_t capacity, const sandglass_collider& now, uint32_t place) {
  uint32_t found = k_no_slot;
  for (uint32_t slot = 0; slot < capacity; ++slot) {
    if (!free_slot(c, slot, now) || (now.id == 0 && !equal_pose(c.known[slot], now))) continue;
    if (found == k_no_slot || c.known[slot].absent < c.known[found].absent ||
        (c.known[slot].absent == c.known[found].absent && c.known[slot].place == place))
      found = slot;
  }
  return found;
}

// Whether another collider of the list, which has no slot yet either, lies nearer to a slot.
bool is_anothers(const Colliders& c, uint32_t capacity, const sandglass_frame_input& input, uint32_t slot,
                 const sandglass_collider& now, uint32_t place, const SimulatedTime& t) {
  const float own_squared = distance_squared(c.known[slot], now);
  uint32_t other_place = 0;
  for (uint32_t i = 0; i < input.collider_count && other_place < capacity; ++i) {
    sandglass_collider other;
    if (!collider_accept(input.colliders[i], &other)) continue;
    const uint32_t at = other_place++;
    if (at == place || c.slot_of_place[at] != k_no_slot || other.shape != now.shape || other.id != now.id) continue;
    if (recognisable(c.known[slot], other, t) && distance_squared(c.known[slot], other) < own_squared) return true;
  }
  return false;
}

// By its place in the list where it lies near, else the nearest, unless that is far and nearer to another; of two that
// are near the one that was passed in the last frame; else a slot for a new one, if need be of one that is not passed
// any more.
uint32_t slot_by_place(const Colliders& c, uint32_t capacity, const sandglass_frame_input& input,
                       const sandglass_collider& now, uint32_t place, const SimulatedTime& t) {
  uint32_t nearest = k_no_slot;
  float nearest2 = 0.0f;
  for (uint32_t slot = 0; slot < capacity; ++slot) {
    if (!free_slot(c, slot, now) || !recognisable(c.known[slot], now, t)) continue;
    const bool in_place = c.known[slot].place == place, passed = c.known[slot].absent <= t.frame_step;
    const float near2 = k_in_place * k_in_place, far2 = distance_squared(c.known[slot], now) + (passed ? 0.0f : near2);
    if (in_place && passed && far2 <= near2) return slot;
    if (nearest != k_no_slot && !(far2 < nearest2 || (far2 == nearest2 && in_place))) continue;
    const bool is_near = far2 <= k_found_again * k_found_again;
    if (is_near || !is_anothers(c, capacity, input, slot, now, place, t)) {
      nearest = slot;
      nearest2 = far2;
    }
  }
  if (nearest != k_no_slot) return nearest;
  uint32_t oldest = k_no_slot;
  for (uint32_t slot = 0; slot < capacity; ++slot) {
    if (c.known[slot].used == 0) return slot;
    if (c.seen_by[slot] != SeenBy::none || c.known[slot].absent == 0.0f) continue;
    if (oldest == k_no_slot || c.known[slot].absent > c.known[oldest].absent) oldest = slot;
  }
  return oldest;
}

// Whether `now` continues `before`, which was a frame of `step` seconds ago: it has not jumped.
bool continues(const Placement& before, const Placement& now, double step, float margin) {
  float shift2 = 0.0f, speed2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const float shift = now.pose.position[k] - before.pose.position[k];
    const float speed = __builtin_fabsf(before.linear[k]) + __builtin_fabsf(now.linear[k]);
    shift2 += shift * shift;
    speed2 += speed * speed;
  }
  return __builtin_sqrtf(shift2) <= static_cast<float>(step) * __builtin_sqrtf(speed2) + margin;
}

// The same of its turning, for what is as far from it as its sizes.
bool turns_on(const Placement& before, const Placement& now, double step, float margin) {
  const Pose &a = before.pose, &b = now.pose;
  float with = 0.0f, turn2 = 0.0f, speed2 = 0.0f, reach2 = 0.0f;
  for (int k = 0; k < 4; ++k) with += a.rotation[k] * b.rotation[k];
  for (int k = 0; k < 4; ++k) {
    const float d = b.rotation[k] - (with < 0.0f ? -a.rotation[k] : a.rotation[k]);
    turn2 += 4.0f * d * d;
  }
  for (int k = 0; k < 3; ++k) {
    const float speed = __builtin_fabsf(before.angular[k]) + __builtin_fabsf(now.angular[k]);
    speed2 += speed * speed;
    reach2 += b.size[k] * b.size[k];
  }
  return __builtin_sqrtf(turn2 * reach2) <= static_cast<float>(step) * __builtin_sqrtf(speed2 * reach2) + margin;
}

// ---- a frame's colliders

// The velocity at which a collider goes what is left of its distance and this frame's, in the simulated time that is
// left.
float spread(float left, double owed, float now, double step, double debt) {
  const double distance = static_cast<double>(left) * owed + static_cast<double>(now) * step;
  if (now == 0.0f && distance < k_distance_min && distance > -k_distance_min) return 0.0f;
  const double velocity = distance / debt, limit = static_cast<double>(k_collider_speed);
  return static_cast<float>(velocity < limit ? (velocity > -limit ? velocity : -limit) : limit);
}

// Whether a pushes before b: the smaller first, of equal ones the faster. A table that is followed may for a while be
// faster than the hand that presses on it. Equal ones are distinguished by their shapes and poses, not by their places.
bool pushes_before(const sandglass_collider& a, const sandglass_collider& b) {
  const bool endless = a.shape == SANDGLASS_SHAPE_HALF_SPACE, other_endless = b.shape == SANDGLASS_SHAPE_HALF_SPACE;
  if (endless != other_endless) return other_endless;
  const float a2 = square_of(quad(a.size)), b2 = square_of(quad(b.size));
  if (a2 != b2) return a2 < b2;
  const float va = fastness(a), vb = fastness(b);
  if (va != vb) return va > vb;
  if (a.shape != b.shape) return a.shape < b.shape;
  for (int k = 0; k < 3; ++k)
    if (a.position[k] != b.position[k]) return a.position[k] < b.position[k];
  for (int k = 0; k < 3; ++k)
    if (a.size[k] != b.size[k]) return a.size[k] < b.size[k];
  for (int k = 0; k < 4; ++k)
    if (a.rotation[k] != b.rotation[k]) return a.rotation[k] < b.rotation[k];
  return false;
}

// The slots that particles see first, each part in the order in which they push.
void order(Colliders* c, uint32_t capacity) {
  c->count = 0;
  constexpr SeenBy k_parts[] = {SeenBy::all, SeenBy::grains};
  for (const SeenBy part : k_parts) {
    const uint32_t first = c->count;
    for (uint32_t slot = 0; slot < capacity; ++slot) {
      if (c->seen_by[slot] != part) continue;
      uint32_t at = c->count++;
      for (; at > first && pushes_before(c->of_slot[slot], c->given[at - 1]); --at) {
        c->given[at] = c->given[at - 1];
        c->slots[at] = c->slots[at - 1];
        c->slides[at] = c->slides[at - 1];
      }
      c->given[at] = c->of_slot[slot];
      c->slots[at] = slot;
      c->slides[at] = c->slides_of_slot[slot];
    }
    if (part == SeenBy::all) c->solid_count = c->count;
  }
}

// What sand meets of a collider in this frame. owed: see colliders_take; 0 where how far it still has to go is not
// known.
void hold_slot(Colliders* colliders, const Granular& g, uint32_t slot, const sandglass_collider& now, double owed,
               const HoldRule& rule) {
  Colliders& c = *colliders;
  KnownCollider& known = c.known[slot];
  const double step = static_cast<double>(g.time.frame_step), debt = g.time.debt;
  const bool same_one =
      known.used != 0 && known.id == now.id && known.shape == now.shape && recognisable(known, now, g.time);
  const bool continued = same_one && known.absent <= g.time.frame_step;
  const Placement before = placement_of(c.of_slot[slot]);
  const float seconds = c.waits ? g.time.frame_step : known.absent + g.time.left_out;
  if (!same_one) hold_anew(&known.pose, placement_of(now));
  else if (step > 0.0) hold(&known.pose, now.shape, placement_of(now), seconds, rule);
  known.used = 1;
  known.id = now.id;
  known.shape = now.shape;
  known.absent = 0.0f;
  // In a pause all stands; where that is after a move of the scene, only the held pose knows.
  Placement met = continued && !c.waits && !(step > 0.0) ? before : known.pose.held;
  if (owed >= k_time_resolution && debt >= k_time_resolution) {
    // One that jumped has nothing left to go: else it would come from as far away as it goes in all of the time debt.
    const double left = continued && !c.arrived && continues(before, met, step, g.desc.particle_radius) ? owed : 0.0;
    for (int k = 0; k < 3; ++k) {
      met.linear[k] = spread(before.linear[k], left, met.linear[k], step, debt);
      met.angular[k] = spread(before.angular[k], left, met.angular[k], step, debt);
    }
  }
  const bool goes_on = continued && !c.waits && step > 0.0;
  const float radius = g.desc.particle_radius;
  const bool jumps = goes_on && (g.time.left_out > 0.0f || !continues(before, known.pose.held, step, radius) ||
                                 !turns_on(before, known.pose.held, step, radius));
  c.ends[slot] = met.pose;
  float(&slide)[6] = c.slides_of_slot[slot];
  c.met[slot] = goes_on ? pose_before(before, slide, c.arrived ? 0.0f : static_cast<float>(owed)) : met.pose;
  if (step > 0.0 || !continued) __builtin_memcpy(slide, known.pose.slide, sizeof slide);
  c.jumps[slot] = !continued || c.waits ? k_is_new : jumps ? 1 : 0;
  if (g.time.rate < 1.0 && step > 0.0) {
    met = known.pose.held;
    if (goes_on) met.pose = jumps ? pose_before(met, slide, g.time.frame_step) : c.met[slot];
    const float rate = static_cast<float>(g.time.rate);
    for (int k = 0; k < 3; ++k) {
      met.linear[k] *= rate;
      met.angular[k] *= rate;
    }
    for (float& s : slide) s *= rate;
    if (goes_on) met.pose = pose_before(met, slide, -static_cast<float>(debt));
  }
  c.of_slot[slot] = now;
  place(&c.of_slot[slot], met);
  c.seen_by[slot] = now.grains_only != 0 ? SeenBy::grains : SeenBy::all;
  c.reliefs = c.reliefs || now.shape == SANDGLASS_SHAPE_RELIEF;
}

// A collider that had lost its id, and has it again: what was known without one about there is not another that jumps.
// distance_max: metres that it may have gone meanwhile.
void forget_without_id(Colliders* c, uint32_t capacity, const sandglass_collider& now, float distance_max) {
  for (uint32_t slot = 0; now.id != 0 && slot < capacity; ++slot) {
    KnownCollider& known = c->known[slot];
    if (known.used == 0 || known.id != 0 || known.shape != now.shape || c->seen_by[slot] != SeenBy::none) continue;
    if (distance_squared(known, now) <= distance_max * distance_max) known.used = 0;
  }
}

}  // namespace

void colliders_take(Colliders* colliders, const Granular& g, const sandglass_frame_input& input, double owed,
                    FrameCounts* counts) {
  if (g.desc.particle_capacity == 0) return;
  Colliders& c = *colliders;
  const uint32_t capacity = g.desc.collider_capacity;
  const HoldRule rule = hold_rule(g);
  if (c.waits) owed = 0.0;  // how far colliders still have to go is not saved
  for (uint32_t slot = 0; slot < capacity; ++slot) {
    c.seen_by[slot] = SeenBy::none;
    if (c.known[slot].used != 0 && !(c.waits && input.collider_count == 0)) c.known[slot].absent += g.time.frame_step;
  }
  // Those that are certain first, so that none of the others takes their slot.
  bool all_certain = false;
  for (int pass = 0; pass < 2 && !all_certain; ++pass) {
    all_certain = true;
    uint32_t place = 0;
    for (uint32_t i = 0; i < input.collider_count; ++i) {
      sandglass_collider now;
      if (place == capacity || !collider_accept(input.colliders[i], &now)) {
        counts->ignored_colliders += pass == 0 ? 1u : 0u;
        continue;
      }
      uint32_t& slot = c.slot_of_place[place++];
      if (pass == 1 && slot != k_no_slot) continue;
      slot = pass == 0 ? slot_by_identity(c, capacity, now, place - 1)
                       : slot_by_place(c, capacity, input, now, place - 1, g.time);
      all_certain = all_certain && slot != k_no_slot;
      if (slot == k_no_slot) continue;
      const bool returns = c.known[slot].used != 0 && c.known[slot].absent > g.time.frame_step;
      hold_slot(&c, g, slot, now, owed, rule);
      forget_without_id(&c, capacity, now, returns ? k_lost_id : k_in_place);
      c.known[slot].place = place - 1;
      c.known[slot].listed = i;
    }
  }
  // What comes later than the first after a save comes from nowhere: where it was then, it has not moved from.
  for (uint32_t slot = 0; slot < capacity && c.waits && input.collider_count != 0; ++slot)
    if (c.known[slot].absent > 0.0f) c.known[slot].absent = k_gone_seconds;
  if (input.collider_count != 0 && g.time.frame_step > 0.0f) c.waits = false;
  order(&c, capacity);
  c.jumped = false;
  if (g.time.frame_step > 0.0f) c.arrived = false;
  for (uint32_t i = 0; i < c.solid_count; ++i) c.jumped = c.jumped || c.jumps[c.slots[i]] == 1;
  colliders_drop_gone_fields(&c);
}

}  // namespace sandglass
