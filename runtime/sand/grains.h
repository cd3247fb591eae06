// Layer 4 of granular: the grains, which are what is drawn. They follow the particles in sweeps, and are written to the
// app's buffer.
#pragma once

#include "kernels/kernels.h"
#include "runtime/frame/governor.h"
#include "runtime/frame/layout.h"
#include "runtime/sand/solver.h"

namespace sandglass {

struct Granular;

// ---- Grains (grain_records.cpp)
//
// The grains: what is drawn. They follow a snapshot of the particles.

constexpr float k_support_radii = 3.0f;  // h = 3r

// A copy of the particles for a sweep. While the sweep goes on, the particles go on too.
struct Snapshot {
  Particle* particles;  // in sorted order
  float* positions[3];  // x, y and z of the same; those of bodies lie far from everything
  CellSort sort;        // cells as wide as the support radius
};

struct Grains {
  Grain* records;
  uint32_t count;
  CellSort sort;
  Snapshot snapshot;
};

// particle_rows: room for particles and padding.
void grains_layout(Grains* grains, const sandglass_granular_desc& desc, uint32_t particle_rows, Layout* layout);
// What a sort of the grains needs besides them. Nothing is kept there from sort to sort.
void grains_sort_layout(Grains* grains, const sandglass_granular_desc& desc, Layout* layout);
void grains_reset(Grains* grains);
void grains_restore(Grains* grains, const SavedScene& saved);
void grains_move(Grains* grains, const SceneMove& move);
void grains_append(Grains* grains, const float position[3], const float velocity[3], uint32_t number);
// Takes grain i out; the last one moves into its place.
void grains_remove(Grains* grains, uint32_t i);

// The sorts of a sweep, in units. A `run` function is true once its sort is done.
void grains_begin_snapshot(Grains* grains, const Granular& granular);
bool grains_run_snapshot(Grains* grains, const Granular& granular);
void grains_begin_sort(Grains* grains, const Granular& granular);
bool grains_run_sort(Grains* grains, const Granular& granular);

// ---- GrainSleep (grain_records.cpp)
//
// Sleep of the grains: which of them a sweep refines. A group of 16 grains, neighbours in storage and so mostly in
// space, is left out when three things hold: all of it has kept still for some sweeps, no particle that moves is near
// enough to be in its sums (ParticleMotion), and no collider that moved since the last sweep comes near.
//
//   triage   lists every group for the refinement or leaves it out
//
// The refinement itself leaves a still grain where it is while no particle in its sums moves, so leaving its group out
// changes no bit. With the dissertation's rule every step looks the particles up, and no group is left out.

constexpr uint8_t k_tile_made = 2;
struct GrainSleep {
  uint32_t* groups;  // numbers of the groups that the sweep refines
  uint8_t* still;    // one a group: all its grains keep still; k_tile_made: so long that its tile is right
  Sleeper* tiles;    // one a group: the sphere that holds its grains
  uint32_t group_count;
  uint32_t still_groups;  // that the last triage found
  // Sorting or removal has changed the groups since the last triage: `still` is of other groups.
  bool groups_changed;
  bool all_asleep;  // the last sweep refined no grain, and all particles slept
  bool wakes;       // the next triage wakes every grain
  bool waking;      // the triage under way does
};

void grain_sleep_layout(GrainSleep* sleep, const sandglass_granular_desc& desc, Layout* layout);
void grain_sleep_reset(GrainSleep* sleep);
// Every grain wakes in the next sweep, group by group.
void grain_sleep_wake_all(GrainSleep* sleep);
// Nothing is remembered of which groups keep still, and nothing is left to wake. Between sweeps.
void grain_sleep_settle(GrainSleep* sleep, const Granular& granular);

// The grains are in another order; `count` of them came, as the last ones; or some were taken out.
void grain_sleep_regrouped(GrainSleep* sleep);
void grain_sleep_added(GrainSleep* sleep, const Granular& granular, uint32_t count);
void grain_sleep_removed(GrainSleep* sleep);
// Grains of these groups were carried.
void grain_sleep_carried(GrainSleep* sleep, uint32_t begin, uint32_t end);
// A sweep is complete. at_rest: it refined no grain, and all particles sleep.
void grain_sleep_followed(GrainSleep* sleep, bool at_rest);

// Whether grains that all sleep on sleeping particles have nothing to follow. A collider that has changed ends that.
bool grain_sleep_skips_time(GrainSleep* sleep, const Granular& granular);

// The phases of a sweep. A `run` function is true once its phase is done.
uint32_t grain_sleep_items(const Granular& granular);  // of the next unit
void grain_sleep_begin_triage(GrainSleep* sleep);
bool grain_sleep_run_triage(GrainSleep* sleep, const Granular& granular, uint32_t* cursor);

// ---- Output (grain_records.cpp)
//
// The output: grains are written to the app's buffer, at the end of each frame, whatever the budget: those of groups that
// have changed since that buffer was written, or all where the app does not say when that was.

struct Output {
  const sandglass_frame_input* input;  // of this frame
  uint32_t cursor;                     // next grain, then next free number
  uint32_t* stamps;                    // one a group: the frame in which it last changed
  uint32_t frame;                      // counts all frames
  uint32_t oldest;                     // groups with this stamp or a later one are written; 0: all are
  // The last frame in which some grain changed, and in which all may have: their values, or their groups.
  uint32_t last_change, all_since;
  // Some grain, and all grains, in this frame or since the last one.
  bool moved, all_changed;
  uint64_t version;
};

void output_layout(Output* output, const sandglass_granular_desc& desc, Layout* layout);
void output_begin_frame(Output* output, const sandglass_frame_input* input);
void output_end_frame(Output* output);
// So many groups moved; grains are in other groups; grains came, went or were all moved.
void output_moved(Output* output, uint32_t groups);
void output_regrouped(Output* output);
void output_changed(Output* output);
// Whether what is drawn may be other than two frames ago.
bool output_is_moving(const Output& output);
// What was written is out of date.
void output_restart(Output* output);

// The stage (granular.cpp).
bool output_next(const Granular& granular, WorkUnit* unit);
void output_run(Output* output, const Granular& granular);
uint32_t output_forecast(const Granular& granular, Forecast* entries);

// ---- GrainCarry (grain_carry.cpp)
//
// A sweep takes grains to where sand was when its snapshot was taken. Since then colliders have gone on, in simulated time
// and without (Carry, in solver.h). So a grain is drawn where the motion of its collider since then takes it. What of
// that motion took no time is taken into the records before the next sweep looks at them; the rest that sweep finds.
// Who holds a grain is as for particles, and is looked up once a sweep, where some collider has gone on at all.
//
// In a sweep a group of grains has three states: as the last sweep left it, carried, and refined. Two of them can be met at
// a time: the groups that the phase has come to have the later one.

struct GrainCarry {
  // The slot of the collider that holds each grain.
  uint8_t* holders;
  // By slot: where colliders were when sand was as the grains are now, and where carries took them from there; the same
  // for the sweep under way.
  RigidPose *met, *carried, *next_met, *next_carried;
  // By slot, for both: 1 where the collider has moved since.
  uint8_t *moves, *next_moves;
  // By slot, from where grains are to where they are drawn. [1]: of groups with the later state.
  RigidMotion* motions[2];
  // For both states: grains are still to be moved by a carry.
  bool pending, next_pending;
  // This frame's motions are known; some of them move grains.
  bool known, drawn;
  // Groups whose holders are not known.
  uint32_t unknown;
  // At the frame's end: the next grain whose holder is looked up, and how many were.
  uint32_t cursor, looked;
};
struct GrainStance {
  const RigidPose* met;
  const uint8_t* moves;
};

// The motions by which grains are drawn elsewhere than their records say.
constexpr uint8_t k_grain_holders = 254;  // slots that can hold one; a higher number stands for none
struct GrainMotions {
  const uint8_t* holders;  // null: all are drawn where they are
  const RigidMotion* motions[2];
  uint32_t moved;

