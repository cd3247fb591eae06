/* Sandglass light: where the light of a room comes from, of what colour it is, and how hard its shadows are, from one
 * image of the camera (chapter 5).
 *
 * An app
 *   1. reads a network's file into memory (aligned to 8 bytes) and fills a sandglass_light_desc,
 *   2. asks sandglass_light_bytes, and hands a block of that size to sandglass_light_create,
 *   3. passes light and camera image to sandglass_scene_frame (input.light, input.camera) whenever it has an image,
 *      which gives the network part of the frame's budget; or, without a scene, calls sandglass_light_set_image and
 *      then sandglass_light_run, with as many units as fit,
 *   4. reads sandglass_light_get, and converts it for its renderer (sandglass_light_to_filament, _to_arkit, _to_unity).
 *
 * An estimate takes several frames; the one before it stays valid until it is complete. Nothing is allocated, no clock
 * is read, and the same bytes come out of every instruction set and every division into frames.
 *
 * Cost of an image. Its planes are read within the call that they are passed to, and never after: what is kept is 256 x
 * 192 pixels. So an image is resampled in its frame, whatever the budget is, and the cost grows with the image. As a
 * share of the time of one estimate (7 ms on an x86 server) it is 0.13 for 640 x 480 and 0.25 for 1920 x 1440 in NV12,
 * 1.8 for 4032 x 3024 in RGBA, and 6 for 16384 x 3072 in RGB. It is cut into work units that read about 256 KiB of the
 * image, below 0.1 ms each at every size. Pass the size of the camera's preview, not that of its photographs.
 *
 * Conventions. The world frame is right-handed with y up, as in sandglass.h. Directions are unit vectors *towards* the
 * light. Colours are linear, in the tone-mapped range of the picture: 1 is what the camera shows as white.
 *
 * Radiometry. The dissertation gives none. Of the rules that were measured (`sandglass ceiling`), this one lights an
 * object best. The ambient light has the radiance a. The directional light gives a surface that faces it the irradiance
 * pi * strength * c. The strength is such that its share of what the level floor receives is the contrast o:
 *   strength = Y(a) / Y(c) * o / (1 - o) / cos(theta),   o at most 0.95, cos(theta) at least 0.1, strength at most 64
 * with luminances Y (5.2) and the angle theta of the light from the zenith. A white diffuse surface that faces the
 * light then has the radiance a + strength * c, in the camera's tone-mapped range.
 *
 * An app that knows the tone curve of its camera does better to light in radiance. It multiplies both lights by
 * Y(inverse of the curve at a) / Y(a), multiplies shadows onto the camera's image through the inverse, and applies the
 * curve over all at the end. The error is then 0.0206 instead of 0.0230 (RMSE over 20 views, `sandglass_lab verify shot`).
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_LIGHT_H
#define SANDGLASS_LIGHT_H

#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

struct sandglass_room_light;

/* ------------------------------------------------------------------------------------------------ camera image */

/* The width of what the network sees, pixels. */
#define SANDGLASS_LIGHT_WIDTH 256
/* The height of what the network sees, pixels. */
#define SANDGLASS_LIGHT_HEIGHT 192
/* The longest side of a camera image, pixels. */
#define SANDGLASS_CAMERA_SIDE_LIMIT 16384

/* How the bytes of an image are laid out.
 *
 * RGB and RGBA: one plane, sRGB. NV12 and NV21: luma, then pairs of chroma at half resolution, U first in NV12, V first
 * in NV21. I420: luma, U, V.
 *
 * ARCore's YUV_420_888 is NV12, NV21 or I420, by the pixel stride and order of its planes. ARKit's capturedImage is
 * NV12. */
typedef int32_t sandglass_camera_format;
enum {
  SANDGLASS_CAMERA_RGB = 0,
  SANDGLASS_CAMERA_RGBA = 1,
  SANDGLASS_CAMERA_NV12 = 2,
  SANDGLASS_CAMERA_NV21 = 3,
  SANDGLASS_CAMERA_I420 = 4
};

