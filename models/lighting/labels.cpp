#include "models/lighting/labels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sandglass::host {

namespace {

constexpr double k_contrast_factor = 0.05;  // the factor in (5.24)
// The least length of the mean of weighted directions. Below it there is no direction.
constexpr double k_least_concentration = 1e-3;
constexpr double k_gaussian_sharpness = 2.0 * std::numbers::pi;

Vec3 clamped(Vec3 c) { return {std::min(c.x, 1.0), std::min(c.y, 1.0), std::min(c.z, 1.0)}; }

struct WeightedColour {
  Vec3 sum, clamped_sum;
  double weight = 0.0;

  void add(Vec3 colour, double w) {
    sum = sum + colour * w, clamped_sum = clamped_sum + clamped(colour) * w;
    weight += w;
  }
  Vec3 mean(Range range) const {
    if (weight <= 0.0) return {};
    const Vec3 colour = sum * (1.0 / weight);
    switch (range) {
      case Range::none:
        return colour;
      case Range::pixels:
        return clamped_sum * (1.0 / weight);
      case Range::mean:
        return clamped(colour);
      case Range::mean_keeping_hue:
        return colour * (1.0 / std::max({1.0, colour.x, colour.y, colour.z}));
    }
    return colour;
  }
};

}  // namespace

LabelVariants label_variants(const RadianceMap& panorama, Vec3 up, double white) {
  const double threshold = k_highlight_share * greatest_luminance(panorama);
  Vec3 direction;
  WeightedColour light, ambient[k_ambient_weights];
  double bright[2] = {0.0, 0.0}, irradiance[2] = {0.0, 0.0};  // first the rest, then the highlight
  for (int v = 0; v < panorama.height; ++v) {
    const double omega = pixel_solid_angle(v, panorama.width, panorama.height);
    for (int u = 0; u < panorama.width; ++u) {
      const Vec3 radiance = panorama.colour(u, v), d = panorama_direction(u, v, panorama.width, panorama.height);
      const double l = luminance(radiance);
      const Vec3 colour = tone_mapped(radiance, white);
      const bool highlight = l >= threshold;
      bright[highlight ? 1 : 0] += l * omega;
      irradiance[highlight ? 1 : 0] += l * omega * std::max(0.0, dot(d, up));
      if (highlight) {
        direction = direction + d * (l * omega);
        light.add(colour, l * omega);
      } else {
        ambient[static_cast<int>(AmbientWeight::luminance)].add(colour, l * omega);
        ambient[static_cast<int>(AmbientWeight::solid_angle)].add(colour, omega);
      }
    }
  }
  LabelVariants labels = {};
  const double concentration = bright[1] > 0.0 ? length(direction) / bright[1] : 0.0;
  labels.concentration = concentration;
  labels.has_direction = concentration >= k_least_concentration;
  labels.direction = labels.has_direction ? normalised(direction) : up;
  for (int range = 0; range < k_ranges; ++range) {
    labels.light[range] = light.mean(static_cast<Range>(range));
    for (int weight = 0; weight < k_ambient_weights; ++weight) {
      // If the highlight is the whole panorama and has no direction, it counts as ambient light.
      const bool empty = ambient[weight].weight <= 0.0 && !labels.has_direction;
      labels.ambient[range][weight] = (empty ? light : ambient[weight]).mean(static_cast<Range>(range));
    }
  }
  if (labels.has_direction) {
    const double ratio = bright[0] / bright[1], arriving = irradiance[0] + irradiance[1];
    labels.contrast[static_cast<int>(Contrast::printed)] = 1.0 - std::tanh(ratio / k_contrast_factor);
    labels.contrast[static_cast<int>(Contrast::factor_above)] = 1.0 - std::tanh(k_contrast_factor * ratio);
    labels.contrast[static_cast<int>(Contrast::irradiance)] = arriving > 0.0 ? irradiance[1] / arriving : 0.0;
  }
  return labels;
}

LightLabels LabelVariants::chosen(Range range, AmbientWeight weight, Contrast which) const {
  const auto r = static_cast<int>(range), w = static_cast<int>(weight), c = static_cast<int>(which);
  return {direction, light[r], ambient[r][w], contrast[c], has_direction, concentration};
}

LightLabels labels_of(const RadianceMap& panorama, Vec3 up, double white) {
  return label_variants(panorama, up, white)
      .chosen(Range::mean_keeping_hue, AmbientWeight::solid_angle, Contrast::irradiance);
}

Vec3 environment_at(const LightLabels& labels, Vec3 direction) {
  const Vec3 a = labels.ambient, c = labels.light;
  const double lobe = std::exp(k_gaussian_sharpness * (dot(labels.direction, direction) - 1.0));
  return {1.0 - (1.0 - lobe * c.x) * (1.0 - a.x), 1.0 - (1.0 - lobe * c.y) * (1.0 - a.y),
          1.0 - (1.0 - lobe * c.z) * (1.0 - a.z)};
}

RadianceMap environment_of(const LightLabels& labels, int width, int height) {
  RadianceMap map(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) map.set(u, v, environment_at(labels, panorama_direction(u, v, width, height)));
  return map;
}

}  // namespace sandglass::host
