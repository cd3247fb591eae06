// See environment.h. Pixels are cut finer than most panoramas have them, so that few straddle two cells.
#include "models/baking/environment.h"

#include <algorithm>
#include <cmath>

#include "models/baking/light_cells.h"

namespace sandglass::host {
namespace {

constexpr int k_width = 1024, k_height = k_width / 2;

}  // namespace

Environment::Environment(const RadianceMap& panorama) {
  double sum = 0;
  for (int v = 0; v < k_height / 2; ++v) {
    const double solid_angle = pixel_solid_angle(v, k_width, k_height);
    for (int u = 0; u < k_width; ++u) {
      const Vec3 d = panorama_direction(u, v, k_width, k_height);
      const Vec3 colour = panorama.colour(u * panorama.width / k_width, v * panorama.height / k_height);
      const double light = std::max(0.0, luminance(colour)) * std::max(0.0, d.y) * solid_angle;
      cells_[cell_of(d)] += light;
      sums_.push_back(sum += light);
    }
  }
  for (double& x : cells_) x /= sum;
  for (double& x : sums_) x /= sum;
}

Vec3 Environment::direction(double share, double a, double b) const {
  const auto found = std::upper_bound(sums_.begin(), sums_.end(), share);
  const long index = std::min<long>(found - sums_.begin(), static_cast<long>(sums_.size()) - 1);
  return panorama_direction(static_cast<double>(index % k_width) + a - 0.5,
                            static_cast<double>(index / k_width) + b - 0.5, k_width, k_height);
}

}  // namespace sandglass::host