/* How luma and chroma become RGB: by ITU-R BT.601 or BT.709, with luma over 0..255 (FULL) or over 16..235 (VIDEO).
 * Android's cameras give FULL_601. iOS names its matrix in the attachments of the pixel buffer. */
typedef int32_t sandglass_yuv_range;
enum {
  SANDGLASS_YUV_FULL_601 = 0,
  SANDGLASS_YUV_VIDEO_601 = 1,
  SANDGLASS_YUV_FULL_709 = 2,
  SANDGLASS_YUV_VIDEO_709 = 3
};

/* A `turn_deg` that lets the library choose the quarter turn by which the world's up comes nearest to the image's up.
 * It needs a pose of the stored image. */
#define SANDGLASS_TURN_FROM_POSE 0xffffffffu

/* An image of a pinhole camera, in the app's memory, and where the camera looked.
 *
 * The pose is that of the image *as stored*, unless `pose_is_upright` is 1: x along its rows to the right, y up its
 * columns, looking along -z. ArCamera_getPose and ARCamera.transform are such poses. ArCamera_getDisplayOrientedPose
 * and the transform of Unity's AR camera are those of the upright image. Only the rotation matters: light comes from
 * far. */
typedef struct sandglass_camera_image {
  uint32_t struct_size;
  /* How its pixels are stored. */
  sandglass_camera_format format;
  /* For NV12, NV21 and I420. */
  sandglass_yuv_range range;
  /* Pixels as stored, 2..SANDGLASS_CAMERA_SIDE_LIMIT; even in NV12, NV21 and I420. */
  uint32_t width, height;
  /* The clockwise turn that makes the stored image upright: 0, 90, 180, 270, or SANDGLASS_TURN_FROM_POSE. */
  uint32_t turn_deg;
  /* As many as the format has. */
  const uint8_t* planes[3];
  /* Bytes from row to row of each plane, at least the bytes of a row. */
  uint32_t strides[3];
  /* Pixels of the stored image, 1..1e6. */
  float focal_x, focal_y;
  /* The principal point, pixels; the centre of the first pixel is (0, 0). */
  float centre_x, centre_y;
  /* Camera to world, (x, y, z, w) of any length above 0. */
  float orientation[4];
  /* 1: `orientation` is that of the upright image. 0: that of the stored one. */
  uint32_t pose_is_upright;
  /* When it was taken, by any clock that grows: the time of the filter. */
  uint64_t timestamp_ns;
  /* Where the camera was, world, metres. Only room.h reads it. */
  float position[3];
  /* How long and how sensitively the image was exposed, at least 0: seconds times ISO / 100, or any other number that
   * is proportional to it. ARCore: SENSOR_EXPOSURE_TIME * 1e-9 * SENSOR_SENSITIVITY / 100. ARKit: exposureDuration
   * times the ISO of the frame's EXIF data / 100. 0: unknown. Only room.h reads it. */
  float exposure;
} sandglass_camera_image;

/* Fills *image with the defaults: RGB, no planes, turn 0, no rotation, BT.601 over 0..255, at the origin, exposure
 * unknown. */
SANDGLASS_API void sandglass_camera_image_default(sandglass_camera_image* image);

/* The focal length, in pixels, of a camera of which only the field of view across the diagonal is known (2.15). The
 * angle is in degrees, 1..179; 0 is returned for any other. Take ((width - 1) / 2, (height - 1) / 2) as the principal
 * point. */
SANDGLASS_API float sandglass_camera_focal(uint32_t width, uint32_t height, float diagonal_deg);

/* The rotation of a column-major 4 x 4 matrix from camera to world (simd_float4x4, OpenGL), as (x, y, z, w). The rest
 * of the matrix is not read. Returns 1. For a matrix that is not a rotation, to 0.001, it gives the identity and
 * returns 0. */
