// The frame of a plane, as apps describe one: a normal and a direction along it.
#pragma once

#include "runtime/math/finite.h"
#include "runtime/math/math.h"

namespace sandglass {

// Unit vectors in the world: along, the normal, and their cross product along x normal. Returns the sentence that says what
// is wrong, or null.
inline const char* plane_axes(const float normal[3], const float along[3], double axes[3][3]) {
  if (!all_finite(normal, 3) || !all_finite(along, 3)) return "the plane's normal or along is not finite.";
  double n[3], a[3], largest[2] = {0, 0}, share = 0;
  for (int i = 0; i < 3; ++i) {
    n[i] = static_cast<double>(normal[i]);
    a[i] = static_cast<double>(along[i]);
    largest[0] = absolute(n[i]) > largest[0] ? absolute(n[i]) : largest[0];
    largest[1] = absolute(a[i]) > largest[1] ? absolute(a[i]) : largest[1];
  }
  if (!(largest[0] > 0) || !(largest[1] > 0)) return "the plane's normal or along is the zero vector.";
  for (double& x : n) x /= largest[0];
  for (double& x : a) x /= largest[1];
  const double length = square_root(square_of(n));
  for (double& x : n) x /= length;
  for (int i = 0; i < 3; ++i) share += a[i] * n[i];
  for (int i = 0; i < 3; ++i) a[i] -= share * n[i];
  const double squared = square_of(a);
  if (!(squared > 1e-6)) return "the plane's along is along its normal: it must lie in the plane.";
  for (int i = 0; i < 3; ++i) {
    axes[0][i] = a[i] / square_root(squared);
    axes[1][i] = n[i];
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    axes[2][i] = axes[0][j] * n[k] - axes[0][k] * n[j];
  }
  return nullptr;
}

}  // namespace sandglass
