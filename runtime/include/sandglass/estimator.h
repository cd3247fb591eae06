/* Sandglass estimate: where the light of a room comes from, of what colour it is, and how hard its shadows are, from one
 * image of the camera (chapter 5).
 *
 * An app
 *   1. reads a network's file into memory (aligned to 8 bytes) and fills a sandglass_estimator_desc,
 *   2. asks sandglass_estimator_bytes, and hands a block of that size to sandglass_estimator_create,
 *   3. passes estimator and camera image to sandglass_scene_frame (input.estimator, input.camera) whenever it has an
 *      image, which gives the network part of the frame's budget; or, without a scene, calls
 *      sandglass_estimator_set_image and then sandglass_estimator_run, with as many units as fit,
 *   4. reads sandglass_estimator_get, and converts it for its renderer (renderers.h).
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
 * Radiometry. The dissertation gives none. Here the ambient light has the radiance a. The directional light gives a
 * surface that faces it the irradiance pi * strength * c. The strength is such that its share of what the level floor
 * receives is the contrast o:
 *   strength = Y(a) / Y(c) * o / (1 - o) / cos(theta),   o at most 0.95, cos(theta) at least 0.1, strength at most 64
 * with luminances Y (5.2) and the angle theta of the light from the zenith. A white diffuse surface that faces the
 * light then has the radiance a + strength * c, in the camera's tone-mapped range.
 *
 * An app that knows the tone curve of its camera does better to light in radiance. It multiplies both lights by
 * Y(inverse of the curve at a) / Y(a), multiplies shadows onto the camera's image through the inverse, and applies the
 * curve over all at the end.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_ESTIMATOR_H
#define SANDGLASS_ESTIMATOR_H

#include "sandglass/camera.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The light of the room as a network estimates it from one image, in a block of the app. */
typedef struct sandglass_estimator sandglass_estimator;

/* The width of what the network sees, pixels. */
#define SANDGLASS_ESTIMATOR_WIDTH 256
/* The height of what the network sees, pixels. */
#define SANDGLASS_ESTIMATOR_HEIGHT 192

/* What computes the network. All back ends read the same file, in work units that are equally small.
 *
 * OWN (the default): the project's own kernels. By `sandglass_lab bench lighting` on x86 with AVX-512 they are three times
 * faster than XNNPACK of 2022 in bytes, with the same results to the bit, and five times faster than XNNPACK in float.
 *
 * XNNPACK_F32 and XNNPACK_INT8: Google's kernels, in float and in bytes, in builds configured with
 * SANDGLASS_XNNPACK=ON. They give up three promises:
 *   - Results differ in the last digits between CPUs, so frames do not replay to the bit.
 *   - Such an estimator must be given back by sandglass_estimator_release.
 *   - Beside the block they draw on a region of the process. It has SANDGLASS_XNNPACK_REGION_MIB MiB (a CMake variable,
 *     64) and holds two estimators in float (27 MiB each), or eight in bytes. Nothing is allocated from the heap, and
 *     nothing at all while frames run.
 * xnn_initialize keeps the allocator of its first caller in the process. So an app that calls it too must create its
 * estimator before. Create and release such estimators on one thread at a time.
 *
 * A file holds the network in bytes, and may hold it in float too (`models/lighting/quantise.py --keep-float`, 30 MB more;
 * the shipped file does not). Only XNNPACK_F32 reads the float network, and is then within 1e-3 of it. Without it,
 * XNNPACK_F32 computes with the weights that the bytes stand for and rounds nothing in between. That is as far from the
 * network as it was trained as the rounding of the weights is. */
typedef int32_t sandglass_estimator_backend;
enum {
  SANDGLASS_ESTIMATOR_BACKEND_OWN = 0,
  SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32 = 1,
  SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_INT8 = 2
};

/* How an estimator is made, and its filter over time.
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
typedef struct sandglass_estimator_desc {
  uint32_t struct_size;
  /* Which kernels to use. Default: AUTOMATIC. */
  sandglass_isa isa;
  /* The file of a network, aligned to 8 bytes. It must stay unchanged as long as the estimator is used. */
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
  sandglass_estimator_backend backend;
} sandglass_estimator_desc;

/* Fills *desc with the defaults, and no file. */
SANDGLASS_API void sandglass_estimator_desc_default(sandglass_estimator_desc* desc);

/* What the file of a network says of itself. */
typedef struct sandglass_estimator_info {
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
} sandglass_estimator_info;