SANDGLASS_API int32_t sandglass_camera_orientation(const float matrix[16], float orientation[4]);

/* Whether the library can use an image. Fails with INVALID_ARGUMENT, and says which of these it is: an unknown format
 * or range, a side that is too short or too long, an odd side in YUV, a missing plane, a stride shorter than its row,
 * an unknown turn, intrinsics or a pose that are not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_camera_check(const sandglass_camera_image* image,
                                                                          const char** reason);

/* ------------------------------------------------------------------------------------------------ light */

/* What computes the network. All back ends read the same file, in work units that are equally small.
 *
 * OWN (the default): the project's own kernels. By `sandglass_lab bench lighting` on x86 with AVX-512 they are three times
 * faster than XNNPACK of 2022 in bytes, with the same results to the bit, and five times faster than XNNPACK in float.
 *
 * XNNPACK_F32 and XNNPACK_INT8: Google's kernels, in float and in bytes, in builds configured with
 * SANDGLASS_XNNPACK=ON. They give up three promises:
 *   - Results differ in the last digits between CPUs, so frames do not replay to the bit.
 *   - Such a light must be given back by sandglass_light_release.
 *   - Beside the block they draw on a region of the process. It has SANDGLASS_XNNPACK_REGION_MIB MiB (a CMake variable,
 *     64) and holds two lights in float (27 MiB each), or eight in bytes. Nothing is allocated from the heap, and
 *     nothing at all while frames run.
 * xnn_initialize keeps the allocator of its first caller in the process. So an app that calls it too must create its
 * light before. Create and release such lights on one thread at a time.
 *
 * A file holds the network in bytes, and may hold it in float too (`models/lighting/quantise.py --keep-float`, 30 MB more;
 * the shipped file does not). Only XNNPACK_F32 reads the float network, and is then within 1e-3 of it. Without it,
 * XNNPACK_F32 computes with the weights that the bytes stand for and rounds nothing in between. That is as far from the
 * network as it was trained as the rounding of the weights is. */
typedef int32_t sandglass_light_backend;
enum {
  SANDGLASS_LIGHT_BACKEND_OWN = 0,
  SANDGLASS_LIGHT_BACKEND_XNNPACK_F32 = 1,
  SANDGLASS_LIGHT_BACKEND_XNNPACK_INT8 = 2
};

/* How a light is made, and its filter over time.
 *
 * The filter takes an estimate m of the image at time t into the state d. The image before it was taken at time t', and
 * n estimates were taken in before. t - t' counts as within 0..1 s.
 *   a        = max((t - t') / (smoothing + t - t'), 1 / (n + 1))
 *   d        turns towards m along the great circle, by a times the angle between them, at most turn_limit * (t - t')
 *   others   the colours and the contrast move by a times their difference
 *   rejected an estimate that is more than outlier_angle from d, or differs in luminance by more than outlier_level, is
 *            an outlier and changes nothing. It is taken in all the same if it agrees with the estimate before it,
 *            which was rejected too, or if three in a row were rejected.
 * The turn of the camera is taken out before: estimates are filtered in the world's frame. Times that do not grow from
 * image to image count as `interval` apart.
 *
 * Step response with the defaults and four estimates a second, for a light that jumps by 90 degrees: the first estimate
 * after the jump changes nothing, none moves the light by more than 30 degrees, it is half way with the third estimate
 * and 90 % of the way with the sixth (1.25 s after the first), and it never goes too far. A light that moves slowly is
 * followed `smoothing` seconds behind. */
