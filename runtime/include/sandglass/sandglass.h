/* Sandglass: sand, light and shadow for augmented reality, inside a fixed slice of every frame.
 *
 * This header holds scenes and granular material, in C. It includes points in volumes and on surfaces (sampling.h) and
 * signed-distance fields (field.h). The rest of the public API stands in headers of its own: camera.h (its image),
 * estimate.h (the light of one image), room.h (the light of all images), renderers.h (light as renderers want it),
 * skin.h (the surface of the sand as a mesh), cast.h (the shadows of any triangles), shadow.h (those of objects that were
 * baked) and pile_shadow.h (the shadow of the sand). sandglass.hpp adds owner types for C++.
 * Units, errors, the rule for NULL, and version and ABI: see types.h, whose rules hold for all functions.
 *
 * An app
 *
 *   1. fills a sandglass_scene_desc (start from sandglass_scene_desc_default),
 *   2. asks sandglass_scene_bytes how much memory that scene needs,
 *   3. hands one block of that size to sandglass_scene_create,
 *   4. adds material (sandglass_granular_add), sampled by sandglass_sample_points or its own,
 *   5. calls sandglass_scene_frame once a frame, with colliders, a time step and a budget in nanoseconds.
 *
 * After step 3 the library allocates nothing, starts no thread, takes no lock and reads no clock but the one that it
 * was handed. There is nothing to destroy: the block is the scene, and it belongs to the app.
 *
 * Threads. One scene belongs to one thread at a time. Different scenes are independent.
 *
 * Words. A *particle* carries the physics. A *grain* is what is drawn. A *collider* is a shape that pushes sand. A
 * *work unit* is a bounded piece of work; a frame can end between any two. Numbers in parentheses such as (4.37) are
 * equations of the dissertation that runtime/README.md names. That page also lists every correction to it. */
#ifndef SANDGLASS_SANDGLASS_H
#define SANDGLASS_SANDGLASS_H

#include "sandglass/field.h"
#include "sandglass/sampling.h"
#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ granular material */

/* How the contacts of one sub-step are resolved.
 *
 * SMALL_STEP (the default): pair by pair. A pair corrects both its particles at once, and the next pair sees that
 * (Gauss-Seidel). What one particle gains the other loses, so momentum is conserved. It takes many small steps, and
 * then only one iteration.
 *
 * AVERAGED: all pairs see the same positions (Jacobi). The sum of a particle's corrections is divided by the number of
 * constraints that acted on it (4.37). `relaxation` multiplies that mean; the product is never above 1 per
 * constraint. */
typedef int32_t sandglass_scheme;
enum { SANDGLASS_SCHEME_SMALL_STEP = 0, SANDGLASS_SCHEME_AVERAGED = 1 };

/* How grains blend between the flow and free flight (4.43), by the factor lambda.
 *
 * CONTINUOUS (the default): lambda falls smoothly to 0 inside the material. Grains follow once a frame, by the
 * particles' displacements, and keep an even density. Among particles that fall freely they fall on their own.
 *
 * SOURCE: (4.44) as printed, once every refine_step. Lambda jumps from 0.298 to 0, and grains pop; they gather around
 * the particles. It costs several times as much.
 *
 * MEANS: CONTINUOUS, but a grain in free flight knows no particle of its own. It does not turn where its particle hits
 * something, and sand is drawn where none is. */
typedef int32_t sandglass_blend;
enum { SANDGLASS_BLEND_CONTINUOUS = 0, SANDGLASS_BLEND_SOURCE = 1, SANDGLASS_BLEND_MEANS = 2 };

/* How one sub-step is solved. An app leaves this struct as sandglass_scene_desc_default filled it: every measured
 * number and the quality ladder hold for these defaults. Its other values are the solver of the dissertation as printed
 * (Alg. 4), and are here so that the library can be compared with it. */
typedef struct sandglass_reference_scheme {
  /* Default: SANDGLASS_SCHEME_SMALL_STEP. */
  sandglass_scheme scheme;
  /* Default: SANDGLASS_BLEND_CONTINUOUS. */
  sandglass_blend blend;
  /* Iterations a sub-step, 1..64. Default: 1. */
  uint32_t solver_iterations;
  /* Iterations that move overlapping particles apart before the solver runs, 0..8 (Alg. 4, lines 6 to 12). Default:
   * 0. */
  uint32_t stabilisation_iterations;
  /* SMALL_STEP: the share of a pair's correction that is made, above 0, at most 1. AVERAGED: above 0, at most 2.
   * Default: 1. */
  float relaxation;
} sandglass_reference_scheme;

#define SANDGLASS_PARTICLE_LIMIT 4000000 /* The most particles that a description may ask for */
#define SANDGLASS_GRAIN_LIMIT 64000000   /* The most grains */
#define SANDGLASS_COLLIDER_LIMIT 256     /* The most colliders */
#define SANDGLASS_FLOW_LIMIT 64          /* The most emitters, and the most sinks */
#define SANDGLASS_FRICTION_LIMIT 10.0f   /* The largest coefficient of friction */
#define SANDGLASS_GRAVITY_LIMIT 1000.0f  /* The strongest gravity, m/s^2 */
#define SANDGLASS_SUBSTEP_LIMIT 0.1f     /* The longest sub-step, seconds */

/* What a scene's granular material is and how much of it there may be (chapter 4).
 *
 * Particles are equal spheres with contacts and friction. Grains are many more, are carried along by the particles, and
 * never collide with each other. */
