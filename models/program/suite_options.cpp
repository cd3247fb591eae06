// Every suite of `bench` and `verify` on the command line: its options with their ranges and defaults.
#include "models/program/bench.h"
#include "models/program/command_line.h"
#include "models/program/verify.h"

namespace sandglass::host {

namespace {

using Options = std::vector<CommandOption>;

constexpr const char* k_shipped = "the shipped one";

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
  return {thread_counts(o),
          frames(o),
          {"--out", &o.out, "FOLDER", "Draw error against time into this folder, of the last thread count"},
          isa_option(o.isa),
          json_option(o.json)};
}

Options growth_options(BenchOptions& o) { return {thread_counts(o), isa_option(o.isa), json_option(o.json)}; }

#ifdef SANDGLASS_HAVE_BAKE
Options shadow_options(BenchOptions& o) {
  return {by_commas({"--asset",
                     &o.assets,
                     "FILES",
                     "Baked shadows, separated by commas: the first is measured, --out draws all of them",
                     {},
                     "the shipped chair"}),
          {"--mesh", &o.mesh, "MESH", "The mesh that they were baked from: a file, or a generated mesh's name"},
          by_commas({"--thresholds", &o.thresholds, "LIST", "More thresholds of the adaptive mode, separated by commas",
                     whole_number(0, 255)}),
          {"--out", &o.out, "FOLDER", "Draw error against time into this folder"},
          isa_option(o.isa),
          json_option(o.json)};
}
#endif

Options lighting_options(BenchOptions& o) {
  return {{"--asset", &o.network, "FILE", "The network", {}, k_shipped}, isa_option(o.isa), json_option(o.json)};
}

Options machine_options(BenchOptions& o) { return {json_option(o.json)}; }

Command bench(const char* name, const char* help, Options (*options)(BenchOptions&), BenchSuite suite,
              Bench::Kernels kernels = Bench::Kernels::sand) {
  return command<BenchOptions>(name, help, options,
                               [=](const BenchOptions& o) { return run_bench(name, kernels, suite, o); });
}

CommandOption panoramas(VerifyOptions& o) {
  return {"--panoramas",
          &o.panoramas,
          "FILES",
          "Files that end in .hdr or .exr, or folders of them",
          {},
          "the interiors of SANDGLASS_DATA_DIR"};
}

Options verify_granular_options(VerifyOptions& o) {
  return {{"--case", &o.cases, "NAMES", "Only these cases", one_of(verdict_groups()), "all"},
          {"--quick", &o.quick, "", "Only the cases that take seconds"},
          {"--out", &o.out, "FOLDER", "Write the table and its curves into this folder"},
          isa_option(o.isa),
          json_option(o.json)};
}

Options verify_lighting_options(VerifyOptions& o) {
  return {panoramas(o),
          {"--manifest", &o.manifest, "FILE",
           "CSV with the columns file, group and fold: which panoramas show the same place"},
          {"--network",
           &o.network,
           "FILE",
           "Network that estimates, run as in an app; of a file .npz in float",
           {},
           "the shipped one for --panoramas"},
          excludes("--network", {"--estimates",
                                 &o.estimates,
                                 "FILE",
                                 "Estimates of all views, as train.py writes them",
                                 {},
                                 "the cross-validated ones for SANDGLASS_DATA_DIR"}),
          {"--object", &o.object, "MESH", "Object that is lit: a mesh file, or the name of a generated mesh"},
          {"--views", &o.views, "N", "Views of each panorama", whole_number(1, 8)},
          {"--samples", &o.samples, "N", "Paths a pixel; 0 renders nothing", whole_number(0, 4096)},
          {"--out", &o.out, "FOLDER", "Write tables and pictures into this folder"},
          isa_option(o.isa),
          threads_option(o.threads),
          json_option(o.json)};
}

Options verify_shot_options(VerifyOptions& o) {
  return {panoramas(o),
          {"--network", &o.network, "FILE", "Network that estimates the light", {}, k_shipped},
          seed_option(o.seed, "Where the cameras look: 0 for the study of 20 views, others in all panoramas"),
          {"--out", &o.out, "FOLDER", "Write the table and pictures into this folder; a later run goes on from it"},
          threads_option(o.threads),
          json_option(o.json)};
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

std::vector<Command> verify_suites() {
  return {
      command<VerifyOptions>("granular", "Sand: friction, piles, flow, momentum, hard cases", verify_granular_options,
                             verify_granular_command),
      command<VerifyOptions>("lighting", "Light: estimates against labels and baselines", verify_lighting_options,
                             verify_lighting_command),
      command<VerifyOptions>("shot", "Whole pictures: composites against path traced truth", verify_shot_options,
                             verify_shot_command),
  };
}

}  // namespace sandglass::host
