// `sandglass bench growth`: how time and memory grow with the scene. A column collapses for its first second. Its sizes
// go from 1,000 particles and 10,000 grains to 100,000 particles and two million grains.
#include <cstdio>

#include "models/program/bench.h"
#include "models/simulation/metrics.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_frames = 50;

// One value for each size of the scene.
struct Growth {
  std::vector<double> particles, solver, grains, refine, items, bytes;
};

void measure_size(const SceneFile& scene, const std::string& name, uint32_t threads, Bench* bench, Growth* growth) {
  BenchRow result;
  {
    Progress progress(name + ", " + std::to_string(threads) + "T", k_frames);
    uint32_t frame = 0;
    result = bench_scene(scene, bench->isa, threads, k_frames, true, [&] {
      progress.done(++frame);
      return !interrupted();
    });
  }
  if (interrupted()) return;
  const double items = result.particles + result.grains, bytes = static_cast<double>(result.bytes);
  growth->particles.push_back(result.particles), growth->solver.push_back(result.ms_solver);
  growth->grains.push_back(result.grains), growth->refine.push_back(result.ms_refine);
  growth->items.push_back(items), growth->bytes.push_back(bytes);
  std::printf("%9u %9u %2u %12.2f %14.0f %11.2f %13.1f %10.1f\n", result.particles, result.grains, threads,
              result.ms_solver, 1e6 * result.ms_solver / result.particles, result.ms_refine,
              1e6 * result.ms_refine / result.grains, bytes / items);
  std::fflush(stdout);
  bench->keep(name, "ms_solver", "ms", result.ms_solver, threads);
  bench->keep(name, "ms_refine", "ms", result.ms_refine, threads);
  bench->keep(name, "bytes", "B", bytes, threads);
}

void measure(uint32_t threads, Bench* bench) {
  const SceneFile column = load_scene("column14k");
  Growth growth;
  for (const auto& [count, each] :
       {std::pair{1000u, 10u}, {3000u, 16u}, {10000u, 16u}, {30000u, 16u}, {100000u, 20u}}) {
    measure_size(scaled_column(column, count, each), "growth " + std::to_string(count), threads, bench, &growth);
    if (interrupted()) return;
  }
  const double of_solver = fitted_exponent(growth.particles, growth.solver);
  const double of_refine = fitted_exponent(growth.grains, growth.refine);
  const double of_bytes = fitted_exponent(growth.items, growth.bytes);
  std::printf("grows with the power  %.2f (solver), %.2f (refinement), %.2f (bytes), %u thread%s\n", of_solver,
              of_refine, of_bytes, threads, threads == 1 ? "" : "s");
  bench->keep("growth", "exponent_solver", "1", of_solver, threads);
  bench->keep("growth", "exponent_refine", "1", of_refine, threads);
  bench->keep("growth", "exponent_bytes", "1", of_bytes, threads);
}

}  // namespace

void bench_growth(const BenchOptions& options, Bench* bench) {
  std::printf("%9s %9s %2s %12s %14s %11s %13s %10s\n", "particles", "grains", "T", "solver, ms", "ns a particle",
              "refine, ms", "ns a grain", "bytes/item");
  for (const uint32_t threads : options.threads)
    if (!interrupted()) measure(threads, bench);
}

}  // namespace sandglass::host
