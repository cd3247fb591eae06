// An estimate, or the light of a room, in the terms of renderers. The header states each target's convention; the tests
// evaluate the target's own formula on what comes out.
#include <cstring>

#include "runtime/core/filled_struct.h"
#include "runtime/core/math.h"
#include "runtime/core/refuse.h"
#include "runtime/light/harmonics.h"
#include "runtime/light/luminance.h"

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

// The quaternion of the rotation whose columns are x, y and z (Shepperd's choice of the greatest of four divisors).
void quaternion_of(const double x[3], const double y[3], const double z[3], float q[4]) {
  const double traces[4] = {x[0] - y[1] - z[2], y[1] - x[0] - z[2], z[2] - x[0] - y[1], x[0] + y[1] + z[2]};
  int best = 3;
  for (int i = 0; i < 3; ++i)
    if (traces[i] > traces[best]) best = i;
  const double twice = square_root(1.0 + traces[best]), over = 0.5 / twice;
  const double sums[3] = {y[2] - z[1], z[0] - x[2], x[1] - y[0]};      // 4 w (x, y, z)
  const double products[3] = {x[1] + y[0], y[2] + z[1], z[0] + x[2]};  // 4 (xy, yz, zx)
  double out[4] = {sums[0] * over, sums[1] * over, sums[2] * over, 0.5 * twice};
  if (best < 3) {
    out[best] = 0.5 * twice;
    out[(best + 1) % 3] = products[best] * over;
    out[(best + 2) % 3] = products[(best + 2) % 3] * over;
    out[3] = sums[best] * over;
  }
  for (int i = 0; i < 4; ++i) q[i] = static_cast<float>(out[i]);
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

// What every renderer is told, in double.
struct Lights {
  double towards[3];           // the directional light
  double facing[3];            // the radiance of a white surface that faces it, by it alone
  double ambient[3];           // the radiance of a level white floor, by all other light
  double sh[3 * k_harmonics];  // radiance, interleaved
};

Lights lights_of(const sandglass_light_estimate& estimate, sandglass_light_model model) {
  Lights lights;
  for (int i = 0; i < 3; ++i) {
    lights.towards[i] = static_cast<double>(estimate.direction[i]);
    lights.facing[i] = static_cast<double>(estimate.strength) * static_cast<double>(estimate.light[i]);
    lights.ambient[i] = static_cast<double>(estimate.ambient[i]);
  }
  light_harmonics(estimate, model, lights.sh);
  return lights;
}

Lights lights_of(const sandglass_room_light& light, sandglass_light_model model) {
  Lights lights = {};
  if (model == SANDGLASS_LIGHT_MODEL_AMBIENT) main_light_of(light, lights.facing);
  for (int i = 0; i < 3; ++i) lights.towards[i] = static_cast<double>(light.main_direction[i]);
  for (int i = 0; i < 3; ++i) {
    const double rest = static_cast<double>(light.irradiance[i]) / k_pi - lights.facing[i] * lights.towards[1];
    lights.ambient[i] = rest > 0.0 ? rest : 0.0;
  }
  room_harmonics(light, model, lights.sh);
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

sandglass_status check(const sandglass_light_estimate* estimate, sandglass_light_model model, const char** reason) {
  float unused[27];
  return sandglass_light_harmonics(estimate, model, unused, reason);
}
sandglass_status check(const sandglass_room_light* light, sandglass_light_model model, const char** reason) {
  float unused[27];
  return sandglass_room_harmonics(light, model, unused, reason);
}

void write(Lights lights, float nits, sandglass_light_filament* filament) {
  sandglass_light_filament filled = {};
  make_irradiance(lights.sh);
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) filled.sh[i] = static_cast<float>(lights.sh[i]);
  for (int i = 0; i < 3; ++i) filled.direction[i] = static_cast<float>(-lights.towards[i]);
  const double greatest = split_colour(lights.facing, filled.colour);
  filled.intensity = static_cast<float>(k_pi * static_cast<double>(nits) * greatest);
  filled.sh_intensity = nits;
  fill_struct(&filled, sizeof filled, filament);
}

void write(const Lights& lights, sandglass_light_arkit* arkit) {
  sandglass_light_arkit filled = {};
  write_planar(lights.sh, filled.sh);
  for (int i = 0; i < 3; ++i) filled.primary_light_direction[i] = static_cast<float>(-lights.towards[i]);
  rotation_with_z(lights.towards, filled.orientation);
  filled.primary_light_intensity = static_cast<float>(k_neutral_lumens * luminance(lights.facing));
  filled.ambient_intensity = static_cast<float>(k_neutral_lumens * luminance(lights.ambient));
  filled.ambient_colour_temperature = temperature_of(lights.ambient);
  fill_struct(&filled, sizeof filled, arkit);
}

void write(const Lights& lights, sandglass_light_arcore* arcore) {
  sandglass_light_arcore filled = {};
  for (int i = 0; i < 3; ++i) {
    filled.main_light_direction[i] = static_cast<float>(lights.towards[i]);
    filled.main_light_intensity[i] = static_cast<float>(k_pi * lights.facing[i]);
  }
  // The phase turns the sign of coefficients with odd m: those of odd index.
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i)
    filled.sh[i] = static_cast<float>(i / 3 % 2 == 1 ? -lights.sh[i] : lights.sh[i]);
  fill_struct(&filled, sizeof filled, arcore);
}

