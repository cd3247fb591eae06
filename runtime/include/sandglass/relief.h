/* Sandglass relief: the real place as a height map over a plane, from a device's depth images, meshes and planes.
 *
 * An ideal plane knows nothing of the books and boxes on a table. A depth image does, but it has holes, noise, pixels
 * that fly between near and far, and a bias of some per cent; and the table would tremble with it. So a relief gathers
 * images in the cells of a map, ties their bias to the plane, and changes a height only where it must.
 *
 * An app
 *
 *     sandglass::Relief relief;                                     // once; 0.8 megabytes
 *     sandglass::Status status = relief.create();
 *
 *     status = relief.set_plane(anchor.position, anchor.rotation);  // whenever the tracker has moved the plane
 *     sandglass_depth_image depth = sandglass::depth_image();       // whenever there is a new depth image
 *     depth.depth = pixels, depth.width = 256, depth.height = 192, depth.stride = 512;
 *     ...                                                           // intrinsics, pose, time stamp, confidence
 *     input.relief = relief.get(), input.depth = &depth;
 *     status = scene.frame(input, &report);
 *     const sandglass_heights heights = relief.heights();           // metres above the plane, row after row
 *     if (heights.version != shown) upload(heights), shown = heights.version;
 *
 * Sand, skins and bodies lie on it where the app passes its collider, beside the plane's own:
 *
 *     sandglass_collider colliders[2] = {sandglass::floor_at(0), sandglass::relief_collider(relief)};
 *     colliders[0].id = 1, colliders[1].id = 2;
 *     input.colliders = colliders, input.collider_count = 2;
 *
 * What it does. A pixel beside a step or a hole says nothing. The plane is found in each image as the nearest surface
 * to where it should be that has 12 % of the pixels and nothing below it, and all depths are scaled so that it lies at
 * height 0: that takes away a depth camera's bias, which moves by the second. What an image shows of a cell is its
 * highest point. The height is the median of eight such looks, and of the cells around. It is shown only where it
 * differs from what was shown by 6 mm, and by half of what neighbours differ, in one to six images, the more the longer
 * the cell was still. Below 8 mm it is exactly 0. A thing that is taken away goes when the camera sees through it.
 *
 * What an app knows without a depth camera it tells by sandglass_relief_set_meshes, a scanned room for example, and by
 * sandglass_relief_set_outline, where the plane ends.
 *
 * Limits. A map has one height for each cell, up to 0.5 m: what is below a shelf is as solid as the shelf. Cells of 1 cm fill cups and
 * blunt rims; things thinner than 8 mm are not seen; below the plane nothing is believed. Images that a system has
 * smoothed lose things lower than about 12 cm. A hand becomes solid where it rests: pass a mask.
 *
 * Cost. An image is read in the frame that takes it, whatever the budget, in units of 1,024 pixels, at most 16; all
 * else is units of 1,024 pixels or 2,048 cells, as the budget admits. The same bits come out of every instruction set and
 * every division into frames.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_RELIEF_H
#define SANDGLASS_RELIEF_H

#include "sandglass/camera.h"
#include "sandglass/sand.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Triangles in arrays of the app (cast.h). */
struct sandglass_cast_mesh;

/* Heights of the real place over a plane, in a block of the app. */
typedef struct sandglass_relief sandglass_relief;

/* How large a relief is: set once, at create. */
typedef struct sandglass_relief_desc {
  uint32_t struct_size;
  /* Cells along the plane's x and z, 16..256. Default: 128. */
  uint32_t cells[2];
  /* Metres along the side of a cell, 0.005..0.05. Default: 0.01. Smaller ones than the pixels on the plane stay empty. */
  float cell;
  /* The most meshes, 0..1024. Default: 64. */
  uint32_t mesh_capacity;
  /* Metres above the plane, 0.01..0.5: of meshes, what is higher is no ground: ceilings, lamps, a table above the floor.
   * Default: 0.5. */
  float ceiling;
} sandglass_relief_desc;

/* Fills *desc with the defaults. */
SANDGLASS_API void sandglass_relief_desc_default(sandglass_relief_desc* desc);

/* The exact number of bytes that sandglass_relief_create needs. Fails with INVALID_ARGUMENT: a field out of range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_relief_bytes(const sandglass_relief_desc* desc,
                                                                          uint64_t* bytes, const char** reason);

/* Makes a relief whose heights are all 0, over the plane y = 0 about the origin, in the app's block. There is nothing to
 * destroy. Fails like sandglass_relief_bytes, and with MEMORY_TOO_SMALL and MEMORY_ALIGNMENT; nothing was written then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_relief_create(const sandglass_relief_desc* desc,
                                                                           void* block, uint64_t bytes,
                                                                           sandglass_relief** relief,
                                                                           const char** reason);

/* Forgets all that was seen. The plane stays. */
SANDGLASS_API void sandglass_relief_reset(sandglass_relief* relief);

