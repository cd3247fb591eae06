/* Sandglass sampling: points on disks, spheres, surfaces and in volumes (chapter 3 of the source).
 *
 * Part of the public API; sandglass.h includes it. Sampling runs when a scene is set up, not in the frame, but obeys
 * the same rules: nothing is allocated, no thread is started, and for equal arguments (the seed is one of them) the
 * same bits come out of every compiler and instruction set.
 *
 * Memory. An algorithm that needs working memory has three functions:
 *     sandglass_sample_X_capacity   a number of points that always suffices for the output,
 *     sandglass_sample_X_bytes      the working memory that a run with a given output capacity needs, exactly,
 *     sandglass_sample_X            the run.
 * `scratch` must be aligned to SANDGLASS_BLOCK_ALIGNMENT and is the caller's again afterwards.
 *
 * Points are 3 floats each, tightly packed: x0 y0 z0 x1 ... After a failure *count is 0, *reason says what is wrong,
 * and the output array is as it was. Angles are in radians, polar angle theta from +y, azimuth phi from +x towards +z:
 * x = r sin(theta) cos(phi), y = r cos(theta), z = r sin(theta) sin(phi).
 *
 * Samples are centres: they lie on the surface or in the volume, spheres drawn around them reach beyond it. */
#ifndef SANDGLASS_SAMPLING_H
#define SANDGLASS_SAMPLING_H

#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -------------------------------------------------------------------------------- disk, sphere, ring */

/* `count` points spread evenly over the disk of `radius` metres around the origin in the plane y = 0 (sunflower
 * pattern): r_i = radius sqrt((i - 1/2)/(count - 1/2)), phi_i = golden angle * i, i = 1..count (3.4, 3.5). The last
 * point lies on the rim. `points` takes 3*count floats. Fails with INVALID_ARGUMENT: count 0 or above 2^30, radius not
 * finite or not above 0, NULL. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_disk(float radius, uint32_t count, float* points,
                                                                         const char** reason);

/* `count` points spread evenly over the sphere of `radius` metres around the origin:
 * cos(theta_i) = (count + 1 - 2i)/count, phi_i = golden angle * i, i = 1..count (3.8, 3.9).
 * `points` takes 3*count floats. Fails with INVALID_ARGUMENT: count 0 or above 2^30, radius not finite or not above 0,
 * NULL. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_sphere(float radius, uint32_t count, float* points,
                                                                           const char** reason);

/* Exactly `count` points spread evenly over the ring theta_a <= theta <= theta_b of the sphere of `radius` metres: the
 * points of a whole sphere of N points that fall into the ring (3.10). ERRATUM (3.11): the N it gives can keep one
 * point more or fewer than wanted; here N is the one nearest to it that keeps exactly `count`, which always exists.
 * Every point lies in the ring, to the rounding of its coordinates. theta_a = 0 gives a cap, and the range 0..pi the
 * sphere. `points` takes 3*count floats. Fails with INVALID_ARGUMENT: not 0 <= theta_a < theta_b <= pi (the float
 * nearest to pi is taken as pi), a ring so thin that the whole sphere would have more than 2^40 points, count 0 or
 * above 2^30, radius not finite or not above 0, NULL. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_ring(float radius, float theta_a, float theta_b,
                                                                         uint32_t count, float* points,
                                                                         const char** reason);

/* -------------------------------------------------------------------------------- meshes */

/* A triangle mesh in the caller's arrays: 3 floats a vertex, 3 indices a triangle, counter-clockwise seen from outside.
 * Triangles are neighbours where they share vertices by index, so merge equal vertices where that matters (GEODESIC).
 * Every function that takes a mesh checks it: at least one triangle, at most 2^27; indices below vertex_count;
 * coordinates finite and within SANDGLASS_COORDINATE_LIMIT. It fails with INVALID_ARGUMENT and the first fault. */