/* Reads what a file says of itself, after all checks of sandglass_estimator_create. Set info->struct_size before. Fails
 * with INVALID_ARGUMENT: no lighting network, a damaged one, one that is cut off, or one of another version. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_estimator_inspect(const void* asset, uint64_t asset_bytes,
                                                                               sandglass_estimator_info* info,
                                                                               const char** reason);

/* The light of a room. */
typedef struct sandglass_estimator_light {
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
  /* The radiance of ambient and light together as real spherical harmonics: 9 coefficients of red, green and blue,
   * interleaved (r0 g0 b0 r1 ...), in the world's frame. Coefficient l(l+1)+m belongs to
   *   Y00  0.282095          Y1-1 0.488603 y       Y10 0.488603 z              Y11 0.488603 x
   *   Y2-2 1.092548 x y      Y2-1 1.092548 y z     Y20 0.315392 (3 z^2 - 1)    Y21 1.092548 x z
   *   Y22  0.546274 (x^2 - y^2)
   * without the Condon-Shortley phase. The light is the spherical Gaussian of (5.27), exp(2 pi (cos - 1)), times the
   * factor by which a facing surface receives pi * strength * c, as from the directional light. */
  float sh[27];
} sandglass_estimator_light;

/* The exact number of bytes that sandglass_estimator_create needs. Fails with INVALID_ARGUMENT: a field out of range, or a
 * file that sandglass_estimator_inspect refuses; and with UNSUPPORTED (isa, backend). */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_estimator_bytes(const sandglass_estimator_desc* desc,
                                                                             uint64_t* bytes, const char** reason);

/* Makes an estimator in the app's block: checks the whole file, lays the block out and packs the weights for this CPU. It
 * takes some hundredths of a second, and up to 24 KiB of stack. With the project's own kernels there is nothing to
 * destroy.
 *
 * Fails like sandglass_estimator_bytes, and with MEMORY_TOO_SMALL and MEMORY_ALIGNMENT; nothing was written then. With
 * XNNPACK it fails with UNSUPPORTED too, where its region is full or the app initialised XNNPACK first; the block was
 * written to then, and there is no estimator. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_estimator_create(const sandglass_estimator_desc* desc,
                                                                              void* block, uint64_t bytes,
                                                                              sandglass_estimator** estimator,
                                                                              const char** reason);

/* Gives back what an XNNPACK back end took of its region: call it before the block is freed. The estimator must not be used
 * afterwards. With the project's own kernels there is nothing to give back. */
SANDGLASS_API void sandglass_estimator_release(sandglass_estimator* estimator);

/* Forgets every estimate, and the image under way: for a new room. */
SANDGLASS_API void sandglass_estimator_reset(sandglass_estimator* estimator);

/* Turns the estimates with the world's frame, as sandglass_scene_move does: v becomes rotation * v. The rotation is
 * (x, y, z, w), of any length above 0. Fails with INVALID_ARGUMENT: it is not finite or has no length. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_estimator_turn(sandglass_estimator* estimator,
                                                                            const float rotation[4],
                                                                            const char** reason);

/* Without a scene: takes an image and resamples all of it, if the estimate before is complete and `interval` has
 * passed; else it does nothing. *taken, which is optional, is 1 or 0 accordingly. What it costs stands at the top.
 * Fails like sandglass_camera_check. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_estimator_set_image(sandglass_estimator* estimator,
                                                                                 const sandglass_camera_image* image,
                                                                                 int32_t* taken, const char** reason);

/* Runs at most `units` work units, of some tens of microseconds each; returns how many it ran. Fewer than `units` means
 * that there is no image left to estimate. */
SANDGLASS_API uint32_t sandglass_estimator_run(sandglass_estimator* estimator, uint32_t units);

/* The number of work units until the estimate under way is complete. 0: none is under way. */
SANDGLASS_API uint32_t sandglass_estimator_units_left(const sandglass_estimator* estimator);

/* Gives the estimate after the filter. Set estimate->struct_size before. */
SANDGLASS_API void sandglass_estimator_get(const sandglass_estimator* estimator, sandglass_estimator_light* estimate);

/* Gives the last estimate as the network made it, turned into the world, before the filter. Set estimate->struct_size
 * before. */
SANDGLASS_API void sandglass_estimator_get_latest(const sandglass_estimator* estimator,
                                                  sandglass_estimator_light* estimate);

/* A 64-bit hash of the filtered estimate and the image under way. It is equal on every instruction set and compiler. */
SANDGLASS_API uint64_t sandglass_estimator_hash(const sandglass_estimator* estimator);

/* The instruction set of the project's own kernels. With an XNNPACK back end these only clamp and average between
 * XNNPACK's operators, which choose theirs by the CPU. */
SANDGLASS_API sandglass_isa sandglass_estimator_isa(const sandglass_estimator* estimator);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_ESTIMATOR_H */
