// The grains' stage. A sweep is one pass of the refinement over all grains (4.39-4.44): a snapshot of the particles is
// sorted by cells of the support radius, the grains are sorted anew every few sweeps, and those that are not asleep are
// moved unit by unit. A sweep may take several frames, and covers all the simulated time that the grains lag behind at
// its begin, in up to k_sweep_steps_max steps. One machine says which phase follows which (sweep.cpp).
#pragma once

#include "runtime/core/governor.h"
#include "sandglass/sandglass.h"

namespace sandglass {

struct Granular;

constexpr uint32_t k_sweep_steps_max = 4;  // and frames that a sweep may cover
// Sweeps in a row that a grain keeps still before it may sleep; the apex of a flight is shorter.
constexpr float k_patience_sweeps = 16.0f;

// In the order in which they run.
enum class SweepPhase : uint32_t {
  idle,      // between sweeps
  snapshot,  // copies the particles, sorted by cell; they wait meanwhile
  sort,      // the grains by cell, every few sweeps
  scatter,   // the particles' motion to the nodes of a grid
  join,      // its blocks
  count,     // the grains in its cells
  smooth,    // makes their density of it
  triage,    // which groups of grains are refined
  refine,    // moves them
  drain,     // takes out those that are inside a sink
};

struct Sweep {
  SweepPhase phase;
  uint32_t cursor;          // next item of the phase
  float sweeps_since_sort;  // a sweep over a part of the grains counts for that part
  float step;               // seconds
  uint32_t steps;
  uint32_t since_push;  // sweeps since the last one in which grains were counted and pushed apart; 0: in this one
  uint32_t particles;   // in the snapshot
  double time;          // simulated time that the sweep covers, seconds
};

void sweep_reset(Sweep* sweep);
// Nothing is remembered of the grains' order, and the next sweep does not push them apart. No sweep may be under way.
void sweep_forget(Sweep* sweep);
Stage granular_grain_stage(Granular* granular);

// Runs the sweep under way to its end.
void sweep_finish(Granular* granular);

// Whether grains may be added: no phase is under way that would have to begin again.
bool sweep_takes_grains(const Granular& granular);
// What material that comes and goes means for the sweep under way.
void sweep_particles_changed(Granular* granular);
void sweep_grains_added(Granular* granular, uint32_t count);
void sweep_grains_removed(Granular* granular);

}  // namespace sandglass