typedef struct sandglass_granular_desc {
  /* The most particles at any time, at most 4 million. 0 leaves granular material out: no memory, no time. */
  uint32_t particle_capacity;
  /* The most grains, at most 64 million. 0 simulates particles only. */
  uint32_t grain_capacity;
  /* The most static boundary particles (samples of a fixed surface), at most 4 million. */
  uint32_t boundary_capacity;
  /* The most rigid bodies, 0..255. */
  uint32_t body_capacity;
  /* The most particles of all bodies together. They count in particle_capacity too. */
  uint32_t body_particle_capacity;
  /* The most emitters passed to one frame, 0..64. */
  uint32_t emitter_capacity;
  /* The most sinks passed to one frame, 0..64. */
  uint32_t sink_capacity;
  /* The most colliders passed to one frame, 0..256. */
  uint32_t collider_capacity;

  /* The radius r of every particle, metres, 0.0001..10. Default: 0.01. */
  float particle_radius;
  /* Metres, 0..r. The centre of a grain stays this far outside every collider. 0, the default, means 0.35 r. */
  float grain_radius;
  /* mu_s, 0..10. The default of both coefficients, 0.16, spreads a collapsing column as far as sand spreads (Lube
   * 2004). Particles do not rotate, which does the work of higher coefficients. */
  float static_friction;
  /* mu_k, 0..10. It may exceed mu_s. */
  float kinetic_friction;
  /* How much more a particle yields than one below it, 0..1.5, the k of the corrected (4.38). In a pair whose upper
   * particle is `d` particle diameters higher (measured against gravity), the shares of the correction are in the ratio
   * exp(k d). The default, 0.45, is calibrated together with the friction. A higher k carries tall piles with less
   * overlap, but carries inside the sand what a floor or a wall should carry. 0 conserves momentum pairwise. In
   * SMALL_STEP k only brakes a fall: it lifts a pair until the pair rises, on average, by what gravity takes in a
   * sub-step. In AVERAGED it lifts a particle by at most twice that. So nothing flies up at an impact. */
  float height_weighting;

  /* C of (4.45), above 0, at most 1. Default: 0.5, as in the dissertation. Particles that can reach nothing within the
   * frame count neither for (4.45) nor for the neighbour lists, and are not slowed: all that fall below everything, and
   * fast ones elsewhere, as long as there are at most 64. */
  float courant;
  /* Seconds, 0.000001..0.1: the longest sub-step. 0, the default, means 0.01742 sqrt(r/g), for which the default scheme
   * was calibrated. Where a frame's time step would take more than 10,000 sub-steps, they are longer. */
  float substep_max;
  /* Seconds, 0.000001..substep_max: the shortest sub-step that (4.45) may ask for. Faster particles are slowed to
   * courant * r / substep_min. 0, the default, means substep_max / 4. */
  float substep_min;
  /* Neighbour lists reach 2r + list_skin * r, 0.1..1. They are rebuilt before anything outside them can touch. Default:
   * 0.8. */
  float list_skin;

  /* Seconds, 0..5: particles that stay near one place for so long fall asleep, and cost nothing until something touches
   * them. Near is 10 % of r; for r below 1 cm 10 % of sqrt(r * 1 cm), because slow creep shrinks no faster; for rigid
   * bodies three times that. Where there is gravity, only what touches something falls asleep, and near is at most
   * 0.08 g sleep_after^2, which is less than a flight takes. What stands straight on one other particle, and could fall
   * aside as a lattice does, waits for 172 sqrt(r / g), 5.5 s for 1 cm. What is above 0 and below 0.04 counts as 0.04. 0
   * means never. Default: 0.5. */
  float sleep_after;
  /* Seconds, 0.0001..0.1: the longest step of the grains, Delta t_hr: how often lambda is applied. Default: 0.008, as
   * in the dissertation. */
  float refine_step;

  /* The scheme that results are compared with. Apps leave it alone. */
  sandglass_reference_scheme reference;

  /* Metres, 0..0.1: a collider does not move while its surface, where sand is, is told less than this away from where
   * it is held; see sandglass_collider. 0: every pose is taken as told, and without velocities the way from frame to
   * frame is its velocity. Default: 0.003, above the noise of a tracker. */
  float collider_band;
  /* Metres, 0..2000: what falls so far is removed: particles, grains, and rigid bodies that are wholly so low. It
   * counts along gravity, as it is now, from the lowest point of this frame's bounded colliders, of the boundary
   * particles and of what is asleep. Nothing is removed where none of these is there, without gravity, or over a
   * half-space that rises less than 84 degrees. What flies beyond SANDGLASS_COORDINATE_LIMIT is removed wherever it is.
   * 0: only that. Default: 20. */
  float lowest;
} sandglass_granular_desc;

/* ------------------------------------------------------------------------------------------------ quality */

/* The quality ladder. When the work of a frame does not fit its budget, the frame runs at the first quality level that
 * does. A level includes what the levels before it gave up. */
enum {
  /* Everything. */
  SANDGLASS_LEVEL_FULL = 0,
  /* Neighbour lists are rebuilt after three times the motion that could outdate them. */
  SANDGLASS_LEVEL_KEEP_LISTS = 1,
  /* Sub-steps are 4/3 as long. AVERAGED with several iterations: 3/4 of them. */
  SANDGLASS_LEVEL_COARSE = 2,
  /* Sub-steps are twice as long. AVERAGED with several iterations: half of them. Grains are pushed to an even density
   * in one sweep of four instead of two. */
  SANDGLASS_LEVEL_COARSER = 3,
  /* As much simulated time as fits. The rest is the time debt: report.time.debt. */
  SANDGLASS_LEVEL_SLOW_MOTION = 4,
  SANDGLASS_LEVEL_COUNT = 5
};

/* What a quality level costs and what its error is. The numbers come from `sandglass_lab bench ladder`: a collapsing column
 * of 14,280 particles and 228,480 grains over two seconds. Costs are relative to the full quality in the same run. */
typedef struct sandglass_level {
  uint32_t struct_size;
  /* "full", for example. */
  const char* name;
  /* Of the particles, relative to level 0. */
  float cost_solver;
  /* Of the grains, relative to level 0. */
  float cost_refine;
  /* The overlap of touching pairs, (2r - distance) / r: its 99th percentile over the pairs, mean over the frames. */
  float overlap_p99;
  /* The same overlap: its mean over the pairs, mean over the frames. */
  float overlap_mean;
  /* The slope of the pile at the end, degrees. */
  float angle_deg;
} sandglass_level;

/* What a quality level costs, and its error. NULL beyond the last level. Slow motion has the errors of the level before
 * it. */
SANDGLASS_API const sandglass_level* sandglass_level_describe(uint32_t level);

/* The name of a quality level. NULL beyond the last level. */
SANDGLASS_API const char* sandglass_level_name(uint32_t level);

/* ------------------------------------------------------------------------------------------------ scene */

/* What a scene is: set once, at create. */
typedef struct sandglass_scene_desc {
  uint32_t struct_size;
  /* Which kernels to use. Default: AUTOMATIC. */
  sandglass_isa isa;
  /* Particles (or grains) in a work unit, 16..65536, a multiple of 16. The default, 1024, is about 50 microseconds on a
   * phone core. With a pool of T threads, T times that keeps the pool busy. */
  uint32_t unit_items;
  /* The best quality level that may be used: a higher one saves energy. Without a clock it is the level that runs.
   * Default: 0. */
  uint32_t finest_level;
  /* m/s^2, in any direction, at most 1000. With length 0, height weighting has no effect. Default: (0, -9.81, 0).
   * sandglass_scene_set_gravity changes it. */
  float gravity[3];
  /* The only clock that the scene reads. Default: none. */
  sandglass_clock clock;
  /* The worker pool of the app. Default: none. */
  sandglass_parallel parallel;
  /* Default: none. */
  sandglass_trace trace;
  /* Default: none. */
  sandglass_log log;
  /* The sand and the rigid bodies. */
  sandglass_granular_desc granular;
} sandglass_scene_desc;

/* Fills *desc with the defaults: gravity (0, -9.81, 0), no clock, no pool, no hooks, room for 16 colliders and for no
 * other material, and the calibrated parameters for sand of particle radius 0.01 m. The app then sets the capacities
 * and whatever differs. */