typedef struct sandglass_light_desc {
  uint32_t struct_size;
  /* Which kernels to use. Default: AUTOMATIC. */
  sandglass_isa isa;
  /* The file of a network, aligned to 8 bytes. It must stay unchanged as long as the light is used. */
  const void* asset;
  /* The size of the file. */
  uint64_t asset_bytes;
  /* Seconds, 0..60: an image taken less than this after the last one that was used is passed over, to save energy.
   * Default: 0.25. */
  float interval;
  /* Seconds, 0..60. With 0 every estimate is taken whole, and none is rejected. Default: 0.4. */
  float smoothing;
  /* Radians a second, above 0, at most 1e6; only with smoothing. Default: 2.0944 (120 degrees). */
  float turn_limit;
  /* Radians, 0..pi. With pi no direction is rejected. Default: 0.6981 (40 degrees). */
  float outlier_angle;
  /* Of luminance, 0..2. With 2 no brightness is rejected. Default: 0.35. */
  float outlier_level;
  /* Default: the project's own kernels. */
  sandglass_light_backend backend;
} sandglass_light_desc;

/* Fills *desc with the defaults, and no file. */
SANDGLASS_API void sandglass_light_desc_default(sandglass_light_desc* desc);

/* What the file of a network says of itself. */
typedef struct sandglass_light_info {
  uint32_t struct_size;
  /* Images that the network was trained with. */
  uint32_t training_images;
  /* Images that the rounding to bytes was calibrated with. */
  uint32_t calibration_images;
  /* The median angle, degrees, between the directions in bytes and in float, on other images. */
  float angle_deg;
  /* The median of the greatest difference of colours and contrast between bytes and float, on those images. */
  float difference;
  /* Of the manifests of the training set. */
  uint64_t data_hash;
  /* Of the training. */
  uint64_t seed;
} sandglass_light_info;

/* Reads what a file says of itself, after all checks of sandglass_light_create. Set info->struct_size before. Fails
 * with INVALID_ARGUMENT: no lighting network, a damaged one, one that is cut off, or one of another version. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_inspect(const void* asset, uint64_t asset_bytes,
                                                                           sandglass_light_info* info,
                                                                           const char** reason);

/* The light of a room. */
typedef struct sandglass_light_estimate {
  uint32_t struct_size;
  /* 0: no estimate was completed yet. Then the light comes from above, is grey, and has contrast 0. */
  uint32_t valid;
  /* Of the image that the estimate last changed with. It changes only when the estimate changes. */
  uint64_t timestamp_ns;
  /* Of the last image that was estimated, also when that estimate was rejected. */
  uint64_t image_ns;
  /* World, unit vector towards the light. */
  float direction[3];
  /* The colour c of the directional light, linear RGB, 0..1. */
  float light[3];
  /* 0..64: the directional light gives a surface that faces it the irradiance pi * strength * c; see the top. */
  float strength;
  /* The radiance a from everywhere, linear RGB, 0..1. */
  float ambient[3];
  /* The contrast o, 0..1: the share of the directional light in what the floor receives. It is the opacity of an umbra
   * (where the light is fully hidden) on the floor (6.18): shadow = coverage * contrast (shadow.h). */
  float contrast;
  /* 0..1: how far the estimates m agreed lately. It is the smoothed mean of max(0, m . d), times n / (n + 1) for the n
   * estimates so far. Below 0.5, prefer a light from above. */
  float confidence;
  /* Estimates that were completed so far, the rejected ones included. */
  uint32_t estimates;
  /* Radians from the last estimate as the network gave it to `direction`. */
  float deviation;
  /* Estimates that were rejected as outliers, of `estimates`. */
  uint32_t rejected;
  /* Radiance as real spherical harmonics, of SANDGLASS_LIGHT_MODEL_WHOLE; see sandglass_light_model. */
  float sh[27];
} sandglass_light_estimate;

