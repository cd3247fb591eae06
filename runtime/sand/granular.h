// Granular material: the state of a scene's sand, put together from its parts, and what the scene does with it.
//
//   particles   physics          [sort, lists], contacts, bodies     substep.cpp   Alg. 4, in sub-steps
//   grains      what is drawn    snapshot, [sort], refine            sweep.cpp     (4.39-4.44), in sweeps
//   output      grains into the app's buffer                         grain_records.cpp  mandatory, at a frame's end
//
// Each of the three is a stage: a sequence of work units, after each of which a frame may end. Four headers hold the
// parts in layers; a part is a section there, which names the source file of the part.
//
// A part lays out its own memory, resets itself and changes only itself: its functions take it as a pointer and the
// rest as `const Granular&`. So what one part does to another is a call, made where the whole is put together: here, in
// edit_*.cpp, and in the two machines, substep.cpp and sweep.cpp (tests/sand/owners.py). The records of particles and
// grains are what all of them work on.
#pragma once

#include "runtime/sand/grains.h"

namespace sandglass {

// Kinds of work unit, for the governor's predictor.
enum : uint32_t {
  k_unit_particle_sort,
  k_unit_lists,
  k_unit_stabilise,
  k_unit_solve,
  k_unit_slack,
  k_unit_colours,
  k_unit_predict,
  k_unit_pairs,
  k_unit_complete,
  k_unit_snapshot,
  k_unit_motion,
  k_unit_grain_sort,
  k_unit_refine,
  k_unit_output,
  k_unit_touch,
  k_unit_wake,
  k_unit_sleep,
  k_unit_triage,
  k_unit_bodies,
  k_unit_drain,
  k_unit_departed,
  k_unit_carry,
  k_unit_push,
  k_unit_grain_carry,
  k_granular_kinds
};
static_assert(k_granular_kinds == k_sand_kinds);

// Counts of the frame under way. Each part of the sand counts what it finds.
struct FrameCounts {
  uint32_t substeps, list_builds;
  uint32_t dropped_contacts;  // neighbours for which a list had no room
  uint32_t quarantined;       // particles and grains that were not finite or out of bounds
  // What the frame was given and could not use.
  uint32_t ignored_colliders, ignored_emitters, ignored_sinks;
  uint32_t denied_particles;  // for which emitters found no room or no free place
  uint32_t carries;           // by colliders that went on without time for sand
  // How often the particles came to another state.
  uint32_t moments() const { return substeps + carries; }
};

static inline void count_lists(FrameCounts* counts, uint32_t dropped, bool built) {
  counts->dropped_contacts += dropped;
  counts->list_builds += built ? 1u : 0u;
}

struct Granular {
  // As the app described it.
  sandglass_granular_desc desc;
  float gravity[3];
  float gravity_length;
  float resting_gravity[3];  // under which all that sleeps fell asleep, nearly
  uint32_t unit;             // items of a work unit
  const Kernels* kernels;
  sandglass_parallel parallel;

  // The particles.
  Particles particles;
  Neighbours neighbours;
  PairColours colours;
  Boundary boundary;
  Bodies bodies;
  Sleep sleep;
  Departed departed;
  Substep substep;
  Carry carry;
  Contacts contacts;

  // The grains.
  Grains grains;
  ParticleMotion motion;
  GrainSleep grain_sleep;
  GrainCarry grain_carry;
  Sweep sweep;
  Output output;

