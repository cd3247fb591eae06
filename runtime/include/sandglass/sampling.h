/* Sandglass sampling: points on disks, spheres, surfaces and in volumes (chapter 3).
 *
 * sandglass.h includes this header. Sampling runs when a scene is set up, not in the frame, but follows the same rules:
 * nothing is allocated, no thread is started, and for equal arguments (the seed is one of them) the same bits come out
 * of every compiler and instruction set.
 *
 * Memory. sandglass_sample_points works in memory of the app. For the same description, sandglass_sample_capacity names
 * a number of points that is always enough, and sandglass_sample_bytes the exact working memory of a run with a given
 * capacity. `scratch` must be aligned to SANDGLASS_BLOCK_ALIGNMENT. After the call it belongs to the app again.
 *
 * Points are 3 floats each, tightly packed: x0 y0 z0 x1 ... After a failure *count is 0, *reason says what is wrong,
 * and the output array is as it was. Angles are in radians: the polar angle theta from +y, the azimuth phi from +x
 * towards +z. So x = r sin(theta) cos(phi), y = r cos(theta), z = r sin(theta) sin(phi), (2.4) to (2.9).
 *
 * Samples are centres. They lie on the surface or in the volume; spheres drawn around them reach beyond it.
 *
 * Where a comment says "corrected", the printed formula cannot be used as it stands. runtime/README.md lists all
 * corrections. Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_SAMPLING_H
#define SANDGLASS_SAMPLING_H

#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -------------------------------------------------------------------------------- disk, sphere, ring */

/* Spreads `count` points evenly over the disk of `radius` metres around the origin in the plane y = 0. It is the
 * sunflower pattern r_i = radius sqrt((i - 1/2)/(count - 1/2)), phi_i = golden angle * i, i = 1..count (3.4, 3.5). The
 * last point lies on the rim. `points` takes 3 * count floats. Fails with INVALID_ARGUMENT: count is 0 or above 2^30,
 * or the radius is not finite or not above 0. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_disk(float radius, float* points, uint32_t count,
                                                                         const char** reason);

/* Spreads `count` points evenly over the sphere of `radius` metres around the origin: cos(theta_i) = (count + 1 -
 * 2i)/count, phi_i = golden angle * i, i = 1..count (3.8, 3.9). `points` takes 3 * count floats. Fails with
 * INVALID_ARGUMENT: count is 0 or above 2^30, or the radius is not finite or not above 0. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_sphere(float radius, float* points, uint32_t count,
                                                                           const char** reason);

/* Spreads exactly `count` points evenly over the ring theta_a <= theta <= theta_b of the sphere of `radius` metres.
 * They are the points of a whole sphere of N points that fall into the ring (3.10). (3.11) is corrected: its N can keep
 * one point more or fewer than wanted. Here N is the nearest to it that keeps exactly `count`, which always exists.
 *
 * Every point lies in the ring, to the rounding of its coordinates. theta_a = 0 gives a cap, and the range 0..pi the
 * sphere. `points` takes 3 * count floats. Fails with INVALID_ARGUMENT: not 0 <= theta_a < theta_b <= pi (the float
 * nearest to pi counts as pi), a ring so thin that the whole sphere would have more than 2^40 points, a count of 0 or
 * above 2^30, or a radius that is not finite or not above 0. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_ring(float radius, float theta_a, float theta_b,
                                                                         float* points, uint32_t count,
                                                                         const char** reason);

/* -------------------------------------------------------------------------------- meshes */

/* A triangle mesh in the app's arrays: 3 floats a vertex, 3 indices a triangle, counter-clockwise seen from outside.
 *
 * Triangles are neighbours where they share vertices by index, so merge equal vertices where that matters (GEODESIC).
 * Every function that takes a mesh checks it: at least one triangle, at most 2^27; indices below vertex_count;
 * coordinates finite and within SANDGLASS_COORDINATE_LIMIT. It fails with INVALID_ARGUMENT and names the first
 * fault. */
typedef struct sandglass_mesh {
  /* 3 floats each, metres. */
  const float* vertices;
  /* How many vertices there are. */
  uint32_t vertex_count;
  /* 3 for each triangle. */
  const uint32_t* indices;
  /* How many triangles there are. */
  uint32_t triangle_count;
} sandglass_mesh;

