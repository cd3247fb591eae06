// What stands behind a shot: a panorama of radiance, of which a camera sees excerpts, or a photograph, which it sees as
// it is. The scene's frame is the panorama's own, turned about y so that the scene's camera looks where it should; its
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
  double confidence = -1.0;    // of an estimate; below 0: it is none
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

  // Between what the camera shows and the radiance that it stands for, through the camera's tone curve. Of a photograph
  // none is known but sRGB's: its values count as radiance.
  Vec3 radiance(Vec3 shown) const { return has_truth() ? radiance_of(shown, white) : shown; }
  Vec3 shown(Vec3 radiance) const;
};

// Of what a level floor receives, the share by which what stands in the light's way can darken each colour. Its
// luminance is the contrast; a colour has more of it, the more of that colour is the light's and not the surroundings':
//   o_k = o c_k / Y(c) / (o c_k / Y(c) + (1 - o) a_k / Y(a))
Vec3 shadow_opacity(const ShotLight& light);

// The panorama of a file. `camera` and `azimuth_deg`: at rest the camera looks there. `standing`: where the object
// stands; the light is that of this place.
Surroundings panorama_surroundings(RadianceMap panorama, const std::string& name, const Camera& camera,
                                   double azimuth_deg, Vec3 standing, double insertion);

// A room of the project's own; `folder` keeps its panorama between runs, empty: it is traced each time.
Surroundings room_surroundings(uint32_t seed, const std::string& folder, uint32_t threads, const Camera& camera,
                               double azimuth_deg, Vec3 standing);

// A photograph with this diagonal field of view, and the camera that took it: eye and direction are the scene's. Its
// pictures, of 4 : 3, show as much as fits of a photograph of another shape.
Surroundings photo_surroundings(const std::string& path, double diagonal_fov_deg, Camera* camera);

// The labels of the panorama at the place of the object: what a perfect network would say. One thing more, which a
// network is not asked: a shadow from one direction takes only that part of the highlight which comes from there, so
// that the contrast is the label's times the highlight's concentration (labels.h).
ShotLight labelled_light(const Surroundings& surroundings);

// What an app lights with that knows nothing of the room: white, from the upper left behind the camera.
ShotLight arbitrary_light(const ShotCamera& camera);

}  // namespace sandglass::host
