// An orthonormal frame about a unit direction, for casting rays.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/geometry/vec3.h"

namespace sandglass::host {

struct Frame {
  Vec3 u, v, w;
  explicit Frame(Vec3 direction) : w(direction) {
    u = normalised(cross(std::fabs(w.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{1, 0, 0}, w));
    v = cross(w, u);
  }
  Vec3 world(double a, double b, double c) const { return u * a + v * b + w * c; }
};

// A direction about the normal with density cos/pi, from two numbers in 0..1.
inline Vec3 cosine_direction(Vec3 normal, double a, double b) {
  const double r = std::sqrt(a), angle = 2.0 * std::numbers::pi * b;
  return Frame(normal).world(r * std::cos(angle), r * std::sin(angle), std::sqrt(std::max(0.0, 1.0 - a)));
}

}  // namespace sandglass::host
