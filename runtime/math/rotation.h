// Vectors, rotations by unit quaternions (x, y, z, w), and inertia. Rigid bodies take doubles.
#pragma once

namespace sandglass {

template <class Real>
struct VectorOf {
  Real x, y, z;
};
using Vector = VectorOf<double>;
using FloatVector = VectorOf<float>;

inline Vector to_vector(const float v[3]) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

template <class Real>
VectorOf<Real> cross(const VectorOf<Real>& a, const VectorOf<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// (R - 1) r for the rotation by q: exact to the last bits of small turns.
template <class Real>
VectorOf<Real> turned_by(const Real q[4], const VectorOf<Real>& r) {
  const VectorOf<Real> v = {q[0], q[1], q[2]}, t = cross(v, r);
  const VectorOf<Real> u = cross(v, {t.x + q[3] * r.x, t.y + q[3] * r.y, t.z + q[3] * r.z});
  return {Real{2} * u.x, Real{2} * u.y, Real{2} * u.z};
}

template <class Real>
VectorOf<Real> rotated(const Real q[4], const VectorOf<Real>& r) {
  const VectorOf<Real> t = turned_by(q, r);
  return {r.x + t.x, r.y + t.y, r.z + t.z};
}

// The w with (tr(S) - S) w = l, for the spread S = sum of r r^T. A straight body has no inertia about its own axis. A
// billionth more of the trace on the diagonal keeps the equation solvable, and no spin comes out about that axis,
// because none went in.
inline void angular_velocity(const double spread[9], const double l[3], double w[3]) {
  const double trace = spread[0] + spread[4] + spread[8];
  double m[9];
  for (int i = 0; i < 9; ++i) m[i] = -spread[i];
  for (int i = 0; i < 9; i += 4) m[i] += trace * (1.0 + 1e-9);
  const double c[3] = {m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6]};
  const double det = m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
  w[0] = w[1] = w[2] = 0.0;
  if (!(det > 1e-300)) return;  // a point
  const double inverse[9] = {c[0], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
                             c[1], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
                             c[2], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) w[i] += inverse[3 * i + j] * l[j] / det;
}

// The rotation by r and then by t.
template <class Real>
void multiply(const Real t[4], const Real r[4], Real q[4]) {
  q[0] = t[3] * r[0] + t[0] * r[3] + t[1] * r[2] - t[2] * r[1];
  q[1] = t[3] * r[1] + t[1] * r[3] + t[2] * r[0] - t[0] * r[2];
  q[2] = t[3] * r[2] + t[2] * r[3] + t[0] * r[1] - t[1] * r[0];
  q[3] = t[3] * r[3] - t[0] * r[0] - t[1] * r[1] - t[2] * r[2];
}

// The rotation nearest to a matrix, for shape matching (4.31).
//
// The proper rotation R that maximises tr(R^T A), as a unit quaternion (x, y, z, w). A is row-major; reflections, flat
// and straight bodies and half turns are allowed. Where several rotations are equally good, as for a straight body or a
// mirrored cube, it is the one nearest to `near`, a unit quaternion. It is `near` itself where an entry is not finite
// or beyond 1e300, and where all are below 1e-300.
void nearest_rotation(const double a[9], const double near[4], double q[4]);

}  // namespace sandglass
