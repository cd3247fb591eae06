#include "tests/laboratory/light/lit_picture.h"

#include <algorithm>

#include "models/compositing/image_errors.h"

namespace sandglass::host {

namespace {

constexpr double k_most_contrast = 0.95;   // a limit, because o / (1 - o) has none
constexpr double k_least_elevation = 0.1;  // sine; a light that grazes the floor cannot give it a large irradiance

}  // namespace

RadianceMap lit_by(const LightLabels& labels, const RadianceMap& directional, const RadianceMap& ambient) {
  const double o = std::min(labels.contrast, k_most_contrast), bright = luminance(labels.light);
  const double elevation = std::max(labels.direction.y, k_least_elevation);
  const Vec3 light =
      bright > 0.0 ? labels.light * (luminance(labels.ambient) * o / (1.0 - o) / elevation / bright) : labels.light;
  RadianceMap picture(directional.width, directional.height);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      picture.set(x, y,
                  limited(product(light, directional.colour(x, y)) + product(labels.ambient, ambient.colour(x, y))));
  return picture;
}

RadianceMap shown_by(RadianceMap radiance, double white) {
  for (int y = 0; y < radiance.height; ++y)
    for (int x = 0; x < radiance.width; ++x) radiance.set(x, y, limited(tone_mapped(radiance.colour(x, y), white)));
  return radiance;
}

}  // namespace sandglass::host
