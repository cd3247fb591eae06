#include "tests/laboratory/room/floor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/baking/truth.h"
#include "models/tracing/embree_scene.h"

namespace sandglass::host {

namespace {

constexpr double k_pi_double = std::numbers::pi;
constexpr double k_half_light = 10.0 * k_pi_double / 180.0;

uint32_t fine_of(Vec3 d) {
  constexpr uint32_t k_sectors = k_cell_sectors * k_strata_side, k_rings = k_cell_rings * k_strata_side;
  const double turns = std::atan2(d.z, d.x) / (2.0 * k_pi_double);
  const auto sector = static_cast<uint32_t>((turns - std::floor(turns)) * k_sectors) % k_sectors;
  const uint32_t ring = std::min(static_cast<uint32_t>(d.y * d.y * k_rings), k_rings - 1);
  const uint32_t stratum = ring % k_strata_side * k_strata_side + sector % k_strata_side;
  return cell_of(d) * k_cell_strata + stratum;
}

}  // namespace

Vec3 fine_direction(uint32_t fine) {
  return cell_direction(fine / k_cell_strata, (fine % k_strata_side + 0.5) / k_strata_side,
                        (fine % k_cell_strata / k_strata_side + 0.5) / k_strata_side);
}

TrueLight true_light(const RadianceMap& panorama, Vec3 place) {
  TrueLight light = {};
  Fine sums = {};
  for (int v = 0; v < panorama.height; ++v) {
    const double omega = pixel_solid_angle(v, panorama.width, panorama.height);
    for (int u = 0; u < panorama.width; ++u) {
      const Vec3 d = panorama_direction(u, v, panorama.width, panorama.height), q = d - place;
      if (!(q.y > 0)) continue;
      const double distance = length(q);
      const double facing = omega * (1 - dot(d, place)) / std::pow(distance, 3) * q.y / distance;
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

FloorObject::FloorObject(const std::string& name, const Mesh& source, uint64_t seed, ThreadPool* pool) {
  const StandingObject standing = stand_on_plane(source, name);
  const Mesh& mesh = standing.mesh;
  const double height = standing.box.height;
  const EmbreeScene caster = EmbreeScene::triangles(mesh.vertices, mesh.indices);
  hidden_ = trace_hidden(caster, {2 * height, k_texels}, HiddenOf::strata, seed, *pool, [](uint32_t) { return true; });
  hidden_cells_.assign(hidden_.size() / k_cell_strata, 0.0f);
  for (size_t i = 0; i < hidden_.size(); ++i) hidden_cells_[i / k_cell_strata] += hidden_[i] / k_cell_strata;
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
