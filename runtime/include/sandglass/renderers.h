/* Sandglass renderers: an estimate (estimator.h), or the light of a room (room.h), in the terms of a renderer.
 *
 * An app
 *   1. makes a sandglass_light of one (sandglass_light_of_estimator, _of_room, _of_harmonics),
 *   2. where a thing must keep its own colours, adapts it (sandglass_light_adapt),
 *   3. converts it for its renderer (sandglass_light_to_filament, _arkit, _arcore, _unity).
 *
 * Set the struct_size of each struct before its function is called. What is converted may be of an older or a newer
 * header: what the functions need is in every version.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_RENDERERS_H
#define SANDGLASS_RENDERERS_H

#include "sandglass/estimator.h"
#include "sandglass/room.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ light */

/* Light as one directional light and the rest. All of it is linear RGB in the world's frame. */
typedef struct sandglass_light {
  uint32_t struct_size;
  /* Unit vector towards the directional light. */
  float towards[3];
  /* The irradiance that the directional light gives a surface that faces it. */
  float facing[3];
  /* The irradiance of a level floor by everything, the directional light included. A white floor shows floor / pi. */
  float floor[3];
  /* Radiance without the directional light as real spherical harmonics, laid out like sandglass_estimator_light.sh. */
  float ambient_sh[27];
  /* The same of everything. */
  float whole_sh[27];
} sandglass_light;

/* The light of an estimate: facing is pi * strength * c, ambient_sh the ambient radiance a alone, whole_sh its `sh`.
 * Fails with INVALID_ARGUMENT: a struct_size that is not set, or an estimate that is not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status
sandglass_light_of_estimator(const sandglass_estimator_light* estimate, sandglass_light* light, const char** reason);

/* The light of a room: whole_sh is its `sh`, floor its `irradiance`. The directional light is its main light, with
 * facing = main_share * Y(irradiance) * main_colour / cos(theta), the luminance Y (5.2) and the angle theta of
 * main_direction from the zenith, cos(theta) at least 0.1. What ambient_sh leaves out of coefficient Y_lm is
 * facing * Y_lm(main_direction). So the two together are whole_sh, and nothing is counted twice.
 *
 * Fails with INVALID_ARGUMENT: a struct_size that is not set, or a light that is not finite. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_of_room(const sandglass_room_light* room_light,
                                                                           sandglass_light* light, const char** reason);

/* The light that ARCore, WebXR or OpenXR estimates, without a room: facing is main_irradiance, 0 of TOTAL; whole_sh has
 * facing * Y_lm(main_direction) besides; the harmonics' part of floor is that of Ramamoorthi and Hanrahan 2001 (5). The
 * other fields do not count. Fails with INVALID_ARGUMENT: a struct_size that is not set, a number that is not finite, or
 * AMBIENT whose main_direction is 0. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_of_harmonics(const sandglass_harmonics* harmonics,
                                                                                sandglass_light* light,
                                                                                const char** reason);

/* For things that must keep their own colours, such as a product in a shop: *adapted becomes *light in other colours,
 * for each converter below. The two may be the same.
 *
 * `strength`, 0..1: how much of the room's light reaches the thing; the rest is even white light, in which a white
 * surface shows 1. `keep_chroma` 1: the room's light loses its hue, each colour becomes its luminance; 0: it stays.
 * With 1 and 0 nothing changes. Fails with INVALID_ARGUMENT: a light that was not filled or is not finite, an
 * argument out of range, or a struct_size that is not set. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_adapt(const sandglass_light* light, float strength,
                                                                         int32_t keep_chroma, sandglass_light* adapted,
                                                                         const char** reason);

/* How a renderer is to draw a light.
 *
 * AMBIENT: by harmonics and a directional light that casts shadows. The two together are everything.
 *
 * WHOLE: by harmonics alone. They hold everything, so the directional light beside them is 0. */
typedef int32_t sandglass_light_model;
enum { SANDGLASS_LIGHT_AMBIENT = 0, SANDGLASS_LIGHT_WHOLE = 1 };

/* The harmonics of a light, a room or an estimate as an object sees them that is turned by `rotation` (object to
 * world, any length above 0). Both arrays are interleaved (r0 g0 b0 ...), as in sandglass_estimator_light.sh; they may be
 * the same. Fails with INVALID_ARGUMENT: a number that is not finite, or a rotation of length 0. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_harmonics_turn(const float sh[27], const float rotation[4],
                                                                            float turned[27], const char** reason);

/* ------------------------------------------------------------------------------------------------ renderers */

/* All conversions fail with INVALID_ARGUMENT: an unknown model, a struct_size that is not set, or a light that is not
 * finite. */