  const RigidMotion* of(uint32_t i) const {
    return holders == nullptr || holders[i] >= k_grain_holders ? nullptr : &motions[i < moved ? 1 : 0][holders[i]];
  }
};

void grain_carry_layout(GrainCarry* carry, const sandglass_granular_desc& desc, Layout* layout);
void grain_carry_reset(GrainCarry* carry, const Granular& granular);
// From now on grains are drawn where their records have them.
void grain_carry_settle(GrainCarry* carry, const Granular& granular);
// The holders of grains from the group of `first` on are not known any more: other grains stand there now.
void grain_carry_forget(GrainCarry* carry, const Granular& granular, uint32_t first);
// All grains are in other groups, or will be.
void grain_carry_regrouped(GrainCarry* carry, const Granular& granular);
// A unit of a sweep has refined these grains: their holders are not known any more.
void grain_carry_refined(GrainCarry* carry, const Granular& granular, uint32_t begin, uint32_t end);
// The frame's colliders are known, but nobody was carried yet.
void grain_carry_begin_frame(GrainCarry* carry, const Granular& granular);
void grain_carry_begin_sweep(GrainCarry* carry, const Granular& granular);
void grain_carry_complete(GrainCarry* carry);
// Particles were carried.
void grain_carry_note(GrainCarry* carry, const Granular& granular);

// Grains before this one have the later state.
uint32_t grain_carry_moved(const Granular& granular);
// Where colliders were when grains had their state. `moved`: the later one.
GrainStance grain_carry_stance(const Granular& granular, bool moved);
// The carriers go from there: takes their motions. False: none goes on that holds grains, as a hand over sand does not.
bool grain_carry_take_motions(GrainCarry* carry, const Granular& granular, bool moved);
// Finds holders of grains of one state, at most a unit of them. Returns the next grain.
uint32_t grain_carry_find(GrainCarry* carry, const Granular& granular, uint32_t begin, uint32_t end);
// A unit of the phase that takes carries into the records. Whether a record has changed.
bool grain_carry_take(GrainCarry* carry, const Granular& granular, uint32_t begin, uint32_t end);
// That phase is done.
void grain_carry_taken(GrainCarry* carry);

// At a frame's end: what must be known before grains are written.
bool grain_carry_is_due(const Granular& granular);
void grain_carry_begin(GrainCarry* carry, const Granular& granular, bool any);
void grain_carry_found(GrainCarry* carry, uint32_t cursor);
GrainMotions grain_carry_motions(const Granular& granular);

// ---- ParticleMotion (motion_grid.cpp)
//
// The motion of the particles during a sweep, on the nodes of a sparse grid, for the grains to read (kernels.h). What
// counts is a particle's displacement since the last sweep, at the place where it began. So one sweep a frame follows
// as closely as several that use the velocities at their ends.
//
//   scatter  the particles of the snapshot, in their order
//   join     each block gets the nodes of the next blocks that its cells reach

// Only what a grain needs is made. Which places particles move near is known before the triage; and where few groups
// are refined, blocks far from them are left out.

struct Place {
  float position[3];
};

struct PlaceOfBlock {
  int32_t at[3];
};

struct ParticleMotion {
  MotionGrid grid;
  // Cells of two nodes a side in which something moves that a grain may read, and the nodes that bound them.
  PlaceSet moved;
  int32_t low[3], high[3];
  // The blocks of grains that are refined and those about them; and those of these whose nodes are read.
  PlaceSet wanted;
  PlaceSet read;
  // Most particles moved in the last sweep, or many groups are refined: then the sets are not used.
  bool all_moved, all_wanted;
  uint32_t movers, wanted_groups;
  // The last blocks that were put into `wanted`, by which of their coordinates are odd.
  PlaceOfBlock recent[8];
  // One a number: where the particle was at the last sweep's snapshot, and at that of the sweep under way.
  Place* starts;
  Place* ends;
};

void motion_layout(ParticleMotion* motion, const sandglass_granular_desc& desc, Layout* layout);
// The planes, in which nothing is kept from sweep to sweep.
void motion_planes_layout(ParticleMotion* motion, const sandglass_granular_desc& desc, Layout* layout);
void motion_configure(ParticleMotion* motion, const sandglass_granular_desc& desc);

// How nearly a particle fell freely during `time`: 1 if it did, down to 0. In free fall the velocity at the end exceeds
// the mean by half of what gravity adds in that time.
float motion_free_fall(const float at_end[3], const float mean[3], const float gravity[3], float time);

// A particle that is added, as if it had come here with its velocity.
void motion_add(const ParticleMotion& motion, const Granular& granular, uint32_t number, const float position[3],
                const float velocity[3]);
// The particles from the row `first` on, which were just added, have fallen freely until now.
void motion_fall(const ParticleMotion& motion, const Granular& granular, uint32_t first);
// Of sixteen particles those of the bits were carried: that is no motion for grains to follow.
void motion_carry(const ParticleMotion& motion, const Granular& granular, const Particle* records, uint32_t which,
                  const RigidMotion& carrier);
// The next sweep covers what the particles do from now on: the grains have caught up.
void motion_begin_here(const ParticleMotion& motion, const Granular& granular);
// Nothing is remembered of how many particles moved.
void motion_forget(ParticleMotion* motion);
// The sweep under way is complete.
void motion_complete(ParticleMotion* motion);

// The phases of a sweep. A `run` function runs a unit, and is true once its phase is done.
// `time`: simulated, seconds.
void motion_begin(ParticleMotion* motion, const Granular& granular);
// The velocity of a particle in the snapshot becomes the mean one since the last sweep. The table of blocks is emptied
// along with that.
bool motion_measure(ParticleMotion* motion, const Granular& granular, uint32_t* cursor);
uint32_t motion_items(const Granular& granular);                        // of the next unit
uint64_t motion_items_of_a_sweep(const Granular& granular, bool even);  // as many blocks as the last sweep had
bool motion_run_scatter(ParticleMotion* motion, const Granular& granular, uint32_t* cursor);
bool motion_run_join(ParticleMotion* motion, const Granular& granular, uint32_t* cursor);
bool motion_run_count(ParticleMotion* motion, const Granular& granular, uint32_t* cursor);
bool motion_run_smooth(ParticleMotion* motion, const Granular& granular, uint32_t* cursor);

// A block whose own nodes are complete finds the blocks about it, and gets its records if they are read.
void motion_join(MotionGrid* grid, uint32_t number, bool is_read = true);
// A block gets its density, once all grains in it and in the blocks about it are counted.
void motion_smooth(const MotionGrid& grid, uint32_t number);

// Whether a particle moves so near to a grain of a group that the sums at it may change. `tile` holds the group.
bool motion_near(const ParticleMotion& motion, const Granular& granular, uint32_t group, const Sleeper& tile);
// Before the triage. If the last sweep refined many groups, this one will, too: then all blocks are made.
void motion_begin_wanting(ParticleMotion* motion, const Granular& granular);
// The group is refined.
void motion_want(ParticleMotion* motion, const Granular& granular, uint32_t group);

// ---- Sweep (sweep.cpp)
//
// The grains' stage. A sweep is one pass of the refinement over all grains (4.39-4.44): a snapshot of the particles is
// sorted by cells of the support radius, the grains are sorted anew every few sweeps, and those that are not asleep are
// moved unit by unit. A sweep may take several frames, and covers all the simulated time that the grains lag behind at
// its begin, in up to k_sweep_steps_max steps. One machine says which phase follows which (sweep.cpp).

constexpr uint32_t k_sweep_steps_max = 4;  // and frames that a sweep may cover
// Sweeps in a row that a grain keeps still before it may sleep; the apex of a flight is shorter.
constexpr float k_patience_sweeps = 16.0f;

// In the order in which they run.
enum class SweepPhase : uint32_t {
  idle,      // between sweeps
  snapshot,  // copies the particles, sorted by cell; they wait meanwhile
  carry,     // takes into the grains what carried them, where something did
  sort,      // the grains by cell, every few sweeps
  triage,    // which groups of grains are refined
  scatter,   // the particles' motion to the nodes of a grid
  join,      // its blocks
  count,     // the grains in its cells
  smooth,    // makes their density of it
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
  // A sweep was late: from then on grains meet colliders in each step, as these may go farther in a sweep than a wall
  // is thick.
  bool late;
};

void sweep_reset(Sweep* sweep);
// Nothing is remembered of the grains' order, and the next sweep does not push them apart. No sweep may be under way.
void sweep_forget(Sweep* sweep);
Stage granular_grain_stage(Granular* granular);

// Runs the sweep under way to its end.
void sweep_finish(Granular* granular);

// A snapshot under way ends.
void sweep_end_snapshot(Granular* granular);

// Whether a sweep is under way that has its snapshot: what sand does from now on is for the next sweep.
bool sweep_has_snapshot(const Granular& granular);
// Whether grains may be added: no phase is under way that would have to begin again.
bool sweep_takes_grains(const Granular& granular);
// Between frames: the sweep under way ends, so that all grains have one state.
void sweep_end(Granular* granular);
// Particles or grains were added or removed: the sweep under way takes that into account.
void sweep_particles_changed(Sweep* sweep);
void sweep_grains_added(Granular* granular, uint32_t count);
void sweep_grains_removed(Granular* granular);

}  // namespace sandglass
