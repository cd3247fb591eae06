// `sandglass_lab bench shadow`: time and error of one shadow texture, for every way of computing it, and what the textures
// of a pile cost. On one thread.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "models/files/aligned_bytes.h"
#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "tests/laboratory/bench.h"
#include "tests/laboratory/cpu_time.h"
#ifdef SANDGLASS_HAVE_EMBREE
#include "models/baking/network.h"
#include "models/baking/shadow_runner.h"
#include "models/baking/trainer.h"
#include "models/baking/training_set.h"
#include "models/simulation/metrics.h"
#include "runtime/asset/shadow_asset.h"
#endif

namespace sandglass::host {

constexpr const char *k_name = "shadow", *k_help = "Shadows: one texture by every way of computing it";

#ifndef SANDGLASS_HAVE_EMBREE

Command bench_shadow_suite() { return {k_name, k_help, {}, {}, {}, k_no_ray_tracer}; }

#else

namespace {

// ---- of an object

constexpr uint32_t k_size = k_native_size, k_texels = k_size * k_size;
constexpr uint32_t k_lights = 12;  // evenly spread over the baked cap
constexpr uint64_t k_stream = uint64_t{3} << 40;

double rmse(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::pow(static_cast<double>(a[i] - b[i]), 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

// One way of computing, over the lights.
struct Samples {
  const char* name;
  double texel_macs;                // of what it computes
  std::vector<double> ms = {};      // CPU time of the thread: each light's best of some repeats
  double rmse = 0, rmse_truth = 0;  // against the float network, against ray tracing
  double evaluated = 0;             // texels that the network was asked for

  void judge(const std::vector<float>& values, const std::vector<float>& reference, const std::vector<float>& truth) {
    rmse += host::rmse(values, reference) / k_lights;
    rmse_truth += host::rmse(values, truth) / k_lights;
  }
  void tell(Bench* bench) const {
    std::vector<double> times = ms;
    const double median = quantile(times, 0.5), share = evaluated / k_lights / k_texels;
    const double gmac_per_s = texel_macs * evaluated / k_lights / median * 1e-6;
    std::printf("%-18s %8.2f %8.1f %10.4f %10.4f %8.1f %%\n", name, median, gmac_per_s, rmse, rmse_truth, 100 * share);
    bench->keep(name, "ms", "ms", median);
    bench->keep(name, "gmac_per_s", "GMAC/s", gmac_per_s);
    bench->keep(name, "rmse", "1", rmse);
    bench->keep(name, "rmse_truth", "1", rmse_truth);
    bench->keep(name, "evaluated", "1", share);
  }
};

// A baked file with its float network, and the mesh that it was made from.
struct BakedShadow {
  LightGeometry geometry;
  FloatNetwork network;
  double ambient_rmse = 0;  // that the file states; 0: it has no ambient shadow
};

// A Failure says that the file is damaged, lacks the float network, or was baked from another mesh.
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
  if (baked.network.parameters.empty())
    throw cannot("measure", name, "it does not hold the float network to compare with", "Bake it with --keep-float");
  return baked;
}

void measure_object(const BenchOptions& options, Bench* bench) {
  const std::string name = options.asset.empty() ? SANDGLASS_SHADOWS_DIR "/chair.shadow" : options.asset;
  const std::string content = read_file(name, "baked shadow", k_asset_limit);
  const std::span<const uint8_t> file(reinterpret_cast<const uint8_t*>(content.data()), content.size());
  const BakedShadow baked = open_baked_shadow(file, name, named_mesh(options.mesh).mesh);
  const LightGeometry& geometry = baked.geometry;
  const FloatNetwork& network = baked.network;
  const ShadowCaster caster(geometry.object.mesh, geometry.half_angle, {}, 1);
  ThreadPool pool(1);
  std::vector<float> output(k_texels);
  ShadowRunner full(file, name, bench->isa, SANDGLASS_SHADOW_FULL),
      adaptive(file, name, bench->isa, SANDGLASS_SHADOW_ADAPTIVE);
  const std::vector<Direction> lights = ring_directions(geometry.polar_max, k_lights);
  const double separated_macs =
      static_cast<double>(network.shape.width) * (network.shape.layers * network.shape.width + 1);
  Samples own_float = {"f32", static_cast<double>(network.shape.macs())}, own_int8 = {"int8", separated_macs},
          own_adaptive = {"int8_adaptive", separated_macs};
  with_steps("measuring", k_lights, [&](const BenchStep& step) {
    for (uint32_t i = 0; i < k_lights && !interrupted(); ++i) {
      const Direction& light = lights[i];
      const std::vector<float> truth = caster.texture(geometry.rectangle(light), light, k_stream + i, k_size, pool);
      std::vector<float> reference;
      own_float.ms.push_back(best_cpu_ms([&] { reference = evaluate(network, light, k_size, pool); }));
      own_float.evaluated += k_texels;
      own_float.judge(reference, reference, truth);
      // The runtime computes nothing for a light that it has already. So another light comes in between, untimed.
      const Direction other = lights[(i + 1) % k_lights];
      const auto bytes = [&](ShadowRunner* runner, Samples* samples) {
        sandglass_texture texture = {};
        samples->ms.push_back(best_cpu_ms([&] { texture = runner->texture(light); }, [&] { runner->texture(other); }));
        samples->evaluated += runner->evaluated();
        for (uint32_t t = 0; t < k_texels; ++t) output[t] = 1 - static_cast<float>(texture.bytes[t]) / 255;
        samples->judge(output, reference, truth);
      };
      bytes(&full, &own_int8);
      bytes(&adaptive, &own_adaptive);
      step();
    }
    return 0;
  });
  if (interrupted()) return;
  std::printf("%-18s %8s %8s %10s %10s %10s\n", "case", "ms", "GMAC/s", "RMSE (f32)", "RMSE truth", "evaluated");
  for (const Samples* samples : {&own_float, &own_int8, &own_adaptive}) samples->tell(bench);
  if (!(baked.ambient_rmse > 0)) return;
  const double ambient_ms = full.ambient_ms();
  std::printf("ambient shadow     %8.3f ms; RMSE %.4f in made-up rooms, by its file\n", ambient_ms, baked.ambient_rmse);
  bench->keep("ambient", "ms", "ms", ambient_ms);
  bench->keep("ambient", "rmse_truth", "1", baked.ambient_rmse);
}

// ---- of a pile: the soft shadow of one light, and the room's light, each from the columns to the last unit

std::vector<float> cone(float radius) {
  constexpr uint32_t k_grains = 24000;
  constexpr float k_foot = 0.25f, k_height = 0.08f;  // metres
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<float> grains;
  while (grains.size() < 3 * k_grains) {
    const float x = k_foot * unit(random), z = k_foot * unit(random), y = k_height * std::fabs(unit(random));
    if (std::hypot(x, z) < k_foot * (1 - y / k_height)) grains.insert(grains.end(), {x, y + radius, z});
  }
  return grains;
}

void require(const cpp::Status& status) {
  if (!status) throw cannot("measure", "the sand's shadow", status.reason != nullptr ? status.reason : status.name());
}

void measure_pile(Bench* bench) {
  constexpr uint32_t k_repeats = 15;
  constexpr float k_radius = 0.0035f;  // metres
  const std::vector<float> grains = cone(k_radius);
  std::printf("\n%-18s %8s %8s %9s\n", "sand, 128 texels", "ms", "units", "KiB");
  for (const uint32_t sky_texels : {0u, 64u}) {
    sandglass_pile_shadow_desc desc = cpp::pile_shadow_desc();
    desc.isa = bench->isa;
    desc.sky_texels = sky_texels;
    uint64_t bytes = 0;
    require({sandglass_pile_shadow_bytes(&desc, &bytes, nullptr), nullptr});
    cpp::PileShadow shadow;
    require(shadow.create(desc));
    if (sky_texels == 0) require(shadow.set_light({0.6f, 0.75f, 0.2f}));
    double ms = 1e30;  // both textures, on the floor and on the sand: the best of some repeats
    uint32_t units = 0;
    for (uint32_t i = 0; i < k_repeats && !interrupted(); ++i) {
      shadow.refresh();
      double sum = 0;
      units = 0;
      for (bool more = true; more; units += more ? 1 : 0) {
        const double from = cpu_ms_now();
        more = shadow.run(grains, k_radius, 1) != 0;
        sum += cpu_ms_now() - from;
      }
      ms = std::min(ms, sum);
    }
    if (interrupted()) return;
    const std::string name = sky_texels == 0 ? "pile_light" : "pile_sky/" + std::to_string(sky_texels);
    const double kib = static_cast<double>(bytes) / 1024;
    std::printf("%-18s %8.2f %8u %9.0f\n", name.c_str(), ms, units, kib);
    bench->keep(name, "ms", "ms", ms);
    bench->keep(name, "units", "1", units);
    bench->keep(name, "kib", "KiB", kib);
  }
}

void measure(const BenchOptions& options, Bench* bench) {
  measure_object(options, bench);
  if (!interrupted()) measure_pile(bench);
}

Options options_of(BenchOptions& o) {
  return {standard("the shipped chair", {"--asset", &o.asset, "FILE", "A baked shadow"}),
          {"--mesh", &o.mesh, "MESH", "The mesh that it was baked from: a file, or a generated mesh's name"},
          isa_option(o.isa),
          json_option(o.json)};
}

}  // namespace

Command bench_shadow_suite() { return bench_command(k_name, k_help, options_of, measure, Bench::Kernels::bytes); }

#endif

}  // namespace sandglass::host
