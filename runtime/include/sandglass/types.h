/* Sandglass types: what all public headers share. It holds the version, the status codes, the hooks of the app (clock,
 * worker pool, trace, log), the instruction sets, and the rules below, which hold for every public function.
 *
 * sandglass.h and every header beside it include this one; an app need not.
 *
 * Units. SI: metres, seconds, kilograms, radians. A name that ends in _ns or _deg is of nanoseconds or degrees. The
 * world frame is right-handed with y up. Quaternions are (x, y, z, w). All numbers are `float` where nothing else is
 * said. Positions are relative to a scene origin that the app chooses. Keep them within SANDGLASS_COORDINATE_LIMIT of
 * it. An array is a pointer, then its count. Truth values in structs are `uint32_t`, 1 or 0.
 *
 * Results. A function returns a status, a value or nothing.
 *   - Only one with a status can fail. It takes `reason`, which may be NULL. On failure it stores one static sentence
 *     in *reason: what is wrong, where, and what to do. On success it stores NULL there. A function that fails has
 *     changed nothing, except where its comment says so.
 *   - Where there is no value to return, it is the neutral one: 0, NULL, or the identity pose. A function that answers
 *     yes or no returns 1 or 0 as an `int32_t`.
 *
 * NULL. One rule holds for every pointer that is not documented as optional:
 *   - A function that returns a status refuses NULL with SANDGLASS_ERROR_INVALID_ARGUMENT; *reason names the argument.
 *   - A function that returns nothing does nothing; one that returns a value returns the neutral one.
 * `reason` is always optional. So is the `user` pointer of a callback. An array may be NULL when its count is 0.
 * This header does not protect an app from a pointer that is neither NULL nor valid.
 *
 * Version and ABI. SANDGLASS_VERSION is the version of the headers, sandglass_version() that of the linked library.
 * Before 1.0 a new minor version may change anything; from 1.0 on only a new major version may break an app. A patch
 * version changes no header. CHANGELOG.md names every change that breaks source code or saved data. An app, and above
 * all one that links a shared library, begins with
 *
 *     if (!SANDGLASS_VERSION_FITS()) return fail("the library is of another version than its headers");
 *
 * because a `_default` function writes the whole struct as the library knows it.
 *
 * Structs are of three kinds:
 *   - Structs that begin with `struct_size` may grow, at their end only. The `_default` function of the struct sets
 *     struct_size. Where there is no such function, the app sets it to sizeof the struct before every call.
 *       - A struct that the library reads must have the size that the library knows, or it is refused.
 *       - In a struct that the library fills (a report, an estimate, a texture, an info), no byte beyond struct_size is
 *         written, and struct_size then says how many were. A struct_size below 8 counts as not set: a function with a
 *         status refuses it, any other leaves the struct as it is.
 *       - A report's plan is read again when it is replayed, so it must be whole. What is converted for a renderer
 *         (renderers.h) may be that of an older header.
 *       - In a struct that the library owns (sandglass_level), struct_size says which fields exist.
 *   - sandglass_granular_desc is the last member of sandglass_scene_desc and grows with it, at its end only.
 *   - All other structs are frozen from 1.0 on: sandglass_clock, _parallel, _trace, _log, _reference_scheme, _region,
 *     _collider, _body_pose, _emitter, _grain, _plan_run, _stage_report, _ray_hit, _mesh, _points and the groups of a
 *     report (_time_report, _sand_report, _shadow_report, _estimator_report) keep their size and fields, because they
 *     stand in arrays, in other structs or by value. What they lack then comes as a new struct and a new function; what
 *     a group lacks, as a new group at the end of its report. Before 1.0 a minor version may add a field at the end, 0
 *     of which means what held before (sandglass_collider.id): fill such a struct with zeros first.
 *
 * Enumerations are 32-bit integers; new values are added at the end. */
#ifndef SANDGLASS_TYPES_H
#define SANDGLASS_TYPES_H

#include <stddef.h>
#include <stdint.h>

/* Attributes in brackets, where the language has them: C++17 and C23. */
#if defined(__cplusplus) ? __cplusplus >= 201703L : defined(__STDC_VERSION__) && __STDC_VERSION__ > 201710L
#define SANDGLASS_BRACKETS 1
#else
#define SANDGLASS_BRACKETS 0
#endif

/* The static archive hides the API: the app that links it finds it all the same, and a shared library made of that app
 * does not export it. Only the build of the plug-in, which must export it, defines SANDGLASS_EXPORTS. */
#if !defined(SANDGLASS_EXPORTS)
#define SANDGLASS_API
#elif defined(_WIN32)
#define SANDGLASS_API __declspec(dllexport)
#elif SANDGLASS_BRACKETS
#define SANDGLASS_API [[gnu::visibility("default")]]
#else
#define SANDGLASS_API __attribute__((visibility("default")))
#endif

/* A status that nobody looks at is a warning, and a cast to void silences it. Only [[nodiscard]] does both: GCC's
 * attribute for older languages warns in spite of the cast, so older languages have none. */
