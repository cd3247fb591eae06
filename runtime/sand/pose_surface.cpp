#include "runtime/sand/pose_surface.h"

namespace sandglass {
namespace {

template <class Visit>
void for_corners(const float low[3], const float high[3], const Visit& visit) {
  for (int corner = 0; corner < 8; ++corner) {
    const float at[3] = {(corner & 1) != 0 ? high[0] : low[0], (corner & 2) != 0 ? high[1] : low[1],
                         (corner & 4) != 0 ? high[2] : low[2]};
    visit(at);
  }
}

float face_distance(const Face& from, const Face& to, const float low[3], const float high[3]) {
  float largest = 0.0f;
  for_corners(low, high, [&](const float at[3]) {
    largest = maximum(largest, __builtin_fabsf((dot(at, to.n) - to.offset) - (dot(at, from.n) - from.offset)));
  });
  return largest;
}

// The same for a box that grows: of faces that sand is in front of alone.
float faces_distance(const Pose& from, const Pose& to, const float low[3], const float high[3]) {
  float largest = 0.0f;
  for (int side = 0; side < 6; ++side) {
    const Face a = face_of(from, side / 2, side % 2 != 0 ? 1.0f : -1.0f);
    const Face b = face_of(to, side / 2, side % 2 != 0 ? 1.0f : -1.0f);
    if (sand_beyond(a, b, low, high)) largest = maximum(largest, face_distance(a, b, low, high));
  }
  return largest;
}

}  // namespace

float grown(const Pose& from, const Pose& to) {
  float largest = 0.0f;
  for (int k = 0; k < 3; ++k) largest = maximum(largest, __builtin_fabsf(to.size[k] - from.size[k]));
  return largest;
}

float reach_of(sandglass_shape shape, const Pose& pose, const HoldRule& rule) {
  if (shape == SANDGLASS_SHAPE_SPHERE) return pose.size[0];
  if (shape == SANDGLASS_SHAPE_CAPSULE) return pose.size[0] + pose.size[1];
  if (shape != SANDGLASS_SHAPE_HALF_SPACE) return length3(pose.size);
  float far[3];
  for (int k = 0; k < 3; ++k)
    far[k] = maximum(__builtin_fabsf(rule.low[k] - pose.position[k]), __builtin_fabsf(rule.high[k] - pose.position[k]));
  return length3(far);
}

void near_box(sandglass_shape shape, const Pose& pose, const HoldRule& rule, float low[3], float high[3]) {
  const float reach = reach_of(shape, pose, rule);
  bool disjoint = false;
  for (int k = 0; k < 3; ++k) {
    low[k] = maximum(rule.low[k], pose.position[k] - reach);
    high[k] = minimum(rule.high[k], pose.position[k] + reach);
    disjoint = disjoint || low[k] > high[k];
  }
  for (int k = 0; disjoint && k < 3; ++k) low[k] = pose.position[k] - reach;
  for (int k = 0; disjoint && k < 3; ++k) high[k] = pose.position[k] + reach;
}

Face face_of(const Pose& pose, int axis, float side) {
  const FloatVector n =
      rotated(pose.rotation, {axis == 0 ? side : 0.0f, axis == 1 ? side : 0.0f, axis == 2 ? side : 0.0f});
  return {n, dot(pose.position, n) + pose.size[axis]};
}

bool sand_beyond(const Face& from, const Face& to, const float low[3], const float high[3]) {
  bool beyond = false;
  for_corners(low, high, [&](const float at[3]) {
    beyond = beyond || dot(at, from.n) > from.offset || dot(at, to.n) > to.offset;
  });
  return beyond;
}

Pose between(const Pose& from, const Pose& to, float share) {
  Pose p;
  float length2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    p.position[k] = from.position[k] + share * (to.position[k] - from.position[k]);
    p.size[k] = from.size[k] + share * (to.size[k] - from.size[k]);
  }
  for (int k = 0; k < 4; ++k) {
    p.rotation[k] = from.rotation[k] + share * (to.rotation[k] - from.rotation[k]);
    length2 += p.rotation[k] * p.rotation[k];
  }
  const float inverse = 1.0f / __builtin_sqrtf(length2);  // both have length 1 and are no more than 90 degrees apart
  for (float& c : p.rotation) c *= inverse;
  return p;
}

void motion_between(const Pose& from, const Pose& to, float shift[3], float turn[3]) {
  const float *a = from.rotation, *b = to.rotation;
  const FloatVector v = cross(FloatVector{b[0], b[1], b[2]}, {a[0], a[1], a[2]});
  const float w[3] = {v.x, v.y, v.z};
  const float with = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];  // cosine of half the angle
  const float half = with < 0.0f ? minimum(with, -0.1f) : maximum(with, 0.1f);
  for (int k = 0; k < 3; ++k) {
    shift[k] = to.position[k] - from.position[k];
    turn[k] = 2.0f * (b[k] * a[3] - a[k] * b[3] - w[k]) / half;
  }
}

