// `sandglass_lab bench SUITE`: times with the error of the same run in the same row. Here is what the suites share.
#include "tests/laboratory/bench.h"

#include <cstdio>

#include "kernels/int8.h"
#include "models/files/atomic_file.h"
#include "models/simulation/simulation.h"

namespace sandglass::host {

Bench::Bench(const std::string& s, const std::string& isa_option, Kernels kernels)
    : suite(s), isa(find_isa(isa_option)), isa_name(kernels_of(isa)) {
  const Int8Kernels* of_bytes = select_int8_kernels(isa);
  if (kernels == Kernels::bytes && of_bytes != nullptr) isa_name = sandglass_isa_name(of_bytes->isa);
}

void Bench::keep(const std::string& scene, const char* metric, const char* unit, double value, uint32_t threads,
                 const std::string& kernels) {
  if (!keeping_) keeping_.emplace();
  measurements.push_back({suite, scene, metric, unit, kernels.empty() ? isa_name : kernels, value, threads, {}});
}

namespace {

int run_bench(const char* name, Bench::Kernels kernels, BenchSuite suite, const BenchOptions& options) {
  Bench bench(name, options.isa, kernels);
  suite(options, &bench);
  if (!options.json.empty()) write_file(options.json, measurements_json(bench.measurements));
  if (!interrupted()) return k_exit_done;
  std::puts("interrupted; what was measured is above");
  return k_exit_interrupted;
}

}  // namespace

Command bench_command(const char* name, const char* help, Options (*options)(BenchOptions&), BenchSuite suite,
                      Bench::Kernels kernels) {
  return command<BenchOptions>(name, help, options,
                               [=](const BenchOptions& o) { return run_bench(name, kernels, suite, o); });
}

SceneTable::SceneTable(Bench* bench) : bench_(bench) {
  std::printf("%-34s %2s %9s %9s %9s %11s %10s %9s %8s\n", "case", "T", "ms/frame", "solver", "refine", "P99 (% r)",
              "mean", "max", "angle");
}

BenchRow SceneTable::row(const std::string& name, const SceneFile& scene, uint32_t threads, uint32_t frames,
                         uint32_t level, bool with_grains) const {
  const BenchRow result = with_steps(name + ", " + std::to_string(threads) + "T", frames, [&](const BenchStep& step) {
    return bench_scene(scene, bench_->isa, threads, frames, with_grains, step, level);
  });
  if (interrupted()) return result;
  std::printf("%-34s %2u %9.2f %9.2f %9.2f %11.4f %10.4f %9.4f %8.1f\n", name.c_str(), threads, result.ms_per_frame,
              result.ms_solver, result.ms_refine, 100.0 * result.overlap_p99, 100.0 * result.overlap_mean,
              100.0 * result.overlap_max, result.angle_deg);
  std::fflush(stdout);
  const std::tuple<const char*, const char*, double> values[] = {
      {"ms_per_frame", "ms", result.ms_per_frame}, {"ms_solver", "ms", result.ms_solver},
      {"ms_refine", "ms", result.ms_refine},       {"overlap_p99", "r", result.overlap_p99},
      {"overlap_mean", "r", result.overlap_mean},  {"overlap_max", "r", result.overlap_max},
      {"angle_deg", "deg", result.angle_deg}};
  for (const auto& [metric, unit, value] : values) bench_->keep(name, metric, unit, value, threads);
  return result;
}

}  // namespace sandglass::host