SANDGLASS_API void sandglass_scene_desc_default(sandglass_scene_desc* desc);

/* A scene, in a block of the app. */
typedef struct sandglass_scene sandglass_scene;

/* The exact number of bytes that a scene of this description needs, in *bytes. The function that lays the scene out
 * counts them, so the two cannot differ. Fails with INVALID_ARGUMENT: a field out of range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_bytes(const sandglass_scene_desc* desc,
                                                                         uint64_t* bytes, const char** reason);

/* Makes a scene in the app's block; *scene then points into it. The block must be aligned to SANDGLASS_BLOCK_ALIGNMENT,
 * at least sandglass_scene_bytes long, and stay where it is. Nothing outside the block is written, and nothing at all
 * when this fails. Fails with INVALID_ARGUMENT, MEMORY_TOO_SMALL, MEMORY_ALIGNMENT, and UNSUPPORTED (isa). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_create(const sandglass_scene_desc* desc, void* block,
                                                                          uint64_t bytes, sandglass_scene** scene,
                                                                          const char** reason);

/* Puts the scene back to the state just after create: no material, no boundary, no collider known, time zero, the
 * description's gravity and friction. The governor forgets the costs that it measured. */
SANDGLASS_API void sandglass_scene_reset(sandglass_scene* scene);

/* Moves everything in the scene rigidly: p becomes rotation * p + translation, and velocities turn. Either may be NULL:
 * then there is none. The rotation is a quaternion (x, y, z, w) of any length above 0; the translation is in metres.
 *
 * It serves AR relocalisation, and shifting the origin before coordinates grow large. Gravity stays as it is. Pass the
 * colliders of the next frame moved in the same way: then what is asleep stays asleep, unless the move has tilted it by
 * more than 1.1 degrees against gravity. Fails with INVALID_ARGUMENT, also when something would leave
 * SANDGLASS_COORDINATE_LIMIT; nothing was moved then. But sand that has fallen below everything or flown away is
 * removed where it would leave the limit. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_move(sandglass_scene* scene, const float rotation[4],
                                                                        const float translation[3],
                                                                        const char** reason);

/* Replaces gravity: m/s^2, in any direction, at most 1000. It serves a device that is tipped, and may be called before
 * every frame. A sub-step that desc.granular left to the library follows the new length.
 *
 * Sand that is asleep wakes up where gravity has changed by more than 2 % of its length (a turn by 1.1 degrees) since
 * what sleeps was last woken by it. So the noise of a sensor wakes nothing, and a slow turn does. sandglass_scene_reset
 * brings the description's gravity back. Saved bytes hold the gravity that sand sleeps under, not the scene's: set it
 * before sandglass_scene_restore. Fails with INVALID_ARGUMENT; gravity stays as it was then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_set_gravity(sandglass_scene* scene,
                                                                               const float gravity[3],
                                                                               const char** reason);

/* How many bytes sandglass_scene_save would write now, at most: it finishes a step of the grains that is under way, in
 * which some may leave. */
SANDGLASS_API uint64_t sandglass_scene_save_bytes(const sandglass_scene* scene);

/* Saves the scene to `data`, for an app that goes to the background. *written is the number of bytes.
 *
 * The bytes hold the material, the time, where colliders were held, and the gravity that sand sleeps under. They do not
 * hold the description, the scene's gravity, friction, fields, hooks, or the costs that the governor measured. Shadows,
 * pile shadows, estimators and rooms are no part of a scene: they have blocks of their own, and are not saved. The bytes are the
 * same on every instruction set, in little-endian order. The scene itself finishes the step of its grains that is under
 * way, and drops an unfinished sub-step.
 *
 * The scene and one of the same description that is restored from the bytes then stay equal to the bit, given the same
 * input and the same executed plans. Without a clock every frame runs all its work, so the plans are the same. A plan
 * counts the work units of shadows and lights too: to repeat one in a restored scene, record it in frames without them,
 * or create them anew at both places.
 *
 * Fails with INVALID_ARGUMENT, and MEMORY_TOO_SMALL: `bytes` is less than sandglass_scene_save_bytes. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_save(sandglass_scene* scene, void* data,
                                                                        uint64_t bytes, uint64_t* written,
                                                                        const char** reason);

/* Restores a scene from saved bytes. Its description must have the same particle_radius and enough capacity. With other
 * capacities of particles or grains the scene runs on, but not to the same bits: particles are then sorted otherwise.
 *
 * What rests wakes where gravity, or the colliders of the first frame that has any, differ from those that it came to
 * rest with. Frames before that one mean that the planes are not found yet: what rests waits. Both hold for the scene
 * that was saved, too, from the save on.
 *
 * The bytes need not be trusted: they are checked. Fails with INVALID_ARGUMENT (the bytes are damaged, or from another
 * version of the format) and CAPACITY (there is not enough room). The scene is then as it was. There is one exception:
 * where the checksum is right and the content contradicts itself, the scene is reset. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_restore(sandglass_scene* scene, const void* data,
                                                                           uint64_t bytes, const char** reason);

/* One named region of the scene's block. */
typedef struct sandglass_region {
  /* "granular.particles", for example. */
  const char* name;
  /* From the start of the block, bytes. */
  uint64_t offset;
  /* Its length. */
  uint64_t bytes;
} sandglass_region;

/* The number of regions of the scene's block. Up to `capacity` of them are written to `regions`, which may be NULL. */
SANDGLASS_API uint32_t sandglass_scene_regions(const sandglass_scene* scene, sandglass_region* regions,
                                               uint32_t capacity);

/* The instruction set of the kernels that the scene uses. It is never AUTOMATIC, and NEON where NEON_DOTPROD or
 * NEON_I8MM was asked for. */
SANDGLASS_API sandglass_isa sandglass_scene_isa(const sandglass_scene* scene);

/* ------------------------------------------------------------------------------------------- adding and removing */

/* Particles or grains to add, in the app's arrays of 3 floats each. */
typedef struct sandglass_points {
  /* Metres. */
  const float* positions;
  /* m/s, at most 10,000 along each axis. NULL: at rest. */
  const float* velocities;
  /* How many there are; may be 0. */
  uint32_t count;
} sandglass_points;

