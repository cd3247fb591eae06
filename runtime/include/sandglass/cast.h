/* Sandglass cast: the soft shadows of any triangles on a plane, without a bake: that of one light, and the ambient
 * shadow in the light of the whole room.
 *
 * The light is taken as directions of equal irradiance. Each throws the app's own triangles onto the plane, as an image of
 * one bit a texel; the images are counted, and a filter takes the bands away. So any mesh casts from the frame on in which
 * it is loaded, on floor, wall or table, and may be skinned. shadow.h costs less for an object that was baked, has many
 * triangles and turns all the time; runtime/shadow/README.md says when.
 *
 * An app
 *   1. hands a block of sandglass_cast_bytes to sandglass_cast_create, one for each plane,
 *   2. calls sandglass_cast_set_plane, _set_meshes, _set_light and _set_cells, every frame if it likes: what is as it was
 *      costs nothing,
 *   3. passes its casts to sandglass_scene_frame (input.casts), which gives them part of the frame's budget; without a
 *      scene it calls sandglass_cast_run,
 *   4. draws the textures of sandglass_cast_get_texture and _get_ambient on the plane, by runtime/shadow/README.md.
 *
 * Real and virtual. A plane of the room, which the camera shows, is darkened by virtual objects only: what a real table
 * hides from it is dark in the image already. So a mesh of something real hides light from virtual objects and planes, and
 * keeps virtual objects from darkening a real plane where it does so itself. What it leaves is all the light that is
 * there: in the shade of a house a virtual object hides the sky, and its shadow is as dark as under a cloud. Both
 * textures are divided by that, so an app draws them by the same formula everywhere. For that it needs both textures,
 * the light, and cells that are 1 together less the main light's share; where meshes are real each texture then takes
 * half as much time again.
 *
 * What stands on the plane, a book, a cup, a hand, receives by the same textures. desc.layers of them are made, one after
 * the other in `bytes`, for as many heights, evenly from the plane up to plane.height. A place reads the two about its
 * height, where it slides to along the light:
 *
 *   float above = dot(place - corner, normal);                        // metres
 *   vec3 from = place - above * slide - corner;                       // in the plane
 *   vec2 at = vec2(dot(from, along) / dot(along, along), dot(from, across) / dot(across, across));
 *   if (at != clamp(at, 0.0, 1.0)) return outside;                    // 0; of the ambient texture 1
 *   float layer = clamp(above / height, 0.0, 1.0) * (layers - 1.0), lower = floor(layer);
 *   at.y = clamp(at.y, 0.5 / side, 1.0 - 0.5 / side);                 // no neighbour's texels
 *   float low = texture(image, vec2(at.x, (lower + at.y) / layers)).r;
 *   float high = texture(image, vec2(at.x, (min(lower + 1.0, layers - 1.0) + at.y) / layers)).r;
 *   return mix(low, high, layer - lower);
 *
 * `image` is side texels wide and layers * side high. models/kit/receive.glsl has this for floors, depth.glsl
 * there for what a depth texture shows. What receives should not be one of the meshes: its own lower part, in the layer
 * below it, would shade its top.
 *
 * A texture may take several frames; the one before it stays valid until it is complete. Where there are more than 4,000
 * triangles a coarse first texture comes ahead. Nothing is allocated, no clock is read, and the same bytes come out of
 * every instruction set and every division into frames. There is nothing to save: after a restore the app calls again.
 *
 * Triangles are solid: those that a material's alpha cuts out cast whole. What lies behind the plane casts nothing.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_CAST_H
#define SANDGLASS_CAST_H

#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The shadows of any triangles on a plane, in a block of the app. */
typedef struct sandglass_cast sandglass_cast;

