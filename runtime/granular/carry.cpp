// What colliders hold, and how it goes with them. solver.h has the rules.
//
// Whether a particle lies on a collider is found by a ray along gravity: exactly for shapes that have a formula, by
// steps through a field. Sixteen at once; groups of them that are far from all that moves are passed over.
#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

constexpr uint32_t k_none = ~0u;
constexpr float k_far = 3e38f;
constexpr float k_in_wall = 2.0f;    // radii that an enclosed centre may lie in the wall
constexpr float k_same_way = 0.25f;  // radii by which ways may differ and be one
constexpr float k_step_out = 0.5f;   // radii that a collider goes at once through what gives way
constexpr uint32_t k_steps_out = 16;
constexpr uint32_t k_trace_steps = 24;  // through a field
constexpr uint32_t k_unit_share = 4;    // a particle costs so many times as much as in a pass

struct Lanes {
  float at[3][k_lane_group], velocity[3][k_lane_group];
  float low[3], high[3];
  uint32_t count, free;  // free: bits of the lanes that are sand, and have not departed
};

bool encloses(const ColliderFrame& c) { return c.shape == SANDGLASS_SHAPE_FIELD && c.field.outward < 0.0f; }

void velocity_at(const ColliderFrame& c, const float x[3], float v[3]) {
  const float r[3] = {x[0] - c.position[0], x[1] - c.position[1], x[2] - c.position[2]}, *w = c.angular;
  v[0] = c.linear[0] + (w[1] * r[2] - w[2] * r[1]);
  v[1] = c.linear[1] + (w[2] * r[0] - w[0] * r[2]);
  v[2] = c.linear[2] + (w[0] * r[1] - w[1] * r[0]);
}

// The box around a collider, in the world's axes; of a half-space, everything.
Bounds box_of(const ColliderFrame& c) {
  Bounds box = {{-k_far, -k_far, -k_far}, {k_far, k_far, k_far}};
  if (c.shape == SANDGLASS_SHAPE_HALF_SPACE) return box;
  for (int k = 0; k < 3; ++k) {
    float middle = c.position[k], half = c.extent[k];
    for (int a = 0; a < 3 && c.shape == SANDGLASS_SHAPE_FIELD; ++a) {
      const float side = 0.5f * c.field.spacing * static_cast<float>(c.field.counts[a] - 1);
      half = a == 0 ? 0.0f : half;
      middle += (c.field.low[a] + side) * c.axes[a][k];
      half += side * __builtin_fabsf(c.axes[a][k]);
    }
    box.low[k] = middle - half, box.high[k] = middle + half;
  }
  return box;
}

void to_local(const ColliderFrame& c, const float x[3], float local[3]) {
  for (int a = 0; a < 3; ++a) {
    local[a] = 0.0f;
    for (int k = 0; k < 3; ++k) local[a] += c.axes[a][k] * (x[k] - c.position[k]);
  }
}

// Metres along `way` until each ray is in the box; k_far: never. One way for all.
void enter_box(const float at[3][k_lane_group], const float way[3], const float low[3], const float high[3],
               float enter[k_lane_group]) {
  constexpr float k_along = 1e-6f;
  float leave[k_lane_group];
  for (uint32_t l = 0; l < k_lane_group; ++l) enter[l] = 0.0f, leave[l] = k_far;
  for (int k = 0; k < 3; ++k) {
    if (__builtin_fabsf(way[k]) < k_along) {
      for (uint32_t l = 0; l < k_lane_group; ++l) leave[l] = at[k][l] < low[k] || at[k][l] > high[k] ? -1.0f : leave[l];
      continue;
    }
    const float inverse = 1.0f / way[k], first = way[k] > 0.0f ? low[k] : high[k], last = low[k] + high[k] - first;
    for (uint32_t l = 0; l < k_lane_group; ++l) {
      const float in = (first - at[k][l]) * inverse, out = (last - at[k][l]) * inverse;
      enter[l] = enter[l] < in ? in : enter[l];
      leave[l] = out < leave[l] ? out : leave[l];
    }
  }
  for (uint32_t l = 0; l < k_lane_group; ++l) enter[l] = enter[l] <= leave[l] ? enter[l] : k_far;
}

