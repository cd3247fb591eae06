#include "tests/laboratory/light/lighting_bench.h"

#include <algorithm>
#include <cmath>

#include "models/files/aligned_bytes.h"
#include "models/files/failure.h"
#include "models/lighting/light_runner.h"
#include "models/lighting/room_light.h"
#include "models/rooms/excerpt.h"
#include "models/work/progress.h"
#include "runtime/light/network/backends.h"
#include "sandglass/sandglass.hpp"
#include "tests/laboratory/cpu_time.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_repeats = 25;
constexpr uint32_t k_width = 256, k_height = 192;
constexpr double k_macs = 2.549e9;  // with pooling before the transitions' convolutions, and with the heads

// Without a camera pose, directions are in the world's axes: x right, y up, z backward.
LightValues values_of(const sandglass_light_estimate& e) {
  return {e.direction[0], -e.direction[1], -e.direction[2], e.light[0],   e.light[1],
          e.light[2],     e.ambient[0],    e.ambient[1],    e.ambient[2], e.contrast};
}

// The longest of the work units' best times.
double longest_unit(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa,
                    sandglass_estimator_backend backend, std::span<const uint8_t> rgb) {
  LightRunner runner(file, name, isa, k_width, k_height, backend);
  LightNetwork* net = runner.network();
  std::vector<double> best(net->units, 1e30);
  for (uint32_t repeat = 0; repeat < k_repeats && !(repeat > 0 && interrupted()); ++repeat) {
    begin_light_network(net, rgb.data());
    for (uint32_t unit = 0; unit < net->units; ++unit) {
      const double from = cpu_ms_now();
      run_light_unit(net, unit);
      best[unit] = std::min(best[unit], cpu_ms_now() - from);
    }
  }
  return *std::max_element(best.begin(), best.end());
}

// Measures the time of an estimate as an app would see it. Returns false if this build lacks the back end.
bool measure(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa,
             sandglass_estimator_backend choice, const std::vector<Picture>& images, LightingBenchRow* row) {
  const LightBackend* backend = nullptr;
  if (!find_light_backend(choice, &backend, nullptr)) return false;
  const AlignedBytes aligned(file);
  sandglass_estimator_desc desc = estimator_desc();
  desc.asset = aligned.data();
  desc.asset_bytes = file.size();
  desc.isa = isa;
  desc.backend = choice;
  desc.smoothing = desc.interval = 0;
  Estimator light;
  if (const Status status = light.create(desc); !status) throw cannot("read", name, status.reason);
  uint64_t bytes = 0;
  if (sandglass_estimator_bytes(&desc, &bytes, nullptr) != SANDGLASS_OK) return false;  // cannot be
  row->arena_bytes = static_cast<double>(bytes + (backend == nullptr ? 0 : backend->bytes_beside()));
  row->ms = 1e30;
  for (const Picture& picture : images) {
    if (interrupted()) return true;
    const sandglass_camera_image image = camera_image_of(picture, k_excerpt_fov_deg);
    for (uint32_t repeat = 0; repeat < (&picture == &images[0] ? k_repeats : 1); ++repeat) {
      if (sandglass_estimator_set_image(light.get(), &image, nullptr, nullptr) != SANDGLASS_OK)
        return false;  // cannot be
      const double begin = cpu_ms_now();
      sandglass_estimator_run(light.get(), UINT32_MAX);
      row->ms = std::min(row->ms, cpu_ms_now() - begin);
    }
    sandglass_light_estimate latest = light.estimated();
    sandglass_estimator_get_latest(light.get(), &latest);  // the filter rejects what contradicts the image before
    row->estimates.push_back(values_of(latest));
  }
  return true;
}

}  // namespace

LightingBench bench_lighting(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa,
                             const std::vector<Excerpt>& excerpts,
                             const std::function<bool(uint32_t done, uint32_t total)>& go_on) {
  struct Case {
    const char* name;
    sandglass_estimator_backend backend;
  };
  constexpr Case k_cases[] = {{"int8", SANDGLASS_ESTIMATOR_BACKEND_OWN},
                              {"xnnpack_f32", SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32},
                              {"xnnpack_int8", SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_INT8}};
  constexpr uint32_t k_steps = std::size(k_cases);
  LightingBench bench;
  const LightBackend* xnnpack = nullptr;
  bench.has_xnnpack = find_light_backend(SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32, &xnnpack, nullptr);
  std::vector<Picture> images;
  std::vector<LightValues> truth;
  for (const Excerpt& excerpt : excerpts) {
    images.emplace_back(k_width, k_height, Colour{0, 0, 0}).rgb = excerpt.rgb;
    truth.push_back(excerpt.values);
  }
  for (const Case& c : k_cases) {
    LightingBenchRow row;
    row.name = c.name;
    if (!measure(file, name, isa, c.backend, images, &row)) break;
    row.longest_unit_ms = longest_unit(file, name, isa, c.backend, images[0].rgb);
    if (interrupted()) return bench;
    row.gmac_per_s = k_macs / row.ms * 1e-6;
    bench.rows.push_back(row);
    if (!go_on(static_cast<uint32_t>(bench.rows.size()), k_steps)) return bench;
  }
  bench.compared = true;
  for (LightingBenchRow& row : bench.rows) {
    const LightDifference off = median_difference(row.estimates, truth);
    row.angle_deg = off.angle_deg;
    row.difference = off.other;
  }
  go_on(k_steps, k_steps);
  return bench;
}

}  // namespace sandglass::host
