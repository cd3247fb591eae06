// Who holds sand: what encloses it, and what is below it along gravity. Rays meet shapes by formulas, and fields in steps.
#include "runtime/sand/holding.h"

namespace sandglass {

namespace {

constexpr float k_far = 3e38f;
constexpr float k_in_wall = 2.0f;       // radii that an enclosed centre may lie in the wall
constexpr float k_reached = 0.25f;      // radii from a field's surface that count as on it
constexpr float k_thin = 2.5f;          // radii of a step that cannot pass a wall of two
constexpr uint32_t k_trace_steps = 24;  // through a field, or to a capsule
constexpr uint32_t k_corners = 8, k_all_corners = (1u << k_corners) - 1;

// Four lanes of sixteen.
Quad& four(float lanes[k_lane_group], uint32_t l) { return *reinterpret_cast<Quad*>(lanes + l); }
const Quad& four(const float lanes[k_lane_group], uint32_t l) { return *reinterpret_cast<const Quad*>(lanes + l); }

void to_local(const Granular& g, const ColliderFrame& c, const HeldLanes& lanes) {
  const auto& at = lanes.at;
  auto& local = scratch_of(g).local;
  for (uint32_t l = 0; l < lanes.count; l += 4) {
    const Quad x = four(at[0], l) - c.position[0], y = four(at[1], l) - c.position[1],
               z = four(at[2], l) - c.position[2];
    for (int a = 0; a < 3; ++a) four(local[a], l) = c.axes[a][0] * x + c.axes[a][1] * y + c.axes[a][2] * z;
  }
}

// Metres along `direction` until each ray is in the box; k_far: never.
void enter_box(const Granular& g, uint32_t count, const float direction[3], const float low[3], const float high[3],
               float enter[k_lane_group]) {
  constexpr float k_along = 1e-6f;
  const auto& at = scratch_of(g).local;
  for (uint32_t l = 0; l < count; l += 4) {
    const Quad far = Quad{} + k_far, never = Quad{} - 1.0f;
    Quad in = {}, out = far;
    for (int k = 0; k < 3; ++k) {
      const Quad x = four(at[k], l);
      if (__builtin_fabsf(direction[k]) < k_along) {
        out = x < low[k] ? never : out;
        out = x > high[k] ? never : out;
        continue;
      }
      const float inverse = 1.0f / direction[k];
      const Quad first = ((direction[k] > 0.0f ? low[k] : high[k]) - x) * inverse;
      const Quad last = ((direction[k] > 0.0f ? high[k] : low[k]) - x) * inverse;
      in = in < first ? first : in;
      out = last < out ? last : out;
    }
    four(enter, l) = in <= out ? in : far;
  }
}

// Metres down until each ray is in a ball; k_far: never.
void enter_ball(const ColliderFrame& c, const HeldLanes& lanes, const float down[3], float enter[k_lane_group]) {
  for (uint32_t l = 0; l < lanes.count; l += 4) {
    Quad along = {}, square = {};
    for (int k = 0; k < 3; ++k) {
      const Quad r = four(lanes.at[k], l) - c.position[k];
      along -= r * down[k];
      square += r * r;
    }
    const Quad within = c.size[0] * c.size[0] - (square - along * along);  // of the nearest point, squared
    for (uint32_t i = 0; i < 4; ++i) {
      const bool inside = square[i] <= c.size[0] * c.size[0], meets = within[i] >= 0.0f && along[i] > 0.0f;
      enter[l + i] = inside ? 0.0f : meets ? along[i] - __builtin_sqrtf(within[i]) : k_far;
    }
  }
}

// Metres down until a ray is in a capsule: in steps as long as the distance to it.
float capsule_below(const ColliderFrame& c, const HeldLanes& lanes, uint32_t l, const float down[3]) {
  const float half = c.size[1];
  float travelled = 0.0f;
  for (uint32_t step = 0; step < k_trace_steps && travelled < k_coordinate_bound; ++step) {
    float r[3], along = 0.0f, square = 0.0f;
    for (int k = 0; k < 3; ++k) {
      r[k] = lanes.at[k][l] + travelled * down[k] - c.position[k];
      along += r[k] * c.axes[1][k];
    }
    along = along < -half ? -half : along > half ? half : along;
    for (int k = 0; k < 3; ++k) {
      r[k] -= along * c.axes[1][k];
      square += r[k] * r[k];
    }
    const float distance = __builtin_sqrtf(square) - c.size[0];
    if (distance < 1e-3f * c.size[0]) return travelled;
    travelled += distance;
  }
  return k_far;
}

// From where rays entered the grid of a field or relief on to its surface. A step that goes beyond the surface is halved.
void trace_field(const Granular& g, const ColliderFrame& c, const HeldLanes& lanes, const float down[3],
                 float below[k_lane_group]) {
  const float r = g.desc.particle_radius;
  auto& at = scratch_of(g).traced;
  auto &distance = scratch_of(g).distance, &last = scratch_of(g).last;  // steps; below 0: between the last two
  for (float& s : last) s = 0.0f;
  bool open = true;
  for (uint32_t step = 0; step < k_trace_steps && open; ++step) {
    const float longer = 0.5f + 0.25f * static_cast<float>(step), shortest = (longer < k_thin ? longer : k_thin) * r;
    for (uint32_t l = 0; l < lanes.count; ++l)
      for (int k = 0; k < 3; ++k) at[k][l] = lanes.at[k][l] + (below[l] < k_far ? below[l] : 0.0f) * down[k];
    holding_measure(g, c, at, distance, lanes.count);
    open = false;
    for (uint32_t l = 0; l < lanes.count; ++l) {
      const bool beyond = distance[l] < k_reached * r;
      const float half = 0.5f * __builtin_fabsf(last[l]);
      if (below[l] >= k_far || ((beyond || last[l] < 0.0f) && half < k_reached * r)) continue;
      if (last[l] < 0.0f || beyond) {
        below[l] += beyond ? -half : half;
        last[l] = -half;
      } else {
        last[l] = distance[l] > shortest ? distance[l] : shortest;
        below[l] += last[l];
      }
      open = true;
    }
  }
  for (uint32_t l = 0; l < lanes.count; ++l)
    below[l] = last[l] < 0.0f || distance[l] < k_reached * r ? below[l] : k_far;
}

// Metres down to a collider, of each lane; k_far: it is not below.
void find_below(const Granular& g, const ColliderFrame& c, const HeldLanes& lanes, const float down[3],
                float below[k_lane_group]) {
  const auto& local = scratch_of(g).local;
  float direction[3];
  for (int a = 0; a < 3; ++a) direction[a] = c.axes[a][0] * down[0] + c.axes[a][1] * down[1] + c.axes[a][2] * down[2];
  to_local(g, c, lanes);
  if (c.shape == SANDGLASS_SHAPE_HALF_SPACE) {
    for (uint32_t l = 0; l < lanes.count; l += 4) {
      const Quad y = four(local[1], l), down_to = direction[1] < -1e-6f ? y / -direction[1] : Quad{} + k_far;
      four(below, l) = y <= 0.0f ? Quad{} : down_to;
    }
  } else if (c.shape == SANDGLASS_SHAPE_BOX) {
    const float low[3] = {-c.size[0], -c.size[1], -c.size[2]};
    enter_box(g, lanes.count, direction, low, c.size, below);
  } else if (c.shape == SANDGLASS_SHAPE_FIELD) {
    float high[3];
    for (int a = 0; a < 3; ++a) high[a] = c.field.low[a] + c.field.spacing * static_cast<float>(c.field.counts[a] - 1);
    enter_box(g, lanes.count, direction, c.field.low, high, below);
    trace_field(g, c, lanes, down, below);
  } else if (c.shape == SANDGLASS_SHAPE_RELIEF) {
    const float low[3] = {-c.size[0], -c.size[1], -c.size[2]};
    enter_box(g, lanes.count, direction, low, c.size, below);
    trace_field(g, c, lanes, down, below);
  } else if (c.shape == SANDGLASS_SHAPE_SPHERE) {
    enter_ball(c, lanes, down, below);
  } else {
    for (uint32_t l = 0; l < lanes.count; ++l) below[l] = capsule_below(c, lanes, l, down);
  }
}

// Metres down until a box meets another one; k_far: never.
float meets_below(const Bounds& box, const Bounds& here, const float down[3]) {
  float enter = 0.0f, leave = k_far;
  for (int k = 0; k < 3; ++k) {
    const float low = box.low[k] - here.high[k], high = box.high[k] - here.low[k];
    if (__builtin_fabsf(down[k]) < 1e-6f) {
      leave = low > 0.0f || high < 0.0f ? -1.0f : leave;
      continue;
    }
    const float a = low / down[k], b = high / down[k];
    enter = (a < b ? a : b) > enter ? (a < b ? a : b) : enter;
    leave = (a < b ? b : a) < leave ? (a < b ? b : a) : leave;
  }
  return enter <= leave ? enter : k_far;
}

// Whether the velocity is near to one between rest and the collider's: not that of sand that falls onto it.
bool goes_along(const HeldLanes& lanes, uint32_t l, const ColliderFrame& c, float speed_max) {
  const float x[3] = {lanes.at[0][l], lanes.at[1][l], lanes.at[2][l]};
  const float* const velocity = lanes.velocities + l * k_record_floats;
  float v[3], length2 = 0.0f, with = 0.0f, squared = 0.0f;
  holding_velocity(c, x, v);
  for (int k = 0; k < 3; ++k) {
    length2 += v[k] * v[k];
    with += v[k] * velocity[k];
  }
  float share = length2 > 0.0f ? with / length2 : 0.0f;
  share = share > 0.0f ? (share < 1.0f ? share : 1.0f) : 0.0f;
  for (int k = 0; k < 3; ++k) {
    const float difference = velocity[k] - share * v[k];
    squared += difference * difference;
  }
  return squared <= speed_max * speed_max;
}

// Bits of the lanes that are within the box of a collider's group.
uint32_t within_group(const Granular& g, uint32_t collider, const HeldLanes& lanes) {
  const CarryGroup& group = g.carry.groups[g.carry.group_of[collider]];
  if (!group.hollow) return 0;
  const auto& local = scratch_of(g).local;
  to_local(g, g.colliders.carriers[group.first].from, lanes);
  uint32_t within = (1u << lanes.count) - 1;
  for (uint32_t l = 0; l < lanes.count; ++l)
    for (int k = 0; k < 3; ++k)
      within &= local[k][l] < group.box.low[k] || local[k][l] > group.box.high[k] ? ~(1u << l) : ~0u;
  return within;
}

// Whether the field encloses the whole box of the group.
bool field_holds_all(const Granular& g, const HeldGroup& group, const ColliderFrame& field) {
  auto& middle = scratch_of(g).traced;
  auto& distance = scratch_of(g).distance;
  float half2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const float low = group.box.low[k], high = group.box.high[k];
    half2 += 0.25f * (high - low) * (high - low);
    middle[k][0] = 0.5f * (low + high);
  }
  holding_measure(g, field, middle, distance, 1);
  return distance[0] - __builtin_sqrtf(half2) > -k_in_wall * g.desc.particle_radius;
}

// The collider of a vessel that holds the whole group, or k_no_holder: all corners of the group's box are in the
// vessel's box and above its colliders, and other colliders below are lower.
uint32_t vessel_that_holds_all(const Granular& g, const HeldGroup& group, uint32_t vessel) {
  HeldLanes& corners = scratch_of(g).corners;
  auto& found = scratch_of(g).found;
  corners.count = k_corners;
  for (int k = 0; k < 3; ++k)
    for (uint32_t l = 0; l < k_corners; ++l)
      corners.at[k][l] = (l >> k & 1) != 0 ? group.box.high[k] : group.box.low[k];
  if (within_group(g, vessel, corners) != k_all_corners) return k_no_holder;
  float below[k_corners], lowest = 0.0f;
  uint32_t holder = k_no_holder;
  for (float& b : below) b = k_far;
  for (uint32_t n = 0; n < group.count; ++n) {
    if (!holding_carries(g, group.near[n])) continue;
    find_below(g, g.colliders.carriers[group.near[n]].from, corners, group.down, found);
    if (found[0] < below[0]) holder = group.near[n];
    for (uint32_t l = 0; l < k_corners; ++l) below[l] = found[l] < below[l] ? found[l] : below[l];
  }
  for (const float b : below) lowest = b > lowest ? b : lowest;
  if (lowest >= k_far) return k_no_holder;
  for (uint32_t n = 0; n < group.count; ++n) {
    const uint32_t i = group.near[n];
    if (holding_carries(g, i)) continue;
    const ColliderFrame& c = g.colliders.carriers[i].from;
    if (c.shape != SANDGLASS_SHAPE_HALF_SPACE) {
      if (meets_below(g.carry.reaches[i], group.box, group.down) <= lowest) return k_no_holder;
      continue;
    }
    find_below(g, c, corners, group.down, found);
    for (uint32_t l = 0; l < k_corners; ++l)
      if (found[l] <= lowest) return k_no_holder;
  }
  return holder;
}

}  // namespace