typedef struct sandglass_mesh {
  const float* vertices;
  uint32_t vertex_count;
  const uint32_t* indices;
  uint32_t triangle_count;
} sandglass_mesh;

/* The axis-aligned bounding box of the vertices that triangles use (3.22, 3.23), metres. Fails with
 * INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_mesh_bounds(const sandglass_mesh* mesh,
                                                                         float bounds_min[3], float bounds_max[3],
                                                                         const char** reason);

/* The sum of the triangles' areas (3.16, 3.17) in square metres. Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_mesh_area(const sandglass_mesh* mesh, double* area,
                                                                       const char** reason);

/* The generalised winding number (3.28) of the mesh about `point`: 1 inside, 0 outside a closed mesh, a fraction where
 * the mesh is open. One exact pass over all triangles (use sandglass_mesh_inside for many points). ERRATUM (3.27): the
 * solid angle is 2 atan2(det[a b c], |a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|). Fails with INVALID_ARGUMENT, also for
 * a point not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_mesh_winding_number(const sandglass_mesh* mesh,
                                                                                 const float point[3], double* winding,
                                                                                 const char** reason);

/* -------------------------------------------------------------------------------- inside tests */

/* Says whether a point lies in a volume: non-zero inside. `user` is handed through. Must give the same answer for the
 * same point. sandglass_mesh_inside_test is one; an app may bring its own (an analytic shape, a ray tracer). */
typedef int (*sandglass_inside)(void* user, const float point[3]);

/* How a prepared mesh decides.
 *
 * PARITY counts the triangles above the point along the longest axis of the bounding box; odd is inside. For meshes in
 * which every edge belongs to an even number of triangles; orientation does not matter. Vertices and point are rounded
 * to a grid of 2^26 steps along that axis and everything after that is integer arithmetic, so that points that line up
 * with edges and vertices are no special case: the answer is right for every point further than 2^-25 of the box from
 * the surface.
 *
 * WINDING asks for a generalised winding number of at least 1/2 in magnitude. For meshes with holes, overlaps or stray
 * pieces; needs a consistent orientation. Near triangles are taken exactly, distant ones together (a dipole and its
 * first moment a cluster), which changes the number by less than 0.04 and so no answer on a closed mesh. */
typedef int32_t sandglass_inside_rule;
enum { SANDGLASS_INSIDE_PARITY = 0, SANDGLASS_INSIDE_WINDING = 1 };

typedef struct sandglass_mesh_inside sandglass_mesh_inside;

/* The exact number of bytes that sandglass_mesh_inside_create needs, proportional to the number of triangles.
 * Fails with INVALID_ARGUMENT (mesh, or an unknown rule). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_mesh_inside_bytes(const sandglass_mesh* mesh,
                                                                               sandglass_inside_rule rule,
                                                                               uint64_t* bytes, const char** reason);

/* Prepares a mesh for many inside tests, in the caller's block (aligned to SANDGLASS_BLOCK_ALIGNMENT). The mesh's
 * arrays are copied and may go. There is nothing to destroy. Fails with INVALID_ARGUMENT, MEMORY_TOO_SMALL,
 * MEMORY_ALIGNMENT; nothing is touched then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_mesh_inside_create(const sandglass_mesh* mesh,
                                                                                sandglass_inside_rule rule, void* block,
                                                                                uint64_t bytes,
                                                                                sandglass_mesh_inside** inside,
                                                                                const char** reason);

/* 1 if `point` lies in the mesh, else 0 (also for a point that is not finite). `inside` is a sandglass_mesh_inside*;
 * the signature is that of sandglass_inside, so that it can be handed to the samplers with the object as `user`. Any
 * number of threads may test at the same time. */
SANDGLASS_API int sandglass_mesh_inside_test(void* inside, const float point[3]);

/* -------------------------------------------------------------------------------- options */

