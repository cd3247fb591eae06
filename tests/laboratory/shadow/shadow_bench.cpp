#include "tests/laboratory/shadow/shadow_bench.h"

#include <algorithm>
#include <cmath>

#include "models/baking/shadow_runner.h"
#include "models/baking/trainer.h"
#include "models/files/aligned_bytes.h"
#include "models/files/failure.h"
#include "models/simulation/metrics.h"
#include "models/work/progress.h"
#include "models/work/random.h"
#include "runtime/asset/shadow_asset.h"
#include "tests/laboratory/cpu_time.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_size = k_native_size, k_texels = k_size * k_size;
constexpr uint32_t k_lights = 12;  // evenly spread over the baked cap
constexpr uint64_t k_stream = uint64_t{3} << 40;

double rmse(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::pow(static_cast<double>(a[i] - b[i]), 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

struct Samples {
  std::vector<double> ms;
  double rmse = 0, rmse_truth = 0, macs = 0, evaluated = 0;

  void judge(const std::vector<float>& values, const std::vector<float>& reference, const std::vector<float>& truth) {
    rmse += host::rmse(values, reference);
    rmse_truth += host::rmse(values, truth);
  }

  ShadowBenchRow row(const std::string& name) const {
    ShadowBenchRow r;
    r.name = name;
    std::vector<double> times = ms;
    r.ms = quantile(times, 0.5);
    r.gmac_per_s = macs / k_lights / r.ms * 1e-6;
    r.evaluated = evaluated > 0 ? evaluated / k_lights / k_texels : 1;
    r.rmse = rmse / k_lights;
    r.rmse_truth = rmse_truth / k_lights;
    return r;
  }
};

}  // namespace

BakedShadow open_baked_shadow(std::span<const uint8_t> file, const std::string& name, const Mesh& mesh) {
  const AlignedBytes aligned(file);
  ShadowAsset asset;
  const char* reason = nullptr;
  if (open_shadow_asset(aligned.data(), file.size(), &asset, &reason) != SANDGLASS_OK)
    throw cannot("read", name, reason);
  BakedShadow baked;
  baked.network.shape = {asset.width, asset.layers};
  if (asset.float_parameters != nullptr && asset.texel_frequencies == k_texel_frequencies &&
      asset.light_frequencies == k_light_frequencies)
    baked.network.parameters.assign(asset.float_parameters, asset.float_parameters + asset.float_parameter_count);
  LightGeometry& geometry = baked.geometry;
  geometry.object = stand_on_plane(mesh, name);
  geometry.plane = asset.plane;
  geometry.half_angle = 0.5 * asset.angular_diameter;
  geometry.polar_max = asset.polar_max;
  baked.ambient_rmse = static_cast<double>(asset.ambient.rmse);
  const double scale = geometry.object.scale;
  if (std::fabs(geometry.object.box.height * scale - asset.box.height) > 1e-4 * scale ||
      std::fabs(geometry.object.box.half_x * scale - asset.box.half_x) > 1e-4 * scale)
    throw cannot("measure", name, "it was baked from another mesh", "Name its mesh with --mesh");
  return baked;
}

ShadowBench bench_shadow(std::span<const uint8_t> file, const std::string& name, const Mesh& mesh, sandglass_isa isa,
                         const std::function<bool(uint32_t, uint32_t)>& go_on) {
  const BakedShadow baked = open_baked_shadow(file, name, mesh);
  const LightGeometry& geometry = baked.geometry;
  const FloatNetwork& network = baked.network;
  if (network.parameters.empty())
    throw cannot("measure", name, "it does not hold the float network to compare with", "Bake it with --keep-float");
  const ShadowCaster caster(geometry.object.mesh, geometry.half_angle, {}, 1);
  ThreadPool pool(1);
  std::vector<float> output(k_texels);
  ShadowRunner full(file, name, isa, SANDGLASS_SHADOW_FULL), adaptive(file, name, isa, SANDGLASS_SHADOW_ADAPTIVE);
  const std::vector<Direction> lights = ring_directions(geometry.polar_max, k_lights);
  Samples own_float, own_int8, own_adaptive;
  const double texel_macs = static_cast<double>(network.shape.macs());
  const double separated_macs =
      static_cast<double>(network.shape.width) * (network.shape.layers * network.shape.width + 1);
  for (uint32_t i = 0; i < k_lights; ++i) {
    const Direction& light = lights[i];
    const std::vector<float> truth = caster.texture(geometry.rectangle(light), light, k_stream + i, k_size, pool);
    if (interrupted()) break;
    std::vector<float> reference;
    own_float.ms.push_back(best_cpu_ms([&] { reference = evaluate(network, light, k_size, pool); }));
    own_float.macs += texel_macs * k_texels;
    own_float.judge(reference, reference, truth);
    // The runtime computes nothing for a light that it has already. So another light comes in between, untimed.
    const Direction other = lights[(i + 1) % k_lights];
    const auto bytes = [&](ShadowRunner* runner, Samples* samples) {
      if (interrupted()) return;
      sandglass_shadow_texture texture = {};
      samples->ms.push_back(best_cpu_ms([&] { texture = runner->texture(light); }, [&] { runner->texture(other); }));
      samples->macs += separated_macs * texture.evaluated;
      samples->evaluated += texture.evaluated;
      for (uint32_t t = 0; t < k_texels; ++t) output[t] = 1 - static_cast<float>(texture.coverage[t]) / 255;
      samples->judge(output, reference, truth);
    };
    bytes(&full, &own_int8);
    bytes(&adaptive, &own_adaptive);
    if (!go_on(i + 1, k_lights)) break;
  }
  ShadowBench bench;
  if (own_float.ms.size() < k_lights) return bench;
  if (baked.ambient_rmse > 0) {
    bench.ambient_ms = full.ambient_ms();
    bench.ambient_rmse = baked.ambient_rmse;
  }
  bench.rows = {own_float.row("f32"), own_int8.row("int8"), own_adaptive.row("int8_adaptive")};
  return bench;
}

}  // namespace sandglass::host
