#include "runtime/light/renderers/lighting.h"

#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/light/harmonics.h"
#include "runtime/light/luminance.h"
#include "runtime/math/finite.h"
#include "runtime/math/math.h"

namespace sandglass {

namespace {

constexpr double k_elevation_min = 0.1;

bool usable(const sandglass_estimator_light& e) {
  return is_finite(e.strength) && all_finite(e.direction, 3) && all_finite(e.light, 3) && all_finite(e.ambient, 3) &&
         all_finite(e.sh, 3 * k_harmonics);
}
bool usable(const sandglass_room_light& l) {
  return is_finite(l.main_share) && all_finite(l.main_direction, 3) && all_finite(l.main_colour, 3) &&
         all_finite(l.irradiance, 3) && all_finite(l.sh, 3 * k_harmonics);
}
bool usable(const sandglass_harmonics& h) {
  const float* d = h.main_direction;
  return all_finite(h.sh, 3 * k_harmonics) && all_finite(d, 3) && all_finite(h.main_irradiance, 3) &&
         (h.kind == SANDGLASS_HARMONICS_TOTAL || d[0] != 0 || d[1] != 0 || d[2] != 0);
}

sandglass_light light_from(const sandglass_estimator_light& estimate) {
  sandglass_light light = {};
  const double up = static_cast<double>(estimate.direction[1]);
  for (int c = 0; c < 3; ++c) {
    const double even = k_pi * static_cast<double>(estimate.ambient[c]);
    const double facing = k_pi * static_cast<double>(estimate.strength) * static_cast<double>(estimate.light[c]);
    light.towards[c] = estimate.direction[c];
    light.facing[c] = static_cast<float>(facing);
    light.floor[c] = static_cast<float>(even + (up > 0.0 ? facing * up : 0.0));
    light.ambient_sh[c] = static_cast<float>(even * 4.0 * k_harmonic_factors[0]);
  }
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) light.whole_sh[i] = estimate.sh[i];
  return light;
}

sandglass_light light_from(const sandglass_room_light& room_light) {
  sandglass_light light = {};
  double axis[3], polynomials[k_harmonics], facing[3];
  for (int i = 0; i < 3; ++i) axis[i] = static_cast<double>(room_light.main_direction[i]);
  harmonic_polynomials(axis, polynomials);
  main_light_of(room_light, facing);
  for (int c = 0; c < 3; ++c) {
    light.towards[c] = room_light.main_direction[c];
    light.facing[c] = static_cast<float>(k_pi * facing[c]);
    light.floor[c] = room_light.irradiance[c];
  }
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) {
    const double main = k_pi * facing[i % 3] * k_harmonic_factors[i / 3] * polynomials[i / 3];
    light.ambient_sh[i] = static_cast<float>(static_cast<double>(room_light.sh[i]) - main);
    light.whole_sh[i] = room_light.sh[i];
  }
  return light;
}

sandglass_light light_from(const sandglass_harmonics& given) {
  sandglass_light light = {};
  const bool main = given.kind == SANDGLASS_HARMONICS_AMBIENT;
  double towards[3] = {0, 1, 0}, level[k_harmonics], polynomials[k_harmonics], squared = 0;
  harmonic_polynomials(towards, level);
  for (const float d : given.main_direction) squared += static_cast<double>(d) * static_cast<double>(d);
  for (int i = 0; main && i < 3; ++i) towards[i] = static_cast<double>(given.main_direction[i]) / square_root(squared);
  harmonic_polynomials(towards, polynomials);
  for (uint32_t c = 0; c < 3; ++c) {
    const double facing = main ? static_cast<double>(given.main_irradiance[c]) : 0;
    double floor = towards[1] > 0 ? towards[1] * facing : 0;
    for (uint32_t j = 0, i = c; j < k_harmonics; ++j, i += 3) {
      const double sh = (given.with_phase == 1 ? phase_of(j) : 1) * static_cast<double>(given.sh[i]);
      light.ambient_sh[i] = static_cast<float>(sh);
      light.whole_sh[i] = static_cast<float>(sh + facing * k_harmonic_factors[j] * polynomials[j]);
      floor += k_pi * k_cosine_factors[j] * k_harmonic_factors[j] * level[j] * sh;
    }
    light.towards[c] = static_cast<float>(towards[c]);
    light.facing[c] = static_cast<float>(facing);
    light.floor[c] = floor > 0 ? static_cast<float>(floor) : 0;
  }
  return light;
}

