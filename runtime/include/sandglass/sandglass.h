/* Sandglass: sand, light and shadow for augmented reality, inside a fixed slice of every frame.
 *
 * Scenes and granular material, in C; with it come sampling (sampling.h) and signed-distance fields (field.h). Light
 * and shadows stand in headers of their own: light.h, shadow.h, pile_shadow.h. An app
 *
 *   1. fills a sandglass_scene_desc (start from sandglass_scene_desc_default),
 *   2. asks sandglass_scene_bytes how much memory that scene needs,
 *   3. hands one block of that size to sandglass_scene_create,
 *   4. adds material (sandglass_granular_add), sampled by sandglass_sample_* or its own,
 *   5. calls sandglass_scene_frame once a frame, with colliders, a time step and a budget in nanoseconds.
 *
 * After step 3 the library allocates nothing, starts no thread, takes no lock and reads no clock but the one it was
 * handed. There is nothing to destroy: the block is the scene, and it is the caller's.
 *
 * Units, coordinates, the sizes of structs and errors: see types.h, whose rules hold for all functions.
 *
 * Threads. One scene belongs to one thread at a time; different scenes are independent. */
#ifndef SANDGLASS_SANDGLASS_H
#define SANDGLASS_SANDGLASS_H

#include "sandglass/field.h"
#include "sandglass/sampling.h"
#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ granular material */

/* How contact corrections of one Jacobi iteration are combined (SPEC 2.1).
 * SMALL_STEP: every correction times one fixed factor, the same on both sides of a pair, so momentum is conserved;
 * needs many small steps and then needs only one iteration (the default). AVERAGED: the total is divided by the number
 * of constraints that acted on the particle, (4.37); `relaxation` multiplies it, and the product is never above 1 per
 * constraint. */
typedef int32_t sandglass_scheme;
enum { SANDGLASS_SCHEME_SMALL_STEP = 0, SANDGLASS_SCHEME_AVERAGED = 1 };

/* How grains blend between the flow and free flight.
 * CONTINUOUS: lambda falls smoothly to 0 inside the material (the default). SOURCE: (4.44) as printed; lambda jumps
 * from 0.298 to 0. */
typedef int32_t sandglass_blend;
enum { SANDGLASS_BLEND_CONTINUOUS = 0, SANDGLASS_BLEND_SOURCE = 1 };

/* How one sub-step is solved. An app leaves this struct as sandglass_scene_desc_default filled it: every measured number
 * and the quality ladder hold for these defaults. Its other values are the solver of the dissertation as printed. They
 * are here so that the library can be compared with it. Frozen: this struct never grows. */
typedef struct sandglass_reference_scheme {
  /* Default: SANDGLASS_SCHEME_SMALL_STEP. */
  sandglass_scheme scheme;
  /* Default: SANDGLASS_BLEND_CONTINUOUS. */
  sandglass_blend blend;
  /* Jacobi iterations a sub-step, 1..64. Default: 1. */
  uint32_t solver_iterations;
  /* Iterations that move overlapping particles apart before the solver runs, 0..8 (Alg. 4, lines 6 to 12). Default: 0. */
  uint32_t stabilisation_iterations;
  /* SMALL_STEP: the factor omega, above 0, at most 0.45. AVERAGED: above 0, at most 2. Default: 0.45. */
  float relaxation;
} sandglass_reference_scheme;

/* Granular material: `particles` carry the physics (low resolution, contacts and friction between equal spheres);
 * `grains` are what is drawn (high resolution, advected by the particles, never colliding with each other). Chapter 4
 * of the source. */
