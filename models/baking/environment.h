// A panorama as the light of a floor: its share in each cell, and directions that are drawn as often as they light the
// floor.
#pragma once

#include <array>
#include <vector>

#include "models/geometry/vec3.h"
#include "models/rooms/panorama.h"
#include "sandglass/types.h"

namespace sandglass::host {

class Environment {
 public:
  // Luminance counts. The panorama must have light above the horizon.
  explicit Environment(const RadianceMap& panorama);

  // The share of the floor's irradiance from each cell; sum 1.
  const std::array<double, SANDGLASS_LIGHT_CELLS>& cells() const { return cells_; }

  // The direction at `share` (0..1) of the irradiance, at the place (a, b) within its pixel.
  Vec3 direction(double share, double a, double b) const;

 private:
  std::array<double, SANDGLASS_LIGHT_CELLS> cells_ = {};
  std::vector<double> sums_;  // of the irradiance, pixel by pixel; ends at 1
};

}  // namespace sandglass::host
