/* Sandglass fields: any closed surface as a collider for particles and grains, a scanned room, an hourglass, a bucket.
 *
 * A signed-distance field is a regular grid of distances in the app's memory. It is made once, from a mesh or from a
 * function, on a workstation or on the device. Distances above 0 are free space, below 0 solid. A collider of
 * SANDGLASS_SHAPE_FIELD points to it (sandglass.h). The dissertation has no such fields: there, surfaces are sampled
 * with particles, and grains leak through them.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_FIELD_H
#define SANDGLASS_FIELD_H

#include "sandglass/sampling.h"

#ifdef __cplusplus
extern "C" {
#endif

/* On which side of the surface sand cannot be.
 *
 * INSIDE: a solid object. All space beyond the grid is free.
 *
 * OUTSIDE: a container or a room. All space beyond the grid is solid, so nothing can leave, however fast it is. */
typedef int32_t sandglass_solid;
enum { SANDGLASS_SOLID_INSIDE = 0, SANDGLASS_SOLID_OUTSIDE = 1 };

/* A field, in a block of the app. */
typedef struct sandglass_field sandglass_field;

/* The signed distance of a point from a surface, metres, above 0 in free space. `user` is handed through. */
typedef float (*sandglass_distance_function)(void* user, const float point[3]);

/* What a field is made from: a mesh with an inside test, or a function that is asked at every node, for exact shapes
 * that are no mesh, such as a silo with a hole.
 *
 * With a spacing of one particle radius, a surface whose radius of curvature R is several spacings is followed to
 * spacing^2 / (8 R). Flat walls thicker than one spacing have no holes, whatever their angle; thinner ones may. */
typedef struct sandglass_field_desc {
  uint32_t struct_size;
  /* Default: SANDGLASS_SOLID_INSIDE. */
  sandglass_solid solid;
  /* The corners of a box that leaves a margin around the surface, metres. It is enlarged to whole spacings. Needed. */
  float bounds_min[3], bounds_max[3];
  /* Between two nodes, metres, 0.00001..100; there are at most 2^24 nodes. Needed. */
  float spacing;
  /* Metres, 0..1000: distances from a mesh are exact up to this far from the surface, and at most 13 % too large
   * beyond. Less than two spacings is taken as two. Give it the diameter of a particle or more. Default: 0. */
  float band;
  /* NULL, the default, or the surface. */
  const sandglass_mesh* mesh;
  /* A mesh needs it: it decides the side. Use sandglass_mesh_inside_test with a prepared mesh as `inside_user`. */
  sandglass_inside_function inside;
  /* Handed to inside. */
  void* inside_user;
  /* Needed where there is no mesh, else NULL, the default. It may underestimate distances far from the surface. */
  sandglass_distance_function distance;
  /* Handed to distance. */
  void* distance_user;
} sandglass_field_desc;

/* Fills *desc with the defaults: solid inside; no box, spacing and surface yet. */
SANDGLASS_API void sandglass_field_desc_default(sandglass_field_desc* desc);

/* The exact number of bytes that sandglass_field_create needs. Fails with INVALID_ARGUMENT: a field out of range, too
 * many nodes, the mesh, or not exactly one of mesh and distance. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_field_bytes(const sandglass_field_desc* desc,
                                                                         uint64_t* bytes, const char** reason);

/* Makes a field in the app's block, aligned to SANDGLASS_BLOCK_ALIGNMENT; the block is the field. The mesh's arrays may
 * go. From a mesh it takes time in proportion to the number of triangles times band^3 / spacing^3, and one inside test
 * a node. The block holds no address: a copy of its bytes, in another aligned block of any process that runs the same
 * build of the library, is the same field. They are not checked, so take none that others made.
 *
 * Fails like sandglass_field_bytes, with MEMORY_TOO_SMALL, MEMORY_ALIGNMENT, and with INVALID_ARGUMENT also for a
 * distance that is not finite, a surface that crosses the faces of the box, or no node that is solid, or none that is
 * free (the surface lies between the nodes: make the spacing smaller). The block may have been written to then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_field_create(const sandglass_field_desc* desc, void* block,
                                                                          uint64_t bytes, sandglass_field** field,
                                                                          const char** reason);

/* The distance that sand sees at a point of the field's own coordinates, metres. `normal` is optional: it receives the
 * direction in which the distance grows, of length 1. A coordinate beyond 1e6 m counts as 1e6 m. A point that is not
 * finite has the distance 0 and the normal (0, 1, 0). For tools and pictures. */
SANDGLASS_API float sandglass_field_distance(const sandglass_field* field, const float point[3], float normal[3]);

/* On which side a field is solid, and the box of its nodes. Both corners are optional. */
SANDGLASS_API sandglass_solid sandglass_field_bounds(const sandglass_field* field, float bounds_min[3],
                                                     float bounds_max[3]);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_FIELD_H */
