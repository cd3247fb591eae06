#include "runtime/light/harmonics.h"

#include "runtime/core/finite.h"
#include "runtime/core/math.h"
#include "runtime/core/refuse.h"
#include "runtime/light/luminance.h"

namespace sandglass {

namespace {

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

constexpr double k_most_contrast = 0.95, k_least_elevation = 0.1, k_most_strength = 64.0;

bool usable(const sandglass_light_estimate& e) {
  return is_finite(e.strength) && all_finite(e.direction, 3) && all_finite(e.light, 3) && all_finite(e.ambient, 3);
}
bool usable(const sandglass_room_light& l) {
  return is_finite(l.main_share) && all_finite(l.main_direction, 3) && all_finite(l.main_colour, 3) &&
         all_finite(l.irradiance, 3) && all_finite(l.sh, 3 * k_harmonics);
}

}  // namespace

extern const double k_harmonic_factors[k_harmonics] = {0.28209479177387814, 0.48860251190291992, 0.48860251190291992,
                                                       0.48860251190291992, 1.0925484305920792,  1.0925484305920792,
                                                       0.31539156525252005, 1.0925484305920792,  0.54627421529603959};

extern const double k_cosine_factors[k_harmonics] = {1.0,  2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 0.25,
                                                     0.25, 0.25,      0.25,      0.25};

void harmonic_polynomials(const double v[3], double p[k_harmonics]) {
  const double x = v[0], y = v[1], z = v[2];
  p[0] = 1.0, p[1] = y, p[2] = z, p[3] = x;
  p[4] = x * y, p[5] = y * z, p[6] = 3.0 * z * z - 1.0, p[7] = x * z, p[8] = x * x - y * y;
}

void light_harmonics(const sandglass_light_estimate& estimate, sandglass_light_model model, double* sh) {
  double axis[3], polynomials[k_harmonics];
  for (int i = 0; i < 3; ++i) axis[i] = static_cast<double>(estimate.direction[i]);
  harmonic_polynomials(axis, polynomials);
  for (uint32_t colour = 0; colour < 3; ++colour) {
    const double a = static_cast<double>(estimate.ambient[colour]), c = static_cast<double>(estimate.light[colour]);
    double lobe = 0.0;
    if (model == SANDGLASS_LIGHT_MODEL_WHOLE) lobe = k_pi / k_facing * static_cast<double>(estimate.strength) * c;
    if (model == SANDGLASS_LIGHT_MODEL_PICTURE) lobe = c * (1.0 - a);  // 1 - (1 - g c)(1 - a) = a + g c (1 - a)
    for (uint32_t i = 0; i < k_harmonics; ++i) {
      const double zonal = k_zonal[i == 0 ? 0 : i < 4 ? 1 : 2];
      sh[3 * i + colour] = lobe * zonal * k_harmonic_factors[i] * polynomials[i];
    }
    sh[colour] += a * 4.0 * k_pi * k_harmonic_factors[0];
  }
}

void main_light_of(const sandglass_room_light& light, double facing[3]) {
  double irradiance[3];
  for (int c = 0; c < 3; ++c) irradiance[c] = static_cast<double>(light.irradiance[c]);
  const double up = static_cast<double>(light.main_direction[1]);
  const double elevation = up > k_least_elevation ? up : k_least_elevation;
  const double level = static_cast<double>(light.main_share) * luminance(irradiance) / (k_pi * elevation);
  for (int c = 0; c < 3; ++c) facing[c] = level * static_cast<double>(light.main_colour[c]);
}

void room_harmonics(const sandglass_room_light& light, sandglass_light_model model, double* sh) {
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) sh[i] = static_cast<double>(light.sh[i]);
  if (model == SANDGLASS_LIGHT_MODEL_WHOLE) return;
  double axis[3], polynomials[k_harmonics], facing[3];
  for (int i = 0; i < 3; ++i) axis[i] = static_cast<double>(light.main_direction[i]);
  harmonic_polynomials(axis, polynomials);
  main_light_of(light, facing);
  for (uint32_t i = 0; i < k_harmonics; ++i)
    for (uint32_t c = 0; c < 3; ++c) sh[3 * i + c] -= k_pi * facing[c] * k_harmonic_factors[i] * polynomials[i];
}

double light_strength(const double direction[3], const double light[3], const double ambient[3], double contrast) {
  const double colour = luminance(light);
  if (!(colour > 0.0)) return 0.0;
  const double o = contrast < k_most_contrast ? contrast : k_most_contrast;
  const double elevation = direction[1] > k_least_elevation ? direction[1] : k_least_elevation;
  const double strength = luminance(ambient) / colour * o / (1.0 - o) / elevation;
  return strength < k_most_strength ? strength : k_most_strength;
}

}  // namespace sandglass

using namespace sandglass;

sandglass_status sandglass_light_harmonics(const sandglass_light_estimate* estimate, sandglass_light_model model,
                                           float sh[27], const char** reason) {
  if (estimate == nullptr || sh == nullptr)
    return refuse(reason, "estimate or sh is NULL: pass an estimate of sandglass_light_get and room for 27 floats");
  if (estimate->struct_size < k_least_estimate_bytes)
    return refuse(
        reason,
        "estimate.struct_size is not set: set it to sizeof(sandglass_light_estimate) before sandglass_light_get");
  if (model < SANDGLASS_LIGHT_MODEL_AMBIENT || model > SANDGLASS_LIGHT_MODEL_PICTURE)
    return refuse(reason, "model is none of SANDGLASS_LIGHT_MODEL_AMBIENT, _WHOLE and _PICTURE");
  if (!usable(*estimate))
    return refuse(
        reason,
        "a direction, colour or strength of the estimate is not finite: pass an estimate as sandglass_light_get fills "
        "it");
  double exact[3 * k_harmonics];
  light_harmonics(*estimate, model, exact);
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) sh[i] = static_cast<float>(exact[i]);
  return accept(reason);
}

sandglass_status sandglass_room_harmonics(const sandglass_room_light* light, sandglass_light_model model, float sh[27],
                                          const char** reason) {
  if (light == nullptr || sh == nullptr)
    return refuse(reason, "light or sh is NULL: pass a light of sandglass_room_get and room for 27 floats");
  if (light->struct_size < k_least_room_light_bytes)
    return refuse(reason,
                  "light.struct_size is not set: set it to sizeof(sandglass_room_light) before sandglass_room_get");
  if (model != SANDGLASS_LIGHT_MODEL_AMBIENT && model != SANDGLASS_LIGHT_MODEL_WHOLE)
    return refuse(reason, "model is none of SANDGLASS_LIGHT_MODEL_AMBIENT and _WHOLE, which a room has");
  if (!usable(*light))
    return refuse(reason, "a number of the light is not finite: pass a light as sandglass_room_get fills it");
  double exact[3 * k_harmonics];
  room_harmonics(*light, model, exact);
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) sh[i] = static_cast<float>(exact[i]);
  return accept(reason);
}
