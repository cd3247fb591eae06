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
#include "tests/laboratory/machine_peak.h"
#include "tests/laboratory/shadow/xnnpack_peer.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_size = k_native_size, k_texels = k_size * k_size;
constexpr uint32_t k_lights = 12;  // evenly spread over the baked cap
constexpr uint64_t k_stream = uint64_t{3} << 40;
constexpr double k_beyond = 1e-3;  // the share of activations that the peer's int8 clips

double rmse(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::pow(static_cast<double>(a[i] - b[i]), 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

#ifdef SANDGLASS_HAVE_XNNPACK
// The input of a peer for one light: 69 floats a texel, from tables of the two coordinates.
void encode_texels(const std::vector<float>& positions, const Direction& light, std::vector<float>* input) {
  float encoded[3 * k_light_inputs];
  encode_light(light, encoded);
  float* x = input->data();
  for (uint32_t v = 0; v < k_size; ++v)
    for (uint32_t u = 0; u < k_size; ++u, x += k_inputs) {
      std::copy_n(&positions[u * k_texel_inputs], k_texel_inputs, x);
      std::copy_n(&positions[v * k_texel_inputs], k_texel_inputs, x + k_texel_inputs);
      std::copy_n(encoded, 3 * k_light_inputs, x + 2 * k_texel_inputs);
    }
}
#endif

struct Samples {
  std::vector<double> ms;
  double rmse = 0, rmse_truth = 0, macs = 0, evaluated = 0;

  void judge(const std::vector<float>& values, const std::vector<float>& reference, const std::vector<float>& truth) {
    rmse += host::rmse(values, reference);
    rmse_truth += host::rmse(values, truth);
  }

  ShadowBenchRow row(const std::string& name, double peak) const {
    ShadowBenchRow r;
    r.name = name;
    std::vector<double> times = ms;
    r.ms = quantile(times, 0.5);
    r.gmac_per_s = macs / k_lights / r.ms * 1e-6;
    r.fraction = peak > 0 ? r.gmac_per_s / peak : 0;
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
  const MachinePeak peak = measure_machine_peak();
  std::vector<float> positions(size_t{k_size} * k_texel_inputs), input(size_t{k_texels} * k_inputs + 64),
      output(k_texels);
  for (uint32_t i = 0; i < k_size; ++i)
    encode(texel_centre(i, k_size), k_texel_frequencies, &positions[i * k_texel_inputs]);

  ShadowRunner full(file, name, isa, SANDGLASS_SHADOW_FULL), adaptive(file, name, isa, SANDGLASS_SHADOW_ADAPTIVE);
  const std::vector<Direction> lights = ring_directions(geometry.polar_max, k_lights);
  Samples own_float, own_int8, own_adaptive, peer_float, peer_int8;
#ifdef SANDGLASS_HAVE_XNNPACK
  encode_texels(positions, lights[k_lights / 2], &input);
  const Floats probe(input.begin(), input.begin() + 16384 * k_inputs);
  const std::vector<float> clips = activation_clips(network, probe, 16384, k_beyond);
  XnnpackPeer xnn_float(network, clips, false), xnn_int8(network, clips, true);
#endif
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
      sandglass_texture texture = {};
      samples->ms.push_back(best_cpu_ms([&] { texture = runner->texture(light); }, [&] { runner->texture(other); }));
      samples->macs += separated_macs * runner->evaluated();
      samples->evaluated += runner->evaluated();
      for (uint32_t t = 0; t < k_texels; ++t) output[t] = 1 - static_cast<float>(texture.bytes[t]) / 255;
      samples->judge(output, reference, truth);
    };
    bytes(&full, &own_int8);
    bytes(&adaptive, &own_adaptive);
#ifdef SANDGLASS_HAVE_XNNPACK
    encode_texels(positions, light, &input);
    const auto peer = [&](Samples* samples, const std::function<void()>& work) {
      if (interrupted()) return;
      samples->ms.push_back(best_cpu_ms(work));
      samples->macs += texel_macs * k_texels;
      samples->judge(output, reference, truth);
    };
    peer(&peer_float, [&] { xnn_float.run(input.data(), k_texels, output.data()); });
    std::vector<int8_t> encoded(input.size());
    xnn_int8.round_inputs(input.data(), k_texels, encoded.data());
    peer(&peer_int8, [&] { xnn_int8.run_bytes(encoded.data(), k_texels, output.data()); });
#endif
    if (!go_on(i + 1, k_lights)) break;
  }
  ShadowBench bench;
  if (own_float.ms.size() < k_lights) return bench;
  if (baked.ambient_rmse > 0) {
    bench.ambient_ms = full.ambient_ms();
    bench.ambient_rmse = baked.ambient_rmse;
  }
  bench.rows = {own_float.row("f32", peak.f32_gmac_per_s), own_int8.row("int8", peak.int8_gmac_per_s),
                own_adaptive.row("int8_adaptive", peak.int8_gmac_per_s)};
  if (!peer_float.ms.empty()) {
    bench.has_xnnpack = true;
    bench.rows.push_back(peer_float.row("xnnpack_f32", peak.f32_gmac_per_s));
    bench.rows.push_back(peer_int8.row("xnnpack_int8", peak.int8_gmac_per_s));
  }
  return bench;
}

}  // namespace sandglass::host
