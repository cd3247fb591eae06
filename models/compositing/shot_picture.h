// One instant of a shot as a picture: composited as an app does, and path traced as the truth.
//
// Composite. The background is the camera's image. The floor keeps A - s c of what the camera shows of it: A is what
// the ambient shadows leave of the room's light, s the main light's share, c what the sharp textures cover. The object
// gets the room's harmonics by the nine numbers of its vertices, which know what it hides from itself. What it does not
// see of the room it sees of itself, and that is as bright: where it is open to the share v, light is 1 / (1 - rho (1 - v))
// times as strong. Sand is drawn by the kit. Nothing is traced but where things are.
//
// Metal reflects the room by the library's cube; it does not know what stands beside it.
//
// Truth. The sand is grains of 0.6 mm, balls of many sizes packed along its surface (grains.h). Object and grains stand in
// the light of the warped panorama, on a floor that only catches shadows and reflects
// light. Where the floor is seen, the panorama's radiance is multiplied by the irradiance with what stands on it and
// divided by that without (differential rendering, Debevec 1998). The floor's reflectance is that which explains its
// own radiance around the object. Both pictures go through the same camera.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "models/compositing/shot_camera.h"
#include "models/compositing/surroundings.h"
#include "models/drawing/sand_layer.h"
#include "models/drawing/sand_shape.h"
#include "models/mesh/mesh.h"
#include "models/rooms/panorama.h"
#include "models/simulation/floor_shadow.h"

namespace sandglass::host {

// What falls on the floor and the grains. textures: the library's. none: nothing.
enum class CastShadow { textures, none };

// An object as it is lit.
struct LitObject {
  Mesh mesh;                            // in the scene's frame, standing on y = 0
  Quaternion rotation = k_no_rotation;  // from its own frame
  // sandglass_shadow_transfer of the three corners of each triangle: nine numbers a corner. Empty: the object does not
  // know what it hides from itself, and is lit by its normals.
  std::vector<float> transfer;
  uint32_t moving = 0;                    // the first vertices: those of the object that may be carried
  uint32_t metal_from = UINT32_MAX;       // the first triangle of what is metal; those before it are painted
  std::vector<float> metal_normals = {};  // of the three corners of each triangle from there on
};

struct ShotPictureOptions {
  int width = 320, height = 240;
  int samples = 3;    // composite: per pixel and axis
  int paths = 64;     // truth: per pixel
  uint64_t seed = 0;  // of the truth's noise
  uint32_t threads = 1;
  // Composite. False is a control: the object is not lit by itself.
  bool lit_by_itself = true;
  KitChange kit = {};  // of the composite's sand, for controls
};

class ShotPicture {
 public:
  // Needs Embree, else a Failure.
  ShotPicture(const LitObject& object, const SandShape& sand);
  ~ShotPicture();
  ShotPicture(const ShotPicture&) = delete;
  ShotPicture& operator=(const ShotPicture&) = delete;

  // Linear, 0..1. Equal arguments give equal bits on any number of threads.
  RadianceMap composite(const Surroundings& room, const ShotCamera& camera, const PlacedLight& light,
                        const SceneShadows& shadows, CastShadow cast, const ShotPictureOptions& options) const;
  // What fills a pixel; `nothing` also where different things share it. The normal is its middle's.
  struct Seen {
    enum What { nothing, floor, object, sand, metal } what = nothing;
    Vec3 normal;
  };
  std::vector<Seen> seen(const ShotCamera& camera, int width, int height) const;
  // Surroundings must have a truth.
  RadianceMap truth(const Surroundings& room, const ShotCamera& camera, const ShotPictureOptions& options) const;

 private:
  struct State;
  class Paths;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host
