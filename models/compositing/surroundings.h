// What stands behind a shot: a panorama, of which the camera sees excerpts, or a photograph, which it sees as it is.
// The scene's frame is the panorama's, turned about y so that the scene's camera looks where it should. The camera's
// eye is where the panorama was taken.
//
// The camera answers as a phone's does: it shows radiance times its exposure, and white where that is more than 1.
#pragma once

#include <cstdint>
#include <string>

#include "models/compositing/shot_camera.h"
#include "models/compositing/shot_light.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/panorama.h"

namespace sandglass::host {

struct Surroundings {
  RadianceMap panorama;      // empty: a photograph
  RadianceMap warped;        // the panorama from where the object stands, its own centre at `view`
  double exposure = 1.0;     // by itself, of the camera at rest
  double insertion = 0.0;    // how far ahead the object stands, in radii of the panorama's sphere
  Vec3 foot;                 // the object's, from the eye, in radii
  View view = {};            // towards it
  Vec3 floor;                // radiance of the floor around the object, no more than its light explains
  RadianceMap photo;         // linear, 0..1
  double photo_focal = 0.0;  // pixels
  std::string name;

  bool has_truth() const { return !panorama.rgb.empty(); }
  // What the camera shows in a direction: linear, 0..1.
  Vec3 seen(const ShotCamera& camera, Vec3 direction) const;
  // The light at the object as it is, in the picture's scale. Needs a truth.
  ShotLight true_light() const { return scaled(light_above_floor(warped, view, floor), exposure); }
  // What a shiny thing there reflects. It lasts as long as this.
  Reflected true_reflected() const;
};

// Surroundings of a panorama. At rest `camera` looks along `azimuth_deg`. The light is that of the place `standing`,
// where the object stands.
Surroundings panorama_surroundings(RadianceMap panorama, const std::string& name, const Camera& camera,
                                   double azimuth_deg, Vec3 standing, double insertion);

// The same, seen by the same camera, with the object elsewhere.
Surroundings moved(const Surroundings& surroundings, const Camera& camera, Vec3 standing, double insertion);

// A captured room's sphere is taken to be four times as far away as the object.
constexpr double k_object_insertion = 0.25;

// A captured room that ships (models/kept_rooms). A Failure names those that do.
RadianceMap kept_room(const std::string& name);

// A made-up room. It is traced, and kept in `folder` between runs unless that is empty.
Surroundings room_surroundings(uint32_t seed, const std::string& folder, uint32_t threads, const Camera& camera,
                               double azimuth_deg, Vec3 standing);

// A photograph with this diagonal field of view. *camera keeps its eye and direction and gets the photograph's field of
// view. Pictures are 4 : 3 and show what fits of a photograph of another shape.
Surroundings photo_surroundings(const std::string& path, double diagonal_fov_deg, Camera* camera);

// A light of 0.7 from the upper left behind the camera, which an app draws that knows nothing of the room.
ShotLight arbitrary_light(const ShotCamera& camera, Vec3 irradiance);

}  // namespace sandglass::host
