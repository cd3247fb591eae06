// The cells in which a room's light is counted at an object: SANDGLASS_LIGHT_CELLS parts of the upper hemisphere
// (sandglass/types.h). What is expected of a room that nobody looked at, and how cells turn with an object.
#pragma once

#include <cstdint>

#include "runtime/core/math.h"
#include "sandglass/types.h"

namespace sandglass {

constexpr uint32_t k_light_sectors = 16, k_light_rings = 4;
static_assert(k_light_sectors * k_light_rings == SANDGLASS_LIGHT_CELLS);

// The share of the floor's irradiance that is expected of each ring, the lowest first: the mean of 27 captured interiors,
// whose windows and lamps make the lowest ring the brightest.
// Every sector of a ring has the same share.
constexpr double k_light_prior[k_light_rings] = {0.35, 0.19, 0.21, 0.25};

inline void light_prior(double cells[SANDGLASS_LIGHT_CELLS]) {
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) cells[i] = k_light_prior[i / k_light_sectors] / k_light_sectors;
}

// The cells as an object sees them that is turned by `yaw` radians about +y. Between two sectors they are interpolated;
// the sum of a ring stays. Turning an object counter-clockwise, seen from above, raises the azimuth of the light in the
// object's frame, because azimuths count clockwise there (from +x to +z).
inline void turn_cells(const double world[SANDGLASS_LIGHT_CELLS], double yaw, double object[SANDGLASS_LIGHT_CELLS]) {
  const double turns = yaw / (2 * k_pi), sectors = k_light_sectors * (turns - static_cast<double>(floor_index(turns)));
  const int64_t whole = floor_index(sectors);
  const double part = sectors - static_cast<double>(whole);
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) {
    const uint32_t ring = i / k_light_sectors * k_light_sectors;
    const uint32_t from = (i + 2 * k_light_sectors - static_cast<uint32_t>(whole)) % k_light_sectors;
    const uint32_t before = (from + k_light_sectors - 1) % k_light_sectors;
    object[i] = (1 - part) * world[ring + from] + part * world[ring + before];
  }
}

}  // namespace sandglass