/* The plane in the world: `position` is the middle of the map, `rotation` (x, y, z, w) turns the plane's frame, whose y
 * is the normal, to the world's. The heights move with it. Fails with INVALID_ARGUMENT: a position that is not finite or
 * beyond the coordinate limit, or a rotation that is none. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_relief_set_plane(sandglass_relief* relief,
                                                                              const float position[3],
                                                                              const float rotation[4],
                                                                              const char** reason);

/* How the numbers of a depth image are stored: 16 bits, without sign, or floats. */
typedef int32_t sandglass_depth_format;
enum { SANDGLASS_DEPTH_U16 = 0, SANDGLASS_DEPTH_F32 = 1 };

/* A depth image in the app's memory, and where its camera was, which need not be the view's.
 *
 * Depth is that along the camera's axis, as ARCore, ARKit, WebXR and Camera2 give it, not the distance. 0, NaN, and what
 * is farther than 4 m, is unknown. */
typedef struct sandglass_depth_image {
  uint32_t struct_size;
  /* How its numbers are stored. Default: 16 bits. */
  sandglass_depth_format format;
  /* Pixels as stored, 2..SANDGLASS_CAMERA_SIDE_LIMIT. Where there are more than 16,384, each n-th of each n-th row is
   * taken. */
  uint32_t width, height;
  /* The upper row. */
  const void* depth;
  /* Bytes from row to row, at least those of a row. Negative where the lower row is stored first. */
  int32_t stride;
  /* What a number is multiplied by to give metres, 1e-6..1e3. Default: 0.001. */
  float to_metres;
  /* NULL, or a byte for each pixel: how sure its depth is. */
  const uint8_t* confidence;
  /* Of its rows, as `stride`. */
  int32_t confidence_stride;
  /* Depth of less confidence is unknown: 128 for ARCore's raw depth, 2 for ARKit. */
  uint32_t confidence_min;
  /* NULL, or a byte for each pixel: where it is not 0 the depth is a person's, or what else is not to become solid. */
  const uint8_t* mask;
  /* Of its rows, as `stride`. */
  int32_t mask_stride;
  /* Pixels of the stored image, 1..1e6. */
  float focal_x, focal_y;
  /* The principal point, pixels, within the image; the centre of the first pixel is (0, 0). */
  float centre_x, centre_y;
  /* Where the camera was, world, metres. */
  float position[3];
  /* Camera to world, (x, y, z, w), of the image as stored: x along its rows to the right, y up its columns, looking along
   * -z. */
  float orientation[4];
  /* When it was taken. An image whose time is that of the one before is passed over, because it is the same: a second
   * look at it would count its mistakes twice. 0: each is new. */
  uint64_t timestamp_ns;
} sandglass_depth_image;

/* Fills *image with the defaults: no pixels, 16 bits in millimetres, at the origin without a rotation. */
SANDGLASS_API void sandglass_depth_image_default(sandglass_depth_image* image);

/* Without a scene: takes an image in, whole. *taken, which is optional, is 1, or 0 where its time is that of the one
 * before. Fails with INVALID_ARGUMENT, and says which field is out of range. In a frame it is the same, but an image is
 * passed over while one before is under way; one that cannot be used is counted in report.estimator.ignored_images. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_relief_set_image(sandglass_relief* relief,
                                                                              const sandglass_depth_image* image,
                                                                              int32_t* taken, const char** reason);

/* What is known of the place from triangles, all of it: the meshes of a scanned room, of ARKit or of a headset. `meshes` are
 * those of cast.h, where an app that has casts passes them, too; `closed` and `is_real` say nothing here.
 *
 * A cell gets the highest surface over its middle that is below the ceiling. What is upright has no height: walls, and what
 * is below a table, are planes and fields (field.h). Where a mesh comes, goes, or has another pose, version or array,
 * cells change at once by what it changes, and forget what was seen of them; depth images change them again. A pose that
 * moves no corner by 2 mm changes nothing.
 *
 * The arrays are read in work units: keep them until another call leaves them out. Depth images wait meanwhile, so leave
 * out what moves in every frame. Triangles with an index that no vertex has, or a corner that is not finite, are passed
 * over. Fails with CAPACITY: more meshes than the description has; and with INVALID_ARGUMENT: a
 * field out of range, or a pose that is not finite. Nothing is changed then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_relief_set_meshes(sandglass_relief* relief,
                                                                               const struct sandglass_cast_mesh* meshes,
                                                                               uint32_t count, const char** reason);

/* The outline of the plane as ARCore, ARKit and WebXR tell it: rings of corners, x and z in the plane's frame, metres.
 * `counts` are the corners of each ring, at least 3; a ring in a ring is a hole, and so on (even-odd rule). A cell whose
 * middle is outside is gone: it has the height SANDGLASS_RELIEF_GONE, and what lies there falls. Then pass no half-space
 * for the plane, since heights are solid below. No rings (0): no cell is gone. Takes effect at once. Fails with
 * INVALID_ARGUMENT: a ring of less than 3 corners, more than 4,096 in all, or one that is not finite or beyond the
 * coordinate limit. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_relief_set_outline(sandglass_relief* relief,
                                                                                const float* corners,
                                                                                const uint32_t* counts, uint32_t rings,
                                                                                const char** reason);

/* Metres: the height of a cell beyond the outline. */
#define SANDGLASS_RELIEF_GONE (-8.0f)

