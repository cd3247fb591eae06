// The solids during a frame. world.h has the rules; how they push a particle: kernels/collider_push.inl.
//
// Rotations by angular velocity use the first-order quaternion step, renormalised. So there is no sine or cosine in a
// hashed path. The error is angle^3 / 12: 7e-4 rad for a turn of 0.2 rad within one frame.
#include "runtime/relief/relief.h"
#include "runtime/sand/collider_placement.h"
#include "runtime/solid/field/field.h"

namespace sandglass {
namespace {

// Radii that a collider goes in a frame, as held poses do at last. What goes less stands.
constexpr float k_unmoved = 1e-3f;

bool normalise(float q[4]) {
  const float length2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!(length2 > 1e-12f && length2 < 1e12f)) return false;
  const float inverse = 1.0f / __builtin_sqrtf(length2);
  for (int i = 0; i < 4; ++i) q[i] *= inverse;
  return true;
}

void find_motion(Carrier* carrier, bool goes) {
  constexpr float k_difference_min = 1e-7f;
  const ColliderFrame &from = carrier->from, &to = carrier->to;
  bool differ = false;
  for (int k = 0; k < 3; ++k) {
    differ = differ || __builtin_fabsf(from.position[k] - to.position[k]) > k_difference_min;
    for (int j = 0; j < 3; ++j) differ = differ || __builtin_fabsf(from.axes[k][j] - to.axes[k][j]) > k_difference_min;
  }
  carrier->moves = goes && differ;
  carrier->motion = rigid_motion(from, to);
}

// ---- what sleepers have seen

bool visible(const Colliders& c, const ColliderWatch& watch, uint32_t slot) {
  return c.seen_by[slot] == SeenBy::all || (&watch == &c.for_grains && c.seen_by[slot] == SeenBy::grains);
}

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
  return now.shape == SANDGLASS_SHAPE_BOX && box_surface_distance(seen.pose, pose, hold_rule(g)) < k_rounding;
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
  c.shape = is_grid(seen.shape) ? SANDGLASS_SHAPE_BOX : seen.shape;
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
    const bool relief = c.of_slot[slot].shape == SANDGLASS_SHAPE_RELIEF;
    watch->fields[slot] = relief ? watch->looked_at[slot] : version_of(c.of_slot[slot]);
  }
}

void begin_look(const Colliders& c, uint32_t capacity, ColliderWatch* watch) {
  for (uint32_t slot = 0; slot < capacity; ++slot)
    if (c.seen_by[slot] != SeenBy::none && c.of_slot[slot].shape == SANDGLASS_SHAPE_RELIEF)
      watch->looked_at[slot] = version_of(c.of_slot[slot]);
}

// Of a relief that is where it was seen: what has changed on it. False: it is another one, or was another one.
bool find_changed(const ColliderWatch& watch, uint32_t slot, const sandglass_collider& now, MovedColliders* moved) {
  const SeenCollider& seen = watch.seen[slot];
  if (now.shape != SANDGLASS_SHAPE_RELIEF || seen.shape != now.shape || !(watch.fields[slot] <= version_of(now)))
    return false;
  ChangedRelief& changed = moved->reliefs[moved->relief_count++];
  colliders_pose(&now, 1, 0.0f, &changed.at);
  changed.changes = changes_of(now);
  changed.seen = static_cast<uint32_t>(watch.fields[slot]);
  return same_pose(pose_of(now), seen.pose);
}

// Fills watch->moved. margin: metres around a collider that count as near.
void find_moved(const Granular& g, ColliderWatch* watch, float margin) {
  const Colliders& c = g.colliders;
  MovedColliders& moved = watch->moved;
  moved.count = moved.relief_count = 0;
  for (uint32_t slot = 0; !c.waits && slot < g.desc.collider_capacity; ++slot) {
    if (same(g, *watch, slot)) continue;
    const SeenCollider& seen = watch->seen[slot];
    const bool is = visible(c, *watch, slot), was = seen.present != 0;
    if (is && was && find_changed(*watch, slot, c.of_slot[slot], &moved)) continue;
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

void drop_gone_fields(const Colliders& c, ColliderFrame* frames, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    bool there = !is_grid(frames[i].shape);
    for (uint32_t k = 0; k < c.count && !there; ++k) there = has_grid(frames[i], c.given[k]);
    if (there) continue;
    sandglass_collider nothing = {};
    nothing.shape = SANDGLASS_SHAPE_SPHERE;
    nothing.position[1] = -k_coordinate_bound;
    nothing.rotation[3] = 1.0f;
    colliders_pose(&nothing, 1, 0.0f, &frames[i]);
  }
}

void drop_gone_reliefs(const Colliders& c, MovedColliders* moved) {
  const uint32_t count = moved->relief_count;
  moved->relief_count = 0;
  for (uint32_t i = 0; i < count; ++i) {
    bool there = false;
    for (uint32_t k = 0; k < c.count && !there; ++k) there = has_grid(moved->reliefs[i].at, c.given[k]);
    if (there) moved->reliefs[moved->relief_count++] = moved->reliefs[i];
  }
}

}  // namespace

