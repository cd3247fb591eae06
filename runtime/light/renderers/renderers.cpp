// A light in the terms of renderers. The header states each target's convention; the tests
// evaluate the target's own formula on what comes out.
#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/light/harmonics.h"
#include "runtime/light/luminance.h"
#include "runtime/light/renderers/lighting.h"
#include "runtime/math/finite.h"
#include "runtime/math/math.h"
#include "runtime/math/turn.h"

namespace sandglass {
namespace {

constexpr double k_neutral_lumens = 1000.0;
constexpr double k_coldest = 40000.0, k_warmest = 1000.0, k_white = 6500.0;  // kelvin

// Splits a light into a colour whose greatest channel is 1, and that channel. Black becomes white of intensity 0.
double split_colour(const double c[3], float colour[3]) {
  const double two = c[0] > c[1] ? c[0] : c[1], greatest = two > c[2] ? two : c[2];
  for (int i = 0; i < 3; ++i) colour[i] = greatest > 0.0 ? static_cast<float>(c[i] / greatest) : 1.0f;
  return greatest;
}

// A rotation whose z axis is the given unit vector and whose x axis is level.
void rotation_with_z(const double z[3], float q[4]) {
  const double level = square_root(z[0] * z[0] + z[2] * z[2]);
  const bool upright = level < 1e-6;
  const double x[3] = {upright ? 1.0 : z[2] / level, 0.0, upright ? 0.0 : -z[0] / level};
  const double y[3] = {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
  quaternion_of(x, y, z, q);
}

// McCamy 1992 on the chromaticity of linear sRGB.
float temperature_of(const double c[3]) {
  const double r = c[0], g = c[1], b = c[2];
  const double x = 0.4124564 * r + 0.3575761 * g + 0.1804375 * b, y = 0.2126729 * r + 0.7151522 * g + 0.0721750 * b,
               z = 0.0193339 * r + 0.1191920 * g + 0.9503041 * b, sum = x + y + z;
  if (!(sum > 0.0)) return static_cast<float>(k_white);
  const double below = 0.1858 - y / sum;
  if (!(absolute(below) > 1e-6)) return static_cast<float>(k_coldest);
  const double n = (x / sum - 0.3320) / below;
  const double kelvin = ((449.0 * n + 3525.0) * n + 6823.3) * n + 5520.33;
  return static_cast<float>(kelvin < k_warmest ? k_warmest : kelvin > k_coldest ? k_coldest : kelvin);
}

// What every renderer is given, in double.
struct Lights {
  double towards[3];           // the directional light
  double facing[3];            // the radiance of a white surface that faces it, by it alone
  double ambient[3];           // the radiance of a level white floor, by all other light
  double sh[3 * k_harmonics];  // radiance, interleaved
};

// What rounding leaves of a floor that the directional light lights alone, of the whole.
constexpr double k_rounding = 1e-6;

Lights lights_of(const sandglass_light& light, sandglass_light_model model) {
  Lights lights;
  const bool whole = model == SANDGLASS_LIGHT_WHOLE;
  for (int i = 0; i < 3; ++i) lights.towards[i] = static_cast<double>(light.towards[i]);
  const double up = lights.towards[1] > 0.0 ? lights.towards[1] : 0.0;
  for (int i = 0; i < 3; ++i) {
    const double floor = static_cast<double>(light.floor[i]) / k_pi;
    lights.facing[i] = whole ? 0.0 : static_cast<double>(light.facing[i]) / k_pi;
    const double rest = floor - lights.facing[i] * up;
    lights.ambient[i] = rest > k_rounding * floor ? rest : 0.0;
  }
  const float* sh = whole ? light.whole_sh : light.ambient_sh;
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) lights.sh[i] = static_cast<double>(sh[i]);
  return lights;
}

// Irradiance over pi, as factors of the polynomials of harmonic_polynomials.
void make_irradiance(double* sh) {
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) sh[i] *= k_harmonic_factors[i / 3] * k_cosine_factors[i / 3];
}

// From red, green and blue of each coefficient to all of red, all of green, all of blue.
void write_planar(const double* sh, float* planar) {
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) planar[k_harmonics * (i % 3) + i / 3] = static_cast<float>(sh[i]);
}

void write(Lights lights, float nits, sandglass_filament_light* filament) {
  sandglass_filament_light filled = {};
  make_irradiance(lights.sh);
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) filled.sh[i] = static_cast<float>(lights.sh[i]);
  for (int i = 0; i < 3; ++i) filled.direction[i] = static_cast<float>(-lights.towards[i]);
  const double greatest = split_colour(lights.facing, filled.colour);
  filled.intensity = static_cast<float>(k_pi * static_cast<double>(nits) * greatest);
  filled.sh_intensity = nits;
  fill_struct(&filled, sizeof filled, filament);
}

