/* Sandglass light: where the room's light comes from, of what colour it is and how hard its shadows are, from one image
 * of the camera (chapter 5 of the source).
 *
 * An app
 *   1. reads a network's file into memory (aligned to 8 bytes) and fills a sandglass_light_desc,
 *   2. asks sandglass_light_bytes, hands a block of that size to sandglass_light_create,
 *   3. passes light and camera image to sandglass_scene_frame (input.light, input.camera) whenever it has an image,
 *      which gives the network part of the frame's budget; or, without a scene, calls sandglass_light_set_image and
 *      then sandglass_light_run, as many units as fit,
 *   4. reads sandglass_light_get, and converts for its renderer (sandglass_light_to_filament, ..._arkit, ..._unity).
 *
 * An estimate takes several frames; the one before it stays valid until it is complete. The image's planes are read
 * within the call that they are passed to, and never after: what is kept is 256 x 192 pixels. So resampling is a part
 * of its frame that must be done whatever the budget is, and what it costs grows with the image. On an x86 server, as a
 * share of the time of one estimate (7 ms there): 0.13 for 640 x 480 and 0.25 for 1920 x 1440 in NV12, 1.8 for 4032 x
 * 3024 in RGBA, 6 for 16384 x 3072 in RGB; 0.09 to 0.15 a megapixel from two megapixels on. It is cut into work units
 * that read about 256 KiB of the image, below 0.1 ms each at every size. Pass the size that the camera's preview has,
 * not its photographs. Nothing is allocated, no clock is read, and the same bytes come out of every instruction set and
 * every division into frames.
 *
 * Conventions. World frame right-handed, y up, as in types.h; directions are unit vectors *towards* the light.
 * Colours are linear, in the tone-mapped range of the picture: 1 is what the camera shows as white.
 *
 * Radiometry. The source gives none; of the rules that were measured (`sandglass ceiling`, SPEC 3.3) this one lights an
 * object best: the ambient light has the radiance a, and the directional light gives a surface that faces it the
 * irradiance pi * strength * c, so strong that its share of what the level floor receives is the contrast o:
 *   strength = Y(a) / Y(c) * o / (1 - o) / cos(theta),   o at most 0.95, cos(theta) at least 0.1, strength at most 64
 * with luminances Y (5.2) and the light's angle theta from the zenith. A white diffuse surface facing the light then
 * has the radiance a + strength * c, in the camera's tone-mapped range. An app that knows its camera's tone curve does
 * better to light in radiance: both lights times Y(inverse of the curve at a) / Y(a), shadows multiplied onto the
 * camera's image through the inverse, and the curve over all at the end (RMSE 0.0206 in place of 0.0230 over 20 views,
 * `sandglass verify shot`). */
#ifndef SANDGLASS_LIGHT_H
#define SANDGLASS_LIGHT_H

#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ camera image */

/* What the network sees, pixels. */
#define SANDGLASS_LIGHT_WIDTH 256
#define SANDGLASS_LIGHT_HEIGHT 192
/* Longest side of a camera image, pixels. */
#define SANDGLASS_CAMERA_SIDE_LIMIT 16384

/* Byte layouts. RGB and RGBA: one plane, sRGB. NV12, NV21: luma, then pairs of chroma at half resolution (U first in
 * NV12, V first in NV21). I420: luma, U, V. ARCore's YUV_420_888 is NV12, NV21 or I420 by its planes' pixel stride and
 * order; ARKit's capturedImage is NV12. */
typedef int32_t sandglass_camera_format;
enum {
  SANDGLASS_CAMERA_RGB = 0,
  SANDGLASS_CAMERA_RGBA = 1,
  SANDGLASS_CAMERA_NV12 = 2,
  SANDGLASS_CAMERA_NV21 = 3,
  SANDGLASS_CAMERA_I420 = 4
};

/* Luma and chroma to RGB: ITU-R BT.601 or BT.709, luma over 0..255 or over 16..235. Android's cameras give FULL_601;
 * iOS names its matrix in the pixel buffer's attachments. */
typedef int32_t sandglass_yuv_range;
enum {
  SANDGLASS_YUV_FULL_601 = 0,
  SANDGLASS_YUV_VIDEO_601 = 1,
  SANDGLASS_YUV_FULL_709 = 2,
  SANDGLASS_YUV_VIDEO_709 = 3
};

/* `turn_deg` that makes the library choose the quarter turn by which the world's up comes nearest to the image's. Needs
 * a pose of the stored image. */
