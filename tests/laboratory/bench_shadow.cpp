// `sandglass_lab bench shadow`: time and error of one shadow texture, for every way of computing it, and what the textures
// of a pile cost.
#include <cstdio>

#include "models/files/atomic_file.h"
#include "tests/laboratory/bench.h"
#include "tests/laboratory/shadow/pile_bench.h"
#ifdef SANDGLASS_HAVE_EMBREE
#include "tests/laboratory/shadow/shadow_bench.h"
#endif

namespace sandglass::host {

constexpr const char *k_name = "shadow", *k_help = "Shadows: one texture by every way of computing it";

#ifndef SANDGLASS_HAVE_EMBREE

Command bench_shadow_suite() { return {k_name, k_help, {}, {}, {}, k_no_ray_tracer}; }

#else

namespace {

void print_and_keep(const std::vector<ShadowBenchRow>& rows, Bench* bench) {
  std::printf("%-18s %8s %8s %10s %10s %10s\n", "case", "ms", "GMAC/s", "RMSE (f32)", "RMSE truth", "evaluated");
  for (const ShadowBenchRow& r : rows) {
    std::printf("%-18s %8.2f %8.1f %10.4f %10.4f %8.1f %%\n", r.name.c_str(), r.ms, r.gmac_per_s, r.rmse, r.rmse_truth,
                100 * r.evaluated);
    bench->keep(r.name, "ms", "ms", r.ms);
    bench->keep(r.name, "gmac_per_s", "GMAC/s", r.gmac_per_s);
    bench->keep(r.name, "rmse", "1", r.rmse);
    bench->keep(r.name, "rmse_truth", "1", r.rmse_truth);
    bench->keep(r.name, "evaluated", "1", r.evaluated);
  }
}

void print_and_keep(const std::vector<PileBenchRow>& rows, Bench* bench) {
  std::printf("\n%-18s %8s %8s %9s\n", "sand, 128 texels", "ms", "units", "KiB");
  for (const PileBenchRow& r : rows) {
    const double kib = static_cast<double>(r.bytes) / 1024;
    std::printf("%-18s %8.2f %8u %9.0f\n", r.name.c_str(), r.ms, r.units, kib);
    bench->keep(r.name, "ms", "ms", r.ms);
    bench->keep(r.name, "units", "1", r.units);
    bench->keep(r.name, "kib", "KiB", kib);
  }
}

void measure(const BenchOptions& options, Bench* bench) {
  const std::string asset = options.asset.empty() ? SANDGLASS_SHADOWS_DIR "/chair.shadow" : options.asset;
  const std::string content = read_file(asset, "baked shadow", k_asset_limit);
  const Mesh mesh = named_mesh(options.mesh).mesh;
  const ShadowBench result = with_progress("measuring", [&](const auto& go_on) {
    return bench_shadow({reinterpret_cast<const uint8_t*>(content.data()), content.size()}, asset, mesh, bench->isa,
                        go_on);
  });
  print_and_keep(result.rows, bench);
  if (result.ambient_ms > 0) {
    std::printf("ambient shadow     %8.3f ms; RMSE %.4f in made-up rooms, by its file\n", result.ambient_ms,
                result.ambient_rmse);
    bench->keep("ambient", "ms", "ms", result.ambient_ms);
    bench->keep("ambient", "rmse_truth", "1", result.ambient_rmse);
  }
  if (!interrupted()) print_and_keep(bench_pile_shadow(bench->isa), bench);
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
