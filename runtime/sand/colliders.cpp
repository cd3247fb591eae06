// The solids on their way through a frame. world.h has the rules.
//
// Rotations by angular velocity use the first-order quaternion step, renormalised. So there is no sine or cosine in a
// hashed path. The error is angle^3 / 12: 7e-4 rad for a turn of 0.2 rad within one frame.
#include "runtime/sand/granular.h"
#include "runtime/solid/field/field.h"

namespace sandglass {

namespace {

constexpr float k_collider_speed = 1e4f;   // metres or radians a second, along each axis
constexpr double k_way_resolution = 1e-6;  // metres or radians; what is shorter counts as none
constexpr float k_gone_seconds = 0.25f;    // after so long, one that is not passed is no longer recognised by its place
constexpr float k_as_large = 2.0f;         // of what has no id: a size may grow so much in a frame
constexpr float k_recognised = 0.25f;      // metres that a collider may have gone since the last frame
constexpr float k_recognised_id = 1.0f;    // and one with an id
constexpr float k_found_again = 0.01f;     // and that one without an id may, if it was not passed then
constexpr float k_lost_id = 0.05f;         // metres that one may go while it has lost its id
constexpr float k_in_place = 0.003f;       // metres; at its place in the list, one that is so near is the same
constexpr float k_unmoved =
    1e-3f;  // radii that a collider goes in a frame, as held poses do at last; what goes less stands

bool normalise(float q[4]) {
  const float length2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!(length2 > 1e-12f && length2 < 1e12f)) return false;
  const float inverse = 1.0f / __builtin_sqrtf(length2);
  for (int i = 0; i < 4; ++i) q[i] *= inverse;
  return true;
}

// ---- recognising

// A collider holds its placement as the library does: in one piece, in the same order.
constexpr size_t k_placement_at = offsetof(sandglass_collider, position);
static_assert(offsetof(sandglass_collider, size) - k_placement_at == offsetof(Pose, size) &&
              offsetof(sandglass_collider, grains_only) - k_placement_at == sizeof(Placement));

Placement placement_of(const sandglass_collider& c) {
  Placement p;
  __builtin_memcpy(&p, reinterpret_cast<const uint8_t*>(&c) + k_placement_at, sizeof p);
  return p;
}

Pose pose_of(const sandglass_collider& c) { return placement_of(c).pose; }

void place(sandglass_collider* c, const Placement& p) {
  __builtin_memcpy(reinterpret_cast<uint8_t*>(c) + k_placement_at, &p, sizeof p);
}

float length_of(const float v[3]) { return __builtin_sqrtf(square_of(quad(v))); }
bool equal3(const float a[3], const float b[3]) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }

bool free_slot(const Colliders& c, uint32_t slot, const sandglass_collider& now) {
  const KnownCollider& known = c.known[slot];
  return known.used != 0 && c.seen_by[slot] == SeenBy::none && known.shape == now.shape && known.id == now.id;
}

bool equal_pose(const KnownCollider& known, const sandglass_collider& now) {
  const Pose& told = known.pose.told;
  return equal3(told.position, now.position) && equal3(told.size, now.size) && same_turn(told.rotation, now.rotation);
}

// Square of about how far a collider has gone since it was known.
float apart2(const KnownCollider& known, const sandglass_collider& now) {
  const Pose& told = known.pose.told;
  if (same_pose(told, pose_of(now))) return 0.0f;
  float sum = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const float way = now.position[k] - told.position[k], more = now.size[k] - told.size[k];
    sum += (now.shape == SANDGLASS_SHAPE_HALF_SPACE ? 0.0f : way * way + more * more);
  }
  if (now.shape != SANDGLASS_SHAPE_HALF_SPACE) return sum;
  // A half-space may have slid along itself: what counts is how its plane lies.
  HoldRule at = {};
  for (int k = 0; k < 3; ++k) at.low[k] = at.high[k] = now.position[k];
  const float way = surface_way(now.shape, told, pose_of(now), at);
  return way * way;
}

// Whether sizes are about as they were: a hand is no table, though it lay where that is told.
bool as_large(const Pose& told, const sandglass_collider& now) {
  const int sizes = now.shape == SANDGLASS_SHAPE_SPHERE    ? 1
                    : now.shape == SANDGLASS_SHAPE_CAPSULE ? 2
                    : now.shape == SANDGLASS_SHAPE_BOX     ? 3
                                                           : 0;
  bool as = true;
  for (int k = 0; k < sizes; ++k)
    as = as && now.size[k] <= k_as_large * told.size[k] && told.size[k] <= k_as_large * now.size[k];
  return as;
}