/* How the distance between two points is measured.
 *
 * EUCLIDEAN (3.13): straight through space.
 *
 * GEODESIC (3.14): the length of the shortest path along the surface, exact (paths are unfolded triangle by triangle),
 * so that the two sides of a thin sheet do not see each other. Needs triangles that share their vertices by index. */
typedef int32_t sandglass_metric;
enum { SANDGLASS_METRIC_EUCLIDEAN = 0, SANDGLASS_METRIC_GEODESIC = 1 };

typedef struct sandglass_sample_options {
  uint32_t struct_size;
  uint32_t tries;          /* N_t of Alg. 1 and 2, 1..1000: 30, the value the project fixed; the source gives none */
  uint64_t seed;           /* any number; equal seeds give equal points */
  sandglass_metric metric; /* surface sampling only */
  /* Called now and then with the work done and the work there is (0 = unknown) in a unit of the algorithm's: candidates
   * settled (surface), points found (volume), lattice sites tested (lattice). May be NULL. */
  void (*progress)(void* user, uint64_t done, uint64_t total);
  void* user; /* handed to progress */
} sandglass_sample_options;

/* Seed 1, 30 tries, Euclidean distance, no progress calls. */
SANDGLASS_API void sandglass_sample_options_default(sandglass_sample_options* options);

/* -------------------------------------------------------------------------------- surface, Poisson disk */

/* Points on a mesh's surface, no two closer than `distance` metres, in blue-noise distribution: Alg. 1, with
 * max(tries, tries*A/(pi distance^2)) candidates drawn evenly over the area A (3.15-3.21). ERRATUM Alg. 1: growth from
 * one seed never reaches parts further than 2*distance away; here it starts again from a remaining candidate until none
 * is left, so that every candidate is closer than `distance` to a sample. Expect about 0.7 A/distance^2 points. Time is
 * linear in candidates and triangles.
 *
 * _capacity: the number of candidates. _bytes: about 20 bytes a candidate, 8 a point of capacity and 8 a triangle
 * (GEODESIC: about 35, 8 and 170). All fail with INVALID_ARGUMENT: the mesh, its area 0, a distance not finite, not
 * above 0, or so small that it would take more than 2^30 candidates or 2^20 cells of that size along one axis of the
 * box; options. sandglass_sample_surface also with MEMORY_TOO_SMALL, MEMORY_ALIGNMENT, and CAPACITY if there are more
 * samples than `capacity`. `options` NULL means the defaults. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status
sandglass_sample_surface_capacity(const sandglass_mesh* mesh, float distance, const sandglass_sample_options* options,
                                  uint32_t* capacity, const char** reason);
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status
sandglass_sample_surface_bytes(const sandglass_mesh* mesh, float distance, const sandglass_sample_options* options,
                               uint32_t capacity, uint64_t* bytes, const char** reason);
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_surface(const sandglass_mesh* mesh, float distance,
                                                                            const sandglass_sample_options* options,
                                                                            void* scratch, uint64_t scratch_bytes,
                                                                            float* points, uint32_t capacity,
                                                                            uint32_t* count, const char** reason);

/* -------------------------------------------------------------------------------- volume, Poisson disk */

