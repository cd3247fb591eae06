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

// A cube of 27 particles, `ratio` times as dense as sand, dropped on a bed six layers deep: largest overlap at the end
// in r, and how high anything ever was, in d.
struct HeavyCube {
  double overlap_max = 0.0, highest_d = 0.0;
};
HeavyCube heavy_cube(const sandglass_scene_desc& desc, double ratio);

// One particle shot at 40 m/s through a bed at the floor: how far the lowest particle is below where it may be, in r.
double projectile_depth(const sandglass_scene_desc& desc);

// A collider put into a bed at once: the fastest particle over the CFL limit.
double teleport_speed(const sandglass_scene_desc& desc);

// A bed at this height weighting: fastest particle in the last 0.4 s of two, m/s.
double weighting_speed(sandglass_scene_desc desc, double k);

// What the library refuses or ignores as it must, of the attempts that are made: particles not finite, beyond the
// coordinate limit, one above the capacity (and the last place given, which counts too); colliders not finite, without
// size, of no shape.
struct Refusals {
  int refused = 0, attempts = 0;
};
Refusals refusals(const sandglass_scene_desc& desc);

// Seconds simulated in frames of these time steps, which no clock measures: 0, negative, not a number, infinite, 1e9 s.
double simulated_time(const sandglass_scene_desc& desc, std::span<const double> time_steps);

// Bodies that are a point, a pair, a line, a plane, dropped on the floor: largest deviation from rigid, in r.
double degenerate_body_softness(const sandglass_scene_desc& desc);

// nearest_rotation against matrices whose best rotation is known by construction, A = Q S: largest gap of the trace
// tr(R^T A) to the best, relative. Mirrored ones (S with a negative factor), half turns from the start, ranks 0 to 3.
double rotation_gap(double scale);

}  // namespace sandglass::host