bool recognisable(const KnownCollider& known, const sandglass_collider& now, const SimulatedTime& t) {
  if (now.id == 0 && !as_large(known.pose.told, now)) return false;
  const bool passed = known.absent <= t.frame_step;
  float most = now.id != 0 ? k_recognised_id : passed ? k_recognised : k_found_again;
  if (passed && t.left_out > 0.0f) most += 2.0f * length_of(now.linear_velocity) * (t.frame_step + t.left_out);
  return known.absent < k_gone_seconds && apart2(known, now) <= most * most;
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
  const float mine2 = apart2(c.known[slot], now);
  uint32_t other_place = 0;
  for (uint32_t i = 0; i < input.collider_count && other_place < capacity; ++i) {
    sandglass_collider other;
    if (!collider_accept(input.colliders[i], &other)) continue;
    const uint32_t at = other_place++;
    if (at == place || c.slot_of_place[at] != k_no_slot || other.shape != now.shape || other.id != now.id) continue;
    if (recognisable(c.known[slot], other, t) && apart2(c.known[slot], other) < mine2) return true;
  }
  return false;
}

// By its place in the list where it lies near, else the nearest, unless that is far and nearer to another; of two that are
// near the one that was passed in the last frame; else a slot for a new one, if need be of one that is not passed any more.
uint32_t slot_by_place(const Colliders& c, uint32_t capacity, const sandglass_frame_input& input,
                       const sandglass_collider& now, uint32_t place, const SimulatedTime& t) {
  uint32_t nearest = k_no_slot;
  float nearest2 = 0.0f;
  for (uint32_t slot = 0; slot < capacity; ++slot) {
    if (!free_slot(c, slot, now) || !recognisable(c.known[slot], now, t)) continue;
    const bool in_place = c.known[slot].place == place, passed = c.known[slot].absent <= t.frame_step;
    const float near2 = k_in_place * k_in_place, way2 = apart2(c.known[slot], now) + (passed ? 0.0f : near2);
    if (in_place && passed && way2 <= near2) return slot;
    if (nearest != k_no_slot && !(way2 < nearest2 || (way2 == nearest2 && in_place))) continue;
    const bool is_near = way2 <= k_found_again * k_found_again;
    if (is_near || !is_anothers(c, capacity, input, slot, now, place, t)) {
      nearest = slot;
      nearest2 = way2;
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
  float way2 = 0.0f, speed2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const float way = now.pose.position[k] - before.pose.position[k];
    const float speed = __builtin_fabsf(before.linear[k]) + __builtin_fabsf(now.linear[k]);
    way2 += way * way;
    speed2 += speed * speed;
  }
  return __builtin_sqrtf(way2) <= static_cast<float>(step) * __builtin_sqrtf(speed2) + margin;
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

// Where it is `before` seconds before it is there.
Pose pose_before(const Placement& at, const float slide[6], float before) {
  const float *q = at.pose.rotation, h = -0.5f * before;
  const float w[3] = {at.angular[0] - slide[3], at.angular[1] - slide[4], at.angular[2] - slide[5]};
  Pose p = at.pose;
  p.rotation[0] = q[0] + h * (w[0] * q[3] + w[1] * q[2] - w[2] * q[1]);
  p.rotation[1] = q[1] + h * (w[1] * q[3] + w[2] * q[0] - w[0] * q[2]);
  p.rotation[2] = q[2] + h * (w[2] * q[3] + w[0] * q[1] - w[1] * q[0]);
  p.rotation[3] = q[3] - h * (w[0] * q[0] + w[1] * q[1] + w[2] * q[2]);
  normalise(p.rotation);
  for (int k = 0; k < 3; ++k) p.position[k] = at.pose.position[k] - before * (at.linear[k] - slide[k]);
  return p;
}

// The velocity at which a collider goes what is left of its way and this frame's, in the simulated time that is left.
float spread(float left, double owed, float now, double step, double debt) {
  const double way = static_cast<double>(left) * owed + static_cast<double>(now) * step;
  if (now == 0.0f && way < k_way_resolution && way > -k_way_resolution) return 0.0f;
  const double velocity = way / debt, most = static_cast<double>(k_collider_speed);
  return static_cast<float>(velocity < most ? (velocity > -most ? velocity : -most) : most);
}

// ---- a frame's colliders

// Metres a second that a point of it moves at, at most; of a half-space, one metre away.
float fastness(const sandglass_collider& c) {
  const float reach2 = c.shape == SANDGLASS_SHAPE_HALF_SPACE ? 1.0f : square_of(quad(c.size));
  return length_of(c.linear_velocity) + __builtin_sqrtf(square_of(quad(c.angular_velocity)) * reach2);
}

// Whether a pushes before b: the smaller first, of equal ones the faster. A table that is followed may for a while be
// faster than the hand that presses on it. Equal ones are told apart by their shapes and poses, not by their places.
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

void find_way(Carrier* carrier, bool goes) {
  constexpr float k_least = 1e-7f;
  const ColliderFrame &from = carrier->from, &to = carrier->to;
  bool differ = false;
  for (int k = 0; k < 3; ++k) {
    differ = differ || __builtin_fabsf(from.position[k] - to.position[k]) > k_least;
    for (int j = 0; j < 3; ++j) differ = differ || __builtin_fabsf(from.axes[k][j] - to.axes[k][j]) > k_least;
  }
  carrier->moves = goes && differ;
  carrier->way = rigid_way(from, to);
}

HoldRule hold_rule(const Granular& g) {
  HoldRule rule;
  rule.band = g.desc.collider_band;
  for (int k = 0; k < 3; ++k) {
    rule.low[k] = g.particles.low[k] - g.desc.particle_radius;
    rule.high[k] = g.particles.high[k] + g.desc.particle_radius;
  }
  rule.leave_speed = contacts_leave_speed(g);
  // Well below the 2 r at which sand is beyond a wall. What starts by less, at once, costs a heap more than by all.
  const float r = g.desc.particle_radius, bands = 2.0f * rule.band;
  rule.gentle = 1.5f * (r > bands ? r : bands);
  rule.longest = k_longest_step;
  rule.returns = g.colliders.waits;
  return rule;
}

// What sand meets of a collider in this frame. owed: see colliders_take; 0 where what is left of its way is not known.
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
    // Of one that jumped nothing is left: else it would come from as far away as it goes in all of the time debt.
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
}

// A collider that had lost its id, and has it again: what was known without one about there is not another that jumps.
// `most`: metres that it may have gone meanwhile.
void forget_without_id(Colliders* c, uint32_t capacity, const sandglass_collider& now, float most) {
  for (uint32_t slot = 0; now.id != 0 && slot < capacity; ++slot) {
    KnownCollider& known = c->known[slot];
    if (known.used == 0 || known.id != 0 || known.shape != now.shape || c->seen_by[slot] != SeenBy::none) continue;
    if (apart2(known, now) <= most * most) known.used = 0;
  }
}

// ---- what sleepers have seen

bool visible(const Colliders& c, const ColliderWatch& watch, uint32_t slot) {
  return c.seen_by[slot] == SeenBy::all || (&watch == &c.for_grains && c.seen_by[slot] == SeenBy::grains);
}

uint64_t version_of(const sandglass_collider& c) { return c.shape == SANDGLASS_SHAPE_FIELD ? c.field->version : 0; }

// Whether a slot is as it was seen, and stands still. A box may have changed where no sand is.
bool same(const Granular& g, const ColliderWatch& watch, uint32_t slot) {
  constexpr float k_rounding = 1e-6f;  // metres
  const Colliders& c = g.colliders;
  const SeenCollider& seen = watch.seen[slot];
  const bool is = visible(c, watch, slot);
  if (!is || seen.present == 0) return !is && seen.present == 0;
  const sandglass_collider& now = c.of_slot[slot];
  for (int k = 0; k < 3; ++k) {
    if (now.linear_velocity[k] != 0.0f || now.angular_velocity[k] != 0.0f) return false;
  }
  const Pose pose = pose_of(now);
  if (seen.shape != now.shape || (watch.fields[slot] != 0 && watch.fields[slot] != version_of(now))) return false;
  if (same_pose(pose, seen.pose)) return true;
  return now.shape == SANDGLASS_SHAPE_BOX && way_of_box(seen.pose, pose, hold_rule(g)) < k_rounding;
}

// About half of what a point of the collider can have travelled between two poses: half the shift, and half the arc of
// a point as far from the centre as the sizes reach. A half-space has no size, so its turning does not count.
float half_travel(const Pose& a, const Pose& b) {
  float shift2 = 0.0f, turn2 = 0.0f, extent2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    shift2 += (b.position[k] - a.position[k]) * (b.position[k] - a.position[k]);
    extent2 += b.size[k] * b.size[k];
  }
  for (int k = 0; k < 4; ++k) turn2 += (b.rotation[k] - a.rotation[k]) * (b.rotation[k] - a.rotation[k]);
  return 0.5f * __builtin_sqrtf(shift2) + __builtin_sqrtf(turn2 * extent2);
}