/* The exact number of bytes that sandglass_light_create needs. Fails with INVALID_ARGUMENT: a field out of range, or a
 * file that sandglass_light_inspect refuses; and with UNSUPPORTED (isa, backend). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_bytes(const sandglass_light_desc* desc,
                                                                         uint64_t* bytes, const char** reason);

/* Makes a light in the app's block: checks the whole file, lays the block out and packs the weights for this CPU. It
 * takes some hundredths of a second, and up to 24 KiB of stack. With the project's own kernels there is nothing to
 * destroy.
 *
 * Fails like sandglass_light_bytes, and with MEMORY_TOO_SMALL and MEMORY_ALIGNMENT; nothing was written then. With
 * XNNPACK it fails with UNSUPPORTED too, where its region is full or the app initialised XNNPACK first; the block was
 * written to then, and there is no light. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_create(const sandglass_light_desc* desc, void* block,
                                                                          uint64_t bytes, sandglass_light** light,
                                                                          const char** reason);

/* Gives back what an XNNPACK back end took of its region: call it before the block is freed. The light must not be used
 * afterwards. With the project's own kernels there is nothing to give back. */
SANDGLASS_API void sandglass_light_release(sandglass_light* light);

/* Forgets every estimate, and the image under way: for a new room. */
SANDGLASS_API void sandglass_light_reset(sandglass_light* light);

/* Turns the light with the world's frame, as sandglass_scene_move does: v becomes rotation * v. The rotation is
 * (x, y, z, w), of any length above 0. Fails with INVALID_ARGUMENT: it is not finite or has no length. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_turn(sandglass_light* light, const float rotation[4],
                                                                        const char** reason);

/* Without a scene: takes an image and resamples all of it, if the estimate before is complete and `interval` has
 * passed; else it does nothing. *taken, which is optional, is 1 or 0 accordingly. What it costs stands at the top.
 * Fails like sandglass_camera_check. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_set_image(sandglass_light* light,
                                                                             const sandglass_camera_image* image,
                                                                             int32_t* taken, const char** reason);

/* Runs at most `units` work units, of some tens of microseconds each; returns how many it ran. Fewer than `units` means
 * that there is no image left to estimate. */
SANDGLASS_API uint32_t sandglass_light_run(sandglass_light* light, uint32_t units);

/* The number of work units until the estimate under way is complete. 0: none is under way. */
SANDGLASS_API uint32_t sandglass_light_units_left(const sandglass_light* light);

/* Gives the estimate after the filter. Set estimate->struct_size before. */
SANDGLASS_API void sandglass_light_get(const sandglass_light* light, sandglass_light_estimate* estimate);

/* Gives the last estimate as the network made it, turned into the world, before the filter. Set estimate->struct_size
 * before. */
SANDGLASS_API void sandglass_light_get_latest(const sandglass_light* light, sandglass_light_estimate* estimate);

/* A 64-bit hash of the filtered estimate and the image under way. It is equal on every instruction set and compiler. */
SANDGLASS_API uint64_t sandglass_light_hash(const sandglass_light* light);

/* The instruction set of the project's own kernels. With an XNNPACK back end these only clamp and average between
 * XNNPACK's operators, which choose theirs by the CPU. */
SANDGLASS_API sandglass_isa sandglass_light_isa(const sandglass_light* light);

/* ------------------------------------------------------------------------------------------------ harmonics */

/* What is in the spherical harmonics.
 *
 * They are 9 coefficients of red, green and blue, interleaved (r0 g0 b0 r1 ...), of radiance in the world's frame.
 * Coefficient l(l+1)+m belongs to
 *   Y00  0.282095          Y1-1 0.488603 y       Y10 0.488603 z              Y11 0.488603 x
 *   Y2-2 1.092548 x y      Y2-1 1.092548 y z     Y20 0.315392 (3 z^2 - 1)    Y21 1.092548 x z
 *   Y22  0.546274 (x^2 - y^2)
 * without the Condon-Shortley phase. ARCore's coefficients have it: theirs of index 1, 3, 5 and 7 are minus these.
 *
 * AMBIENT: the ambient radiance a alone, for use beside a directional light with shadows.
 *
 * WHOLE: ambient and light, for renderers without a directional light. The light is the spherical Gaussian of (5.27),
 * exp(2 pi (cos - 1)), times the factor by which a facing surface receives pi * strength * c, as from the directional
 * light.
 *
 * PICTURE: (5.27) to (5.29) as printed: a Gaussian of height c under which a is screen-blended, the map that the
 * dissertation shows to the eye. As light it is too dim: it gives a facing surface 0.84 c (1 - a) + pi a. */
