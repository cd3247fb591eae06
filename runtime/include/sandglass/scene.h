/* Sandglass scene: what a scene is, making it in the app's block, moving, saving and restoring it.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_SCENE_H
#define SANDGLASS_SCENE_H

#include "sandglass/sand.h"
#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

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

/* A 64-bit hash of the sand: the sum over all particles and grains of FNV-1a over (kind, number, position, velocity).
 * For a particle of a rigid body the second value holds the number of the particle and that of the body.
 * The hash is equal on every instruction set, compiler and thread count. */
SANDGLASS_API uint64_t sandglass_scene_hash(const sandglass_scene* scene);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_SCENE_H */