#define SANDGLASS_TURN_FROM_POSE 0xffffffffu

/* An image of a pinhole camera, in the caller's memory, and where the camera looked.
 *
 * The pose is that of the image *as stored*, unless `pose_is_upright`: x along its rows to the right, y up its columns,
 * looking along -z. ArCamera_getPose and ARCamera.transform are such poses; ArCamera_getDisplayOrientedPose and the
 * transform of Unity's AR camera are those of the upright image. Only the rotation matters: light comes from far. */
typedef struct sandglass_camera_image {
  uint32_t struct_size;
  sandglass_camera_format format;
  sandglass_yuv_range range; /* of NV12, NV21, I420 */
  uint32_t width, height;    /* pixels as stored, 2..SANDGLASS_CAMERA_SIDE_LIMIT; even in YUV */
  uint32_t turn_deg;         /* clockwise turn that makes the stored image upright: 0, 90, 180, 270, or FROM_POSE */
  const uint8_t* planes[3];  /* as many as the format has */
  uint32_t strides[3];       /* bytes from row to row, at least a row's bytes */
  float focal_x, focal_y;    /* pixels of the stored image, 1..1e6 */
  float centre_x, centre_y;  /* principal point, pixels; the centre of the first pixel is (0, 0) */
  float orientation[4];      /* camera to world, (x, y, z, w) of any length above 0 */
  uint32_t pose_is_upright;  /* 1: `orientation` is that of the upright image, not of the stored one */
  uint64_t timestamp_ns;     /* when it was taken, by any clock that grows; the filter's time */
} sandglass_camera_image;

/* No planes; turn 0, no rotation, BT.601 over 0..255. */
SANDGLASS_API void sandglass_camera_image_default(sandglass_camera_image* image);

/* Focal length in pixels of a camera of which only the field of view across the diagonal is known, in degrees: (2.15).
 * 0 when that is not between 1 and 179 degrees. Principal point: (width - 1) / 2, (height - 1) / 2. */
SANDGLASS_API float sandglass_camera_focal(uint32_t width, uint32_t height, float diagonal_deg);

/* The rotation of a column-major 4 x 4 matrix camera to world (simd_float4x4, OpenGL) as (x, y, z, w); the rest of the
 * matrix is not read. A matrix that is no rotation gives the identity and 0, else 1. */
SANDGLASS_API int32_t sandglass_camera_orientation(const float matrix[16], float orientation[4]);

/* Whether the library can use the image. Fails with INVALID_ARGUMENT, and a sentence for: no image, an unknown format
 * or range, a side that is too short or too long, odd YUV, a missing plane, a stride shorter than its row, a turn that
 * is none, intrinsics or a pose that are not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_camera_check(const sandglass_camera_image* image,
                                                                          const char** reason);

/* ------------------------------------------------------------------------------------------------ light */

/* What computes the network; all read the same file, in units as small. By `sandglass bench lighting` on x86 with
 * AVX-512 the project's own kernels are three times faster than XNNPACK of 2022 in bytes, whose results are the same
 * there to the bit, and five times faster than in float: they are the default.
 *
 * A file holds the network in bytes and may hold it in float too (`sandglass quantise-light --keep-float`, 30 MB more;
 * the shipped file does not). Without it XNNPACK_F32 computes with the weights that the bytes stand for and rounds
 * nothing in between, which is as far from the network as it was trained as their rounding is; with it that network
 * itself, to 1e-3. The others read the bytes of either file.
 *
 * XNNPACK_F32 and XNNPACK_INT8 are Google's kernels, in float and in bytes, in builds configured with
 * SANDGLASS_XNNPACK=ON. They give up three promises of this header: their results differ in the last digits between
 * CPUs, so that frames do not replay to the bit; a light of theirs must be given back by sandglass_light_release; and
 * beside the block they draw on a region of the process, of SANDGLASS_XNNPACK_REGION_MIB (a CMake variable, 64) MiB,
 * that holds two lights in float (27 MiB each), or eight in bytes. Nothing is allocated from the heap, and nothing
 * at all while frames run. xnn_initialize keeps the allocator of its first caller in the process: an app that calls it,
 * too, must create its light before. Create and release such lights on one thread at a time. */
typedef int32_t sandglass_light_backend;
enum {
  SANDGLASS_LIGHT_BACKEND_OWN = 0,
  SANDGLASS_LIGHT_BACKEND_XNNPACK_F32 = 1,
  SANDGLASS_LIGHT_BACKEND_XNNPACK_INT8 = 2
};

