// The cells of light (runtime/light/light_cells.h) as shadows take them: checked, compared, and turned with an object.
#pragma once

#include <cstdint>

#include "runtime/frame/refuse.h"
#include "runtime/light/light_cells.h"
#include "runtime/math/finite.h"
#include "runtime/math/math.h"

namespace sandglass {

constexpr double k_cells_slack = 1e-3;  // that the sum of all cells may exceed 1 by

// Refuses what are no shares of one light.
inline sandglass_status check_cells(const float cells[SANDGLASS_LIGHT_CELLS], const char** reason) {
  double sum = 0;
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) {
    if (!(cells[i] >= 0 && is_finite(cells[i])))
      return refuse(reason, "a cell is negative or not finite: pass shares of the plane's light.");
    sum += static_cast<double>(cells[i]);
  }
  if (!(sum <= 1 + k_cells_slack))
    return refuse(reason, "the cells are more than 1 together: divide them by the irradiance of the plane.");
  return accept(reason);
}

// Whether a texel can differ by a step of its byte between two lights: what each cell hides is 1 at most, so by no more
// than all that grew, or all that shrank.
template <class Before, class After>
bool cells_differ(const Before before[SANDGLASS_LIGHT_CELLS], const After after[SANDGLASS_LIGHT_CELLS]) {
  double rise = 0, fall = 0;
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) {
    const double change = static_cast<double>(after[i]) - static_cast<double>(before[i]);
    (change > 0 ? rise : fall) += absolute(change);
  }
  return 255 * (rise > fall ? rise : fall) >= 1;
}

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
