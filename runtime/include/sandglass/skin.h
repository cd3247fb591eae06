/* Sandglass skin: the surface of a scene's sand as a mesh, and what of the sand is not part of it.
 *
 * Sand is drawn as one opaque mesh whose fragments cut a repeating block of packed grains, a small 3D texture: it shows
 * grains of half a millimetre, whatever the size of the particles, and costs what a mesh costs. Each patch of the mesh
 * takes the origin of its block from one particle, so the grains move with the sand. What flies or lies alone is drawn
 * as points and short lines. An engine's own sand material does, too.
 *
 * How it is made. The particles are summed on a lattice that stands still in the world; what colliders fill counts as
 * full. Dry sand does not overhang: from above to below each layer gets what the layer over it has, a little less and
 * a little wider; not through walls. Surface nets (Gibson 1998) make the mesh of it, and its foot runs out at a slope
 * instead of upright. No vertex is beyond a wall of 1.5 particle radii or more, none more than a radius beyond a thinner
 * one. What falls is not part of the mesh; sand in a vessel that is lowered does not fall.
 *
 * An app
 *   1. fills a sandglass_skin_desc (start from sandglass_skin_desc_default, with the scene's granular description), asks
 *      sandglass_skin_bytes, and hands a block of that size to sandglass_skin_create,
 *   2. passes the skin to sandglass_scene_frame (input.skin), which gives it part of the frame's budget,
 *   3. uploads the chunks whose version has changed, and draws each: an ordinary mesh, one draw call a chunk,
 *   4. draws the loose sand.
 * The scene needs no grains for that: leave granular.grain_capacity at 0.
 *
 * Only what moved is made anew, and at rest nothing; a collider that moves where no sand feels it costs nothing. A skin
 * that the budget does not complete goes on in the next frame. Until then the one before is carried along at each
 * frame's end, in time that is kept for it: rigidly with the collider that its sand goes along with, by 1.5 particle
 * radii beside that. So sand moves in every frame, and stays in its vessel. Once most of it has gone elsewhere the mesh
 * is left out, and all sand is loose. A particle that moves by less than a fortieth of its radius stays where it was
 * drawn. Nothing is allocated, no clock is read, and every instruction set gives the same bytes. There is nothing to
 * save: after a restore the skin is made anew from the particles. The patches may then take their blocks from others.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_SKIN_H
#define SANDGLASS_SKIN_H

#include "sandglass/sandglass.h"
#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The surface of the sand as a mesh, in a block of the app. */
typedef struct sandglass_skin sandglass_skin;

/* What a skin is: set once, at create. */
typedef struct sandglass_skin_desc {
  uint32_t struct_size;
  /* The scene's granular.particle_capacity, 1..4000000. Particles beyond it have no skin. */
  uint32_t particle_capacity;
  /* The scene's granular.particle_radius, metres. */
  float particle_radius;
  /* The scene's granular.collider_capacity. The skin does not know of colliders beyond it. */
  uint32_t collider_capacity;
  /* Metres, 0.0001..1: the side of the block of grains that the app draws with. Default: 0.0084, which holds 14^3 grains
   * of 0.6 mm. */
  float block_side;
  /* Which vertex of a triangle tells the block's origin where the app's shader takes it without interpolation (`flat`).
   * 0 (the default): the last one, as in OpenGL and WebGL. 1: the first one, as in Metal, Vulkan and Direct3D. */
  uint32_t first_vertex;
  /* 0 (the default): the mesh is open where it meets colliders, and ends half a particle radius within them. 1: it is
   * capped there, just within them, for sand behind glass. It then has up to twice the vertices. */
  uint32_t capped;
} sandglass_skin_desc;

/* Fills *desc with the defaults, and with what the skin must know of the scene; `granular` may be NULL. */
SANDGLASS_API void sandglass_skin_desc_default(sandglass_skin_desc* desc, const sandglass_granular_desc* granular);