void measure(const Granular& g, const ColliderFrame& c, const float at[3][k_lane_group], float distance[k_lane_group],
             float (*normal)[k_lane_group] = nullptr) {
  alignas(SANDGLASS_BLOCK_ALIGNMENT) SurfacePoint points[k_lane_group] = {};
  for (uint32_t l = 0; l < k_lane_group; ++l)
    for (int k = 0; k < 3; ++k) points[l].position[k] = at[k][l];
  const SurfaceArgs args = {points, &c};
  uint32_t unused = 0;
  g.kernels->surface_at(&args, 0, k_lane_group, &unused);
  for (uint32_t l = 0; l < k_lane_group; ++l) {
    distance[l] = points[l].distance;
    for (int k = 0; k < 3 && normal != nullptr; ++k) normal[k][l] = points[l].normal[k];
  }
}

// A ball about each point of a segment.
float capsule_below(const ColliderFrame& c, const float x[3], const float down[3], float reach) {
  const float half = c.shape == SANDGLASS_SHAPE_CAPSULE ? c.size[1] : 0.0f;
  float gone = 0.0f;
  for (uint32_t step = 0; step < k_trace_steps && gone < reach; ++step) {
    float r[3], along = 0.0f, square = 0.0f;
    for (int k = 0; k < 3; ++k) r[k] = x[k] + gone * down[k] - c.position[k], along += r[k] * c.axes[1][k];
    along = along < -half ? -half : along > half ? half : along;
    for (int k = 0; k < 3; ++k) r[k] -= along * c.axes[1][k], square += r[k] * r[k];
    const float distance = __builtin_sqrtf(square) - c.size[0];
    if (distance < 1e-3f * c.size[0]) return gone;
    gone += distance;
  }
  return k_far;
}

void to_local(const ColliderFrame& c, const float at[3][k_lane_group], float local[3][k_lane_group]) {
  float apart[3][k_lane_group];
  for (int k = 0; k < 3; ++k)
    for (uint32_t l = 0; l < k_lane_group; ++l) apart[k][l] = at[k][l] - c.position[k];
  for (int a = 0; a < 3; ++a)
    for (uint32_t l = 0; l < k_lane_group; ++l)
      local[a][l] = c.axes[a][0] * apart[0][l] + c.axes[a][1] * apart[1][l] + c.axes[a][2] * apart[2][l];
}

// On from where rays entered the grid of a field, to its surface.
void trace_field(const Granular& g, const ColliderFrame& c, const Lanes& lanes, const float down[3],
                 float below[k_lane_group]) {
  const float r = g.desc.particle_radius;
  float at[3][k_lane_group], distance[k_lane_group];
  bool open = true;
  for (uint32_t step = 0; step < k_trace_steps && open; ++step) {
    const float shortest = (0.5f + 0.25f * static_cast<float>(step)) * r;
    for (uint32_t l = 0; l < k_lane_group; ++l)
      for (int k = 0; k < 3; ++k) at[k][l] = lanes.at[k][l] + (below[l] < k_far ? below[l] : 0.0f) * down[k];
    measure(g, c, at, distance);
    open = false;
    for (uint32_t l = 0; l < lanes.count; ++l) {
      if (below[l] >= k_far || distance[l] < 0.25f * r) continue;
      below[l] += distance[l] > shortest ? distance[l] : shortest;
      open = true;
    }
  }
  for (uint32_t l = 0; l < lanes.count; ++l) below[l] = distance[l] < 0.25f * r ? below[l] : k_far;
}

// Metres down to a collider, of each lane; k_far: it is not below.
void find_below(const Granular& g, const ColliderFrame& c, const Lanes& lanes, const float down[3],
                float below[k_lane_group]) {
  float way[3], local[3][k_lane_group];
  for (int a = 0; a < 3; ++a) way[a] = c.axes[a][0] * down[0] + c.axes[a][1] * down[1] + c.axes[a][2] * down[2];
  to_local(c, lanes.at, local);
  if (c.shape == SANDGLASS_SHAPE_HALF_SPACE) {
    for (uint32_t l = 0; l < k_lane_group; ++l)
      below[l] = local[1][l] <= 0.0f ? 0.0f : way[1] < -1e-6f ? local[1][l] / -way[1] : k_far;
  } else if (c.shape == SANDGLASS_SHAPE_BOX) {
    const float least[3] = {-c.size[0], -c.size[1], -c.size[2]};
    enter_box(local, way, least, c.size, below);
  } else if (c.shape == SANDGLASS_SHAPE_FIELD) {
    float most[3];
    for (int a = 0; a < 3; ++a) most[a] = c.field.low[a] + c.field.spacing * static_cast<float>(c.field.counts[a] - 1);
    enter_box(local, way, c.field.low, most, below);
    trace_field(g, c, lanes, down, below);
  } else {
    for (uint32_t l = 0; l < lanes.count; ++l) {
      const float x[3] = {lanes.at[0][l], lanes.at[1][l], lanes.at[2][l]};
      below[l] = capsule_below(c, x, down, k_coordinate_bound);
    }
  }
}