/* Adds particles and grains. Either may be NULL: none.
 *
 * Particles should start 2r or more apart (SANDGLASS_SAMPLE_LATTICE). Overlap is resolved, gently. Fails with CAPACITY,
 * and with INVALID_ARGUMENT: a coordinate is not finite or beyond SANDGLASS_COORDINATE_LIMIT, or a velocity is out of
 * range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_add(sandglass_scene* scene,
                                                                          const sandglass_points* particles,
                                                                          const sandglass_points* grains,
                                                                          const char** reason);

struct sandglass_collider;

/* Removes the sand whose centres lie inside a shape; its velocities mean nothing. *particles and *grains receive the
 * counts; both are optional. Rigid bodies stay: see sandglass_granular_remove_body. What is left wakes up. Fails with
 * INVALID_ARGUMENT: the shape is not usable. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_remove(sandglass_scene* scene,
                                                                             const struct sandglass_collider* region,
                                                                             uint32_t* particles, uint32_t* grains,
                                                                             const char** reason);

/* A rigid body: particles that keep their shape (shape matching, 4.28 to 4.36). Sand pushes it, and it pushes sand.
 *
 * Its particles are spheres of the material's radius. Sample the body like sand, on a lattice or by Poisson disk, so
 * that a particle stands for the same volume; or make a box (sandglass_box_body). A body may also be one or two
 * particles, a line or a plane of them. Bodies do not carry grains: pass a collider with the body's pose to keep grains
 * out of it. */
typedef struct sandglass_body {
  uint32_t struct_size;
  /* 3 floats each, world, metres, within SANDGLASS_COORDINATE_LIMIT. Needed until the body is added. */
  const float* particle_positions;
  /* How many particles the body has. */
  uint32_t particle_count;
  /* The mass of a particle of the body over that of a particle of sand, 0.001..1000. Default: 1. Up to 8, with the
   * default sub-steps, body and sand stay apart and come to rest. Above that, sand that the body falls on may be thrown
   * up, and takes seconds longer to rest; half of the default substep_max is enough up to 20. Above 20, sand that the
   * body squeezes may end inside it, unless substep_max is far shorter; so may, at any density, single particles on a
   * bare floor that a body falls onto. A stack of two or three bodies, none denser than those below, does not move. It
   * also stands if the uppermost is up to 8 times as dense, though bodies that were put ball on ball slide by up to two
   * diameters until they lie in the hollows. One that is 100 times as dense pushes apart what carries it. */
  float density_ratio;
  /* m/s, of the centre of mass, at most 10,000 along each axis. */
  float linear_velocity[3];
  /* rad/s, about the centre of mass, at most 10,000 about each axis. */
  float angular_velocity[3];
} sandglass_body;

/* Fills *body with the defaults: no particles, density_ratio 1, at rest. */
SANDGLASS_API void sandglass_body_default(sandglass_body* body);

/* Adds a body. *index, which is optional, is its number: the lowest that no body has, counted from 0. Its particles
 * appear in sandglass_granular_particles like sand that is added now. Overlap is resolved as by
 * sandglass_granular_set_body. Fails with CAPACITY, and with INVALID_ARGUMENT: a body without particles, or a number
 * out of range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_add_body(sandglass_scene* scene,
                                                                               const sandglass_body* body,
                                                                               uint32_t* index, const char** reason);

/* Where a body is. */
typedef struct sandglass_body_pose {
  /* Of the centre of mass: the mean of the particles' positions. World, metres. */
  float position[3];
  /* From the pose in which the body was added, (x, y, z, w). */
  float rotation[4];
  /* m/s. */
  float linear_velocity[3];
  /* rad/s. */
  float angular_velocity[3];
} sandglass_body_pose;

/* The pose of a body now: draw its mesh with it. An index that no body has returns the identity pose at the origin. */
SANDGLASS_API sandglass_body_pose sandglass_granular_body_pose(const sandglass_scene* scene, uint32_t index);

/* 1 if a body has this index, else 0: none was added, or it was removed by the app, by a sink or by granular.lowest. */
SANDGLASS_API int32_t sandglass_granular_has_body(const sandglass_scene* scene, uint32_t index);

/* Removes a body, between frames. The other bodies keep their numbers. Its number, those of its particles, and its room
 * are free for the next sandglass_granular_add_body. What lies within 2r + list_skin * r of the box around the centres
 * of its particles wakes up. report.sand counts it in removed_bodies, and its particles in removed_particles. Fails
 * with INVALID_ARGUMENT: no body has this index. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_remove_body(sandglass_scene* scene,
                                                                                  uint32_t index, const char** reason);

/* Puts a body somewhere else, from one moment to the next, with these velocities: at most 10,000 m/s and rad/s along
 * each axis. The rotation has any length above 0. It may be called before every frame, to drag a body: give the
 * velocity of the way then, so that the body pushes what it meets.
 *
 * The body wakes up, and so does what is near it, at the old place and at the new one, as for removing. Overlap with
 * sand and bodies is resolved gently, as for sandglass_granular_add: a pair parts at no more than 0.9 sqrt(2 g r),
 * times the density_ratio of the densest body where that is 1 to 5. Sand or another body that would be caught between
 * particles of this one is put beside it, along an axis of the world that does not point down. What stands there is not
 * looked at, so keep clear of thin walls. Neighbour lists are built anew in the next frame. Beside 14,000 particles the
 * call takes some 0.1 ms on a workstation, and 12 ms where a body of 1,000 is put into the midst of them.
 *
 * Fails with INVALID_ARGUMENT: no body has this index, a number out of range, or one of its particles would lie beyond
 * SANDGLASS_COORDINATE_LIMIT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_set_body(sandglass_scene* scene, uint32_t index,
                                                                               const sandglass_body_pose* pose,
                                                                               const char** reason);

/* Pushes a body at a point, as a finger that flicks it does.
 *
 * `impulse` is the impulse over the mass of the body, a vector in m/s along the world's axes: the velocity of the
 * centre of mass changes by it, whatever the mass is. An app that has an impulse in N s divides it by the mass in kg.
 * `point` is in the world, metres, on the body or not. It is optional; NULL is the centre of mass, and the body does
 * not turn. With c the centre of mass and r the particles' places relative to it:
 *
 *     linear  += impulse
 *     angular += J^-1 ((point - c) x impulse)        J = mean over the particles of (|r|^2 - r r^T)
 *
 * J is the inertia over the mass. Particles do not turn, so a body whose particles lie on a line does not spin about
 * that line, and one of a single particle not at all. The body and what is near it wake up. Neighbour lists are built
 * anew in the next frame. Fails with INVALID_ARGUMENT: no body has this index, a number is not finite, the point is
 * beyond SANDGLASS_COORDINATE_LIMIT, or the body would be faster than 10,000 m/s or rad/s along an axis. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_push_body(sandglass_scene* scene, uint32_t index,
                                                                                const float impulse[3],
                                                                                const float point[3],
                                                                                const char** reason);

/* A box as a rigid body. Its particles (sandglass_box_body), the collider that keeps grains out of it
 * (sandglass_box_collider) and the mesh of a box of these half extents fit each other: the particles form a regular
 * lattice, at most 2r apart, and the outermost touch the faces of the box from inside. */
