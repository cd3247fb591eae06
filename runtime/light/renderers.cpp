// The estimate in the terms of three renderers. Each function states its target's convention; the tests evaluate the
// target's own formula on what comes out.
#include <cstring>

#include "runtime/core/filled_struct.h"
#include "runtime/core/math.h"
#include "runtime/core/refuse.h"
#include "runtime/light/harmonics.h"

namespace sandglass {
namespace {

constexpr float k_neutral_lumens = 1000.0f;
constexpr double k_coldest = 40000.0, k_warmest = 1000.0, k_white = 6500.0;  // kelvin

float luminance(const float c[3]) { return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2]; }

float greatest_of(const float c[3]) {
  const float two = c[0] > c[1] ? c[0] : c[1];
  return two > c[2] ? two : c[2];
}

// Splits a light into a colour whose greatest channel is 1, and that channel. Black becomes white of intensity 0.
float split_colour(const float c[3], float colour[3]) {
  const float greatest = greatest_of(c);
  for (int i = 0; i < 3; ++i) colour[i] = greatest > 0.0f ? c[i] / greatest : 1.0f;
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
float temperature_of(const float c[3]) {
  const double r = static_cast<double>(c[0]), g = static_cast<double>(c[1]), b = static_cast<double>(c[2]);
  const double x = 0.4124564 * r + 0.3575761 * g + 0.1804375 * b, y = 0.2126729 * r + 0.7151522 * g + 0.0721750 * b,
               z = 0.0193339 * r + 0.1191920 * g + 0.9503041 * b, sum = x + y + z;
  if (!(sum > 0.0)) return static_cast<float>(k_white);
  const double below = 0.1858 - y / sum;
  if (!(absolute(below) > 1e-6)) return static_cast<float>(k_coldest);
  const double n = (x / sum - 0.3320) / below;
  const double kelvin = ((449.0 * n + 3525.0) * n + 6823.3) * n + 5520.33;
  return static_cast<float>(kelvin < k_warmest ? k_warmest : kelvin > k_coldest ? k_coldest : kelvin);
}

// Irradiance over pi, as factors of the polynomials of harmonic_polynomials.
void irradiance_polynomial(const sandglass_light_estimate& estimate, sandglass_light_model model, double* polynomial) {
  light_harmonics(estimate, model, polynomial);
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) polynomial[i] *= k_harmonic_factors[i / 3] * k_cosine_factors[i / 3];
}

sandglass_status check(const sandglass_light_estimate* estimate, sandglass_light_model model, const void* out,
                       const char** reason) {
  if (out == nullptr) return refuse(reason, "filament, arkit or unity is NULL: pass the struct to fill");
  if (!can_fill(out)) return refuse(reason, "the struct to fill has no struct_size: set it to the struct's sizeof");
  float unused[27];
  return sandglass_light_harmonics(estimate, model, unused, reason);
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
  const sandglass_status status = check(estimate, model, filament, reason);
  if (status != SANDGLASS_OK) return status;
  if (!(nits > 0.0f && nits <= 1e9f)) return refuse(reason, "nits is not a number above 0 and up to 1e9");
  double polynomial[3 * k_harmonics];
  irradiance_polynomial(*estimate, model, polynomial);
  sandglass_light_filament filled = {};
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) filled.sh[i] = static_cast<float>(polynomial[i]);
  for (int i = 0; i < 3; ++i) filled.direction[i] = -estimate->direction[i];
  const float greatest = split_colour(estimate->light, filled.colour);
  filled.intensity = static_cast<float>(k_pi) * nits * estimate->strength * greatest;
  filled.sh_intensity = nits;
  fill_struct(&filled, sizeof filled, filament);
  return SANDGLASS_OK;
}

sandglass_status sandglass_light_to_arkit(const sandglass_light_estimate* estimate, sandglass_light_model model,
                                          sandglass_light_arkit* arkit, const char** reason) {
  const sandglass_status status = check(estimate, model, arkit, reason);
  if (status != SANDGLASS_OK) return status;
  double sh[3 * k_harmonics], towards[3];
  sandglass_light_arkit filled = {};
  light_harmonics(*estimate, model, sh);
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) filled.sh[k_harmonics * (i % 3) + i / 3] = static_cast<float>(sh[i]);
  for (int i = 0; i < 3; ++i) {
    filled.primary_light_direction[i] = -estimate->direction[i];
    towards[i] = static_cast<double>(estimate->direction[i]);
  }
  rotation_with_z(towards, filled.orientation);
  filled.primary_light_intensity = k_neutral_lumens * estimate->strength * luminance(estimate->light);
  filled.ambient_intensity = k_neutral_lumens * luminance(estimate->ambient);
  filled.ambient_colour_temperature = temperature_of(estimate->ambient);
  fill_struct(&filled, sizeof filled, arkit);
  return SANDGLASS_OK;
}

sandglass_status sandglass_light_to_unity(const sandglass_light_estimate* estimate, sandglass_light_model model,
                                          sandglass_light_unity* unity, const char** reason) {
  const sandglass_status status = check(estimate, model, unity, reason);
  if (status != SANDGLASS_OK) return status;
  // The light in a left-handed world: z is turned over.
  sandglass_light_estimate mirrored = {};
  memcpy(&mirrored, estimate, k_least_estimate_bytes);
  mirrored.direction[2] = -mirrored.direction[2];
  double polynomial[3 * k_harmonics], forward[3];
  sandglass_light_unity filled = {};
  irradiance_polynomial(mirrored, model, polynomial);
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i)
    filled.sh[k_harmonics * (i % 3) + i / 3] = static_cast<float>(polynomial[i]);
  for (int i = 0; i < 3; ++i) {
    filled.forward[i] = -mirrored.direction[i];
    forward[i] = static_cast<double>(filled.forward[i]);
  }
  rotation_with_z(forward, filled.rotation);
  filled.intensity = estimate->strength * split_colour(estimate->light, filled.colour);
  fill_struct(&filled, sizeof filled, unity);
  return SANDGLASS_OK;
}
