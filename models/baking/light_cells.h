// The cells of light (sandglass/types.h) as directions, in the frame in which the cells are given: y up.
#pragma once

#include <algorithm>
#include <cmath>

#include "models/geometry/vec3.h"
#include "runtime/shadow/receiver/cells.h"

namespace sandglass::host {

// A direction of cell `cell`. a and b in 0..1 are places in the cell's azimuth and elevation; where they are uniform,
// so is the irradiance that a floor receives.
inline Vec3 cell_direction(uint32_t cell, double a, double b) {
  const double azimuth = 2 * k_pi * (cell % k_cell_sectors + a) / k_cell_sectors;
  const double square = (cell / k_cell_sectors + b) / k_cell_rings;  // of the sine of the elevation
  const double flat = std::sqrt(std::max(0.0, 1 - square));
  return {flat * std::cos(azimuth), std::sqrt(square), flat * std::sin(azimuth)};
}

// The cell of a unit vector above the horizon.
inline uint32_t cell_of(Vec3 d) {
  const double turns = std::atan2(d.z, d.x) / (2 * k_pi);
  const auto sector = static_cast<uint32_t>((turns - std::floor(turns)) * k_cell_sectors) % k_cell_sectors;
  const auto ring = std::min(static_cast<uint32_t>(d.y * d.y * k_cell_rings), k_cell_rings - 1);
  return k_cell_sectors * ring + sector;
}

// The cell that a mirror across the plane z = 0 shows in `cell`.
inline uint32_t mirrored_cell(uint32_t cell) {
  return cell / k_cell_sectors * k_cell_sectors + (k_cell_sectors - 1 - cell % k_cell_sectors);
}

}  // namespace sandglass::host
