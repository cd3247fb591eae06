// Coming and going: emitters pour particles and grains into the scene, sinks and the app take them out.
//
// Removing moves the last record into the gap, so the order of the others stays. A layer of sand comes before the first
// sub-step that begins after the layer's moment, and only while a sweep of the grains neither takes its snapshot nor
// sorts nor chooses what to refine. So nothing about a jet depends on the length of a frame. What comes later than its
// moment comes as far from the nozzle and as fast as it would be by then.
//
// A layer goes on with the lattice of the one before it, also where the nozzle has moved aside. But a jet that touched
// something is not where free fall has it. Sand placed into it would be driven back, the next layer into that, and the
// jet would spray. So each particle steps back to where it overlaps nothing. If that is too far, it is left out.
//
// Numbers of removed items are used again, the last removed first.
#pragma once

#include "kernels/kernels.h"
#include "runtime/core/layout.h"

namespace sandglass {

struct Granular;

struct EmitterState {
  double run;       // metres that sand has come since the last layer, by the speeds of the time
  uint32_t layer;   // layers so far
  float origin[3];  // a point of the last layer's lattice, where the layer left the nozzle, world, metres
};

struct Nozzle {
  sandglass_emitter emitter;  // with the speed that it has, and a rotation of length 1
  float axes[3][3];           // local x, y, z in the world
  float shift[2];             // of the coming layer's lattice along x and z, metres
  uint32_t sites[2];          // of an even and of an odd layer that is not shifted; 0: not counted yet
};

struct Sites;
struct Batch;

// Since the scene was created or reset.
struct FlowCounts {
  uint64_t emitted_particles, emitted_grains, removed_particles, removed_grains;
  uint64_t denied_particles;  // that found no room or no free place
  uint64_t removed_bodies;
};

struct Flow {
  uint32_t* free_particles;  // numbers
  uint32_t* free_grains;
  uint32_t free_particle_count, free_grain_count;
  Nozzle* nozzles;  // of this frame
  EmitterState* emitter_states;
  Sites* sites;          // of the layer that comes
  Batch* batch;          // of it, what is added next
  ColliderFrame* sinks;  // of this frame
  uint32_t emitter_count, sink_count;
  FlowCounts counts;
};

void flow_layout(Flow* flow, const sandglass_granular_desc& desc, Layout* layout);
void flow_reset(Flow* flow, const sandglass_granular_desc& desc);

// The number of a new item, where there are `count` of its kind already.
uint32_t flow_take_particle_number(Flow* flow, uint32_t count);
uint32_t flow_take_grain_number(Flow* flow, uint32_t count);

// Takes particle i or grain i out; the last one moves into its place.
void flow_remove_particle(Granular* granular, uint32_t i);
void flow_remove_grain(Granular* granular, uint32_t i);
// After particles were taken out: indices mean others now.
void flow_after_removal(Granular* granular);

// Takes a frame's emitters and sinks. Counts those that it leaves out.
void flow_take(Granular* granular, const sandglass_frame_input& input);
// So many seconds of simulated time have passed.
void flow_pass_time(Flow* flow, double seconds);
// Whether a layer comes before the next sub-step.
bool flow_is_due(const Granular& granular);
// m/s of the fastest emitter; 0 without one.
float flow_speed(const Flow& flow);
// Lets in the layers that are due. The colliders are those of the coming sub-step.
void flow_emit(Granular* granular);

// Units that empty the sinks, and take out what is gone. True once all is done.
bool flow_run_drain(Granular* granular);
bool flow_run_grain_drain(Granular* granular);

sandglass_status granular_remove(Granular* granular, const sandglass_collider* region, uint32_t* particles,
                                 uint32_t* grains, const char** reason);

}  // namespace sandglass
