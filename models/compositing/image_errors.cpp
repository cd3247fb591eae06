#include "models/compositing/image_errors.h"

#include <cmath>
#include <numbers>

namespace sandglass::host {

ImageErrors compare(const RadianceMap& truth, const RadianceMap& picture) {
  double difference = 0.0, truth_square = 0.0, picture_square = 0.0, both = 0.0, logarithm = 0.0, angle = 0.0;
  size_t coloured = 0;
  const size_t values = truth.rgb.size();
  for (size_t i = 0; i < values; ++i) {
    const double t = truth.rgb[i], p = picture.rgb[i];
    difference += (t - p) * (t - p);
    truth_square += t * t, picture_square += p * p, both += t * p;
    const double l = std::log((t + 1.0) / (p + 1.0));
    logarithm += l * l;
  }
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x) {
      const Vec3 t = truth.colour(x, y), p = picture.colour(x, y);
      if (dot(t, t) <= 0.0 || dot(p, p) <= 0.0) continue;
      angle += std::atan2(length(cross(t, p)), dot(t, p));
      ++coloured;
    }
  const double n = static_cast<double>(values);
  ImageErrors errors;
  errors.rmse = std::sqrt(difference / n);
  errors.relative = truth_square > 0.0 ? std::sqrt(difference / truth_square) : 0.0;
  const double scale = picture_square > 0.0 ? both / picture_square : 0.0;
  errors.scale_invariant = std::sqrt(std::fmax(0.0, truth_square - scale * both) / n);
  errors.logarithmic = std::sqrt(logarithm / n);
  errors.angle_deg = coloured > 0 ? angle / static_cast<double>(coloured) * 180.0 / std::numbers::pi : 0.0;
  return errors;
}

}  // namespace sandglass::host