typedef struct sandglass_granular_desc {
  uint32_t particle_capacity;      /* most particles at any time; 0 leaves granular material out: no memory, no time */
  uint32_t grain_capacity;         /* most grains; 0 simulates particles only */
  uint32_t boundary_capacity;      /* most static boundary particles (samples of a fixed surface) */
  uint32_t body_capacity;          /* most rigid bodies; 0..255 */
  uint32_t body_particle_capacity; /* most particles of all bodies together; they count in particle_capacity too */
  uint32_t emitter_capacity;       /* most emitters passed to one frame; 0..64 */
  uint32_t sink_capacity;          /* most sinks passed to one frame; 0..64 */
  uint32_t collider_capacity;      /* most analytic colliders passed to one frame; 0..256 */

  float particle_radius; /* r, metres, above 0; all particles are equal */
  float
      grain_radius; /* metres, above 0, at most r: a grain's centre stays this far outside every collider; 0 = 0.35 r */
  float static_friction;  /* mu_s >= 0; the default of both, 0.14, spreads collapsing columns as far as sand spreads
                           * (Lube 2004): particles do not rotate, which does the work of higher coefficients */
  float kinetic_friction; /* mu_k >= 0; may exceed mu_s (the source's hourglass does) */
  float height_weighting; /* k of SPEC 2.1 (erratum 4.38), dimensionless, 0..1.5; the default, 0.3, is calibrated with
                           * the friction. More carries tall piles with less overlap, and carries inside the sand what
                           * a floor or a wall should carry; 0 conserves momentum pairwise. What it lifts a particle by
                           * is at most twice what gravity takes, so nothing flies up at an impact */

  float courant;     /* C of (4.45), above 0, at most 1; the source's 0.5 */
  float substep_max; /* seconds; longest sub-step; 0 = 0.00871 * sqrt(r/g), the value the default scheme was calibrated
                        at */
  float substep_min; /* seconds; shortest sub-step that (4.45) may ask for; faster particles are slowed to
                        courant*r/substep_min; 0 = substep_max/4 */
  float list_skin; /* neighbour lists reach 2r + list_skin*r; 0.1..1; they are rebuilt before anything outside can touch
                    */

  float sleep_after; /* seconds; particles that stay within 10 % of r of one place for so long sleep, and cost nothing,
                      * until something touches them; 0 = never; at most 5; the default is 0.5 */

  /* Seconds, above 0: the longest step of the grains, Delta t_hr. The default is the dissertation's, 0.008. */
  float refine_step;

  sandglass_reference_scheme reference;
} sandglass_granular_desc;

/* ------------------------------------------------------------------------------------------------ quality */

/* The quality ladder. When a frame's work does not fit its budget, the frame runs at the first rung that does; a rung
 * includes what the rungs above it gave up. Numbers: sandglass bench ladder, a collapsing column of 14,280 particles
 * and 228,480 grains over two seconds; cost relative to the full quality in the same run, overlap in particle radii. */
enum {
  SANDGLASS_LEVEL_FULL = 0,
  SANDGLASS_LEVEL_REFINE_ONCE = 1, /* grains take one step a frame instead of one every refine_step */
  SANDGLASS_LEVEL_KEEP_LISTS = 2, /* neighbour lists are rebuilt after three times the motion that could outdate them */
  SANDGLASS_LEVEL_COARSE = 3,     /* sub-steps 4/3 as long; AVERAGED with several iterations: 3/4 of them */
  SANDGLASS_LEVEL_COARSER = 4,    /* sub-steps twice as long; AVERAGED with several iterations: half of them */
  SANDGLASS_LEVEL_SLOW_MOTION = 5, /* as much simulated time as fits; the rest is time_debt */
  SANDGLASS_LEVEL_COUNT = 6
};
typedef struct sandglass_level {
  uint32_t struct_size;
  const char* name;   /* "full" */
  float cost_solver;  /* of the particles, relative to rung 0 */
  float cost_refine;  /* of the grains, relative to rung 0 */
  float overlap_p99;  /* of r: mean over the frames of the 99th percentile over touching pairs of (2r - distance) / r */
  float overlap_mean; /* likewise, of the mean */
  float angle_degrees; /* of the pile at the end */
} sandglass_level;

/* What a rung costs and what its error is, or NULL beyond the last; slow motion has the errors of the rung above it. */
SANDGLASS_API const sandglass_level* sandglass_level_describe(uint32_t level);

/* Its name: sandglass_level_describe(level)->name, or NULL. */
SANDGLASS_API const char* sandglass_level_name(uint32_t level);

/* ------------------------------------------------------------------------------------------------ scene */