// Where a collider was seen. Its field may be gone by now: a box of the field's reach stands for it.
void pose_seen(const SeenCollider& seen, ColliderFrame* frame) {
  sandglass_collider c = {};
  c.shape = seen.shape == SANDGLASS_SHAPE_FIELD ? SANDGLASS_SHAPE_BOX : seen.shape;
  place(&c, {seen.pose, {0, 0, 0}, {0, 0, 0}});
  colliders_pose(&c, 1, 0.0f, frame);
}

// The colliders of this frame are those that sleepers have seen.
void remember(const Granular& g, ColliderWatch* watch) {
  const Colliders& c = g.colliders;
  for (uint32_t slot = 0; slot < g.desc.collider_capacity; ++slot) {
    watch->seen[slot] = {};
    watch->fields[slot] = 0;
    if (!visible(c, *watch, slot)) continue;
    watch->seen[slot] = {1, c.of_slot[slot].shape, pose_of(c.of_slot[slot])};
    watch->fields[slot] = version_of(c.of_slot[slot]);
  }
}

// Fills watch->moved. margin: metres around a collider that count as near.
void find_moved(const Granular& g, ColliderWatch* watch, float margin) {
  const Colliders& c = g.colliders;
  MovedColliders& moved = watch->moved;
  moved.count = 0;
  for (uint32_t slot = 0; !c.waits && slot < g.desc.collider_capacity; ++slot) {
    if (same(g, *watch, slot)) continue;
    const SeenCollider& seen = watch->seen[slot];
    const bool is = visible(c, *watch, slot), was = seen.present != 0;
    const float reach = margin + (is && was ? half_travel(seen.pose, pose_of(c.of_slot[slot])) : 0.0f);
    if (is) {
      colliders_pose(&c.of_slot[slot], 1, 0.0f, &moved.frames[moved.count]);
      moved.margins[moved.count++] = reach;
    }
    if (was) {
      pose_seen(seen, &moved.frames[moved.count]);
      moved.margins[moved.count++] = reach;
    }
  }
}