typedef struct sandglass_box_desc {
  uint32_t struct_size;
  /* Half the edges along x, y and z, metres, each at least particle_radius and at most SANDGLASS_COORDINATE_LIMIT. */
  float half_extents[3];
  /* r of the scene, metres, 0.0001..10. */
  float particle_radius;
  /* Of the centre, world, metres. Default: the origin. */
  float position[3];
  /* Turns the box about its centre, (x, y, z, w), of any length above 0. Default: no turn. */
  float rotation[4];
  /* Over that of packed sand. Default: 1. */
  float density;
} sandglass_box_desc;

/* Fills *desc with the defaults: at the origin, not turned, density 1; no extents and no radius yet. */
SANDGLASS_API void sandglass_box_desc_default(sandglass_box_desc* desc);

/* How many particles a box has. Fails with INVALID_ARGUMENT: a field out of range or not finite, or more than 2^20
 * particles. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_box_count(const sandglass_box_desc* desc, uint32_t* count,
                                                                       const char** reason);

/* Writes the particles of a box to `points`, 3 floats each, and fills *body for sandglass_granular_add_body:
 * body->particle_positions is `points`, and body->density_ratio the value that gives the whole box the mass of its
 * volume times its density, whatever its lattice. `capacity`: how many particles fit into `points`. Fails like
 * sandglass_box_count, and with CAPACITY. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_box_body(const sandglass_box_desc* desc, float* points,
                                                                      uint32_t capacity, sandglass_body* body,
                                                                      const char** reason);

/* The collider of a box body at a pose: pass it in frame_input.colliders to keep grains out of the box. Its position
 * and rotation are also where the mesh of the box is drawn. The pose is that before the frame, and the collider has the
 * body's velocities, so grains meet the box where it was one frame ago. */
SANDGLASS_API void sandglass_box_collider(const sandglass_box_desc* desc, const sandglass_body_pose* pose,
                                          struct sandglass_collider* collider);

/* Replaces the static boundary particles: fixed spheres of the particles' radius, samples of a surface
 * (SANDGLASS_SAMPLE_SURFACE with a distance of at most 2r). Particles collide with them; grains do not see them.
 * `positions`: 3 floats each, metres. Fails with CAPACITY, and with INVALID_ARGUMENT: a coordinate is not finite or
 * beyond SANDGLASS_COORDINATE_LIMIT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_set_boundary(sandglass_scene* scene,
                                                                                   const float* positions,
                                                                                   uint32_t count, const char** reason);

/* Replaces the two friction coefficients from the next frame on; each 0..10. Everything wakes up. Fails with
 * INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_granular_set_friction(sandglass_scene* scene,
                                                                                   float static_friction,
                                                                                   float kinetic_friction,
                                                                                   const char** reason);

/* ------------------------------------------------------------------------------------------------ frame */

/* The camera's image (camera.h). */
struct sandglass_camera_image;

/* The shape of a collider. */
typedef int32_t sandglass_shape;
enum {
  /* Solid below the plane through `position` whose normal is local +y. */
  SANDGLASS_SHAPE_HALF_SPACE = 0,
  /* size[0] is the radius. */
  SANDGLASS_SHAPE_SPHERE = 1,
  /* size[0] is the radius, size[1] half the length of the segment along local y. */
  SANDGLASS_SHAPE_CAPSULE = 2,
  /* size holds the half extents along local x, y and z. */
  SANDGLASS_SHAPE_BOX = 3,
  /* Any surface, as a grid of distances in `field`; size means nothing. */
  SANDGLASS_SHAPE_FIELD = 4
};

/* A collider: a solid that sand cannot enter, and that the app moves. Its pose is that at the *end* of the frame's time
 * step; during the step it moves with its velocities. Friction is the material's. The order of the list means nothing.
 * An app may pass what it knows: poses alone, with velocities 0, are enough.
 *
 * Gentle. What is deep in a collider, because it jumped, grew or appeared in sand, leaves it with the collider's own
 * velocity plus at most 0.225 sqrt(2 g r), 0.1 m/s for r = 1 cm. Where a body is denser than sand, that speed is times
 * the square of the highest density_ratio, counted up to 5. Of two colliders that press sand into each other the slower
 * one holds: it is not entered.
 *
 * Held. The pose that a tracker tells is never twice the same. A collider does not move, and what sleeps on it does not
 * wake, while its surface, where sand is, is told less than granular.collider_band away from where it is held. A
 * half-space may slide along itself, a ball may turn, and a box that grows keeps the faces that sand lies on. A pose
 * that stays beyond the band for 3 frames, or that moves on there, is followed, with the velocity of the way that it is
 * held to go: so walls of 2 r keep sand by poses alone. It is held never ahead of the told pose; where that moves, at
 * most the band behind, once it has made up what it waited for, at 1.25 times the told speed. A tracker may be slower
 * than the frames: then it goes evenly from pose to pose. What needs more than 50 m/s^2 is a jump. It is waited for 3
 * frames, or for the tracker's next pose; a single outlier does nothing. Then it comes gently, at most as fast as sand
 * leaves what jumped; one of more than 1.5 r and 3 bands is there at once. The correction of a plane, or a jump of a
 * table, takes no sand along itself. The collider is held again once it has stood for 1.5 s.
 * sandglass_granular_held_collider tells where.
 *
 * Velocities that the app tells are believed once they have kept their direction for 4 frames, or for 0.25 s after they
 * turned back, or have led its surface further than twice the band. Then pose and velocities are taken as told; what
 * the collider was behind them it makes up with a time constant of 0.05 s. Velocities below 0.1 mm/s, or that only
 * shake the surface within the band, are noise; those that come between frames without any are a slow tracker's
 * differences, and its poses count alone. A way of more than 6 r and 12 bands in a frame that needs more than 50 m/s^2
 * is a jump whatever velocity tells it: that of a late frame whose time step was cut. A collider that comes new with a
 * velocity is believed at once. What a told velocity has and its pose does not go, for 0.1 s or in a frame in which it
 * changes, drags sand along faces and pushes none: a belt, a treadmill.
 *
 * Identity. A collider is recognised from frame to frame by its `id`; without one by an equal pose, else as the nearest
 * of its shape. Its place in the list decides between those that are equally near. One that is not recognised, that
 * went more than 0.25 m in a frame (1 m with an id), or that was left out for 0.25 s, is new: it is where it is told
 * to be.
 *
 * Carried. A frame ends with colliders where they are told to be, whatever it could afford to simulate: sand is never
 * more than r / 2 behind, or r where one ball or box alone moves. Time that is given up moves a collider together with
 * what it holds, rigidly: what a field that is solid outside encloses, and what lies on it, along gravity, in the box
 * around all colliders that go its way. What only lies on a ball or a box goes as far as friction takes it. What is in
 * the way goes before it or aside, and pushes on what is in its way. In slow motion sand feels a collider slower than
 * told, by as much as time is short, so that what speeds up or brakes throws no more than it should. A frame
 * longer than 0.1 s, a jump, and what poses did while frames were paused or told too short carry, too: what is
 * enclosed, and what stands in a vessel of several colliders; of those pass ids. */