/* Without a scene: runs at most so many work units of images and meshes. Returns how many were run; 0: there are none. */
SANDGLASS_API uint32_t sandglass_relief_run(sandglass_relief* relief, uint32_t units);

/* The heights as they are shown now. They are stable until units are run again. */
typedef struct sandglass_heights {
  uint32_t struct_size;
  /* Cells along x and z. */
  uint32_t cells[2];
  /* Metres above the plane, x within z: heights[z * cells[0] + x] is that at the middle of the cell. Multiples of
   * 0.25 mm, -0.03..0.5; SANDGLASS_RELIEF_GONE beyond the outline. */
  const float* heights;
  /* Metres along the side of a cell. */
  float cell;
  /* Where the first cell's corner lies in the plane, and the edges of the map along x and along z, world, metres; up is
   * the plane's normal. */
  float corner[3], along[3], across[3], up[3];
  /* The depths of the last image times this are those of the plane, 0.92..1.08: what to multiply a depth texture by that
   * is compared with what is drawn. 1 until the plane was seen. */
  float depth_scale;
  /* What the last version has changed: cells from `low`, below `high`, along x and z. */
  uint32_t low[2], high[2];
  /* Grows by 1 when heights have changed. An app that has missed one uploads all. */
  uint64_t version;
} sandglass_heights;

/* Fills *heights. Set heights->struct_size before. */
SANDGLASS_API void sandglass_relief_get_heights(const sandglass_relief* relief, sandglass_heights* heights);

/* Fills *collider with the relief as sand meets it: SANDGLASS_SHAPE_RELIEF at the pose of the plane, at rest. Pass it to
 * each frame, with an id.
 *
 * Between the middles of four cells heights go over into each other (bilinear). All below them is solid, however deep.
 * Beyond the map there is nothing, and sand falls past; half a cell beyond its outer cells the relief ends in a face.
 * So pass the plane, too, as a half-space. A height may change at any time, by any amount: what lies over the cells
 * around wakes, and nothing else. What is inside then comes out as gently as out of any collider (`Gentle`, sand.h):
 * nothing is thrown. It holds nothing as a vessel does: the correction of a plane takes no sand along.
 *
 * As sink and as region, it is what lies below its heights. A saved scene has no heights: restore them before the first
 * frame (sandglass_relief_restore), else what slept on them falls. */
SANDGLASS_API void sandglass_relief_get_collider(const sandglass_relief* relief, sandglass_collider* collider);

/* The bytes that sandglass_relief_save writes: of all heights (whole 1), or of those that the last version has changed (0). */
SANDGLASS_API uint64_t sandglass_relief_save_bytes(const sandglass_relief* relief, uint32_t whole);

/* Writes heights, so that another relief of the same description shows them: a later session (whole 1), or a second device
 * and a replay, which take what each version has changed (0). *written is the number of bytes. Fails with
 * MEMORY_TOO_SMALL; nothing was written then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_relief_save(const sandglass_relief* relief, uint32_t whole,
                                                                         void* data, uint64_t bytes, uint64_t* written,
                                                                         const char** reason);

/* Shows what sandglass_relief_save wrote; the bytes may come from anywhere. It is a version of its own. What was seen of
 * these cells is forgotten: they change again after five looks. Fails with INVALID_ARGUMENT: the bytes are no saved
 * relief, of another version or description, damaged, or hold a height that no relief has. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_relief_restore(sandglass_relief* relief, const void* data,
                                                                            uint64_t bytes, const char** reason);

/* A 64-bit hash of all that was seen. It is equal on every instruction set and compiler. */
SANDGLASS_API uint64_t sandglass_relief_hash(const sandglass_relief* relief);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_RELIEF_H */
