/* Sandglass shadow: the soft shadows of one object on the plane that it stands on, one for each light (chapter 6), and
 * its ambient shadow in the light of the whole room.
 *
 * A network that was baked for that object (`sandglass bake`) computes the shadows of lights. The ambient shadow is
 * mixed from the object's baked visibility for any cells of light. Both are made in work units small enough for any
 * frame.
 *
 * An app
 *   1. reads a baked file into memory (aligned to 8 bytes) and fills a sandglass_shadow_desc,
 *   2. asks sandglass_shadow_bytes, and hands a block of that size to sandglass_shadow_create; the bytes of the file
 *      may go then,
 *   3. calls sandglass_shadow_set_cells with the light of the room (ambient_cells of sandglass_room_get), and
 *      sandglass_shadow_set_light for each sharp light (its main_direction), every frame if it likes,
 *   4. passes its shadows to sandglass_scene_frame (input.shadows), which gives them part of the frame's budget;
 *      without a scene it calls sandglass_shadow_run, with as many units as fit,
 *   5. draws the textures that sandglass_shadow_get_ambient and sandglass_shadow_get_texture describe
 *      (runtime/shadow/README.md says how).
 *
 * A texture may take several frames; the one before it stays valid until it is complete. Nothing is allocated, no clock
 * is read, and the same bytes come out of every instruction set and every division into frames.
 *
 * Where several objects have several lights, the texture with the greatest visible change is begun first. The change is
 * the angle that the light has turned since the texture that is shown, times the light's share of the irradiance, times
 * the opacity. It grows by an eighth with every call of set_light that it waits, so no texture waits for ever. The
 * first ambient shadow of an object comes before all that; later ones take turns with the textures of lights.
 *
 * The object's frame is that of the mesh that was baked: y up, metres. Turn the light into it: d_object =
 * R_world_to_object d_world (6.1). Coverage c, 0..1, is byte / 255 and means 1 - transparency (6.18). The shadow's
 * opacity is coverage * opacity * the contrast o of the light: the share of the light that one shadow removes.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_SHADOW_H
#define SANDGLASS_SHADOW_H

#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The shadows of one baked object, in a block of the app. */
typedef struct sandglass_shadow sandglass_shadow;

/* Texels along a side of the texture that networks are baked for. */
#define SANDGLASS_SHADOW_TEXELS 256
/* The most lights of one object. */
#define SANDGLASS_SHADOW_LIGHTS 8

/* Which texels the network is asked for.
 *
 * ADAPTIVE (the default): one in 4 x 4, which makes a coarse grid; then all texels of the cells whose corners differ by
 * more than `threshold`, and of the cells around those. The rest is interpolated.
 *
 * FULL: all. */
typedef int32_t sandglass_shadow_mode;
enum { SANDGLASS_SHADOW_ADAPTIVE = 0, SANDGLASS_SHADOW_FULL = 1 };

/* What the shadows of an object are: set once, at create. */
typedef struct sandglass_shadow_desc {
  uint32_t struct_size;
  /* Which kernels to use. Default: AUTOMATIC. */
  sandglass_isa isa;
  /* A baked file, aligned to 8 bytes. It is needed until create returns. */
  const void* asset;
  /* The size of the file. */
  uint64_t asset_bytes;
  /* Which texels the network is asked for. Default: ADAPTIVE. */
  sandglass_shadow_mode mode;
  /* Steps of 1/255 of coverage, 0..255. The default, 48 (0.19), adds less than 0.002 of error. */
  uint32_t threshold;
  /* Radians, 0..1: a texture is made anew when its light has turned by more. Default: 0.01. */
  float light_tolerance;
  /* 1..SANDGLASS_SHADOW_LIGHTS. Default: 1. Each light costs one texture, 64 KiB, of memory. */
  uint32_t light_count;
} sandglass_shadow_desc;

/* Fills *desc with the defaults: adaptive, one light, no file. */
SANDGLASS_API void sandglass_shadow_desc_default(sandglass_shadow_desc* desc);

