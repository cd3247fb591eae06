// A collider's placement as held poses have it, and where it was a moment ago. For the files of colliders alone.
#pragma once

#include <cstddef>

#include "runtime/sand/granular.h"

namespace sandglass {

constexpr float k_collider_speed = 1e4f;  // metres or radians a second, along each axis

// A collider holds its placement as the library does: in one piece, in the same order.
constexpr size_t k_placement_at = offsetof(sandglass_collider, position);
static_assert(offsetof(sandglass_collider, size) - k_placement_at == offsetof(Pose, size) &&
              offsetof(sandglass_collider, grains_only) - k_placement_at == sizeof(Placement));

inline Placement placement_of(const sandglass_collider& c) {
  Placement p;
  __builtin_memcpy(&p, reinterpret_cast<const uint8_t*>(&c) + k_placement_at, sizeof p);
  return p;
}

inline Pose pose_of(const sandglass_collider& c) { return placement_of(c).pose; }

inline void place(sandglass_collider* c, const Placement& p) {
  __builtin_memcpy(reinterpret_cast<uint8_t*>(c) + k_placement_at, &p, sizeof p);
}

// The pose `before` seconds before the placement.
Pose pose_before(const Placement& at, const float slide[6], float before);
// The greatest speed of a point of it, m/s; of a half-space, of a point one metre away.
float fastness(const sandglass_collider& collider);
HoldRule hold_rule(const Granular& granular);
// The app may free a field that it does not pass any more, while a step that meets it is under way. A ball of no size,
// far from everything, takes its place.
void colliders_drop_gone_fields(Colliders* colliders);

inline float length_of(const float v[3]) { return __builtin_sqrtf(square_of(quad(v))); }

}  // namespace sandglass
