/* Sandglass types: what all public headers share. Version, coordinate limit, status codes, the app's hooks (clock,
 * worker pool, trace, log), instruction sets, and the handles of objects that a scene's frame brings up to date.
 *
 * sandglass.h and every header beside it include this one; an app need not.
 *
 * Conventions. SI units: metres, seconds, kilograms, radians. World frame right-handed, y up. Quaternions are (x, y, z,
 * w). `float` throughout. Positions are relative to a scene origin of the app's choice; keep them within
 * SANDGLASS_COORDINATE_LIMIT of it.
 *
 * Sizes. A struct that may grow begins with `struct_size`, set by its `_default` function or, where it has none, to
 * sizeof by the caller, before every call. One that the library reads must have the library's own size, or is refused.
 * Of one that it fills (a report, an estimate, a texture, an info), no byte beyond struct_size is written, and
 * struct_size then says how many were; below 8 it was not set: functions that can fail refuse it, others leave the
 * struct as it is. A report's plan is read again, and so must be whole; an estimate may be that of an older header. Of
 * the library's own (a level), it says which fields exist.
 *
 * Errors. Functions that can fail return a sandglass_status and, where `reason` is not NULL, store in it one static
 * sentence that says what is wrong, where, and what to do; on success it is set to NULL. A function that fails has
 * changed nothing. sandglass_scene_frame does not fail: it degrades, in a stated order, and says so in the report. */
#ifndef SANDGLASS_TYPES_H
#define SANDGLASS_TYPES_H

#include <stddef.h>
#include <stdint.h>

/* A shared library keeps all that it exports, used or not. So the static archive hides the API (inside the app that
 * links it, it is found as ever), and only the build of a shared library of it, the plug-in, defines SANDGLASS_EXPORTS.
 */
#if defined(SANDGLASS_EXPORTS)
#define SANDGLASS_API __attribute__((visibility("default")))
#else
#define SANDGLASS_API
#endif
#if defined(__GNUC__) || defined(__clang__)
#define SANDGLASS_NODISCARD __attribute__((warn_unused_result))
#else
#define SANDGLASS_NODISCARD
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define SANDGLASS_VERSION_MAJOR 0
#define SANDGLASS_VERSION_MINOR 1
#define SANDGLASS_VERSION_PATCH 0

/* Coordinates beyond this distance (metres) from the scene origin are refused: there a float resolves 6e-5 m, and
 * contacts between centimetre particles lose their meaning. Move the scene origin instead. */
#define SANDGLASS_COORDINATE_LIMIT 1000.0f

/* ------------------------------------------------------------------------------------------------ status */

typedef int32_t sandglass_status;
enum {
  SANDGLASS_OK = 0,
  SANDGLASS_ERROR_INVALID_ARGUMENT = 1, /* a field is out of range, not finite, or a pointer is NULL */
  SANDGLASS_ERROR_MEMORY_TOO_SMALL = 2, /* the block is smaller than the need; nothing was touched */
  SANDGLASS_ERROR_MEMORY_ALIGNMENT = 3, /* the block is not aligned to SANDGLASS_BLOCK_ALIGNMENT */
  SANDGLASS_ERROR_CAPACITY = 4,         /* more items than the description made room for; nothing was added */
  SANDGLASS_ERROR_UNSUPPORTED = 5,      /* this CPU or this build lacks what was asked for */
  SANDGLASS_ERROR_REPLAY = 6            /* a recorded plan does not fit this scene */
};

/* A short constant name of a status, "SANDGLASS_ERROR_CAPACITY" say; never NULL. */
SANDGLASS_API const char* sandglass_status_name(sandglass_status status);

/* Alignment in bytes that the scene's memory block must have. */
#define SANDGLASS_BLOCK_ALIGNMENT 64

/* ------------------------------------------------------------------------------------------------ hooks */

/* A clock. now_ns returns nanoseconds from any origin; it should not go backward, but nothing breaks if it does: the
 * frame then ends at its cap of units, with a valid state. now_ns == NULL means "no clock": every frame runs all its
 * work. */
typedef struct sandglass_clock {
  uint64_t (*now_ns)(void* user);
  void* user;
} sandglass_clock;

/* The platform's monotonic clock (CLOCK_MONOTONIC; mach_absolute_time on Apple), ready to be handed over. */
SANDGLASS_API sandglass_clock sandglass_clock_system(void);

/* A worker pool of the app's. run must call task(context, index) once for each index in 0..count-1, on any threads in
 * any order, and return when all calls have. Results do not depend on it. run == NULL: the calling thread does
 * everything. */
typedef struct sandglass_parallel {
  void (*run)(void* user, void (*task)(void* context, uint32_t index), void* context, uint32_t count);
  void* user;
} sandglass_parallel;

/* Profiling hook: `begin` and `end` bracket every work unit, `name` is a static string such as "granular.solve". Either
 * may be NULL. Called on the thread that called sandglass_scene_frame. */
typedef struct sandglass_trace {
  void (*begin)(void* user, const char* name);
  void (*end)(void* user, const char* name);
  void* user;
} sandglass_trace;

/* The platform's own profiler as a trace hook: sections of ATrace on Android (seen in Perfetto and Android Studio; link
 * with -landroid), signpost intervals of the subsystem "sandglass" on Apple (seen in Instruments); both members NULL
 * elsewhere. Call it once, before the scenes are created: on Apple the system makes a log object for the process. */
SANDGLASS_API sandglass_trace sandglass_trace_system(void);

/* Log hook: static sentences about things an app developer should know (a capacity reached, a quarantined particle).
 * May be NULL. Called at most once per kind of event and frame. */
typedef struct sandglass_log {
  void (*write)(void* user, const char* sentence);
  void* user;
} sandglass_log;

/* ------------------------------------------------------------------------------------------------ instruction sets */

/* Which kernels to use. All give the same bits; AUTOMATIC takes the fastest that the CPU has. NEON_DOTPROD is NEON with
 * SDOT, NEON_I8MM with SMMLA: shadows of networks and the light have a table for each, sand and its shadow run that of
 * NEON. Of shadows and light, AVX512 means AVX-512 with VNNI. */
typedef int32_t sandglass_isa;
enum {
  SANDGLASS_ISA_AUTOMATIC = 0,
  SANDGLASS_ISA_SCALAR = 1,
  SANDGLASS_ISA_NEON = 2,
  SANDGLASS_ISA_AVX2 = 3,
  SANDGLASS_ISA_AVX512 = 4,
  SANDGLASS_ISA_NEON_DOTPROD = 5,
  SANDGLASS_ISA_NEON_I8MM = 6
};

/* "scalar", "neon", "avx2", "avx512", "neon_dotprod", "neon_i8mm"; "automatic" for 0; NULL for any other number. */
SANDGLASS_API const char* sandglass_isa_name(sandglass_isa isa);

/* 1 if this build has kernels for `isa` and this CPU can run them, else 0. AUTOMATIC and SCALAR are always available.
 */
SANDGLASS_API int32_t sandglass_isa_available(sandglass_isa isa);

/* ------------------------------------------------------------------------------------------------ handles */

/* Objects that an app creates in blocks of its own and hands to sandglass_scene_frame: the shadows of one object
 * (shadow.h), the shadow that the sand casts (pile_shadow.h), the light of the room (light.h). */
typedef struct sandglass_shadow sandglass_shadow;
typedef struct sandglass_pile_shadow sandglass_pile_shadow;
typedef struct sandglass_light sandglass_light;

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_TYPES_H */
