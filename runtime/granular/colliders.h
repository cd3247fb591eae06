// Colliders on their way through a frame: checked once, posed at the instant at which a sub-step ends, and compared
// with those of earlier frames, because sand sleeps on them.
#pragma once

#include "kernels/kernels.h"
#include "runtime/core/layout.h"

namespace sandglass {

struct Granular;

// Colliders that moved, appeared or went away: where they were and where they are.
struct MovedColliders {
  ColliderFrame* frames;
  float* margins;  // metres around each, within which sleepers wake
  uint32_t count;
};

// The colliders as sleepers last saw them, and what has changed since.
struct ColliderWatch {
  sandglass_collider* before;
  uint32_t before_count;
  MovedColliders moved;
};

struct Colliders {
  sandglass_collider* given;      // of this frame, those that particles see first, with the velocities of their ways
  ColliderFrame* substep_frames;  // posed for the sub-step
  ColliderFrame* sweep_frames;    // posed for the grains' sweep
  // How many were posed. A step that goes on in the next frame ends with the colliders with which it began.
  uint32_t substep_count, sweep_count;
  uint32_t count;
  uint32_t solid_count;  // those that particles see
  ColliderWatch solid;   // for the particles
  ColliderWatch all;     // for the grains
  bool adopts;           // the next frame's count as seen: nothing has moved
};

void colliders_layout(Colliders* colliders, const sandglass_granular_desc& desc, Layout* layout);
void colliders_reset(Colliders* colliders);

// Takes a frame's colliders. Counts those that it leaves out. owed: the time debt, in seconds, before the frame's time
// step was added. Sand that owes time has not gone the whole of the last frames' way yet. So a collider goes what is
// left of its way, and this frame's, spread over all the simulated time left: one that stops has not jumped, and in
// slow motion it is faster than the app says, as it is on the screen.
void colliders_take(Granular* granular, const sandglass_frame_input& input, double owed);
// Finds what has changed for the particles since they were last woken; a change makes the touch phase due.
void colliders_find_moved(Granular* granular);

// `now` are the colliders that sleepers have seen.
void watch_remember(ColliderWatch* watch, const sandglass_collider* now, uint32_t count);
// Fills watch->moved. margin: metres around a collider that count as near.
void watch_find_moved(ColliderWatch* watch, const sandglass_collider* now, uint32_t count, float margin);
bool watch_changed(const ColliderWatch& watch, const sandglass_collider* now, uint32_t count);

// Finite, with positive sizes and a usable rotation? Writes the collider with its rotation normalised.
bool collider_accept(const sandglass_collider& collider, sandglass_collider* accepted);

// Poses each collider as it was `before` seconds before the end of the frame, going back along its velocities.
void colliders_pose(const sandglass_collider* colliders, uint32_t count, float before, ColliderFrame* frames);

}  // namespace sandglass
