// Rotations given as quaternions by apps and their sensors, in double: any length above 0 is accepted.
#pragma once

#include "runtime/core/math.h"

namespace sandglass {

struct Rotation {
  double m[3][3];  // rows
};

inline bool rotation_of(const float q[4], Rotation* rotation) {
  double squared = 0.0, c[4];
  for (int i = 0; i < 4; ++i) c[i] = static_cast<double>(q[i]), squared += c[i] * c[i];
  if (!(squared > 0.0) || squared - squared != 0.0) return false;  // zero, NaN or infinite
  const double length = square_root(squared);
  for (double& x : c) x /= length;
  const double x = c[0], y = c[1], z = c[2], w = c[3];
  *rotation = {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
  return true;
}

inline void rotate(const Rotation& rotation, const double v[3], double out[3]) {
  for (int i = 0; i < 3; ++i) out[i] = rotation.m[i][0] * v[0] + rotation.m[i][1] * v[1] + rotation.m[i][2] * v[2];
}

}  // namespace sandglass