// Whether the velocity is near to one between rest and the collider's: not that of sand that falls onto it.
bool goes_along(const Lanes& lanes, uint32_t l, const ColliderFrame& c, float most) {
  const float x[3] = {lanes.at[0][l], lanes.at[1][l], lanes.at[2][l]};
  float v[3], length2 = 0.0f, with = 0.0f, apart2 = 0.0f;
  velocity_at(c, x, v);
  for (int k = 0; k < 3; ++k) length2 += v[k] * v[k], with += v[k] * lanes.velocity[k][l];
  float share = length2 > 0.0f ? with / length2 : 0.0f;
  share = share > 0.0f ? (share < 1.0f ? share : 1.0f) : 0.0f;
  for (int k = 0; k < 3; ++k) {
    const float apart = lanes.velocity[k][l] - share * v[k];
    apart2 += apart * apart;
  }
  return apart2 <= most * most;
}

// Of a support's group: bits of the lanes within its box.
uint32_t within_group(const Granular& g, uint32_t collider, const Lanes& lanes) {
  const CarryGroup& group = g.carry.groups[g.carry.group_of[collider]];
  if (!group.hollow) return 0;
  float local[3][k_lane_group];
  int32_t beyond[k_lane_group] = {};
  to_local(g.colliders.carriers[group.first].from, lanes.at, local);
  for (int k = 0; k < 3; ++k)
    for (uint32_t l = 0; l < k_lane_group; ++l)
      beyond[l] |= (local[k][l] < group.box.low[k] ? 1 : 0) | (local[k][l] > group.box.high[k] ? 1 : 0);
  uint32_t within = 0;
  for (uint32_t l = 0; l < lanes.count; ++l) within |= beyond[l] == 0 ? 1u << l : 0;
  return within;
}

// Whether a collider may be below a point of the lanes, or reach it: of a box around it that is as much wider.
bool may_be_below(const ColliderFrame& c, const Lanes& lanes, const float down[3], float margin) {
  const Bounds box = box_of(c);
  float enter = 0.0f, leave = k_far;
  for (int k = 0; k < 3; ++k) {
    const float low = box.low[k] - margin - lanes.high[k], high = box.high[k] + margin - lanes.low[k];
    if (__builtin_fabsf(down[k]) < 1e-6f) {
      leave = low > 0.0f || high < 0.0f ? -1.0f : leave;
      continue;
    }
    const float a = low / down[k], b = high / down[k];
    enter = (a < b ? a : b) > enter ? (a < b ? a : b) : enter;
    leave = (a < b ? b : a) < leave ? (a < b ? b : a) : leave;
  }
  return enter <= leave;
}

bool overlaps(const Bounds& a, const Bounds& b, float margin) {
  bool meet = true;
  for (int k = 0; k < 3; ++k) meet = meet && a.low[k] - margin <= b.high[k] && b.low[k] - margin <= a.high[k];
  return meet;
}

bool carries(const Granular& g, uint32_t i) { return g.carry.group_of[i] != k_carry_groups; }