  // Both.
  SimulatedTime time;
  Colliders colliders;
  Flow flow;
  FrameCounts counts;
};

// Checks the description; a sentence, or null.
const char* granular_refuse(const sandglass_granular_desc& desc);

// Shared by size and creation: lays out every region the description needs.
void granular_layout(Granular* granular, const sandglass_granular_desc& desc, Layout* layout);

// After layout: takes the rest of the description, and chooses what it leaves to the library.
void granular_configure(Granular* granular, const sandglass_scene_desc& desc, const Kernels* kernels);

// Whether this gravity is finite and not too large.
bool gravity_fits(const float gravity[3]);
// Sets gravity and the limits of sub-steps that follow from it, and wakes what has to wake.
void granular_set_gravity(Granular* granular, const float gravity[3]);
// Wakes what sleeps where gravity differs by enough from that under which it fell asleep.
void granular_feel_gravity(Granular* granular);
// From now on this is the gravity under which what sleeps fell asleep.
void granular_set_resting_gravity(Granular* granular, const float gravity[3]);
// Sets friction. Wakes nobody.
void granular_take_friction(Granular* granular, float static_friction, float kinetic_friction);

// To the state without material. The description and the regions are in place.
void granular_reset(Granular* granular);

// Between frames: the grains' sweep is finished, the sub-step under way is abandoned or ended, and lists and orders
// that can be found again are forgotten. Nothing is remembered then that a restored scene would not know.
void granular_settle(Granular* granular);

// Takes a frame's input: colliders, emitters, sinks and time.
void granular_begin_frame(Granular* granular, const sandglass_frame_input* input);
void granular_end_frame(Granular* granular);
// A unit of the carry: sand that colliders hold goes with them where they go on without time for it.
void granular_carry(Granular* granular);
// The motions of colliders since grains were as they are. `moved`: for grains with the later state of a sweep, else for
// the others. False: there is none.
bool granular_find_grain_motions(Granular* granular, bool moved);
// While all sleep, time passes without sub-steps: then true.
bool granular_skip_time(Granular* granular);
// Lets in the layers that are due.
void granular_pour(Granular* granular);

// Everything wakes. Only outside a frame.
void granular_wake_all(Granular* granular);
// From now on no particle counts as departed. Finds what rests.
void granular_forget_departed(Granular* granular);
// Puts inert particles with empty lists behind the last one, so that kernels may process whole vectors.
void granular_seal(Granular* granular);

// Takes particle i, grain i or a body with its particles out. The last one moves into its place. No phase of the bodies
// may be under way.
void granular_take_out_particle(Granular* granular, uint32_t i);
void granular_take_out_grain(Granular* granular, uint32_t i);
void granular_take_out_body(Granular* granular, uint32_t index);
// Takes out what of the group that begins at `first` is in a sink, or has fallen or flown too far. Returns how many.
uint32_t granular_drain_particles(Granular* granular, uint32_t first);
uint32_t granular_drain_grains(Granular* granular, uint32_t first);
// After particles were taken out: their indices have changed.
void granular_after_removal(Granular* granular);

// What the app does between frames (edit_*.cpp).
sandglass_status granular_add(Granular* granular, const sandglass_points& particles, const sandglass_points& grains,
                              const char** reason);
// From a nozzle, within a frame. False: there is no room.
bool granular_pour_in(Granular* granular, const sandglass_points& particles, const sandglass_points& grains);
sandglass_status granular_remove(Granular* granular, const sandglass_collider* region, uint32_t* particles,
                                 uint32_t* grains, const char** reason);
sandglass_status granular_set_boundary(Granular* granular, const float* positions, uint32_t count, const char** reason);
void granular_set_friction(Granular* granular, float static_friction, float kinetic_friction);
sandglass_status granular_move(Granular* granular, const float rotation[4], const float translation[3],
                               const char** reason);
sandglass_status granular_add_body(Granular* granular, const sandglass_body* body, uint32_t* index,
                                   const char** reason);
sandglass_status granular_remove_body(Granular* granular, uint32_t index, const char** reason);
sandglass_status granular_set_body(Granular* granular, uint32_t index, const sandglass_body_pose* pose,
                                   const char** reason);
sandglass_status granular_push_body(Granular* granular, uint32_t index, const float impulse[3], const float* point,
                                    const char** reason);
void granular_body_pose(const Granular& granular, uint32_t index, sandglass_body_pose* pose);
sandglass_status granular_save(Granular* granular, void* data, uint64_t bytes, uint64_t* written, const char** reason);
sandglass_status granular_restore(Granular* granular, const void* data, uint64_t bytes, const char** reason);

// The numbers of the state that a restored scene cannot work out again. Saved as they are.
struct SavedState {
  double debt, slipped, simulated, grain_lag, next_check;
  ShownTime shown;
  FlowCounts flow;
  float low[3], high[3];
  double share, rate;
  float speed_max, frame_step, densest_body, builds_per_substep;
  float resting_gravity[3];
  uint32_t bounds_known, awake, dither;
};
// A saved scene besides its arrays.
struct SavedScene {
  uint32_t particles, free_particles, grains, free_grains, boundary, bodies, body_particles;
  SavedState state;
};
// Saving a settled scene (save.cpp): how many bytes, and the bytes.
uint64_t granular_save_bytes(const Granular& granular);
sandglass_status saved_write(const Granular& granular, void* data, uint64_t bytes, uint64_t* written,
                             const char** reason);
// Whether bytes are a saved scene that this one has room for. Then saved_read reads its arrays and numbers. False: they
// contradict each other.
sandglass_status saved_check(const Granular& granular, const void* data, uint64_t bytes, const char** reason);
bool saved_read(const Granular& granular, const void* data, SavedScene* saved);

// The first particle on a ray (particles.cpp).
void granular_ray(const Granular& granular, const float origin[3], const float direction[3], float reach,
                  sandglass_ray_hit* hit);

// The output's stage. The others stand in solver.h and grains.h.
Stage granular_output_stage(Granular* granular);
Stage granular_carry_stage(Granular* granular);

// Pieces that a work unit is cut into at most.
constexpr uint32_t k_pieces = 8;

// Runs task over [begin, end) cut into at most k_pieces, on the app's pool where there is one. A piece runs once: a
// second call for it does nothing, and what the pool left out runs here.
template <class Task>
void granular_split(const Granular& granular, uint32_t begin, uint32_t end, Task* task) {
  constexpr uint32_t k_worth_sharing = 512;
  struct Job {
    Task* task;
    uint32_t begin, end, piece, pieces;
    uint8_t begun[k_pieces];
    void run(uint32_t index) {
      if (index >= pieces || begun[index] != 0) return;
      begun[index] = 1;
      const uint32_t first = begin + index * piece;
      task->run(index, first, end - first < piece ? end : first + piece);
    }
  };
  if (granular.parallel.run == nullptr || end - begin < k_worth_sharing) {
    task->run(0, begin, end);
    return;
  }
  Job job = {task, begin, end, 0, 0, {}};
  job.piece = ((end - begin + k_pieces - 1) / k_pieces + k_lane_group - 1) / k_lane_group * k_lane_group;
  job.pieces = (end - begin + job.piece - 1) / job.piece;
  granular.parallel.run(
      granular.parallel.user, [](void* context, uint32_t index) { static_cast<Job*>(context)->run(index); }, &job,
      job.pieces);
  for (uint32_t index = 0; index < job.pieces; ++index) job.run(index);
}

}  // namespace sandglass
