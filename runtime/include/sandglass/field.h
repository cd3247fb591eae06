/* Signed-distance fields: any closed surface as a collider for particles and grains (SPEC 2.3), a scanned room, an
 * hourglass, a bucket. A field is a regular grid of distances in the caller's memory, made once, from a mesh or from a
 * function, on a workstation or on the device. Distances above 0 are free space, below 0 solid.
 *
 * See types.h for what holds for all functions. */
#ifndef SANDGLASS_FIELD_H
#define SANDGLASS_FIELD_H

#include "sandglass/sampling.h"

#ifdef __cplusplus
extern "C" {
#endif

/* On which side of the surface sand cannot be.
 * INSIDE: a solid object; all space beyond the grid is free. OUTSIDE: a container or a room; all space beyond the grid
 * is solid, so nothing can leave, however fast it is. */
typedef int32_t sandglass_solid;
enum { SANDGLASS_SOLID_INSIDE = 0, SANDGLASS_SOLID_OUTSIDE = 1 };

typedef struct sandglass_field sandglass_field;

/* The number of bytes of a field over the box bounds_min..bounds_max (metres) with nodes `spacing` metres apart; the
 * box is enlarged to whole spacings. At most 2^24 nodes. A spacing of one particle radius follows surfaces whose radius
 * of curvature R is several of them, to spacing^2/(8 R). Flat walls thicker than one spacing have no holes, whatever
 * their angle; thinner ones may. Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_field_bytes(const float bounds_min[3],
                                                                         const float bounds_max[3], float spacing,
                                                                         uint64_t* bytes, const char** reason);

/* The signed distance of a point from a surface, metres, above 0 in free space. */
typedef float (*sandglass_distance)(void* user, const float point[3]);

/* Fills a field by asking a function at every node: exact shapes that are no mesh, a silo with a hole say. The function
 * may underestimate distances far from the surface. `block` must be aligned to SANDGLASS_BLOCK_ALIGNMENT. Fails with
 * INVALID_ARGUMENT (also for distances not finite, where the surface crosses the faces of the box: leave a margin, and
 * where it lies between the nodes: nothing solid, or nothing free), MEMORY_TOO_SMALL, MEMORY_ALIGNMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_field_from_function(
    const float bounds_min[3], const float bounds_max[3], float spacing, sandglass_solid solid,
    sandglass_distance distance, void* user, void* block, uint64_t bytes, sandglass_field** field, const char** reason);

/* Fills a field from a mesh. Distances are exact up to `band` metres from the surface (at least two spacings; give it
 * the diameter of a particle or more) and at most 13 % above the truth beyond. `inside` decides the side
 * (sandglass_mesh_inside_test with a prepared mesh as `inside_user`). The box must leave a margin round the surface.
 * Costs the number of triangles times band^3/spacing^3 and an inside test a node. Fails as from_function does. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_field_from_mesh(
    const sandglass_mesh* mesh, sandglass_inside inside, void* inside_user, const float bounds_min[3],
    const float bounds_max[3], float spacing, float band, sandglass_solid solid, void* block, uint64_t bytes,
    sandglass_field** field, const char** reason);

/* The distance that sand sees at a point of the field's own coordinates, and, where `normal` is not NULL, the direction
 * in which it grows (unit length). For tools and pictures. */
SANDGLASS_API float sandglass_field_distance(const sandglass_field* field, const float point[3], float normal[3]);

/* The box of the field's nodes, and on which side it is solid. */
SANDGLASS_API sandglass_solid sandglass_field_bounds(const sandglass_field* field, float bounds_min[3],
                                                     float bounds_max[3]);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_FIELD_H */
