/* Sandglass pile shadow: the soft shadow that a scene's sand casts on the floor and on itself.
 *
 * The sand is taken as columns of what is drawn: the grains, spheres of granular.grain_radius, or the particles of a
 * scene without grains. Over each texel of a rectangle of the floor it reaches from its lowest to its highest sphere,
 * and hides light by the share of the texel that spheres cover: a greater grain_radius gives a darker shadow. What a
 * column hides of the light is an interval of elevations; seen along one azimuth, the intervals of all columns are
 * taken as one. The light is a cap of uniform radiance, cut into azimuths. This is exact for a heap that lies on the
 * floor, as far as azimuths and texels are fine, right for one body of sand in the air, and too dark where sand falls
 * onto a heap: what lies between the two counts as sand. Of scattered grains smaller than half a texel it is right on
 * the mean, not grain by grain.
 *
 * An app
 *   1. fills a sandglass_pile_shadow_desc, asks sandglass_pile_shadow_bytes, and hands a block of that size to
 *      sandglass_pile_shadow_create,
 *   2. calls sandglass_pile_shadow_set_light, every frame if it likes,
 *   3. passes it to sandglass_scene_frame (input.pile_shadow), which gives it part of the time of the shadow stage: its
 *      textures and those of shadow.h take turns. Without a scene: sandglass_pile_shadow_run,
 *   4. draws the texture, like that of an object: shadow = coverage * opacity * contrast of the light. The shadows of
 *      object and sand multiply: transparency = (1 - shadow) (1 - shadow).
 *
 * Textures are made anew while sand moves and when the light has turned; of sand at rest in a light at rest they cost
 * nothing. A texture may take several frames; the one before it stays valid until it is complete. Nothing is allocated,
 * no clock is read, and the same bytes come out of every instruction set. */
#ifndef SANDGLASS_PILE_SHADOW_H
#define SANDGLASS_PILE_SHADOW_H

#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sandglass_pile_shadow_desc {
  uint32_t struct_size;
  sandglass_isa isa;
  float low[2], high[2];  /* x and z of the rectangle's corners, world, metres: what sand and shadow are looked at in */
  float floor;            /* y of the floor, metres */
  uint32_t texels;        /* a side: 32..256, a multiple of 32; default 128. A texel of half a particle's diameter to a
                           * whole one is fine enough, also for grains, of which it is then one to three wide */
  float angular_diameter; /* of the light, radians, 0.02..1; default 0.34907 (20 degrees) */
  float light_tolerance;  /* radians, 0..1: made anew when the light has turned by more; default 0.01 */
  uint32_t on_sand;       /* 1 (the default): also the shadow of the sand on itself; 0 saves half the time and memory */
} sandglass_pile_shadow_desc;

SANDGLASS_API void sandglass_pile_shadow_desc_default(sandglass_pile_shadow_desc* desc);

/* The exact number of bytes that create needs. Fails with INVALID_ARGUMENT and UNSUPPORTED (isa). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_pile_shadow_bytes(const sandglass_pile_shadow_desc* desc,
                                                                               uint64_t* bytes, const char** reason);

/* There is nothing to destroy. Fails as sandglass_pile_shadow_bytes, and with MEMORY_TOO_SMALL and MEMORY_ALIGNMENT;
 * nothing is touched then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_pile_shadow_create(const sandglass_pile_shadow_desc* desc,
                                                                                void* block, uint64_t bytes,
                                                                                sandglass_pile_shadow** shadow,
                                                                                const char** reason);

/* The direction towards the light, world, of any length above 0. Lights more than 70 degrees from the zenith are
 * clamped there, and `opacity` falls linearly to 0 at the horizon, as in shadow.h. Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_pile_shadow_set_light(sandglass_pile_shadow* shadow,
                                                                                   const float direction[3],
                                                                                   const char** reason);

/* The next texture is made even if nothing seems to have moved: after sandglass_scene_move or _restore. */
SANDGLASS_API void sandglass_pile_shadow_refresh(sandglass_pile_shadow* shadow);

/* Without a scene: runs at most `units` work units on these spheres, 3 floats each, which must stay as they are from
 * the first unit of a texture to its last; returns how many it ran. A complete texture is not begun again before
 * set_light or refresh asks for one. */
SANDGLASS_API uint32_t sandglass_pile_shadow_run(sandglass_pile_shadow* shadow, const float* positions, uint32_t count,
                                                 float radius, uint32_t units);

typedef struct sandglass_pile_shadow_texture {
  uint32_t struct_size;
  uint32_t valid;          /* 0: no texture was completed yet; all coverage is 0 */
  uint32_t texels;         /* a side */
  const uint8_t* coverage; /* on the floor; texels x texels bytes, row v along z, column u along x */
  const uint8_t* on_sand;  /* on the sand's upper surface, where there is any; NULL without */
  float low[2], high[2];   /* world, of the description */
  float opacity;           /* 1, or less for a light beyond 70 degrees, 0 at and below the horizon */
  uint32_t age;            /* frames since the one that the texture was begun in; 0: nothing has changed since */
} sandglass_pile_shadow_texture;

/* texture.struct_size is set before (see "Sizes" in types.h). Bytes are stable until units are run again. */
SANDGLASS_API void sandglass_pile_shadow_get_texture(const sandglass_pile_shadow* shadow,
                                                     sandglass_pile_shadow_texture* texture);

/* A 64-bit hash of the textures: equal on every instruction set and compiler. */
SANDGLASS_API uint64_t sandglass_pile_shadow_hash(const sandglass_pile_shadow* shadow);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_PILE_SHADOW_H */
