// The shadows of the library, ready to draw: their textures and where they lie on the floor.
#pragma once

#include <cstdint>
#include <vector>

#include "models/geometry/vec3.h"

namespace sandglass::host {

// A shadow texture on a floor, as an app composites it: it multiplies the floor's direct light by
// 1 - coverage * opacity, in linear space.
struct FloorShadow {
  // The number of the collider that casts this shadow. The renderer does not trace this collider's shadow on the floor.
  uint32_t collider = 0;
  uint32_t texels = 0;                 // a side
  std::vector<uint8_t> coverage;       // row by row along local z
  double low[2] = {}, high[2] = {};    // corners of the rectangle: local x and z, metres
  double opacity = 1, half_angle = 0;  // half_angle: of the light, radians
  Vec3 position;                       // of the object; its floor is at this height
  Quaternion rotation = k_no_rotation;
};

// The share of the direct light that the texture leaves at the point (x, z) of its floor, or of the surface that it was
// made for. It is interpolated between texels as on a GPU, and is 1 beyond the rectangle.
double floor_transparency(const FloorShadow& shadow, double x, double z);

// All shadows of a scene at one moment. Those of the main light come first; those of the room's light hold what is
// hidden of it, so that floor_transparency is the share that arrives.
struct SceneShadows {
  std::vector<FloorShadow> object;  // of each standing object
  std::vector<FloorShadow> pile;    // of the sand on the floor; it may be empty, as all below
  std::vector<FloorShadow> pile_on_sand;
  std::vector<FloorShadow> ambient;  // of each standing object
  std::vector<FloorShadow> sky, sky_on_sand;
};

}  // namespace sandglass::host