// The collider that holds each lane; k_none: none that moves.
void find_holders(const Granular& g, const Lanes& lanes, uint32_t holder[k_lane_group]) {
  const float r = g.desc.particle_radius, length = g.gravity_length;
  float down[3] = {0, 0, 0}, nearest[k_lane_group], below[k_lane_group], found[k_lane_group];
  uint32_t support[k_lane_group], enclosing[k_lane_group];
  for (int k = 0; k < 3 && length > 0.0f; ++k) down[k] = g.gravity[k] / length;
  for (uint32_t l = 0; l < k_lane_group; ++l)
    holder[l] = support[l] = enclosing[l] = k_none, nearest[l] = below[l] = k_far;
  const Carrier* carriers = g.colliders.carriers;
  bool some = false;
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i)
    some = some || (carries(g, i) && may_be_below(carriers[i].from, lanes, down, r));
  if (!some) return;
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    const ColliderFrame& c = carriers[i].from;
    if (!may_be_below(c, lanes, down, r)) continue;
    if (encloses(c)) {
      measure(g, c, lanes.at, found);
      for (uint32_t l = 0; l < lanes.count; ++l)
        if (found[l] > -k_in_wall * r && found[l] < nearest[l]) nearest[l] = found[l], enclosing[l] = i;
    } else if (length > 0.0f) {
      find_below(g, c, lanes, down, found);
      for (uint32_t l = 0; l < lanes.count; ++l)
        if (found[l] < below[l]) below[l] = found[l], support[l] = i;
    }
  }
  uint32_t asked = k_none, within = 0;
  for (uint32_t l = 0; l < lanes.count; ++l) {
    const uint32_t on = support[l], in = enclosing[l];
    if (in != k_none && carries(g, in)) holder[l] = in;
    if (on == k_none || !carries(g, on)) continue;
    if (on != asked) within = within_group(g, on, lanes), asked = on;
    const bool inside = (within >> l & 1) != 0;
    const bool lies = !inside && g.carry.due == Carry::Moment::close &&
                      goes_along(lanes, l, carriers[on].from, granular_speed_scale(g));
    if (!inside && !lies) continue;
    // In a vessel within a field, or the other way round: what is nearer is the inner one.
    if (holder[l] == k_none || (inside && below[l] < nearest[l] + 2.0f * r) || lies) holder[l] = on;
  }
}

// A pose between those of a carrier.
ColliderFrame pose_between(const Carrier& carrier, float share) {
  ColliderFrame f = carrier.to;
  for (int a = 0; a < 3; ++a) {
    f.position[a] = carrier.from.position[a] + share * (carrier.to.position[a] - carrier.from.position[a]);
    float length2 = 0.0f;
    for (int k = 0; k < 3; ++k) {
      f.axes[a][k] = carrier.from.axes[a][k] + share * (carrier.to.axes[a][k] - carrier.from.axes[a][k]);
      length2 += f.axes[a][k] * f.axes[a][k];
    }
    for (int k = 0; k < 3; ++k) f.axes[a][k] /= __builtin_sqrtf(length2);
  }
  find_extent(&f);
  return f;
}

// Puts lanes out of a collider, by no more than `most` each. Returns whether any was in it.
bool put_out(const Granular& g, const ColliderFrame& c, Lanes* lanes, uint32_t mask, const float most[k_lane_group],
             float moved[k_lane_group]) {
  float distance[k_lane_group], normal[3][k_lane_group];
  measure(g, c, lanes->at, distance, normal);
  bool any = false;
  for (uint32_t l = 0; l < lanes->count; ++l) {
    float depth = g.desc.particle_radius - distance[l];
    depth = depth < most[l] ? depth : most[l];
    if ((mask >> l & 1) == 0 || !(depth > 0.0f)) continue;
    for (int k = 0; k < 3; ++k) lanes->at[k][l] += depth * normal[k][l];
    moved[l] += depth;
    any = true;
  }
  return any;
}

// What is not held gives way to what moves, in steps that are short against it; then nothing is in what stands.
void give_way(const Granular& g, Lanes* lanes, uint32_t mask, float moved[k_lane_group]) {
  const float r = g.desc.particle_radius;
  const Bounds here = {{lanes->low[0], lanes->low[1], lanes->low[2]}, {lanes->high[0], lanes->high[1], lanes->high[2]}};
  float endless[k_lane_group];
  for (float& m : endless) m = k_far;
  for (uint32_t i = 0; i < g.colliders.solid_count && mask != 0; ++i) {
    const Carrier& carrier = g.colliders.carriers[i];
    Bounds box = box_of(carrier.from);
    bounds_join(&box, box_of(carrier.to));
    if (!carries(g, i) || encloses(carrier.to) || !overlaps(here, box, 2.0f * r)) continue;
    float most = 0.0f, low[3], high[3];
    for (int corner = 0; corner < 2; ++corner) {
      carrier.way.way(corner == 0 ? here.low : here.high, corner == 0 ? low : high);
      const float* u = corner == 0 ? low : high;
      const float way = __builtin_sqrtf(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
      most = way > most ? way : most;
    }
    const float parts = most / (k_step_out * r);
    const uint32_t steps = carrier.to.shape == SANDGLASS_SHAPE_HALF_SPACE ? 1
                           : parts < static_cast<float>(k_steps_out)      ? static_cast<uint32_t>(parts) + 1
                                                                          : k_steps_out;
    for (uint32_t step = 1; step <= steps; ++step)
      put_out(g, pose_between(carrier, static_cast<float>(step) / static_cast<float>(steps)), lanes, mask, endless,
              moved);
  }
}

void leave_standing(const Granular& g, Lanes* lanes, uint32_t mask, const float moved[k_lane_group]) {
  float most[k_lane_group] = {}, unused[k_lane_group] = {};
  Bounds here = k_nowhere;
  for (uint32_t l = 0; l < lanes->count; ++l) {
    const float x[3] = {lanes->at[0][l], lanes->at[1][l], lanes->at[2][l]};
    most[l] = moved[l];
    bounds_include(&here, x, g.desc.particle_radius);
  }
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i)
    if (!carries(g, i) && overlaps(here, box_of(g.colliders.carriers[i].to), 0.0f))
      put_out(g, g.colliders.carriers[i].to, lanes, mask, most, unused);
}

}  // namespace

