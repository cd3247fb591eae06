// Neighbour lists: which particles may touch in the next sub-steps, and how long that stays true.
//
// A list holds every pair that was closer than 2r + skin when it was built. It stays complete while no pair has
// approached by more than the skin, so lists are rebuilt by motion, not after a fixed number of sub-steps. Motion that
// all share does not count: half the range of the displacements bounds how far any particle strays from their mean, and
// a falling body needs no rebuild. Once the motion of the sub-steps has used up the skin, what is left of it is
// measured, place by place (list_slack.h).
#pragma once

#include "runtime/core/layout.h"
#include "runtime/granular/cell_sort.h"

namespace sandglass {

struct Granular;

struct Neighbours {
  CellSort sort;             // of the particles
  float* positions[3];       // x, y and z of the particles in sorted order, as the last build saw them
  uint32_t* lists;           // k_list_slots record indices a particle
  uint8_t* counts;           // used slots a particle
  uint8_t* near_counts;      // of them, near ones
  uint8_t* listed;           // one a group: 1 where the particles have lists
  bool halves;               // every pair is in one list only
  bool valid;                // false: the lists must be rebuilt before the next sub-step
  float slack;               // metres by which pairs may still approach before the lists are stale
  bool measured;             // the slack is that of a measurement, and no sub-step has run since
  float last_spread;         // metres; half the range of the last sub-step's displacements
  float last_substep;        // seconds; its length
  float builds_per_substep;  // recent average, for the forecast
};

void neighbours_layout(Neighbours* neighbours, uint32_t rows, Layout* layout);
void neighbours_reset(Neighbours* neighbours, float substep);
// Forgets what the lists were good for: the particles start as if they had just been added.
void neighbours_forget(Neighbours* neighbours, float substep);

// How far apart two particles of a list were at most when it was built, metres.
float neighbours_reach(const Granular& granular);

// Whether a sub-step of this length may need pairs that the lists lack, for all that is known.
bool neighbours_stale(const Granular& granular, uint32_t level, float substep);
// What the answer to that is worth: true where the slack can be measured.
bool neighbours_doubt(const Granular& granular);
// Measuring it, in units. True once it is done.
void neighbours_begin_measuring(Granular* granular);
bool neighbours_run_measuring(Granular* granular);

// Rebuilding, in units: sort, then lists. A `run` function is true once its phase is done.
void neighbours_begin_sort(Granular* granular);
bool neighbours_run_sort(Granular* granular);
bool neighbours_run_lists(Granular* granular);

// Whole lists of the particles [begin, end), from the grid of the last build. Returns how many neighbours had no room.
uint32_t neighbours_build(Granular* granular, uint32_t begin, uint32_t end);
// The whole list of particle i.
const uint32_t* neighbours_of(Granular* granular, uint32_t i, uint32_t* count);

// After a sub-step: uses up the slack by its motion.
void neighbours_wear(Granular* granular);
// At the start of a frame: what the last frame taught about how often lists are rebuilt.
void neighbours_learn(Neighbours* neighbours, uint32_t builds, uint32_t substeps);

// An empty list that points at the inert particle.
void neighbours_clear_row(Neighbours* neighbours, uint32_t row, uint32_t inert);

}  // namespace sandglass
