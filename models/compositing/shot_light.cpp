#include "models/compositing/shot_light.h"

#include <algorithm>
#include <cmath>

#include "models/baking/light_cells.h"
#include "runtime/light/harmonics.h"
#include "runtime/light/renderers/lighting.h"

namespace sandglass::host {

namespace {

constexpr double k_cosine_min = 0.1;  // a lower light would have to be brighter than any is

std::array<double, k_harmonics> harmonics_at(Vec3 d) {
  const double v[3] = {d.x, d.y, d.z};
  std::array<double, k_harmonics> values;
  harmonic_polynomials(v, values.data());
  for (uint32_t j = 0; j < k_harmonics; ++j) values[j] *= k_harmonic_factors[j];
  return values;
}

ShotLight dark() {
  ShotLight light = {};
  light.struct_size = sizeof light;
  light.valid = 1;
  light.main_direction[1] = 1.0f;
  light.white = 1.0f;
  for (float& c : light.main_colour) c = 1.0f;
  return light;
}

// The radiance of the main light's facing surface, for each colour.
Vec3 main_facing(const ShotLight& light) {
  double facing[3];
  main_light_of(light, facing);
  return {facing[0], facing[1], facing[2]};
}

}  // namespace

Vec3 mean_direction_of(const ShotLight& light) {
  Vec3 sum = main_direction_of(light) * static_cast<double>(light.main_share);
  for (uint32_t i = 0; i < k_light_cells; ++i)
    sum = sum + cell_direction(i, 0.5, 0.5) * static_cast<double>(light.ambient_cells[i]);
  return length(sum) > 0.0 ? normalised(sum) : Vec3{0, 1, 0};
}

Vec3 shown_by(const ShotLight& light, Vec3 normal) {
  const std::array<double, k_harmonics> y = harmonics_at(normal);
  Vec3 sum;
  for (uint32_t j = 0; j < k_harmonics; ++j) sum = sum + from_floats(light.sh + 3 * j) * (k_cosine_factors[j] * y[j]);
  return {std::max(sum.x, 0.0), std::max(sum.y, 0.0), std::max(sum.z, 0.0)};
}

Vec3 main_in_harmonics(const ShotLight& light, Vec3 normal) {
  const double c = dot(normal, main_direction_of(light));
  return main_facing(light) * std::max(0.0, 0.25 + 0.5 * c + 5.0 / 32.0 * (3.0 * c * c - 1.0));
}

Vec3 main_by_cosine(const ShotLight& light, Vec3 normal) {
  return main_facing(light) * std::max(0.0, dot(normal, main_direction_of(light)));
}

Vec3 from_floor(const ShotLight& light, Vec3 normal) { return from_floats(light.floor) * (0.5 * (1.0 - normal.y)); }

ShotLight light_of(const RadianceMap& panorama, View view) {
  ShotLight light = dark();
  const ViewRotation rotation(view);
  std::array<double, k_light_cells> cells = {};
  std::array<Vec3, k_harmonics> sh = {};
  Vec3 irradiance;
  for (int v = 0; v < panorama.height; ++v) {
    const double omega = pixel_solid_angle(v, panorama.width, panorama.height);
    for (int u = 0; u < panorama.width; ++u) {
      const Vec3 d = rotation.to_panorama(panorama_direction(u, v, panorama.width, panorama.height));
      const Vec3 colour = panorama.colour(u, v);
      const std::array<double, k_harmonics> y = harmonics_at(d);
      for (uint32_t j = 0; j < k_harmonics; ++j) sh[j] = sh[j] + colour * (omega * y[j]);
      if (!(d.y > 0.0)) continue;
      irradiance = irradiance + colour * (omega * d.y);
      cells[cell_of(d)] += luminance(colour) * omega * d.y;
    }
  }
  const double all = luminance(irradiance);
  for (uint32_t i = 0; i < k_light_cells; ++i)
    light.cells[i] = light.ambient_cells[i] =
        all > 0.0 ? static_cast<float>(cells[i] / all) : k_prior_ring_shares[i / k_cell_sectors];
  for (uint32_t j = 0; j < k_harmonics; ++j) to_floats(sh[j], light.sh + 3 * j);
  to_floats(irradiance, light.irradiance);
  light.seen = 1.0f;
  return light;
}

ShotLight light_above_floor(const RadianceMap& panorama, View view, Vec3 floor) {
  ShotLight light = light_of(above_horizon(panorama, view), view);
  to_floats(floor, light.floor);
  for (uint32_t j = 0; j < 2; ++j)
    to_floats(from_floats(light.sh + 3 * j) + floor * k_below_harmonics[j], light.sh + 3 * j);
  return light;
}

ShotLight one_light(Vec3 towards, double share, Vec3 irradiance) {
  ShotLight light = dark();
  const Vec3 d = normalised(towards);
  share = d.y > 0.0 ? share : 0.0;
  to_floats(d, light.main_direction);
  to_floats(irradiance, light.irradiance);
  light.main_share = static_cast<float>(share);
  const std::array<double, k_harmonics> y = harmonics_at(d);
  for (uint32_t j = 0; j < k_harmonics; ++j) {
    const double direct = share / std::max(d.y, k_cosine_min) * y[j];
    const double even = j == 0 ? (1.0 - share) * 4.0 * k_harmonic_factors[0] : 0.0;
    to_floats(irradiance * (direct + even), light.sh + 3 * j);
  }
  return light;
}

ShotLight one_light(const sandglass_estimator_light& e) {
  ShotLight light = dark();
  const Vec3 d = normalised(from_floats(e.direction));
  std::copy_n(e.sh, 27, light.sh);
  to_floats(d, light.main_direction);
  light.main_share = d.y > 0.0 ? e.contrast : 0.0f;
  to_floats(shown_by(light, {0, 1, 0}) * k_pi, light.irradiance);
  return light;
}

ShotLight scaled(ShotLight light, double factor) {
  for (float& c : light.sh) c = static_cast<float>(factor * static_cast<double>(c));
  for (float& e : light.irradiance) e = static_cast<float>(factor * static_cast<double>(e));
  for (float& f : light.floor) f = static_cast<float>(factor * static_cast<double>(f));
  return light;
}

ShotLight mirrored(const ShotLight& light) {
  ShotLight out = light;
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    const uint32_t from = mirrored_cell(i);
    out.cells[i] = light.cells[from];
    out.ambient_cells[i] = light.ambient_cells[from];
  }
  out.main_direction[2] = -light.main_direction[2];
  for (const uint32_t odd : {2u, 5u, 7u})  // the polynomials with an odd power of z
    for (uint32_t c = 0; c < 3; ++c) out.sh[3 * odd + c] = -light.sh[3 * odd + c];
  return out;
}

ShotLight mean_light(std::span<const ShotLight> lights) {
  ShotLight mean = dark();
  double level = 0.0;
  Vec3 irradiance, floor;
  std::array<double, 27> sh = {};
  const double n = static_cast<double>(lights.size());
  for (const ShotLight& light : lights) {
    const double all = luminance(irradiance_of(light));
    level += std::log(all) / n;
    irradiance = irradiance + irradiance_of(light) * (1.0 / (all * n));
    floor = floor + from_floats(light.floor) * (1.0 / (all * n));
    for (size_t i = 0; i < sh.size(); ++i) sh[i] += static_cast<double>(light.sh[i]) / (all * n);
    for (uint32_t i = 0; i < k_light_cells; ++i) mean.cells[i] += static_cast<float>(1.0 / n) * light.cells[i];
  }
  std::copy_n(mean.cells, k_light_cells, mean.ambient_cells);
  to_floats(irradiance * std::exp(level), mean.irradiance);
  to_floats(floor * std::exp(level), mean.floor);
  for (size_t i = 0; i < sh.size(); ++i) mean.sh[i] = static_cast<float>(sh[i] * std::exp(level));
  return mean;
}

}  // namespace sandglass::host
