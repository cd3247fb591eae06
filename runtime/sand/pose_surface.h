// Poses, and distances between the surfaces of a shape at two poses, where sand is. For held poses alone.
#pragma once

#include "runtime/math/rotation.h"
#include "runtime/sand/held_pose.h"

namespace sandglass {

inline float dot(const float a[3], const FloatVector& b) { return a[0] * b.x + a[1] * b.y + a[2] * b.z; }
inline float dot3(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline float length3(const float v[3]) { return __builtin_sqrtf(dot3(v, v)); }
inline float minimum(float a, float b) { return a < b ? a : b; }
inline float maximum(float a, float b) { return a > b ? a : b; }

// The largest difference of a size.
float grown(const Pose& from, const Pose& to);
// The largest distance of a point of the shape from its position; of a half-space, of sand.
float reach_of(sandglass_shape shape, const Pose& pose, const HoldRule& rule);
// The box of the sand that is near a shape; all of the shape's own box where none is.
void near_box(sandglass_shape shape, const Pose& pose, const HoldRule& rule, float low[3], float high[3]);

// The face of a box along its axis `axis`, up or down it: n . x = offset.
struct Face {
  FloatVector n;
  float offset;
};
Face face_of(const Pose& pose, int axis, float side);
// Whether sand may be in front of a face of both boxes. A table's edges are not where its pile lies.
bool sand_beyond(const Face& from, const Face& to, const float low[3], const float high[3]);

// A share of the motion from one pose to another.
Pose between(const Pose& from, const Pose& to, float share);
// Shift and turn from one pose to another; the turn about the world's axes, as colliders_pose undoes it.
void motion_between(const Pose& from, const Pose& to, float shift[3], float turn[3]);
// A pose that has gone on at a velocity for some seconds.
Pose advanced(const Pose& from, const float linear[3], const float angular[3], float seconds);
// A pose, moved as little as possible so that its face along a local axis lies where `face` does.
Pose laid(const Pose& pose, int axis, float side, const Face& face);

}  // namespace sandglass
