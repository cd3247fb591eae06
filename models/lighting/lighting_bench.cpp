#include "models/lighting/lighting_bench.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "models/host/machine_peak.h"
#include "models/host/random.h"
#include "models/lighting/light_runner.h"
#include "models/lighting/xnnpack_peer.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_repeats = 25;
constexpr uint32_t k_width = 256, k_height = 192;
constexpr double k_macs = 2.549e9;  // pooling before the transitions' convolutions; heads included

// Of this thread: what other processes take away in between does not count.
double seconds_now() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void finish(LightingBenchRow* row, double peak) {
  row->gmac_per_s = k_macs / row->ms * 1e-6;
  row->fraction = peak > 0 ? row->gmac_per_s / peak : 0;
}

void add_part(LightingBenchRow* row, const std::string& name, double ms) {
  for (LightingBenchRow::Part& part : row->parts)
    if (part.name == name) {
      part.ms += ms;
      return;
    }
  row->parts.push_back({name, ms});
}

LightingBenchRow bench_own(LightRunner* runner, std::span<const uint8_t> rgb, double peak,
                           std::vector<LightingBenchRow::Part>* layers) {
  LightNetwork* net = runner->network();
  std::vector<double> best(net->units, 1e30);
  LightingBenchRow row;
  row.name = "int8", row.ms = 1e30;
  for (uint32_t repeat = 0; repeat < k_repeats; ++repeat) {
    begin_light_network(net, rgb.data());
    const double begin = seconds_now();
    double from = begin;
    for (uint32_t unit = 0; unit < net->units; ++unit) {
      run_light_unit(net, unit);
      const double now = seconds_now();
      best[unit] = std::min(best[unit], 1e3 * (now - from));
      from = now;
    }
    row.ms = std::min(row.ms, 1e3 * (from - begin));
  }
  finish(&row, peak);
  Layout layout;
  layout_light_network(k_width, k_height, &layout);
  row.arena_bytes = static_cast<double>(layout.size);
  row.activations = static_cast<double>(light_activation_bytes(k_width, k_height));
  row.longest_unit_ms = *std::max_element(best.begin(), best.end());
  for (uint32_t first = 0; first < net->units; first = light_operator_end(*net, first)) {
    double sum = 0;
    for (uint32_t unit = first; unit < light_operator_end(*net, first); ++unit) sum += best[unit];
    const std::string name = light_unit(*net, first).name;
    layers->push_back({name, sum});
    add_part(&row, name.substr(name.find('.') + 1), sum);
  }
  return row;
}

#ifdef SANDGLASS_HAVE_XNNPACK
double relative_error(const std::vector<float>& a, const std::vector<float>& truth) {
  double error = 0, square = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    error += std::pow(static_cast<double>(a[i] - truth[i]), 2);
    square += std::pow(static_cast<double>(truth[i]), 2);
  }
  return std::sqrt(error / square);
}

LightingBenchRow bench_peer(const LightAsset& asset, bool bytes, std::span<const uint8_t> rgb, double peak,
                            const std::vector<float>& features) {
  XnnpackLightPeer peer(asset, bytes, k_width, k_height);
  LightingBenchRow row;
  row.name = bytes ? "xnnpack_int8" : "xnnpack_f32", row.ms = 1e30;
  std::vector<double> best(peer.times().size(), 1e30);
  for (uint32_t repeat = 0; repeat < k_repeats; ++repeat) {
    const double begin = seconds_now();
    peer.run(rgb);
    row.ms = std::min(row.ms, 1e3 * (seconds_now() - begin));
    for (size_t i = 0; i < best.size(); ++i) best[i] = std::min(best[i], 1e3 * peer.times()[i].seconds);
  }
  finish(&row, peak);
  row.arena_bytes = static_cast<double>(peer.memory_bytes());
  row.longest_unit_ms = *std::max_element(best.begin(), best.end());
  row.relative_error = relative_error(peer.features(), features);
  for (size_t i = 0; i < best.size(); ++i) add_part(&row, peer.times()[i].name, best[i]);
  return row;
}
#endif

}  // namespace

LightingBench bench_lighting(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa,
                             const std::function<bool(uint32_t done, uint32_t total)>& go_on) {
  constexpr uint32_t k_steps = 3;
  LightRunner runner(file, name, isa, k_width, k_height);
  const MachinePeak peak = measure_machine_peak();
  // Times do not depend on what is seen; noise keeps every channel alive.
  std::vector<uint8_t> rgb(size_t{3} * k_width * k_height);
  for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<uint8_t>(256 * random_unit(i));
  LightingBench bench;
  bench.int8_peak = peak.int8_gmac_per_s, bench.f32_peak = peak.f32_gmac_per_s;
  bench.rows.push_back(bench_own(&runner, rgb, peak.int8_gmac_per_s, &bench.layers));
  if (!go_on(1, k_steps)) return bench;
#ifdef SANDGLASS_HAVE_XNNPACK
  bench.has_xnnpack = true;
  const std::vector<float> features = runner.features();
  bench.rows.push_back(bench_peer(runner.asset(), false, rgb, peak.f32_gmac_per_s, features));
  if (!go_on(2, k_steps)) return bench;
  bench.rows.push_back(bench_peer(runner.asset(), true, rgb, peak.int8_gmac_per_s, features));
#endif
  go_on(k_steps, k_steps);
  return bench;
}

}  // namespace sandglass::host
