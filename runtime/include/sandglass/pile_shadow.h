/* Sandglass pile shadow: the soft shadow that a scene's sand casts on the floor and on itself, and how much of the
 * room's light it leaves there.
 *
 * The sand is taken as columns of what is drawn: what lies under the skin (skin.h) of a scene that makes one; else the
 * grains, spheres of granular.grain_radius, or the particles of a scene without grains. Over each texel of a rectangle of
 * the floor a column reaches from its lowest to its highest sphere. It hides light by the share of the texel's width that
 * spheres block, so a greater grain_radius gives a darker shadow.
 *
 * A column hides an interval of elevations. Along one azimuth the intervals of all columns count as one. The light is a
 * cap of uniform radiance, cut into azimuths. This is exact for a pile that lies on the floor, as far as azimuths and
 * texels are fine, and right for one body of sand in the air. It is too dark where sand falls onto a pile, because what
 * lies between the two counts as sand; beside a skin each particle in the air throws its own shadow instead, by three
 * tenths of its outline, on what lies under it. For scattered grains smaller than half a texel it is right on average
 * (to 0.01 between grains on the floor), not grain by grain.
 *
 * An app
 *   1. fills a sandglass_pile_shadow_desc, asks sandglass_pile_shadow_bytes, and hands a block of that size to
 *      sandglass_pile_shadow_create,
 *   2. calls sandglass_pile_shadow_set_light, every frame if it likes,
 *   3. passes the shadow to sandglass_scene_frame (input.pile_shadow), which gives it part of the time of the shadow
 *      stage; its textures and those of shadow.h take turns. Without a scene it calls sandglass_pile_shadow_run,
 *   4. draws the texture like that of an object: c = scale * bytes / 255 of FLOOR, 0 outside the rectangle. Of
 *      one light object and sand leave (1 - c of the object) * (1 - c of the sand).
 *
 * The room's light. An app that sets desc.sky_texels also gets a texture of the light that arrives from all sides, on
 * the floor and on the sand. It calls sandglass_pile_shadow_set_cells when its estimate of the room has changed, or
 * never: then the texture is made for a room that nobody has seen. To draw the floor, it multiplies by A = bytes / 255 of
 * SKY_FLOOR, 1 outside the rectangle. Where it draws a share s of the light as a sharp shadow, it leaves
 * that share out of the cells and multiplies by A - s * c instead. Where object and sand lie in each other's shadow, the
 * floor keeps s (1 - c1) (1 - c2) + (A1 - s) (A2 - s) / (1 - s), no factor below 0, the second term 0 where s is 1;
 * runtime/shadow/README.md has the shader, and the formula for more objects. Sand is drawn in the same way by SAND,
 * and grains in the gaps between others are darker, see sandglass_pile_shadow_light_grains.
 *
 * What is said above of columns holds here too. Light and shadow of one bright cell are as soft as the cell is wide,
 * and on scattered grains they are right on average, not grain by grain.
 *
 * A texture is made anew while sand moves and when its light has changed. When both are at rest it costs nothing. A
 * texture may take several frames; the one before it stays valid until it is complete. Nothing is allocated, no clock
 * is read, and the same bytes come out of every instruction set.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_PILE_SHADOW_H
#define SANDGLASS_PILE_SHADOW_H

#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

struct sandglass_heights; /* relief.h */

/* The shadow that the sand casts, in a block of the app. */
typedef struct sandglass_pile_shadow sandglass_pile_shadow;

/* What a shadow of sand is: set once, at create. */
typedef struct sandglass_pile_shadow_desc {
  uint32_t struct_size;
  /* Which kernels to use. Default: AUTOMATIC. */
  sandglass_isa isa;
  /* x and z of the corners of a rectangle of the floor, world, metres: sand within it casts the shadow, and the texture
   * covers it. */
  float low[2], high[2];
  /* The height y of the floor, metres. */
  float floor;
  /* Texels along a side: 32..256, a multiple of 32. Default: 128. A texel as wide as a particle, or half as wide, is
   * fine enough. It is then one to three grains wide. */
  uint32_t texels;
  /* Radians, 0..1: the texture is made anew when the light has turned by more. Default: 0.01. */
  float light_tolerance;
  /* 1 (the default): also the shadow of the sand on itself. 0 saves half the time and memory. */
  uint32_t on_sand;
  /* Along a side of the texture of the room's light (SANDGLASS_PILE_SHADOW_SKY_FLOOR): `texels`, a half or a quarter of it, a
   * multiple of 16, at most 128. A half is fine enough. 0 (the default): there is none. */
  uint32_t sky_texels;
} sandglass_pile_shadow_desc;

/* Fills *desc with the defaults and a rectangle of one square metre around the origin. */
SANDGLASS_API void sandglass_pile_shadow_desc_default(sandglass_pile_shadow_desc* desc);