/* Gives the axis-aligned bounding box of the vertices that triangles use (3.22, 3.23), metres. Fails with
 * INVALID_ARGUMENT: the mesh. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_mesh_bounds(const sandglass_mesh* mesh,
                                                                         float bounds_min[3], float bounds_max[3],
                                                                         const char** reason);

/* Gives the sum of the triangles' areas (3.16, 3.17), square metres. Fails with INVALID_ARGUMENT: the mesh. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_mesh_area(const sandglass_mesh* mesh, double* area,
                                                                       const char** reason);

/* Gives the generalised winding number (3.28) of the mesh about `point`: 1 inside and 0 outside a closed mesh, a
 * fraction where the mesh is open. (3.27) is corrected: the solid angle is 2 atan2(det[a b c], |a||b||c| + (a.b)|c| +
 * (b.c)|a| + (c.a)|b|). It takes one exact pass over all triangles; use sandglass_mesh_inside for many points. Fails
 * with INVALID_ARGUMENT: the mesh, or a point that is not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_mesh_winding_number(const sandglass_mesh* mesh,
                                                                                 const float point[3], double* winding,
                                                                                 const char** reason);

/* -------------------------------------------------------------------------------- inside tests */

/* Says whether a point lies in a volume: not 0 means inside. `user` is handed through. It must give the same answer for
 * the same point. sandglass_mesh_inside_test is such a test; an app may bring its own, an analytic shape for
 * example. */
typedef int32_t (*sandglass_inside_function)(void* user, const float point[3]);

/* How a prepared mesh decides.
 *
 * PARITY counts the triangles above the point along the longest axis of the bounding box; an odd number is inside. It
 * is for meshes in which every edge belongs to an even number of triangles; orientation does not matter. Vertices and
 * point are rounded to a grid of 2^26 steps along that axis, and everything after that is integer arithmetic. So points
 * that line up with edges and vertices are no special case: the answer is right for every point further than 2^-25 of
 * the box from the surface.
 *
 * WINDING asks for a generalised winding number of at least 1/2 in magnitude. It is for meshes with holes, overlaps or
 * stray pieces, and needs a consistent orientation. Near triangles are taken exactly, distant ones together (a dipole
 * and its first moment for each cluster). That changes the number by less than 0.04, and so no answer on a closed
 * mesh. */
typedef int32_t sandglass_inside_rule;
enum { SANDGLASS_INSIDE_PARITY = 0, SANDGLASS_INSIDE_WINDING = 1 };

/* A mesh that was prepared for many inside tests, in a block of the app. */
typedef struct sandglass_mesh_inside sandglass_mesh_inside;

/* The exact number of bytes that sandglass_mesh_inside_create needs, in proportion to the number of triangles. Fails
 * with INVALID_ARGUMENT: the mesh, or an unknown rule. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_mesh_inside_bytes(const sandglass_mesh* mesh,
                                                                               sandglass_inside_rule rule,
                                                                               uint64_t* bytes, const char** reason);

/* Prepares a mesh for many inside tests, in the app's block (aligned to SANDGLASS_BLOCK_ALIGNMENT). The mesh's arrays
 * are copied and may go. There is nothing to destroy. Fails with INVALID_ARGUMENT, MEMORY_TOO_SMALL and
 * MEMORY_ALIGNMENT; nothing was written then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_mesh_inside_create(const sandglass_mesh* mesh,
                                                                                sandglass_inside_rule rule, void* block,
                                                                                uint64_t bytes,
                                                                                sandglass_mesh_inside** inside,
                                                                                const char** reason);

/* 1 if `point` lies in the mesh, else 0, also for a point that is not finite. `inside` is a sandglass_mesh_inside*. It
 * is a sandglass_inside_function, so that it can be handed to a sampler with the object as `inside_user`. Any number of
 * threads may test at the same time. */
SANDGLASS_API int32_t sandglass_mesh_inside_test(void* inside, const float point[3]);

/* -------------------------------------------------------------------------------- surfaces and volumes */

