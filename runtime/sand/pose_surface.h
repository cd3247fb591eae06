// Poses, and how far the surfaces of shapes at them are apart where sand is. For held poses alone.
#pragma once

#include "runtime/math/rotation.h"
#include "runtime/sand/held_pose.h"

namespace sandglass {

inline float dot(const float a[3], const FloatVector& b) { return a[0] * b.x + a[1] * b.y + a[2] * b.z; }
inline float dot3(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline float length3(const float v[3]) { return __builtin_sqrtf(dot3(v, v)); }
inline float minimum(float a, float b) { return a < b ? a : b; }
inline float maximum(float a, float b) { return a > b ? a : b; }

// By how much the sizes differ at most.
float grown(const Pose& from, const Pose& to);
// As far as points of the shape are from its position; of a half-space, as far as sand is.
float reach_of(sandglass_shape shape, const Pose& pose, const HoldRule& rule);
// The box of the sand that is near a shape; all of the shape's own box where none is.
void near_box(sandglass_shape shape, const Pose& pose, const HoldRule& rule, float low[3], float high[3]);

// The face of a box along its axis `axis`, up or down it: n . x = offset.
struct Face {
  FloatVector n;
  float offset;
};
Face face_of(const Pose& pose, int axis, float side);
// Whether sand may be in front of a face of both boxes. A table's edges are not where its heap lies.
bool sand_beyond(const Face& from, const Face& to, const float low[3], const float high[3]);

// A share of the motion from one pose to another.
Pose between(const Pose& from, const Pose& to, float share);
// Shift and turn from one pose to another; the turn about the world's axes, as colliders_pose undoes it.
void motion_between(const Pose& from, const Pose& to, float shift[3], float turn[3]);
// Where a pose is when it has gone on at a velocity.
Pose advanced(const Pose& from, const float linear[3], const float angular[3], float seconds);
// A pose, moved as little as makes its face along a local axis lie where `face` does.
Pose laid(const Pose& pose, int axis, float side, const Face& face);

}  // namespace sandglass
