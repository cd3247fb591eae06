// How the cells of light (runtime/core/light_cells.h) turn with an object.
#pragma once

#include <cstdint>

#include "runtime/core/light_cells.h"
#include "runtime/core/math.h"

namespace sandglass {

// The cells as an object sees them that is turned by `yaw` radians about +y. Between two sectors they are interpolated;
// the sum of a ring stays. Turning an object counter-clockwise, seen from above, raises the azimuth of the light in the
// object's frame, because azimuths count clockwise, from +x to +z.
inline void turn_cells(const double world[SANDGLASS_LIGHT_CELLS], double yaw, double object[SANDGLASS_LIGHT_CELLS]) {
  const double turns = yaw / (2 * k_pi), sectors = k_cell_sectors * (turns - static_cast<double>(floor_index(turns)));
  const int64_t whole = floor_index(sectors);
  const double part = sectors - static_cast<double>(whole);
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) {
    const uint32_t ring = i / k_cell_sectors * k_cell_sectors;
    const uint32_t from = (i + 2 * k_cell_sectors - static_cast<uint32_t>(whole)) % k_cell_sectors;
    const uint32_t before = (from + k_cell_sectors - 1) % k_cell_sectors;
    object[i] = (1 - part) * world[ring + from] + part * world[ring + before];
  }
}

}  // namespace sandglass
