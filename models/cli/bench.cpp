// `sandglass bench SUITE`: times with the error of the same run in the same row.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <thread>

#include "models/cli/commands.h"
#include "models/host/atomic_file.h"
#include "models/host/failure.h"
#include "models/host/granular_bench.h"
#include "models/host/machine_peak.h"
#include "models/host/measurement_json.h"
#include "models/host/peer_bullet.h"
#include "models/host/progress.h"
#include "models/host/simulation.h"

namespace sandglass::host {

namespace {

constexpr int k_exit_interrupted = 130;
constexpr uint32_t k_peer_frames = 5;     // other engines take seconds a frame
constexpr uint32_t k_search_threads = 4;  // the search needs errors only, and they do not depend on threads

struct Options {
  std::string suite, json, isa = "automatic";
  uint32_t frames = 100;
  bool peers = false;
  std::vector<uint32_t> threads = {1};
};

struct Bench {
  const Options& options;
  sandglass_isa isa;
  std::string isa_name;
  std::vector<Measurement> measurements;

  void keep(const std::string& scene, const char* metric, const char* unit, double value, uint32_t threads,
            const std::string& kernels) {
    Measurement m;
    m.suite = options.suite, m.scene = scene, m.metric = metric, m.unit = unit, m.isa = kernels, m.value = value,
    m.threads = threads;
    measurements.push_back(m);
  }
  void keep(const std::string& scene, const char* metric, const char* unit, double value, uint32_t threads) {
    keep(scene, metric, unit, value, threads, isa_name);
  }

  static void head() {
    std::printf("%-34s %2s %9s %9s %9s %11s %10s %9s %8s\n", "case", "T", "ms/frame", "solver", "refine", "P99 (% r)",
                "mean", "max", "angle");
  }

  // Runs a case behind a progress bar, prints its row and keeps its numbers. `kernels`: what computed it.
  BenchRow row(const std::string& name, uint32_t threads, uint32_t frames, const std::string& kernels,
               const std::function<BenchRow(const BenchStep&)>& run) {
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
    keep(name, "ms_per_frame", "ms", result.ms_per_frame, threads, kernels);
    keep(name, "ms_solver", "ms", result.ms_solver, threads, kernels);
    keep(name, "ms_refine", "ms", result.ms_refine, threads, kernels);
    keep(name, "overlap_p99", "r", result.overlap_p99, threads, kernels);
    keep(name, "overlap_mean", "r", result.overlap_mean, threads, kernels);
    keep(name, "overlap_max", "r", result.overlap_max, threads, kernels);
    keep(name, "angle_deg", "deg", result.angle_deg, threads, kernels);
    return result;
  }
  BenchRow row(const std::string& name, const SceneFile& scene, uint32_t threads, uint32_t level = 0) {
    return row(name, threads, options.frames, isa_name, [&](const BenchStep& step) {
      return bench_scene(scene, isa, threads, options.frames, true, step, level);
    });
  }

  void granular() {
    constexpr uint32_t k_source_steps = 16, k_source_iterations = 7;  // Alg. 4 as the source runs it
    const SceneFile column = load_scene("column14k");
    head();
    BenchRow standard;
    for (const uint32_t threads : options.threads) {
      standard = row("column14k/default", column, threads);
      row("column14k/source", source_scheme(column, k_source_steps, k_source_iterations), threads);
      if (interrupted()) return;
    }
    if (options.peers) peers(column);
    if (interrupted()) return;
    EqualError equal;
    {
      constexpr uint32_t k_runs_at_most = 16;  // of the bisections; fewer when a cheaper setting is found early
      Progress progress("searching source_equal_error", k_runs_at_most * options.frames);
      uint32_t frame = 0;
      equal = find_equal_error(column, standard.overlap_p99, isa,
                               std::min(k_search_threads, std::max(1u, std::thread::hardware_concurrency())),
                               options.frames, [&] {
                                 progress.done(++frame);
                                 return !interrupted();
                               });
    }
    if (interrupted()) return;
    if (!equal.found) {
      std::printf(
          "column14k/source_equal_error: no setting of the source's scheme up to 256 steps x 7 iterations reaches a "
          "P99 of %.4f %% r\n",
          100.0 * standard.overlap_p99);
      return;
    }
    for (const uint32_t threads : options.threads)
      row("column14k/source_equal_error", source_scheme(column, equal.steps, equal.iterations), threads);
    std::printf("source_equal_error is %u steps x %u iterations (+ 1 stabilisation)\n", equal.steps, equal.iterations);
    keep("column14k/source_equal_error", "steps", "1/frame", equal.steps, options.threads[0]);
    keep("column14k/source_equal_error", "iterations", "1/step", equal.iterations, options.threads[0]);
  }

