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

/* The number of bytes of a field over the box bounds_min..bounds_max (metres), with nodes `spacing` metres apart. The
 * box is enlarged to whole spacings. Spacing is 0.00001..100; there are at most 2^24 nodes.
 *
 * With a spacing of one particle radius, a surface whose radius of curvature R is several spacings is followed to
 * spacing^2 / (8 R). Flat walls thicker than one spacing have no holes, whatever their angle; thinner ones may. Fails
 * with INVALID_ARGUMENT: a box or spacing out of range, or too many nodes. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_field_bytes(const float bounds_min[3],
                                                                         const float bounds_max[3], float spacing,
                                                                         uint64_t* bytes, const char** reason);

/* The signed distance of a point from a surface, metres, above 0 in free space. */
typedef float (*sandglass_distance)(void* user, const float point[3]);

/* Makes a field by asking a function at every node: for exact shapes that are no mesh, such as a silo with a hole. The
 * function may underestimate distances far from the surface. `block` must be aligned to SANDGLASS_BLOCK_ALIGNMENT and
 * hold sandglass_field_bytes; it is the field.
 *
 * Fails with MEMORY_TOO_SMALL, MEMORY_ALIGNMENT, and INVALID_ARGUMENT: an argument out of range, a distance that is not
 * finite, a surface that crosses the faces of the box (leave a margin), or no node that is solid, or none that is free
 * (the surface lies between the nodes: make the spacing smaller). The block may have been written to then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_field_from_function(
    const float bounds_min[3], const float bounds_max[3], float spacing, sandglass_solid solid,
    sandglass_distance distance, void* user, void* block, uint64_t bytes, sandglass_field** field, const char** reason);

/* Makes a field from a mesh. Distances are exact up to `band` metres from the surface, and at most 13 % too large
 * beyond. `band` is 0..1000; less than two spacings is taken as two. Give it the diameter of a particle or more.
 * `inside` decides the side: use sandglass_mesh_inside_test with a prepared mesh as `inside_user`. The box must leave a
 * margin around the surface.
 *
 * It takes time in proportion to the number of triangles times band^3 / spacing^3, and one inside test a node. Fails
 * like sandglass_field_from_function. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_field_from_mesh(
    const sandglass_mesh* mesh, sandglass_inside inside, void* inside_user, const float bounds_min[3],
    const float bounds_max[3], float spacing, float band, sandglass_solid solid, void* block, uint64_t bytes,
    sandglass_field** field, const char** reason);

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
