// Three numbers in double, for the references of tests.
#pragma once

#include "models/geometry/vec3.h"

namespace sandglass::tests {

using Vector = host::Vec3;
using host::length;
inline Vector operator*(double s, Vector a) { return a * s; }
inline Vector at(const float* p) { return host::from_floats(p); }
inline void set(float* p, Vector a) { host::to_floats(a, p); }

}  // namespace sandglass::tests