/* What a cast is: set once, at create. */
typedef struct sandglass_cast_desc {
  uint32_t struct_size;
  /* Which kernels to use. Default: AUTOMATIC. */
  sandglass_isa isa;
  /* Texels along a side of the texture of the light: 0 (none), 64, 128 or 256. Default: 128. */
  uint32_t texels;
  /* How many directions a light is: 32 or 64. Default: 64; 32 takes half the time, for half as much error again. */
  uint32_t directions;
  /* Texels along a side of the ambient shadow: 0 (none), 64 or 128. Default: 64. */
  uint32_t ambient_texels;
  /* The most triangles of all meshes together, at most 1,000,000; 36 bytes each. Default: 4096. A triangle that the
   * plane cuts may count twice. */
  uint32_t triangle_capacity;
  /* The most meshes, 1..1024. Default: 16. */
  uint32_t mesh_capacity;
  /* Radians, 0..1: a texture is made anew when the light has turned by more. Default: 0.005, by which no shadow moves by a
   * texel. */
  float light_tolerance;
  /* The first mesh that darkens the plane, and what is near, set how large the texels are. What is more than so many
   * times as far from its middle as these reach casts nothing; nor do up to six triangles that reach so far and lead
   * nowhere. They are counted in `too_far`: give them a cast of their own. 2 or more; 0: all is drawn, however coarse.
   * Default: 8. */
  float reach;
  /* 1..8: at how many heights shadows are made, for what stands on the plane, see above. Four take 1.4 to 1.9 times as long
   * as one, and at the plane's end up to 2.8 times. A triangle that a layer cuts counts up to twice more: each layer has room
   * for so many of all triangles, at most for an eighth and 1024 more. Default: 1, for the plane alone. */
  uint32_t layers;
} sandglass_cast_desc;

/* Fills *desc with the defaults. */
SANDGLASS_API void sandglass_cast_desc_default(sandglass_cast_desc* desc);

/* The exact number of bytes that sandglass_cast_create needs. Fails with INVALID_ARGUMENT: a field out of range; and with
 * UNSUPPORTED (isa). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_cast_bytes(const sandglass_cast_desc* desc,
                                                                        uint64_t* bytes, const char** reason);

/* Makes a cast in the app's block, for the floor y = 0, without meshes. There is nothing to destroy. Fails like
 * sandglass_cast_bytes, and with MEMORY_TOO_SMALL and MEMORY_ALIGNMENT; nothing was written then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_cast_create(const sandglass_cast_desc* desc, void* block,
                                                                         uint64_t bytes, sandglass_cast** cast,
                                                                         const char** reason);

/* What receives the shadow. */
typedef struct sandglass_cast_plane {
  uint32_t struct_size;
  /* A point of it, world, metres. */
  float origin[3];
  /* Away from its surface, world, of any length above 0. */
  float normal[3];
  /* A direction along it, world: that of the texture's rows and of azimuth 0 of the cells. It need not be at a right angle
   * to the normal, but not along it. */
  float along[3];
  /* Its extent from the origin, metres: first along `along`, then along cross(along, normal). No shadow is drawn
   * beyond: where an app sees a part of a large plane only, that part's texels are finer. With layers the light's texture
   * goes on for what stands at the end and slides beyond it: draw there only what receives. */
  float low[2], high[2];
  /* 1: it is not in the camera's image, so what is real darkens it too. */
  uint32_t is_virtual;
  /* Metres above it, 0..1. What of a real mesh is lower is taken for the plane, and hides nothing: the mesh of a scan
   * has the floor in it, some millimetres too high. Default: 0.03. */
  float bias;
  /* Metres above it, 0.001..100: how high receivers stand, for layers; 1 has no use for it. What stands higher reads the
   * highest layer. Default: 0.15. */
  float height;
} sandglass_cast_plane;

/* Fills *plane with the defaults: the real floor y = 0, `along` +x, 10 km wide, `bias` 0.03, `height` 0.15. */
SANDGLASS_API void sandglass_cast_plane_default(sandglass_cast_plane* plane);

/* Sets the plane. Moving it by less than a tenth of a texel, or its origin within it, makes no new texture. Fails with
 * INVALID_ARGUMENT: a number that is not finite, a normal or `along` without a direction, `high` that is not above
 * `low`, or a field out of range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_cast_set_plane(sandglass_cast* cast,
                                                                            const sandglass_cast_plane* plane,
                                                                            const char** reason);

/* Triangles that cast. Start from sandglass_cast_mesh_default. */
typedef struct sandglass_cast_mesh {
  /* x y z of each vertex, in the mesh's frame. */
  const float* positions;
  /* Bytes from one vertex to the next, a multiple of 4, at least 12. Default: 12. */
  uint32_t stride;
  /* How many vertices there are. */
  uint32_t vertex_count;
  /* Three of each triangle. NULL: vertices in threes. */
  const void* indices;
  /* Bytes of an index, 2 or 4. Default: 4. */
  uint32_t index_bytes;
  /* How many triangles there are. */
  uint32_t triangle_count;
  /* Column-major, as engines have it; the last row is taken as 0 0 0 1. It may scale and mirror. Default: identity. */
  float world_from_mesh[16];
  /* Another one when positions, indices or counts have changed. */
  uint32_t version;
  /* 1: it is closed, and counter-clockwise from outside, so that half of its triangles can be left out at any light. 0
   * (the default): both sides of every triangle cast, in twice the time. */
  uint32_t closed;
  /* 1: it is real, and stands in the camera's image. */
  uint32_t is_real;
} sandglass_cast_mesh;

