/* Sandglass room: the light of the whole room at the place of an object, from what the camera has seen so far.
 *
 * One image of a table says little about the lamp above it; a camera that has looked around says much. So the camera's
 * images are gathered in 512 parts of the sphere around the session's place, and what nobody has seen yet is filled
 * with what is usual. The answer is the light that is to be expected: soft where little is known, sharper the more was
 * seen.
 *
 * An app
 *   1. hands a block of sandglass_room_bytes to sandglass_room_create,
 *   2. passes room and camera image to sandglass_scene_frame (input.room, input.camera); or, without a scene, calls
 *      sandglass_room_set_image for each image,
 *   3. asks sandglass_room_get for the light at each object's place, lets what is shown fade towards it
 *      (sandglass_room_fade), and hands the cells to the object's shadow (sandglass_shadow_set_cells) and to that
 *      of the sand (sandglass_pile_shadow_set_cells).
 *
 * It works from the first frame on: before any image the light is what is usual in a room. The network of
 * estimate.h is not needed; where an app has one, its estimate is one more input.
 *
 * Exposure. A camera that adapts shows a dark room and a bright one alike. Fill in sandglass_camera_image.exposure
 * where the system tells it. Where it is 0, the library finds it from what the image shows again of what was seen
 * before. Give it with every image or with none.
 *
 * Clipped pixels hide how bright a lamp is. sandglass_room_light.clipped says what share of the light comes from there,
 * as far as one can tell: little may hide a strong lamp. Above 0.02, an app that can set its camera helps most by a
 * short exposure, such as a sixty-fourth, for as long as desc.interval, so that the room takes one such image.
 *
 * Light that changes. What the camera sees again is learned within a few images. Where four fifths of that have become
 * brighter or darker by half and the app tells the exposure, what is out of the picture is taken to have changed as
 * much. So the level follows at once; from where the light comes is learned when the camera looks there.
 *
 * Radiance is in the camera's scale: 1 is what the last image shows as white, in linear light.
 *
 * Cost. An image is read in the call or the frame that it is passed to, in units of at most 64 parts. Nothing is
 * allocated, no clock is read, and the same bytes come out of every instruction set and every division into frames.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_ROOM_H
#define SANDGLASS_ROOM_H

#include "sandglass/estimate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How a room is remembered: set once, at create. */
typedef struct sandglass_room_desc {
  uint32_t struct_size;
  /* Metres, 0.1..1000: how far the walls are from the place of the session, roughly. What is seen counts as being that
   * far away, so that it can be moved to where an object stands. Default: 3. */
  float radius;
  /* Seconds, 1..1e6: what was seen counts half after so long, because light changes. Default: 180. */
  float half_life;
  /* Seconds, 0..60: an image taken less than this after the last one that was used is passed over, to save energy.
   * Default: 0.1. */
  float interval;
} sandglass_room_desc;

/* Fills *desc with the defaults. */
SANDGLASS_API void sandglass_room_desc_default(sandglass_room_desc* desc);

/* The exact number of bytes that sandglass_room_create needs, below 16 KiB. Fails with INVALID_ARGUMENT: a field out of
 * range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_bytes(const sandglass_room_desc* desc,
                                                                        uint64_t* bytes, const char** reason);

/* Makes a room that nobody has seen, in the app's block. There is nothing to destroy. Fails like sandglass_room_bytes,
 * and with MEMORY_TOO_SMALL and MEMORY_ALIGNMENT; nothing was written then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_create(const sandglass_room_desc* desc, void* block,
                                                                         uint64_t bytes, sandglass_room** room,
                                                                         const char** reason);

/* Forgets all that was seen: for a new room. */
SANDGLASS_API void sandglass_room_reset(sandglass_room* room);

