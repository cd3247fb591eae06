// What must not break a scene. Each case is a function from a description to a measured number.
#pragma once

#include <span>

#include "sandglass/sandglass.h"

namespace sandglass::host {

// `count` particles at one place, let go above a floor: largest overlap in r after two seconds, and how high above the
// place any of them came, in d.
struct Coincident {
  double overlap = 0.0, rise_d = 0.0;
};
Coincident coincident(const sandglass_scene_desc& desc, uint32_t count);

// A stack of `count` particles exactly on top of each other: height over count d after `seconds`, and the highest that
// it ever was.
struct Stack {
  double height = 0.0, highest = 0.0;
};
Stack stack(const sandglass_scene_desc& desc, uint32_t count, double seconds);

// One particle shot at 40 m/s through a bed at the floor: how far the lowest particle is below where it may be, in r.
double projectile_depth(const sandglass_scene_desc& desc);

// A collider put into a bed at once: the fastest particle over the CFL limit.
double teleport_speed(const sandglass_scene_desc& desc);

// A bed at this height weighting: fastest particle in the last 0.4 s of two, m/s.
double weighting_speed(sandglass_scene_desc desc, double k);

// Seconds simulated in frames of these time steps, which no clock measures: 0, negative, not a number, infinite, 1e9 s.
double simulated_time(const sandglass_scene_desc& desc, std::span<const double> time_steps);

}  // namespace sandglass::host