void write(Lights lights, sandglass_light_unity* unity) {
  // In a left-handed world z is turned over, and with it the coefficients that are odd in z.
  lights.towards[2] = -lights.towards[2];
  constexpr uint32_t k_odd[3] = {2, 5, 7};
  for (const uint32_t odd : k_odd)
    for (uint32_t c = 0; c < 3; ++c) lights.sh[3 * odd + c] = -lights.sh[3 * odd + c];
  make_irradiance(lights.sh);
  double forward[3];
  sandglass_light_unity filled = {};
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
template <class Source, class Renderer, class... More>
sandglass_status convert(const Source* source, sandglass_light_model model, Renderer* out, const char** reason,
                         More... more) {
  if (out == nullptr) return refuse(reason, "filament, arkit, arcore or unity is NULL: pass the struct to fill");
  if (!can_fill(out)) return refuse(reason, "the struct to fill has no struct_size: set it to the struct's sizeof");
  const sandglass_status status = check(source, model, reason);
  if (status == SANDGLASS_OK) write(lights_of(*source, model), more..., out);
  return status;
}

template <class Source>
sandglass_status to_filament(const Source* source, sandglass_light_model model, float nits,
                             sandglass_light_filament* filament, const char** reason) {
  if (!(nits > 0.0f && nits <= 1e9f)) return refuse(reason, "nits is not a number above 0 and up to 1e9");
  return convert(source, model, filament, reason, nits);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

int32_t sandglass_camera_orientation(const float matrix[16], float orientation[4]) {
  if (orientation == nullptr) return 0;
  if (matrix == nullptr) {
    orientation[0] = orientation[1] = orientation[2] = 0.0f, orientation[3] = 1.0f;
    return 0;
  }
  constexpr double k_tolerance = 1e-3;  // of lengths and right angles
  double axes[3][3];
  bool fine = true;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) axes[i][j] = static_cast<double>(matrix[4 * i + j]);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) {
      const double product = axes[i][0] * axes[j][0] + axes[i][1] * axes[j][1] + axes[i][2] * axes[j][2];
      fine = fine && absolute(product - (i == j ? 1.0 : 0.0)) < k_tolerance;
    }
  const double* x = axes[0];
  const double* y = axes[1];
  const double turned = axes[2][0] * (x[1] * y[2] - x[2] * y[1]) + axes[2][1] * (x[2] * y[0] - x[0] * y[2]) +
                        axes[2][2] * (x[0] * y[1] - x[1] * y[0]);
  fine = fine && turned > 0.0;
  if (fine) quaternion_of(axes[0], axes[1], axes[2], orientation);
  else orientation[0] = orientation[1] = orientation[2] = 0.0f, orientation[3] = 1.0f;
  return fine ? 1 : 0;
}

sandglass_status sandglass_light_to_filament(const sandglass_light_estimate* estimate, sandglass_light_model model,
                                             float nits, sandglass_light_filament* filament, const char** reason) {
  return to_filament(estimate, model, nits, filament, reason);
}
sandglass_status sandglass_room_to_filament(const sandglass_room_light* light, sandglass_light_model model, float nits,
                                            sandglass_light_filament* filament, const char** reason) {
  return to_filament(light, model, nits, filament, reason);
}
sandglass_status sandglass_light_to_arkit(const sandglass_light_estimate* estimate, sandglass_light_model model,
                                          sandglass_light_arkit* arkit, const char** reason) {
  return convert(estimate, model, arkit, reason);
}
sandglass_status sandglass_room_to_arkit(const sandglass_room_light* light, sandglass_light_model model,
                                         sandglass_light_arkit* arkit, const char** reason) {
  return convert(light, model, arkit, reason);
}
sandglass_status sandglass_room_to_arcore(const sandglass_room_light* light, sandglass_light_model model,
                                          sandglass_light_arcore* arcore, const char** reason) {
  return convert(light, model, arcore, reason);
}
sandglass_status sandglass_light_to_unity(const sandglass_light_estimate* estimate, sandglass_light_model model,
                                          sandglass_light_unity* unity, const char** reason) {
  return convert(estimate, model, unity, reason);
}
sandglass_status sandglass_room_to_unity(const sandglass_room_light* light, sandglass_light_model model,
                                         sandglass_light_unity* unity, const char** reason) {
  return convert(light, model, unity, reason);
}