typedef struct sandglass_collider {
  /* What `size` means. */
  sandglass_shape shape;
  /* World, metres. */
  float position[3];
  /* Local to world, (x, y, z, w), of any length above 0. */
  float rotation[4];
  /* Metres, above 0; see sandglass_shape. */
  float size[3];
  /* World, m/s, at most 10,000 along each axis. */
  float linear_velocity[3];
  /* World, rad/s, about `position`, at most 10,000 about each axis. */
  float angular_velocity[3];
  /* 1: particles do not see it. For the shape of a rigid body, whose particles stand for it. */
  uint32_t grains_only;
  /* For SANDGLASS_SHAPE_FIELD: it must stay valid during the frame (field.h). Walls thinner than two steps of a grain,
   * 2 * refine_step * speed, let fast grains through: make containers SANDGLASS_SOLID_OUTSIDE. */
  const struct sandglass_field* field;
  /* Any number that stays with the collider from frame to frame, and that no other in the list has. 0: it has none, and
   * is recognised by its pose. Sinks and regions need none. */
  uint32_t id;
} sandglass_collider;

/* The collider at this place of the last frame's list, counted from 0, as sand met it, in *held: pose, sizes and
 * velocities. It differs from what was told by up to granular.collider_band, by more until a jump is followed. Returns
 * 1 where there is one. Else, where the collider was left out, and from a save, restore or reset until the next frame,
 * it returns 0, and *held stays as it was. */
SANDGLASS_API int32_t sandglass_granular_held_collider(const sandglass_scene* scene, uint32_t index,
                                                       sandglass_collider* held);

/* Where removed particles and grains are said to be: (0, SANDGLASS_REMOVED_Y, 0), beyond every far plane. */
#define SANDGLASS_REMOVED_Y (-1e6f)

/* A grain as the app's buffer receives it. */
typedef struct sandglass_grain {
  /* World, metres. */
  float position[3];
  /* m/s, for shading, level of detail or sound. Below 0: the grain was removed. */
  float speed;
} sandglass_grain;

/* Stages, in the order in which a frame runs them. */
typedef int32_t sandglass_stage;
enum {
  SANDGLASS_STAGE_GRANULAR = 0,
  SANDGLASS_STAGE_LIGHTING = 1,
  SANDGLASS_STAGE_SKIN = 2,
  SANDGLASS_STAGE_SHADOW = 3,
  SANDGLASS_STAGE_REFINE = 4,
  SANDGLASS_STAGE_OUTPUT = 5,
  SANDGLASS_STAGE_COUNT = 6
};

/* What reports, traces and recordings call a stage, such as "granular". NULL where there is no such stage. */
SANDGLASS_API const char* sandglass_stage_name(uint32_t stage);

/* The most runs that a plan has. */
enum { SANDGLASS_PLAN_RUNS = 48 };

/* Consecutive work units of one stage. */
typedef struct sandglass_plan_run {
  /* A sandglass_stage. */
  uint32_t stage;
  /* How many. */
  uint32_t units;
} sandglass_plan_run;

/* The executed plan: what a frame did, in order. Given back to sandglass_scene_frame with the same input on the same
 * state, it reproduces the frame to the bit, on any instruction set and with any pool. The state includes that of the
 * shadows and the light in the input, whose work units are part of the plan. All of it then counts as mandatory. */
typedef struct sandglass_plan {
  uint32_t struct_size;
  /* The quality level. */
  uint32_t level;
  /* In the order in which they ran. */
  sandglass_plan_run runs[SANDGLASS_PLAN_RUNS];
  /* How many of `runs` are used. */
  uint32_t run_count;
} sandglass_plan;

/* A nozzle that pours sand for as long as it is passed to frames. It pours layers of a hexagonal lattice with the
 * density of packed sand, one whenever the layer before has gone far enough: about 0.5 R^2 speed / r^3 particles a
 * second, with R the nozzle's radius and r that of a particle. Every layer comes at its own moment, so a jet is the
 * same at any frame rate, and stretches without gaps. A layer for which there is no room is left out, counted and
 * logged. Numbers of removed particles and grains are used again, so a scene with a sink pours for ever.
 *
 * No particle comes where it would overlap another one or a collider. One whose place is not free comes up to 1.65 r
 * behind it, against the jet. If that is not enough, or if its surface would be more than 0.1 r inside a collider once
 * it has gone on by r, it is left out, counted and logged. So a nozzle that is blocked pauses, in part or wholly, and
 * what it pours into is not thrown about. Keep 2 r before the nozzle free of colliders. Sand does not take over the
 * velocity of a nozzle that is moved. */
typedef struct sandglass_emitter {
  /* Of the nozzle's centre, world, metres. */
  float position[3];
  /* Local to world, (x, y, z, w); sand leaves along local -y. */
  float rotation[4];
  /* Metres, 1 to 100 particle radii. */
  float radius;
  /* m/s, above 0, at most 100. Sand faster than courant * r / substep_min is slowed to it. */
  float speed;
  /* 0..64, at random places within a particle. */
  uint32_t grains_per_particle;
} sandglass_emitter;

