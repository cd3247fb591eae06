// Luminance of linear RGB (5.2).
#pragma once

namespace sandglass {

constexpr double luminance(const double c[3]) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

inline double luminance(const float c[3]) {
  const double wide[3] = {static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])};
  return luminance(wide);
}

}  // namespace sandglass
