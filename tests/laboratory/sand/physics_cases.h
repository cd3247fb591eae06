// Scenes with a known outcome. Each is one function from a description to a measured number. `sandglass_lab verify
// granular` makes a table of them, and the tests assert that table. Every function takes solver settings, friction and
// radius from the description and sets the capacities itself.
#pragma once

#include <cstdint>
#include <span>

#include "sandglass/sandglass.h"

namespace sandglass::host {

// The defaults, with both friction coefficients mu.
sandglass_scene_desc physics_desc(double mu);

// One particle is thrown sideways; there is no floor. The largest deviation from symplectic Euler's closed form for the
// reported sub-steps, x = v t, y = -g dt^2 N(N+1)/2, relative to the distance fallen in one second.
double free_fall_error(const sandglass_scene_desc& desc);

// One particle on a plane, v0 = 1 m/s: the distance that it slides, in metres. *substep: the longest sub-step, seconds.
// Truth: v0^2/(2 mu g).
double sliding_distance(const sandglass_scene_desc& desc, double* substep);

// One particle at rest on an incline whose tangent is `slope`: metres moved downhill after `seconds`.
double incline_distance(const sandglass_scene_desc& desc, double slope, double seconds);
// Truth while it slides: g (sin - mu cos) t^2/2.
double incline_truth(const sandglass_scene_desc& desc, double slope, double seconds);

// A column of 1200 particles and 9600 grains that collapses and is then left alone: five seconds.
struct RestingPile {
  double overlap_mean, overlap_max;  // of the last instant
  double speed;                      // v_rms/sqrt(g d)
  double sinking;                    // of the top over the last second, in d
  double energy_ratio;               // kinetic energy at the end over its maximum
  double grains_below;               // grains below the floor by more than their radius
};
RestingPile resting_pile(const sandglass_scene_desc& desc);

// 512 particles flying into each other without gravity for 0.4 s: the change of total momentum per sub-step over the
// sum of the momenta's sizes, and over the whole run. `collisions`: how many of them changed direction.
struct Cloud {
  double drift_per_step = 0.0, drift = 0.0;
  double collisions = 0.0;
};
Cloud free_cloud(const sandglass_scene_desc& desc);

// Grains among particles of one velocity u, without gravity, for half a second: largest |v - u|/|u| of those inside.
// `shear` is the change of velocity over the block's height, relative to u; 0 for the claim.
double uniform_field_error(const sandglass_scene_desc& desc, double shear);

// The largest jump, in d, of a grain's displacement in one step when its start moves by one float's last place, along a
// line from outside into a block of moving particles: 1024 grains at a time, each time within the interval that jumped
// most, until its ends are neighbours. The first frame of a scene does not push grains apart.
double threshold_jump(const sandglass_scene_desc& desc);

// How far, in d and across the line, the push for an even density moves grains on a line through a block of particles at
// rest and far beyond it on both sides: the most, and the largest change from a grain to the next, 0.0012 radii away.
struct PushOnALine {
  double max = 0.0, change = 0.0;
};
PushOnALine push_on_a_line(const sandglass_scene_desc& desc);

// What must not break a scene. Beds are small, because each case tests an event, not bulk behaviour.

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

// A bed at this height weighting: fastest particle in the last 0.4 s of two, m/s.
double weighting_speed(sandglass_scene_desc desc, double k);

// Seconds simulated in frames of these time steps, which no clock measures: 0, negative, not a number, infinite, 1e9 s.
double simulated_time(const sandglass_scene_desc& desc, std::span<const double> time_steps);

}  // namespace sandglass::host