/* The temporal filter. An estimate m of the image at time t, after one at time t' that left the state d:
 *   a     = max((t - t') / (smoothing + t - t'), 1 / (n + 1)), n estimates taken in before; t - t' within 0..1 s
 *   d     turns towards m along the great circle by a times the angle between them, at most turn_limit * (t - t')
 *   other numbers move by a times their difference
 *   rejected: an estimate that is more than outlier_angle from d, or differs in luminance by more than outlier_level,
 *         changes nothing, unless it agrees with the one before it, which was rejected too, or three were in a row.
 * Step response with the defaults and four estimates a second, for light that jumps by 90 degrees: the first estimate
 * after it changes nothing, none moves it by more than 30 degrees, it is half way with the third and 90 % of the way
 * with the sixth (1.25 s after the first), and never goes too far. A light that moves slowly is followed `smoothing`
 * seconds behind. The camera's turn is taken out before: estimates are filtered in the world's frame.
 * Times that do not grow from image to image count as `interval` apart. */
typedef struct sandglass_light_desc {
  uint32_t struct_size;
  sandglass_isa isa;
  const void* asset; /* a network's file, aligned to 8 bytes; it must stay, unchanged, as long as the light is used */
  uint64_t asset_bytes;
  float interval;      /* seconds, 0..60: an image taken less than this after the last one used is passed over; default
                        * 0.25. Saves energy */
  float smoothing;     /* seconds, 0..60; default 0.4; 0: every estimate is taken whole, and none is rejected */
  float turn_limit;    /* radians a second, above 0; default 2.0944 (120 degrees); only with smoothing */
  float outlier_angle; /* radians, 0..pi; default 0.6981 (40 degrees); pi: none is rejected for its direction */
  float outlier_level; /* of luminance, 0..2; default 0.35; 2: none is rejected for its brightness */
  sandglass_light_backend backend; /* default: the project's own kernels */
} sandglass_light_desc;

SANDGLASS_API void sandglass_light_desc_default(sandglass_light_desc* desc);

/* What a network's file says of itself. */
typedef struct sandglass_light_info {
  uint32_t struct_size;
  uint32_t training_images;
  uint32_t calibration_images; /* for the rounding to bytes */
  float angle_deg;             /* on other images: median angle between its directions in bytes and in float */
  float difference;            /* and median of the greatest difference of colours and contrast */
  uint64_t data_hash;          /* of the training set's manifests */
  uint64_t seed;
} sandglass_light_info;

/* Reads the file's description after the checks of sandglass_light_create; info.struct_size is set before (see "Sizes"
 * in types.h). Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_inspect(const void* asset, uint64_t asset_bytes,
                                                                           sandglass_light_info* info,
                                                                           const char** reason);

/* The light of a room. */
typedef struct sandglass_light_estimate {
  uint32_t struct_size;
  uint32_t valid;        /* 0: no estimate was completed yet; then the light comes from above, grey, contrast 0 */
  uint64_t timestamp_ns; /* of the image that it last changed with; changes only when the estimate changes */
  uint64_t image_ns;     /* of the last image that was estimated, also when that was rejected */
  float direction[3];    /* world, unit vector towards the light */
  float light[3];        /* colour c of the directional light, linear RGB, 0..1 */
  float strength;        /* 0..64: that light gives a surface facing it the irradiance pi * strength * c; see above */
  float ambient[3];      /* radiance a from everywhere, linear RGB, 0..1 */
  float contrast;     /* o, 0..1: share of the directional light in what the floor receives; opacity of an umbra on it
                       * (6.18): shadow = coverage * contrast (shadow.h) */
  float confidence;   /* 0..1: how far the estimates agreed lately, m the estimates: the smoothed mean of max(0, m . d),
                       * times n / (n + 1) of the n estimates so far. Below 0.5: prefer a light from above */
  uint32_t estimates; /* completed so far, rejected ones included */
  float deviation;    /* radians from the last estimate as the network gave it to `direction` */
  uint32_t rejected;  /* of `estimates`: rejected as outliers, see sandglass_light_desc */
  float sh[27];       /* radiance, real spherical harmonics L_lm of SANDGLASS_LIGHT_MODEL_WHOLE; see below */
} sandglass_light_estimate;