typedef struct sandglass_scene_desc {
  uint32_t struct_size;
  sandglass_isa isa;
  uint32_t unit_items; /* particles (or grains) per work unit, 16..65536, a multiple of 16; about 50 us on a phone core
                        * at the default 1024; with a pool of T threads, T times that keeps the pool busy */
  uint32_t finest_level; /* rungs of the quality ladder better than this one are not used, to save energy; 0 by default;
                          * without a clock, the rung that runs */
  float gravity[3];      /* m/s^2; any direction; its length 0 is allowed (then height weighting has no effect) */
  sandglass_clock clock;
  sandglass_parallel parallel;
  sandglass_trace trace;
  sandglass_log log;
  sandglass_granular_desc granular;
} sandglass_scene_desc;

/* Fills *desc with the defaults: gravity (0, -9.81, 0), no clock, no pool, no hooks, no granular capacity, and the
 * calibrated granular parameters for sand of particle radius 0.01 m. The calling app then sets capacities and whatever
 * differs. */
SANDGLASS_API void sandglass_scene_desc_default(sandglass_scene_desc* desc);

typedef struct sandglass_scene sandglass_scene;

/* The exact number of bytes that a scene of this description needs, in *bytes. The same walk over the description lays
 * the scene out, so the two cannot differ. Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_bytes(const sandglass_scene_desc* desc,
                                                                         uint64_t* bytes, const char** reason);

/* Makes a scene in the caller's block; *scene then points into it. The block must be aligned to
 * SANDGLASS_BLOCK_ALIGNMENT, at least sandglass_scene_bytes long, and stay where it is. Nothing outside the block is
 * written, and nothing at all when this fails. Fails with INVALID_ARGUMENT, MEMORY_TOO_SMALL, MEMORY_ALIGNMENT,
 * UNSUPPORTED (isa). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_create(const sandglass_scene_desc* desc, void* block,
                                                                          uint64_t bytes, sandglass_scene** scene,
                                                                          const char** reason);

/* Back to the state just after create: no material, no boundary, time zero, the governor's memory of costs forgotten.
 */
SANDGLASS_API void sandglass_scene_reset(sandglass_scene* scene);

/* Moves everything in the scene rigidly: p becomes rotation * p + translation (either may be NULL: none), velocities
 * turn. For AR relocalisation, and to shift the origin before coordinates grow large; gravity stays as it is. Pass the
 * colliders of the next frame moved likewise: they count as unmoved, so what sleeps goes on sleeping. Fails with
 * INVALID_ARGUMENT, also when something would leave SANDGLASS_COORDINATE_LIMIT; nothing was moved then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_move(sandglass_scene* scene, const float rotation[4],
                                                                        const float translation[3],
                                                                        const char** reason);

/* Saving and restoring, for an app that goes to the background. The bytes hold the material and the time, not the
 * description, colliders, hooks or the governor's memory of costs; they are the same on every instruction set, for
 * little-endian machines. A saved scene and the one restored from the bytes then run on alike, to the bit.
 *
 * save_bytes: how many bytes save would write now. save: writes them; finishes the grains' sweep under way and drops
 * an unfinished sub-step. Fails with INVALID_ARGUMENT or MEMORY_TOO_SMALL.
 *
 * restore: into a scene whose description has the same particle_radius and room enough. The bytes need not be trusted:
 * they are checked, and damage fails with INVALID_ARGUMENT, lack of room with CAPACITY. The scene is then as it was,
 * or, where bytes with a right checksum contradict themselves, reset. */
SANDGLASS_API uint64_t sandglass_scene_save_bytes(const sandglass_scene* scene);
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_save(sandglass_scene* scene, void* data,
                                                                        uint64_t bytes, uint64_t* written,
                                                                        const char** reason);
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_restore(sandglass_scene* scene, const void* data,
                                                                           uint64_t bytes, const char** reason);

/* One named region of the scene's block. */
typedef struct sandglass_region {
  const char* name; /* "granular.particles" */
  uint64_t offset;  /* bytes from the start of the block */
  uint64_t bytes;
} sandglass_region;

/* Number of regions; up to `capacity` of them are written to `regions` (may be NULL with capacity 0). */
SANDGLASS_API uint32_t sandglass_scene_regions(const sandglass_scene* scene, sandglass_region* regions,
                                               uint32_t capacity);

/* The kernels that the scene uses: never AUTOMATIC; NEON where NEON_DOTPROD or NEON_I8MM was asked for. */
SANDGLASS_API sandglass_isa sandglass_scene_isa(const sandglass_scene* scene);

