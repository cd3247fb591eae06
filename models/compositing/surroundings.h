// What stands behind a shot: a panorama, of which the camera sees excerpts, or a photograph, which it sees as it is.
// The scene's frame is the panorama's, turned about y so that the scene's camera looks where it should. The camera's
// eye is where the panorama was taken.
#pragma once

#include <cstdint>
#include <string>

#include "models/compositing/shot_camera.h"
#include "models/lighting/labels.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/panorama.h"

namespace sandglass::host {

// Light as an app has it: from one direction and from everywhere, in the scene's frame, linear. `light` gives a surface
// that faces it the irradiance pi * light. `ambient` is radiance.
struct ShotLight {
  Vec3 towards = {0, 1, 0};
  Vec3 light, ambient;
  double contrast = 0.0;
  double concentration = 1.0;  // the share of `light` that one direction stands for; no single shadow removes more
  double confidence = -1.0;    // of an estimate; below 0 if the light is not estimated
};

struct Surroundings {
  RadianceMap panorama;      // empty: a photograph
  RadianceMap warped;        // the panorama from where the object stands, its own centre at `view`
  double white = 1.0;        // luminance of the panorama that is tone mapped to 1
  View view = {};            // towards where the object stands, on the level of the eye
  RadianceMap photo;         // linear, 0..1
  double photo_focal = 0.0;  // pixels
  std::string name;

  bool has_truth() const { return !panorama.rgb.empty(); }
  // What the camera shows in a direction: linear, 0..1, as its tone curve leaves it.
  Vec3 seen(const ShotCamera& camera, Vec3 direction) const;

  // The radiance for what the camera shows, and back, through the camera's tone curve. A photograph's curve is not
  // known: its linear values count as radiance.
  Vec3 radiance(Vec3 shown) const { return has_truth() ? radiance_of(shown, white) : shown; }
  Vec3 shown(Vec3 radiance) const;
};

// The share of each colour of a level floor that an object in the light's way can remove. Over all colours it is the
// contrast. It is greater for colours that come from the light more than from the surroundings:
//   o_k = o c_k / Y(c) / (o c_k / Y(c) + (1 - o) a_k / Y(a))
Vec3 shadow_opacity(const ShotLight& light);

// Surroundings of a panorama. At rest `camera` looks along `azimuth_deg`. The light is that of the place `standing`,
// where the object stands.
Surroundings panorama_surroundings(RadianceMap panorama, const std::string& name, const Camera& camera,
                                   double azimuth_deg, Vec3 standing, double insertion);

// A made-up room. Its panorama is kept in `folder` between runs; if `folder` is empty, it is traced each time.
Surroundings room_surroundings(uint32_t seed, const std::string& folder, uint32_t threads, const Camera& camera,
                               double azimuth_deg, Vec3 standing);

// A photograph with this diagonal field of view. *camera keeps its eye and direction and gets the photograph's field of
// view. Pictures are 4 : 3 and show what fits of a photograph of another shape.
Surroundings photo_surroundings(const std::string& path, double diagonal_fov_deg, Camera* camera);

// The labels of the panorama at the place of the object: what a perfect network would say. The contrast is the label's
// times the highlight's concentration (labels.h): a shadow from one direction removes only the part of the highlight
// that comes from there.
ShotLight labelled_light(const Surroundings& surroundings);

// The light of an app that knows nothing of the room: white, from the upper left behind the camera.
ShotLight arbitrary_light(const ShotCamera& camera);

}  // namespace sandglass::host