bool same_grid(const FieldGrid& a, const FieldGrid& b) {
  bool same = a.values == b.values;
  for (int k = 0; k < 3; ++k) same = same && a.counts[k] == b.counts[k];
  return same;
}

// A field that is not passed any longer may be gone, while a step that meets it is under way. A ball of no size, far from
// everything, takes its place.
void drop_gone_fields(const Colliders& c, ColliderFrame* frames, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    bool there = frames[i].shape != SANDGLASS_SHAPE_FIELD;
    for (uint32_t k = 0; k < c.count && !there; ++k)
      there = c.given[k].shape == SANDGLASS_SHAPE_FIELD && same_grid(frames[i].field, grid_of(c.given[k].field));
    if (there) continue;
    sandglass_collider nothing = {};
    nothing.shape = SANDGLASS_SHAPE_SPHERE;
    nothing.position[1] = -k_coordinate_bound;
    nothing.rotation[3] = 1.0f;
    colliders_pose(&nothing, 1, 0.0f, &frames[i]);
  }
}

}  // namespace

void colliders_layout(Colliders* c, const sandglass_granular_desc& d, Layout* layout) {
  const uint64_t capacity = d.collider_capacity;
  c->known = layout_region<KnownCollider>(layout, "granular.known_colliders", capacity);
  c->of_slot = layout_region<sandglass_collider>(layout, "granular.colliders_by_slot", capacity);
  c->seen_by = layout_region<SeenBy>(layout, "granular.colliders_seen_by", capacity);
  c->given = layout_region<sandglass_collider>(layout, "granular.colliders", capacity);
  c->slots = layout_region<uint32_t>(layout, "granular.given_slots", capacity);
  c->slides_of_slot = layout_region<float[6]>(layout, "granular.slides_by_slot", capacity);
  c->slides = layout_region<const float*>(layout, "granular.collider_slides", capacity);
  c->slot_of_place = layout_region<uint32_t>(layout, "granular.collider_slots", capacity);
  c->met = layout_region<Pose>(layout, "granular.colliders_met", capacity);
  c->ends = layout_region<Pose>(layout, "granular.collider_ends", capacity);
  c->jumps = layout_region<uint8_t>(layout, "granular.collider_jumps", capacity);
  c->carriers = layout_region<Carrier>(layout, "granular.carriers", capacity);
  c->substep_slots = layout_region<uint32_t>(layout, "granular.substep_slots", capacity);
  c->substep_frames = layout_region<ColliderFrame>(layout, "granular.substep_colliders", capacity);
  c->sweep_frames = layout_region<ColliderFrame>(layout, "granular.sweep_colliders", capacity);
  if (d.grain_capacity != 0)
    c->sweep_ways =
        layout_region<ColliderFrame>(layout, "granular.sweep_collider_ways", (k_sweep_steps_max - 1) * capacity);
  ColliderWatch* const watches[] = {&c->for_particles, &c->for_grains};
  for (ColliderWatch* watch : watches) {
    const bool grains = watch == &c->for_grains;
    watch->seen =
        layout_region<SeenCollider>(layout, grains ? "granular.grains_saw" : "granular.particles_saw", capacity);
    watch->fields = layout_region<uint64_t>(
        layout, grains ? "granular.grains_saw_fields" : "granular.particles_saw_fields", capacity);
    watch->moved.frames = layout_region<ColliderFrame>(
        layout, grains ? "granular.sweep_moved" : "granular.moved_colliders", 2 * capacity);
    watch->moved.margins =
        layout_region<float>(layout, grains ? "granular.sweep_moved_margins" : "granular.moved_margins", 2 * capacity);
  }
}