#if SANDGLASS_BRACKETS
#define SANDGLASS_NODISCARD [[nodiscard]]
#else
#define SANDGLASS_NODISCARD
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ version */

/* From 1.0 on, only a new one may break an app. */
#define SANDGLASS_VERSION_MAJOR 0
/* Before 1.0, a new one may break an app. */
#define SANDGLASS_VERSION_MINOR 2
/* A new one changes no header but this line. */
#define SANDGLASS_VERSION_PATCH 0

/* One number for the three: 1,000,000 major + 1,000 minor + patch. */
#define SANDGLASS_VERSION (1000000 * SANDGLASS_VERSION_MAJOR + 1000 * SANDGLASS_VERSION_MINOR + SANDGLASS_VERSION_PATCH)

/* The SANDGLASS_VERSION of the library that is linked. */
SANDGLASS_API uint32_t sandglass_version(void);

/* 1 if the linked library fits the headers that this line is compiled with, else 0: major and minor version are the
 * same. Ask it before any other call. */
#define SANDGLASS_VERSION_FITS() (sandglass_version() / 1000u == SANDGLASS_VERSION / 1000u)

/* Coordinates farther from the scene origin than this, in metres, are refused. A float resolves 6e-5 m there, and the
 * contacts of centimetre particles lose their meaning. Move the scene origin instead. */
#define SANDGLASS_COORDINATE_LIMIT 1000.0f

/* ------------------------------------------------------------------------------------------------ status */

/* What a function that can fail returns. */
typedef int32_t sandglass_status;
enum {
  /* The call did what it was asked for. */
  SANDGLASS_OK = 0,
  /* An argument or a field is out of range or not finite, or a pointer is NULL. */
  SANDGLASS_ERROR_INVALID_ARGUMENT = 1,
  /* The block is smaller than the need. */
  SANDGLASS_ERROR_MEMORY_TOO_SMALL = 2,
  /* The block is not aligned to SANDGLASS_BLOCK_ALIGNMENT. */
  SANDGLASS_ERROR_MEMORY_ALIGNMENT = 3,
  /* There are more items than there is room for. */
  SANDGLASS_ERROR_CAPACITY = 4,
  /* This CPU or this build lacks what was asked for. */
  SANDGLASS_ERROR_UNSUPPORTED = 5,
  /* A recorded plan does not fit this scene. */
  SANDGLASS_ERROR_REPLAY = 6
};

/* The name of a status, such as "SANDGLASS_ERROR_CAPACITY". Never NULL; "unknown status" for any other number. */
SANDGLASS_API const char* sandglass_status_name(sandglass_status status);

/* The alignment, in bytes, of every block of memory that an app hands over. */
#define SANDGLASS_BLOCK_ALIGNMENT 64

/* ------------------------------------------------------------------------------------------------ hooks */

/* Nanoseconds since any origin. */
typedef uint64_t (*sandglass_clock_function)(void* user);

/* A clock. It should not go backward. If it does, nothing breaks: the frame ends at its cap of work units, with a valid
 * state. now_ns == NULL means "no clock": every frame runs all its work. */
typedef struct sandglass_clock {
  /* The time now. */
  sandglass_clock_function now_ns;
  /* Handed to now_ns. */
  void* user;
} sandglass_clock;

/* The monotonic clock of the platform: CLOCK_MONOTONIC, or mach_absolute_time on Apple. On the web, what the page
 * hands in: toolchains/web/sandglass.mjs takes performance.now(). */
SANDGLASS_API sandglass_clock sandglass_clock_system(void);

/* A part of a piece of work. */
typedef void (*sandglass_task_function)(void* context, uint32_t index);
/* Calls task(context, index) once for each index below count, on any threads, in any order, and waits for all. */
typedef void (*sandglass_parallel_function)(void* user, sandglass_task_function task, void* context, uint32_t count);

/* A worker pool of the app. Results do not depend on it. run == NULL: the calling thread does everything.
 *
 * A pool that leaves calls out, repeats one that it has begun, or makes one with an index beyond count - 1 does no harm:
 * what is missing runs on the calling thread, the rest does nothing. What is not protected: a pool that returns while a
 * call still runs or is still to come, or that makes two calls with one index at the same moment. */
typedef struct sandglass_parallel {
  /* Runs a piece of work. */
  sandglass_parallel_function run;
  /* Handed to run. */
  void* user;
} sandglass_parallel;

/* Is called with the name of a work unit, a static string such as "granular.solve". */
typedef void (*sandglass_trace_function)(void* user, const char* name);

/* A profiling hook, on the thread that called sandglass_scene_frame. Either function may be NULL. */
typedef struct sandglass_trace {
  /* Called before every work unit, and after it. */
  sandglass_trace_function begin, end;
  /* Handed to both. */
  void* user;
} sandglass_trace;

