#include "models/lighting/labels.h"

#include <algorithm>

namespace sandglass::host {

namespace {

// The least length of the mean of weighted directions. Below it there is no direction.
constexpr double k_concentration_min = 1e-3;

struct WeightedColour {
  Vec3 sum;
  double weight = 0.0;

  void add(Vec3 colour, double w) {
    sum = sum + colour * w;
    weight += w;
  }
  Vec3 mean() const {
    if (weight <= 0.0) return {};
    const Vec3 colour = sum * (1.0 / weight);
    return colour * (1.0 / std::max({1.0, colour.x, colour.y, colour.z}));
  }
};

}  // namespace

LightLabels labels_of(const RadianceMap& panorama, Vec3 up, double white) {
  const double threshold = k_highlight_share * greatest_luminance(panorama);
  Vec3 direction;
  WeightedColour light, ambient;
  double bright = 0.0, irradiance[2] = {0.0, 0.0};  // first of the rest, then of the highlight
  for (int v = 0; v < panorama.height; ++v) {
    const double omega = pixel_solid_angle(v, panorama.width, panorama.height);
    for (int u = 0; u < panorama.width; ++u) {
      const Vec3 radiance = panorama.colour(u, v), d = panorama_direction(u, v, panorama.width, panorama.height);
      const double l = luminance(radiance);
      const Vec3 colour = tone_mapped(radiance, white);
      const bool highlight = l >= threshold;
      irradiance[highlight ? 1 : 0] += l * omega * std::max(0.0, dot(d, up));
      if (highlight) {
        bright += l * omega;
        direction = direction + d * (l * omega);
        light.add(colour, l * omega);
      } else {
        ambient.add(colour, omega);
      }
    }
  }
  LightLabels labels = {};
  labels.concentration = bright > 0.0 ? length(direction) / bright : 0.0;
  labels.has_direction = labels.concentration >= k_concentration_min;
  labels.direction = labels.has_direction ? normalised(direction) : up;
  labels.light = light.mean();
  // If the highlight is the whole panorama and has no direction, it counts as ambient light.
  labels.ambient = (ambient.weight <= 0.0 && !labels.has_direction ? light : ambient).mean();
  const double arriving = irradiance[0] + irradiance[1];
  labels.contrast = labels.has_direction && arriving > 0.0 ? irradiance[1] / arriving : 0.0;
  return labels;
}

}  // namespace sandglass::host
