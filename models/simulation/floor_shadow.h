// A shadow of the library, ready to draw: its texture and where it lies on the floor.
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

}  // namespace sandglass::host
