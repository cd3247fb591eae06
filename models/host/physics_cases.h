// Scenes with a known outcome, each one function from a description to a measured number: what `sandglass verify
// granular` tabulates and the tests assert. Every function takes the description's solver settings, friction and radius
// as they are and sets the capacities itself.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sandglass/sandglass.h"

namespace sandglass::host {

// The defaults, with both friction coefficients mu.
sandglass_scene_desc physics_desc(double mu);

// One particle thrown sideways, no floor: largest deviation from symplectic Euler's closed form for the sub-steps that
// were reported, x = v t, y = -g dt^2 N(N+1)/2, relative to the distance fallen in one second.
double free_fall_error(const sandglass_scene_desc& desc);

// One particle on a plane, v0 = 1 m/s: the distance it slides in metres; *substep the step length. Truth: v0^2/(2 mu
// g).
double sliding_distance(const sandglass_scene_desc& desc, double* substep);

// One particle at rest on an incline whose tangent is `slope`: metres moved downhill after `seconds`.
double incline_distance(const sandglass_scene_desc& desc, double slope, double seconds);
// Truth while it slides: g (sin - mu cos) t^2/2.
double incline_truth(const sandglass_scene_desc& desc, double slope, double seconds);

// Twenty particles exactly on top of each other, after two seconds: height over 20 d.
double stack_height(const sandglass_scene_desc& desc);

// A column of 1200 particles and 9600 grains that collapses and is then left alone: five seconds.
struct RestingPile {
  double overlap_mean, overlap_max;  // of the last instant
  double speed;                      // v_rms/sqrt(g d)
  double sinking;                    // of the top over the last second, in d
  double energy_ratio;               // kinetic energy at the end over its maximum
  double grains_below;               // grains below the floor by more than their radius
  double lowest_grain;               // height of the lowest grain in drawn radii
  double angle_deg;
};
RestingPile resting_pile(const sandglass_scene_desc& desc);

// One row of the table. Control rows pass when a wrong setting fails the claim as it must.
struct Verdict {
  std::string name, unit;
  double truth = 0.0, result = 0.0, limit = 0.0;  // the result may differ from the truth by the limit
  bool pass = false, control = false;
};

// The whole table. `done(n, total)` is called after each scene; it returns false to stop early.
std::vector<Verdict> granular_verdicts(sandglass_isa isa, const std::function<bool(uint32_t, uint32_t)>& done);

}  // namespace sandglass::host
