// Every suite of `bench` and `verify` on the command line: its options with their ranges and defaults.
#include "models/program/bench.h"
#include "models/program/option_values.h"
#include "models/program/verify.h"

namespace sandglass::host {

namespace {

constexpr const char* k_shipped = "the shipped one";

CLI::Option* add_thread_counts(CLI::App* suite, BenchOptions& o) {
  return add_option(suite, "--threads", o.threads, "LIST", "Thread counts, separated by commas")
      ->delimiter(',')
      ->check(whole_number(1, 256));
}

void add_frames(CLI::App* suite, BenchOptions& o) {
  add_option(suite, "--frames", o.frames, "N", "Frames of a case; errors compare at 100 only")
      ->check(whole_number(1, 10000));
}

CLI::App* add_suite(CLI::App* above, const char* name, const char* help) {
  return above->add_subcommand(name, help)->group("Suites");
}

void add_bench_shadow(CLI::App* suite, int* exit_code) {
#ifdef SANDGLASS_HAVE_BAKE
  BenchOptions& o = options_of(suite, exit_code, bench_shadow_command);
  add_option(suite, "--asset", o.assets, "FILES",
             "Baked shadows, separated by commas: the first is measured, --out draws all of them")
      ->delimiter(',')
      ->default_str("the shipped chair");
  add_option(suite, "--mesh", o.mesh, "MESH", "The mesh that they were baked from: a file, or a generated mesh's name");
  add_option(suite, "--thresholds", o.thresholds, "LIST", "More thresholds of the adaptive mode, separated by commas")
      ->delimiter(',')
      ->check(whole_number(0, 255));
  add_option(suite, "--out", o.out, "FOLDER", "Draw error against time into this folder");
  add_isa(suite, o.isa);
  add_json(suite, o.json);
#else
  static_cast<void>(exit_code);
  leave_out(suite, "this build has no ray tracer", "Install Embree and Eigen, configure and build again.");
#endif
}

void add_verify_lighting(CLI::App* suite, VerifyOptions& o) {
  add_option(suite, "--manifest", o.manifest, "FILE",
             "CSV with the columns file, group and fold: which panoramas show the same place");
  CLI::Option* network =
      suite->add_option("--network", o.network, "Network that estimates, run as in an app; of a file .npz in float");
  network->type_name("FILE")->default_str("the shipped one for --panoramas");
  add_option(suite, "--estimates", o.estimates, "FILE", "Estimates of all views, as train.py writes them")
      ->default_str("the cross-validated ones for SANDGLASS_DATA_DIR")
      ->excludes(network);
  add_option(suite, "--object", o.object, "MESH", "Object that is lit: a mesh file, or the name of a generated mesh");
  add_option(suite, "--views", o.views, "N", "Views of each panorama")->check(whole_number(1, 8));
  add_option(suite, "--samples", o.samples, "N", "Paths a pixel; 0 renders nothing")->check(whole_number(0, 4096));
  add_option(suite, "--out", o.out, "FOLDER", "Write tables and pictures into this folder");
  add_isa(suite, o.isa);
}

void add_panoramas(CLI::App* suite, VerifyOptions& o) {
  add_option(suite, "--panoramas", o.panoramas, "FILES", "Files that end in .hdr or .exr, or folders of them")
      ->default_str("the interiors of SANDGLASS_DATA_DIR");
}

}  // namespace

void add_bench(CLI::App* bench, int* exit_code) {
  bench->require_subcommand(1);
  CLI::App* granular = add_suite(bench, "granular", "Sand: a collapsing column, against the dissertation's scheme");
  BenchOptions& of_sand = options_of(granular, exit_code, bench_granular_command);
  add_thread_counts(granular, of_sand);
  add_frames(granular, of_sand);
  granular->add_flag("--peers", of_sand.peers, "Also run other engines on the same scene, 5 frames each");
  add_isa(granular, of_sand.isa);
  add_json(granular, of_sand.json);

  CLI::App* ladder = add_suite(bench, "ladder", "The quality ladder: error and time of every level");
  BenchOptions& of_ladder = options_of(ladder, exit_code, bench_ladder_command);
  add_thread_counts(ladder, of_ladder);
  add_frames(ladder, of_ladder);
  add_option(ladder, "--out", of_ladder.out, "FOLDER",
             "Draw error against time into this folder, of the last thread count");
  add_isa(ladder, of_ladder.isa);
  add_json(ladder, of_ladder.json);

  CLI::App* growth = add_suite(bench, "growth", "Sand: how time and memory grow with the scene");
  BenchOptions& of_growth = options_of(growth, exit_code, bench_growth_command);
  add_thread_counts(growth, of_growth);
  add_isa(growth, of_growth.isa);
  add_json(growth, of_growth.json);

  add_bench_shadow(add_suite(bench, "shadow", "Shadows: one texture by every way of computing it"), exit_code);

  CLI::App* lighting = add_suite(bench, "lighting", "The lighting network: one estimate by every back end");
  BenchOptions& of_lighting = options_of(lighting, exit_code, bench_lighting_command);
  add_option(lighting, "--asset", of_lighting.network, "FILE", "The network")->default_str(k_shipped);
  add_isa(lighting, of_lighting.isa);
  add_json(lighting, of_lighting.json);

  CLI::App* machine = add_suite(bench, "machine", "This machine: peak arithmetic and memory speed of one thread");
  add_json(machine, options_of(machine, exit_code, bench_machine_command).json);
}

void add_verify(CLI::App* verify, int* exit_code) {
  verify->require_subcommand(1);
  CLI::App* granular = add_suite(verify, "granular", "Sand: friction, piles, flow, momentum, hard cases");
  VerifyOptions& of_sand = options_of(granular, exit_code, verify_granular_command);
  add_option(granular, "--case", of_sand.cases, "NAMES", "Only these cases")
      ->check(one_of(verdict_groups()))
      ->default_str("all");
  granular->add_flag("--quick", of_sand.quick, "Only the cases that take seconds");
  add_option(granular, "--out", of_sand.out, "FOLDER", "Write the table and its curves into this folder");
  add_isa(granular, of_sand.isa);
  add_json(granular, of_sand.json);

  CLI::App* lighting = add_suite(verify, "lighting", "Light: estimates against labels and baselines");
  VerifyOptions& of_light = options_of(lighting, exit_code, verify_lighting_command);
  add_panoramas(lighting, of_light);
  add_verify_lighting(lighting, of_light);
  add_threads(lighting, of_light.threads);
  add_json(lighting, of_light.json);

  CLI::App* shot = add_suite(verify, "shot", "Whole pictures: composites against path traced truth");
  VerifyOptions& of_shot = options_of(shot, exit_code, verify_shot_command);
  add_panoramas(shot, of_shot);
  add_option(shot, "--network", of_shot.network, "FILE", "Network that estimates the light")->default_str(k_shipped);
  add_seed(shot, of_shot.seed, "Where the cameras look: 0 for the study of 20 views, others in all panoramas");
  add_option(shot, "--out", of_shot.out, "FOLDER",
             "Write the table and pictures into this folder; a later run goes on from it");
  add_threads(shot, of_shot.threads);
  add_json(shot, of_shot.json);
}

}  // namespace sandglass::host