/* The profiler of the platform as a trace hook. Android: sections of ATrace, seen in Perfetto and Android Studio (link
 * with -landroid). Apple: signpost intervals of the subsystem "sandglass", seen in Instruments. Elsewhere both members
 * are NULL. Call it once, before the scenes are created: on Apple the system makes a log object for the process. */
SANDGLASS_API sandglass_trace sandglass_trace_system(void);

/* Receives a sentence, which is static. */
typedef void (*sandglass_log_function)(void* user, const char* sentence);

/* A log hook: what an app developer should know, such as that a capacity was reached or a particle was quarantined. */
typedef struct sandglass_log {
  /* May be NULL. Called at most once per kind of event and frame. */
  sandglass_log_function write;
  /* Handed to write. */
  void* user;
} sandglass_log;

/* ------------------------------------------------------------------------------------------------ instruction sets */

/* Which kernels to use. All give the same bits. AUTOMATIC takes the fastest that the CPU has.
 *
 * NEON_DOTPROD is NEON with SDOT, NEON_I8MM is NEON with SMMLA. The light and the shadows of objects have kernels for
 * each; sand and its shadow then run those of NEON. For the light and the shadows of objects, AVX512 means AVX-512 with
 * VNNI. WASM is the 128-bit SIMD of WebAssembly. */
typedef int32_t sandglass_isa;
enum {
  SANDGLASS_ISA_AUTOMATIC = 0,
  SANDGLASS_ISA_SCALAR = 1,
  SANDGLASS_ISA_NEON = 2,
  SANDGLASS_ISA_AVX2 = 3,
  SANDGLASS_ISA_AVX512 = 4,
  SANDGLASS_ISA_NEON_DOTPROD = 5,
  SANDGLASS_ISA_NEON_I8MM = 6,
  SANDGLASS_ISA_WASM = 7
};

/* The name of an instruction set: "automatic", "scalar", "neon", "avx2", "avx512", "neon_dotprod", "neon_i8mm" or
 * "wasm". NULL for any other number. */
SANDGLASS_API const char* sandglass_isa_name(sandglass_isa isa);

/* 1 if this build has kernels for `isa` and this CPU can run them, else 0. AUTOMATIC and SCALAR are always
 * available. */
SANDGLASS_API int32_t sandglass_isa_available(sandglass_isa isa);

/* ------------------------------------------------------------------------------------------------ rotations */

/* The rotation by `angle` radians about `axis`, as a quaternion (x, y, z, w). The axis may have any length above 0.
 * Seen from its tip, a positive angle turns counter-clockwise. Returns 1. Where the axis is not finite or has no
 * length, or the angle is not finite, it gives the identity and returns 0. */
SANDGLASS_API int32_t sandglass_rotation_about(const float axis[3], float angle, float rotation[4]);

/* ------------------------------------------------------------------------------------------------ light cells */

/* The light that a level floor receives, by where it comes from: the upper hemisphere in 64 cells, 4 rings of 16
 * sectors, in the world frame. Cell i is sector i % 16 of ring i / 16.
 *   - Sector s covers the azimuths from s to s + 1 times 22.5 degrees. The azimuth is 0 along +x and 90 degrees along
 *     +z.
 *   - Rings 0 to 3 cover the elevations 0 to 30, 30 to 45, 45 to 60 and 60 to 90 degrees.
 * Under an even sky every cell gives a level floor the same irradiance. An array of cells holds the share of the
 * floor's irradiance that comes from each; all shares together are 1, or less where a part is drawn in another way. */
#define SANDGLASS_LIGHT_CELLS 64

/* ------------------------------------------------------------------------------------------------ textures */

/* A square texture on a plane, as it is now. Its bytes are stable until units are run again. */
typedef struct sandglass_texture {
  uint32_t struct_size;
  /* 0: none was completed yet; the bytes then say that nothing is hidden. */
  uint32_t valid;
  /* layers * side rows of side texels, row after row. NULL: the description has none. */
  const uint8_t* bytes;
  /* Texels along a side. */
  uint32_t side;
  /* 0: it shows what is now. Else so many frames, or calls that set what it shows, have passed since it was begun. */
  uint32_t behind;
  /* Where it lies, metres: its first corner, the edge along a row, and the edge across the rows. In the world, of a baked
   * object in its mesh's coordinates. */
  float corner[3], along[3], across[3];
  /* What 255 stands for. Of a light's shadow its opacity: 1, and less for a light that is too low to be followed. */
  float scale;
  /* Of a light's shadow, but not of the sand's: the unit vector towards the light that it was made for. */
  float light[3];
  /* Another one when a byte has changed: upload it then. 0: none was completed. */
  uint64_t version;
  /* How many images of side x side `bytes` holds, from the plane up: 1, but of a cast with layers (cast.h). */
  uint32_t layers;
  /* Of a cast alone. Metres: the height of the highest layer. */
  float height;
  /* Of a cast alone, world. What is m metres above the plane reads the texture at place - m * slide, which is in the plane.
   * It is along the light; of an ambient texture it is the normal. */
  float slide[3];
} sandglass_texture;

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_TYPES_H */
