// Rotations from the quaternions of apps and their sensors, in double. Any length above 0 is accepted.
#pragma once

#include "runtime/math/finite.h"
#include "runtime/math/math.h"

namespace sandglass {

struct Rotation {
  double m[3][3];  // rows
};

// q at length 1. False where q is zero, NaN or infinite.
inline bool unit_quaternion(const float q[4], double unit[4]) {
  double squared = 0.0;
  for (int i = 0; i < 4; ++i) {
    unit[i] = static_cast<double>(q[i]);
    squared += unit[i] * unit[i];
  }
  if (!(squared > 0.0) || !is_finite(squared)) return false;
  const double length = square_root(squared);
  for (int i = 0; i < 4; ++i) unit[i] /= length;
  return true;
}

inline bool rotation_of(const float q[4], Rotation* rotation) {
  double c[4];
  if (!unit_quaternion(q, c)) return false;
  const double x = c[0], y = c[1], z = c[2], w = c[3];
  *rotation = {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
  return true;
}

// Turns q further, by `second`. Leaves q alone where one of the two is no rotation. Both are brought to length 1 before
// they are multiplied, because the product of two long or two short ones may not fit a float.
inline void turn_further(const float second[4], float q[4]) {
  double a[4], b[4];
  if (!unit_quaternion(second, a) || !unit_quaternion(q, b)) return;
  q[0] = static_cast<float>(a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1]);
  q[1] = static_cast<float>(a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0]);
  q[2] = static_cast<float>(a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3]);
  q[3] = static_cast<float>(a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]);
}

inline void rotate(const Rotation& rotation, const double v[3], double out[3]) {
  for (int i = 0; i < 3; ++i) out[i] = rotation.m[i][0] * v[0] + rotation.m[i][1] * v[1] + rotation.m[i][2] * v[2];
}

// The quaternion of the rotation whose columns are x, y and z (Shepperd's choice of the greatest of four divisors).
inline void quaternion_of(const double x[3], const double y[3], const double z[3], float q[4]) {
  const double traces[4] = {x[0] - y[1] - z[2], y[1] - x[0] - z[2], z[2] - x[0] - y[1], x[0] + y[1] + z[2]};
  int best = 3;
  for (int i = 0; i < 3; ++i)
    if (traces[i] > traces[best]) best = i;
  const double twice = square_root(1.0 + traces[best]), over = 0.5 / twice;
  const double sums[3] = {y[2] - z[1], z[0] - x[2], x[1] - y[0]};      // 4 w (x, y, z)
  const double products[3] = {x[1] + y[0], y[2] + z[1], z[0] + x[2]};  // 4 (xy, yz, zx)
  double out[4] = {sums[0] * over, sums[1] * over, sums[2] * over, 0.5 * twice};
  if (best < 3) {
    out[best] = 0.5 * twice;
    out[(best + 1) % 3] = products[best] * over;
    out[(best + 2) % 3] = products[(best + 2) % 3] * over;
    out[3] = sums[best] * over;
  }
  for (int i = 0; i < 4; ++i) q[i] = static_cast<float>(out[i]);
}

}  // namespace sandglass