void carry_layout(Carry* c, const sandglass_granular_desc& d, Layout* layout) {
  c->group_of = layout_region<uint8_t>(layout, "granular.carry_groups", d.collider_capacity);
}

void carry_reset(Carry* c) {
  c->due = Carry::Moment::none;
  c->closing = c->known = c->usual = false;
}

void carry_begin_frame(Carry* c, bool jumped, bool moving) {
  c->due = jumped ? Carry::Moment::jump : Carry::Moment::none;
  c->moving = moving;
  c->closing = c->known = false;
  c->cursor = c->carried = 0;
}

void carry_close(Carry* c) {
  if (c->moving && !c->closing) c->due = Carry::Moment::close;
  c->closing = true;
  c->known = false;
}

bool carry_is_due(const Granular& g) {
  if (g.carry.due != Carry::Moment::close) return g.carry.due == Carry::Moment::jump;
  return g.carry.known || g.time.debt >= k_time_resolution || g.time.rate < 1.0;
}

static uint32_t unit_of(const Granular& g) {
  const uint32_t unit = g.unit / k_unit_share / k_lane_group * k_lane_group;
  return unit > k_lane_group ? unit : uint32_t{k_lane_group};
}

uint32_t carry_units(const Granular& g) { return (g.particles.count + unit_of(g) - 1) / unit_of(g); }

bool carry_is_expected(const Granular& g) {
  return g.carry.usual && g.carry.moving && (g.time.debt >= k_time_resolution || g.time.rate < 1.0);
}

uint32_t carry_items(const Granular& g) {
  const uint32_t left = g.particles.count - g.carry.cursor, unit = unit_of(g);
  return left < unit ? left : unit;
}

void carry_begin(Carry* c, const Granular& g, float faster) {
  c->known = true;
  c->faster = faster;
  c->cursor = c->group_count = 0;
  c->gave_way = false;
  c->pushed = c->resting = c->standing = k_nowhere;
  c->way_max = 0.0f;
  const float same = k_same_way * g.desc.particle_radius;
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    const Carrier& carrier = g.colliders.carriers[i];
    c->group_of[i] = k_carry_groups;
    if (!carrier.moves) continue;
    uint32_t at = 0;
    for (; at < c->group_count; ++at) {
      const Carrier& first = g.colliders.carriers[c->groups[at].first];
      const float* const places[] = {carrier.from.position, first.from.position};
      float apart2 = 0.0f;
      for (const float* place : places) {
        float mine[3], other[3], d2 = 0.0f;
        carrier.way.way(place, mine), first.way.way(place, other);
        for (int k = 0; k < 3; ++k) d2 += (mine[k] - other[k]) * (mine[k] - other[k]);
        apart2 = d2 > apart2 ? d2 : apart2;
      }
      if (apart2 <= same * same) break;
    }
    if (at == k_carry_groups) continue;
    if (at == c->group_count) c->groups[c->group_count++] = {i, 0, k_nowhere, false};
    CarryGroup& group = c->groups[at];
    c->group_of[i] = static_cast<uint8_t>(at);
    if (carrier.from.shape == SANDGLASS_SHAPE_HALF_SPACE) continue;
    ++group.members;
    group.hollow = group.members > 1 || carrier.from.shape == SANDGLASS_SHAPE_FIELD;
    const Bounds box = box_of(carrier.from);
    for (int corner = 0; corner < 8; ++corner) {
      const float x[3] = {(corner & 1) != 0 ? box.high[0] : box.low[0], (corner & 2) != 0 ? box.high[1] : box.low[1],
                          (corner & 4) != 0 ? box.high[2] : box.low[2]};
      float local[3];
      to_local(g.colliders.carriers[group.first].from, x, local);
      bounds_include(&group.box, local);
    }
  }
  for (uint32_t i = 0; i < k_carry_groups; ++i) c->held[i] = k_nowhere;
  for (uint32_t b = 0; b < g.bodies.count; ++b) {
    c->body_holders[b] = 0;
    if (!bodies_has(g.bodies, b) || c->group_count == 0) continue;
    Lanes lanes = {};
    lanes.count = 1;
    for (int k = 0; k < 3; ++k) {
      lanes.at[k][0] = lanes.low[k] = lanes.high[k] = static_cast<float>(g.bodies.all[b].center[k]);
      lanes.velocity[k][0] = g.bodies.all[b].linear[k];
    }
    uint32_t holder[k_lane_group];
    find_holders(g, lanes, holder);
    if (holder[0] == k_none) continue;
    const Carrier& carrier = g.colliders.carriers[holder[0]];
    float center[3] = {lanes.at[0][0], lanes.at[1][0], lanes.at[2][0]}, change[3];
    carrier.way.move(center);
    velocity_at(carrier.from, center, change);
    for (float& v : change) v *= faster - 1.0f;
    bodies_carry(g, b, carrier.way, change);
    c->body_holders[b] = static_cast<uint8_t>(holder[0] + 1);
  }
}

