// See floor_shadow.h.
#include "models/simulation/floor_shadow.h"

#include <cmath>

namespace sandglass::host {

double floor_transparency(const FloorShadow& shadow, double px, double pz) {
  const Vec3 local = rotate(conjugate(shadow.rotation), Vec3{px - shadow.position.x, 0.0, pz - shadow.position.z});
  const double n = shadow.texels;
  const double u = (local.x - shadow.low[0]) / (shadow.high[0] - shadow.low[0]) * n - 0.5;
  const double v = (local.z - shadow.low[1]) / (shadow.high[1] - shadow.low[1]) * n - 0.5;
  if (!(u > -1.0 && v > -1.0 && u < n && v < n)) return 1.0;
  const auto texel = [&](double x, double y) {
    const bool inside = x >= 0.0 && y >= 0.0 && x < n && y < n;
    return inside ? shadow.coverage[static_cast<size_t>(y) * shadow.texels + static_cast<size_t>(x)] / 255.0 : 0.0;
  };
  const double x = std::floor(u), y = std::floor(v), fx = u - x, fy = v - y;
  const double coverage = (1.0 - fy) * ((1.0 - fx) * texel(x, y) + fx * texel(x + 1.0, y)) +
                          fy * ((1.0 - fx) * texel(x, y + 1.0) + fx * texel(x + 1.0, y + 1.0));
  return 1.0 - coverage * shadow.opacity;
}

}  // namespace sandglass::host
