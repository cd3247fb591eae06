// `sandglass bench SUITE`: times with the error of the same run in the same row.
#include <cstdio>
#include <functional>
#include <thread>

#include "kernels/int8.h"
#include "models/cli/commands.h"
#include "models/cli/options.h"
#include "models/host/atomic_file.h"
#include "models/host/failure.h"
#include "models/host/granular_bench.h"
#include "models/host/machine_peak.h"
#include "models/host/measurement_json.h"
#include "models/host/metrics.h"
#include "models/host/peer_bullet.h"
#include "models/host/plot.h"
#include "models/host/progress.h"
#include "models/host/simulation.h"
#include "models/lighting/excerpts.h"
#include "models/lighting/lighting_bench.h"
#ifdef SANDGLASS_HAVE_BAKE
#include "models/host/mesh/generated.h"
#include "models/shadow/shadow_bench.h"
#include "models/shadow/shadow_curves.h"
#endif

namespace sandglass::host {

namespace {

constexpr int k_exit_interrupted = 130;
constexpr uint32_t k_peer_frames = 5;     // other engines take seconds a frame
constexpr uint32_t k_search_threads = 4;  // the search needs errors only, and they do not depend on threads

struct Options {
  std::string suite, json, out, isa = "automatic", mesh;
  std::vector<std::string> assets;
  uint32_t frames = 100;
  bool peers = false;
  std::vector<uint32_t> threads = {1}, thresholds;
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

  // One series of the error-time plane.
  struct Curve {
    const char* name;
    Colour colour;
    PlotSeries::Mark mark;
    bool line;
    std::vector<BenchRow> rows;
  };

  // The error-time plane: every rung of the quality ladder, the default scheme with other sub-steps, the source's
  // scheme.
  void ladder() {
    const SceneFile column = load_scene("column14k");
    head();
    std::vector<Curve> curves = {{"source, 3 iterations", {110, 110, 120}, PlotSeries::Mark::ring, true, {}},
                                 {"source, 7 iterations", {60, 60, 66}, PlotSeries::Mark::square, true, {}},
                                 {"small steps, one iteration", {28, 110, 150}, PlotSeries::Mark::disk, true, {}},
                                 {"rungs of the ladder", {196, 98, 16}, PlotSeries::Mark::disk, false, {}}};
    for (const uint32_t threads : options.threads) {
      for (Curve& curve : curves) curve.rows.clear();
      for (uint32_t level = 0; level < SANDGLASS_LEVEL_SLOW_MOTION && !interrupted(); ++level)
        curves[3].rows.push_back(
            row("rung " + std::to_string(level) + ", " + sandglass_level_name(level), column, threads, level));
      for (const uint32_t steps : {24u, 32u, 48u, 64u, 96u, 128u}) {
        if (!interrupted())
          curves[2].rows.push_back(row("small steps " + std::to_string(steps), small_steps(column, steps), threads));
      }
      for (const uint32_t steps : {8u, 16u, 32u, 64u}) {
        for (const uint32_t iterations : {3u, 7u}) {
          if (interrupted()) return;
          curves[iterations == 7 ? 1 : 0].rows.push_back(
              row("source " + std::to_string(steps) + " x (" + std::to_string(iterations) + " + 1)",
                  source_scheme(column, steps, iterations), threads));
        }
      }
    }
    if (options.out.empty() || interrupted()) return;
    make_folder(options.out);
    Plot overlap, angle;
    overlap.title = "Error against time: column of 14,280 particles";
    overlap.x = angle.x = {"solver, ms a frame", 10.0, 200.0, true};
    overlap.y = {"P99 of the overlap, % of r", 0.04, 100.0, true};
    angle.title = "Angle of the pile against time";
    angle.y = {"angle, degrees", 0.0, 40.0, false};
    overlap.legend_right = false, angle.legend_right = true;
    for (const Curve& curve : curves) {
      PlotSeries series;
      series.name = curve.name, series.colour = curve.colour, series.mark = curve.mark, series.line = curve.line;
      for (const BenchRow& point : curve.rows)
        series.x.push_back(point.ms_solver), series.y.push_back(100.0 * point.overlap_p99);
      overlap.series.push_back(series);
      series.y.clear();
      for (const BenchRow& point : curve.rows) series.y.push_back(point.angle_deg);
      angle.series.push_back(series);
    }
    write_png(options.out + "/ladder_overlap.png", draw_plot(overlap));
    write_png(options.out + "/ladder_angle.png", draw_plot(angle));
    std::printf("plots          %s/ladder_overlap.png, ladder_angle.png\n", options.out.c_str());
  }

