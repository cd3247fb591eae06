// What can reach nothing any more, and so drives nothing.
#include "runtime/sand/holding.h"

namespace sandglass {

namespace {

// A half-space is under something where its normal rises by more than this share of its length: a wall, which AR finds
// a degree or two off the vertical, is under nothing.
constexpr float k_floor_rise = 0.1f;
constexpr float k_endless = 3e38f;  // metres

float dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Metres along gravity.
float depth_of(const Granular& g, const float at[3]) { return dot(g.gravity, at) / g.gravity_length; }

float depth_of(const Granular& g, const Bounds& b) {
  float corner[3];
  for (int k = 0; k < 3; ++k) corner[k] = g.gravity[k] > 0.0f ? b.high[k] : b.low[k];
  return is_empty(b) ? -k_endless : depth_of(g, corner);
}

// How far a bounded collider reaches from its position along a direction of length 1.
float reach_along(const ColliderFrame& c, const float direction[3]) {
  float along[3];
  for (int a = 0; a < 3; ++a) along[a] = __builtin_fabsf(dot(c.axes[a], direction));
  if (c.shape == SANDGLASS_SHAPE_BOX || c.shape == SANDGLASS_SHAPE_RELIEF)
    return along[0] * c.size[0] + along[1] * c.size[1] + along[2] * c.size[2];
  if (c.shape == SANDGLASS_SHAPE_CAPSULE) return c.size[0] + along[1] * c.size[1];
  if (c.shape != SANDGLASS_SHAPE_FIELD) return c.size[0];
  float reach = 0.0f;  // of the farthest corner of the grid
  for (int a = 0; a < 3; ++a) {
    const float side = dot(c.axes[a], direction), low = c.field.low[a];
    const float high = low + c.field.spacing * static_cast<float>(c.field.counts[a] - 1);
    reach += side * (side > 0.0f ? high : low);
  }
  return reach;
}

// Where a frame's collider is, and where it was when the frame's time began.
void pose_both(const Granular& g, uint32_t c, ColliderFrame frames[2]) {
  colliders_pose(&g.colliders.given[c], 1, 0.0f, &frames[0]);
  colliders_pose(&g.colliders.given[c], 1, static_cast<float>(g.time.debt), &frames[1], &g.colliders.slides[c]);
}

void include_solid(Departed* departed, const Granular& g, const ColliderFrame& c) {
  departed->bounded = true;
  if (!(g.gravity_length > 0.0f)) return;
  const float inverse = 1.0f / g.gravity_length;
  const float down[3] = {g.gravity[0] * inverse, g.gravity[1] * inverse, g.gravity[2] * inverse};
  const float depth = depth_of(g, c.position) + reach_along(c, down);
  departed->bottom = depth > departed->bottom ? depth : departed->bottom;
}

// A fast particle's path: where it begins and ends, and its velocity on average.
struct Path {
  float from[3], to[3], velocity[3];
};

Path path_of(const Granular& g, uint32_t i) {
  const Particle& p = g.particles.records[0][i];
  Path path;
  for (int k = 0; k < 3; ++k) {
    path.from[k] = p.position[k];
    path.velocity[k] = p.velocity[k] + 0.5f * g.departed.horizon * g.gravity[k];
    path.to[k] = path.from[k] + g.departed.horizon * path.velocity[k];
  }
  return path;
}

// What an interval's gravity adds to a path, at most.
float fall_of(const Granular& g) { return g.gravity_length * g.departed.horizon * g.departed.horizon; }

bool meets(const Path& path, const Bounds& box, float margin) {
  for (int k = 0; k < 3; ++k) {
    const float low = path.from[k] < path.to[k] ? path.from[k] : path.to[k];
    const float high = path.from[k] < path.to[k] ? path.to[k] : path.from[k];
    if (high < box.low[k] - margin || low > box.high[k] + margin) return false;
  }
  return true;
}

// Whether two paths come nearer to each other than this. Gravity is the same on both.
bool meets(const Path& a, const Path& b, float time, float distance) {
  float difference[3], approach[3];
  for (int k = 0; k < 3; ++k) {
    difference[k] = b.from[k] - a.from[k];
    approach[k] = b.velocity[k] - a.velocity[k];
  }
  const float speed2 = dot(approach, approach), nearer = -dot(difference, approach);
  const float at = nearer > 0.0f ? (nearer < time * speed2 ? nearer / speed2 : time) : 0.0f;
  for (int k = 0; k < 3; ++k) difference[k] += at * approach[k];
  return dot(difference, difference) < distance * distance;
}

void mark(Departed* departed, const Granular& g, uint32_t i, bool departs) {
  Departed& d = *departed;
  Particle* p = &g.particles.records[0][i];
  d.returned = d.returned || (has_departed(*p) && !departs);
  d.found += departs ? 1u : 0u;
  set_departed(p, departs);
}

void count_in(Departed* d, const Particle& p) {
  const float speed2 = dot(p.velocity, p.velocity);
  d->others_speed2 = speed2 > d->others_speed2 ? speed2 : d->others_speed2;
  bounds_include(&d->others, p.position);
}

// ---- the bodies' spans, and what is below all

void measure_slot(Departed* departed, const Granular& g, uint32_t slot) {
  if (!departed->falls) return;
  const Particle& p = g.particles.records[0][g.bodies.rows[slot]];
  BodySpan* span = &departed->spans[body_of(p) - 1];
  const float depth = depth_of(g, p.position);
  span->top = depth < span->top ? depth : span->top;
  span->bottom = depth > span->bottom ? depth : span->bottom;
}

// A body that is not wholly below the others is something that sand may lie on.
void find_below(Departed* departed, const Granular& g) {
  Departed& d = *departed;
  const float margin = neighbours_reach(g);
  d.below = d.falls ? d.bottom + margin : k_endless;
  for (bool again = d.falls; again;) {
    again = false;
    for (uint32_t b = 0; b < g.bodies.count; ++b) {
      BodySpan& span = d.spans[b];
      if (!span.below) continue;
      span.below = span.top > d.below && dot(g.bodies.all[b].linear, g.gravity) >= 0.0f;
      if (span.below) continue;
      again = true;
      if (span.bottom + margin > d.below) d.below = span.bottom + margin;
    }
  }
}

// ---- the particles

void look_at(Departed* departed, const Granular& g, uint32_t i) {
  Departed& d = *departed;
  const Particle& p = g.particles.records[0][i];
  if (!is_awake(p)) return;
  d.gone = d.gone || departed_is_gone(g, p.position);
  const bool below = in_body(p) ? d.falls && d.spans[body_of(p) - 1].below
                                : d.falls && depth_of(g, p.position) > d.below && dot(p.velocity, g.gravity) >= 0.0f;
  if (below) return mark(departed, g, i, true);
  const float speed2 = dot(p.velocity, p.velocity);
  const bool fast = d.open && !in_body(p) && !(d.reach > 0.0f && speed2 * d.horizon * d.horizon <= d.reach * d.reach);
  if (!fast) {
    mark(departed, g, i, false);
    return count_in(&d, p);
  }
  d.fast_speed2 = speed2 > d.fast_speed2 ? speed2 : d.fast_speed2;
  bounds_include(&d.fast_ones, p.position);
  if (d.fast_count < k_fast_max) d.fast[d.fast_count] = i;
  else mark(departed, g, i, false);
  ++d.fast_count;
}

// Whether a path leads near a collider, which goes from one pose to the other.
bool meets(const Path& path, const ColliderFrame poses[2], float margin) {
  if (poses[0].shape != SANDGLASS_SHAPE_HALF_SPACE) {
    Bounds box = holding_box(poses[0]);
    bounds_join(&box, holding_box(poses[1]));
    return meets(path, box, margin);
  }
  for (int pose = 0; pose < 2; ++pose) {
    const float* normal = poses[pose].axes[1];
    const float plane = dot(normal, poses[pose].position) + margin;
    if (dot(normal, path.from) < plane || dot(normal, path.to) < plane) return true;
  }
  return false;
}

// Those of the fast ones that can reach nothing depart, where there is something to depart from.
void judge_fast(Departed* departed, const Granular& g) {
  Departed& d = *departed;
  const uint32_t count = d.fast_count <= k_fast_max ? d.fast_count : k_fast_max;
  // The others may go as far as lists reach.
  const float margin = 2.0f * neighbours_reach(g) + fall_of(g);
  Bounds there = d.others;
  bounds_join(&there, g.boundary.bounds);
  bounds_join(&there, g.sleep.resting);
  const bool few = d.fast_count <= k_fast_max && (!is_empty(there) || d.bounded);
  bool reaches[k_fast_max];
  for (uint32_t f = 0; f < count; ++f) reaches[f] = !few || meets(path_of(g, d.fast[f]), there, margin);
  for (uint32_t c = 0; few && c < g.colliders.solid_count; ++c) {
    ColliderFrame poses[2];
    pose_both(g, c, poses);
    for (uint32_t f = 0; f < count; ++f) reaches[f] = reaches[f] || meets(path_of(g, d.fast[f]), poses, margin);
  }
  for (uint32_t f = 0; few && f < count; ++f) {
    const Path path = path_of(g, d.fast[f]);
    for (uint32_t other = 0; other < f; ++other) {
      if (meets(path, path_of(g, d.fast[other]), d.horizon, neighbours_reach(g))) reaches[f] = reaches[other] = true;
    }
  }
  for (uint32_t f = 0; f < count; ++f) {
    mark(departed, g, d.fast[f], !reaches[f]);
    if (reaches[f]) count_in(&d, g.particles.records[0][d.fast[f]]);
  }
  if (d.fast_count <= k_fast_max) return;
  d.others_speed2 = d.fast_speed2 > d.others_speed2 ? d.fast_speed2 : d.others_speed2;
  bounds_join(&d.others, d.fast_ones);
}

bool beyond(const Granular& g, const Particles& p) {
  for (int k = 0; k < 3; ++k) {
    if (p.low[k] < -SANDGLASS_COORDINATE_LIMIT || p.high[k] > SANDGLASS_COORDINATE_LIMIT) return true;
  }
  Bounds all;
  __builtin_memcpy(all.low, p.low, sizeof all.low);
  __builtin_memcpy(all.high, p.high, sizeof all.high);
  return g.departed.falls && depth_of(g, all) > g.departed.gone_depth;
}

void complete(Departed* departed, const Granular& g) {
  Departed& d = *departed;
  judge_fast(departed, g);
  d.known = true;
  d.narrow = d.found != 0 || d.count != 0 || beyond(g, g.particles);
  d.count = d.found;
}

void begin_look(Departed* departed, const Granular& g) {
  Departed& d = *departed;
  d.horizon = static_cast<float>(time_interval(g));
  d.reach = neighbours_reach(g) - fall_of(g);
  d.others = d.fast_ones = k_nowhere;
  d.others_speed2 = d.fast_speed2 = 0.0f;
  d.found = d.fast_count = 0;
  d.returned = d.gone = d.narrow = false;
  for (uint32_t b = 0; b < g.bodies.count; ++b) d.spans[b] = {k_endless, -k_endless, true};
}

uint32_t whole_groups(uint32_t count) { return (count + k_lane_group - 1) / k_lane_group * k_lane_group; }
uint32_t slots_of(const Granular& g) { return whole_groups(g.bodies.particle_count); }

}  // namespace

void departed_layout(Departed* d, const sandglass_granular_desc& desc, Layout* layout) {
  d->spans = layout_region<BodySpan>(layout, "granular.body_spans", desc.body_capacity);
}

void departed_reset(Departed* d) {
  d->count = 0;
  d->known = d->gone = d->falls = d->open = d->grains_go = false;
  d->next_grains = 0.0;
}

void departed_begin_frame(Departed* departed, const Granular& g) {
  Departed& d = *departed;
  d.open = true;
  d.falls = g.gravity_length > 0.0f;
  d.bottom = -k_endless;
  d.bounded = false;
  for (uint32_t c = 0; c < g.colliders.solid_count; ++c) {
    ColliderFrame frames[2];
    pose_both(g, c, frames);
    for (const ColliderFrame& frame : frames) {
      if (holding_encloses(frame)) d.open = d.falls = false;
      if (frame.shape != SANDGLASS_SHAPE_HALF_SPACE) include_solid(departed, g, frame);
      else if (-dot(frame.axes[1], g.gravity) > k_floor_rise * g.gravity_length) d.falls = false;
    }
  }
  if (d.falls) {
    Bounds still = g.boundary.bounds;
    bounds_join(&still, g.sleep.resting);
    const float depth = depth_of(g, still);
    d.bottom = depth > d.bottom ? depth : d.bottom;
    d.falls = d.bottom > -k_endless;
  }
  const float reach = neighbours_reach(g), depth = g.desc.lowest > reach ? g.desc.lowest : reach;
  d.gone_depth = g.desc.lowest > 0.0f ? d.bottom + depth : k_endless;
}

void departed_begin_interval(Departed* d) { d->known = false; }

bool departed_due(const Granular& g) {
  const Departed& d = g.departed;
  if (d.known || g.particles.count == 0) return false;
  const float time = static_cast<float>(time_interval(g));
  const float distance = time * (g.particles.speed_max + time * g.gravity_length);
  return d.count != 0 || distance > neighbours_reach(g) || beyond(g, g.particles);
}

// The passes' groups are those of the lists: without lists all groups are looked at.
uint32_t departed_items(const Granular& g) {
  return slots_of(g) + (g.neighbours.valid ? sleep_active_items(g) : whole_groups(g.particles.count));
}

bool departed_run(Departed* departed, const Granular& g, uint32_t* cursor) {
  Departed& d = *departed;
  const uint32_t items = departed_items(g), slots = slots_of(g);
  const uint32_t end = items - *cursor < g.unit ? items : *cursor + g.unit;
  if (*cursor == 0) begin_look(departed, g);
  uint32_t at = *cursor;
  for (; at < end && at < slots; at += k_lane_group) {
    for (uint32_t slot = at; slot < at + k_lane_group && slot < g.bodies.particle_count; ++slot)
      measure_slot(departed, g, slot);
  }
  if (at == slots && (end > slots || end == items)) find_below(departed, g);  // once, also if a unit ended there
  for (; at < end; at += k_lane_group) {
    const uint32_t group = (at - slots) / k_lane_group;
    const uint32_t first = (g.neighbours.valid ? g.sleep.active_groups[group] : group) * k_lane_group;
    for (uint32_t i = first; i < first + k_lane_group && i < g.particles.count; ++i) look_at(departed, g, i);
    // A flow that has nothing to depart from, and that nothing has departed from, is not looked at any further.
    if (!d.falls && d.count == 0 && d.found == 0 && d.fast_count > k_fast_max && !beyond(g, g.particles)) {
      d.known = true;
      return true;
    }
  }
  *cursor = at;
  if (at < items) return false;
  complete(departed, g);
  return true;
}

bool departed_narrows(const Departed& d, const Granular& g, Bounds* all, float* speed_max) {
  if (!d.narrow) return false;
  *all = d.others;
  bounds_join(all, g.sleep.resting);
  *speed_max = __builtin_sqrtf(d.others_speed2);
  return true;
}

// Whether a place is below all that is there, by the last frame's colliders.
static bool is_below_all(const Granular& g, const float position[3]) {
  return departed_is_gone(g, position) ||
         (g.departed.falls && depth_of(g, position) > g.departed.bottom + neighbours_reach(g));
}

bool departed_has_left(const Granular& g, const Particle& p) {
  return is_awake(p) && !in_body(p) && (has_departed(p) || is_below_all(g, p.position));
}

// A grain has left, too, where it is far from all particles that have not departed.
bool departed_has_left(const Granular& g, const Grain& grain) {
  bool alone = false;
  for (int k = 0; k < 3; ++k) {
    const float margin = neighbours_reach(g), x = grain.position[k];
    alone = alone || x < g.particles.low[k] - margin || x > g.particles.high[k] + margin;
  }
  return alone || is_below_all(g, grain.position);
}

bool departed_takes_grains(Departed* departed, const Granular& g) {
  constexpr double k_period = 0.1;  // seconds of simulated time: grains that fell alone are looked for less often
  Departed& d = *departed;
  d.grains_go = d.gone || (d.falls && !(g.time.simulated < d.next_grains));
  if (d.grains_go) d.next_grains = g.time.simulated + k_period;
  return d.grains_go;
}

bool departed_is_gone(const Granular& g, const float position[3]) {
  for (int k = 0; k < 3; ++k) {
    if (!(__builtin_fabsf(position[k]) <= SANDGLASS_COORDINATE_LIMIT)) return true;
  }
  return g.departed.falls && depth_of(g, position) > g.departed.gone_depth;
}

}  // namespace sandglass