typedef int32_t sandglass_light_model;
enum { SANDGLASS_LIGHT_MODEL_AMBIENT = 0, SANDGLASS_LIGHT_MODEL_WHOLE = 1, SANDGLASS_LIGHT_MODEL_PICTURE = 2 };

/* Writes the spherical harmonics of an estimate. Fails with INVALID_ARGUMENT: an unknown model, an estimate whose
 * struct_size is not set, or one that is not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_harmonics(const sandglass_light_estimate* estimate,
                                                                             sandglass_light_model model, float sh[27],
                                                                             const char** reason);

/* Writes the spherical harmonics of the light of a room (room.h). WHOLE: all of it, its `sh`. AMBIENT: the same less the
 * main light, which then is drawn as a directional light.
 *
 * That light gives a facing surface the irradiance E = main_share * Y(irradiance) * main_colour / cos(theta), with the
 * luminance Y (5.2) and the angle theta of main_direction from the zenith, cos(theta) at least 0.1. What AMBIENT leaves
 * out of coefficient Y_lm is E * Y_lm(main_direction). So the two together are WHOLE, and nothing is counted twice.
 *
 * Fails with INVALID_ARGUMENT: another model, a light whose struct_size is not set, or one that is not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_harmonics(const struct sandglass_room_light* light,
                                                                            sandglass_light_model model, float sh[27],
                                                                            const char** reason);

/* ------------------------------------------------------------------------------------------------ renderers */

/* An estimate, or the light of a room, in the terms of renderers. Set the struct_size of each struct before its function
 * is called. Light and estimate may be those of an older or a newer header: what the functions need is in every
 * version.
 *
 * Take the model AMBIENT beside the directional light, WHOLE without it. For WHOLE the functions of a room give the
 * directional light the intensity 0, because the harmonics have it already; those of an estimate give it in both. All
 * fail like sandglass_light_harmonics or sandglass_room_harmonics, and with INVALID_ARGUMENT where the struct to fill
 * has no struct_size. */

/* For Filament: a LightManager of type DIRECTIONAL or SUN, and an IndirectLight. */
typedef struct sandglass_light_filament {
  uint32_t struct_size;
  /* LightManager direction: the way the light travels. */
  float direction[3];
  /* Linear sRGB; the greatest channel is 1. */
  float colour[3];
  /* Lux: nits * the irradiance of a facing surface, of its greatest channel: pi * nits * strength * greatest channel of
   * an estimate's light. */
  float intensity;
  /* For IndirectLight::Builder::irradiance(3, sh): pre-convolved, over pi and pre-scaled, so that sh0 + sh1 y + sh2 z +
   * sh3 x + sh4 xy + sh5 yz + sh6 (3z^2 - 1) + sh7 xz + sh8 (x^2 - y^2) is irradiance over pi. */
  float sh[27];
  /* IndirectLight intensity: nits. */
  float sh_intensity;
} sandglass_light_filament;

/* Converts an estimate for Filament. `nits` is the luminance that radiance 1 stands for, in cd/m^2, above 0 and at most
 * 1e9; it is also the intensity of the IndirectLight. Take about 30 for Filament's default indoor exposure. With the
 * camera's exposure e (Camera::setExposure), 1 / e shows radiance 1 as 1. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_to_filament(const sandglass_light_estimate* estimate,
                                                                               sandglass_light_model model, float nits,
                                                                               sandglass_light_filament* filament,
                                                                               const char** reason);

/* Converts the light of a room for Filament. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_to_filament(const struct sandglass_room_light* light,
                                                                              sandglass_light_model model, float nits,
                                                                              sandglass_light_filament* filament,
                                                                              const char** reason);

/* For SceneKit and RealityKit, in the layout of ARDirectionalLightEstimate. 1000 lumens are what ARKit calls neutral,
 * and what SceneKit's lights have by default: they stand for irradiance pi on a facing surface, and for ambient
 * radiance 1. */
