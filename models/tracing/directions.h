// Directions and numbers for sampling light paths: directions about a normal or within a cap, and numbers that are
// spread evenly over a pixel's samples.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/geometry/vec3.h"

namespace sandglass::host {

// An orthonormal frame about a unit direction.
struct Frame {
  Vec3 u, v, w;
  explicit Frame(Vec3 direction) : w(direction) {
    u = normalised(cross(std::fabs(w.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{1, 0, 0}, w));
    v = cross(w, u);
  }
  Vec3 world(double a, double b, double c) const { return u * a + v * b + w * c; }
};

// A direction about the normal with the density cosine / pi. a and b are random numbers in 0..1.
inline Vec3 cosine_direction(Vec3 normal, double a, double b) {
  const double r = std::sqrt(a), angle = 2.0 * std::numbers::pi * b;
  return Frame(normal).world(r * std::cos(angle), r * std::sin(angle), std::sqrt(std::max(0.0, 1.0 - a)));
}

// A direction in the cap about `middle`, uniform in solid angle. `cosine_min` is that of the cap's rim; a and b
// are random numbers in 0..1.
inline Vec3 cap_direction(Vec3 middle, double cosine_min, double a, double b) {
  const double cosine = 1.0 - a * (1.0 - cosine_min), sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  const double angle = 2.0 * std::numbers::pi * b;
  return Frame(middle).world(sine * std::cos(angle), sine * std::sin(angle), cosine);
}

// Evenly spread numbers in 0..1: the index-th step of a lattice that begins at `start`. The steps for d dimensions are
// powers of 1 / x, where x is the root of x^(d + 1) = x + 1.
constexpr double k_plane_steps[2] = {0.7548776662466927, 0.5698402909980532};
constexpr double k_space_steps[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
inline double lattice_point(double start, int index, double step) {
  const double value = start + index * step;
  return value - std::floor(value);
}

}  // namespace sandglass::host
