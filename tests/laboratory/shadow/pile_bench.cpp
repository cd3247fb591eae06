// See pile_bench.h.
#include "tests/laboratory/shadow/pile_bench.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "models/files/failure.h"
#include "models/work/progress.h"
#include "sandglass/sandglass.hpp"
#include "tests/laboratory/cpu_time.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_grains = 24000, k_repeats = 15;
constexpr float k_radius = 0.0035f;  // metres

std::vector<float> cone() {
  constexpr float k_foot = 0.25f, k_height = 0.08f;  // metres
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<float> grains;
  while (grains.size() < 3 * k_grains) {
    const float x = k_foot * unit(random), z = k_foot * unit(random), y = k_height * std::fabs(unit(random));
    if (std::hypot(x, z) < k_foot * (1 - y / k_height)) grains.insert(grains.end(), {x, y + k_radius, z});
  }
  return grains;
}

void require(const cpp::Status& status) {
  if (!status) throw cannot("measure", "the sand's shadow", status.reason != nullptr ? status.reason : status.name());
}

PileBenchRow measured(const std::vector<float>& grains, sandglass_isa isa, uint32_t sky_texels) {
  sandglass_pile_shadow_desc desc = cpp::pile_shadow_desc();
  desc.isa = isa;
  desc.sky_texels = sky_texels;
  PileBenchRow row;
  require({sandglass_pile_shadow_bytes(&desc, &row.bytes, nullptr), nullptr});
  cpp::PileShadow shadow;
  require(shadow.create(desc));
  if (sky_texels == 0) require(shadow.set_light({0.6f, 0.75f, 0.2f}));
  row.name = sky_texels == 0 ? "pile_light" : "pile_sky/" + std::to_string(sky_texels);
  row.ms = 1e30;
  for (uint32_t i = 0; i < k_repeats && !(i > 0 && interrupted()); ++i) {
    shadow.refresh();
    double sum = 0;
    row.units = 0;
    for (bool more = true; more; row.units += more ? 1 : 0) {
      const double from = cpu_ms_now();
      more = shadow.run(grains, k_radius, 1) != 0;
      sum += cpu_ms_now() - from;
    }
    row.ms = std::min(row.ms, sum);
  }
  return row;
}

}  // namespace

std::vector<PileBenchRow> bench_pile_shadow(sandglass_isa isa) {
  const std::vector<float> grains = cone();
  std::vector<PileBenchRow> rows;
  for (const uint32_t sky_texels : {0u, 64u}) {
    const PileBenchRow row = measured(grains, isa, sky_texels);
    if (interrupted()) break;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace sandglass::host