bool holding_encloses(const ColliderFrame& c) { return c.shape == SANDGLASS_SHAPE_FIELD && c.field.outward < 0.0f; }

bool holding_carries(const Granular& g, uint32_t i) { return g.carry.group_of[i] != k_carry_groups; }

Bounds holding_box(const ColliderFrame& c) {
  Bounds box = {{-k_far, -k_far, -k_far}, {k_far, k_far, k_far}};
  if (c.shape == SANDGLASS_SHAPE_HALF_SPACE) return box;
  for (int k = 0; k < 3; ++k) {
    float middle = c.position[k], half = c.shape == SANDGLASS_SHAPE_FIELD ? 0.0f : c.extent[k];
    for (int a = 0; a < 3 && c.shape == SANDGLASS_SHAPE_FIELD; ++a) {
      const float side = 0.5f * c.field.spacing * static_cast<float>(c.field.counts[a] - 1);
      middle += (c.field.low[a] + side) * c.axes[a][k];
      half += side * __builtin_fabsf(c.axes[a][k]);
    }
    box.low[k] = middle - half;
    box.high[k] = middle + half;
  }
  return box;
}

void holding_join(Bounds* box, const ColliderFrame& first, const ColliderFrame& c) {
  float low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    const float half = c.shape == SANDGLASS_SHAPE_BOX                 ? c.size[a]
                       : c.shape == SANDGLASS_SHAPE_CAPSULE && a == 1 ? c.size[0] + c.size[1]
                                                                      : c.size[0];
    const bool field = c.shape == SANDGLASS_SHAPE_FIELD;
    low[a] = field ? c.field.low[a] : -half;
    high[a] = field ? c.field.low[a] + c.field.spacing * static_cast<float>(c.field.counts[a] - 1) : half;
  }
  for (uint32_t corner = 0; corner < k_corners; ++corner) {
    float difference[3], local[3] = {};
    for (int k = 0; k < 3; ++k) {
      difference[k] = c.position[k] - first.position[k];
      for (int a = 0; a < 3; ++a) difference[k] += ((corner >> a & 1) != 0 ? high[a] : low[a]) * c.axes[a][k];
    }
    for (int a = 0; a < 3; ++a)
      for (int k = 0; k < 3; ++k) local[a] += first.axes[a][k] * difference[k];
    bounds_include(box, local);
  }
}