  // Other engines, and ours over as many frames, in which the column still stands.
  void peers(const SceneFile& column) {
    if (!bullet_available()) {
      std::puts(
          "column14k/bullet: left out, this build has no Bullet; install libbullet-dev, configure and build again");
      return;
    }
    row("column14k/bullet, 5 frames", 1, k_peer_frames, "bullet",
        [&](const BenchStep& step) { return bench_bullet(column, k_peer_frames, step); });
    row("column14k/default, 5 frames", 1, k_peer_frames, isa_name,
        [&](const BenchStep& step) { return bench_scene(column, isa, 1, k_peer_frames, false, step); });
  }

  // The error-time plane: every rung of the quality ladder, the default scheme with other sub-steps, the source's
  // scheme.
  void ladder() {
    const SceneFile column = load_scene("column14k");
    head();
    for (const uint32_t threads : options.threads) {
      for (uint32_t level = 0; level < SANDGLASS_LEVEL_SLOW_MOTION && !interrupted(); ++level)
        row("rung " + std::to_string(level) + ", " + sandglass_level_name(level), column, threads, level);
      for (const uint32_t steps : {24u, 32u, 48u, 96u, 128u}) {
        if (!interrupted()) row("small steps " + std::to_string(steps), small_steps(column, steps), threads);
      }
      for (const uint32_t steps : {8u, 16u, 32u, 64u}) {
        for (const uint32_t iterations : {3u, 7u}) {
          if (interrupted()) return;
          row("source " + std::to_string(steps) + " x (" + std::to_string(iterations) + " + 1)",
              source_scheme(column, steps, iterations), threads);
        }
      }
    }
  }

  void machine() {
    const MachinePeak peak = measure_machine_peak();
    std::printf("peak, one thread: %.2f GMAC/s (f32), %.2f GB/s read\n", peak.f32_gmac_per_s, peak.read_gb_per_s);
    keep("peak", "f32_gmac_per_s", "GMAC/s", peak.f32_gmac_per_s, 1);
    keep("peak", "read_gb_per_s", "GB/s", peak.read_gb_per_s, 1);
  }
};

}  // namespace

void add_bench_command(CLI::App& program, int* exit_code) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("bench", "Measure time and error");
  command->add_option("suite", options->suite, "granular, ladder or machine")
      ->required()
      ->check(CLI::IsMember({"granular", "ladder", "machine"}));
  command->add_option("--json", options->json, "Write the measurements to this file");
  command->add_option("--frames", options->frames, "Frames a case; errors are comparable at 100 only (100)")
      ->check(CLI::Range(1u, 10000u));
  command->add_flag("--peers", options->peers, "granular: also run other engines on the same scene, five frames each");
  command->add_option("--threads", options->threads, "Thread counts, separated by commas (1)")
      ->delimiter(',')
      ->check(CLI::Range(1u, 256u));
  command->add_option("--isa", options->isa, "Kernels to use (automatic)");
  command->callback([options, exit_code] {
    listen_for_interrupt();
    Bench bench = {*options, find_isa(options->isa), {}, {}};
    sandglass_scene_desc desc;
    sandglass_scene_desc_default(&desc);
    desc.isa = bench.isa;
    bench.isa_name = sandglass_isa_name(sandglass_scene_isa(Simulation(desc).handle()));
    if (options->suite == "granular") bench.granular();
    else if (options->suite == "ladder") bench.ladder();
    else bench.machine();
    if (!options->json.empty()) write_file(options->json, measurements_json(bench.measurements));
    if (interrupted()) std::puts("interrupted; what was measured is above");
    *exit_code = interrupted() ? k_exit_interrupted : 0;
  });
}

}  // namespace sandglass::host
