// Coming and going: emitters pour particles and grains into the scene, sinks and the app take them out.
//
// Removing moves the last record into the gap, so the order of the others stays. Emitting happens between intervals of
// simulated time, never in the middle of a sub-step, and only while a sweep of the grains neither takes its snapshot
// nor sorts nor chooses what to refine. What cannot come in time comes later, as far from the nozzle and as fast as it
// would be by then.
//
// Numbers of removed items are used again, the last removed first.
#pragma once

#include "kernels/kernels.h"
#include "runtime/core/layout.h"

namespace sandglass {

struct Granular;

struct EmitterState {
  double run;       // metres that sand has come since the last layer
  uint32_t layer;   // layers so far
  uint32_t unused;  // what is saved has no gap
};

// Since the scene was created or reset.
struct FlowCounts {
  uint64_t emitted_particles, emitted_grains, removed_particles, removed_grains;
  uint64_t denied_particles;  // that found no room
  uint64_t removed_bodies;
};

struct Flow {
  uint32_t* free_particles;  // numbers
  uint32_t* free_grains;
  uint32_t free_particle_count, free_grain_count;
  sandglass_emitter* emitters;  // of this frame
  EmitterState* emitter_states;
  ColliderFrame* sinks;  // of this frame
  uint32_t emitter_count, sink_count;
  FlowCounts counts;
};

void flow_layout(Flow* flow, const sandglass_granular_desc& desc, Layout* layout);
void flow_reset(Flow* flow, const sandglass_granular_desc& desc);

// The number of a new item, where there are `count` of its kind already.
uint32_t flow_take_particle_number(Flow* flow, uint32_t count);
uint32_t flow_take_grain_number(Flow* flow, uint32_t count);

// Takes particle i out; the last one moves into its place.
void flow_remove_particle(Granular* granular, uint32_t i);
// After particles were taken out: indices mean others now.
void flow_after_removal(Granular* granular);

// Takes a frame's emitters and sinks. Counts those that it leaves out.
void flow_take(Granular* granular, const sandglass_frame_input& input);
// Lets the emitters pour for so many seconds of simulated time.
void flow_emit(Granular* granular, double seconds);

// Units that empty the sinks. True once all is done.
bool flow_run_drain(Granular* granular);
bool flow_run_grain_drain(Granular* granular);

sandglass_status granular_remove(Granular* granular, const sandglass_collider* region, uint32_t* particles,
                                 uint32_t* grains, const char** reason);

}  // namespace sandglass
