// What the ten sums of the network's heads mean. Without libm, because results must not differ between C libraries.
#pragma once

#include "runtime/light/network/network.h"
#include "runtime/math/math.h"

namespace sandglass {

inline double elu(double x) { return x > 0 ? x : exponential(x) - 1; }
inline double sigmoid(double x) { return 1 / (1 + exponential(-x)); }
inline double hyperbolic_tangent(double x) { return 2 * sigmoid(2 * x) - 1; }

// The heads are direction, light colour, ambient colour and contrast. A direction of zero length becomes up.
inline LightOutputs light_outputs_of(const double heads[k_light_heads]) {
  constexpr double k_shortest = 1e-6;
  LightOutputs out = {};
  double direction[3];
  for (uint32_t axis = 0; axis < 3; ++axis) direction[axis] = hyperbolic_tangent(heads[axis]);
  const double length = square_root(square_of(direction));
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const double up = axis == 1 ? -1 : 0;
    out.direction[axis] = static_cast<float>(length > k_shortest ? direction[axis] / length : up);
    out.light[axis] = static_cast<float>(sigmoid(heads[3 + axis]));
    out.ambient[axis] = static_cast<float>(sigmoid(heads[6 + axis]));
  }
  out.contrast = static_cast<float>(sigmoid(heads[9]));
  return out;
}

}  // namespace sandglass