/* What one frame is given. */
typedef struct sandglass_frame_input {
  uint32_t struct_size;
  /* Seconds of simulated time to advance; at most 0.1 is taken. Where it is not finite or not above 0, the frame is a
   * pause: no particle, grain or body moves, nothing is poured or drained, nothing wakes or falls asleep, however much
   * time is owed. Time debt and grain_lag stay, and frames after the pause make them up. Colliders may be moved
   * meanwhile: that counts when time goes on. Grains are written, lights and shadows go on. Calls between frames work
   * as ever; a save still finishes the step of the grains. */
  float time_step;
  /* Nanoseconds that the frame may take by the scene's clock. 0 runs the mandatory part only. */
  uint64_t budget_ns;
  /* The share of the budget, 0..1, that the device can sustain without getting too hot: the frame is planned for
   * budget_ns times it. Default: 1, which anything above 1 or not a number counts as too; below 0 counts as 0. It is
   * not the number that Android calls headroom, in which 1 is hot. */
  float thermal_headroom;
  /* Colliders that are not usable or beyond collider_capacity are left out, and reported. */
  const sandglass_collider* colliders;
  /* How many colliders there are. */
  uint32_t collider_count;
  /* Emitters that are not usable or beyond emitter_capacity are left out, and reported. */
  const sandglass_emitter* emitters;
  /* How many emitters there are. */
  uint32_t emitter_count;
  /* Shapes that remove the sand whose centres come inside, and the rigid bodies all of whose particles' centres do. A
   * body goes as by sandglass_granular_remove_body: ask sandglass_granular_has_body where report.sand.removed_bodies
   * has changed. They are checked every 20 ms of simulated time; velocities mean nothing. Sand and bodies that are
   * asleep stay until they wake. Sinks that are not usable or beyond sink_capacity are left out, and reported. */
  const sandglass_collider* sinks;
  /* How many sinks there are. */
  uint32_t sink_count;
  /* Seconds, 0..0.1: grains are written where they were so long before the time of the state, for displays faster than
   * the simulation. 0: the newest. */
  float output_lag;
  /* Receives one sandglass_grain for each number that a grain has or had: report.sand.grain_numbers of them, but no
   * more than grain_capacity. Draw those whose speed is not below 0. NULL: none wanted. */
  sandglass_grain* grains;
  /* Bytes from one item to the next: a multiple of 4, at least sizeof(sandglass_grain), which is the default. */
  uint32_t grain_stride;
  /* How many items fit. */
  uint32_t grain_capacity;
  /* Frames since the library wrote this very buffer, with the same stride, capacity and output_lag: 1 where it is always
   * the same one, 3 where three take turns. Only what has changed since is written. 0 (the default): unknown, and all
   * is written; say so too after a lost graphics context. */
  uint32_t grains_age;
  /* NULL, or the skin of the sand to bring up to date (skin.h). One work unit runs in every second frame whatever the
   * budget, more as it admits. */
  struct sandglass_skin* skin;
  /* The shadows to bring up to date (shadow.h). One work unit a frame runs whatever the budget, more as it admits. Pass
   * all objects whose shadows are seen. None may be NULL. */
  struct sandglass_shadow* const* shadows;
  /* How many shadows there are. */
  uint32_t shadow_count;
  /* NULL, or the shadow of the sand (pile_shadow.h): of its grains where it has any, else of its particles. It and the
   * shadows of objects are brought up to date in turns. */
  struct sandglass_pile_shadow* pile_shadow;
  /* The casts to bring up to date (cast.h), in turns with the two above. None may be NULL. */
  struct sandglass_cast* const* casts;
  /* How many casts there are. */
  uint32_t cast_count;
  /* NULL, or the estimator to bring up to date (estimate.h). One work unit a frame runs whatever the budget, more as it
   * admits. An image that is taken is resampled in the frame that takes it, whatever the budget. */
  struct sandglass_estimator* estimator;
  /* NULL, or the room that the camera's images are gathered in (room.h). It takes an image when its own interval has
   * passed; the image is then read in this frame, whatever the budget. */
  struct sandglass_room* room;
  /* NULL, or the newest image. The estimator passes it over while an estimate is under way, and until its interval has
   * passed. It is read in this call only. */
  const struct sandglass_camera_image* camera;
  /* NULL, or a recorded plan to execute: the clock then decides nothing. */
  const sandglass_plan* plan;
} sandglass_frame_input;

/* Fills *input with the defaults: nothing but thermal_headroom 1 and grain_stride sizeof(sandglass_grain). */
SANDGLASS_API void sandglass_frame_input_default(sandglass_frame_input* input);

/* What one stage did in a frame. */
typedef struct sandglass_stage_report {
  /* Work units that were executed. */
  uint32_t units;
  /* 1: the stage had work left that the budget did not admit. */
  uint32_t denied;
  /* By the scene's clock; 0 without one. */
  uint64_t elapsed_ns;
} sandglass_stage_report;

/* The time of a frame: what it took by the scene's clock, and how far simulated time has come. */
typedef struct sandglass_time_report {
  /* The budget that the frame was given. */
  uint64_t budget_ns;
  /* budget_ns times thermal_headroom: the target duration of a performance hint session. */
  uint64_t target_ns;
  /* The actual duration of that session. */
  uint64_t elapsed_ns;
  /* The part of elapsed_ns that is done whatever the budget. */
  uint64_t mandatory_ns;
  /* The last work unit, plus what output took beyond its own prediction; see sandglass_scene_frame. */
  uint64_t last_unit_ns;
  /* The longest work unit of the frame. */
  uint64_t longest_unit_ns;
  /* 1: the clock went backward, stood still or jumped, and the frame ended at its cap of work units. */
  uint32_t clock_fault;
  /* Seconds simulated since create or reset. */
  double simulated;
  /* Seconds that were asked for since then and not simulated. Later frames make up two frames' worth; what is beyond
   * that is given up and stays in this sum. 0: no slow motion. */
  double debt;
} sandglass_time_report;

/* The sand and the rigid bodies after a frame, what the frame did and left out, and totals since create or reset. */
typedef struct sandglass_sand_report {
  /* Particles in the scene, and those of them that are not asleep. */
  uint32_t particles, awake;
  /* Grains in the scene, and those of the last pass over them that were not asleep, in whole groups of 16. */
  uint32_t grains, awake_grains;
  /* Numbers given out so far: the length of what sandglass_granular_particles writes, and sandglass_granular_grains. */
  uint32_t particle_numbers, grain_numbers;
  /* Seconds of simulated time: that which the grains have reached (the particles, in a scene without grains), and an even
   * one to draw, never beyond it. They are equal without slow motion. In it grains move in some frames and stand in the
   * others, so an app draws them 5 to 15 ms later, between its last two buffers:
   *     if (report.sand.grains_time > newer.time) older = newer, newer = this buffer and its grains_time;
   *                                               (else this buffer is written again in the next frame)
   *     share = (shown_time - older.time) / (newer.time - older.time), from 0 to 1      once a frame
   *     position = older.position + share * (newer.position - older.position)           in the vertex shader
   * A grain whose speed is below 0 in one of the two was removed or is new: it is drawn as in the newer one. So is one that
   * moved further than its speeds explain: its number was given anew. After move, restore and reset begin anew. */
  double grains_time, shown_time;
  /* Seconds by which the oldest grain is behind the particles. Never ten frames: simulated time slows before. */
  float grain_lag;
  /* Seconds: the length of the last sub-step. */
  float substep;
  /* m/s: the fastest particle in the last sub-step, of those that can reach something. */
  float speed_max;
  /* Sub-steps that were completed in this frame, and neighbour lists that were built. */
  uint32_t substeps, list_builds;
  /* Neighbours beyond the capacity of a list (32), summed over the list builds of the frame. 0 in any packing. */
  uint32_t dropped_contacts;
  /* Particles and grains that were found not finite, or beyond twice the coordinate limit, and put to rest inside. */
  uint32_t quarantined;
  /* What this frame left out: not finite, without size, or beyond its capacity. */
  uint32_t ignored_colliders, ignored_emitters, ignored_sinks;
  /* 1: the grid by which grains follow the particles had no room for some place in the last pass. Grains there follow
   * more roughly. It has room for sand of the scene's capacity, but not strewn thinly over wide floors. */
  uint32_t grid_full;
  /* What emitters added in all. */
  uint64_t emitted_particles, emitted_grains;
  /* Particles that emitters left out: for want of capacity, or because something was in their place. */
  uint64_t denied_particles;
  /* What sinks, sandglass_granular_remove and sandglass_granular_remove_body took away in all, what fell by
   * granular.lowest, and what left the coordinate limit. The particles of bodies count among the particles. */
  uint64_t removed_particles, removed_grains, removed_bodies;
} sandglass_sand_report;

