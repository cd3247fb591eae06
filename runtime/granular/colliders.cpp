// Rotations by angular velocity use the first-order quaternion step, renormalised. So there is no sine or cosine in a
// hashed path. The error is angle^3 / 12: 7e-4 rad for a turn of 0.2 rad within one frame.
#include "runtime/granular/colliders.h"

#include "runtime/core/finite.h"
#include "runtime/granular/field.h"
#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

constexpr float k_collider_speed = 1e4f;   // metres or radians a second, along each axis
constexpr double k_way_resolution = 1e-6;  // metres or radians; what is shorter counts as none

bool normalise(float q[4]) {
  const float length2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!(length2 > 1e-12f && length2 < 1e12f)) return false;
  const float inverse = 1.0f / __builtin_sqrtf(length2);
  for (int i = 0; i < 4; ++i) q[i] *= inverse;
  return true;
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

// About half of what a point of the collider can have travelled between two poses: half the shift, and half the arc of
// a point as far from the centre as the sizes reach. A half-space has no size, so its turning does not count.
float half_travel(const sandglass_collider& a, const sandglass_collider& b) {
  float shift2 = 0.0f, turn2 = 0.0f, extent2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    shift2 += (b.position[k] - a.position[k]) * (b.position[k] - a.position[k]);
    extent2 += b.size[k] * b.size[k];
  }
  for (int k = 0; k < 4; ++k) turn2 += (b.rotation[k] - a.rotation[k]) * (b.rotation[k] - a.rotation[k]);
  return 0.5f * __builtin_sqrtf(shift2) + __builtin_sqrtf(turn2 * extent2);
}

// Whether `now` continues `before`, which was a frame of `step` seconds ago: it has not jumped.
bool continues(const sandglass_collider& before, const sandglass_collider& now, double step, float margin) {
  if (before.shape != now.shape || before.field != now.field) return false;
  float way2 = 0.0f, speed2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    if (before.size[k] != now.size[k]) return false;
    const float way = now.position[k] - before.position[k];
    const float a = __builtin_fabsf(before.linear_velocity[k]), b = __builtin_fabsf(now.linear_velocity[k]);
    way2 += way * way, speed2 += (a + b) * (a + b);
  }
  return __builtin_sqrtf(way2) <= static_cast<float>(step) * __builtin_sqrtf(speed2) + margin;
}

// The velocity at which a collider goes what is left of its way and this frame's, in the simulated time that is left.
float spread(float left, double owed, float now, double step, double debt) {
  const double way = static_cast<double>(left) * owed + static_cast<double>(now) * step;
  if (now == 0.0f && way < k_way_resolution && way > -k_way_resolution) return 0.0f;
  const double velocity = way / debt, most = static_cast<double>(k_collider_speed);
  return static_cast<float>(velocity < most ? (velocity > -most ? velocity : -most) : most);
}

}  // namespace

void colliders_layout(Colliders* c, const sandglass_granular_desc& d, Layout* layout) {
  const uint64_t capacity = d.collider_capacity;
  c->given = layout_region<sandglass_collider>(layout, "granular.colliders", capacity);
  c->substep_frames = layout_region<ColliderFrame>(layout, "granular.substep_colliders", capacity);
  c->sweep_frames = layout_region<ColliderFrame>(layout, "granular.sweep_colliders", capacity);
  c->solid.before = layout_region<sandglass_collider>(layout, "granular.colliders_before", capacity);
  c->all.before = layout_region<sandglass_collider>(layout, "granular.sweep_colliders_before", capacity);
  c->solid.moved.frames = layout_region<ColliderFrame>(layout, "granular.moved_colliders", 2 * capacity);
  c->solid.moved.margins = layout_region<float>(layout, "granular.moved_margins", 2 * capacity);
  c->all.moved.frames = layout_region<ColliderFrame>(layout, "granular.sweep_moved", 2 * capacity);
  c->all.moved.margins = layout_region<float>(layout, "granular.sweep_moved_margins", 2 * capacity);
}

void colliders_reset(Colliders* c) {
  c->count = c->solid_count = c->substep_count = c->sweep_count = 0;
  c->solid.before_count = c->solid.moved.count = 0;
  c->all.before_count = 0;
  c->adopts = false;
}

void colliders_take(Granular* g, const sandglass_frame_input& input, double owed) {
  Colliders& c = g->colliders;
  const uint32_t before_count = c.adopts || owed < k_time_resolution ? 0 : c.count;
  const double step = static_cast<double>(g->time.frame_step), debt = g->time.debt;
  c.count = 0;
  for (int pass = 0; pass < 2; ++pass) {
    const bool grains_only = pass == 1;
    for (uint32_t i = 0; i < input.collider_count; ++i) {
      if ((input.colliders[i].grains_only != 0) != grains_only) continue;
      sandglass_collider now;
      if (c.count == g->desc.collider_capacity || !collider_accept(input.colliders[i], &now)) {
        ++g->counts.ignored_colliders;
        continue;
      }
      sandglass_collider* given = &c.given[c.count];
      if (c.count < before_count && debt >= k_time_resolution &&
          continues(*given, now, step, g->desc.particle_radius)) {
        for (int k = 0; k < 3; ++k) {
          now.linear_velocity[k] = spread(given->linear_velocity[k], owed, now.linear_velocity[k], step, debt);
          now.angular_velocity[k] = spread(given->angular_velocity[k], owed, now.angular_velocity[k], step, debt);
        }
      }
      *given = now, ++c.count;
    }
    if (!grains_only) c.solid_count = c.count;
  }
}