namespace {

// What a particle's copies hold as velocity while a sub-step is under way: so many seconds of it. 1: a velocity.
float second_scale(const Granular& g, uint32_t group, uint32_t active_before) {
  const SubstepPhase phase = g.substep.phase;
  const bool last =
      phase == SubstepPhase::complete || (phase == SubstepPhase::solve && g.contacts.pass + 1 == g.contacts.iterations);
  const bool active = active_before < g.sleep.active_count && g.sleep.active_groups[active_before] == group;
  if (phase == SubstepPhase::stabilise || !active) return 1.0f;
  return last && active_before * k_lane_group < g.substep.cursor ? 1.0f : g.substep.length;
}

Bounds box_of(const Lanes& lanes) {
  Bounds box;
  for (int k = 0; k < 3; ++k) {
    float low[k_lane_group], high[k_lane_group];
    for (uint32_t l = 0; l < k_lane_group; ++l) low[l] = high[l] = lanes.at[k][l];
    for (uint32_t half = k_lane_group / 2; half != 0; half /= 2) {
      for (uint32_t l = 0; l < half; ++l) {
        low[l] = low[l + half] < low[l] ? low[l + half] : low[l];
        high[l] = high[l + half] > high[l] ? high[l + half] : high[l];
      }
    }
    box.low[k] = low[0], box.high[k] = high[0];
  }
  return box;
}

// x becomes x + columns d, for d = x - from; v becomes v + turn v + gain d, with what collider and sand differ by.
struct QuadWay {
  Quad from, turn[3], shift, gain[3], constant;
};
Quad quad(const float v[3]) { return Quad{v[0], v[1], v[2], 0.0f}; }
Quad times(const Quad columns[3], const Quad& v) {
  const Quad x = {v[0], v[0], v[0], v[0]}, y = {v[1], v[1], v[1], v[1]}, z = {v[2], v[2], v[2], v[2]};
  return (columns[0] * x + columns[1] * y) + columns[2] * z;
}

// The gain is of the collider's velocity there: `more` times that.
QuadWay quad_way(const Carrier& carrier, float more) {
  const RigidWay& w = carrier.way;
  const float *v = carrier.from.linear, *s = carrier.from.angular;
  const float spin[3][3] = {{0, s[2], -s[1]}, {-s[2], 0, s[0]}, {s[1], -s[0], 0}};
  QuadWay q = {quad(w.from), {}, quad(w.shift), {}, {}};
  for (int k = 0; k < 3; ++k) q.turn[k] = Quad{w.turn[0][k], w.turn[1][k], w.turn[2][k], 0.0f};
  const auto gained = [&](const float u[3]) { return (quad(u) + times(q.turn, quad(u))) * more; };
  for (int k = 0; k < 3; ++k) q.gain[k] = gained(spin[k]);
  q.constant = gained(v);
  return q;
}

// A copy of a particle, which holds `scale` seconds of its velocity.
void carry_copy(const QuadWay& q, float scale, Particle* p) {
  struct Halves {
    Quad at, velocity;
  } halves;
  const uint32_t identity = p->identity;
  static_assert(sizeof halves == sizeof *p);
  __builtin_memcpy(&halves, p, sizeof halves);
  const Quad d = halves.at - q.from;
  halves.at += times(q.turn, d) + q.shift;
  halves.velocity += times(q.turn, halves.velocity);
  if (scale != 0.0f) halves.velocity += (times(q.gain, d) + q.constant) * scale;
  __builtin_memcpy(p, &halves, sizeof halves);
  p->identity = identity;
}

// Moves the lanes that one collider holds, in all that is kept of them.
void carry_lanes(Carry* c, const Granular& g, uint32_t first, uint32_t holder, uint32_t mask, float scale, Lanes* lanes,
                 float moved[k_lane_group]) {
  const Carrier& carrier = g.colliders.carriers[holder];
  const float more = c->faster - 1.0f, gains = more != 0.0f ? 1.0f : 0.0f;
  const QuadWay q = quad_way(carrier, more);
  Bounds before = {}, after = k_nowhere;
  float way2 = 0.0f;
  for (int k = 0; k < 3; ++k) before.low[k] = lanes->low[k], before.high[k] = lanes->high[k];
  for (int corner = 0; corner < 8; ++corner) {
    float x[3], u[3];
    for (int k = 0; k < 3; ++k) x[k] = (corner >> k & 1) != 0 ? before.high[k] : before.low[k];
    carrier.way.way(x, u);
    const float square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    way2 = square > way2 ? square : way2;
    for (int k = 0; k < 3; ++k) x[k] += u[k];
    bounds_include(&after, x);
  }
  Bounds& held = c->held[c->group_of[holder]];
  bounds_join(&held, before), bounds_join(&held, after);
  const float way = __builtin_sqrtf(way2);
  c->way_max = way > c->way_max ? way : c->way_max;
  for (uint32_t l = 0; l < lanes->count; ++l) {
    if ((mask >> l & 1) == 0) continue;
    Particle& p = g.particles.records[0][first + l];
    const bool awake = is_awake(p);
    carry_copy(q, awake ? gains : 0.0f, &p);
    for (uint32_t copy = 1; copy < 3 && (!awake || scale != 0.0f); ++copy)
      if (g.particles.records[copy] != nullptr)
        carry_copy(q, awake ? gains * scale : 0.0f, &g.particles.records[copy][first + l]);
    for (int k = 0; k < 3; ++k) lanes->at[k][l] = p.position[k];
    if (!awake) bounds_include(&c->resting, p.position);
    sleep_carry(g, number_of(p), carrier.way);
    moved[l] = way;
    ++c->carried;
  }
}

// Lanes that hold nothing, or what has departed, are as one that counts. False: there is none.
bool read_lanes(const Granular& g, uint32_t first, Lanes* lanes) {
  const Particle* records = g.particles.records[0] + first;
  lanes->count = g.particles.count - first < k_lane_group ? g.particles.count - first : k_lane_group;
  lanes->free = 0;
  uint32_t here = 0;
  for (uint32_t l = 0; l < lanes->count; ++l) {
    here |= has_departed(records[l]) ? 0 : 1u << l;
    lanes->free |= has_departed(records[l]) || in_body(records[l]) ? 0 : 1u << l;
  }
  if (here == 0) return false;
  const uint32_t instead = static_cast<uint32_t>(__builtin_ctz(here));
  for (uint32_t l = 0; l < k_lane_group; ++l) {
    const Particle& p = records[(here >> l & 1) != 0 ? l : instead];
    for (int k = 0; k < 3; ++k) lanes->at[k][l] = p.position[k], lanes->velocity[k][l] = p.velocity[k];
  }
  const Bounds box = box_of(*lanes);
  for (int k = 0; k < 3; ++k) lanes->low[k] = box.low[k], lanes->high[k] = box.high[k];
  return true;
}

// What was put elsewhere in a lane, without a velocity.
void write_pushed(Carry* c, const Granular& g, uint32_t i, const float to[3]) {
  float way[3], way2 = 0.0f;
  const Particle& p = g.particles.records[0][i];
  for (int k = 0; k < 3; ++k) way[k] = to[k] - p.position[k], way2 += way[k] * way[k];
  if (way2 == 0.0f) return;
  for (Particle* records : g.particles.records)
    for (int k = 0; k < 3 && records != nullptr; ++k) records[i].position[k] += way[k];
  const float length = __builtin_sqrtf(way2);
  c->way_max = length > c->way_max ? length : c->way_max;
  c->gave_way = true;
  bounds_include(&c->pushed, p.position);
  if (is_asleep(p)) bounds_include(&c->resting, p.position);
}

void run_group(Carry* c, const Granular& g, uint32_t group, uint32_t active_before) {
  Lanes lanes;
  uint32_t holder[k_lane_group], open = 0;
  if (!read_lanes(g, group * k_lane_group, &lanes)) return;
  find_holders(g, lanes, holder);
  const bool under_way = g.substep.phase >= SubstepPhase::stabilise && g.substep.phase <= SubstepPhase::bodies;
  const float scale = under_way ? second_scale(g, group, active_before) : 0.0f;
  float moved[k_lane_group] = {};
  uint32_t left = 0;
  for (uint32_t l = 0; l < lanes.count; ++l) {
    const Particle& p = g.particles.records[0][group * k_lane_group + l];
    if (has_departed(p)) continue;
    const uint32_t of_body = in_body(p) ? c->body_holders[body_of(p) - 1] : 0;
    holder[l] = in_body(p) ? (of_body != 0 ? of_body - 1 : k_none) : holder[l];
    left |= holder[l] != k_none ? 1u << l : 0;
    if (holder[l] != k_none) continue;
    bounds_include(&c->standing, p.position);
    open |= in_body(p) ? 0 : 1u << l;
  }
  while (left != 0) {
    const uint32_t by = holder[__builtin_ctz(left)];
    uint32_t mask = 0;
    for (uint32_t l = 0; l < lanes.count; ++l) mask |= (left >> l & 1) != 0 && holder[l] == by ? 1u << l : 0;
    carry_lanes(c, g, group * k_lane_group, by, mask, scale, &lanes, moved);
    left &= ~mask;
  }
  if (c->due == Carry::Moment::close) give_way(g, &lanes, open, moved);
  uint32_t some = 0;
  for (uint32_t l = 0; l < lanes.count; ++l) some |= moved[l] > 0.0f ? 1u << l : 0;
  if ((some & lanes.free) == 0) return;
  leave_standing(g, &lanes, lanes.free, moved);
  for (uint32_t l = 0; l < lanes.count; ++l) {
    const float to[3] = {lanes.at[0][l], lanes.at[1][l], lanes.at[2][l]};
    if ((lanes.free >> l & 1) != 0) write_pushed(c, g, group * k_lane_group + l, to);
  }
}

}  // namespace