  // How time and memory grow with the scene: the collapsing column from 1,000 particles and 10,000 grains to 100,000
  // and two million, over its first second.
  void growth() {
    constexpr uint32_t k_frames = 50;
    const SceneFile column = load_scene("column14k");
    std::printf("%9s %9s %2s %12s %14s %11s %13s %10s\n", "particles", "grains", "T", "solver, ms", "ns a particle",
                "refine, ms", "ns a grain", "bytes/item");
    for (const uint32_t threads : options.threads) {
      std::vector<double> particles, solver, grains, refine, items, bytes;
      for (const auto& [count, each] :
           {std::pair{1000u, 10u}, {3000u, 16u}, {10000u, 16u}, {30000u, 16u}, {100000u, 20u}}) {
        const std::string name = "growth " + std::to_string(count);
        BenchRow result;
        {
          Progress progress(name + ", " + std::to_string(threads) + "T", k_frames);
          uint32_t frame = 0;
          result = bench_scene(scaled_column(column, count, each), isa, threads, k_frames, true, [&] {
            progress.done(++frame);
            return !interrupted();
          });
        }
        if (interrupted()) return;
        particles.push_back(result.particles), solver.push_back(result.ms_solver);
        grains.push_back(result.grains), refine.push_back(result.ms_refine);
        items.push_back(result.particles + result.grains), bytes.push_back(static_cast<double>(result.bytes));
        std::printf("%9u %9u %2u %12.2f %14.0f %11.2f %13.1f %10.1f\n", result.particles, result.grains, threads,
                    result.ms_solver, 1e6 * result.ms_solver / result.particles, result.ms_refine,
                    1e6 * result.ms_refine / result.grains, bytes.back() / items.back());
        std::fflush(stdout);
        keep(name, "ms_solver", "ms", result.ms_solver, threads);
        keep(name, "ms_refine", "ms", result.ms_refine, threads);
        keep(name, "bytes", "B", static_cast<double>(result.bytes), threads);
      }
      const double of_solver = fitted_exponent(particles, solver), of_refine = fitted_exponent(grains, refine);
      const double of_bytes = fitted_exponent(items, bytes);
      std::printf("grows with the power  %.2f (solver), %.2f (refinement), %.2f (bytes), %u thread%s\n", of_solver,
                  of_refine, of_bytes, threads, threads == 1 ? "" : "s");
      keep("growth", "exponent_solver", "1", of_solver, threads);
      keep("growth", "exponent_refine", "1", of_refine, threads);
      keep("growth", "exponent_bytes", "1", of_bytes, threads);
    }
  }
#ifdef SANDGLASS_HAVE_BAKE
  void shadow() {
    std::vector<NamedShadow> files;
    for (const std::string& path :
         options.assets.empty() ? std::vector{std::string(SANDGLASS_SHADOWS_DIR) + "/chair.shadow"} : options.assets) {
      const std::string content = read_file(path, "baked shadow");
      files.push_back({path, {content.begin(), content.end()}});
    }
    const std::string mesh_name = options.mesh.empty() ? "chair" : options.mesh;
    MeshResult loaded = make_named(mesh_name);
    if (!loaded) loaded = load_mesh(mesh_name);
    if (!loaded) throw Failure(loaded.error);
    ShadowBench result;
    {
      Progress progress("measuring", 1);
      result = bench_shadow(files[0].bytes, files[0].name, loaded.mesh, isa, options.thresholds,
                            [&](uint32_t done, uint32_t total) {
                              progress.total(total);
                              progress.done(done);
                              return !interrupted();
                            });
    }
    std::printf("%-18s %8s %10s %8s %9s %10s %9s %10s %8s %9s %10s\n", "case", "ms", "+ encoding", "GMAC/s", "of peak",
                "RMSE (f32)", "max (f32)", "RMSE truth", "P99.9", "max", "evaluated");
    for (const ShadowBenchRow& r : result.rows) {
      std::printf("%-18s %8.2f %10.2f %8.1f %8.1f%% %10.4f %9.3f %10.4f %8.3f %9.3f %8.1f %%\n", r.name.c_str(), r.ms,
                  r.ms + r.ms_encoding, r.gmac_per_s, 100 * r.fraction, r.rmse, r.worst, r.rmse_truth, r.p999_truth,
                  r.worst_truth, 100 * r.evaluated);
      keep(r.name, "ms", "ms", r.ms, 1);
      keep(r.name, "ms_with_encoding", "ms", r.ms + r.ms_encoding, 1);
      keep(r.name, "gmac_per_s", "GMAC/s", r.gmac_per_s, 1);
      keep(r.name, "fraction_of_peak", "1", r.fraction, 1);
      keep(r.name, "rmse", "1", r.rmse, 1);
      keep(r.name, "worst", "1", r.worst, 1);
      keep(r.name, "rmse_truth", "1", r.rmse_truth, 1);
      keep(r.name, "p999_truth", "1", r.p999_truth, 1);
      keep(r.name, "worst_truth", "1", r.worst_truth, 1);
      keep(r.name, "evaluated", "1", r.evaluated, 1);
    }
    if (!interrupted() && !result.has_xnnpack) std::puts("XNNPACK is not installed: its rows are left out");
    if (!options.out.empty() && !interrupted()) shadow_curves(files, loaded.mesh, mesh_name);
  }

