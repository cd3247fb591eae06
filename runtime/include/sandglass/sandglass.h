/* Sandglass: sand, light and shadow for augmented reality, inside a fixed slice of every frame.
 *
 * This header is all of the sand: scene.h, sand.h, bodies.h and frame.h, with sampling.h (points in volumes and on
 * surfaces) and field.h (signed-distance fields). The rest of the public API stands in headers of its own: camera.h (its
 * image), estimator.h (the light of one image), room.h (the light of all images), renderers.h (light as renderers want
 * it), skin.h (the surface of the sand as a mesh), cast.h (the shadows of any triangles), shadow.h (those of objects that
 * were baked), pile_shadow.h (the shadow of the sand) and relief.h (heights of the real place). sandglass.hpp adds owner
 * types for C++.
 * Units, errors, the rule for NULL, and version and ABI: see types.h, whose rules hold for all functions.
 *
 * An app
 *
 *   1. fills a sandglass_scene_desc (start from sandglass_scene_desc_default),
 *   2. asks sandglass_scene_bytes how much memory that scene needs,
 *   3. hands one block of that size to sandglass_scene_create,
 *   4. adds material (sandglass_scene_add), sampled by sandglass_sample_points or its own,
 *   5. calls sandglass_scene_frame once a frame, with colliders, a time step and a budget in nanoseconds.
 *
 * After step 3 the library allocates nothing, starts no thread, takes no lock and reads no clock but the one that it
 * was handed. There is nothing to destroy: the block is the scene, and it belongs to the app.
 *
 * Threads. One scene belongs to one thread at a time. Different scenes are independent.
 *
 * Words. A *particle* carries the physics. A *grain* is what is drawn. A *collider* is a shape that pushes sand. A
 * *work unit* is a bounded piece of work; a frame can end between any two. Numbers in parentheses such as (4.37) are
 * equations of the dissertation that runtime/README.md names. That page also lists every correction to it. */
#ifndef SANDGLASS_SANDGLASS_H
#define SANDGLASS_SANDGLASS_H

#include "sandglass/bodies.h"
#include "sandglass/field.h"
#include "sandglass/frame.h"
#include "sandglass/sampling.h"
#include "sandglass/sand.h"
#include "sandglass/scene.h"
#include "sandglass/types.h"

#endif /* SANDGLASS_SANDGLASS_H */