/* Without a scene: takes an image in, whole, unless `interval` has not passed. *taken, which is optional, is 1 if it
 * was, else 0. Fails like sandglass_camera_check. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_set_image(sandglass_room* room,
                                                                            const sandglass_camera_image* image,
                                                                            int32_t* taken, const char** reason);

/* The room turns and moves with the world's frame, as sandglass_scene_move does: x becomes rotation * x + translation.
 * Gravity stays where it is, so the rotation must be one about the y axis. Fails with INVALID_ARGUMENT: a rotation that
 * tilts y by more than 0.001, or a number that is not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_move(sandglass_room* room, const float rotation[4],
                                                                       const float translation[3], const char** reason);

/* The light at one place. */
typedef struct sandglass_room_light {
  uint32_t struct_size;
  /* 0: no image was taken in yet, and all is what is usual. */
  uint32_t valid;
  /* The share of a level floor's irradiance that comes from each cell (types.h); all are 1 together. */
  float cells[SANDGLASS_LIGHT_CELLS];
  /* The same without `main_share`, which is taken from the cells that the main light stands in: what the ambient shadow
   * is drawn with, beside a sharp shadow of the main light. */
  float ambient_cells[SANDGLASS_LIGHT_CELLS];
  /* World, unit vector towards the main light. */
  float main_direction[3];
  /* 0..1: the share of the floor's irradiance that comes from the main light alone. It is above 0 only where such a
   * light was seen; it is the opacity of a sharp shadow's umbra. */
  float main_share;
  /* The colour of the main light, linear RGB; the luminance is 1. */
  float main_colour[3];
  /* The irradiance of a level floor, linear RGB. A white floor shows irradiance / pi. */
  float irradiance[3];
  /* Radiance of all directions as real spherical harmonics, laid out like sandglass_light_estimate.sh. */
  float sh[27];
  /* 0..1: how much of the light was seen, as far as one can know: the share of the usual light that comes from parts
   * that were seen. */
  float seen;
  /* 0..1: the share of the irradiance that comes from parts that were clipped to white. */
  float clipped;
  /* World, unit vector: where looking would tell most. */
  float look[3];
  /* The radiance that the last image shows as white, in the room's own scale, which no exposure changes. irradiance and
   * sh times this may be compared from image to image. */
  float white;
} sandglass_room_light;

/* The light at `position`, metres in the world's frame: where an object stands. `estimate` is optional: that of a
 * network (estimate.h), whose direction says where light is to be expected among what was not seen. Set
 * light->struct_size before.
 *
 * It reads all 512 parts: 1.4 million instructions on ARM, nearly four times what an image takes. Ask it when an object
 * moved or a new image came, not for each of its vertices. Fails with INVALID_ARGUMENT: a position that is not
 * finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_get(const sandglass_room* room,
                                                                      const float position[3],
                                                                      const sandglass_light_estimate* estimate,
                                                                      sandglass_room_light* light, const char** reason);

/* Lets light come and go softly: moves *shown, which the app keeps for each object, towards *now, which
 * sandglass_room_get gave, by the share 1 - exp(-seconds / 0.5). Call it in each frame with the time since the frame
 * before, and draw with *shown. Start from the light before the first image, so that light comes in from what is usual;
 * a *shown whose struct_size is 0 becomes *now.
 *
 * No cell and no share moves by more than that share of what is left: 3.3 % in a frame at 60 Hz. A main light that is
 * more than 20 degrees from the one before fades out before the new one fades in. irradiance and sh follow a change of
 * exposure at once. Does nothing where `seconds` is not in 0..3600, or *now was not filled or is not finite. */
SANDGLASS_API void sandglass_room_fade(sandglass_room_light* shown, const sandglass_room_light* now, float seconds);

/* The bytes that sandglass_room_save writes. */
SANDGLASS_API uint64_t sandglass_room_save_bytes(const sandglass_room* room);

/* Writes what was seen, so that a later session in the same world frame need not look around again. *written is the
 * number of bytes. Fails with MEMORY_TOO_SMALL; nothing was written then. An image under way is left out. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_save(const sandglass_room* room, void* data,
                                                                       uint64_t bytes, uint64_t* written,
                                                                       const char** reason);

/* Reads what sandglass_room_save wrote; the bytes may come from anywhere. What was seen is then as old as it was when
 * it was saved. Fails with INVALID_ARGUMENT: the bytes are no saved room, of another version, damaged, or hold a number
 * that no room has. The room is as it was then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_restore(sandglass_room* room, const void* data,
                                                                          uint64_t bytes, const char** reason);

/* A 64-bit hash of all that was seen. It is equal on every instruction set and compiler. */
SANDGLASS_API uint64_t sandglass_room_hash(const sandglass_room* room);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_ROOM_H */
