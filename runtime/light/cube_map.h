// Faces of a cube map as every graphics API takes them: +x, -x, +y, -y, +z, -z; s to the right and t down, -1..1.
#pragma once

#include <cstdint>

#include "runtime/math/math.h"

namespace sandglass {

struct CubePoint {
  uint32_t face;
  double s, t;
};

// Where a direction meets the cube. It need not be of length 1, but not 0.
inline CubePoint cube_point(const double d[3]) {
  const double x = absolute(d[0]), y = absolute(d[1]), z = absolute(d[2]);
  if (x >= y && x >= z) return {d[0] > 0 ? 0u : 1u, (d[0] > 0 ? -d[2] : d[2]) / x, -d[1] / x};
  if (y >= z) return {d[1] > 0 ? 2u : 3u, d[0] / y, (d[1] > 0 ? d[2] : -d[2]) / y};
  return {d[2] > 0 ? 4u : 5u, (d[2] > 0 ? d[0] : -d[0]) / z, -d[1] / z};
}

// The direction of a point, of length 1.
inline void cube_direction(const CubePoint& point, double d[3]) {
  const uint32_t axis = point.face / 2;
  const double sign = point.face % 2 == 0 ? 1 : -1, scale = 1 / square_root(1 + point.s * point.s + point.t * point.t);
  d[axis] = sign * scale;
  d[axis == 0 ? 2 : 0] = (axis == 0 ? -sign : axis == 2 ? sign : 1) * point.s * scale;
  d[axis == 1 ? 2 : 1] = (axis == 1 ? sign : -1) * point.t * scale;
}

}  // namespace sandglass
