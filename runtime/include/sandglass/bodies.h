/* Sandglass bodies: rigid bodies that sand pushes and that push sand.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_BODIES_H
#define SANDGLASS_BODIES_H

#include "sandglass/sand.h"
#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A rigid body: particles that keep their shape (shape matching, 4.28 to 4.36). Sand pushes it, and it pushes sand.
 *
 * Its particles are spheres of the material's radius. Sample the body like sand, on a lattice or by Poisson disk, so
 * that a particle stands for the same volume; or make a box (sandglass_box_body). A body may also be one or two
 * particles, a line or a plane of them. Bodies do not carry grains: pass a collider with the body's pose to keep grains
 * out of it. */
typedef struct sandglass_body {
  uint32_t struct_size;
  /* 3 floats each, world, metres, within SANDGLASS_COORDINATE_LIMIT. Needed until the body is added. */
  const float* particle_positions;
  /* How many particles the body has. */
  uint32_t particle_count;
  /* The mass of a particle of the body over that of a particle of sand, 0.001..1000. Default: 1. Up to 8, with the
   * default sub-steps, body and sand stay apart and come to rest. Above that, sand that the body falls on may be thrown
   * up, and takes seconds longer to rest; half of the default substep_max is enough up to 20. Above 20, sand that the
   * body squeezes may end inside it, unless substep_max is far shorter; so may, at any density, single particles on a
   * bare floor that a body falls onto. A stack of two or three bodies, none denser than those below, does not move. It
   * also stands if the uppermost is up to 8 times as dense, though bodies that were put ball on ball slide by up to two
   * diameters until they lie in the hollows. One that is 100 times as dense pushes apart what carries it. */
  float density_ratio;
  /* m/s, of the centre of mass, at most 10,000 along each axis. */
  float linear_velocity[3];
  /* rad/s, about the centre of mass, at most 10,000 about each axis. */
  float angular_velocity[3];
} sandglass_body;

/* Fills *body with the defaults: no particles, density_ratio 1, at rest. */
SANDGLASS_API void sandglass_body_default(sandglass_body* body);

/* Adds a body. *index, which is optional, is its number: the lowest that no body has, counted from 0. Its particles
 * appear in sandglass_scene_particles like sand that is added now. Overlap is resolved as by
 * sandglass_scene_set_body. Fails with CAPACITY, and with INVALID_ARGUMENT: a body without particles, or a number
 * out of range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_add_body(sandglass_scene* scene,
                                                                            const sandglass_body* body, uint32_t* index,
                                                                            const char** reason);

/* Where a body is. */
typedef struct sandglass_body_pose {
  /* Of the centre of mass: the mean of the particles' positions. World, metres. */
  float position[3];
  /* From the pose in which the body was added, (x, y, z, w). */
  float rotation[4];
  /* m/s. */
  float linear_velocity[3];
  /* rad/s. */
  float angular_velocity[3];
} sandglass_body_pose;

/* The pose of a body now: draw its mesh with it. An index that no body has returns the identity pose at the origin. */
SANDGLASS_API sandglass_body_pose sandglass_scene_body_pose(const sandglass_scene* scene, uint32_t index);

/* 1 if a body has this index, else 0: none was added, or it was removed by the app, by a sink or by granular.lowest. */
SANDGLASS_API int32_t sandglass_scene_has_body(const sandglass_scene* scene, uint32_t index);