FieldGrid grid_of(const sandglass_collider& c) {
  return c.shape == SANDGLASS_SHAPE_RELIEF ? relief_grid(c.relief->relief) : grid_of(c.field);
}

uint64_t version_of(const sandglass_collider& c) {
  if (c.shape == SANDGLASS_SHAPE_RELIEF) return c.relief->relief.change;
  return c.shape == SANDGLASS_SHAPE_FIELD ? c.field->version : 0;
}

const CellChange* changes_of(const sandglass_collider& c) { return c.relief->relief.changes; }

bool has_grid(const ColliderFrame& frame, const sandglass_collider& collider) {
  if (!is_grid(frame.shape) || collider.shape != frame.shape) return false;
  const FieldGrid grid = grid_of(collider);
  bool same = frame.field.values == grid.values;
  for (int k = 0; k < 3; ++k) same = same && frame.field.counts[k] == grid.counts[k];
  return same;
}

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

float fastness(const sandglass_collider& c) {
  const float reach2 = c.shape == SANDGLASS_SHAPE_HALF_SPACE ? 1.0f : square_of(quad(c.size));
  return length_of(c.linear_velocity) + __builtin_sqrtf(square_of(quad(c.angular_velocity)) * reach2);
}

HoldRule hold_rule(const Granular& g) {
  HoldRule rule;
  rule.band = g.desc.collider_band;
  for (int k = 0; k < 3; ++k) {
    rule.low[k] = g.particles.low[k] - g.desc.particle_radius;
    rule.high[k] = g.particles.high[k] + g.desc.particle_radius;
  }
  rule.leave_speed = contacts_leave_speed(g);
  // Well below the 2 r at which sand is beyond a wall. What starts by less, at once, costs a pile more than by all.
  const float r = g.desc.particle_radius, bands = 2.0f * rule.band;
  rule.gentle = 1.5f * (r > bands ? r : bands);
  rule.longest = k_longest_step;
  rule.returns = g.colliders.waits;
  return rule;
}

void colliders_drop_gone_fields(Colliders* c) {
  drop_gone_fields(*c, c->substep_frames, c->substep_count);
  drop_gone_fields(*c, c->sweep_frames, c->sweep_count);
  drop_gone_fields(*c, c->sweep_step_frames, c->sweep_step_frame_count);
  drop_gone_fields(*c, c->for_grains.moved.frames, c->for_grains.moved.count);
  if (c->reliefs) drop_gone_reliefs(*c, &c->for_grains.moved);
}

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
    c->sweep_step_frames =
        layout_region<ColliderFrame>(layout, "granular.sweep_step_colliders", (k_sweep_steps_max - 1) * capacity);
  ColliderWatch* const watches[] = {&c->for_particles, &c->for_grains};
  for (ColliderWatch* watch : watches) {
    const bool grains = watch == &c->for_grains;
    watch->seen =
        layout_region<SeenCollider>(layout, grains ? "granular.grains_saw" : "granular.particles_saw", capacity);
    watch->fields = layout_region<uint64_t>(
        layout, grains ? "granular.grains_saw_fields" : "granular.particles_saw_fields", capacity);
    watch->looked_at =
        layout_region<uint64_t>(layout, grains ? "granular.grains_look_at" : "granular.particles_look_at", capacity);
    watch->moved.reliefs =
        layout_region<ChangedRelief>(layout, grains ? "granular.sweep_changed" : "granular.changed_reliefs", capacity);
    watch->moved.frames = layout_region<ColliderFrame>(
        layout, grains ? "granular.sweep_moved" : "granular.moved_colliders", 2 * capacity);
    watch->moved.margins =
        layout_region<float>(layout, grains ? "granular.sweep_moved_margins" : "granular.moved_margins", 2 * capacity);
  }
}