void colliders_reset(Colliders* c, const sandglass_granular_desc& d) {
  c->count = c->solid_count = c->substep_count = c->sweep_count = c->sweep_way_count = 0;
  c->waits = c->arrived = c->jumped = false;
  ColliderWatch* const watches[] = {&c->for_particles, &c->for_grains};
  for (uint32_t slot = 0; slot < d.collider_capacity; ++slot) {
    c->known[slot] = {};
    c->seen_by[slot] = SeenBy::none;
    for (ColliderWatch* watch : watches) {
      watch->seen[slot] = {};
      watch->fields[slot] = 0;
      watch->moved.count = 0;
    }
  }
}

void colliders_take(Colliders* colliders, const Granular& g, const sandglass_frame_input& input, double owed,
                    FrameCounts* counts) {
  if (g.desc.particle_capacity == 0) return;
  Colliders& c = *colliders;
  const uint32_t capacity = g.desc.collider_capacity;
  const HoldRule rule = hold_rule(g);
  if (c.waits) owed = 0.0;  // what is left of ways is not saved
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
  // What comes later than the first after a save comes from nowhere: where it was then is no way.
  for (uint32_t slot = 0; slot < capacity && c.waits && input.collider_count != 0; ++slot)
    if (c.known[slot].absent > 0.0f) c.known[slot].absent = k_gone_seconds;
  if (input.collider_count != 0 && g.time.frame_step > 0.0f) c.waits = false;
  order(&c, capacity);
  c.jumped = false;
  if (g.time.frame_step > 0.0f) c.arrived = false;
  for (uint32_t i = 0; i < c.solid_count; ++i) c.jumped = c.jumped || c.jumps[c.slots[i]] == 1;
  drop_gone_fields(c, c.substep_frames, c.substep_count);
  drop_gone_fields(c, c.sweep_frames, c.sweep_count);
  drop_gone_fields(c, c.sweep_ways, c.sweep_way_count);
  drop_gone_fields(c, c.for_grains.moved.frames, c.for_grains.moved.count);
}

bool colliders_find_moved(Colliders* c, const Granular& g) {
  ColliderWatch& watch = c->for_particles;
  watch.moved.count = 0;
  if (c->waits) return false;
  if (g.sleep.awake_count < g.particles.count) find_moved(g, &watch, neighbours_reach(g));
  const bool touch = watch.moved.count != 0;
  if (!touch) remember(g, &watch);
  return touch;
}

void colliders_seen_by_particles(Colliders* c, const Granular& g) { remember(g, &c->for_particles); }