typedef struct sandglass_light_arkit {
  uint32_t struct_size;
  /* The way the light travels: -z of an SCNLight's node. */
  float primary_light_direction[3];
  /* Lumens: 1000 * luminance of a white surface that faces the light: 1000 * strength * luminance of an estimate's
   * light. */
  float primary_light_intensity;
  /* (x, y, z, w) of a node whose -z is that direction. */
  float orientation[4];
  /* Lumens: 1000 * luminance of an estimate's ambient; of a room what a level white floor shows, without the
   * directional light. */
  float ambient_intensity;
  /* Kelvin, of the ambient's colour by McCamy's formula, 1000..40000; 6500 is white. */
  float ambient_colour_temperature;
  /* Radiance, not interleaved: nine of red, nine of green, nine of blue. */
  float sh[27];
} sandglass_light_arkit;

/* Converts an estimate for SceneKit and RealityKit. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_to_arkit(const sandglass_light_estimate* estimate,
                                                                            sandglass_light_model model,
                                                                            sandglass_light_arkit* arkit,
                                                                            const char** reason);

/* Converts the light of a room for SceneKit and RealityKit. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_to_arkit(const struct sandglass_room_light* light,
                                                                           sandglass_light_model model,
                                                                           sandglass_light_arkit* arkit,
                                                                           const char** reason);

/* For shaders that were written for ARCore's Environmental HDR. */
typedef struct sandglass_light_arcore {
  uint32_t struct_size;
  /* World, towards the light: environmental HDR main light direction. */
  float main_light_direction[3];
  /* Linear RGB, the irradiance of a facing surface: environmental HDR main light intensity. A white surface shows it
   * over pi. */
  float main_light_intensity[3];
  /* Environmental HDR ambient spherical harmonics: radiance, interleaved, with the Condon-Shortley phase. */
  float sh[27];
} sandglass_light_arcore;

/* Converts the light of a room into what ARCore gives. The model AMBIENT is what ARCore means. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_to_arcore(const struct sandglass_room_light* light,
                                                                            sandglass_light_model model,
                                                                            sandglass_light_arcore* arcore,
                                                                            const char** reason);

/* For Unity, whose world is left-handed: z is reversed, as AR Foundation does with poses. */
typedef struct sandglass_light_unity {
  uint32_t struct_size;
  /* Of the Light's transform: the way the light travels. */
  float forward[3];
  /* The Quaternion (x, y, z, w) of that transform. */
  float rotation[4];
  /* Linear; the greatest channel is 1. Light.color takes gamma: use Color.gamma. */
  float colour[3];
  /* Light.intensity, linear: the greatest channel of a white surface that faces the light, which is strength * greatest
   * channel of an estimate's light. Unity leaves out the 1/pi of diffuse surfaces. */
  float intensity;
  /* For RenderSettings.ambientProbe: SphericalHarmonicsL2[channel, i] = sh[9 * channel + i], irradiance over pi. So sh0
   * + sh1 y + sh2 z + sh3 x + sh4 xy + sh5 yz + sh6 (3z^2 - 1) + sh7 xz + sh8 (x^2 - y^2) is the radiance of a white
   * surface. */
  float sh[27];
} sandglass_light_unity;

/* Converts an estimate for Unity. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_to_unity(const sandglass_light_estimate* estimate,
                                                                            sandglass_light_model model,
                                                                            sandglass_light_unity* unity,
                                                                            const char** reason);

/* Converts the light of a room for Unity. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_room_to_unity(const struct sandglass_room_light* light,
                                                                           sandglass_light_model model,
                                                                           sandglass_light_unity* unity,
                                                                           const char** reason);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_LIGHT_H */