/* The exact number of bytes that sandglass_light_create needs. Fails with INVALID_ARGUMENT (a field out of range; a
 * file that is no lighting network, damaged, cut off, or of another version) and UNSUPPORTED (isa, backend). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_bytes(const sandglass_light_desc* desc,
                                                                         uint64_t* bytes, const char** reason);

/* Checks the whole file, lays out the block and packs the weights for this CPU: some hundredths of a second, and up to
 * 24 KiB of stack. With the project's own kernels there is nothing to destroy. Fails as sandglass_light_bytes, and with
 * MEMORY_TOO_SMALL and MEMORY_ALIGNMENT; nothing is touched then. With XNNPACK, fails with UNSUPPORTED too where its
 * region is full or the app initialised XNNPACK first; the block was written to then, and there is no light. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_create(const sandglass_light_desc* desc, void* block,
                                                                          uint64_t bytes, sandglass_light** light,
                                                                          const char** reason);

/* Before the block is freed: gives back what an XNNPACK back end took of its region. With the project's own kernels
 * there is nothing to give back. The light must not be used afterwards. NULL: nothing. */
SANDGLASS_API void sandglass_light_release(sandglass_light* light);

/* Forgets every estimate, and the image under way: for a new room. */
SANDGLASS_API void sandglass_light_reset(sandglass_light* light);

/* The world's frame has turned (sandglass_scene_move): v becomes rotation * v, (x, y, z, w) of any length above 0.
 * Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_turn(sandglass_light* light, const float rotation[4],
                                                                        const char** reason);

/* Without a scene: resamples the image, all of it, if the estimate before is complete and `interval` has passed; else
 * does nothing. *taken (may be NULL) says which. What it costs stands at the top. Fails as sandglass_camera_check. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_set_image(sandglass_light* light,
                                                                             const sandglass_camera_image* image,
                                                                             uint32_t* taken, const char** reason);

/* Runs at most `units` work units, of some tens of microseconds each; returns how many it ran. Fewer than `units`:
 * there is no image left to estimate. */
SANDGLASS_API uint32_t sandglass_light_run(sandglass_light* light, uint32_t units);

/* Work units until the estimate under way is complete; 0: none is. */
SANDGLASS_API uint32_t sandglass_light_units_left(const sandglass_light* light);

/* The estimate after the filter; estimate.struct_size is set before, here and below (see "Sizes" in types.h). */
SANDGLASS_API void sandglass_light_get(const sandglass_light* light, sandglass_light_estimate* estimate);

/* The last estimate as the network gave it, turned into the world, before the filter. */
SANDGLASS_API void sandglass_light_get_latest(const sandglass_light* light, sandglass_light_estimate* estimate);

/* A 64-bit hash of the filtered estimate and the image under way: equal on every instruction set and compiler. */
SANDGLASS_API uint64_t sandglass_light_hash(const sandglass_light* light);

/* The instruction set of the project's own kernels, which with SANDGLASS_LIGHT_BACKEND_XNNPACK_* only clamp and average
 * between XNNPACK's operators: those choose theirs by the CPU. */
SANDGLASS_API sandglass_isa sandglass_light_isa(const sandglass_light* light);

/* ------------------------------------------------------------------------------------------------ harmonics */

/* 9 coefficients of red, green and blue, interleaved (r0 g0 b0 r1 ...), of radiance in the world's frame; coefficient
 * l(l+1)+m belongs to
 *   Y00  0.282095          Y1-1 0.488603 y       Y10 0.488603 z              Y11 0.488603 x
 *   Y2-2 1.092548 x y      Y2-1 1.092548 y z     Y20 0.315392 (3 z^2 - 1)    Y21 1.092548 x z
 *   Y22  0.546274 (x^2 - y^2)
 * without the Condon-Shortley phase, which ARCore's coefficients have: theirs of index 1, 3, 5 and 7 are minus these.
 *
 * What is in them:
 * AMBIENT  the ambient radiance a alone: beside a directional light with shadows.
 * WHOLE    ambient and light, for renderers without a directional light. The light is the spherical Gaussian of
 *          (5.27), exp(2 pi (cos - 1)), times the factor by which a facing surface receives pi * strength * c, as from
 *          the directional light.
 * PICTURE  (5.27 - 5.29) as printed: a Gaussian of height c under which a is screen-blended, the map that the source
 *          shows to the eye. As light it is too dim: it gives a facing surface 0.84 c (1 - a) + pi a. */
