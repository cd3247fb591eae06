// Simulated time: what the frames ask for, what is still to make up (the debt), and how it is cut into equal intervals,
// after each of which the grains may follow, and these into equal sub-steps.
#pragma once

#include "sandglass/sandglass.h"

namespace sandglass {

struct Granular;

constexpr double k_time_resolution = 1e-9;  // seconds; a shorter debt counts as none

// All in seconds.
struct SimulatedTime {
  float frame_step;      // the app's time step; 0: a pause
  double debt;           // simulated time to make up
  double interval_debt;  // the debt once the interval under way is complete
  double slipped;        // was asked for and is not made up any more: slow motion
  double simulated;      // in all
  double grain_lag;      // what the particles have gone through and the grains have not yet
};

// What the next sub-step will be.
struct SubstepPlan {
  double interval;  // the interval that it begins; 0: it goes on with the one under way
  uint32_t count;   // sub-steps left in the interval, this one included
  float substep;    // seconds
  bool stale;       // the lists must be rebuilt first
};

void time_reset(SimulatedTime* time);

// Adds a frame's time step to the debt.
void time_take(Granular* granular, float step);
// Whether the frame is a pause: whatever is owed, the particles and the grains do nothing.
bool time_paused(const Granular& granular);
// A sub-step is complete: pays its part of the debt.
void time_pay(Granular* granular);
// Pays the whole debt at once, while all sleep.
void time_skip(Granular* granular);

// The next interval: equal parts of the debt, at most a frame long; with the dissertation's rule at most refine_step.
double time_interval(const Granular& granular);
// The number of equal sub-steps of an interval: (4.45) within the scheme's range (correction to Alg. 5).
uint32_t time_substeps(const Granular& granular, double interval, uint32_t level);
SubstepPlan time_plan_substep(const Granular& granular, uint32_t level);

// As much as the next sweep of the grains may cover, besides the one under way.
double time_lag_limit(const Granular& granular);
// Whether the next interval waits until the grains have followed. They follow whatever the particles have gone through
// once there is no time debt, and before they would be more than two frames behind: time slows rather than leave grains
// behind further. With the dissertation's rule they follow after each interval.
bool time_awaits_grains(const Granular& granular);

}  // namespace sandglass
