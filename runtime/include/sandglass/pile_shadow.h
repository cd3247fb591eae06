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
 *   4. draws the texture like that of an object: c = coverage / 255 * opacity of the light, 0 outside the rectangle. Of
 *      one light object and sand leave (1 - c of the object) * (1 - c of the sand).
 *
 * The room's light. An app that sets desc.sky_texels also gets a texture of the light that arrives from all sides, on
 * the floor and on the sand. It calls sandglass_pile_shadow_set_cells when its estimate of the room has changed, or
 * never: then the texture is made for a room that nobody has seen. To draw the floor, it multiplies by A = `floor` / 255 of
 * sandglass_pile_shadow_sky, 1 outside the rectangle. Where it draws a share s of the light as a sharp shadow, it leaves
 * that share out of the cells and multiplies by A - s * c instead. Where object and sand lie in each other's shadow, the
 * floor keeps s (1 - c1) (1 - c2) + (A1 - s) (A2 - s) / (1 - s), no factor below 0, the second term 0 where s is 1;
 * runtime/shadow/README.md has the shader, and the formula for more objects. Sand is drawn in the same way by `on_sand`,
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
  /* Of the light, radians, 0.02..1. Default: 0.34907 (20 degrees). */
  float angular_diameter;
  /* Radians, 0..1: the texture is made anew when the light has turned by more. Default: 0.01. */
  float light_tolerance;
  /* 1 (the default): also the shadow of the sand on itself. 0 saves half the time and memory. */
  uint32_t on_sand;
  /* Along a side of the texture of the room's light (sandglass_pile_shadow_sky): `texels`, a half or a quarter of it, a
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

/* Sets the direction towards the light: world, of any length above 0. A light more than 70 degrees from the zenith is
 * taken as one at 70 degrees, and `opacity` falls linearly to 0 at the horizon, as in shadow.h. Fails with
 * INVALID_ARGUMENT: the direction is zero or not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_pile_shadow_set_light(sandglass_pile_shadow* shadow,
                                                                                   const float direction[3],
                                                                                   const char** reason);

/* Makes the next textures even if nothing seems to have moved: call it after sandglass_scene_move or _restore. */
SANDGLASS_API void sandglass_pile_shadow_refresh(sandglass_pile_shadow* shadow);

/* Without a scene: runs at most `units` work units on `count` spheres of `radius` metres; returns how many it ran.
 * `positions` holds 3 floats each, metres. They must stay as they are from the first unit of a texture to its last.
 * Spheres that are not finite, or a million metres high or wide, are left out. A unit is bounded for all others, too. A
 * complete texture is not begun again before set_light, set_cells or refresh asks for one. */
SANDGLASS_API uint32_t sandglass_pile_shadow_run(sandglass_pile_shadow* shadow, const float* positions, uint32_t count,
                                                 float radius, uint32_t units);

/* A texture as it is now. */
typedef struct sandglass_pile_shadow_texture {
  uint32_t struct_size;
  /* 0: no texture was completed yet; all coverage is 0. */
  uint32_t valid;
  /* On the floor: texels x texels bytes, row v along z, column u along x. Stable until units are run again. */
  const uint8_t* coverage;
  /* On the upper surface of the sand, where there is any; NULL when the description left it out. */
  const uint8_t* on_sand;
  /* Along a side. */
  uint32_t texels;
  /* The rectangle of the description, world, metres. */
  float low[2], high[2];
  /* 1; less for a light more than 70 degrees from the zenith; 0 at and below the horizon. */
  float opacity;
  /* Frames since the one that the texture was begun in. 0: nothing has changed since. */
  uint32_t frames_behind;
  /* Another one when a byte of the textures has changed: upload it then. 0: none was completed. */
  uint64_t version;
} sandglass_pile_shadow_texture;

/* Fills *texture; set texture->struct_size before. */
SANDGLASS_API void sandglass_pile_shadow_get_texture(const sandglass_pile_shadow* shadow,
                                                     sandglass_pile_shadow_texture* texture);

/* Sets the light of the room, by the cells of types.h: the share of the floor's light that comes from each, less what
 * is drawn as the shadow of a light. Until the first call they are those of a room that nobody has seen. Cells that
 * cannot change a texel by a step start no new texture. Fails with INVALID_ARGUMENT: a cell is not finite or below 0,
 * all together are more than 1.001, or desc.sky_texels was 0. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_pile_shadow_set_cells(
    sandglass_pile_shadow* shadow, const float cells[SANDGLASS_LIGHT_CELLS], const char** reason);

/* The light of the room that the sand leaves, as it is now. */
typedef struct sandglass_pile_shadow_sky {
  uint32_t struct_size;
  /* 0: no texture was completed yet; nothing is hidden. */
  uint32_t valid;
  /* On the floor: texels x texels bytes, row v along z, column u along x; 255 where the sand hides none of the light of
   * the cells. Stable until units are run again, like those below. */
  const uint8_t* floor;
  /* On the upper surface of the sand; where there is none, as on the floor. */
  const uint8_t* on_sand;
  /* Along a side; 0 and NULL textures where desc.sky_texels was 0. */
  uint32_t texels;
  /* The height of the sand's surface over the floor, on desc.texels x desc.texels bytes: 255 is `height` metres. */
  const uint8_t* heights;
  /* Along a side of `heights`. */
  uint32_t height_texels;
  /* Metres over the floor that 255 stands for. */
  float height;
  /* The rectangle of the description, world, metres. */
  float low[2], high[2];
  /* Frames since the one that the texture was begun in. 0: nothing has changed since. */
  uint32_t frames_behind;
  /* Another one when a byte of the textures has changed: upload it then. 0: none was completed. */
  uint64_t version;
} sandglass_pile_shadow_sky;

/* Fills *sky; set sky->struct_size before. */
SANDGLASS_API void sandglass_pile_shadow_get_sky(const sandglass_pile_shadow* shadow, sandglass_pile_shadow_sky* sky);

/* Writes the light of `count` grains of `radius` metres: 255 times the share of the room's light that reaches the
 * topmost point of each. `positions` holds 3 floats each, metres. A grain whose topmost point lies below the surface of
 * the sand gets on_sand / (1 + 0.9 depth / radius). Without a complete texture all get 255.
 *
 * A shader gets the same from `on_sand` and `heights`, filtered linearly, and more evenly so for each point of a
 * grain's surface: see runtime/shadow/README.md. */
SANDGLASS_API void sandglass_pile_shadow_light_grains(const sandglass_pile_shadow* shadow, const float* positions,
                                                      uint32_t count, float radius, uint8_t* visibility);

/* A 64-bit hash of the textures. It is equal on every instruction set and compiler. */
SANDGLASS_API uint64_t sandglass_pile_shadow_hash(const sandglass_pile_shadow* shadow);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_PILE_SHADOW_H */
