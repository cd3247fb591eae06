#include "tests/laboratory/room/floor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/baking/truth.h"
#include "models/tracing/embree_scene.h"
#include "runtime/core/harmonics.h"
#include "runtime/core/random.h"

namespace sandglass::host {

namespace {

constexpr double k_pi_double = std::numbers::pi;
constexpr double k_half_light = 10.0 * k_pi_double / 180.0;
constexpr uint64_t k_point_stream = 100'061;

uint32_t fine_of(Vec3 d) {
  constexpr uint32_t k_sectors = k_cell_sectors * k_strata_side, k_rings = k_cell_rings * k_strata_side;
  const double turns = std::atan2(d.z, d.x) / (2.0 * k_pi_double);
  const auto sector = static_cast<uint32_t>((turns - std::floor(turns)) * k_sectors) % k_sectors;
  const uint32_t ring = std::min(static_cast<uint32_t>(d.y * d.y * k_rings), k_rings - 1);
  const uint32_t stratum = ring % k_strata_side * k_strata_side + sector % k_strata_side;
  return cell_of(d) * k_cell_strata + stratum;
}

uint32_t sphere_part(Vec3 d) {
  const double turns = std::atan2(d.z, d.x) / (2.0 * k_pi_double), up = std::asin(std::clamp(d.y, -1.0, 1.0));
  const auto column = static_cast<uint32_t>((turns - std::floor(turns)) * k_sphere_columns) % k_sphere_columns;
  const auto row = static_cast<uint32_t>((up / k_pi_double + 0.5) * k_sphere_rows);
  return std::min(row, k_sphere_rows - 1) * k_sphere_columns + column;
}

std::array<double, 9> harmonics_of(Vec3 d) {
  const double v[3] = {d.x, d.y, d.z};
  std::array<double, 9> values;
  harmonic_polynomials(v, values.data());
  for (size_t j = 0; j < 9; ++j) values[j] *= k_harmonic_factors[j];
  return values;
}

// The irradiance of each point of a surface in each of the nine harmonics, from the cosines that it sees.
std::vector<std::array<double, 9>> transfer_of(const std::vector<float>& facing) {
  std::vector<std::array<double, 9>> transfer(facing.size() / k_sphere, std::array<double, 9>{});
  for (uint32_t i = 0; i < k_sphere; ++i) {
    const double row = i / k_sphere_columns, low = std::sin(k_pi_double * (row / k_sphere_rows - 0.5));
    const double high = std::sin(k_pi_double * ((row + 1) / k_sphere_rows - 0.5));
    const double omega = 2.0 * k_pi_double / k_sphere_columns * (high - low);
    const std::array<double, 9> y = harmonics_of(sphere_direction(row + 0.5, i % k_sphere_columns + 0.5));
    for (size_t p = 0; p < transfer.size(); ++p)
      for (size_t j = 0; j < 9; ++j) transfer[p][j] += omega * y[j] * static_cast<double>(facing[p * k_sphere + i]);
  }
  return transfer;
}

}  // namespace

Vec3 sphere_direction(double row, double column) {
  const double up = k_pi_double * (row / k_sphere_rows - 0.5), around = 2.0 * k_pi_double * column / k_sphere_columns;
  return {std::cos(up) * std::cos(around), std::sin(up), std::cos(up) * std::sin(around)};
}

Vec3 fine_direction(uint32_t fine) {
  return cell_direction(fine / k_cell_strata, (fine % k_strata_side + 0.5) / k_strata_side,
                        (fine % k_cell_strata / k_strata_side + 0.5) / k_strata_side);
}

Vec3 floor_radiance(const RadianceMap& panorama, Vec3 foot, double around) {
  constexpr int k_points = 256;
  constexpr double k_golden = 2.399963229728653;
  Vec3 sum;
  for (int i = 0; i < k_points; ++i) {
    const double r = around * std::sqrt((i + 0.5) / k_points);
    sum = sum + look_up(panorama, foot + Vec3{r * std::cos(k_golden * i), 0, r * std::sin(k_golden * i)});
  }
  return sum * (1.0 / k_points);
}

TrueLight true_light(const RadianceMap& panorama, Vec3 place) {
  TrueLight light = {};
  Fine sums = {};
  const double below = luminance(floor_radiance(panorama, place, k_around_foot));
  for (int v = 0; v < panorama.height; ++v) {
    const double omega = pixel_solid_angle(v, panorama.width, panorama.height);
    for (int u = 0; u < panorama.width; ++u) {
      const Vec3 d = panorama_direction(u, v, panorama.width, panorama.height), q = d - place;
      const double distance = length(q), solid = omega * (1 - dot(d, place)) / std::pow(distance, 3);
      light.sphere[sphere_part(q * (1 / distance))] += solid * (q.y > 0 ? luminance(panorama.colour(u, v)) : below);
      if (!(q.y > 0)) continue;
      const double facing = solid * q.y / distance;
      const Vec3 colour = panorama.colour(u, v);
      sums[fine_of(q * (1 / distance))] += facing * luminance(colour);
      light.irradiance = light.irradiance + colour * facing;
    }
  }
  double total = 0;
  for (const double s : sums) total += s;
  for (uint32_t f = 0; f < k_fine; ++f) {
    light.shares[f] = sums[f] / total;
    light.cells[f / k_cell_strata] += light.shares[f];
  }
  return light;
}

FloorObject::FloorObject(std::string name, const Mesh& source, uint64_t seed, ThreadPool* pool)
    : name_(std::move(name)) {
  const StandingObject standing = stand_on_plane(source, name_);
  const Mesh& mesh = standing.mesh;
  const double height = standing.box.height;
  const EmbreeScene caster = EmbreeScene::triangles(mesh.vertices, mesh.indices);
  hidden_ = trace_hidden(caster, {2 * height, k_texels}, HiddenOf::strata, seed, *pool, [](uint32_t) { return true; });
  hidden_cells_.assign(hidden_.size() / k_cell_strata, 0.0f);
  for (size_t i = 0; i < hidden_.size(); ++i) hidden_cells_[i / k_cell_strata] += hidden_[i] / k_cell_strata;

  // Points of the surface, by area, and what each sees.
  std::vector<double> areas;
  const auto corner = [&mesh](uint32_t triangle, uint32_t k) {
    const float* v =
        mesh.vertices.data() + 3 * static_cast<size_t>(mesh.indices[3 * static_cast<size_t>(triangle) + k]);
    return Vec3{v[0], v[1], v[2]};
  };
  for (uint32_t t = 0; t < mesh.triangle_count(); ++t)
    areas.push_back((areas.empty() ? 0.0 : areas.back()) +
                    length(cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0))));
  facing_.assign(static_cast<size_t>(k_points) * k_sphere, 0.0f);
  pool->run(k_points, [&](uint32_t point) {
    Random random = random_stream(seed, k_point_stream + point);
    const double at = random.uniform() * areas.back();
    const auto t = static_cast<uint32_t>(std::upper_bound(areas.begin(), areas.end(), at) - areas.begin());
    double a = random.uniform(), b = random.uniform();
    if (a + b > 1) a = 1 - a, b = 1 - b;
    const Vec3 edge = corner(t, 1) - corner(t, 0), other = corner(t, 2) - corner(t, 0);
    const Vec3 normal = normalised(cross(edge, other));
    const Vec3 from = corner(t, 0) + edge * a + other * b + normal * (1e-4 * height);
    for (uint32_t i = 0; i < k_sphere; ++i) {
      const double column = i % k_sphere_columns + random.uniform(), row = i / k_sphere_columns + random.uniform();
      const Vec3 d = sphere_direction(row, column);
      const double facing = dot(d, normal);
      if (facing > 0 && !caster.occluded(from, d, 1e3 * height))
        facing_[static_cast<size_t>(point) * k_sphere + i] = static_cast<float>(facing);
    }
  });
  transfer_ = transfer_of(facing_);
}

