// The particles' stage: simulated time in equal sub-steps, each a sequence of phases, each phase a sequence of units.
// One machine says which phase follows which (substep.cpp).
//
// A frame may end between any two units. records[0] of the particles then holds the last complete sub-step, so the
// scene is valid.
#pragma once

#include "kernels/kernels.h"
#include "runtime/core/governor.h"

namespace sandglass {

struct Granular;

// In the order in which they run. The first, and those from touch on, run only where they are due.
enum class SubstepPhase : uint32_t {
  idle,        // between sub-steps
  departed,    // before an interval: what can reach nothing in it
  slack,       // what the lists are still good for
  sort,        // the particles by cell, where the lists are stale
  lists,       // new neighbour lists
  colours,     // of the pairs, where lists are new
  stabilise,   // passes that correct the start positions
  solve,       // the source's passes, which predict, resolve contacts and integrate
  predict,     // motion without contacts
  pairs,       // passes that resolve contacts, pair by pair
  complete,    // colliders, and the new state
  bodies,      // rigid motion instead of their particles' own
  touch,       // who is near a collider that moved wakes
  wake,        // who was run into wakes
  sleep,       // who has kept still falls asleep
  drain,       // who is inside a sink goes
  wake_lists,  // lists for those that woke
};

struct Substep {
  SubstepPhase phase;
  uint32_t level;           // quality level at which the sub-step began
  uint32_t due;             // phases that must run before the next sub-step begins: bit 1 << phase
  uint32_t cursor;          // next item of the phase
  uint32_t pass;            // of the stabilisation or of the solver
  uint32_t iterations;      // passes of the solver
  uint32_t interval_left;   // sub-steps left in the interval, this one included
  float length;             // seconds
  float longest, shortest;  // seconds; what the scheme allows
  uint32_t dither;          // phase of the sequence by which gravity varies (contacts.cpp)
  ContactExtent extent;     // what the last pass has seen so far
};

void substep_reset(Substep* substep);
// As after a reset, but what varies gravity goes on. Nothing may be under way.
void substep_forget(Substep* substep);
Stage granular_particle_stage(Granular* granular);

// Nothing is under way and nothing is due.
bool substep_idle(const Granular& granular);
void substep_set_due(Granular* granular, SubstepPhase phase, bool due);
// Before material changes: the sub-step under way starts again from the last state, or ends where bodies have already
// moved.
void substep_abandon(Granular* granular);

// Whether contacts are solved pair by pair. The other scheme is the source's.
bool solves_pairs(const Granular& granular);
// The passes (contacts.cpp).
// Metres a second that what is deep in a collider may leave it with, besides the collider's own velocity.
float contacts_leave_speed(const Granular& granular);
void contacts_begin(Granular* granular);
// One unit of a pass. True once the pass is complete.
bool contacts_run(Granular* granular);
bool contacts_run_pairs(Granular* granular);

}  // namespace sandglass
