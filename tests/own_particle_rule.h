// How a grain stays with its own particle (kernels/own_particle.inl), in double.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/vector.h"

namespace sandglass::tests {

// 1 at a and below, 0 at b and above, smooth between.
inline double fade(double value, double a, double b) {
  const double t = std::clamp((b - value) / (b - a), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

struct OwnParticle {
  Vector velocity, offset;  // from where it began to the grain
  double free = 0;          // its share of free fall
  double lone = 0;
};

struct OwnRule {
  double radius, time, step;  // of the particles; of the sweep; of the grains in it
  Vector gravity;
};

// What is left of `away` without the flight that a grain keeps.
inline Vector without_flight(const OwnRule& rule, const OwnParticle& own, double scale, Vector away) {
  const double speed = length(own.velocity), g = length(rule.gravity);
  const Vector ahead = 1 / std::max(speed, 1e-6) * own.velocity, down = 1 / g * rule.gravity;
  const double falls = own.free * dot(rule.gravity, ahead);
  const double lag = 0.5 * rule.time * std::max(falls, 0.0), began = std::max(speed - lag, 0.5 * scale);
  const double steady = std::clamp(1.25 * falls * dot(own.offset, ahead) / began, -0.5 * speed, 0.5 * speed);
  away = away - std::clamp(dot(away, ahead), std::min(steady, 0.0) - lag, std::max(steady, 0.0)) * ahead;
  const double sink_max = scale * (0.01 + 0.03 * fade(speed / scale, 0.1, 0.3) + 0.02 * own.free);
  return away - std::clamp(dot(away, down), 0.0, sink_max) * down;
}

// Changes the mean velocity that a grain follows, and its own one.
inline void stay_with_own(const OwnRule& rule, const OwnParticle& own, double weight, uint32_t number, Vector* mean,
                          Vector* velocity) {
  const double scale = std::sqrt(2 * rule.radius * length(rule.gravity)), radii = length(own.offset) / rule.radius;
  const double near = fade(radii, 2.35, 2.47);
  const Vector relative = own.velocity - *mean, added = 0.5 * (rule.time + rule.step) * rule.gravity;
  const Vector away = without_flight(rule, own, scale, *velocity + added - own.velocity);
  const double back =
      own.lone * (1 - own.free) * (1 - fade(radii * (0.7 + 0.04 * (number & 15)), 1.2, 1.6)) * 0.1 * scale;
  *mean = *mean + near * fade(weight, 1.8, 2) * (1 - fade(length(relative) / scale, 0.15, 0.4)) * relative;
  *velocity = *velocity - near * away - near * back / std::max(length(own.offset), 1e-6) * own.offset;
}

}  // namespace sandglass::tests