void write(const Lights& lights, sandglass_arkit_light* arkit) {
  sandglass_arkit_light filled = {};
  write_planar(lights.sh, filled.sh);
  for (int i = 0; i < 3; ++i) filled.primary_light_direction[i] = static_cast<float>(-lights.towards[i]);
  rotation_with_z(lights.towards, filled.orientation);
  filled.primary_light_intensity = static_cast<float>(k_neutral_lumens * luminance(lights.facing));
  filled.ambient_intensity = static_cast<float>(k_neutral_lumens * luminance(lights.ambient));
  filled.ambient_colour_temperature = temperature_of(lights.ambient);
  fill_struct(&filled, sizeof filled, arkit);
}

void write(const Lights& lights, sandglass_arcore_light* arcore) {
  sandglass_arcore_light filled = {};
  for (int i = 0; i < 3; ++i) {
    filled.main_light_direction[i] = static_cast<float>(lights.towards[i]);
    filled.main_light_intensity[i] = static_cast<float>(k_pi * lights.facing[i]);
  }
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) filled.sh[i] = static_cast<float>(phase_of(i / 3) * lights.sh[i]);
  fill_struct(&filled, sizeof filled, arcore);
}

void write(Lights lights, sandglass_unity_light* unity) {
  // In a left-handed world z is turned over, and with it the coefficients that are odd in z.
  lights.towards[2] = -lights.towards[2];
  constexpr uint32_t k_odd[3] = {2, 5, 7};
  for (const uint32_t odd : k_odd)
    for (uint32_t c = 0; c < 3; ++c) lights.sh[3 * odd + c] = -lights.sh[3 * odd + c];
  make_irradiance(lights.sh);
  double forward[3];
  sandglass_unity_light filled = {};
  write_planar(lights.sh, filled.sh);
  for (int i = 0; i < 3; ++i) {
    forward[i] = -lights.towards[i];
    filled.forward[i] = static_cast<float>(forward[i]);
  }
  rotation_with_z(forward, filled.rotation);
  filled.intensity = static_cast<float>(split_colour(lights.facing, filled.colour));
  fill_struct(&filled, sizeof filled, unity);
}

// What all conversions have in common; `more` is what the renderer asks for besides.
template <class Renderer, class... More>
sandglass_status convert(const sandglass_light* light, sandglass_light_model model, Renderer* out, const char** reason,
                         More... more) {
  if (light == nullptr)
    return refuse(reason, "light is NULL: pass one of sandglass_light_of_estimator or sandglass_light_of_room.");
  if (out == nullptr) return refuse(reason, "filament, arkit, arcore or unity is NULL: pass the struct to fill.");
  if (!can_fill(out)) return refuse(reason, "the struct to fill has no struct_size: set it to the struct's sizeof.");
  if (light->struct_size < k_light_bytes_min)
    return refuse(reason, "light.struct_size is not set: set it to sizeof(sandglass_light) before it is filled.");
  if (model != SANDGLASS_LIGHT_AMBIENT && model != SANDGLASS_LIGHT_WHOLE)
    return refuse(reason, "model is none of SANDGLASS_LIGHT_AMBIENT and SANDGLASS_LIGHT_WHOLE.");
  if (!usable(*light)) return refuse(reason, "a number of the light is not finite: pass it as it was filled.");
  write(lights_of(*light, model), more..., out);
  return accept(reason);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

sandglass_status sandglass_light_to_filament(const sandglass_light* light, sandglass_light_model model, float nits,
                                             sandglass_filament_light* filament, const char** reason) {
  if (!(nits > 0.0f && nits <= 1e9f)) return refuse(reason, "nits is not a number above 0 and up to 1e9.");
  return convert(light, model, filament, reason, nits);
}
sandglass_status sandglass_light_to_arkit(const sandglass_light* light, sandglass_light_model model,
                                          sandglass_arkit_light* arkit, const char** reason) {
  return convert(light, model, arkit, reason);
}
sandglass_status sandglass_light_to_arcore(const sandglass_light* light, sandglass_light_model model,
                                           sandglass_arcore_light* arcore, const char** reason) {
  return convert(light, model, arcore, reason);
}
sandglass_status sandglass_light_to_unity(const sandglass_light* light, sandglass_light_model model,
                                          sandglass_unity_light* unity, const char** reason) {
  return convert(light, model, unity, reason);
}