bool holding_overlaps(const Bounds& a, const Bounds& b, float margin) {
  bool meet = true;
  for (int k = 0; k < 3; ++k) meet = meet && a.low[k] - margin <= b.high[k] && b.low[k] - margin <= a.high[k];
  return meet;
}

void holding_velocity(const ColliderFrame& c, const float at[3], float v[3]) {
  const float r[3] = {at[0] - c.position[0], at[1] - c.position[1], at[2] - c.position[2]}, *w = c.angular;
  v[0] = c.linear[0] + (w[1] * r[2] - w[2] * r[1]);
  v[1] = c.linear[1] + (w[2] * r[0] - w[0] * r[2]);
  v[2] = c.linear[2] + (w[0] * r[1] - w[1] * r[0]);
}

void holding_measure_points(const Granular& g, const ColliderFrame& c, uint32_t count) {
  const SurfaceArgs args = {scratch_of(g).points, &c};
  uint32_t unused = 0;
  g.kernels->surface_at(&args, 0, count, &unused);
}

void holding_measure(const Granular& g, const ColliderFrame& c, const float at[3][k_lane_group],
                     float distance[k_lane_group], uint32_t count) {
  SurfacePoint* const points = scratch_of(g).points;
  for (uint32_t l = 0; l < count; ++l)
    for (int k = 0; k < 3; ++k) points[l].position[k] = at[k][l];
  holding_measure_points(g, c, count);
  for (uint32_t l = 0; l < count; ++l) distance[l] = points[l].distance;
}

