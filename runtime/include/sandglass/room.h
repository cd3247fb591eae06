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
 * estimator.h is not needed; where an app has one, its estimate is one more input.
 *
 * Exposure. A camera that adapts shows a dark room and a bright one alike. Fill in sandglass_camera_image.exposure
 * where the system tells it. Where it is 0, the library finds it from what the image shows again of the image before,
 * and of what was seen earlier. It may come late, and be missing now and then. sandglass_room_exposure says how bright to draw over an image.
 *
 * White balance. A camera that adapts shows a warm room and a cold one alike. What is drawn follows the picture: by
 * sandglass_camera_image.gains where the system tells them, else by the hue of what an image shows again.
 *
 * Clipped pixels hide how bright a lamp is. sandglass_room_light.clipped says what share of the light comes from there,
 * as far as one can tell: little may hide a strong lamp. An app that can set its camera (AVFoundation, Camera2,
 * ARCore's shared camera) helps most by one image that is exposed for `short_exposure` times as long, when desc.interval
 * has passed. Lower the sensor's gain first, then the time. Keep such an image from the tracker and from
 * the screen. Lamps that pulse flicker in it: an exposure of a pulse, 1/100 or 1/120 s, through less gain, does not.
 *
 * Light that changes. What the camera sees again is learned within a few images. Where two thirds of that have become
 * brighter or darker by half, or all by a quarter, and the app tells the exposure, the light of the whole room is taken
 * to have changed as much. So the level follows at once, also of what is out of the picture, and returns with the
 * light; from where the light comes is learned when the camera looks there. An image that is black or clipped almost
 * everywhere teaches nothing; one that no change of light explains, such as a finger over the lens, or that is a
 * twentieth or twenty times as bright, nothing for 2.5 seconds.
 *
 * Another room. Where images of which nothing is learned have a room's detail, and are three times as bright or as dark
 * as known, or the camera has gone farther than `radius` from where the room began, they bound the level. After half a
 * second of it so far away the old room is forgotten.
 *
 * Radiance is in the camera's scale: 1 is what the last image shows as white, in linear light.
 *
 * Cost. An image is read in the call or the frame that it is passed to, in units of at most 64 parts. Nothing is
 * allocated, no clock is read, and the same bytes come out of every instruction set and every division into frames.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_ROOM_H
#define SANDGLASS_ROOM_H

#include "sandglass/estimator.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The light of the room from all that the camera has seen, in a block of the app. */
typedef struct sandglass_room sandglass_room;

/* How a room is remembered: set once, at create. */
typedef struct sandglass_room_desc {
  uint32_t struct_size;
  /* Metres, 0.1..1000: how far the walls are from the place of the session, roughly. What is seen counts as being that
   * far away, so that it can be moved to where an object stands. When the camera goes farther it is another room, or a
   * larger one: from then on the camera's place is the middle, and walls are four times as far away, up to 1000 m.
   * 0, the default: 3 m, until a camera that walks sees that what is above the horizon is far, as in the open: then 192.
   */
  float radius;
  /* Seconds, 1..1e6: what was seen counts half after so long, because light changes. Default: 180. */
  float half_life;
  /* Seconds, 0..60: an image taken less than this after the last one that was used is passed over, to save energy.
   * Default: 0.1. */
  float interval;
  /* 1: the room keeps what another system knows of its light (sandglass_room_set_cube, _set_harmonics), in 5 KiB more.
   * Default: 0. */
  uint32_t probe;
  /* 1: the room keeps what reflections need (sandglass_room_get_cube), in 96 KiB more; an image then takes six times as
   * long. Default: 0. */
  uint32_t reflections;
} sandglass_room_desc;

/* Fills *desc with the defaults. */
SANDGLASS_API void sandglass_room_desc_default(sandglass_room_desc* desc);

/* The exact number of bytes that sandglass_room_create needs, below 16 KiB without `probe`. Fails with INVALID_ARGUMENT: a field out of
 * range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_bytes(const sandglass_room_desc* desc,
                                                                        uint64_t* bytes, const char** reason);

/* Makes a room that nobody has seen, in the app's block. There is nothing to destroy. Fails like sandglass_room_bytes,
 * and with MEMORY_TOO_SMALL and MEMORY_ALIGNMENT; nothing was written then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_create(const sandglass_room_desc* desc, void* block,
                                                                         uint64_t bytes, sandglass_room** room,
                                                                         const char** reason);

/* Forgets all that was seen: for a new room. What sandglass_room_fade shows stays until the first image. */
SANDGLASS_API void sandglass_room_reset(sandglass_room* room);

/* Without a scene: takes an image in, whole, unless `interval` has not passed. *taken, which is optional, is 1 if it
 * taught something, else 0. Fails like sandglass_camera_check; and where time stamps grow by less than a
 * millisecond from image to image, so that they cannot be nanoseconds. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_set_image(sandglass_room* room,
                                                                            const sandglass_camera_image* image,
                                                                            int32_t* taken, const char** reason);

/* What another system knows of the room's light, where it gives no camera image, or beside camera images.
 *
 * It lies below what the camera has seen: a part that camera images have shown is theirs, as far as they have shown it;
 * the rest is the probe's, as far as `confidence` says; what is left is what is usual. Where camera images are clipped
 * and the probe is not, the probe says how bright the light is. Each probe replaces the one before, so pass it whenever
 * the system has a new one. Where a system gives a cube and harmonics, pass the cube alone.
 *
 *   visionOS    cube, as the texture's pixel format says; originFromAnchorTransform; exposure 1 / cameraScaleReference
 *   ARKit       cube, BGRA8, level 0 and no smaller one: what was white there is grey; the anchor's transform
 *   Android XR  cube, RGBA16F or RGB32F; `rotation` (identity with `reproject`); position of the headset
 *               harmonics (XR_ANDROID_light_estimation), either kind, as ARCore's: nothing tells their phase
 *   ARCore      cube, RGBA16F; identity; position of the camera, and exposure of its image
 *               harmonics, AMBIENT, with_phase 1; the main light's direction and intensity as they are
 *   WebXR       cube, RGBA16F or RGBA8; the pose of probeSpace. Chromium passes on what ARCore or Android XR gives, so
 *               harmonics as ARCore's, turned by probeSpace; primaryLightDirection and primaryLightIntensity
 *   Unity       cube, as its texture; left_handed 1; positions and rotations with z mirrored
 *
 * That is from their documents and sources. None was tried on a device, and the handedness of ARKit's and visionOS'
 * cubes is not established: sandglass_room_probe_fit tells it once the camera has looked around, or hold a lamp to one
 * side and see where main_direction is. All errors that are published here are of cubes resampled from the true light:
 * a system's own are larger.
 *
 * Unit. `exposure` is 1 over the radiance that the value 1 stands for, in the unit of sandglass_camera_image.exposure.
 * 0: unknown. Then it is found from the parts that both camera and probe show; without camera images the value 1 is
 * white. The white balance of the probe is brought to that of the camera in the same way, by up to a factor of 2. */

/* How the texels of a cube are stored: bytes in sRGB, or linear numbers of 0..65000. RGBA16F: halves. A number above,
 * or infinity, is light that the cube cannot hold: it counts as the brightest about it, and as clipped
 * (sandglass_room_light.clipped). One below counts as 0, and what is NaN is left out. */
typedef int32_t sandglass_cube_format;
enum {
  SANDGLASS_CUBE_RGBA8 = 0,
  SANDGLASS_CUBE_BGRA8 = 1,
  SANDGLASS_CUBE_RGBA16F = 2,
  SANDGLASS_CUBE_RGB32F = 3,
  SANDGLASS_CUBE_RGBA32F = 4
};

/* A cube of the room: six images, in the order and with the rows of every graphics API (+x, -x, +y, -y, +z, -z). The
 * texel that a sampler gives for the direction d shows what lies towards d in the cube's frame. */
typedef struct sandglass_cube {
  uint32_t struct_size;
  /* How its texels are stored. */
  sandglass_cube_format format;
  /* Texels along an edge, 4..1024. Of a linear cube take the mip level of 16 or 32, of bytes always level 0. */
  uint32_t size;
  /* Bytes from row to row of each face. Negative where the lower row is stored first; a face is then its upper row. */
  int32_t stride;
  /* The upper row of each face: +x, -x, +y, -y, +z, -z. */
  const void* faces[6];
  /* The cube's frame to world, (x, y, z, w). Identity where the system aligns cubes with the world. */
  float orientation[4];
  /* 1: the cube's frame is left-handed, z reversed. 0: right-handed. */
  uint32_t left_handed;
  /* Where it was taken, world, metres. */
  float position[3];
  /* See above. 0..1e6. */
  float exposure;
  /* 0..1: the share of what it shows that is believed where the camera has seen nothing. Default: 1. Take 0.5 for what
   * a system has guessed rather than seen. */
  float confidence;
  /* 1: it is read in work units of the next sandglass_scene_frame that gets this room; the texels must stay until then.
   * 0: whole, in the call. */
  uint32_t in_frame;
} sandglass_cube;

/* Fills *cube with the defaults. */
SANDGLASS_API void sandglass_cube_default(sandglass_cube* cube);

/* Takes a cube in. NULL: forgets the probe. Bytes are read at 9 points of each of the 512 parts, linear texels at as many
 * as hardly leave one out, at most 169. Fails with INVALID_ARGUMENT: a room without `probe`, a field of *cube that is
 * out of range, or no texel that is a number of 0..65000; there is no probe then, and with `in_frame` none after the
 * frame. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_set_cube(sandglass_room* room,
                                                                           const sandglass_cube* cube,
                                                                           const char** reason);

/* Harmonics with all the light (TOTAL), or without the main light, which is then given beside them (AMBIENT). */
typedef int32_t sandglass_harmonics_kind;
enum { SANDGLASS_HARMONICS_TOTAL = 0, SANDGLASS_HARMONICS_AMBIENT = 1 };

/* Nine harmonics. Of all rooms that have them the most even one is taken, because they hardly tell where a lamp is. */
typedef struct sandglass_harmonics {
  uint32_t struct_size;
  /* Whether `sh` has the main light. */
  sandglass_harmonics_kind kind;
  /* Radiance, world, laid out like sandglass_estimator_light.sh; see `with_phase`. */
  float sh[27];
  /* Of AMBIENT: world, towards the main light, which is far: it comes from there at every place, until the camera has
   * seen it. Where desc.radius is given it is so far from `position` as the walls. 0, 0, 0: there is none. */
  float main_direction[3];
  /* Of AMBIENT: the irradiance of a surface that faces the main light, linear RGB. */
  float main_irradiance[3];
  /* Where they are of, world, metres. */
  float position[3];
  /* See above. 0..1e6. */
  float exposure;
  /* As that of sandglass_cube. */
  float confidence;
  /* As that of sandglass_cube; nothing need stay. */
  uint32_t in_frame;
  /* 1: `sh` has the Condon-Shortley phase, so those of index 1, 3, 5 and 7 have the other sign. */
  uint32_t with_phase;
} sandglass_harmonics;

/* Fills *harmonics with the defaults. */
SANDGLASS_API void sandglass_harmonics_default(sandglass_harmonics* harmonics);

/* Takes harmonics in, in place of a cube. NULL: forgets the probe. Fails with INVALID_ARGUMENT: a room without `probe`,
 * or a number that is not finite or out of range. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_set_harmonics(sandglass_room* room,
                                                                                const sandglass_harmonics* harmonics,
                                                                                const char** reason);

/* For debugging: how the probe would fit best to what the camera has seen of the room, turned clockwise about y as seen
 * from above by *turn_deg (0, 90, 180, 270), and mirrored where *mirrored is 1. 0 and 0: it was passed as it is. Returns
 * 1, or 0 where there is no probe or the two share too little; nothing is written then. */
SANDGLASS_API int32_t sandglass_room_probe_fit(const sandglass_room* room, uint32_t* turn_deg, int32_t* mirrored);

/* The room turns and moves with the world's frame, as sandglass_scene_move does: x becomes rotation * x + translation.
 * Gravity stays where it is, so the rotation must be one about the y axis. Fails with INVALID_ARGUMENT: a rotation that
 * tilts y by more than 0.001, or a number that is not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_move(sandglass_room* room, const float rotation[4],
                                                                       const float translation[3], const char** reason);

/* The light at one place. */
typedef struct sandglass_room_light {
  uint32_t struct_size;
  /* 0: neither an image nor a cube or harmonics were taken in yet, and all is what is usual. */
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
  /* Radiance of all directions as real spherical harmonics, laid out like sandglass_estimator_light.sh. What comes from
   * below is `floor`. */
  float sh[27];
  /* The radiance of the floor around the place, linear RGB, as far as `sh` shows it below: sh is what comes from above
   * plus floor * 1.7725 in coefficient 0, and floor * -1.5350 in coefficient 1, for each colour. So a point that sees
   * other things below it than the floor, such as sand on sand, takes floor * (1 - n.y) / 2 from irradiance / pi. */
  float floor[3];
  /* 0..1: how much of the light was seen, as far as one can know: the share of the usual light that comes from parts
   * that were seen. */
  float seen;
  /* 0..1: the share of the irradiance that comes from parts that were clipped to white. */
  float clipped;
  /* World, unit vector: where looking would tell most. */
  float look[3];
  /* What to multiply the exposure of one image by, so that it tells how bright what is clipped before the camera now is:
   * 1/64, and where that was not short enough 1/4096 or 1/262144. A lamp of unknown size is asked for, too, twelve times
   * at most. 1: there is no need, or no exposure was given. */
  float short_exposure;
  /* The radiance that the last image shows as white, in the room's own unit, which no exposure changes. irradiance and
   * sh times this may be compared from image to image. A short exposure for lamps does not count as the last image. */
  float white;
  /* 1: the app has given an exposure, and `white` is 1 / exposure. */
  uint32_t exposure_known;
  /* A number for the room's own unit: another one after sandglass_room_reset, after sandglass_room_restore, and after
   * the first exposure that was given. */
  uint32_t unit;
  /* How large the main light is from there, radians, 0..1.5: what sandglass_cast_set_light takes. It is measured in
   * images that show the light whole and not clipped, as one of `short_exposure` does, or clipped amid black. 0: not
   * known yet, and the cast takes its usual size. */
  float main_angular_diameter;
  /* By how much that may be off, radians: half a pixel of the images, and how far they differ. */
  float main_angular_error;
  /* The white balance of the last image beside that of the first one, red, green and blue, all above 0. Every colour here
   * has it, as the picture has. A colour over it may be compared from image to image. */
  float balance[3];
} sandglass_room_light;

/* Where the light is asked for. */
typedef struct sandglass_room_place {
  uint32_t struct_size;
  /* Metres in the world's frame: the object's foot, on the floor or whatever it stands on. */
  float position[3];
  /* Optional: that of a network (estimator.h), whose direction says where light is to be expected among what was not
   * seen. */
  const sandglass_estimator_light* network;
  /* Optional: the light that is shown there (sandglass_room_fade). Its main light stays the main one until another is
   * a quarter stronger. */
  const sandglass_room_light* shown;
  /* Optional: three numbers, the radiance of the floor around the foot, linear RGB, where 1 is what the last image shows
   * as white; 0 is black. NULL: as the camera has seen it there, at most nine tenths of the irradiance over pi; and where
   * it has not, 0.18 of that. */
  const float* floor;
  /* Optional: three numbers, the direction away from the surface whose light is asked for, world; a wall's, say. cells,
   * main light, irradiance, seen and clipped are then of that plane, in its frame: y is the normal, x is `along`. The
   * harmonics are the room's, as ever. NULL: a level floor, +y. */
  const float* normal;
  /* Optional: three numbers, a direction along the plane, from which the cells' azimuths count. NULL: +x. */
  const float* along;
} sandglass_room_place;

/* Fills *place with the defaults: the origin, and nothing else. */
SANDGLASS_API void sandglass_room_place_default(sandglass_room_place* place);

/* The light at a place. Set light->struct_size before.
 *
 * It reads all 512 parts: 1.2 million instructions on ARM, three times what an image takes. Ask it when an object
 * moved or a new image came, not for each of its vertices. A plane that is no floor takes twice as long. Fails with
 * INVALID_ARGUMENT: a number of *place that is not finite or out of range, or a plane without a direction. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_get(const sandglass_room* room,
                                                                      const sandglass_room_place* place,
                                                                      sandglass_room_light* light, const char** reason);

/* Texels along an edge of the cube that sandglass_room_get_cube fills. */
#define SANDGLASS_ROOM_CUBE_SIZE 32

/* What a shiny object reflects: one face of a cube map of the room, as it is seen from a place.
 *
 * position     world, metres: the middle of the object.
 * height       metres of that above what the object stands on, 0..1000, which it reflects as the camera saw it there. 0:
 *              it stands on nothing, and all is as far away as the room's walls.
 * face         0..5: +x, -x, +y, -y, +z, -z.
 * left_handed  0: the directions of the texels are the world's. 1: of an engine whose z is the world's -z, as Unity's.
 * texels       4 * 32 * 32 halves, RGBA, the upper row first: what GL, Metal, Vulkan and Direct3D load as that face, so that a
 *              sampler gives for a direction what lies there. (three.js mirrors x of such cubes unless the texture's
 *              isRenderTargetTexture is true.) RGB is radiance, where 1 is what the last image shows as white, at most 65000:
 *              draw it times what irradiance is drawn with. A is the share that was seen there, 0..1; what was not is filled as
 *              in sandglass_room_get, with no detail.
 *
 * It is as sharp as a texel, 2.8 degrees, and not prefiltered: engines do that (Filament's IBLPrefilterContext, three.js'
 * PMREMGenerator, Unity's reflection probes). Ask for one face a frame, when a new image came. A room that was restored
 * knows no detail until its camera has looked around again. Fails with INVALID_ARGUMENT: a room without `reflections`,
 * `height`, `face` or `left_handed` out of range, or a position that is not finite or out of range; nothing is written then. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_get_cube(const sandglass_room* room,
                                                                           const float position[3], float height,
                                                                           uint32_t face, uint32_t left_handed,
                                                                           uint16_t* texels, const char** reason);

/* What to multiply irradiance and sh of a light by, known or shown, to draw it over `image`, which is on the screen. It
 * is 1 where the image was exposed as the room's last one was, or where its exposure is not known. While a short image
 * for lamps is on the screen, it is dark, and so is what is drawn over it. */
SANDGLASS_API float sandglass_room_exposure(const sandglass_room_light* light, const sandglass_camera_image* image);

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

/* Writes what was seen, and the probe, so that a later session in the same world frame need not look around again. *written is the
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