typedef int32_t sandglass_light_model;
enum { SANDGLASS_LIGHT_MODEL_AMBIENT = 0, SANDGLASS_LIGHT_MODEL_WHOLE = 1, SANDGLASS_LIGHT_MODEL_PICTURE = 2 };

/* Fails with INVALID_ARGUMENT: NULL, or a model that is none. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_harmonics(const sandglass_light_estimate* estimate,
                                                                             sandglass_light_model model, float sh[27],
                                                                             const char** reason);

/* ------------------------------------------------------------------------------------------------ renderers */

/* Each struct's struct_size is set before its function is called (see "Sizes" in types.h). The estimate may be that
 * of an older or a newer header: what the functions need of it is in every version. */

/* For Filament: a LightManager of type DIRECTIONAL or SUN, and an IndirectLight. `nits`: the luminance that radiance 1
 * stands for, in cd/m^2 and above 0; it is the IndirectLight's intensity. Around 30 for Filament's default indoor
 * exposure; with the camera's exposure e (Camera::setExposure), 1 / e shows radiance 1 as 1. */
typedef struct sandglass_light_filament {
  uint32_t struct_size;
  float direction[3]; /* LightManager direction: the way the light travels */
  float colour[3];    /* linear sRGB, greatest channel 1 */
  float intensity;    /* lux: pi * nits * strength * greatest channel of light */
  float sh[27];       /* IndirectLight::Builder::irradiance(3, sh): pre-convolved, over pi, pre-scaled, so that
                       * sh0 + sh1 y + sh2 z + sh3 x + sh4 xy + sh5 yz + sh6 (3z^2 - 1) + sh7 xz + sh8 (x^2 - y^2) is
                       * irradiance over pi; of the model that was asked for */
  float sh_intensity; /* IndirectLight intensity: nits */
} sandglass_light_filament;

/* `model` AMBIENT beside the directional light, WHOLE without it. Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_to_filament(const sandglass_light_estimate* estimate,
                                                                               sandglass_light_model model, float nits,
                                                                               sandglass_light_filament* filament,
                                                                               const char** reason);

/* For SceneKit and RealityKit, in the layout of ARDirectionalLightEstimate. 1000 lumens are what ARKit calls neutral
 * and SceneKit's lights have by default: they stand for irradiance pi on a facing surface and for ambient radiance 1.
 */
typedef struct sandglass_light_arkit {
  uint32_t struct_size;
  float primary_light_direction[3]; /* the way the light travels: -z of an SCNLight's node */
  float primary_light_intensity;    /* lumens: 1000 * strength * luminance of light */
  float orientation[4];             /* (x, y, z, w) of a node whose -z is that direction */
  float ambient_intensity;          /* lumens: 1000 * luminance of ambient */
  float
      ambient_colour_temperature; /* kelvin, of the ambient's colour by McCamy's formula, 1000..40000; 6500 is white */
  float
      sh[27]; /* radiance, not interleaved: nine of red, nine of green, nine of blue; of the model that was asked for */
} sandglass_light_arkit;

/* Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_to_arkit(const sandglass_light_estimate* estimate,
                                                                            sandglass_light_model model,
                                                                            sandglass_light_arkit* arkit,
                                                                            const char** reason);

/* For Unity, whose world is left-handed: z is turned over, as AR Foundation does with poses. */
typedef struct sandglass_light_unity {
  uint32_t struct_size;
  float forward[3];  /* of the Light's transform: the way the light travels */
  float rotation[4]; /* Quaternion (x, y, z, w) of that transform */
  float colour[3];   /* linear, greatest channel 1 (Light.color takes gamma: use Color.gamma) */
  float intensity;   /* Light.intensity, linear: strength * greatest channel of light; Unity leaves the 1/pi of diffuse
                        surfaces out */
  float sh[27];      /* SphericalHarmonicsL2[channel, i] = sh[9 * channel + i]: irradiance over pi, so that
                      * sh0 + sh1 y + sh2 z + sh3 x + sh4 xy + sh5 yz + sh6 (3z^2 - 1) + sh7 xz + sh8 (x^2 - y^2) is the
                      * radiance of a white surface; for RenderSettings.ambientProbe */
} sandglass_light_unity;

/* Fails with INVALID_ARGUMENT. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_to_unity(const sandglass_light_estimate* estimate,
                                                                            sandglass_light_model model,
                                                                            sandglass_light_unity* unity,
                                                                            const char** reason);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_LIGHT_H */