/* The exact number of bytes that sandglass_pile_shadow_create needs. Fails with INVALID_ARGUMENT: a field out of range;
 * and with UNSUPPORTED (isa). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_pile_shadow_bytes(const sandglass_pile_shadow_desc* desc,
                                                                               uint64_t* bytes, const char** reason);

/* Makes a pile shadow in the app's block; *shadow then points into it. There is nothing to destroy. Fails like
 * sandglass_pile_shadow_bytes, and with MEMORY_TOO_SMALL and MEMORY_ALIGNMENT; nothing was written then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_pile_shadow_create(const sandglass_pile_shadow_desc* desc,
                                                                                void* block, uint64_t bytes,
                                                                                sandglass_pile_shadow** shadow,
                                                                                const char** reason);

/* Sets the light. `direction`: towards it, world, of any length above 0. `angular_diameter`: radians, 0..1.5; 0 means
 * 0.34907 (20 degrees), and it counts as within 0.02..1. A light more than 70 degrees from the zenith is
 * taken as one at 70 degrees, and `opacity` falls linearly to 0 at the horizon, as in shadow.h. Fails with
 * INVALID_ARGUMENT: a direction that is zero or not finite, or a diameter out of range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_pile_shadow_set_light(sandglass_pile_shadow* shadow,
                                                                                   const float direction[3],
                                                                                   float angular_diameter,
                                                                                   const char** reason);

/* What the shadow falls on where that is not the floor alone: books, a cup, a step. `heights` is that of
 * sandglass_relief_get_heights, or an app's own map; its array must stay until the next call. FLOOR and SKY_FLOOR are then
 * of these heights: a place on a book reads its x and z as a place of the floor does. The map lies about level; its
 * numbers below desc.floor count as the floor. Call it every frame: what has the version of before, and has moved by less
 * than a tenth of a texel, costs nothing. NULL: the floor alone. Fails with INVALID_ARGUMENT: no array, cells not in
 * 2..256, an edge that is not finite, or edges that are upright. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_pile_shadow_set_ground(
    sandglass_pile_shadow* shadow, const struct sandglass_heights* heights, const char** reason);

/* Makes the next textures even if nothing seems to have moved: call it after sandglass_scene_move or _restore. */
SANDGLASS_API void sandglass_pile_shadow_refresh(sandglass_pile_shadow* shadow);

/* Without a scene: runs at most `units` work units on `count` spheres of `radius` metres; returns how many it ran.
 * `positions` holds 3 floats each, metres. They must stay as they are from the first unit of a texture to its last.
 * Spheres that are not finite, or a million metres high or wide, are left out. A unit is bounded for all others, too. A
 * complete texture is not begun again before set_light, set_cells or refresh asks for one. */
SANDGLASS_API uint32_t sandglass_pile_shadow_run(sandglass_pile_shadow* shadow, const float* positions, uint32_t count,
                                                 float radius, uint32_t units);

/* The textures of a pile shadow. All lie on the rectangle of the description: row v along z, column u along x. */
typedef int32_t sandglass_pile_shadow_part;
enum {
  /* The light's shadow on the floor: 255 * coverage. */
  SANDGLASS_PILE_SHADOW_FLOOR = 0,
  /* The same on the upper surface of the sand, where there is any. No bytes when the description left it out. */
  SANDGLASS_PILE_SHADOW_SAND = 1,
  /* The share of the light of the cells that the sand leaves, on the floor; no bytes where desc.sky_texels was 0, as of the
   * two that follow. */
  SANDGLASS_PILE_SHADOW_SKY_FLOOR = 2,
  /* The same on the upper surface of the sand; where there is none, as on the floor. */
  SANDGLASS_PILE_SHADOW_SKY_SAND = 3,
  /* The height of the sand's surface over the floor, on desc.texels x desc.texels bytes: `scale` is in metres. */
  SANDGLASS_PILE_SHADOW_HEIGHTS = 4
};

/* Fills *texture; set texture->struct_size before. For a part that there is not, it has no bytes. */
SANDGLASS_API void sandglass_pile_shadow_get_texture(const sandglass_pile_shadow* shadow,
                                                     sandglass_pile_shadow_part part, sandglass_texture* texture);

/* Sets the light of the room, by the cells of types.h: the share of the floor's light that comes from each, less what
 * is drawn as the shadow of a light. Until the first call they are those of a room that nobody has seen. Cells that
 * cannot change a texel by a step start no new texture. Fails with INVALID_ARGUMENT: a cell is not finite or below 0,
 * all together are more than 1.001, or desc.sky_texels was 0. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_pile_shadow_set_cells(
    sandglass_pile_shadow* shadow, const float cells[SANDGLASS_LIGHT_CELLS], const char** reason);

/* Writes the light of `count` grains of `radius` metres: 255 times the share of the room's light that reaches the
 * topmost point of each. `positions` holds 3 floats each, metres. A grain whose topmost point lies below the surface of
 * the sand gets SKY_SAND / (1 + 0.9 depth / radius). Without a complete texture all get 255.
 *
 * A shader gets the same from SKY_SAND and HEIGHTS, filtered linearly, and more evenly so for each point of a
 * grain's surface: see runtime/shadow/README.md. */
SANDGLASS_API void sandglass_pile_shadow_light_grains(const sandglass_pile_shadow* shadow, const float* positions,
                                                      uint32_t count, float radius, uint8_t* visibility);

/* A 64-bit hash of the textures. It is equal on every instruction set and compiler. */
SANDGLASS_API uint64_t sandglass_pile_shadow_hash(const sandglass_pile_shadow* shadow);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_PILE_SHADOW_H */