std::vector<float> FloorObject::lit(const TrueLight& light) const {
  std::vector<float> irradiance(k_points);
  for (size_t p = 0; p < irradiance.size(); ++p) {
    double sum = 0;
    for (uint32_t i = 0; i < k_sphere; ++i) sum += light.sphere[i] * static_cast<double>(facing_[p * k_sphere + i]);
    irradiance[p] = static_cast<float>(sum / luminance(light.irradiance));
  }
  return irradiance;
}

std::vector<float> FloorObject::lit(const std::array<double, 9>& harmonics, double floor_irradiance) const {
  std::vector<float> irradiance(k_points);
  for (size_t p = 0; p < irradiance.size(); ++p) {
    double sum = 0;
    for (size_t j = 0; j < 9; ++j) sum += transfer_[p][j] * harmonics[j];
    irradiance[p] = static_cast<float>(std::max(sum, 0.0) / floor_irradiance);
  }
  return irradiance;
}

std::vector<float> FloorObject::hidden(Vec3 direction) const {
  std::vector<uint32_t> parts;
  for (uint32_t f = 0; f < k_fine; ++f)
    if (dot(fine_direction(f), direction) > std::cos(k_half_light)) parts.push_back(f);
  std::vector<float> sums(static_cast<size_t>(k_texels) * k_texels, 0.0f);
  for (size_t texel = 0; texel < sums.size(); ++texel) {
    for (const uint32_t f : parts) sums[texel] += hidden_[texel * k_fine + f];
    if (!parts.empty()) sums[texel] /= static_cast<float>(parts.size());
  }
  return sums;
}

std::vector<float> FloorObject::truth(const TrueLight& light) const {
  std::vector<float> ratio(static_cast<size_t>(k_texels) * k_texels);
  for (size_t texel = 0; texel < ratio.size(); ++texel) {
    double lost = 0;
    for (uint32_t f = 0; f < k_fine; ++f) lost += light.shares[f] * static_cast<double>(hidden_[texel * k_fine + f]);
    ratio[texel] = static_cast<float>(1 - lost);
  }
  return ratio;
}

std::vector<float> FloorObject::drawn(const Cells& cells, double share, Vec3 direction) const {
  std::vector<float> sharp, ratio(static_cast<size_t>(k_texels) * k_texels);
  if (share > 0) sharp = hidden(direction);
  for (size_t texel = 0; texel < ratio.size(); ++texel) {
    double lost = share > 0 ? share * static_cast<double>(sharp[texel]) : 0.0;
    for (uint32_t i = 0; i < k_light_cells; ++i)
      lost += cells[i] * static_cast<double>(hidden_cells_[texel * k_light_cells + i]);
    ratio[texel] = static_cast<float>(1 - lost);
  }
  return ratio;
}

double error_of(const std::vector<float>& drawn, const std::vector<float>& truth) {
  double sum = 0;
  for (size_t i = 0; i < drawn.size(); ++i) {
    const double difference = static_cast<double>(drawn[i]) - static_cast<double>(truth[i]);
    sum += difference * difference;
  }
  return std::sqrt(sum / static_cast<double>(drawn.size()));
}

}  // namespace sandglass::host