/* Points in a volume, no two closer than `distance` metres, in blue-noise distribution: Alg. 2. The volume is where
 * `inside` says so within the box bounds_min..bounds_max; `inside` is called once for each point tried that is far
 * enough from all samples. ERRATUM (3.29): a try lies at r = distance * cuberoot(1 + 7 rho) from its sample, which is
 * uniform in the shell between one and two distances; the source's formula is not. ERRATUM Alg. 2: growth starts again
 * from probes, one at a random place in each cell (of edge `distance`) of the box, so that separate parts are reached
 * and every probe inside is closer than `distance` to a sample. A volume that no probe hits is looked for with 1000
 * more; if they miss it, *count is 0 and the status OK. Expect about 0.6 points per distance^3, more in thin shapes
 * (random packing jams at 0.73).
 *
 * _capacity: the densest packing of spheres that the box could hold. _bytes: 4 bytes a cell of the box plus 20 a point
 * of capacity. All fail with INVALID_ARGUMENT: a box not finite, inverted or beyond SANDGLASS_COORDINATE_LIMIT, a
 * distance not finite, not above 0, or so small that the box has more than 2^30 cells; options; NULL.
 * sandglass_sample_volume also with MEMORY_TOO_SMALL, MEMORY_ALIGNMENT, and CAPACITY if there are more samples than
 * `capacity`. `options` NULL means the defaults. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_volume_capacity(const float bounds_min[3],
                                                                                    const float bounds_max[3],
                                                                                    float distance, uint32_t* capacity,
                                                                                    const char** reason);
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_volume_bytes(const float bounds_min[3],
                                                                                 const float bounds_max[3],
                                                                                 float distance, uint32_t capacity,
                                                                                 uint64_t* bytes, const char** reason);
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status
sandglass_sample_volume(const float bounds_min[3], const float bounds_max[3], float distance, sandglass_inside inside,
                        void* inside_user, const sandglass_sample_options* options, void* scratch,
                        uint64_t scratch_bytes, float* points, uint32_t capacity, uint32_t* count, const char** reason);

/* -------------------------------------------------------------------------------- volume, HCP lattice */

/* The sites of a hexagonal close packing in a volume, layers along y: Alg. 3 with (3.33). Neighbours are exactly
 * `distance` metres apart (to float rounding), twelve of them for a site in the interior. ERRATUM Alg. 3: the lattice
 * starts at bounds_min, not at the origin. `inside` is called once a site within the box. Of `options` only the
 * progress call is used; NULL is fine.
 *
 * _capacity: the sites of the box. _bytes: one bit a site. All fail with INVALID_ARGUMENT as sandglass_sample_volume
 * does (more than 2^30 sites); sandglass_sample_lattice also with MEMORY_TOO_SMALL, MEMORY_ALIGNMENT, and CAPACITY. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_lattice_capacity(const float bounds_min[3],
                                                                                     const float bounds_max[3],
                                                                                     float distance, uint32_t* capacity,
                                                                                     const char** reason);
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_lattice_bytes(const float bounds_min[3],
                                                                                  const float bounds_max[3],
                                                                                  float distance, uint64_t* bytes,
                                                                                  const char** reason);
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_lattice(
    const float bounds_min[3], const float bounds_max[3], float distance, sandglass_inside inside, void* inside_user,
    const sandglass_sample_options* options, void* scratch, uint64_t scratch_bytes, float* points, uint32_t capacity,
    uint32_t* count, const char** reason);

/* -------------------------------------------------------------------------------- spectrum */

/* The power |F|^2/count of a point set at one spatial frequency (cycles per metre), F as in (3.1) with k_FT = 1. White
 * noise has an expected power of 1 at every frequency but 0. Fails with INVALID_ARGUMENT: count 0, NULL, a number not
 * finite, or a phase of more than 1e9 cycles. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_power(const float* points, uint32_t count,
                                                                          const float frequency[3], double* power,
                                                                          const char** reason);

/* The radial mean of the power spectrum: power[b] is the mean power over `directions` evenly spread directions at the
 * frequency (b + 1/2) * frequency_max/bins cycles per metre, b = 0..bins-1. planar != 0 takes directions in the plane y
 * = 0 (for points of a flat sheet), else all of space. Blue noise of distance l has next to no power well below 1/l.
 * The mean of the whole set's own outline shows up below about 1/(its size): leave those bins out. `power` takes `bins`
 * doubles. Fails with INVALID_ARGUMENT like sandglass_sample_power, and for bins or directions 0 or above 65536. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_sample_spectrum(const float* points, uint32_t count,
                                                                             float frequency_max, uint32_t bins,
                                                                             uint32_t directions, int32_t planar,
                                                                             double* power, const char** reason);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_SAMPLING_H */