/* Numbers that grow when a byte of what they stand for has changed, also by calls between frames (then in the next
 * frame's report), and else only by sandglass_scene_restore, _move and _reset. Textures, casts and skins have their own. */
typedef struct sandglass_version_report {
  /* What is written to input.grains. */
  uint64_t grains;
  /* The poses of the rigid bodies. */
  uint64_t bodies;
  /* The estimate of input.estimator. */
  uint64_t light;
  /* What input.room tells of its light: grows with each image that it learns from, and with each call that changes it. */
  uint64_t room;
} sandglass_version_report;

/* The shadows of objects that were in the input. */
typedef struct sandglass_shadow_report {
  /* Textures, over all shadows and lights, that are not yet those of their lights; ambient shadows that are not yet those
   * of their cells; and textures of casts that are out of date. */
  uint32_t pending;
  /* Calls of set_light since the oldest texture of a light among them was begun. */
  uint32_t calls_behind;
} sandglass_shadow_report;

/* The estimate of input.light, and the camera's image. */
typedef struct sandglass_estimate_report {
  /* 1: there is one. */
  uint32_t valid;
  /* 1: it changed in this frame. */
  uint32_t changed;
  /* Frames with this estimator since the frame that brought the image of its last estimate. */
  uint32_t frames_behind;
  /* Work units left of the estimate under way. */
  uint32_t units_left;
  /* 1: input.camera cannot be used. sandglass_camera_check and the log hook say why. */
  uint32_t ignored_images;
} sandglass_estimate_report;

/* What a frame did: a group for each capability, which is all 0 where the frame has none of it. runtime/README.md says
 * how to read it. */
typedef struct sandglass_frame_report {
  uint32_t struct_size;
  /* The quality level: 0 is full; see sandglass_level_name. */
  uint32_t level;
  /* Frames since create or reset, this one included. */
  uint64_t frame;
  /* What was executed: record it to replay the frame. */
  sandglass_plan plan;
  /* How long it took. */
  sandglass_time_report time;
  /* What each sandglass_stage did. */
  sandglass_stage_report stages[SANDGLASS_STAGE_COUNT];
  /* The material. */
  sandglass_sand_report sand;
  /* What an app draws: where these are as they were, and the camera stands still, nothing need be drawn or uploaded. */
  sandglass_version_report versions;
  /* Those of objects. */
  sandglass_shadow_report shadows;
  /* Of the light. */
  sandglass_estimate_report estimate;
} sandglass_frame_report;

/* Advances the scene by one frame. Simulated time moves on by input->time_step plus the time debt of earlier frames, as
 * far as the budget admits; without a time step it is a pause, and nothing moves. At most two frames' worth of debt is
 * made up; the rest is given up, as slow motion, and stays counted in report.time.debt. After the call, positions are
 * valid and grains are written, whatever the budget was.
 *
 * `report` is optional. The frame does not fail for lack of time: it degrades, along the quality ladder, and the report
 * says so. So its status need not be looked at once an app works. It fails with INVALID_ARGUMENT: NULL, a wrong or
 * unset struct_size, a grain_stride that is not usable, an array that is NULL while its count is above 0, or NULL among
 * the shadows or casts; nothing was changed. It fails with REPLAY: input->plan is malformed, and nothing was changed; or the
 * plan asks for a work unit that this state does not offer. Then the frame ended there: the scene is valid, but it is
 * not the recorded one. Reset it.
 *
 * Guarantee, for a clock that runs: elapsed_ns <= max(target_ns, mandatory_ns) + last_unit_ns. A frame is at most one
 * work unit late, plus what writing the grains, which comes last and is always done, took beyond its own prediction. */
SANDGLASS_API sandglass_status sandglass_scene_frame(sandglass_scene* scene, const sandglass_frame_input* input,
                                                     sandglass_frame_report* report, const char** reason);

/* ------------------------------------------------------------------------------------------------ reading the state */

/* Copies the present particles by number: the order in which they were added, except that new ones take over the
 * numbers of removed ones. `positions` (metres) and `velocities` (m/s) are optional; each takes 3 floats for each of
 * report.sand.particle_numbers items. Removed particles are at SANDGLASS_REMOVED_Y, at rest. For tests and tools, not
 * for every frame. */
SANDGLASS_API void sandglass_granular_particles(const sandglass_scene* scene, float* positions, float* velocities);

/* The same for grains: report.sand.grain_numbers items. */
SANDGLASS_API void sandglass_granular_grains(const sandglass_scene* scene, float* positions, float* velocities);

/* What a ray can hit. */
typedef int32_t sandglass_hit;
enum { SANDGLASS_HIT_NOTHING = 0, SANDGLASS_HIT_SAND = 1, SANDGLASS_HIT_BODY = 2 };

/* Where a ray meets sand or a body. */
typedef struct sandglass_ray_hit {
  /* What it hit; with NOTHING, all that follows is 0. */
  sandglass_hit what;
  /* SAND: the number of the particle, as in sandglass_granular_particles. BODY: the index of the body. */
  uint32_t index;
  /* From the origin, metres. 0: the ray begins inside a particle. */
  float distance;
  /* World, metres. */
  float point[3];
  /* Of the particle's sphere at that point, of length 1: its centre is at point - r * normal. Where the ray begins
   * inside the sphere, it is the direction from its centre to the origin, or against the ray where they coincide. */
  float normal[3];
} sandglass_ray_hit;

/* The first particle, of sand or of a body, awake or asleep, that a ray meets: from a finger on the screen to a place
 * on the sand. Origin and direction are in the world; the direction has any length above 0. Returns 1 where the ray
 * meets one within `reach` metres, which may be INFINITY. Else it returns 0, also where origin or direction is not
 * finite, the direction has no length, or reach is not above 0. *hit is written in both cases.
 *
 * Particles are spheres of radius r, as physics sees them now: between two of them a ray goes deeper. Where two are
 * equally near, the lower number counts. Grains, colliders and boundary particles are not hit. For a normal of the heap
 * rather than of one sphere, take the mean over some rays about the first. The call looks at every particle once: some
 * 30 microseconds for 14,000 on a workstation. */
SANDGLASS_API int32_t sandglass_granular_ray(const sandglass_scene* scene, const float origin[3],
                                             const float direction[3], float reach, sandglass_ray_hit* hit);

/* A 64-bit hash of the sand: the sum over all particles and grains of FNV-1a over (kind, number, position, velocity).
 * For a particle of a rigid body the second value holds the number of the particle and that of the body.
 * The hash is equal on every instruction set, compiler and thread count. */
SANDGLASS_API uint64_t sandglass_scene_hash(const sandglass_scene* scene);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_SANDGLASS_H */
