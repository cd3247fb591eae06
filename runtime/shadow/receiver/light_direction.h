// The direction towards a light, as an app gives it: three floats of any length above 0.
#pragma once

#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"

namespace sandglass {

// The diameter of a light whose size is not given, radians: 20 degrees.
constexpr float k_usual_diameter = 0.34906585f;

// Refuses what points nowhere; `towards` is the same direction in double, of the same length.
inline sandglass_status check_light_direction(const float direction[3], double towards[3], const char** reason) {
  if (!all_finite(direction, 3))
    return refuse(reason, "direction is not finite: check where it comes from; the light is as it was.");
  for (uint32_t axis = 0; axis < 3; ++axis) towards[axis] = static_cast<double>(direction[axis]);
  if (towards[0] == 0 && towards[1] == 0 && towards[2] == 0)
    return refuse(reason, "direction is the zero vector: it must point to the light.");
  return accept(reason);
}

}  // namespace sandglass