void colliders_find_moved_for_grains(Colliders* c, const Granular& g) {
  find_moved(g, &c->for_grains, g.desc.grain_radius);
  if (!c->waits) remember(g, &c->for_grains);
}

void colliders_begin_substep(Colliders* c, float before) {
  colliders_pose(c->given, c->solid_count, before, c->substep_frames, c->slides);
  for (uint32_t i = 0; i < c->solid_count; ++i) c->substep_slots[i] = c->slots[i];
  c->substep_count = c->solid_count;
}

RigidPose rigid_pose(const ColliderFrame& frame) {
  RigidPose pose;
  __builtin_memcpy(pose.position, frame.position, sizeof pose.position);
  __builtin_memcpy(pose.axes, frame.axes, sizeof pose.axes);
  return pose;
}

ColliderFrame collider_between(const RigidPose& from, const ColliderFrame& to, float share) {
  ColliderFrame f = to;
  for (int a = 0; a < 3; ++a) {
    f.position[a] = from.position[a] + share * (to.position[a] - from.position[a]);
    float length2 = 0.0f;
    for (int k = 0; k < 3; ++k) {
      f.axes[a][k] = from.axes[a][k] + share * (to.axes[a][k] - from.axes[a][k]);
      length2 += f.axes[a][k] * f.axes[a][k];
    }
    for (int k = 0; k < 3; ++k) f.axes[a][k] /= __builtin_sqrtf(length2);
  }
  find_extent(&f);
  return f;
}

void colliders_begin_sweep(Colliders* c, float before, const RigidPose* from, uint32_t steps) {
  colliders_pose(c->given, c->count, before, c->sweep_frames, c->slides);
  c->sweep_count = c->count;
  c->sweep_way_count = from == nullptr ? 0 : (steps - 1) * c->count;
  for (uint32_t i = 0; i < c->sweep_way_count; ++i) {
    const uint32_t of = i % c->count, step = i / c->count + 1;
    const float share = static_cast<float>(step) / static_cast<float>(steps);
    const ColliderFrame& end = c->sweep_frames[of];
    c->sweep_ways[i] = of < c->solid_count ? collider_between(from[c->slots[of]], end, share) : end;
  }
}

bool colliders_move_sand(const Granular& g) {
  const Colliders& c = g.colliders;
  for (uint32_t i = 0; i < c.solid_count && g.particles.count != 0; ++i) {
    const sandglass_collider& it = c.given[i];
    float apart2 = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const float below = g.particles.low[k] - it.position[k], above = it.position[k] - g.particles.high[k];
      const float apart = below > above ? below : above;
      apart2 += apart > 0.0f ? apart * apart : 0.0f;
    }
    const float frame = g.time.frame_step + g.time.left_out, spin = length_of(it.angular_velocity);
    const float way = length_of(it.linear_velocity) * frame, size = length_of(it.size);
    const bool flat = it.shape == SANDGLASS_SHAPE_HALF_SPACE;
    if (way + spin * frame * size <= k_unmoved * g.desc.particle_radius && !(flat && spin > 0.0f)) continue;
    const float reach = way + size + 2.0f * g.desc.particle_radius;
    if (flat || apart2 <= reach * reach) return true;
  }
  return false;
}

bool colliders_may_hold(const Granular& g) {
  uint32_t movers = 0;
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    const sandglass_collider& it = g.colliders.given[i];
    bool moves = false;
    for (int k = 0; k < 3; ++k) moves = moves || it.linear_velocity[k] != 0.0f || it.angular_velocity[k] != 0.0f;
    if (moves) movers += it.shape == SANDGLASS_SHAPE_FIELD ? 2 : 1;
  }
  return movers > 1;
}

void colliders_pose_met(const Granular& g, uint32_t i, ColliderFrame* frame) {
  sandglass_collider met = g.colliders.given[i];
  place(&met, {g.colliders.met[g.colliders.slots[i]], {0, 0, 0}, {0, 0, 0}});
  colliders_pose(&met, 1, 0.0f, frame);
}

void colliders_find_ways(Colliders* c, const RigidPose* from, const uint8_t* moves) {
  for (uint32_t i = 0; i < c->solid_count; ++i) {
    Carrier& carrier = c->carriers[i];
    const RigidPose& pose = from[c->slots[i]];
    sandglass_collider end = c->given[i];
    place(&end, {c->ends[c->slots[i]], {0, 0, 0}, {0, 0, 0}});
    colliders_pose(&end, 1, 0.0f, &carrier.to);
    carrier.from = carrier.to;
    __builtin_memcpy(carrier.from.position, pose.position, sizeof pose.position);
    __builtin_memcpy(carrier.from.axes, pose.axes, sizeof pose.axes);
    find_extent(&carrier.from);
    find_way(&carrier, true);
    carrier.moves = carrier.moves || moves[c->slots[i]] != 0;
  }
}