/* Adds particles and grains at rest or moving. positions: 3 floats each; velocities: 3 floats each, or NULL for rest.
 * Either count may be 0. Particles should start 2r or more apart (a lattice of sandglass_sample_lattice); overlap is
 * resolved, gently. Fails with CAPACITY, or INVALID_ARGUMENT when a coordinate is not finite or beyond
 * SANDGLASS_COORDINATE_LIMIT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_add(
    sandglass_scene* scene, const float* particle_positions, const float* particle_velocities, uint32_t particle_count,
    const float* grain_positions, const float* grain_velocities, uint32_t grain_count, const char** reason);

/* Removes the sand whose centres lie inside a shape (its velocities mean nothing); *particles and *grains, which may be
 * NULL, receive the counts. Rigid bodies stay. Wakes what is left. Fails with INVALID_ARGUMENT. */
struct sandglass_collider;
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_remove(sandglass_scene* scene,
                                                                             const struct sandglass_collider* region,
                                                                             uint32_t* particles, uint32_t* grains,
                                                                             const char** reason);

/* A rigid body: particles that keep their shape (shape matching, 4.28-4.36), pushed by sand and pushing it. They are
 * spheres of the material's radius; sample the body like sand, on a lattice or by Poisson disk, so that a particle
 * stands for the same volume. One or two particles, a line or a plane of them are bodies too. Grains are not carried by
 * bodies; pass a collider with the body's pose to keep them out of it. */
typedef struct sandglass_body {
  uint32_t struct_size;
  uint32_t particle_count;
  const float* particle_positions; /* 3 floats each, world, within SANDGLASS_COORDINATE_LIMIT */
  float density_ratio;             /* the body's density over that of sand; 0.001..1000; 1 by default */
  float linear_velocity[3];        /* m/s, of the centre of mass */
  float angular_velocity[3];       /* rad/s, about it */
} sandglass_body;

SANDGLASS_API void sandglass_body_default(sandglass_body* body);

/* Adds a body; *index (may be NULL) is its number, counted from 0. Its particles also appear, after those added before,
 * in sandglass_granular_particles. Fails like sandglass_granular_add. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_add_body(sandglass_scene* scene,
                                                                               const sandglass_body* body,
                                                                               uint32_t* index, const char** reason);

typedef struct sandglass_body_pose {
  float position[3]; /* of the centre of mass: the mean of the particles' positions */
  float rotation[4]; /* from the pose in which the body was added */
  float linear_velocity[3];
  float angular_velocity[3];
} sandglass_body_pose;

/* The pose of a body now: what draws its mesh. A number that is none gives the identity at the origin. */
SANDGLASS_API sandglass_body_pose sandglass_granular_body_pose(const sandglass_scene* scene, uint32_t index);

/* A box as a rigid body: its particles, the collider that keeps grains out of it, and the mesh that draws it fit each
 * other. The particles form a regular lattice, at most 2r apart; the outermost touch the faces of the box from inside.
 *
 * sandglass_body_box_count: how many particles the box has. `half_extents`: half the edges along x, y and z in metres,
 * each at least particle_radius and at most SANDGLASS_COORDINATE_LIMIT. Fails with INVALID_ARGUMENT: NULL, a number out
 * of its range, or more than 2^20 particles.
 *
 * sandglass_body_box: writes the particles of a box with its centre at `position` to `points` (3 floats each), and fills
 * *body for sandglass_granular_add_body. `rotation` (x, y, z, w) turns the box about its centre; NULL: not turned.
 * `density`: the density of the box over that of packed sand. body->density_ratio is then the value that gives the
 * whole box that mass, whatever its lattice. body->particle_positions is `points`, which is needed until the body is
 * added. `capacity`: how many particles fit into `points`. Fails like sandglass_body_box_count, with INVALID_ARGUMENT
 * also for a rotation without length, and with CAPACITY. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_body_box_count(const float half_extents[3],
                                                                            float particle_radius, uint32_t* count,
                                                                            const char** reason);
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_body_box(const float half_extents[3],
                                                                      float particle_radius, const float position[3],
                                                                      const float rotation[4], float density,
                                                                      float* points, uint32_t capacity,
                                                                      sandglass_body* body, const char** reason);

/* The collider of a box body at a pose, for frame_input.colliders: it keeps grains out of the box, and its position and
 * rotation are where the box's mesh is drawn. `rotation` is the one that the box was made with; NULL: it was not turned.
 * A NULL pose or half_extents leaves *collider as it was. */
