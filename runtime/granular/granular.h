// Granular material: the state of a scene's sand and its three stages.
//
//   particles (particles.cpp)  physics: lists -> stabilise -> solve, a sub-step at a time       (low resolution, Alg.
//   4) grains    (grains.cpp)     what is drawn: snapshot of the particles -> sort -> refine      (high
//   resolution, 4.39-4.44) output    (grains.cpp)     grains into the app's buffer; mandatory, last
//
// Every stage is a resumable sequence of work units. Particles are double-buffered: `records[0]` is always the last
// completed sub-step, so a frame may end between any two units and the scene is valid. Particles and grains are kept
// sorted by cell; their numbers (the order in which the app added them) travel with them.
#pragma once

#include "kernels/kernels.h"
#include "runtime/core/governor.h"
#include "runtime/core/layout.h"
#include "runtime/granular/cell_sort.h"
#include "runtime/granular/colliders.h"

namespace sandglass {

// Kinds of work unit, for the governor's predictor.
enum : uint32_t {
  k_unit_particle_sort,
  k_unit_lists,
  k_unit_stabilise,
  k_unit_solve,
  k_unit_snapshot,
  k_unit_grain_sort,
  k_unit_refine,
  k_unit_output,
  k_unit_touch,
  k_unit_wake,
  k_unit_rest,
  k_unit_triage,
  k_unit_bodies,
  k_unit_drain,
  k_granular_kinds
};

enum class ParticlePhase : uint32_t {
  idle,
  sort,
  lists,
  stabilise,
  solve,
  bodies,
  touch,
  wake,
  rest,
  drain,
  wake_lists
};
enum class GrainPhase : uint32_t { idle, snapshot, sort, mark, triage, refine, drain };

constexpr double k_rest_period = 0.02;  // seconds of simulated time between looks at who rests and what sinks take

// Sweeps in a row that a grain keeps still before it may sleep; the apex of a flight is shorter.
constexpr float k_patience_sweeps = 16.0f;

// Whether the particles of a record group are computed. waking: awake, but without neighbour lists yet.
enum class GroupState : uint8_t { asleep, active, waking };

// What is known of a particle's rest; kept by number.
struct Rest {
  float anchor[3];     // where it was when it last moved on
  uint32_t quiet;      // checks in a row that found it near the anchor; k_asleep: it sleeps
  uint32_t body_slot;  // of a body's particle: its place in body_rest and body_rows
};
constexpr uint32_t k_asleep = ~0u;

struct RigidBody {
  uint32_t first, count;  // slots of its particles
  double center[3];       // of mass
  double rotation[4];     // from the rest shape
  float linear[3], angular[3];
};

// Sums over a body's particles, and the motion that they give.
struct BodyMatch {
  double shift[3], stabilised[3], offset[3], a[9];
  double spread[9], spin[3];  // sums of r r^T and of r x displacement
  double turn[4];
};

struct EmitterState {
  double run;      // metres that sand has come since the last layer
  uint32_t layer;  // layers so far
};

// Colliders that moved, appeared or went away: where they were and where they are.
struct MovedColliders {
  ColliderFrame* frames;
  float* margins;  // metres
  uint32_t count;
};

struct Granular {
  sandglass_granular_desc desc;
  float gravity[3];
  float gravity_length;
  float substep_max, substep_min;
  uint32_t unit;
  const Kernels* kernels;
  sandglass_parallel parallel;

  // Capacities rounded up to whole vectors.
  uint32_t particle_rows;  // records before the boundary
  uint32_t inert;          // index of the inert record, after the boundary

  // Particles. records[0]: the state; [1]: where a pass writes; [2]: only when a sub-step has more than one pass.
  Particle* records[3];
  float* positions[3];
  uint32_t* lists;
  uint8_t* counts;
  CellSort particle_sort;
  uint32_t particle_count;

  // Sleep. Work is done on record groups (16 records) with an awake particle; see rest.cpp.
  uint32_t* active_groups;
  GroupState* group_states;
  uint8_t* touched;  // groups that the last sub-step saw run into sleepers
  Rest* rest;
  uint32_t active_count, awake_count;
  uint32_t waking_count;  // groups that wait for lists
  double next_rest;       // simulated time of the next check
  bool adopts_colliders;  // the next frame's are taken for those of the frame before: nothing has moved
  bool touch_due, wake_due, rest_due;
  sandglass_collider* colliders_before;  // of the last frame
  uint32_t collider_before_count;
  MovedColliders moved, sweep_moved;

  // Rigid bodies (bodies.cpp).
  RigidBody* bodies;
  float* body_rest;        // 3 a slot: position in the rest shape, from the centre of mass
  uint32_t* body_rows;     // the record of each slot
  uint32_t* body_numbers;  // the particle number of each slot
  uint32_t body_count, body_particle_count;
  float densest_body;                   // relative to sand
  uint32_t body_cursor, body_particle;  // progress of the phase
  bool body_applies;
  BodyMatch match;

