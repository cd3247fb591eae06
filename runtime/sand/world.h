// Layer 1 of granular: the world around the sand. What is solid in it, and what comes into it and goes out of it.
//
// The layers include each other in one direction: world.h, particles.h, solver.h, grains.h, granular.h.
#pragma once

#include "kernels/kernels.h"
#include "runtime/frame/layout.h"
#include "runtime/math/rigid_motion.h"
#include "runtime/sand/held_pose.h"

namespace sandglass {

struct Granular;
struct FrameCounts;
struct SavedScene;

// A rigid move of the scene: p becomes rotation * p + shift.
struct SceneMove {
  float axes[3][3];  // images of x, y, z
  float shift[3];
  double rotation[4];

  void turn(float v[3]) const {
    const float x = v[0], y = v[1], z = v[2];
    for (int k = 0; k < 3; ++k) v[k] = x * axes[0][k] + y * axes[1][k] + z * axes[2][k];
  }
  void move(float p[3]) const {
    turn(p);
    for (int k = 0; k < 3; ++k) p[k] += shift[k];
  }
};

// ---- Colliders (colliders.cpp; a frame's list: known_colliders.cpp)
//
// Colliders through a frame: checked once, recognised, held still (runtime/sand/held_pose.h), posed at the
// instant at which a sub-step ends, and compared with those of earlier frames, because sand sleeps on them.
//
// A collider is recognised from frame to frame by its id, else by an equal pose, else by its place in the list, else as
// the nearest of its shape; one that was not passed in the last frame only about where it was. It then has a slot, by
// which all else knows it. So the order of the list means nothing, and one that comes and goes changes nothing for the
// others.

// What a slot knows of its collider. Saved as it is.
struct KnownCollider {
  uint32_t used;
  uint32_t id;
  // Its place in the last list: among the usable colliders, and among all.
  uint32_t place, listed;
  sandglass_shape shape;
  float absent;  // seconds since it was last passed
  HeldPose pose;
};

// A collider as sleepers saw it. Saved as it is, without the field.
struct SeenCollider {
  uint32_t present;
  sandglass_shape shape;
  Pose pose;
};

enum class SeenBy : uint8_t { none, grains, all };

struct CellChange;
// A relief whose heights have changed since `seen`, its last change then.
struct ChangedRelief {
  ColliderFrame at;
  const CellChange* changes;
  uint32_t seen;
};

// Colliders that moved, appeared or went away: where they were and where they are. And reliefs with other heights.
struct MovedColliders {
  ColliderFrame* frames;
  float* margins;  // metres around each, within which sleepers wake
  uint32_t count;
  ChangedRelief* reliefs;
  uint32_t relief_count;
  bool none() const { return count == 0 && relief_count == 0; }
};

// The colliders as sleepers last saw them, by slot, and what has changed since.
struct ColliderWatch {
  SeenCollider* seen;
  uint64_t* fields;  // versions, to compare; 0: not known, because the scene was restored
  // Of reliefs, as the look for sleepers began that is under way: what changes meanwhile has not been seen.
  uint64_t* looked_at;
  MovedColliders moved;
};

// How a collider goes on without time for sand: because it has jumped, or because the frame's time is given up.
struct Carrier {
  ColliderFrame from, to;
  RigidMotion motion;
  bool moves;
};

struct Colliders {
  // One a slot: what is known, this frame's collider as sand meets it, and who sees it.
  KnownCollider* known;
  sandglass_collider* of_slot;
  SeenBy* seen_by;
  // This frame's colliders as sand meets them, in the order in which they push, and their slots.
  sandglass_collider* given;
  uint32_t* slots;
  // The part of a collider's velocities, linear and angular, that does not move its pose: one a slot, and of each
  // `given`.
  float (*slides_of_slot)[6];
  const float** slides;
  // The slots of this frame's list, by place among the usable colliders.
  uint32_t* slot_of_place;
  // One a slot: where sand met it last, before this frame.
  Pose* met;
  // One a slot: 1 where it has jumped in this frame; or k_is_new.
  uint8_t* jumps;
  // One a slot: where it is at the frame's end.
  Pose* ends;
  // One for each solid one of `given`.
  Carrier* carriers;
  // Posed for the sub-step, with their slots.
  uint32_t* substep_slots;
  ColliderFrame* substep_frames;
  // Posed for the grains' sweep; and after each step of it but the last.
  ColliderFrame* sweep_frames;
  ColliderFrame* sweep_step_frames;
  // How many were posed. A step that goes on in the next frame ends with the colliders with which it began.
  uint32_t substep_count, sweep_count;
  // 0: grains meet colliders where these end, in all steps.
  uint32_t sweep_step_frame_count;
  // All of `given`; and those that particles see, too, which come first.
  uint32_t count;
  uint32_t solid_count;
  // A solid one has jumped in this frame.
  bool jumped;
  // At the end of the last frame, colliders were carried to where the app gives them.
  bool arrived;
  ColliderWatch for_particles, for_grains;
  // After saving or restoring, until a collider is passed.
  bool waits;
  // A relief has been passed since the scene was created or reset: else nobody looks for changed ones.
  bool reliefs;
};
constexpr uint32_t k_no_slot = ~0u;
constexpr uint8_t k_is_new = 2;  // another collider had the slot, or nobody knows where this one was

void colliders_layout(Colliders* colliders, const sandglass_granular_desc& desc, Layout* layout);
void colliders_reset(Colliders* colliders, const sandglass_granular_desc& desc);

// Takes a frame's colliders. Counts those that it leaves out. `owed`: the time debt, in seconds, before the frame's
// time step was added.
//
// With a time debt, sand has not met all of the colliders' earlier motion yet. So what is left of that motion and this
// frame's are spread over all the simulated time that is left: a collider that stops has not jumped.
//
// In slow motion a collider goes from where sand met it last, at SimulatedTime::rate of its velocity. In the rest of
// its motion it carries what it holds (Carry, in solver.h), and ends where the app gives it.
//
// The smallest push first. Sand cannot enter the last one to push: a hand presses no sand through the table.
void colliders_take(Colliders* colliders, const Granular& granular, const sandglass_frame_input& input, double owed,
                    FrameCounts* counts);
// Finds what has changed for the particles since they were last woken. A change makes the touch phase due. After that
// phase, colliders_seen_by_particles notes the colliders as they are.
bool colliders_find_moved(Colliders* colliders, const Granular& granular);
void colliders_seen_by_particles(Colliders* colliders, const Granular& granular);
// The same for the grains, which see them at once.
void colliders_find_moved_for_grains(Colliders* colliders, const Granular& granular);
// Poses them as they are `before` seconds before the end of the frame.
void colliders_begin_substep(Colliders* colliders, float before, float particle_radius);
// `from`: where they were when the sweep before ended, by slot. Null: grains meet them where this sweep ends, in all
// steps.
void colliders_begin_sweep(Colliders* colliders, float before, float grain_radius, const RigidPose* from,
                           uint32_t steps);
// A pose between two.
ColliderFrame collider_between(const RigidPose& from, const ColliderFrame& to, float share);
RigidPose rigid_pose(const ColliderFrame& frame);
// Whether one that particles see moves, and near the sand.
bool colliders_move_sand(const Granular& granular);
// Whether more than one ball or box alone moves: sand may stand in what does.
bool colliders_may_hold(const Granular& granular);
// Carriers of colliders that have jumped, at the begin of a frame.
void colliders_find_jumps(Colliders* colliders, const Granular& granular);
// Carriers for grains: from these poses, by slot. `moves`: which count as moving even where they stand.
void colliders_find_motions(Colliders* colliders, const RigidPose* from, const uint8_t* moves);
// Where sand met one of `given` last, before this frame.
void colliders_pose_met(const Granular& granular, uint32_t index, ColliderFrame* frame);
// At a frame's end: all go where the app gives them, with velocities `faster` times as large. Carriers of what that
// leaves out for sand.
void colliders_arrive(Colliders* colliders, const Granular& granular, float faster);
// How many seconds sand is behind `given`: it has met the colliders as they were then.
float colliders_behind(const Granular& granular);
// How many metres sand is behind where the app gives the colliders, at the frame's end.
float colliders_lag(const Granular& granular);
// Metres a second that carried sand may gain as velocities become `faster` times as large.
float colliders_gain(const Colliders& colliders, float faster);
// The sub-step under way goes on where its colliders were carried.
void colliders_carry_substep(Colliders* colliders, float faster);
// After saving or restoring, and when the scene was moved by rotation * p + shift.
void colliders_settle(Colliders* colliders, const Granular& granular);
void colliders_move(Colliders* colliders, const Granular& granular, const SceneMove& move);

// Whether a height has changed that counts within so many metres of a place, along the plane.
bool reliefs_changed(const MovedColliders& moved, const float at[3], float within);
// Whether a ball of this radius touches, or touched, what has changed.
bool reliefs_wake(const MovedColliders& moved, const float at[3], float radius);

// Of a collider that is a grid of the app's: that grid, and which state of it. 0: it is none.
FieldGrid grid_of(const sandglass_collider& collider);
uint64_t version_of(const sandglass_collider& collider);
inline bool is_grid(sandglass_shape shape) { return shape == SANDGLASS_SHAPE_FIELD || shape == SANDGLASS_SHAPE_RELIEF; }
// Of a relief: what is known of its cells' changes.
const CellChange* changes_of(const sandglass_collider& relief);
// Whether it is posed from one of these.
bool has_grid(const ColliderFrame& frame, const sandglass_collider& collider);

// Whether a collider has moved, appeared or gone away since sleepers saw it.
bool watch_changed(const Granular& granular, const ColliderWatch& watch);

// Finite, with positive sizes and a usable rotation? Writes the collider with its rotation normalised.
bool collider_accept(const sandglass_collider& collider, sandglass_collider* accepted);
// The collider of the last frame's list at this index as sand meets it. False: it was left out, or there was none.
bool collider_held(const Granular& granular, uint32_t index, sandglass_collider* held);

// Poses each collider as it was `before` seconds before the end of the frame, going back along its velocities, but for
// what slides (Colliders::slides).
void colliders_pose(const sandglass_collider* colliders, uint32_t count, float before, ColliderFrame* frames,
                    const float* const* slides = nullptr);

// ---- Flow (flow.cpp)
//
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

struct EmitterState {
  // Metres that sand has left the nozzle since the last layer, summed up frame by frame.
  double run;
  uint32_t layer;  // layers so far
  // A point of the last layer's lattice as it left the nozzle, world, metres.
  float origin[3];
};

struct Nozzle {
  sandglass_emitter emitter;  // with the speed that it has, and a rotation of length 1
  float axes[3][3];           // local x, y, z in the world
  float shift[2];             // of the coming layer's lattice along x and z, metres
  // Sites of an even layer and of an odd one, not shifted. 0: not counted yet.
  uint32_t sites[2];
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
  // The layer that is being poured, and what of it is added next.
  Sites* sites;
  Batch* batch;
  ColliderFrame* sinks;  // of this frame
  uint32_t emitter_count, sink_count;
  FlowCounts counts;
};

void flow_layout(Flow* flow, const sandglass_granular_desc& desc, Layout* layout);
void flow_reset(Flow* flow, const sandglass_granular_desc& desc);
void flow_restore(Flow* flow, const SavedScene& saved);

// The number of a new item, where there are `count` of its kind already; a number that is free again.
uint32_t flow_take_particle_number(Flow* flow, uint32_t count);
uint32_t flow_take_grain_number(Flow* flow, uint32_t count);
void flow_free_particle_number(Flow* flow, uint32_t number);
void flow_free_grain_number(Flow* flow, uint32_t number);

// Takes a frame's emitters and sinks. Counts those that it leaves out.
void flow_take(Flow* flow, const Granular& granular, const sandglass_frame_input& input, FrameCounts* counts);
// So many seconds of simulated time have passed.
void flow_pass_time(Flow* flow, double seconds);
// Whether a layer comes before the next sub-step.
bool flow_is_due(const Granular& granular);
// m/s of the fastest emitter; 0 without one.
float flow_speed(const Flow& flow);
// The entrance to the scene for what flow has prepared: so many particles, or so many grains (granular.cpp). False: one
// was beyond the coordinate limit, and none came.
struct Inlet {
  void* scene;
};
bool inlet_let_in(const Inlet& inlet, const float* positions, const float* velocities, uint32_t particles,
                  uint32_t grains);
// Lets in the layers that are due. The colliders are those of the coming sub-step.
void flow_emit(Flow* flow, const Granular& granular, const Inlet& inlet, FrameCounts* counts);

// Which of a group's items lie inside the shapes, from the last to the first: an item that moves into the gap of one
// that is taken out has then been looked at already. Returns how many.
uint32_t flow_find_inside(const Granular& granular, const Record* records, uint32_t count, uint32_t first,
                          const ColliderFrame* shapes, uint32_t shape_count, uint32_t found[k_lane_group]);
// The same of what the frame's sinks or the void take: sand that is awake, and grains. Bodies note what of them is
// inside.
uint32_t flow_find_leaving_particles(const Granular& granular, uint32_t first, uint32_t found[k_lane_group]);
uint32_t flow_find_leaving_grains(const Granular& granular, uint32_t first, uint32_t found[k_lane_group]);
// So many were taken out.
void flow_count_removed(Flow* flow, uint64_t particles, uint64_t grains, uint64_t bodies);

}  // namespace sandglass
