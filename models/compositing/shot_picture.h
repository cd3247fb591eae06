// One instant of a shot as a picture: composited as an app does, and path traced as the truth.
//
// Composite. The background is the camera's image. Compositing needs radiance, so the image goes through the inverse of
// the camera's tone curve, and everything goes through the curve at the end. Where the curve is flat, a shadow or a
// lamp makes less difference.
//
// The object and the grains take the directional light, by the cosine, and the ambient light. The floor keeps
// 1 - (1 - nu) o_k of its radiance in each colour: nu is the share of the direct light that the textures leave, o_k the
// direct light's share of all light (shadow_opacity). Grains are darkened by the pile's own texture at their place, and
// by the object's texture where the light through them would meet the floor. Both darken only the part of the light
// that one direction stands for (ShotLight). What a graphics engine would add is traced: the object's shadow on itself,
// the contact shadows of grains on grains, and how open a point is to ambient light.
//
// The light's colours are means of tone mapped ones (labels.h). Both are made brighter by the factor that the inverse
// curve gives the ambient luminance. The inverse of a mean is less than the mean of inverses, so objects stay a little
// dark.
//
// Truth. Object and grains stand in the light of the warped panorama, on a floor that only catches shadows and reflects
// light. Where the floor is seen, the panorama's radiance is multiplied by the irradiance with what stands on it and
// divided by that without (differential rendering, Debevec 1998). The floor's reflectance is that which explains its
// own radiance around the object. The tone curve is the panorama's.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "models/compositing/shot_camera.h"
#include "models/compositing/surroundings.h"
#include "models/drawing/render.h"
#include "models/mesh/mesh.h"
#include "models/rooms/panorama.h"

namespace sandglass::host {

// What falls on the floor and the grains. textures: the library's. none: nothing. hard: an edge, traced to the middle
// of the light. no_curve: the textures without any tone curve, multiplied onto the floor as the camera shows it, by the
// contrast in all colours alike.
enum class CastShadow { textures, none, hard, no_curve };

struct ShotShadows {
  std::vector<FloorShadow> object, pile, pile_surface;  // none of a kind: nothing is cast
};

struct ShotPictureOptions {
  int width = 320, height = 240;
  int samples = 3;  // composite: per pixel and axis
  int paths = 64;   // truth: per pixel
  uint32_t threads = 1;
};

class ShotPicture {
 public:
  // `object` in the scene's frame, standing on y = 0. Needs Embree, else a Failure.
  ShotPicture(const Mesh& object, std::span<const float> grains, float grain_radius);
  ~ShotPicture();
  ShotPicture(const ShotPicture&) = delete;
  ShotPicture& operator=(const ShotPicture&) = delete;

  // Linear, 0..1. Equal arguments give equal bits on any number of threads.
  RadianceMap composite(const Surroundings& room, const ShotCamera& camera, const ShotLight& light,
                        const ShotShadows& shadows, CastShadow cast, const ShotPictureOptions& options) const;
  // Surroundings must have a truth.
  RadianceMap truth(const Surroundings& room, const ShotCamera& camera, const ShotPictureOptions& options) const;

  // The share of a level floor's irradiance at (x, 0, z) that the grains alone leave. The light is a cap of half angle
  // `half_angle` about `towards`; points^2 stratified rays.
  double grains_leave(double x, double z, Vec3 towards, double half_angle, int points) const;
  // The same for the surface of the grain that is seen from above at (x, z). *facing: its cosine to `towards`; 0 if
  // there is no grain or it faces away.
  double grain_lit(double x, double z, Vec3 towards, double half_angle, int points, double* facing) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host