void colliders_find_moved(Granular* g) {
  Colliders& c = g->colliders;
  c.solid.moved.count = 0;
  if (c.adopts) {
    watch_remember(&c.solid, c.given, c.solid_count);
    watch_remember(&c.all, c.given, c.count);
    c.adopts = false;
  }
  if (g->sleep.awake_count < g->particles.count)
    watch_find_moved(&c.solid, c.given, c.solid_count, neighbours_reach(*g));
  const bool touch = c.solid.moved.count != 0;
  substep_set_due(g, SubstepPhase::touch, touch);
  if (!touch) watch_remember(&c.solid, c.given, c.solid_count);
}

void watch_remember(ColliderWatch* watch, const sandglass_collider* now, uint32_t count) {
  watch->before_count = count;
  for (uint32_t c = 0; c < count; ++c) watch->before[c] = now[c];
}

void watch_find_moved(ColliderWatch* watch, const sandglass_collider* now, uint32_t count, float margin) {
  const sandglass_collider* before = watch->before;
  MovedColliders& moved = watch->moved;
  moved.count = 0;
  for (uint32_t c = 0; c < count || c < watch->before_count; ++c) {
    const bool is = c < count, was = c < watch->before_count;
    if (is && was && same(before[c], now[c])) continue;
    const float reach = margin + (is && was ? half_travel(before[c], now[c]) : 0.0f);
    if (is) colliders_pose(&now[c], 1, 0.0f, &moved.frames[moved.count]), moved.margins[moved.count++] = reach;
    if (was) colliders_pose(&before[c], 1, 0.0f, &moved.frames[moved.count]), moved.margins[moved.count++] = reach;
  }
}

bool watch_changed(const ColliderWatch& watch, const sandglass_collider* now, uint32_t count) {
  bool changed = count != watch.before_count;
  for (uint32_t c = 0; !changed && c < count; ++c) changed = !same(watch.before[c], now[c]);
  return changed;
}

bool collider_accept(const sandglass_collider& collider, sandglass_collider* accepted) {
  if (collider.shape < SANDGLASS_SHAPE_HALF_SPACE || collider.shape > SANDGLASS_SHAPE_FIELD) return false;
  if (!all_finite(collider.position, 3) || !all_finite(collider.rotation, 4) ||
      !all_finite(collider.linear_velocity, 3) || !all_finite(collider.angular_velocity, 3)) {
    return false;
  }
  for (int k = 0; k < 3; ++k) {
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
  if (field) {  // as far as its points are from its origin: turning moves them by that
    float low[3], high[3];
    sandglass_field_bounds(collider.field, low, high);
    for (int k = 0; k < 3; ++k) accepted->size[k] = high[k] > -low[k] ? high[k] : -low[k];
  }
  return normalise(accepted->rotation);
}

void colliders_pose(const sandglass_collider* colliders, uint32_t count, float before, ColliderFrame* frames) {
  for (uint32_t c = 0; c < count; ++c) {
    const sandglass_collider& collider = colliders[c];
    ColliderFrame& frame = frames[c];
    frame.shape = collider.shape;
    if (collider.shape == SANDGLASS_SHAPE_FIELD) frame.field = collider.field->grid;
    const float* q = collider.rotation;
    const float* w = collider.angular_velocity;
    const float h = -0.5f * before;
    float r[4] = {
        q[0] + h * (w[0] * q[3] + w[1] * q[2] - w[2] * q[1]), q[1] + h * (w[1] * q[3] + w[2] * q[0] - w[0] * q[2]),
        q[2] + h * (w[2] * q[3] + w[0] * q[1] - w[1] * q[0]), q[3] - h * (w[0] * q[0] + w[1] * q[1] + w[2] * q[2])};
    normalise(r);
    const float x = r[0], y = r[1], z = r[2], s = r[3];
    const float axes[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + z * s), 2 * (x * z - y * s)},
                              {2 * (x * y - z * s), 1 - 2 * (x * x + z * z), 2 * (y * z + x * s)},
                              {2 * (x * z + y * s), 2 * (y * z - x * s), 1 - 2 * (x * x + y * y)}};
    for (int k = 0; k < 3; ++k) {
      frame.position[k] = collider.position[k] - before * collider.linear_velocity[k];
      frame.size[k] = collider.size[k];
      frame.linear[k] = collider.linear_velocity[k];
      frame.angular[k] = collider.angular_velocity[k];
      for (int j = 0; j < 3; ++j) frame.axes[k][j] = axes[k][j];
    }
    find_extent(&frame);
  }
}

}  // namespace sandglass
