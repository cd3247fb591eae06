/* Sandglass shadow: the soft shadow of one object on the plane that it stands on, from a network baked for that object
 * (`sandglass bake`), evaluated in pieces small enough for any frame (chapter 6 of the source).
 *
 * An app
 *   1. reads a baked file into memory (aligned to 8 bytes) and fills a sandglass_shadow_desc,
 *   2. asks sandglass_shadow_bytes, hands a block of that size to sandglass_shadow_create; the file's bytes may go
 * then,
 *   3. calls sandglass_shadow_set_light whenever it knows the light, every frame if it likes,
 *   4. calls sandglass_shadow_run in every frame, as many units as fit,
 *   5. draws the texture that sandglass_shadow_texture describes.
 *
 * A texture may take several frames; the one before it stays valid until it is complete. Nothing is allocated, no clock
 * is read, and the same bytes come out of every instruction set and every division into frames.
 *
 * The object's frame is that of the mesh that was baked: y up, metres. Turn the light into it: d_object =
 * R_world_to_object d_world (6.1). Coverage c (0..1, byte / 255) is 1 - transparency; the shadow's opacity is coverage
 * * opacity * the contrast level o of the light. */
#ifndef SANDGLASS_SHADOW_H
#define SANDGLASS_SHADOW_H

#include "sandglass/sandglass.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Instruction sets that only the int8 kernels tell apart from SANDGLASS_ISA_NEON: with SDOT, with SMMLA. Here
 * SANDGLASS_ISA_AVX512 means AVX-512 with VNNI. */
enum { SANDGLASS_ISA_NEON_DOTPROD = 5, SANDGLASS_ISA_NEON_I8MM = 6 };

/* Texels a side of the texture that networks are baked for. */
#define SANDGLASS_SHADOW_TEXELS 256

/* Which texels the network is asked for. ADAPTIVE: those of a coarse grid, one in 4 x 4, and all texels of cells whose
 * corners differ by more than `threshold`, and of the cells around those; the rest is interpolated (the default). FULL:
 * all. */
typedef int32_t sandglass_shadow_mode;
enum { SANDGLASS_SHADOW_ADAPTIVE = 0, SANDGLASS_SHADOW_FULL = 1 };

typedef struct sandglass_shadow_desc {
  uint32_t struct_size;
  sandglass_isa isa;
  const void* asset; /* a baked file, aligned to 8 bytes; needed until create returns */
  uint64_t asset_bytes;
  sandglass_shadow_mode mode;
  uint32_t threshold; /* steps of 1/255 of coverage, 0..255; default 5 (0.02), which adds less than 0.002 of error */
  float
      light_tolerance; /* radians, 0..1: the texture is computed anew when the light has turned by more; default 0.01 */
} sandglass_shadow_desc;

SANDGLASS_API void sandglass_shadow_desc_default(sandglass_shadow_desc* desc);

/* What a baked file says of itself. */
typedef struct sandglass_shadow_info {
  uint32_t struct_size;
  uint32_t version;
  float origin[3];      /* footprint's centre on the receiving plane, in the mesh's coordinates */
  float half_x, half_z; /* of the bounding box, metres */
  float height;
  float angular_diameter;      /* of the light, radians */
  float polar_max;             /* largest polar angle of the light that was baked, radians */
  uint32_t plane_fitted;       /* 1: the texture's rectangle follows the light; 0: one square for all lights (6.11) */
  uint32_t width, layers;      /* neurons a layer; hidden layers after the first */
  uint64_t macs_per_texel;     /* of the hidden layers, the first one separated */
  float rmse_float, rmse_int8; /* mean error against ray tracing over lights not trained on */
  uint32_t validated_lights;
  uint32_t float_parameters; /* of the network before rounding, if the file carries them, else 0 */
} sandglass_shadow_info;

/* Reads the file's description after the checks of sandglass_shadow_create. Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_inspect(const void* asset, uint64_t asset_bytes,
                                                                            sandglass_shadow_info* info,
                                                                            const char** reason);

typedef struct sandglass_shadow sandglass_shadow;

/* The exact number of bytes that sandglass_shadow_create needs. Fails with INVALID_ARGUMENT (a field out of range, a
 * file that is no shadow, damaged, cut off, or of another version) and UNSUPPORTED (isa). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_bytes(const sandglass_shadow_desc* desc,
                                                                          uint64_t* bytes, const char** reason);

/* Checks the whole file, lays out the block, and computes the tables of the network's first layer. There is nothing to
 * destroy. Fails as sandglass_shadow_bytes, and with MEMORY_TOO_SMALL and MEMORY_ALIGNMENT; nothing is touched then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_create(const sandglass_shadow_desc* desc,
                                                                           void* block, uint64_t bytes,
                                                                           sandglass_shadow** shadow,
                                                                           const char** reason);

/* The direction towards the light in the object's frame, of any length above 0. A texture under way is completed for
 * its own light first, so that one unit a frame is enough for textures to arrive. Lights steeper than polar_max are
 * followed exactly; beyond it the texture is that of polar_max at the same azimuth, and `opacity` falls linearly to 0
 * at the horizon. Fails with INVALID_ARGUMENT: a vector that is zero or not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_set_light(sandglass_shadow* shadow,
                                                                              const float direction[3],
                                                                              const char** reason);

/* Runs at most `units` work units of some tens of microseconds each; returns how many there were to run. 0: the texture
 * is that of the light. */
SANDGLASS_API uint32_t sandglass_shadow_run(sandglass_shadow* shadow, uint32_t units);

/* Work units until the texture of the present light is complete; an upper bound while the adaptive grid is not yet
 * decided. */
SANDGLASS_API uint32_t sandglass_shadow_units_left(const sandglass_shadow* shadow);

typedef struct sandglass_shadow_texture {
  uint32_t struct_size;
  uint32_t valid;          /* 0: no texture was completed yet; coverage is all 0 */
  const uint8_t* coverage; /* 256 x 256 bytes, row v along z, column u along x; stable until the next run call */
  float low[2], high[2]; /* x and z of the rectangle's corners in the mesh's coordinates, on the plane y = origin[1] */
  float light[3];        /* unit vector that the texture was computed for */
  float opacity;         /* 1, or less for a light beyond polar_max, 0 at and below the horizon */
  uint32_t beyond;       /* 1: the present light lies beyond polar_max */
  uint32_t age;          /* calls of set_light since the one that the texture was begun for; 0: none */
  uint32_t evaluated;    /* texels that the network was asked for */
} sandglass_shadow_texture;

SANDGLASS_API void sandglass_shadow_get_texture(const sandglass_shadow* shadow, sandglass_shadow_texture* texture);

/* The same texture at 128 (the mean of 2 x 2 texels), 256 or 512 texels a side (interpolated), into size * size bytes.
 * Fails with INVALID_ARGUMENT: another size, NULL. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_resample(const sandglass_shadow* shadow,
                                                                             uint32_t size, uint8_t* coverage,
                                                                             const char** reason);

/* The instruction set of the kernels in use. */
SANDGLASS_API sandglass_isa sandglass_shadow_isa(const sandglass_shadow* shadow);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_SHADOW_H */