Pose advanced(const Pose& from, const float linear[3], const float angular[3], float seconds) {
  Pose p = from;
  for (int k = 0; k < 3; ++k) p.position[k] += seconds * linear[k];
  const float h = 0.5f * seconds, w[4] = {h * angular[0], h * angular[1], h * angular[2], 1.0f};
  multiply(w, from.rotation, p.rotation);
  return between(p, p, 0.0f);
}

Pose laid(const Pose& pose, int axis, float side, const Face& face) {
  Pose p = pose;
  const FloatVector m = face_of(pose, axis, side).n, n = face.n, v = cross(m, n);
  const float turn[4] = {v.x, v.y, v.z, 1.0f + m.x * n.x + m.y * n.y + m.z * n.z};
  if (turn[3] < 0.1f) return p;  // turned over
  multiply(turn, pose.rotation, p.rotation);
  p = between(p, p, 0.0f);
  const float off = face.offset - dot(p.position, n) - p.size[axis];
  p.position[0] += off * n.x;
  p.position[1] += off * n.y;
  p.position[2] += off * n.z;
  return p;
}

bool same_pose(const Pose& a, const Pose& b) {
  bool same = true;
  if (__builtin_memcmp(&a, &b, sizeof a) == 0) return true;  // most are; neither holds a NaN
  for (int k = 0; k < 3; ++k) same = same && a.position[k] == b.position[k] && a.size[k] == b.size[k];
  for (int k = 0; k < 4; ++k) same = same && a.rotation[k] == b.rotation[k];
  return same;
}

bool same_turn(const float a[4], const float b[4]) {
  if (__builtin_memcmp(a, b, 4 * sizeof *a) == 0) return true;
  const float with = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3], noise = 1e-10f;  // an angle of 3e-5 rad
  float squared = 0.0f;
  for (int k = 0; k < 4; ++k) {
    const float d = a[k] - (with < 0.0f ? -b[k] : b[k]);
    squared += d * d;
  }
  return squared <= noise;
}

float surface_distance(sandglass_shape shape, const Pose& from, const Pose& to, const HoldRule& rule) {
  if (same_pose(from, to)) return 0.0f;
  float low[3], high[3], largest = 0.0f;
  near_box(shape, from, rule, low, high);
  if (shape == SANDGLASS_SHAPE_HALF_SPACE) {
    const FloatVector a = rotated(from.rotation, {0, 1, 0}), b = rotated(to.rotation, {0, 1, 0});
    return face_distance({a, dot(from.position, a)}, {b, dot(to.position, b)}, rule.low, rule.high);
  }
  if (shape == SANDGLASS_SHAPE_BOX && grown(from, to) > rule.band) return faces_distance(from, to, low, high);
  if (shape == SANDGLASS_SHAPE_SPHERE) {  // however it turns
    const float shift[3] = {to.position[0] - from.position[0], to.position[1] - from.position[1],
                            to.position[2] - from.position[2]};
    return length3(shift) + grown(from, to);
  }
  const float back[4] = {-from.rotation[0], -from.rotation[1], -from.rotation[2], from.rotation[3]};
  for_corners(low, high, [&](const float at[3]) {
    const FloatVector r = {at[0] - from.position[0], at[1] - from.position[1], at[2] - from.position[2]};
    const FloatVector turned = rotated(to.rotation, rotated(back, r));
    const float displacement[3] = {turned.x - r.x + (to.position[0] - from.position[0]),
                                   turned.y - r.y + (to.position[1] - from.position[1]),
                                   turned.z - r.z + (to.position[2] - from.position[2])};
    largest = maximum(largest, length3(displacement));
  });
  return maximum(largest, grown(from, to));
}

void pose_move(Pose* p, const float rotation[4], const float shift[3]) {
  const FloatVector at = rotated(rotation, {p->position[0], p->position[1], p->position[2]});
  float turned[4];
  multiply(rotation, p->rotation, turned);
  const float moved[3] = {at.x + shift[0], at.y + shift[1], at.z + shift[2]};
  for (int k = 0; k < 3; ++k) p->position[k] = moved[k];
  // Rounding must not add up over a million moves.
  const float length2 = turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2] + turned[3] * turned[3];
  const float scale =
      length2 > 0.5f && __builtin_fabsf(length2 - 1.0f) > 1e-6f ? 1.0f / __builtin_sqrtf(length2) : 1.0f;
  for (int k = 0; k < 4; ++k) p->rotation[k] = scale * turned[k];
}

float box_surface_distance(const Pose& from, const Pose& to, const HoldRule& rule) {
  float low[3], high[3];
  near_box(SANDGLASS_SHAPE_BOX, from, rule, low, high);
  return faces_distance(from, to, low, high);
}

}  // namespace sandglass