void colliders_reset(Colliders* c, const sandglass_granular_desc& d) {
  c->count = c->solid_count = c->substep_count = c->sweep_count = c->sweep_step_frame_count = 0;
  c->waits = c->arrived = c->jumped = c->reliefs = false;
  ColliderWatch* const watches[] = {&c->for_particles, &c->for_grains};
  for (uint32_t slot = 0; slot < d.collider_capacity; ++slot) {
    c->known[slot] = {};
    c->seen_by[slot] = SeenBy::none;
    for (ColliderWatch* watch : watches) {
      watch->seen[slot] = {};
      watch->fields[slot] = watch->looked_at[slot] = 0;
      watch->moved.count = watch->moved.relief_count = 0;
    }
  }
}

bool colliders_find_moved(Colliders* c, const Granular& g) {
  ColliderWatch& watch = c->for_particles;
  watch.moved.count = watch.moved.relief_count = 0;
  if (c->waits) return false;
  if (c->reliefs && g.substep.phase != SubstepPhase::touch) begin_look(*c, g.desc.collider_capacity, &watch);
  if (g.sleep.awake_count < g.particles.count) find_moved(g, &watch, neighbours_reach(g));
  const bool touch = !watch.moved.none();
  if (!touch) remember(g, &watch);
  return touch;
}

void colliders_seen_by_particles(Colliders* c, const Granular& g) { remember(g, &c->for_particles); }

void colliders_find_moved_for_grains(Colliders* c, const Granular& g) {
  if (c->reliefs) begin_look(*c, g.desc.collider_capacity, &c->for_grains);
  find_moved(g, &c->for_grains, g.desc.grain_radius);
  if (!c->waits) remember(g, &c->for_grains);
}

void colliders_begin_substep(Colliders* c, float before, float particle_radius) {
  colliders_pose(c->given, c->solid_count, before, c->substep_frames, c->slides);
  for (uint32_t i = 0; i < c->solid_count; ++i) {
    c->substep_slots[i] = c->slots[i];
    c->substep_frames[i].offset = particle_radius;
  }
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

void colliders_begin_sweep(Colliders* c, float before, float grain_radius, const RigidPose* from, uint32_t steps) {
  colliders_pose(c->given, c->count, before, c->sweep_frames, c->slides);
  for (uint32_t i = 0; i < c->count; ++i) c->sweep_frames[i].offset = grain_radius;
  c->sweep_count = c->count;
  c->sweep_step_frame_count = from == nullptr ? 0 : (steps - 1) * c->count;
  for (uint32_t i = 0; i < c->sweep_step_frame_count; ++i) {
    const uint32_t of = i % c->count, step = i / c->count + 1;
    const float share = static_cast<float>(step) / static_cast<float>(steps);
    const ColliderFrame& end = c->sweep_frames[of];
    c->sweep_step_frames[i] = of < c->solid_count ? collider_between(from[c->slots[of]], end, share) : end;
  }
}

bool colliders_move_sand(const Granular& g) {
  const Colliders& c = g.colliders;
  for (uint32_t i = 0; i < c.solid_count && g.particles.count != 0; ++i) {
    const sandglass_collider& it = c.given[i];
    float distance_squared = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const float below = g.particles.low[k] - it.position[k], above = it.position[k] - g.particles.high[k];
      const float gap = below > above ? below : above;
      distance_squared += gap > 0.0f ? gap * gap : 0.0f;
    }
    const float frame = g.time.frame_step + g.time.left_out, spin = length_of(it.angular_velocity);
    const float far = length_of(it.linear_velocity) * frame, size = length_of(it.size);
    const bool flat = it.shape == SANDGLASS_SHAPE_HALF_SPACE;
    if (far + spin * frame * size <= k_unmoved * g.desc.particle_radius && !(flat && spin > 0.0f)) continue;
    const float reach = far + size + 2.0f * g.desc.particle_radius;
    if (flat || distance_squared <= reach * reach) return true;
  }
  return false;
}

bool colliders_may_hold(const Granular& g) {
  uint32_t movers = 0;
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    const sandglass_collider& it = g.colliders.given[i];
    bool moves = false;
    for (int k = 0; k < 3; ++k) moves = moves || it.linear_velocity[k] != 0.0f || it.angular_velocity[k] != 0.0f;
    if (moves && it.shape != SANDGLASS_SHAPE_RELIEF) movers += it.shape == SANDGLASS_SHAPE_FIELD ? 2 : 1;
  }
  return movers > 1;
}

void colliders_pose_met(const Granular& g, uint32_t i, ColliderFrame* frame) {
  sandglass_collider met = g.colliders.given[i];
  place(&met, {g.colliders.met[g.colliders.slots[i]], {0, 0, 0}, {0, 0, 0}});
  colliders_pose(&met, 1, 0.0f, frame);
}