/* How points are chosen. */
typedef int32_t sandglass_sample_method;
enum {
  /* On the surface of `mesh`, no two closer than `distance`, in blue-noise distribution (Alg. 1).
   *
   * max(tries, tries * A / (pi distance^2)) candidates are drawn evenly over the area A (3.15 to 3.21). Alg. 1 is
   * corrected: growth from one seed never reaches parts further away than 2 * distance. Here it starts again from a
   * remaining candidate until none is left, so every candidate is closer than `distance` to a sample. Expect about 0.7
   * A / distance^2 points. Time is linear in candidates and triangles.
   *
   * The capacity that is always enough is the number of candidates. Working memory: about 20 bytes a candidate, 8 a
   * point of capacity and 8 a triangle; with GEODESIC about 35, 8 and 170. Refused: the mesh, an area of 0, more than
   * 2^30 candidates, or more than 2^20 cells along one axis of the box. */
  SANDGLASS_SAMPLE_SURFACE = 0,
  /* In a volume, no two closer than `distance`, in blue-noise distribution (Alg. 2). The volume is where `inside` says
   * so within the box bounds_min..bounds_max. `inside` is called once for each point that is tried and far enough from
   * all samples.
   *
   * (3.29) is corrected: a try lies at r = distance * cuberoot(1 + 7 rho) from its sample, which is uniform in the
   * shell between one and two distances. Alg. 2 is corrected: growth starts again from probes, one at a random place in
   * each cell (of edge `distance`) of the box. So separate parts are reached, and every probe inside is closer than
   * `distance` to a sample. A volume that no probe hits is looked for with 1000 more; if these miss it too, there are 0
   * points. Expect about 0.6 points per distance^3, more in thin shapes; random packing jams at 0.73.
   *
   * The capacity that is always enough is the densest packing of spheres that the box could hold. Working memory: 4
   * bytes a cell of the box, and 20 a point of capacity. Refused: a box that is not finite, inverted or beyond
   * SANDGLASS_COORDINATE_LIMIT, or more than 2^30 cells. */
  SANDGLASS_SAMPLE_VOLUME = 1,
  /* The sites of a hexagonal close packing in such a volume, in layers along y: Alg. 3 with (3.33). `inside` is called
   * once for each site within the box.
   *
   * Neighbours are exactly `distance` apart, to float rounding; a site in the interior has twelve. Alg. 3 is corrected:
   * the lattice starts at bounds_min, not at the origin.
   *
   * The capacity that is always enough is the sites of the box. Working memory: one bit a site. Refused: such a box, or
   * more than 2^30 sites. */
  SANDGLASS_SAMPLE_LATTICE = 2
};

/* How the distance between two points is measured.
 *
 * EUCLIDEAN (3.13): straight through space.
 *
 * GEODESIC (3.14): the length of the shortest path along the surface, exact (paths are unfolded triangle by triangle).
 * So the two sides of a thin sheet do not see each other. It needs triangles that share their vertices by index. */
typedef int32_t sandglass_metric;
enum { SANDGLASS_METRIC_EUCLIDEAN = 0, SANDGLASS_METRIC_GEODESIC = 1 };

/* Called now and then with the work that is done and the work that there is (0: unknown), in a unit of the method:
 * candidates settled (SURFACE), points found (VOLUME), sites tested (LATTICE). `user` is handed through. */
typedef void (*sandglass_progress_function)(void* user, uint64_t done, uint64_t total);

/* Which points are wanted. */
typedef struct sandglass_sample_desc {
  uint32_t struct_size;
  /* Default: SURFACE. */
  sandglass_sample_method method;
  /* Between two points, metres, above 0. Needed. */
  float distance;
  /* N_t of Alg. 1 and 2, 1..1000. Default: 30; the dissertation gives no value. */
  uint32_t tries;
  /* Any number; equal seeds give equal points. Default: 1. */
  uint64_t seed;
  /* SURFACE only. Default: EUCLIDEAN. */
  sandglass_metric metric;
  /* VOLUME and LATTICE: the corners of a box that holds the volume, metres. See sandglass_mesh_bounds. */
  float bounds_min[3], bounds_max[3];
  /* SURFACE needs it. */
  const sandglass_mesh* mesh;
  /* VOLUME and LATTICE need it. */
  sandglass_inside_function inside;
  /* Handed to inside. */
  void* inside_user;
  /* May be NULL, the default. */
  sandglass_progress_function progress;
  /* Handed to progress. */
  void* progress_user;
} sandglass_sample_desc;

/* Fills *desc with the defaults: SURFACE, 30 tries, seed 1, Euclidean distance, no progress calls; no mesh, box and
 * distance yet. */
SANDGLASS_API void sandglass_sample_desc_default(sandglass_sample_desc* desc);

/* How many points are always enough. All three functions fail with INVALID_ARGUMENT: a field out of range, and what the
 * method refuses, for example a distance that is too small for its limits. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_capacity(const sandglass_sample_desc* desc,
                                                                             uint32_t* capacity, const char** reason);

/* The working memory of a run with room for `capacity` points. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_bytes(const sandglass_sample_desc* desc,
                                                                          uint32_t capacity, uint64_t* bytes,
                                                                          const char** reason);

/* The run: `points` takes 3 * capacity floats, *count is how many points it found. Fails also with MEMORY_TOO_SMALL,
 * MEMORY_ALIGNMENT, and CAPACITY: there are more points than `capacity`. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_points(const sandglass_sample_desc* desc,
                                                                           void* scratch, uint64_t scratch_bytes,
                                                                           float* points, uint32_t capacity,
                                                                           uint32_t* count, const char** reason);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_SAMPLING_H */