bool carry_run(Carry* c, const Granular& g) {
  const uint32_t end = c->cursor + carry_items(g);
  uint32_t active = 0;
  const Sleep& sleep = g.sleep;
  while (active < sleep.active_count && sleep.active_groups[active] < c->cursor / k_lane_group) ++active;
  for (uint32_t group = c->cursor / k_lane_group; group * k_lane_group < end && c->group_count != 0; ++group) {
    run_group(c, g, group, active);
    if (active < sleep.active_count && sleep.active_groups[active] == group) ++active;
  }
  c->cursor = end;
  return end >= g.particles.count || c->group_count == 0;
}

void carry_end(Carry* c) {
  c->usual = c->usual || c->due == Carry::Moment::close;
  c->due = Carry::Moment::none;
  c->known = false;
}

Bounds carry_bounds(const Carry& c, float margin) {
  Bounds all = c.pushed;
  for (uint32_t i = 0; i < c.group_count; ++i) bounds_join(&all, c.held[i]);
  for (int k = 0; k < 3 && !is_empty(all); ++k) all.low[k] -= margin, all.high[k] += margin;
  return all;
}

bool carry_mixes(const Granular& g) {
  const Carry& c = g.carry;
  if (c.gave_way) return true;
  const float reach = neighbours_reach(g);
  for (uint32_t a = 0; a < c.group_count; ++a) {
    if (is_empty(c.held[a])) continue;
    if (!is_empty(c.standing) && overlaps(c.held[a], c.standing, reach)) return true;
    for (uint32_t b = 0; b < a; ++b)
      if (!is_empty(c.held[b]) && overlaps(c.held[a], c.held[b], reach)) return true;
  }
  return false;
}

}  // namespace sandglass