void colliders_find_jumps(Colliders* c, const Granular& g) {
  for (uint32_t i = 0; i < c->solid_count; ++i) {
    Carrier& carrier = c->carriers[i];
    colliders_pose(&c->given[i], 1, static_cast<float>(g.time.debt), &carrier.to, &c->slides[i]);
    colliders_pose_met(g, i, &carrier.from);
    find_way(&carrier, c->jumps[c->slots[i]] == 1);
  }
}

void colliders_arrive(Colliders* c, const Granular& g, float faster) {
  c->arrived = true;
  for (uint32_t i = 0; i < c->count; ++i) {
    sandglass_collider &it = c->given[i], &of_slot = c->of_slot[c->slots[i]];
    const sandglass_collider went = it;
    Placement end = placement_of(it);
    end.pose = c->ends[c->slots[i]];
    for (int k = 0; k < 3; ++k) {
      end.linear[k] *= faster;
      end.angular[k] *= faster;
    }
    place(&it, end);
    place(&of_slot, end);
    if (i < c->solid_count) {
      colliders_pose(&went, 1, static_cast<float>(g.time.debt), &c->carriers[i].from, &c->slides[i]);
      colliders_pose(&it, 1, 0.0f, &c->carriers[i].to);
    }
    for (float& s : c->slides_of_slot[c->slots[i]]) s *= faster;
    if (i >= c->solid_count) continue;
    find_way(&c->carriers[i], true);
  }
}

float colliders_behind(const Granular& g) { return g.colliders.arrived ? 0.0f : static_cast<float>(g.time.debt); }

float colliders_lag(const Granular& g) {
  const Colliders& c = g.colliders;
  float most = 0.0f;
  for (uint32_t i = 0; i < c.solid_count; ++i) {
    const Pose at = pose_before(placement_of(c.given[i]), c.slides[i], static_cast<float>(g.time.debt));
    const Pose& end = c.ends[c.slots[i]];
    const float lag = 2.0f * half_travel(at, end);
    most = lag > most ? lag : most;
  }
  return most;
}

float colliders_gain(const Colliders& c, float faster) {
  float most = 0.0f;
  for (uint32_t i = 0; i < c.solid_count; ++i) {
    const float speed = fastness(c.given[i]);
    most = c.carriers[i].moves && speed > most ? speed : most;
  }
  return __builtin_fabsf(faster - 1.0f) / faster * most;
}

void colliders_carry_substep(Colliders* c, float faster) {
  for (uint32_t s = 0; s < c->substep_count; ++s) {
    ColliderFrame& frame = c->substep_frames[s];
    float* const all[] = {frame.linear, frame.angular, frame.slide, frame.slide_turn};
    for (float* v : all)
      for (int k = 0; k < 3; ++k) v[k] *= faster;
    for (uint32_t i = 0; i < c->solid_count; ++i) {
      const Carrier& carrier = c->carriers[i];
      if (!carrier.moves || c->slots[i] != c->substep_slots[s]) continue;
      carrier.way.move(frame.position);
      float* const vectors[] = {frame.linear, frame.angular, frame.axes[0], frame.axes[1], frame.axes[2]};
      for (float* v : vectors) carrier.way.rotate(v);
      find_extent(&frame);
    }
  }
}

void colliders_settle(Colliders* colliders, const Granular& g) {
  Colliders& c = *colliders;
  c.waits = true;
  for (uint32_t slot = 0; slot < g.desc.collider_capacity; ++slot) {
    c.for_particles.fields[slot] = c.for_grains.fields[slot] = 0;
    c.seen_by[slot] = SeenBy::none;
  }
}

void colliders_move(Colliders* colliders, const Granular& g, const SceneMove& move) {
  float rotation[4];
  for (int k = 0; k < 4; ++k) rotation[k] = static_cast<float>(move.rotation[k]);
  Colliders& c = *colliders;
  for (uint32_t slot = 0; slot < g.desc.collider_capacity; ++slot) {
    hold_move(&c.known[slot].pose, rotation, move.shift);
    pose_move(&c.for_particles.seen[slot].pose, rotation, move.shift);
    pose_move(&c.for_grains.seen[slot].pose, rotation, move.shift);
  }
}