float holding_distance(const Granular& g, const ColliderFrame& c, const Quad& at, Quad* normal) {
  if (c.shape == SANDGLASS_SHAPE_HALF_SPACE) {
    *normal = quad(c.axes[1]);
    return dot(*normal, at - quad(c.position));
  }
  SurfacePoint& point = scratch_of(g).points[0];
  for (int k = 0; k < 3; ++k) point.position[k] = at[k];
  holding_measure_points(g, c, 1);
  *normal = quad(point.normal);
  return point.distance;
}

const ColliderFrame& holding_posed(const Granular& g, const Carrier& carrier, float share) {
  if (!carrier.moves) return carrier.to;
  return scratch_of(g).posed = collider_between(rigid_pose(carrier.from), carrier.to, share < 1.0f ? share : 1.0f);
}

void holding_read(const Record* records, uint32_t count, uint32_t which, HeldLanes* lanes) {
  const uint32_t instead = static_cast<uint32_t>(__builtin_ctz(which));
  lanes->count = count;
  lanes->velocities = reinterpret_cast<const float*>(records) + k_vx;
  for (uint32_t l = 0; l < k_lane_group; l += 4) {
    Quad at[4];
    for (uint32_t i = 0; i < 4; ++i)
      __builtin_memcpy(&at[i], records + ((which >> (l + i) & 1) != 0 ? l + i : instead), sizeof *at);
    for (int k = 0; k < 3; ++k) four(lanes->at[k], l) = Quad{at[0][k], at[1][k], at[2][k], at[3][k]};
  }
}