/* Removes a body, between frames. The other bodies keep their numbers. Its number, those of its particles, and its room
 * are free for the next sandglass_scene_add_body. What lies within 2r + list_margin * r of the box around the centres
 * of its particles wakes up. report.sand counts it in removed_bodies, and its particles in removed_particles. Fails
 * with INVALID_ARGUMENT: no body has this index. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_remove_body(sandglass_scene* scene, uint32_t index,
                                                                               const char** reason);

/* Puts a body somewhere else, from one moment to the next, with these velocities: at most 10,000 m/s and rad/s along
 * each axis. The rotation has any length above 0. It may be called before every frame, to drag a body: give the
 * velocity of that motion then, so that the body pushes what it meets.
 *
 * The body wakes up, and so does what is near it, at the old place and at the new one, as for removing. Overlap with
 * sand and bodies is resolved gently, as for sandglass_scene_add: a pair parts at no more than 0.9 sqrt(2 g r),
 * times the density_ratio of the densest body where that is 1 to 5. Sand or another body that would be caught between
 * particles of this one is put beside it, along an axis of the world that does not point down. What stands there is not
 * looked at, so keep clear of thin walls. Neighbour lists are built anew in the next frame. Beside 14,000 particles the
 * call takes some 0.1 ms on a workstation, and 12 ms where a body of 1,000 is put into the midst of them.
 *
 * Fails with INVALID_ARGUMENT: no body has this index, a number out of range, or one of its particles would lie beyond
 * SANDGLASS_COORDINATE_LIMIT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_set_body(sandglass_scene* scene, uint32_t index,
                                                                            const sandglass_body_pose* pose,
                                                                            const char** reason);

/* Pushes a body at a point, as a finger that flicks it does.
 *
 * `impulse` is the impulse over the mass of the body, a vector in m/s along the world's axes: the velocity of the
 * centre of mass changes by it, whatever the mass is. An app that has an impulse in N s divides it by the mass in kg.
 * `point` is in the world, metres, on the body or not. It is optional; NULL is the centre of mass, and the body does
 * not turn. With c the centre of mass and r the particles' places relative to it:
 *
 *     linear  += impulse
 *     angular += J^-1 ((point - c) x impulse)        J = mean over the particles of (|r|^2 - r r^T)
 *
 * J is the inertia over the mass. Particles do not turn, so a body whose particles lie on a line does not spin about
 * that line, and one of a single particle not at all. The body and what is near it wake up. Neighbour lists are built
 * anew in the next frame. Fails with INVALID_ARGUMENT: no body has this index, a number is not finite, the point is
 * beyond SANDGLASS_COORDINATE_LIMIT, or the body would be faster than 10,000 m/s or rad/s along an axis. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_scene_push_body(sandglass_scene* scene, uint32_t index,
                                                                             const float impulse[3],
                                                                             const float point[3], const char** reason);

/* A box as a rigid body. Its particles (sandglass_box_body), the collider that keeps grains out of it
 * (sandglass_box_collider) and the mesh of a box of these half extents fit each other: the particles form a regular
 * lattice, at most 2r apart, and the outermost touch the faces of the box from inside. */
typedef struct sandglass_box_desc {
  uint32_t struct_size;
  /* Half the edges along x, y and z, metres, each at least particle_radius and at most SANDGLASS_COORDINATE_LIMIT. */
  float half_extents[3];
  /* r of the scene, metres, 0.0001..10. */
  float particle_radius;
  /* Of the centre, world, metres. Default: the origin. */
  float position[3];
  /* Turns the box about its centre, (x, y, z, w), of any length above 0. Default: no turn. */
  float rotation[4];
  /* Over that of packed sand. Default: 1. */
  float density;
} sandglass_box_desc;

/* Fills *desc with the defaults: at the origin, not turned, density 1; no extents and no radius yet. */
SANDGLASS_API void sandglass_box_desc_default(sandglass_box_desc* desc);

/* How many particles a box has. Fails with INVALID_ARGUMENT: a field out of range or not finite, or more than 2^20
 * particles. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_box_count(const sandglass_box_desc* desc, uint32_t* count,
                                                                       const char** reason);

/* Writes the particles of a box to `points`, 3 floats each, and fills *body for sandglass_scene_add_body:
 * body->particle_positions is `points`, and body->density_ratio the value that gives the whole box the mass of its
 * volume times its density, whatever its lattice. `capacity`: how many particles fit into `points`. Fails like
 * sandglass_box_count, and with CAPACITY. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_box_body(const sandglass_box_desc* desc, float* points,
                                                                      uint32_t capacity, sandglass_body* body,
                                                                      const char** reason);

/* The collider of a box body at a pose: pass it in frame_input.colliders to keep grains out of the box. Its position
 * and rotation are also where the mesh of the box is drawn. The pose is that before the frame, and the collider has the
 * body's velocities, so grains meet the box where it was one frame ago. */
SANDGLASS_API void sandglass_box_collider(const sandglass_box_desc* desc, const sandglass_body_pose* pose,
                                          sandglass_collider* collider);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_BODIES_H */