/* The exact number of bytes that sandglass_skin_create needs. Fails with INVALID_ARGUMENT: a field out of range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_skin_bytes(const sandglass_skin_desc* desc,
                                                                        uint64_t* bytes, const char** reason);

/* Makes a skin in the app's block; *skin then points into it. There is nothing to destroy. Fails like
 * sandglass_skin_bytes, and with MEMORY_TOO_SMALL and MEMORY_ALIGNMENT; nothing was written then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_skin_create(const sandglass_skin_desc* desc, void* block,
                                                                         uint64_t bytes, sandglass_skin** skin,
                                                                         const char** reason);

/* A vertex of the mesh: 24 bytes. */
typedef struct sandglass_skin_vertex {
  /* World, metres. */
  float position[3];
  /* Away from the sand: 127 is 1. */
  int8_t normal[3];
  /* How far the sand around stands over the surface here: 0 on a ridge, 128 on a plane, 255 in a hollow. */
  uint8_t hollow;
  /* Where the block of grains begins along x, y and z, in 1/65536 of its side: the block is looked up at
   * position / block_side - origin / 65536, repeating. */
  uint16_t origin[3];
  /* Micrometres over the nearest collider, at most 32,767; below 0 within it. A shader that leaves out single grains just
   * over a floor makes the foot end in grains. */
  int16_t over;
} sandglass_skin_vertex;

/* A part of the mesh: what lies in one cube of space. Its triangles are counter-clockwise from outside. */
typedef struct sandglass_skin_chunk {
  /* Another one when any byte of the chunk has changed, also from empty to not; never 0 where there is a mesh. */
  uint32_t version;
  /* How many vertices there are. */
  uint32_t vertex_count;
  /* How many indices there are, three of each triangle; 0: the chunk is empty. */
  uint32_t index_count;
  /* 0. */
  uint32_t unused;
  /* Stable until units are run again. */
  const sandglass_skin_vertex* vertices;
  /* Of the chunk's vertices; stable as they are. */
  const uint16_t* indices;
  /* The corners of the box that holds its vertices, world, metres. */
  float low[3], high[3];
} sandglass_skin_chunk;

/* Sand that is not in the mesh, or in part, or that came since the mesh was begun: 32 bytes. */
typedef struct sandglass_skin_loose {
  /* Of the particle, world, metres. */
  float position[3];
  /* The share of the particle that the mesh does not hold, above 0, at most 1. */
  float weight;
  /* Of one that flies: its velocity, m/s. Of one that lies: the direction away from the sand, of length 1. */
  float vector[3];
  /* Its number, as in sandglass_scene_particles: a seed. */
  uint32_t number;
} sandglass_skin_loose;

/* A skin as it is now. */
typedef struct sandglass_skin_mesh {
  uint32_t struct_size;
  /* 0: there is neither a mesh nor sand. Until the first mesh is complete it has no chunk, and all sand is loose. */
  uint32_t valid;
  /* Another one when anything below has changed. */
  uint32_t version;
  /* Frames since the one in which it was begun. 0: nothing has changed since. */
  uint32_t frames_behind;
  /* A chunk keeps its place for as long as it is not empty. Stable until units are run again, as all that follows. */
  const sandglass_skin_chunk* chunks;
  /* How many chunks there are, the empty ones among them. */
  uint32_t chunk_count;
  /* Vertices and indices of all chunks together. */
  uint32_t vertex_count, index_count;
  /* Particles that fly come first, then those that lie. */
  const sandglass_skin_loose* loose;
  /* How many fly, and how many lie. */
  uint32_t flying_count, lying_count;
  /* Particles whose place found no room in the memory of the skin: they are loose. 0 but where sand is strewn thinly over
   * wide floors. */
  uint32_t left_out;
} sandglass_skin_mesh;

/* Fills *mesh; set mesh->struct_size before. */
SANDGLASS_API void sandglass_skin_get_mesh(const sandglass_skin* skin, sandglass_skin_mesh* mesh);

/* Makes the next skin whole, even if nothing seems to have moved. */
SANDGLASS_API void sandglass_skin_refresh(sandglass_skin* skin);

/* A 64-bit hash of the mesh and of the loose sand. It is equal on every instruction set and compiler. */
SANDGLASS_API uint64_t sandglass_skin_hash(const sandglass_skin* skin);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_SKIN_H */