struct sandglass_collider;
SANDGLASS_API void sandglass_body_box_collider(const sandglass_body_pose* pose, const float half_extents[3],
                                               const float rotation[4], struct sandglass_collider* collider);

/* Replaces the static boundary particles: fixed spheres of the particles' radius, samples of a surface
 * (sandglass_sample_surface with a distance of at most 2r). Particles collide with them; grains do not see them. Fails
 * like sandglass_granular_add. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_set_boundary(sandglass_scene* scene,
                                                                                   const float* positions,
                                                                                   uint32_t count, const char** reason);

/* Replaces the two friction coefficients from the next frame on. Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_set_friction(sandglass_scene* scene,
                                                                                   float static_friction,
                                                                                   float kinetic_friction,
                                                                                   const char** reason);

/* ------------------------------------------------------------------------------------------------ frame */

/* The image that the light is estimated from (light.h). */
struct sandglass_camera_image;

typedef int32_t sandglass_shape;
enum {
  SANDGLASS_SHAPE_HALF_SPACE = 0, /* solid below the plane through `position` whose normal is local +y */
  SANDGLASS_SHAPE_SPHERE = 1,     /* size[0] = radius */
  SANDGLASS_SHAPE_CAPSULE = 2,    /* size[0] = radius, size[1] = half length of the segment along local y */
  SANDGLASS_SHAPE_BOX = 3,        /* size = half extents along local x, y, z */
  SANDGLASS_SHAPE_FIELD = 4       /* `field`: any surface, as a grid of distances; size means nothing */
};

/* A solid that sand cannot enter. Kinematic: the app moves it. Its pose is that at the *end* of the frame's time step;
 * during the step it moves with the given velocities, so a hand with velocity pushes sand and one without merely
 * displaces it. A collider that jumps into sand pushes it out no faster than the CFL limit. Friction is the material's
 * own. */
typedef struct sandglass_collider {
  sandglass_shape shape;
  float position[3];
  float rotation[4];         /* local to world, (x, y, z, w); normalised by the library */
  float size[3];             /* see sandglass_shape; metres, above 0 */
  float linear_velocity[3];  /* m/s, world */
  float angular_velocity[3]; /* rad/s, world, about `position` */
  int32_t grains_only; /* 1: particles do not see it; for the shape of a rigid body, whose particles stand for it */
  const struct sandglass_field* field; /* SANDGLASS_SHAPE_FIELD: stays valid during the frame (field.h). Walls thinner
                                        * than two grains' steps, 2 * refine_step * speed, let fast grains through:
                                        * make containers SANDGLASS_SOLID_OUTSIDE */
} sandglass_collider;

/* Where removed particles and grains are said to be: (0, SANDGLASS_REMOVED_Y, 0), beyond every far plane. */
#define SANDGLASS_REMOVED_Y (-1e6f)

/* A grain as the app's buffer receives it. */
typedef struct sandglass_grain {
  float position[3];
  float speed; /* m/s: for shading, level of detail, or sound; below 0: the grain was removed */
} sandglass_grain;

/* Stages, in the order in which a frame runs them. */
typedef int32_t sandglass_stage;
enum {
  SANDGLASS_STAGE_GRANULAR = 0,
  SANDGLASS_STAGE_LIGHTING = 1,
  SANDGLASS_STAGE_SHADOW = 2,
  SANDGLASS_STAGE_REFINE = 3,
  SANDGLASS_STAGE_OUTPUT = 4,
  SANDGLASS_STAGE_COUNT = 5
};

/* The executed plan: what a frame did, in order. Given back to sandglass_scene_frame with the same input on the same
 * state, it reproduces the frame to the bit, on any instruction set, with any pool. */
enum { SANDGLASS_PLAN_RUNS = 48 };
typedef struct sandglass_plan_run {
  uint32_t stage; /* sandglass_stage */
  uint32_t units; /* consecutive work units of that stage */
} sandglass_plan_run;
typedef struct sandglass_plan {
  uint32_t struct_size;
  uint32_t level; /* rung of the quality ladder */
  uint32_t run_count;
  sandglass_plan_run runs[SANDGLASS_PLAN_RUNS];
} sandglass_plan;

