// Vectors and rotations in double, for cameras, metrics and placing bodies. Only + - * / and sqrt are used, so bodies
// are placed to the same bits on every machine. Rotations are unit quaternions (x, y, z, w), as in the public API.
#pragma once

#include <array>
#include <cmath>

namespace sandglass::host {

struct Vec3 {
  double x = 0.0, y = 0.0, z = 0.0;
};

constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3 operator*(Vec3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
constexpr double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double length(Vec3 a) { return std::sqrt(dot(a, a)); }
inline Vec3 normalised(Vec3 a) { return a * (1.0 / length(a)); }

// Converts from and to the three floats of the public API.
inline Vec3 from_floats(const float* v) { return {v[0], v[1], v[2]}; }
inline void to_floats(Vec3 v, float* out) {
  out[0] = static_cast<float>(v.x);
  out[1] = static_cast<float>(v.y);
  out[2] = static_cast<float>(v.z);
}

using Quaternion = std::array<double, 4>;
constexpr Quaternion k_no_rotation = {0.0, 0.0, 0.0, 1.0};

constexpr Quaternion multiply(const Quaternion& a, const Quaternion& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
          a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

inline Quaternion normalised(const Quaternion& q) {
  const double scale = 1.0 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] * scale, q[1] * scale, q[2] * scale, q[3] * scale};
}

constexpr Vec3 rotate(const Quaternion& q, Vec3 v) {
  const Vec3 axis = {q[0], q[1], q[2]};
  const Vec3 t = cross(axis, v) * 2.0;
  return v + t * q[3] + cross(axis, t);
}

constexpr Quaternion conjugate(const Quaternion& q) { return {-q[0], -q[1], -q[2], q[3]}; }

// The rotation about the vector's direction by its length in radians. libm's sine is not used, because it differs
// between machines. Instead the Taylor series gives a turn that is 2^10 times smaller, and it is squared ten times. The
// error is below 1e-13 for turns up to 2 pi.
inline Quaternion rotation_by(Vec3 turn) {
  constexpr int k_doublings = 10;
  const Vec3 half = turn * (0.5 / (1 << k_doublings));
  const double a2 = dot(half, half);
  const double sine_over_angle = 1.0 - a2 / 6.0 * (1.0 - a2 / 20.0 * (1.0 - a2 / 42.0));
  const double cosine = 1.0 - a2 / 2.0 * (1.0 - a2 / 12.0 * (1.0 - a2 / 30.0));
  Quaternion q = {half.x * sine_over_angle, half.y * sine_over_angle, half.z * sine_over_angle, cosine};
  for (int i = 0; i < k_doublings; ++i) q = normalised(multiply(q, q));
  return q;
}

}  // namespace sandglass::host
