// The motion of the particles during a sweep, on the nodes of a sparse grid, for the grains to read (kernels.h). What
// counts is a particle's displacement since the last sweep, at the place where it began: then one sweep a frame follows
// as closely as many with the velocities of their ends.
//
//   scatter  the particles of the snapshot, in their order
//   join     each block gets the nodes of the next blocks that its cells reach
#pragma once

#include "kernels/kernels.h"
#include "runtime/core/layout.h"

namespace sandglass {

struct Granular;

struct Place {
  float position[3];
};

struct ParticleMotion {
  MotionGrid grid;
  // One a number: where the particle was at the last sweep's snapshot, and at that of the sweep under way.
  Place* starts;
  Place* ends;
};

void motion_layout(ParticleMotion* motion, const sandglass_granular_desc& desc, Layout* layout);
// The planes, in which nothing is kept from sweep to sweep.
void motion_planes_layout(ParticleMotion* motion, const sandglass_granular_desc& desc, Layout* layout);
void motion_configure(ParticleMotion* motion, const sandglass_granular_desc& desc);

// How nearly a particle with these velocities, at the end of `time` and on average, fell freely: then the first is larger
// by half of what gravity adds in that time. From 1, it did, to 0.
float motion_free_fall(const float at_end[3], const float mean[3], const float gravity[3], float time);

// A particle that is added, as if it had come this way with its velocity.
void motion_add(Granular* granular, uint32_t number, const float position[3], const float velocity[3]);
// The particles from the row `first` on, which were just added, have fallen freely on their way.
void motion_fall(Granular* granular, uint32_t first);
// What the particles do from now on is what the next sweep covers. The grains lag behind by nothing.
void motion_begin_here(Granular* granular);
// The sweep under way is complete.
void motion_complete(Granular* granular);

// The phases of a sweep. A `run` function runs a unit, and is true once its phase is done.
// `time`: simulated, seconds.
void motion_begin(ParticleMotion* motion, double time);
// Empties the part of the table of blocks that goes with the items from `begin` to `end` of `all`.
void motion_clear(MotionGrid* grid, uint32_t begin, uint32_t end, uint32_t all);
uint32_t motion_items(const Granular& granular);                        // of the next unit
uint64_t motion_items_of_a_sweep(const Granular& granular, bool even);  // as many blocks as the last sweep had
bool motion_run_scatter(Granular* granular);
bool motion_run_join(Granular* granular);
bool motion_run_count(Granular* granular);
bool motion_run_smooth(Granular* granular);

// A block that has all its own nodes gets its records.
void motion_join(MotionGrid* grid, uint32_t number);
// A block, around which all grains are counted, gets its density.
void motion_smooth(const MotionGrid& grid, uint32_t number);

// Whether a particle moves so near to a sphere that the sums in it may change.
bool motion_near(const MotionGrid& grid, const float position[3], float radius);

}  // namespace sandglass
