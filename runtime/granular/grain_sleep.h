// Sleep of the grains: which of them a sweep refines. A group of 16 grains, neighbours in storage and so mostly in
// space, is left out when three things hold: all of it has kept still for some sweeps, no particle that moves is near
// enough to be in its sums (particle_motion.h), and no collider that moved since the last sweep comes near.
//
//   triage   lists every group for the refinement or leaves it out
//
// The refinement itself leaves a still grain where it is while no particle in its sums moves, so leaving its group out
// changes no bit. With the dissertation's rule every step looks the particles up, and no group is left out.
#pragma once

#include "kernels/particle.h"
#include "runtime/core/layout.h"

namespace sandglass {

struct Granular;

struct GrainSleep {
  uint32_t* groups;  // numbers of the groups that the sweep refines
  uint8_t* still;    // one a group: all its grains keep still
  Sleeper* tiles;    // one a group: the sphere that holds its grains
  uint32_t group_count;
  uint32_t still_groups;  // that the last triage found
  bool groups_changed;    // by sorting or removal since the last triage: `still` is of other groups
  bool all_asleep;        // the last sweep refined no grain, and all particles slept
  bool wakes;             // a whole triage must still wake every grain
  bool waking;            // the triage under way does
};

void grain_sleep_layout(GrainSleep* sleep, const sandglass_granular_desc& desc, Layout* layout);
void grain_sleep_reset(GrainSleep* sleep);
// Every grain wakes in the next sweep, group by group.
void grain_sleep_wake_all(GrainSleep* sleep);
// Nothing is remembered of which groups keep still, and nothing is left to wake. Between sweeps.
void grain_sleep_settle(Granular* granular);

// Grains that all sleep on sleeping particles have nothing to follow, unless a collider has changed.
void grain_sleep_skip_time(Granular* granular);

// The phases of a sweep. A `run` function is true once its phase is done.
uint32_t grain_sleep_items(const Granular& granular);  // of the next unit
void grain_sleep_begin_triage(Granular* granular);
bool grain_sleep_run_triage(Granular* granular);

}  // namespace sandglass