bool watch_changed(const Granular& g, const ColliderWatch& watch) {
  bool changed = false;
  for (uint32_t slot = 0; !g.colliders.waits && !changed && slot < g.desc.collider_capacity; ++slot)
    changed = !same(g, watch, slot);
  return changed;
}

bool collider_held(const Granular& g, uint32_t index, sandglass_collider* held) {
  const Colliders& c = g.colliders;
  for (uint32_t slot = 0; slot < g.desc.collider_capacity; ++slot) {
    if (c.seen_by[slot] == SeenBy::none || c.known[slot].listed != index) continue;
    *held = c.of_slot[slot];
    Placement end = placement_of(*held);
    end.pose = c.ends[slot];
    place(held, end);
    return true;
  }
  return false;
}

bool collider_accept(const sandglass_collider& collider, sandglass_collider* accepted) {
  if (collider.shape < SANDGLASS_SHAPE_HALF_SPACE || collider.shape > SANDGLASS_SHAPE_FIELD) return false;
  for (int k = 0; k < 3; ++k) {  // these refuse what is no number, too, as does normalise
    if (!(__builtin_fabsf(collider.position[k]) <= k_coordinate_bound &&
          __builtin_fabsf(collider.linear_velocity[k]) <= k_collider_speed &&
          __builtin_fabsf(collider.angular_velocity[k]) <= k_collider_speed)) {
      return false;
    }
  }
  const bool field = collider.shape == SANDGLASS_SHAPE_FIELD;
  if (field && (collider.field == nullptr || collider.field->magic != k_field_magic)) return false;
  const uint32_t sizes = field                                       ? 0
                         : collider.shape == SANDGLASS_SHAPE_BOX     ? 3
                         : collider.shape == SANDGLASS_SHAPE_CAPSULE ? 2
                                                                     : collider.shape;
  for (uint32_t k = 0; k < sizes; ++k) {
    if (!(collider.size[k] > 0.0f && collider.size[k] <= k_coordinate_bound)) return false;
  }
  *accepted = collider;
  for (uint32_t k = sizes; k < 3; ++k) accepted->size[k] = 0.0f;  // what means nothing is not compared
  if (field) {  // as far as its points are from its origin: turning moves them by that
    float low[3], high[3];
    sandglass_field_bounds(collider.field, low, high);
    for (int k = 0; k < 3; ++k) accepted->size[k] = high[k] > -low[k] ? high[k] : -low[k];
  }
  return normalise(accepted->rotation);
}

void colliders_pose(const sandglass_collider* colliders, uint32_t count, float before, ColliderFrame* frames,
                    const float* const* slides) {
  constexpr float k_none[6] = {};
  for (uint32_t c = 0; c < count; ++c) {
    const sandglass_collider& collider = colliders[c];
    ColliderFrame& frame = frames[c];
    frame.shape = collider.shape;
    if (collider.shape == SANDGLASS_SHAPE_FIELD) frame.field = grid_of(collider.field);
    const float* slide = slides != nullptr ? slides[c] : k_none;
    const Pose pose = pose_before(placement_of(collider), slide, before);
    const float* r = pose.rotation;
    frame.slides = 0;
    for (int k = 0; k < 3; ++k) {
      frame.slide[k] = slide[k];
      frame.slide_turn[k] = slide[k + 3];
      if (slide[k] != 0.0f || slide[k + 3] != 0.0f) frame.slides = 1;
    }
    const float x = r[0], y = r[1], z = r[2], s = r[3];
    const float axes[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + z * s), 2 * (x * z - y * s)},
                              {2 * (x * y - z * s), 1 - 2 * (x * x + z * z), 2 * (y * z + x * s)},
                              {2 * (x * z + y * s), 2 * (y * z - x * s), 1 - 2 * (x * x + y * y)}};
    for (int k = 0; k < 3; ++k) {
      frame.position[k] = pose.position[k];
      frame.size[k] = collider.size[k];
      frame.linear[k] = collider.linear_velocity[k];
      frame.angular[k] = collider.angular_velocity[k];
      for (int j = 0; j < 3; ++j) frame.axes[k][j] = axes[k][j];
    }
    find_extent(&frame);
  }
}

}  // namespace sandglass