  // Coming and going (flow.cpp). Numbers of removed items are used again, the last removed first.
  uint32_t* free_particles;
  uint32_t* free_grains;
  uint32_t free_particle_count, free_grain_count;
  sandglass_emitter* emitters;
  EmitterState* emitter_states;
  ColliderFrame* sinks;
  uint32_t emitter_count, sink_count;
  bool drain_due;
  uint64_t emitted_particles, emitted_grains, removed_particles, removed_grains, denied_particles;

  // Boundary: fixed, sorted once.
  float* boundary_positions[3];
  CellSort boundary_sort;
  uint32_t boundary_count;

  // Grains. grains[0]: the state; [1]: sorting target.
  Grain* grains[2];
  Particle* snapshot;
  float* snapshot_positions[3];
  CellSort snapshot_sort, grain_sort;
  uint32_t grain_count;

  // Sleep of the grains, by groups of 16; see grain_rest.cpp.
  uint32_t* grain_groups;   // those that the sweep refines
  uint8_t* grain_still;     // as the refinement left it
  Sleeper* grain_tiles;     // one a group: the sphere that holds its grains
  uint8_t* awake_cells[2];  // cells of the snapshot near an awake particle
  sandglass_collider* sweep_colliders_before;
  uint32_t grain_group_count, sweep_collider_before_count;
  uint32_t mark_pass;
  uint32_t still_groups;  // after the last sweep
  bool groups_changed;    // sorted since the last triage: grain_still is of other groups
  bool grains_asleep;     // the last sweep found nothing to do

  // Colliders of the frame, and posed for the sub-step and for the sweep.
  sandglass_collider* colliders;
  ColliderFrame* substep_colliders;
  ColliderFrame* sweep_colliders;
  uint32_t collider_count;
  uint32_t solid_count;  // those that particles see, which come first

  // Progress of the particles.
  ParticlePhase phase;
  uint32_t cursor;      // item within the phase
  uint32_t pass;        // stabilisation or solver iteration
  uint32_t iterations;  // solver iterations of the sub-step under way
  bool lists_valid;
  bool bounds_known;
  float list_slack;       // metres that particles may still move before the lists are stale
  float last_spread;      // half the range of the last sub-step's displacements, metres
  float last_substep;     // seconds
  ContactExtent extent;   // of the sub-step under way
  float low[3], high[3];  // bounds of the particles
  float speed_max;
  uint32_t interval_left;  // sub-steps left before the grains may follow
  float substep;           // length of each
  uint32_t dither;         // phase of the sequence by which gravity varies (particles.cpp)
  float frame_step;        // the app's time step
  double owed;             // simulated time to make up
  double interval_owed;    // what is owed once the interval is complete
  double slipped;          // simulated time asked for that nobody makes up any more: slow motion
  double simulated;
  double unswept;  // simulated time that the grains have not followed yet

  // Progress of the grains.
  GrainPhase grain_phase;
  uint32_t grain_cursor;
  float sweeps_since_sort;  // a sweep over a part of the grains counts for that part
  float sweep_step;
  uint32_t sweep_steps;
  double sweep_time;  // simulated time covered by the sweep under way

  // Progress of the output.
  const sandglass_frame_input* input;
  uint32_t output_cursor;

