// `sandglass_lab bench SUITE`: times with the error of the same run in the same row. Here are the options of the suites and
// what the suites share.
#include "tests/laboratory/bench.h"

#include <cstdio>

#include "kernels/int8.h"
#include "models/files/atomic_file.h"
#include "models/program/command_line.h"
#include "models/simulation/simulation.h"
#include "models/work/progress.h"
#include "tests/laboratory/machine_peak.h"

namespace sandglass::host {

Bench::Bench(const std::string& s, const std::string& isa_option, Kernels kernels)
    : suite(s), isa(find_isa(isa_option)) {
  sandglass_scene_desc desc;
  sandglass_scene_desc_default(&desc);
  desc.isa = isa;
  isa_name = sandglass_isa_name(sandglass_scene_isa(Simulation(desc).handle()));
  const Int8Kernels* of_bytes = select_int8_kernels(isa);
  if (kernels == Kernels::bytes && of_bytes != nullptr) isa_name = sandglass_isa_name(of_bytes->isa);
}

void Bench::keep(const std::string& scene, const char* metric, const char* unit, double value, uint32_t threads,
                 const std::string& kernels) {
  if (!keeping_) keeping_.emplace();
  Measurement m;
  m.suite = suite;
  m.scene = scene;
  m.metric = metric;
  m.unit = unit;
  m.value = value;
  m.isa = kernels.empty() ? isa_name : kernels;
  m.threads = threads;
  measurements.push_back(m);
}

int run_bench(const char* name, Bench::Kernels kernels, BenchSuite suite, const BenchOptions& options) {
  Bench bench(name, options.isa, kernels);
  suite(options, &bench);
  if (!options.json.empty()) write_file(options.json, measurements_json(bench.measurements));
  if (!interrupted()) return k_exit_done;
  std::puts("interrupted; what was measured is above");
  return k_exit_interrupted;
}

// What this machine can do at most, which the other suites' shares of the peak refer to.
void bench_machine(const BenchOptions&, Bench* bench) {
  const MachinePeak peak = measure_machine_peak();
  std::printf("peak, one thread: %.2f GMAC/s (f32), %.2f GMAC/s (int8), %.2f GB/s read\n", peak.f32_gmac_per_s,
              peak.int8_gmac_per_s, peak.read_gb_per_s);
  bench->keep("peak", "f32_gmac_per_s", "GMAC/s", peak.f32_gmac_per_s);
  bench->keep("peak", "int8_gmac_per_s", "GMAC/s", peak.int8_gmac_per_s);
  bench->keep("peak", "read_gb_per_s", "GB/s", peak.read_gb_per_s);
}

SceneTable::SceneTable(Bench* bench) : bench_(bench) {
  std::printf("%-34s %2s %9s %9s %9s %11s %10s %9s %8s\n", "case", "T", "ms/frame", "solver", "refine", "P99 (% r)",
              "mean", "max", "angle");
}

BenchRow SceneTable::row(const std::string& name, uint32_t threads, uint32_t frames, const std::string& kernels,
                         const std::function<BenchRow(const BenchStep&)>& run) const {
  BenchRow result;
  {
    Progress progress(name + ", " + std::to_string(threads) + "T", frames);
    uint32_t frame = 0;
    result = run([&] {
      progress.done(++frame);
      return !interrupted();
    });
  }
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
  for (const auto& [metric, unit, value] : values) bench_->keep(name, metric, unit, value, threads, kernels);
  return result;
}

BenchRow SceneTable::row(const std::string& name, const SceneFile& scene, uint32_t threads, uint32_t frames,
                         uint32_t level) const {
  return row(name, threads, frames, bench_->isa_name, [&](const BenchStep& step) {
    return bench_scene(scene, bench_->isa, threads, frames, true, step, level);
  });
}

void with_progress(const char* what, const std::function<void(const Progressed& go_on)>& measure) {
  Progress progress(what, 1);
  measure([&](uint32_t done, uint32_t total) {
    progress.total(total);
    progress.done(done);
    return !interrupted();
  });
}

namespace {

using Options = std::vector<CommandOption>;

CommandOption thread_counts(BenchOptions& o) {
  return by_commas({"--threads", &o.threads, "LIST", "Thread counts, separated by commas", whole_number(1, 256)});
}

CommandOption frames(BenchOptions& o) {
  return {"--frames", &o.frames, "N", "Frames of a case; errors compare at 100 only", whole_number(1, 10000)};
}

Options granular_options(BenchOptions& o) {
  return {thread_counts(o),
          frames(o),
          {"--peers", &o.peers, "", "Also run other engines on the same scene, 5 frames each"},
          isa_option(o.isa),
          json_option(o.json)};
}

Options ladder_options(BenchOptions& o) {
  return {thread_counts(o), frames(o),
          fills({"--out", &o.out, "FOLDER", "Write the levels' table, of the last thread count, into this new folder"}),
          isa_option(o.isa), json_option(o.json)};
}

Options growth_options(BenchOptions& o) { return {thread_counts(o), isa_option(o.isa), json_option(o.json)}; }

#ifdef SANDGLASS_HAVE_BAKE
Options shadow_options(BenchOptions& o) {
  return {standard("the shipped chair", {"--asset", &o.asset, "FILE", "A baked shadow"}),
          {"--mesh", &o.mesh, "MESH", "The mesh that it was baked from: a file, or a generated mesh's name"},
          isa_option(o.isa),
          json_option(o.json)};
}
#endif

Options lighting_options(BenchOptions& o) { return {isa_option(o.isa), json_option(o.json)}; }

Options machine_options(BenchOptions& o) { return {json_option(o.json)}; }

Command bench(const char* name, const char* help, Options (*options)(BenchOptions&), BenchSuite suite,
              Bench::Kernels kernels = Bench::Kernels::sand) {
  return command<BenchOptions>(name, help, options,
                               [=](const BenchOptions& o) { return run_bench(name, kernels, suite, o); });
}

}  // namespace

std::vector<Command> bench_suites() {
  const char *shadow = "shadow", *of_shadow = "Shadows: one texture by every way of computing it";
  return {
      bench("granular", "Sand: a collapsing column, against the dissertation's scheme", granular_options,
            bench_granular),
      bench("ladder", "The quality ladder: error and time of every level", ladder_options, bench_ladder),
      bench("growth", "Sand: how time and memory grow with the scene", growth_options, bench_growth),
#ifdef SANDGLASS_HAVE_BAKE
      bench(shadow, of_shadow, shadow_options, bench_shadow, Bench::Kernels::bytes),
#else
      {shadow, of_shadow, {}, {}, {}, k_no_ray_tracer},
#endif
      bench("lighting", "The lighting network: one estimate by every back end", lighting_options, bench_lighting,
            Bench::Kernels::bytes),
      bench("machine", "This machine: peak arithmetic and memory speed of one thread", machine_options, bench_machine),
  };
}

}  // namespace sandglass::host