/* A nozzle that pours sand: layers of a hexagonal lattice with the density of packed sand, one whenever the one before
 * has gone far enough, for as long as the emitter is passed. A layer for which there is no room is left out and
 * counted. Numbers of removed particles and grains are used again, so a scene with a sink pours for ever. Keep the
 * space before the nozzle free. */
typedef struct sandglass_emitter {
  float position[3];            /* of the nozzle's centre */
  float rotation[4];            /* local to world, (x, y, z, w); sand leaves along local -y */
  float radius;                 /* metres; 1 to 100 particle radii */
  float speed;                  /* m/s, above 0, at most 100; what is faster than courant * r / substep_min is slowed */
  uint32_t grains_per_particle; /* 0..64, at random places within a particle */
} sandglass_emitter;

typedef struct sandglass_frame_input {
  uint32_t struct_size;
  float time_step; /* seconds of simulated time to advance; not finite or <= 0 advances nothing; at most 0.1 is taken */
  uint64_t budget_ns;     /* time this frame may take by the scene's clock; 0 runs the mandatory part only */
  float thermal_headroom; /* share of the budget that the device can sustain without getting too hot, 0..1: the frame is
                           * planned for budget_ns times it. 1 by default, and for anything above 1 or not a number;
                           * below 0 counts as 0. Not the number that Android calls headroom, in which 1 is hot */
  const sandglass_collider* colliders;
  uint32_t collider_count; /* beyond collider_capacity, or not finite: left out, and reported */
  uint32_t emitter_count;  /* beyond emitter_capacity, or not usable: left out, and reported */
  const sandglass_emitter* emitters;
  const sandglass_collider* sinks; /* shapes that remove the sand whose centres come inside, checked every 20 ms of
                                    * simulated time; velocities mean nothing; sleeping sand and rigid bodies stay */
  uint32_t sink_count;             /* beyond sink_capacity, or not usable: left out, and reported */
  float output_lag;        /* seconds, 0..0.1: grains are written where they were so long before the state's time, for
                            * displays faster than the simulation; 0 = newest */
  void* grains;            /* receives sandglass_grain items by number; NULL: none wanted */
  uint32_t grain_stride;   /* bytes from one item to the next, at least sizeof(sandglass_grain) and a multiple of 4 */
  uint32_t grain_capacity; /* items that fit */
  struct sandglass_shadow* const* shadows; /* to bring up to date (shadow.h): one unit a frame whatever the budget, more
                                            * as it admits; pass all whose shadows are seen */
  uint32_t shadow_count;
  struct sandglass_pile_shadow* pile_shadow; /* NULL, or the sand's own shadow, of its grains where it has any, else of
                                              * its particles; it and the others are brought up to date in turns */
  struct sandglass_light* light; /* NULL, or the light to bring up to date (light.h): one unit a frame whatever the
                                  * budget, more as it admits; an image that is taken is resampled in its frame,
                                  * whatever the budget */
  const struct sandglass_camera_image* camera; /* NULL, or the newest image: passed over while an estimate is under way
                                                * or until the light's interval has passed; read in this call only */
  const sandglass_plan* plan;                  /* NULL, or a recorded plan to execute: the clock then decides nothing */
} sandglass_frame_input;

SANDGLASS_API void sandglass_frame_input_default(sandglass_frame_input* input);

typedef struct sandglass_stage_report {
  uint32_t units;      /* work units executed */
  uint32_t denied;     /* 1 if the stage had work left that the budget did not admit */
  uint64_t elapsed_ns; /* by the scene's clock; 0 without one */
} sandglass_stage_report;