// What the sources have in common: `null`, `size` and `number` say what is wrong with them.
template <class Source>
sandglass_status make(const Source* source, uint32_t bytes_min, sandglass_light* light, const char** reason,
                      const char* null, const char* size, const char* number) {
  if (source == nullptr || light == nullptr) return refuse(reason, null);
  if (!can_fill(light)) return refuse(reason, "light.struct_size is not set: set it to sizeof(sandglass_light).");
  if (source->struct_size < bytes_min) return refuse(reason, size);
  if (!usable(*source)) return refuse(reason, number);
  sandglass_light filled = light_from(*source);
  fill_struct(&filled, sizeof filled, light);
  return accept(reason);
}

}  // namespace

bool usable(const sandglass_light& l) {
  return all_finite(l.towards, 3) && all_finite(l.facing, 3) && all_finite(l.floor, 3) &&
         all_finite(l.ambient_sh, 3 * k_harmonics) && all_finite(l.whole_sh, 3 * k_harmonics);
}

void main_light_of(const sandglass_room_light& light, double facing[3]) {
  double irradiance[3];
  for (int c = 0; c < 3; ++c) irradiance[c] = static_cast<double>(light.irradiance[c]);
  const double up = static_cast<double>(light.main_direction[1]);
  const double elevation = up > k_elevation_min ? up : k_elevation_min;
  const double level = static_cast<double>(light.main_share) * luminance(irradiance) / (k_pi * elevation);
  for (int c = 0; c < 3; ++c) facing[c] = level * static_cast<double>(light.main_colour[c]);
}

}  // namespace sandglass

using namespace sandglass;

sandglass_status sandglass_light_of_estimator(const sandglass_estimator_light* estimate, sandglass_light* light,
                                              const char** reason) {
  return make(
      estimate, k_estimate_bytes_min, light, reason,
      "estimate or light is NULL: pass an estimate of sandglass_estimator_get and the struct to fill",
      "estimate.struct_size is not set: set it to sizeof(sandglass_estimator_light) before sandglass_estimator_get",
      "a number of the estimate is not finite: pass an estimate as sandglass_estimator_get fills it");
}

sandglass_status sandglass_light_of_room(const sandglass_room_light* room_light, sandglass_light* light,
                                         const char** reason) {
  return make(room_light, k_room_light_bytes_min, light, reason,
              "room_light or light is NULL: pass a light of sandglass_room_get and the struct to fill",
              "room_light.struct_size is not set: set it to sizeof(sandglass_room_light) before sandglass_room_get",
              "a number of the light is not finite: pass a light as sandglass_room_get fills it");
}

sandglass_status sandglass_light_of_harmonics(const sandglass_harmonics* harmonics, sandglass_light* light,
                                              const char** reason) {
  return make(harmonics, sizeof(sandglass_harmonics), light, reason,
              "harmonics or light is NULL: pass what a system reports of the light and the struct to fill",
              "harmonics.struct_size is not set: start from sandglass_harmonics_default",
              "a number of the harmonics is not finite, or main_direction is 0: pass them as the system reports them");
}

sandglass_status sandglass_light_adapt(const sandglass_light* light, float strength, int32_t keep_chroma,
                                       sandglass_light* adapted, const char** reason) {
  if (light == nullptr || adapted == nullptr)
    return refuse(reason, "light or adapted is NULL: pass a light that was filled and the struct to fill.");
  if (!can_fill(adapted)) return refuse(reason, "adapted.struct_size is not set: set it to sizeof(sandglass_light).");
  if (light->struct_size < k_light_bytes_min)
    return refuse(reason, "light.struct_size is not set: pass a light that was filled.");
  if (!usable(*light)) return refuse(reason, "a number of the light is not finite: pass it as it was filled.");
  if (!within(strength, 0.0f, 1.0f) || keep_chroma < 0 || keep_chroma > 1)
    return refuse(reason, "strength is not in 0..1, or keep_chroma not 0 or 1.");
  constexpr double k_even = 4 * k_pi * 0.28209479177387814;  // coefficient 0 of radiance 1
  const auto adapt = [&](float colour[3], double white) {
    const auto grey = static_cast<float>(luminance(colour));
    for (int c = 0; c < 3; ++c) {
      const float of_room = keep_chroma != 0 ? grey : colour[c];
      colour[c] = strength * of_room + (1 - strength) * static_cast<float>(white);
    }
  };
  sandglass_light out = {};
  __builtin_memcpy(&out, light, light->struct_size < sizeof out ? light->struct_size : sizeof out);
  adapt(out.facing, 0);
  adapt(out.floor, k_pi);
  for (uint32_t i = 0; i < k_harmonics; ++i) {
    adapt(out.ambient_sh + 3 * i, i == 0 ? k_even : 0);
    adapt(out.whole_sh + 3 * i, i == 0 ? k_even : 0);
  }
  fill_struct(&out, sizeof out, adapted);
  return accept(reason);
}
