#include "runtime/light/network/radiometry.h"

#include "runtime/light/luminance.h"
#include "runtime/math/math.h"

namespace sandglass {

namespace {

// A lobe about an axis has the coefficients z_l Y_lm(axis), where z_l is its integral against the Legendre polynomial l
// (Funk and Hecke). For the spherical Gaussian of (5.27) these integrals have a closed form.
// The Gaussian exp(s (t - 1)) of t = cos, s = 2 pi (5.27).
constexpr double k_sharpness = 2.0 * k_pi;
constexpr double k_at_side = 0.0018674427317079889;   // exp(-2 pi)
constexpr double k_at_back = 3.4873423562089454e-06;  // exp(-4 pi)
// Its moments over -1..1, by parts.
constexpr double k_moment_0 = (1.0 - k_at_back) / k_sharpness;
constexpr double k_moment_1 = (1.0 + k_at_back) / k_sharpness - k_moment_0 / k_sharpness;
constexpr double k_moment_2 = (1.0 - k_at_back) / k_sharpness - 2.0 * k_moment_1 / k_sharpness;
constexpr double k_zonal[3] = {2.0 * k_pi * k_moment_0, 2.0 * k_pi* k_moment_1,
                               2.0 * k_pi*(1.5 * k_moment_2 - 0.5 * k_moment_0)};
// The irradiance that it gives a facing surface, 0.841: the first moment over 0..1.
constexpr double k_facing = 2.0 * k_pi * (1.0 / k_sharpness - (1.0 - k_at_side) / (k_sharpness * k_sharpness));

constexpr double k_contrast_max = 0.95, k_elevation_min = 0.1, k_strength_max = 64.0;

}  // namespace

double light_strength(const double direction[3], const double light[3], const double ambient[3], double contrast) {
  const double colour = luminance(light);
  if (!(colour > 0.0)) return 0.0;
  const double o = contrast < k_contrast_max ? contrast : k_contrast_max;
  const double elevation = direction[1] > k_elevation_min ? direction[1] : k_elevation_min;
  const double strength = luminance(ambient) / colour * o / (1.0 - o) / elevation;
  return strength < k_strength_max ? strength : k_strength_max;
}

void estimate_harmonics(const sandglass_estimator_light& estimate, double sh[3 * k_harmonics]) {
  double axis[3], polynomials[k_harmonics];
  for (int i = 0; i < 3; ++i) axis[i] = static_cast<double>(estimate.direction[i]);
  harmonic_polynomials(axis, polynomials);
  for (uint32_t colour = 0; colour < 3; ++colour) {
    const double a = static_cast<double>(estimate.ambient[colour]), c = static_cast<double>(estimate.light[colour]);
    const double lobe = k_pi / k_facing * static_cast<double>(estimate.strength) * c;
    for (uint32_t i = 0; i < k_harmonics; ++i) {
      const double zonal = k_zonal[i == 0 ? 0 : i < 4 ? 1 : 2];
      sh[3 * i + colour] = lobe * zonal * k_harmonic_factors[i] * polynomials[i];
    }
    sh[colour] += a * 4.0 * k_pi * k_harmonic_factors[0];
  }
}

}  // namespace sandglass