/* What a baked file says of itself. */
typedef struct sandglass_shadow_info {
  uint32_t struct_size;
  /* Of the file's format. */
  uint32_t version;
  /* The centre of the footprint on the receiving plane, in the coordinates of the mesh, metres. */
  float origin[3];
  /* Half the edges of the bounding box along x and z, metres. */
  float half_x, half_z;
  /* The height of the bounding box, metres. */
  float height;
  /* Of the light that was baked, radians. */
  float angular_diameter;
  /* The largest angle of the light from the zenith that was baked, radians. */
  float polar_max;
  /* 1: the rectangle of the texture follows the light. 0: one square for all lights (6.11). */
  uint32_t plane_fitted;
  /* Neurons in a hidden layer, and how many hidden layers follow the first. */
  uint32_t width, layers;
  /* Multiplications of the hidden layers for a texel; the first layer is separated into tables. */
  uint64_t macs_per_texel;
  /* Root mean square errors of coverage against ray tracing, over lights that were not trained on: of the network in
   * float and in bytes. */
  float rmse_float, rmse_int8;
  /* How many lights these errors are over. */
  uint32_t validated_lights;
  /* Parameters of the network before rounding, if the file holds them, else 0. */
  uint32_t float_parameters;
  /* Texels along a side of the ambient shadow. 0: the file has none (files of version 1); its fields are 0 then. */
  uint32_t ambient_texels;
  /* Half the edge of the ambient shadow's square, metres. */
  float ambient_half;
  /* How many textures are mixed into one. */
  uint32_t ambient_components;
  /* Root mean square error of the share of light that is left, against ray tracing, over rooms that it was not fitted
   * to. */
  float ambient_rmse;
  /* Points of the surface that sandglass_shadow_transfer looks up: vertices, those at creases several times. 0: the
   * file has none. */
  uint32_t surface_vertices;
} sandglass_shadow_info;

/* Reads what a file says of itself, after all checks of sandglass_shadow_create. Set info->struct_size before. Fails
 * with INVALID_ARGUMENT: no baked file, a damaged one, one that is cut off, or one of another version. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_inspect(const void* asset, uint64_t asset_bytes,
                                                                            sandglass_shadow_info* info,
                                                                            const char** reason);

/* The exact number of bytes that sandglass_shadow_create needs. Fails with INVALID_ARGUMENT: a field out of range, or a
 * file that sandglass_shadow_inspect refuses; and with UNSUPPORTED (isa). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_bytes(const sandglass_shadow_desc* desc,
                                                                          uint64_t* bytes, const char** reason);

/* Makes the shadows of one object in the app's block: checks the whole file, lays the block out, and computes the
 * tables of the network's first layer. There is nothing to destroy. Fails like sandglass_shadow_bytes, and with
 * MEMORY_TOO_SMALL and MEMORY_ALIGNMENT; nothing was written then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_create(const sandglass_shadow_desc* desc,
                                                                           void* block, uint64_t bytes,
                                                                           sandglass_shadow** shadow,
                                                                           const char** reason);

/* Sets a light. `light`: its number, below light_count. `direction`: towards it, in the object's frame, of any length
 * above 0. `irradiance`: what it gives the plane where nothing hides it, at least 0, in any unit that is the same for
 * all lights; for a single light its value does not matter.
 *
 * A texture under way is completed for its own light first. So one unit a frame is enough for textures to arrive.
 * Lights up to polar_max from the zenith are followed exactly. Beyond it the texture is that of polar_max at the same
 * azimuth, and `opacity` falls linearly to 0 at the horizon. Fails with INVALID_ARGUMENT: a number that no light has, a
 * direction that is zero or not finite, an irradiance that is negative or not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_set_light(sandglass_shadow* shadow, uint32_t light,
                                                                              const float direction[3],
                                                                              float irradiance, const char** reason);

/* Runs at most `units` work units of `count` shadows; returns how many it ran. Fewer than `units` means that every
 * texture is that of its light. If any of the shadows is NULL, it runs none.
 *
 * A unit takes some tens of microseconds on a core that does 110 GMAC/s. For networks with more than 100,000
 * multiplications a texel (info.macs_per_texel) it takes longer in proportion, because a unit is at least 48 texels:
 * 0.23 ms for the largest, 256 x 8. */
SANDGLASS_API uint32_t sandglass_shadow_run(sandglass_shadow* const* shadows, uint32_t count, uint32_t units);

/* The number of work units until the textures of the present lights are complete. It is an upper bound while an
 * adaptive grid is not decided yet. */
SANDGLASS_API uint32_t sandglass_shadow_units_left(const sandglass_shadow* shadow);

/* Fills *texture with the shadow of a light, 256 x 256 bytes of coverage, row v along z, column u along x, in the coordinates
 * of the mesh, on the plane y = origin[1]; set texture->struct_size before. `scale` is below 1 for a light beyond polar_max,
 * and 0 at and below the horizon. For a number that no light has, the texture is not valid and has no bytes. */
SANDGLASS_API void sandglass_shadow_get_texture(const sandglass_shadow* shadow, uint32_t light,
                                                sandglass_texture* texture);

/* How many texels the network was asked for in the texture of a light. 0 for a number that no light has. */
SANDGLASS_API uint32_t sandglass_shadow_evaluated(const sandglass_shadow* shadow, uint32_t light);

