// Who holds sand (Carry, in solver.h), for sixteen particles at once.
#pragma once

#include "runtime/sand/granular.h"

namespace sandglass {

constexpr uint32_t k_no_holder = ~0u;
constexpr uint32_t k_holders_near = 64;  // colliders that are asked for a group of particles
constexpr uint32_t k_together = 4;       // times sixteen particles that are first taken for held by one collider

// Positions and velocities of sixteen particles. Lanes without a particle repeat one of the others.
struct HeldLanes {
  alignas(sizeof(Quad)) float at[3][k_lane_group];
  const float* velocities;  // a record apart
  uint32_t count;
};

// Sixteen particles that may be held.
struct Sixteen {
  uint32_t first, count;       // particles
  float scale;                 // of their copies
  Bounds box;                  // around all that have not departed
  uint32_t here, free, awake;  // bits: these; and of them what is sand; what is awake
};

// A box around particles, and the colliders that are below it, near it or around it.
struct HeldGroup {
  Bounds box;
  float down[3];
  uint32_t near[k_holders_near], count;
  bool some;  // one of these carries
};

// Scratch for one group after another, which would be too much for the stack.
struct HeldScratch {
  alignas(SANDGLASS_BLOCK_ALIGNMENT) SurfacePoint points[k_lane_group];
  HeldLanes lanes, corners;
  Sixteen sixteens[k_together];
  HeldGroup group;
  ColliderFrame posed;
  alignas(sizeof(Quad)) float local[3][k_lane_group], traced[3][k_lane_group], normal[3][k_lane_group];
  float last[k_lane_group], distance[k_lane_group], nearest[k_lane_group], below[k_lane_group], found[k_lane_group];
  float moved[k_lane_group];
  uint32_t support[k_lane_group], enclosing[k_lane_group], holder[k_lane_group];
};

inline HeldScratch& scratch_of(const Granular& granular) { return *granular.carry.scratch; }

bool holding_encloses(const ColliderFrame& collider);
bool holding_carries(const Granular& granular, uint32_t collider);
// The box around a collider in the world's axes; of a half-space, everything.
Bounds holding_box(const ColliderFrame& collider);
// The same of a group of colliders of one motion, in the axes of its first.
void holding_join(Bounds* box, const ColliderFrame& first, const ColliderFrame& collider);
bool holding_overlaps(const Bounds& a, const Bounds& b, float margin);
void holding_velocity(const ColliderFrame& collider, const float at[3], float velocity[3]);
// Distances of the first `count` lanes from a collider.
void holding_measure(const Granular& granular, const ColliderFrame& collider, const float at[3][k_lane_group],
                     float distance[k_lane_group], uint32_t count = k_lane_group);
// Distances and normals of the scratch's points.
void holding_measure_points(const Granular& granular, const ColliderFrame& collider, uint32_t count);
// The same of one place.
float holding_distance(const Granular& granular, const ColliderFrame& collider, const Quad& at, Quad* normal);
// A collider after `share` of its motion, at most all of it; until the next call.
const ColliderFrame& holding_posed(const Granular& granular, const Carrier& carrier, float share);

// From records, of which those of the bits count.
void holding_read(const Record* records, uint32_t count, uint32_t which, HeldLanes* lanes);
void holding_find_near(const Granular& granular, HeldGroup* group);
// The collider that holds all of a group, if that is certain; else k_no_holder.
uint32_t holding_sole(const Granular& granular, const HeldGroup& group);
// The collider that holds each lane; k_no_holder: none that moves. False: of all lanes.
bool holding_find(const Granular& granular, const HeldGroup& group, const HeldLanes& lanes,
                  uint32_t holder[k_lane_group]);

}  // namespace sandglass