  void shadow_curves(const std::vector<NamedShadow>& files, const Mesh& mesh, const std::string& object) {
    make_folder(options.out);
    std::vector<ShadowCurve> curves;
    {
      Progress progress("measuring curves", 1);
      curves = measure_shadow_curves(files, mesh, isa, [&](uint32_t done, uint32_t total) {
        progress.total(total);
        progress.done(done);
        return !interrupted();
      });
    }
    if (curves.empty()) return;
    for (const ShadowCurve& curve : curves)
      for (const ShadowCurvePoint& point : curve.points) {
        const std::string name = curve.name + "/" + point.name;
        std::printf("%-24s %8.2f ms, RMSE in the world %.4f\n", name.c_str(), point.ms, point.rmse);
        keep(name, "ms", "ms", point.ms, 1);
        keep(name, "rmse_truth", "1", point.rmse, 1);
      }
    write_png(options.out + "/shadow_curves.png", draw_plot(shadow_curve_plot(curves, object)));
    std::printf("plot           %s/shadow_curves.png\n", options.out.c_str());
  }
#endif

  void lighting() {
    const bool shipped = options.assets.empty();
    const std::string asset = shipped ? std::string(SANDGLASS_LIGHTS_DIR) + "/room.light" : options.assets.front();
    const std::string content = read_file(asset, "lighting network");
    std::vector<Excerpt> excerpts;
    if (shipped) excerpts = read_excerpts(SANDGLASS_LIGHTS_DIR "/../lighting/excerpts");
    LightingBench result;
    {
      Progress progress("measuring", 1);
      result = bench_lighting(std::span(reinterpret_cast<const uint8_t*>(content.data()), content.size()), asset, isa,
                              excerpts, [&](uint32_t done, uint32_t total) {
                                progress.total(total);
                                progress.done(done);
                                return !interrupted();
                              });
    }
    std::printf("%-13s %8s %8s %9s %11s %13s %17s %10s\n", "case", "ms", "GMAC/s", "of peak", "arena, MiB",
                "activations", "longest unit, ms", "to float");
    for (const LightingBenchRow& r : result.rows) {
      char to_float[32] = "-";
      if (result.compared) std::snprintf(to_float, sizeof to_float, "%5.2f deg, %.4f", r.angle_deg, r.difference);
      std::printf("%-13s %8.2f %8.1f %8.1f%% %11.2f %9.2f MiB %17.3f %s\n", r.name.c_str(), r.ms, r.gmac_per_s,
                  100 * r.fraction, r.arena_bytes / (1 << 20), r.activations / (1 << 20), r.longest_unit_ms, to_float);
      keep(r.name, "ms", "ms", r.ms, 1);
      keep(r.name, "gmac_per_s", "GMAC/s", r.gmac_per_s, 1);
      keep(r.name, "fraction_of_peak", "1", r.fraction, 1);
      keep(r.name, "arena_bytes", "B", r.arena_bytes, 1);
      keep(r.name, "longest_unit_ms", "ms", r.longest_unit_ms, 1);
      if (r.activations > 0) keep(r.name, "activation_bytes", "B", r.activations, 1);
      if (result.compared) {
        keep(r.name, "angle_to_f32", "deg", r.angle_deg, 1);
        keep(r.name, "difference_to_f32", "1", r.difference, 1);
      }
      for (const LightingBenchRow::Part& part : r.parts) keep(r.name, ("ms_" + part.name).c_str(), "ms", part.ms, 1);
    }
    if (result.compared)
      std::puts(shipped
                    ? "to float: medians over 56 excerpts of made-up rooms, against the float network behind the file"
                    : "to float: of one image, against xnnpack_f32");
    std::puts("image to 256 x 192, all of it in its frame:");
    for (const LightingImageRow& r : result.images) {
      std::printf("%-15s %6.2f ms in %3u units, %5.2f ms a megapixel, longest unit %.3f ms\n", r.name.c_str(), r.ms,
                  r.units, r.ms / r.megapixels, r.longest_unit_ms);
      keep("image_" + r.name, "ms", "ms", r.ms, 1);
      keep("image_" + r.name, "longest_unit_ms", "ms", r.longest_unit_ms, 1);
    }
    std::puts("by kind of operator, ms:");
    for (const LightingBenchRow& r : result.rows) {
      std::printf("%-13s", r.name.c_str());
      for (const LightingBenchRow::Part& part : r.parts) std::printf(" %s %.2f ", part.name.c_str(), part.ms);
      std::puts("");
    }
    std::puts("own kernels, by operator, us:");
    for (size_t i = 0; i < result.layers.size(); ++i)
      std::printf("%s%s %.0f",
                  i == 0       ? ""
                  : i % 8 == 0 ? "\n"
                               : ", ",
                  result.layers[i].name.c_str() + 6, 1e3 * result.layers[i].ms);
    std::puts("");
    if (!result.has_xnnpack) std::puts("XNNPACK is not installed: its rows are left out");
  }