/* What the frame did. Times are by the scene's clock. */
typedef struct sandglass_frame_report {
  uint32_t struct_size;
  uint32_t level; /* rung of the quality ladder: 0 = full; see sandglass_level_name */
  uint64_t frame; /* frames since create or reset, this one included */
  uint64_t budget_ns;
  uint64_t target_ns;    /* budget_ns scaled by thermal_headroom: the target duration of a performance hint session */
  uint64_t elapsed_ns;   /* the actual duration of one */
  uint64_t mandatory_ns; /* of elapsed: work that is done whatever the budget */
  uint64_t last_unit_ns; /* duration of the last unit, and of output beyond its prediction; see sandglass_scene_frame */
  uint64_t longest_unit_ns;
  uint32_t clock_fault; /* 1 if the clock went backward, froze or jumped, and the frame ended at its cap of units */
  sandglass_stage_report stages[SANDGLASS_STAGE_COUNT];
  double simulated_time; /* seconds simulated since create or reset */
  double time_debt;      /* seconds asked for since then and not simulated: 0 means no slow motion */
  float grain_lag;       /* seconds by which the oldest grain lags the particles; never ten frames: time slows before */
  float substep;         /* seconds; length of the last sub-step */
  uint32_t substeps;     /* completed in this frame */
  uint32_t list_builds;
  uint32_t particles;
  uint32_t awake; /* particles that do not sleep */
  uint32_t grains;
  uint32_t awake_grains;     /* of the last sweep, in whole groups of 16; the rest slept */
  uint32_t dropped_contacts; /* neighbours beyond a list's capacity (32), summed over the frame's list builds; 0 in any
                                packing */
  uint32_t quarantined;      /* particles and grains found not finite, or beyond the coordinate limit, and reset to rest
                                inside it */
  uint32_t ignored_colliders; /* and emitters and sinks: not finite, degenerate, or beyond capacity */
  uint32_t particle_numbers;  /* numbers given out so far: the length of what sandglass_granular_particles writes */
  uint32_t grain_numbers;     /* likewise */
  uint64_t emitted_particles, emitted_grains; /* by emitters, since create or reset */
  uint64_t removed_particles, removed_grains; /* by sinks and sandglass_granular_remove */
  uint64_t denied_particles;                  /* that emitters had no room for */
  float speed_max;                            /* m/s; fastest particle in the last sub-step */
  uint32_t pending_shadows;  /* textures, over all shadows and lights, that are not yet those of their lights */
  uint32_t shadow_age;       /* calls of set_light since the oldest of them was begun */
  uint32_t light_valid;      /* 1: input.light has an estimate */
  uint32_t light_changed;    /* 1: it changed in this frame */
  uint32_t light_age;        /* frames with this light since the one that brought the image of its last estimate */
  uint32_t light_units_left; /* of the estimate under way */
  uint32_t ignored_images;   /* 1: input.camera cannot be used (sandglass_camera_check and the log hook say why) */
  sandglass_plan plan;       /* what was executed: record it to replay the frame */
} sandglass_frame_report;

/* Advances the scene by one frame: moves simulated time on by input->time_step plus what earlier frames still owe (at
 * most two frames' worth; the rest is slow motion, and counted in time_debt), as far as the budget admits. After it,
 * positions are valid and grains are written whatever the budget was. *report may be NULL. Fails only with
 * INVALID_ARGUMENT (NULL scene or input, a struct_size that is wrong or not set, unusable grain buffer, NULL among the
 * shadows; nothing was changed) or REPLAY (input->plan is malformed: nothing was changed; or it asks for a unit that
 * this state does not offer: the frame ended there, the scene is valid, but it is not the recorded one: reset it).
 *
 * Guarantee, for a clock that runs: elapsed <= max(target, mandatory part) + last_unit_ns of the report: one work unit,
 * and whatever time writing the grains, which is always done and comes last, took beyond its own prediction. */
SANDGLASS_API sandglass_status sandglass_scene_frame(sandglass_scene* scene, const sandglass_frame_input* input,
                                                     sandglass_frame_report* report, const char** reason);

/* ------------------------------------------------------------------------------------------------ reading the state */

/* Copies of the present state by number: the order in which items were added, unless some were removed, whose numbers
 * new ones take over. 3 floats an item, room for report.particle_numbers or grain_numbers items. Removed items are at
 * SANDGLASS_REMOVED_Y, at rest. Any pointer may be NULL. Not part of the frame: for tests and tools. */
SANDGLASS_API void sandglass_granular_particles(const sandglass_scene* scene, float* positions, float* velocities);
SANDGLASS_API void sandglass_granular_grains(const sandglass_scene* scene, float* positions, float* velocities);

/* A 64-bit hash of the state of every active stage: the sum over all particles and grains of FNV-1a over (kind, number,
 * position, velocity). Equal on every instruction set, compiler and thread count. */
SANDGLASS_API uint64_t sandglass_scene_hash(const sandglass_scene* scene);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_SANDGLASS_H */