void colliders_find_motions(Colliders* c, const RigidPose* from, const uint8_t* moves) {
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
    find_motion(&carrier, true);
    carrier.moves = carrier.moves || moves[c->slots[i]] != 0;
  }
}

void colliders_find_jumps(Colliders* c, const Granular& g) {
  for (uint32_t i = 0; i < c->solid_count; ++i) {
    Carrier& carrier = c->carriers[i];
    colliders_pose(&c->given[i], 1, static_cast<float>(g.time.debt), &carrier.to, &c->slides[i]);
    colliders_pose_met(g, i, &carrier.from);
    find_motion(&carrier, c->jumps[c->slots[i]] == 1);
  }
}

void colliders_arrive(Colliders* c, const Granular& g, float faster) {
  c->arrived = true;
  for (uint32_t i = 0; i < c->count; ++i) {
    sandglass_collider &it = c->given[i], &of_slot = c->of_slot[c->slots[i]];
    const sandglass_collider before = it;
    Placement end = placement_of(it);
    end.pose = c->ends[c->slots[i]];
    for (int k = 0; k < 3; ++k) {
      end.linear[k] *= faster;
      end.angular[k] *= faster;
    }
    place(&it, end);
    place(&of_slot, end);
    if (i < c->solid_count) {
      colliders_pose(&before, 1, static_cast<float>(g.time.debt), &c->carriers[i].from, &c->slides[i]);
      colliders_pose(&it, 1, 0.0f, &c->carriers[i].to);
    }
    for (float& s : c->slides_of_slot[c->slots[i]]) s *= faster;
    if (i >= c->solid_count) continue;
    find_motion(&c->carriers[i], true);
  }
}

float colliders_behind(const Granular& g) { return g.colliders.arrived ? 0.0f : static_cast<float>(g.time.debt); }

float colliders_lag(const Granular& g) {
  const Colliders& c = g.colliders;
  float largest = 0.0f;
  for (uint32_t i = 0; i < c.solid_count; ++i) {
    const Pose at = pose_before(placement_of(c.given[i]), c.slides[i], static_cast<float>(g.time.debt));
    const Pose& end = c.ends[c.slots[i]];
    const float lag = 2.0f * half_travel(at, end);
    largest = lag > largest ? lag : largest;
  }
  return largest;
}

float colliders_gain(const Colliders& c, float faster) {
  float largest = 0.0f;
  for (uint32_t i = 0; i < c.solid_count; ++i) {
    const float speed = fastness(c.given[i]);
    largest = c.carriers[i].moves && speed > largest ? speed : largest;
  }
  return __builtin_fabsf(faster - 1.0f) / faster * largest;
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
      carrier.motion.move(frame.position);
      float* const vectors[] = {frame.linear, frame.angular, frame.axes[0], frame.axes[1], frame.axes[2]};
      for (float* v : vectors) carrier.motion.rotate(v);
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
  if (collider.shape < SANDGLASS_SHAPE_HALF_SPACE || collider.shape > SANDGLASS_SHAPE_RELIEF) return false;
  for (int k = 0; k < 3; ++k) {  // these refuse what is no number, too, as does normalise
    if (!(__builtin_fabsf(collider.position[k]) <= k_coordinate_bound &&
          __builtin_fabsf(collider.linear_velocity[k]) <= k_collider_speed &&
          __builtin_fabsf(collider.angular_velocity[k]) <= k_collider_speed)) {
      return false;
    }
  }
  const bool field = collider.shape == SANDGLASS_SHAPE_FIELD;
  if (field && (collider.field == nullptr || collider.field->magic != k_field_magic)) return false;
  const bool relief = collider.shape == SANDGLASS_SHAPE_RELIEF;
  if (relief && (collider.relief == nullptr || collider.relief->relief.magic != k_relief_magic)) return false;
  const uint32_t sizes = is_grid(collider.shape)                     ? 0
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
  for (int k = 0; relief && k < 3; ++k) accepted->size[k] = relief_reach(collider.relief->relief, k);
  return normalise(accepted->rotation);
}

void colliders_pose(const sandglass_collider* colliders, uint32_t count, float before, ColliderFrame* frames,
                    const float* const* slides) {
  constexpr float k_none[6] = {};
  for (uint32_t c = 0; c < count; ++c) {
    const sandglass_collider& collider = colliders[c];
    ColliderFrame& frame = frames[c];
    frame.shape = collider.shape;
    frame.offset = 0.0f;
    if (is_grid(collider.shape)) frame.field = grid_of(collider);
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
