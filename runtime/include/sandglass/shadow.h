/* Sandglass shadow: the soft shadows of one object on the plane that it stands on, one for each light, from a network
 * baked for that object (`sandglass bake`), evaluated in pieces small enough for any frame (chapter 6 of the source).
 *
 * An app
 *   1. reads a baked file into memory (aligned to 8 bytes) and fills a sandglass_shadow_desc,
 *   2. asks sandglass_shadow_bytes, hands a block of that size to sandglass_shadow_create; the file's bytes may go
 *      then,
 *   3. calls sandglass_shadow_set_light for each light, every frame if it likes,
 *   4. passes its shadows to sandglass_scene_frame (input.shadows), which gives them part of the frame's budget; or,
 *      without a scene, calls sandglass_shadow_run, as many units as fit,
 *   5. draws the textures that sandglass_shadow_get_texture describes.
 *
 * A texture may take several frames; the one before it stays valid until it is complete. Nothing is allocated, no clock
 * is read, and the same bytes come out of every instruction set and every division into frames.
 *
 * Of several objects with several lights, the texture with the greatest visible change is begun first: the light's
 * turn since the texture that is shown, times the light's share of the irradiance, times the opacity, growing by an
 * eighth with every call of set_light that it waits, so that none waits for ever.
 *
 * The object's frame is that of the mesh that was baked: y up, metres. Turn the light into it: d_object =
 * R_world_to_object d_world (6.1). Coverage c (0..1, byte / 255) is 1 - transparency; the shadow's opacity is coverage
 * * opacity * the contrast level o of the light. */
#ifndef SANDGLASS_SHADOW_H
#define SANDGLASS_SHADOW_H

#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Texels a side of the texture that networks are baked for. */
#define SANDGLASS_SHADOW_TEXELS 256
/* Most lights of one object. */
#define SANDGLASS_SHADOW_LIGHTS 8

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
  uint32_t threshold; /* steps of 1/255 of coverage, 0..255; default 48 (0.19), which adds less than 0.002 of error */
  float
      light_tolerance; /* radians, 0..1: the texture is computed anew when the light has turned by more; default 0.01 */
  uint32_t light_count; /* 1..SANDGLASS_SHADOW_LIGHTS; default 1. Each costs one texture, 64 KiB, of memory */
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

/* Reads the file's description after the checks of sandglass_shadow_create; info.struct_size is set before (see "Sizes"
 * in types.h). Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_inspect(const void* asset, uint64_t asset_bytes,
                                                                            sandglass_shadow_info* info,
                                                                            const char** reason);

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

/* Light number `light`: the direction towards it in the object's frame, of any length above 0, and the irradiance that
 * it gives the plane where nothing is in its way, in any unit that is the same for all lights (of a single light it
 * means nothing). A texture under way is completed for its own light first, so that one unit a frame is enough for
 * textures to arrive. Lights up to polar_max (to the rounding of floats) are followed exactly; beyond it the texture is
 * that of polar_max at the same azimuth, and `opacity` falls linearly to 0 at the horizon. Fails with INVALID_ARGUMENT:
 * a number that is none, a vector that is zero or not finite, an irradiance that is negative or not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_set_light(sandglass_shadow* shadow, uint32_t light,
                                                                              const float direction[3],
                                                                              float irradiance, const char** reason);

/* Runs at most `units` work units of `count` shadows (none NULL); returns how many it ran. Fewer than `units`: every
 * texture is that of its light. A unit takes some tens of microseconds of a core that does 110 GMAC/s; of networks with
 * more than 100,000 MAC a texel (info.macs_per_texel) longer in proportion, as it is never less than 48 texels: 0.23 ms
 * for the largest, 256 x 8. */
SANDGLASS_API uint32_t sandglass_shadow_run(sandglass_shadow* const* shadows, uint32_t count, uint32_t units);

/* Work units until the textures of the present lights are complete; an upper bound while an adaptive grid is not yet
 * decided. */
SANDGLASS_API uint32_t sandglass_shadow_units_left(const sandglass_shadow* shadow);

typedef struct sandglass_shadow_texture {
  uint32_t struct_size;
  uint32_t valid;          /* 0: no texture was completed yet; coverage is all 0 */
  const uint8_t* coverage; /* 256 x 256 bytes, row v along z, column u along x; stable until units are run again */
  float low[2], high[2]; /* x and z of the rectangle's corners in the mesh's coordinates, on the plane y = origin[1] */
  float light[3];        /* unit vector that the texture was computed for */
  float opacity;         /* 1, or less for a light beyond polar_max, 0 at and below the horizon */
  uint32_t beyond;       /* 1: the present light lies beyond polar_max */
  uint32_t age;          /* calls of set_light since the one that the texture was begun for; 0: it is the light's */
  uint32_t evaluated;    /* texels that the network was asked for */
} sandglass_shadow_texture;

/* texture.struct_size is set before (see "Sizes" in types.h). A `light` that is none has no valid texture. */
SANDGLASS_API void sandglass_shadow_get_texture(const sandglass_shadow* shadow, uint32_t light,
                                                sandglass_shadow_texture* texture);

/* A light's texture at 128 (the mean of 2 x 2 texels), 256 or 512 texels a side (interpolated), into size * size bytes.
 * Fails with INVALID_ARGUMENT: another size, a light that is none, NULL. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_resample(const sandglass_shadow* shadow,
                                                                             uint32_t light, uint32_t size,
                                                                             uint8_t* coverage, const char** reason);

/* All lights together, size x size bytes over the rectangle low..high that holds all their textures: coverage =
 * sum(E c opacity) / sum(E) over the lights above the horizon, E being their irradiances, and c 0 for a light whose
 * first texture is not complete; transparencies then add up as nu = sum(E nu) / sum(E). For apps that draw one texture
 * an object; takes about a millisecond a light at 256, so call it when a texture has changed. size is 1..1024. Fails
 * with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_combine(const sandglass_shadow* shadow,
                                                                            uint32_t size, uint8_t* coverage,
                                                                            float low[2], float high[2],
                                                                            const char** reason);

/* A 64-bit hash of all textures and the lights that they are of: equal on every instruction set and compiler. */
SANDGLASS_API uint64_t sandglass_shadow_hash(const sandglass_shadow* shadow);

/* The instruction set of the kernels in use. */
SANDGLASS_API sandglass_isa sandglass_shadow_isa(const sandglass_shadow* shadow);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_SHADOW_H */