/* For Filament: a LightManager of type DIRECTIONAL or SUN, and an IndirectLight. */
typedef struct sandglass_filament_light {
  uint32_t struct_size;
  /* LightManager direction: the direction in which the light travels. */
  float direction[3];
  /* Linear sRGB; the greatest channel is 1. */
  float colour[3];
  /* Lux: nits * the greatest channel of the irradiance of a facing surface. */
  float intensity;
  /* For IndirectLight::Builder::irradiance(3, sh): pre-convolved, over pi and pre-scaled, so that sh0 + sh1 y + sh2 z +
   * sh3 x + sh4 xy + sh5 yz + sh6 (3z^2 - 1) + sh7 xz + sh8 (x^2 - y^2) is irradiance over pi. */
  float sh[27];
  /* IndirectLight intensity: nits. */
  float sh_intensity;
} sandglass_filament_light;

/* Converts for Filament. `nits` is the luminance that radiance 1 stands for, in cd/m^2, above 0 and at most 1e9; it is
 * also the intensity of the IndirectLight. Take about 30 for Filament's default indoor exposure. With the camera's
 * exposure e (Camera::setExposure), 1 / e shows radiance 1 as 1. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_to_filament(const sandglass_light* light,
                                                                               sandglass_light_model model, float nits,
                                                                               sandglass_filament_light* filament,
                                                                               const char** reason);

/* For SceneKit and RealityKit, in the layout of ARDirectionalLightEstimate. 1000 lumens are what ARKit calls neutral,
 * and what SceneKit's lights have by default: they stand for irradiance pi on a facing surface, and for ambient
 * radiance 1. */
typedef struct sandglass_arkit_light {
  uint32_t struct_size;
  /* The direction in which the light travels: -z of an SCNLight's node. */
  float primary_light_direction[3];
  /* Lumens: 1000 * luminance of a white surface that faces the light. */
  float primary_light_intensity;
  /* (x, y, z, w) of a node whose -z is that direction. */
  float orientation[4];
  /* Lumens: 1000 * luminance of a level white floor, without the directional light where that is not 0. */
  float ambient_intensity;
  /* Kelvin, of the colour of that floor by McCamy's formula, 1000..40000; 6500 is white. */
  float ambient_colour_temperature;
  /* Radiance, not interleaved: nine of red, nine of green, nine of blue. */
  float sh[27];
} sandglass_arkit_light;

/* Converts for SceneKit and RealityKit. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_to_arkit(const sandglass_light* light,
                                                                            sandglass_light_model model,
                                                                            sandglass_arkit_light* arkit,
                                                                            const char** reason);

/* For shaders that were written for ARCore's Environmental HDR. */
typedef struct sandglass_arcore_light {
  uint32_t struct_size;
  /* World, towards the light: environmental HDR main light direction. */
  float main_light_direction[3];
  /* Linear RGB, the irradiance of a facing surface: environmental HDR main light intensity. A white surface shows it
   * over pi. */
  float main_light_intensity[3];
  /* Environmental HDR ambient spherical harmonics: radiance, interleaved, with the Condon-Shortley phase:
   * those of index 1, 3, 5 and 7 are minus these of a light. */
  float sh[27];
} sandglass_arcore_light;

/* Converts into what ARCore gives. The model AMBIENT is what ARCore means. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_to_arcore(const sandglass_light* light,
                                                                             sandglass_light_model model,
                                                                             sandglass_arcore_light* arcore,
                                                                             const char** reason);

/* For Unity, whose world is left-handed: z is reversed, as AR Foundation does with poses. */
typedef struct sandglass_unity_light {
  uint32_t struct_size;
  /* Of the Light's transform: the direction in which the light travels. */
  float forward[3];
  /* The Quaternion (x, y, z, w) of that transform. */
  float rotation[4];
  /* Linear; the greatest channel is 1. Light.color takes gamma: use Color.gamma. */
  float colour[3];
  /* Light.intensity, linear: the greatest channel of a white surface that faces the light. Unity leaves out the 1/pi of
   * diffuse surfaces. */
  float intensity;
  /* For RenderSettings.ambientProbe: SphericalHarmonicsL2[channel, i] = sh[9 * channel + i], irradiance over pi. So sh0
   * + sh1 y + sh2 z + sh3 x + sh4 xy + sh5 yz + sh6 (3z^2 - 1) + sh7 xz + sh8 (x^2 - y^2) is the radiance of a white
   * surface. */
  float sh[27];
} sandglass_unity_light;

/* Converts for Unity. */
SANDGLASS_API SANDGLASS_NODISCARD sandglass_status sandglass_light_to_unity(const sandglass_light* light,
                                                                            sandglass_light_model model,
                                                                            sandglass_unity_light* unity,
                                                                            const char** reason);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_RENDERERS_H */
