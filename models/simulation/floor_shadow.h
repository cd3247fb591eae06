// A shadow of the library as it is drawn: its texture and where it lies on the floor.
#pragma once

#include <cstdint>
#include <vector>

#include "models/geometry/vec3.h"

namespace sandglass::host {

// A shadow texture on a floor, as an app composites it: the floor's direct light is multiplied by 1 - coverage *
// opacity, in linear space.
struct FloorShadow {
  uint32_t collider = 0;  // the caster's number; the renderer leaves it out where it traces the floor's shadows
  uint32_t texels = 0;
  std::vector<uint8_t> coverage;       // row by row along local z
  double low[2] = {}, high[2] = {};    // the rectangle, local x and z, metres
  double opacity = 1, half_angle = 0;  // of the light, radians
  Vec3 position;                       // of the object; its floor is at this height
  Quaternion rotation = k_no_rotation;
};

// Share of the direct light that one texture leaves to a point of its floor, or of any height for which it was made:
// bilinear, as a GPU samples; 1 beyond its rectangle.
double floor_transparency(const FloorShadow& shadow, double x, double z);

}  // namespace sandglass::host