void holding_find_near(const Granular& g, HeldGroup* group) {
  for (int k = 0; k < 3; ++k) group->down[k] = g.gravity_length > 0.0f ? g.gravity[k] / g.gravity_length : 0.0f;
  group->count = 0;
  group->some = false;
  for (uint32_t i = 0; i < g.colliders.solid_count && group->count < k_holders_near; ++i) {
    if (meets_below(g.carry.reaches[i], group->box, group->down) >= k_far) continue;
    group->near[group->count++] = i;
    group->some = group->some || holding_carries(g, i);
  }
}

uint32_t holding_sole(const Granular& g, const HeldGroup& group) {
  uint32_t field = k_no_holder, vessel = k_no_holder;
  for (uint32_t n = 0; n < group.count; ++n) {
    const uint32_t i = group.near[n];
    const ColliderFrame& c = g.colliders.carriers[i].from;
    if (!holding_encloses(c) && !holding_carries(g, i)) continue;
    if (holding_encloses(c) && field == k_no_holder) {
      field = i;
      continue;
    }
    const bool another = vessel != k_no_holder && g.carry.group_of[i] != g.carry.group_of[vessel];
    if (another || c.shape == SANDGLASS_SHAPE_FIELD) return k_no_holder;
    vessel = i;
  }
  if ((field == k_no_holder) == (vessel == k_no_holder)) return k_no_holder;
  if (vessel != k_no_holder) return vessel_that_holds_all(g, group, vessel);
  const bool holds = holding_carries(g, field) && field_holds_all(g, group, g.colliders.carriers[field].from);
  return holds ? field : k_no_holder;
}

// Where `found` is nearer: it, and who it is.
static void take_nearer(const float found[k_lane_group], uint32_t who, float nearest[k_lane_group],
                        uint32_t whose[k_lane_group]) {
  typedef uint32_t Words __attribute__((vector_size(16), may_alias));
  for (uint32_t l = 0; l < k_lane_group; l += 4) {
    Words& of = *reinterpret_cast<Words*>(whose + l);
    const auto nearer = four(found, l) < four(nearest, l);
    of = nearer ? Words{} + who : of;
    four(nearest, l) = nearer ? four(found, l) : four(nearest, l);
  }
}

bool holding_find(const Granular& g, const HeldGroup& group, const HeldLanes& lanes, uint32_t holder[k_lane_group]) {
  const float r = g.desc.particle_radius;
  HeldScratch& scratch = scratch_of(g);
  auto &nearest = scratch.nearest, &below = scratch.below, &found = scratch.found;
  auto &support = scratch.support, &enclosing = scratch.enclosing;
  for (uint32_t l = 0; l < k_lane_group; ++l) {
    holder[l] = support[l] = enclosing[l] = k_no_holder;
    nearest[l] = below[l] = k_far;
  }
  bool any = false;
  for (uint32_t n = 0; n < group.count && group.some; ++n) {
    const uint32_t i = group.near[n];
    const ColliderFrame& c = g.colliders.carriers[i].from;
    if (holding_encloses(c)) {
      holding_measure(g, c, lanes.at, found);
      for (uint32_t l = 0; l < k_lane_group; ++l) found[l] = found[l] > -k_in_wall * r ? found[l] : k_far;
      take_nearer(found, i, nearest, enclosing);
    } else if (g.gravity_length > 0.0f) {
      find_below(g, c, lanes, group.down, found);
      take_nearer(found, i, below, support);
    }
  }
  uint32_t asked = k_no_holder, within = 0;
  for (uint32_t l = 0; l < lanes.count; ++l) {
    const uint32_t on = support[l], in = enclosing[l];
    if (in != k_no_holder && holding_carries(g, in)) holder[l] = in;
    if (on != k_no_holder && holding_carries(g, on)) {
      if (on != asked) within = within_group(g, on, lanes);
      asked = on;
      const bool inside = (within >> l & 1) != 0;
      const bool lies = !inside && below[l] > 0.0f && g.carry.due != Carry::Moment::jump &&
                        goes_along(lanes, l, g.colliders.carriers[on].from, granular_speed_scale(g));
      // Of a vessel within a field, or a field within a vessel, the nearer one is the inner one.
      if (lies || (inside && (holder[l] == k_no_holder || below[l] < nearest[l] + 2.0f * r))) holder[l] = on;
    }
    any = any || holder[l] != k_no_holder;
  }
  return any;
}

}  // namespace sandglass