  void machine() {
    const MachinePeak peak = measure_machine_peak();
    std::printf("peak, one thread: %.2f GMAC/s (f32), %.2f GMAC/s (int8), %.2f GB/s read\n", peak.f32_gmac_per_s,
                peak.int8_gmac_per_s, peak.read_gb_per_s);
    keep("peak", "f32_gmac_per_s", "GMAC/s", peak.f32_gmac_per_s, 1);
    keep("peak", "int8_gmac_per_s", "GMAC/s", peak.int8_gmac_per_s, 1);
    keep("peak", "read_gb_per_s", "GB/s", peak.read_gb_per_s, 1);
  }
};

const std::vector<OptionUse> k_uses = {{"--asset", {"shadow", "lighting"}},
                                       {"--mesh", {"shadow"}},
                                       {"--thresholds", {"shadow"}},
                                       {"--out", {"ladder", "shadow"}},
                                       {"--json", {}},
                                       {"--frames", {"granular", "ladder"}},
                                       {"--peers", {"granular"}},
                                       {"--threads", {"granular", "ladder", "growth"}},
                                       {"--isa", {"granular", "ladder", "growth", "shadow", "lighting"}}};

void check_assets(const Options& options) {
  if (options.assets.size() < 2) return;
  if (options.suite == "lighting") throw Failure("bench lighting measures one network; name one file with --asset");
  if (options.out.empty()) throw Failure("further shadows are only drawn; name a folder for that with --out");
}

}  // namespace

void add_bench_command(Command& program, int* exit_code) {
  const auto options = std::make_shared<Options>();
  Command command = program.add_subcommand("bench", "Measure time and error");
  command->add_option("suite", options->suite, "granular, ladder, growth, shadow, lighting or machine")
      ->required()
      ->check(one_of({"granular", "ladder", "growth", "shadow", "lighting", "machine"}));
  command
      ->add_option(
          "--asset", options->assets,
          "For shadow and lighting: the file (the shipped ones); further shadows of the same mesh are drawn with --out")
      ->delimiter(',');
  command->add_option("--mesh", options->mesh, "For shadow: the mesh that it was baked from (chair)");
  command
      ->add_option("--thresholds", options->thresholds,
                   "For shadow: also these thresholds of the adaptive mode, 0..255")
      ->delimiter(',')
      ->check(range(0u, 255u));
  command->add_option("--out", options->out, "ladder, shadow: write error against time as PNG into this folder");
  command->add_option("--json", options->json, "Write the measurements to this file");
  command->add_option("--frames", options->frames, "Frames a case; errors are comparable at 100 only (100)")
      ->check(range(1u, 10000u));
  command->add_flag("--peers", options->peers, "granular: also run other engines on the same scene, five frames each");
  command->add_option("--threads", options->threads, "Thread counts, separated by commas (1)")
      ->delimiter(',')
      ->check(range(1u, 256u));
  command->add_option("--isa", options->isa, "Kernels, as for run (automatic)");
  command->callback([options, exit_code, command] {
    command.refuse_unused(options->suite, k_uses);
    check_assets(*options);
    listen_for_interrupt();
    Bench bench = {*options, find_isa(options->isa), {}, {}};
    sandglass_scene_desc desc;
    sandglass_scene_desc_default(&desc);
    desc.isa = bench.isa;
    bench.isa_name = sandglass_isa_name(sandglass_scene_isa(Simulation(desc).handle()));
    const Int8Kernels* of_bytes = select_int8_kernels(bench.isa);  // shadows and light have tables of their own
    if (of_bytes != nullptr && (options->suite == "shadow" || options->suite == "lighting"))
      bench.isa_name = sandglass_isa_name(of_bytes->isa);
    if (options->suite == "granular") bench.granular();
    else if (options->suite == "ladder") bench.ladder();
    else if (options->suite == "growth") bench.growth();
    else if (options->suite == "lighting") bench.lighting();
#ifdef SANDGLASS_HAVE_BAKE
    else if (options->suite == "shadow") bench.shadow();
#else
    else if (options->suite == "shadow") throw Failure("this build has no ray tracer; build with Embree");
#endif
    else bench.machine();
    if (!options->json.empty()) write_file(options->json, measurements_json(bench.measurements));
    if (interrupted()) std::puts("interrupted; what was measured is above");
    *exit_code = interrupted() ? k_exit_interrupted : 0;
  });
}

}  // namespace sandglass::host
