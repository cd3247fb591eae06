#include "models/rooms/probe_light.h"

#include <algorithm>

namespace sandglass::host {

ProbeLight::ProbeLight(const RadianceMap& map, const ViewRotation& rotation) : map_(&map), rotation_(rotation) {
  cumulative_.reserve(map.rgb.size() / 3);
  double sum = 0.0;
  for (int v = 0; v < map.height; ++v)
    for (int u = 0; u < map.width; ++u)
      cumulative_.push_back(sum += luminance(map.colour(u, v)) * pixel_solid_angle(v, map.width, map.height));
}

ProbeLight::Sample ProbeLight::sample(double a, double b) const {
  const double total = cumulative_.back(), at = a * total;
  const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), at);
  const auto index = std::min<size_t>(static_cast<size_t>(found - cumulative_.begin()), cumulative_.size() - 1);
  const double before = index > 0 ? cumulative_[index - 1] : 0.0, share = cumulative_[index] - before;
  const int u = static_cast<int>(index) % map_->width, v = static_cast<int>(index) / map_->width;
  const double within = share > 0.0 ? (at - before) / share : 0.5;
  const Vec3 d = panorama_direction(u + within - 0.5, v + b - 0.5, map_->width, map_->height);
  const Vec3 radiance = map_->colour(u, v);
  const double bright = luminance(radiance);
  return {rotation_.to_panorama(d), bright > 0.0 ? radiance * (total / bright) : Vec3{}};
}

}  // namespace sandglass::host