  // This frame's counts.
  uint32_t substeps, list_builds, dropped_contacts, quarantined, ignored_colliders;
  float builds_per_substep;  // recent average, for the forecast
};

// Shared by size and creation: lays out every region the description needs.
void granular_layout(Granular* granular, const sandglass_granular_desc& desc, Layout* layout);

// Checks the description; a sentence, or null.
const char* granular_refuse(const sandglass_granular_desc& desc);

// To the state without material. The description and the regions are in place.
void granular_reset(Granular* granular);

sandglass_status granular_add(Granular* granular, const float* particles, const float* particle_velocities,
                              uint32_t particle_count, const float* grains, const float* grain_velocities,
                              uint32_t grain_count, const char** reason);
sandglass_status granular_set_boundary(Granular* granular, const float* positions, uint32_t count, const char** reason);

// Takes a frame's input: colliders and time.
void granular_begin_frame(Granular* granular, const sandglass_frame_input* input);

// Sleep and waking (rest.cpp).
void granular_find_moved_colliders(Granular* granular);  // begin_frame: what changed since the last frame wakes sand
void granular_settle(Granular* granular);                // after a sub-step: enters the next phase that is due
void granular_skip_rest(Granular* granular);             // while all sleep, time passes without sub-steps
void granular_wake_all(Granular* granular);              // outside a frame
void granular_collect_groups(Granular* granular);        // active_groups from group_states
void granular_run_touch(Granular* granular);
void granular_run_wake(Granular* granular);
void granular_run_rest(Granular* granular);
void granular_run_wake_lists(Granular* granular);
uint32_t granular_rest_items(const Granular& granular);  // of the unit that runs next in one of these phases
float granular_speed_scale(const Granular& granular);    // sqrt(g d), m/s; weightless scenes take the Earth's g
float granular_wake_speed(const Granular& granular);

void granular_seal_particles(Granular* granular);  // inert records after the last particle
void granular_sleep_particle(Granular* granular, uint32_t record);

// Coming and going (flow.cpp).
void granular_take_flow(Granular* granular, const sandglass_frame_input* input);  // begin_frame
bool granular_can_emit(const Granular& granular);
void granular_emit(Granular* granular, double seconds);
uint32_t granular_drain_items(const Granular& granular);
void granular_run_drain(Granular* granular);
void granular_run_grain_drain(Granular* granular);
sandglass_status granular_remove(Granular* granular, const sandglass_collider* region, uint32_t* particles,
                                 uint32_t* grains, const char** reason);

// Moving, saving, restoring (live.cpp).
uint64_t granular_save_bytes(const Granular& granular);
sandglass_status granular_save(Granular* granular, void* data, uint64_t bytes, uint64_t* written, const char** reason);
sandglass_status granular_restore(Granular* granular, const void* data, uint64_t bytes, const char** reason);
sandglass_status granular_move(Granular* granular, const float rotation[4], const float translation[3],
                               const char** reason);
void granular_finish_sweep(Granular* granular);         // grains.cpp
double granular_lag_limit(const Granular& granular);    // as much as the next sweep may cover, after the one under way
bool granular_grains_behind(const Granular& granular);  // at that limit: the particles wait
void granular_sort_boundary(Granular* granular, uint32_t count);  // of the records where the boundary stands
void granular_move_body(Granular* granular, uint32_t index, const double rotation[4], const float shift[3]);

// Rigid bodies (bodies.cpp).
sandglass_status granular_add_body(Granular* granular, const sandglass_body* body, uint32_t* index,
                                   const char** reason);
void granular_body_pose(const Granular& granular, uint32_t index, sandglass_body_pose* pose);
void granular_find_body_rows(Granular* granular);
bool granular_begin_bodies(Granular* granular);  // false: no body is awake
uint32_t granular_body_items(const Granular& granular);
bool granular_run_bodies(Granular* granular);  // true once all are done
void granular_rest_bodies(Granular* granular, uint32_t patience);

// Sleep of the grains (grain_rest.cpp).
void granular_begin_mark(Granular* granular);  // enters the first phase that decides which groups a sweep refines
void granular_run_mark(Granular* granular);
void granular_run_triage(Granular* granular);
uint32_t granular_mark_items(const Granular& granular);
void granular_find_moved(const sandglass_collider* before, uint32_t before_count, const sandglass_collider* now,
                         uint32_t now_count, float margin, MovedColliders* moved);

// Before material changes: the sub-step under way starts again from the last state, or ends where bodies have already
// moved (particles.cpp).
void granular_abandon_substep(Granular* granular);

// Neighbour lists of the active groups in the range [begin, end) of records (particles.cpp).
uint32_t granular_build_lists(Granular* granular, uint32_t begin, uint32_t end);

// The three stages.
Stage granular_particle_stage(Granular* granular);
Stage granular_grain_stage(Granular* granular);
Stage granular_output_stage(Granular* granular);

// Runs task over [begin, end) cut into at most 8 pieces, on the app's pool where there is one.
template <class Task>
void granular_split(const Granular& granular, uint32_t begin, uint32_t end, Task* task) {
  constexpr uint32_t k_pieces = 8, k_worth_sharing = 512;
  struct Job {
    Task* task;
    uint32_t begin, end, piece;
  } job = {task, begin, end, end - begin};
  if (granular.parallel.run == nullptr || end - begin < k_worth_sharing) {
    task->run(0, begin, end);
    return;
  }
  job.piece = ((end - begin + k_pieces - 1) / k_pieces + k_lane_group - 1) / k_lane_group * k_lane_group;
  const uint32_t pieces = (end - begin + job.piece - 1) / job.piece;
  granular.parallel.run(
      granular.parallel.user,
      [](void* context, uint32_t index) {
        const Job& j = *static_cast<const Job*>(context);
        const uint32_t first = j.begin + index * j.piece;
        j.task->run(index, first, j.end - first < j.piece ? j.end : first + j.piece);
      },
      &job, pieces);
}

}  // namespace sandglass
