// What stands behind a shot: a panorama of radiance, of which a camera sees excerpts, or a photograph, which it sees as
// it is. The scene's frame is the panorama's own, turned about y so that the scene's camera looks where it should; its
// eye is where the panorama was taken.
#pragma once

#include <cstdint>
#include <string>

#include "models/lighting/excerpt.h"
#include "models/lighting/labels.h"
#include "models/lighting/panorama.h"
#include "models/shot/shot_camera.h"

namespace sandglass::host {

// Light as an app has it: from one direction and from everywhere, in the scene's frame, linear; `light` gives a facing
// surface the irradiance pi * light, `ambient` is radiance (SPEC 3.3).
struct ShotLight {
  Vec3 towards = {0, 1, 0};
  Vec3 light, ambient;
  double contrast = 0.0;
  double confidence = -1.0;  // of an estimate; below 0: it is none
};

struct Surroundings {
  RadianceMap panorama;  // empty: a photograph
  RadianceMap warped;    // the panorama from where the object stands, its own centre at `view`
  double white = 1.0;    // luminance of the panorama that is tone mapped to 1
  View view = {};        // towards where the object stands, on the level of the eye
  RadianceMap photo;     // linear, 0..1
  std::string name;

  bool has_truth() const { return !panorama.rgb.empty(); }
  // What the camera shows in a direction: linear, 0..1, as its tone curve leaves it.
  Vec3 seen(const ShotCamera& camera, Vec3 direction) const;
};

// The panorama of a file. `camera` and `azimuth_deg`: at rest the camera looks there. `standing`: where the object
// stands; the light is that of this place.
Surroundings panorama_surroundings(RadianceMap panorama, const std::string& name, const Camera& camera,
                                   double azimuth_deg, Vec3 standing, double insertion);

// A room of the project's own; `folder` keeps its panorama between runs, empty: it is traced each time.
Surroundings room_surroundings(uint32_t seed, const std::string& folder, uint32_t threads, const Camera& camera,
                               double azimuth_deg, Vec3 standing);

// A photograph with this diagonal field of view, and the camera that took it: eye and direction are the scene's.
Surroundings photo_surroundings(const std::string& path, double diagonal_fov_deg, Camera* camera);

// The labels of the panorama at the place of the object: what a perfect network would say.
ShotLight labelled_light(const Surroundings& surroundings);

// What an app lights with that knows nothing of the room: white, from the upper left behind the camera.
ShotLight arbitrary_light(const ShotCamera& camera);

}  // namespace sandglass::host