/* Writes the texture of a light in another size: 128 (the mean of 2 x 2 texels), 256, or 512 texels along a side
 * (interpolated). `coverage` takes size * size bytes. Fails with INVALID_ARGUMENT: another size, or a number that no
 * light has. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_resample(const sandglass_shadow* shadow,
                                                                             uint32_t light, uint8_t* coverage,
                                                                             uint32_t size, const char** reason);

/* Writes all lights of an object together, without its ambient shadow, for apps that draw one texture an object.
 * `size`: 1..1024 texels along a side; `coverage` takes size * size bytes. The rectangle low..high, which it returns,
 * holds the textures of all lights.
 *
 * coverage = sum(E c opacity) / sum(E), over the lights above the horizon. E is the irradiance of a light; its c is 0
 * until its first texture is complete. Transparencies nu then add up as sum(E nu) / sum(E). It takes about a
 * millisecond a light at size 256, so call it when a texture has changed. Fails with INVALID_ARGUMENT: another size. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_combine(const sandglass_shadow* shadow,
                                                                            uint8_t* coverage, uint32_t size,
                                                                            float low[2], float high[2],
                                                                            const char** reason);

/* ------------------------------------------------------------------------------------------------ ambient shadow */

/* Sets the light of the room, in cells (SANDGLASS_LIGHT_CELLS, types.h) of the world's frame. `cells`: for each one its
 * share of the irradiance that the floor receives where nothing hides it, at least 0. Together they are 1, or 1 - s
 * where a sharp light with the share s is drawn by the texture of sandglass_shadow_set_light. `yaw`: radians by which
 * the object is turned about +y, as by sandglass_rotation_about: counter-clockwise seen from above. The object stands
 * upright.
 *
 * Until the first call the cells are those of an even sky, so an object has an ambient shadow from its first work
 * units on. A change by which no texel can differ by a step of its byte starts no new texture.
 *
 * Where the file has no ambient shadow, the call changes nothing and succeeds. Fails with INVALID_ARGUMENT: a cell that
 * is negative or not finite, cells that add up to more than 1.001, or a yaw that is not within 1e6 radians. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_set_cells(sandglass_shadow* shadow,
                                                                              const float cells[SANDGLASS_LIGHT_CELLS],
                                                                              float yaw, const char** reason);

/* Fills *texture with the ambient shadow; set texture->struct_size before. 255 * A, where A = 1 - sum(q (1 - V)) with the
 * cells q and the visibility V of each from the floor. So 255 means that the object hides nothing; it is 255 along the rim.
 * Row v lies along z, column u along x, in the coordinates of the mesh, on the plane y = origin[1]. Where the file has no
 * ambient shadow, the side is 0. */
SANDGLASS_API void sandglass_shadow_get_ambient(const sandglass_shadow* shadow, sandglass_texture* texture);

/* Reads from a baked file how the vertices of the object see the room past the object itself: nine coefficients a
 * vertex. The irradiance of a vertex over pi is, for each colour, the sum of the nine products with the harmonics of
 * the room in the object's frame (sandglass_room_light.sh, turned by sandglass_harmonics_turn of renderers.h).
 *
 * What the object hides of the room from itself is as bright as it is: multiply by 1 / (1 - albedo * (1 - open)), with
 * open = coefficient 0 / 0.282095 in 0..1, for each colour. Not in an engine whose ambient occlusion bounces by itself.
 *
 * `positions`: `count` vertices of the app's own mesh, in the coordinates of the mesh that was baked, in any order.
 * Each gets the coefficients of the baked point that is nearest. `normals`: theirs, which tell the sides of a crease
 * apart; may be NULL. `transfer` takes 9 * count floats. Call it once, when the object is loaded.
 *
 * Fails like sandglass_shadow_inspect, and with INVALID_ARGUMENT: a number that is not finite, or a file without a
 * surface (info.surface_vertices is 0). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_shadow_transfer(const void* asset, uint64_t asset_bytes,
                                                                             const float* positions,
                                                                             const float* normals, uint32_t count,
                                                                             float* transfer, const char** reason);

/* ------------------------------------------------------------------------------------------------ replay */

/* A 64-bit hash of all textures, the ambient one included, and of the lights that they are computed for. It is equal on
 * every instruction set and compiler. */
SANDGLASS_API uint64_t sandglass_shadow_hash(const sandglass_shadow* shadow);

/* The instruction set of the kernels in use. */
SANDGLASS_API sandglass_isa sandglass_shadow_isa(const sandglass_shadow* shadow);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_SHADOW_H */