/* Fills *mesh with the defaults, and no triangles. */
SANDGLASS_API void sandglass_cast_mesh_default(sandglass_cast_mesh* mesh);

/* Sets all meshes that cast. The arrays are read in work units, when a mesh is new or has another pose, version or array:
 * keep them until another call leaves them out. Arrays may take turns from call to call. Where positions change while
 * units read them, one texture may show a part of each pose; where a mesh's triangle count changes, they are read anew,
 * four times at most: of one that changes in every frame, a texture may lack what is new.
 * Engines that skin on the GPU have no positions: pass the pose of a coarse mesh that is skinned here, or a box for
 * each bone.
 *
 * Poses that move no corner of a mesh's box by a tenth of a texel make no new texture. Triangles with an index that no
 * vertex has, a corner that is not finite or is 1,000 km away are left out (`left_out` of the report). Fails with
 * CAPACITY: more meshes or triangles than the description has; and with INVALID_ARGUMENT: a field out of range, a pose
 * that is not finite, or other counts with the arrays and the version of before. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_cast_set_meshes(sandglass_cast* cast,
                                                                             const sandglass_cast_mesh* meshes,
                                                                             uint32_t count, const char** reason);

/* Sets the light. `direction`: towards it, world, of any length above 0. `angular_diameter`: radians, 0..1.5; 0 means
 * 0.34907 (20 degrees). Of several lights each has a cast, or they are in the cells. What of the light is below the plane
 * gives no light; a light that is below it altogether throws no shadow. A shadow ends softly after five heights. Fails
 * with INVALID_ARGUMENT: a direction that is zero or not finite, or a diameter out of range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_cast_set_light(sandglass_cast* cast,
                                                                            const float direction[3],
                                                                            float angular_diameter,
                                                                            const char** reason);

/* Sets the light of the room, in cells (types.h) of the plane's frame: x is `along`, y is the normal. `cells`: the share
 * of the plane's irradiance that comes from each, less what is drawn as the shadow of a light. For a floor with `along` +x
 * they are the ambient_cells of sandglass_room_get. What they are less than 1 together is the main light's share, s of
 * runtime/shadow/README.md. Until the first call they are those of an even sky, and s is 0. Cells that cannot
 * change a texel by a step start no new texture. Fails with INVALID_ARGUMENT: a cell that is negative or not finite, or all
 * together are more than 1.001. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_cast_set_cells(sandglass_cast* cast,
                                                                            const float cells[SANDGLASS_LIGHT_CELLS],
                                                                            const char** reason);

/* Without a scene: runs at most `units` work units of `count` casts; returns how many it ran. Fewer than `units` means
 * that every texture is up to date. If any of the casts is NULL, it runs none. */
SANDGLASS_API uint32_t sandglass_cast_run(sandglass_cast* const* casts, uint32_t count, uint32_t units);

/* Fills *texture with the shadow of the light; set texture->struct_size before. 255 * coverage, the share of the light that
 * is hidden. */
SANDGLASS_API void sandglass_cast_get_texture(const sandglass_cast* cast, sandglass_texture* texture);

/* Fills *texture with the ambient shadow; set texture->struct_size before. 255 * A, the share of the plane's light that is
 * left, as in shadow.h. Where real meshes shade the plane, A - s * coverage is left of what they leave, and neither tells
 * of one light alone. */
SANDGLASS_API void sandglass_cast_get_ambient(const sandglass_cast* cast, sandglass_texture* texture);

/* What the textures of now were made of. */
typedef struct sandglass_cast_report {
  uint32_t struct_size;
  /* Directions of the light's texture. Fewer than the description has: a first one, which a better one will replace. */
  uint32_t directions;
  /* Triangles that were left out, see sandglass_cast_set_meshes. */
  uint32_t left_out;
  /* Triangles that cast nothing because of the description's `reach`; one that the plane cuts may count twice. */
  uint32_t too_far;
  /* The share of the ambient texture's light which the meshes' own surface receives, on average, that is, which other parts
   * of it do not hide. 1 without one. */
  float open;
} sandglass_cast_report;

/* Fills *report; set report->struct_size before. */
SANDGLASS_API void sandglass_cast_get_report(const sandglass_cast* cast, sandglass_cast_report* report);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_CAST_H */
