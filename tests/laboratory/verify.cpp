// `sandglass_lab verify SUITE`: measures claims against their truth, and wrong settings that must fail them. Here are the
// options of the suites, what the suites share, and the suites of sand.
#include "tests/laboratory/verify.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/lighting/dataset.h"
#include "models/program/command_line.h"
#include "models/simulation/simulation.h"
#include "models/work/progress.h"
#include "tests/laboratory/room/day_rows.h"
#include "tests/laboratory/sand/carried_cases.h"
#include "tests/laboratory/sand/follow_cases.h"
#include "tests/laboratory/sand/physics_cases.h"

namespace sandglass::host {

namespace {

const char* outcome_of(const Verdict& v) {
  if (v.control) return v.pass ? "fails, as it must" : "PASSES, but must fail";
  if (!v.pass) return "FAIL";
  return std::isinf(v.limit) ? "reported" : "pass";
}

std::string number_text(double value) {
  char text[32];
  if (std::isinf(value)) return "";
  std::snprintf(text, sizeof text, "%.5g", value);
  return text;
}

void print_verdicts(const std::vector<Verdict>& rows) {
  std::printf("%-11s %-32s %11s %11s %11s  %-11s %s\n", "case", "claim", "truth", "result", "limit", "unit", "");
  for (const Verdict& v : rows)
    std::printf("%-11s %-32s %11s %11s %11s  %-11s %s\n", v.group.c_str(), v.name.c_str(), number_text(v.truth).c_str(),
                number_text(v.result).c_str(), number_text(v.limit).c_str(), v.unit.c_str(), outcome_of(v));
}

}  // namespace

uint32_t count_failed(const std::vector<Verdict>& rows) {
  uint32_t failed = 0;
  for (const Verdict& v : rows) failed += v.pass ? 0 : 1;
  return failed;
}

std::vector<Measurement> measurements_of(const std::string& suite, const std::string& isa, uint32_t threads,
                                         const std::vector<Verdict>& rows) {
  std::vector<Measurement> measurements;
  for (const Verdict& v : rows) {
    Measurement m;
    m.suite = suite;
    m.scene = v.name;
    m.metric = "result";
    m.unit = v.unit;
    m.isa = isa;
    m.value = v.result;
    m.threads = threads;
    m.judgement = Measurement::Judgement{v.truth, v.limit, v.pass, v.control};
    measurements.push_back(m);
  }
  return measurements;
}

int tell(const VerifyOptions& options, const char* suite, const std::string& isa, const std::vector<Verdict>& rows,
         const std::vector<Measurement>& more) {
  print_verdicts(rows);
  const uint32_t failed = count_failed(rows);
  std::printf("%zu rows, %u failed\n", rows.size(), failed);
  std::vector<Measurement> all = measurements_of(suite, isa, options.threads, rows);
  all.insert(all.end(), more.begin(), more.end());
  if (!options.json.empty()) write_file(options.json, measurements_json(all));
  return interrupted() ? k_exit_interrupted : failed > 0 ? k_exit_check_failed : k_exit_done;
}

std::vector<std::string> panoramas_of(const VerifyOptions& options, const char* what,
                                      std::vector<std::string> in_data) {
  if (!options.panoramas.empty()) return find_panoramas(options.panoramas);
  if (data_folder().empty())
    throw Failure(
        std::string("cannot check ") + what +
        ": no panoramas are named. Name .hdr or .exr files, or folders of them, with --panoramas, or the data "
        "folder in SANDGLASS_DATA_DIR.");
  for (std::string& name : in_data) name = data_folder() + "/hdri/" + name;
  return find_panoramas(in_data);
}

std::string manifest_of(const VerifyOptions& options) {
  return options.manifest.empty() && options.panoramas.empty() ? data_folder() + "/manifest.csv" : options.manifest;
}

namespace {

// Refuses --quick for a slow case that is named. It would be left out, and so pass without a check.
void expect_quick(const std::vector<std::string>& cases) {
  const std::vector<std::string> quick = quick_verdict_groups();
  for (const std::string& name : cases)
    if (std::find(quick.begin(), quick.end(), name) == quick.end())
      throw cannot("check", name, "it takes minutes, and --quick leaves such cases out",
                   "Leave --quick out, or name quick cases: " + list_of(quick, "or"));
}

// Shows the progress of a table as it is made.
template <class Make>
auto with_progress(const Make& make) {
  Progress progress("verifying", 1);
  return make([&](uint64_t done, uint64_t total) {
    progress.total(total);
    progress.done(done);
    return !interrupted();
  });
}

std::string kernels_of(sandglass_isa isa) {
  sandglass_scene_desc desc = physics_desc(0.6);
  desc.isa = isa;
  desc.granular.particle_capacity = 1;
  return sandglass_isa_name(sandglass_scene_isa(Simulation(desc).handle()));
}

using Options = std::vector<CommandOption>;

CommandOption panoramas(VerifyOptions& o) {
  return standard("the interiors of SANDGLASS_DATA_DIR",
                  {"--panoramas", &o.panoramas, "FILES", "Files that end in .hdr or .exr, or folders of them"});
}

Options verify_granular_options(VerifyOptions& o) {
  return {standard("all", {"--case", &o.cases, "NAMES", "Only these cases", one_of(verdict_groups())}),
          {"--quick", &o.quick, "", "Only the cases that take seconds"},
          seed_option(o.seed, "Where the poured sand begins"),
          isa_option(o.isa),
          json_option(o.json)};
}

Options verify_follow_options(VerifyOptions& o) {
  return {standard("all", {"--case", &o.cases, "NAMES", "Only these scenes", one_of(follow_groups())}),
          seed_option(o.seed, "How the sand of every scene is turned, and where its grains are"), isa_option(o.isa),
          json_option(o.json)};
}

Options verify_carried_options(VerifyOptions& o) {
  return {standard("all", {"--case", &o.cases, "NAMES", "Only these", one_of(carried_groups())}),
          {"--quick", &o.quick, "", "Three scenes, two budgets, 60 Hz"},
          seed_option(o.seed, "By which part of a frame a way begins later"),
          isa_option(o.isa),
          json_option(o.json)};
}

Options verify_lighting_options(VerifyOptions& o) {
  return {panoramas(o),
          {"--manifest", &o.manifest, "FILE",
           "CSV with the columns file, group and fold: which panoramas show the same place"},
          standard("the shipped one for --panoramas", {"--network", &o.network, "FILE", "Network that estimates"}),
          excludes("--network",
                   standard("the cross-validated ones for SANDGLASS_DATA_DIR",
                            {"--estimates", &o.estimates, "FILE", "Estimates of all views, as train.py writes them"})),
          seed_option(o.seed, "Where the cameras look"),
          threads_option(o.threads),
          json_option(o.json)};
}

Options verify_room_options(VerifyOptions& o) {
  return {standard("the interiors and studios of SANDGLASS_DATA_DIR",
                   {"--panoramas", &o.panoramas, "FILES", "Files that end in .hdr or .exr, or folders of them"}),
          {"--manifest", &o.manifest, "FILE",
           "CSV with the columns file, group and fold: which panoramas show the same place"},
          standard("the shipped one", {"--network", &o.network, "FILE", "Network that estimates one light"}),
          standard("chair, armadillo, trefoil and bucket",
                   {"--mesh", &o.meshes, "MESHES", "Objects on the floor: files, or names of generated meshes"}),
          {"--quick", &o.quick, "", "A quarter of the sessions"},
          seed_option(o.seed, "How the phone sways"),
          threads_option(o.threads),
          json_option(o.json)};
}

Options verify_day_options(VerifyOptions& o) {
  return {panoramas(o),
          standard("all", {"--case", &o.cases, "NAMES", "Only these", one_of(day_cases())}),
          {"--quick", &o.quick, "", "One seed instead of three"},
          seed_option(o.seed, "Lamps, rooms and ways of looking; the two after it are taken too"),
          threads_option(o.threads),
          json_option(o.json)};
}

Options verify_shot_options(VerifyOptions& o) {
  return {panoramas(o),
          {"--manifest", &o.manifest, "FILE",
           "CSV with the columns file, group and fold: which panoramas show the same place"},
          standard("the shipped one", {"--network", &o.network, "FILE", "Network that estimates the light"}),
          {"--quick", &o.quick, "", "Fewer rays: minutes, with errors that are a little larger"},
          seed_option(o.seed, "Where the cameras look, and how the phone sways"),
          threads_option(o.threads),
          json_option(o.json)};
}

Options verify_cast_options(VerifyOptions& o) {
  return {
      standard("chair, and four of SANDGLASS_DATA_DIR",
               {"--mesh", &o.meshes, "MESHES", "What casts: files, or names of generated meshes"}),
      panoramas(o),
      {"--quick", &o.quick, "", "Half of the lights, a quarter of the rooms"},
      seed_option(o.seed, "From where the lights come"),
      {"--picture", &o.picture, "FILE", "JPEG: a chair whose shadow falls on a table and a wall, behind a real bucket"},
      threads_option(o.threads),
      json_option(o.json)};
}

Options verify_look_options(VerifyOptions& o) {
  return {{"--quick", &o.quick, "", "One light, one distance"},
          {"--picture", &o.picture, "FILE", "PNG of every view: drawn on the left, traced on the right"},
          {"--plain", &o.plain, "FILE", "JPEG: the pile by the kit on the left, by plain.frag on the right"},
          threads_option(o.threads),
          json_option(o.json)};
}

Options verify_files_options(VerifyOptions& o) {
  return {required({"FOLDER", &o.folder, "", "Mesh files, also in folders of it"}), json_option(o.json)};
}

}  // namespace

int verify_granular_command(const VerifyOptions& options) {
  if (options.quick) expect_quick(options.cases);
  const VerdictChoice choice = {options.cases, options.quick, find_isa(options.isa), options.seed};
  const std::string isa_name = kernels_of(choice.isa);
  return tell(options, "granular", isa_name,
              with_progress([&](const auto& progress) { return granular_verdicts(choice, progress); }));
}

int verify_follow_command(const VerifyOptions& options) {
  const sandglass_isa isa = find_isa(options.isa);
  const std::string isa_name = kernels_of(isa);
  return tell(options, "follow", isa_name, with_progress([&](const auto& progress) {
                return follow_verdicts(options.cases, options.seed, isa, progress);
              }));
}

int verify_carried_command(const VerifyOptions& options) {
  const VerdictChoice choice = {options.cases, options.quick, find_isa(options.isa), options.seed};
  std::string table;
  const std::vector<Verdict> rows =
      with_progress([&](const auto& progress) { return carried_verdicts(choice, &table, progress); });
  std::fputs(table.c_str(), stdout);
  return tell(options, "carried", kernels_of(choice.isa), rows);
}

std::vector<Command> verify_suites() {
  return {
      command<VerifyOptions>("granular", "Sand: friction, piles, flow, momentum, hard cases", verify_granular_options,
                             verify_granular_command),
      command<VerifyOptions>("follow", "Grains: whether what is drawn is where the particles are, and moves with them",
                             verify_follow_options, verify_follow_command),
      command<VerifyOptions>("carried", "Sand in what is moved: whether it stays and flows where the budget is short",
                             verify_carried_options, verify_carried_command),
      command<VerifyOptions>("lighting", "Light: estimates against labels and baselines", verify_lighting_options,
                             verify_lighting_command),
      command<VerifyOptions>("room", "Rooms: the light as a session has seen it, against the light that is there",
                             verify_room_options, verify_room_command),
      command<VerifyOptions>("day", "A day with a phone: light that changes, covered lenses, lamps, doors",
                             verify_day_options, verify_day_command),
      command<VerifyOptions>("shot", "Whole pictures: composites against path traced truth", verify_shot_options,
                             verify_shot_command),
      command<VerifyOptions>("colour",
                             "Whether what is put into a room has the room's colour, against a path traced truth",
                             verify_shot_options, verify_colour_command),
      command<VerifyOptions>("cast", "Shadows of triangles on floors, walls and below tables, against rays",
                             verify_cast_options, verify_cast_command),
      command<VerifyOptions>("look", "Drawn sand against path traced grains; how its speckle moves",
                             verify_look_options, verify_look_command),
      command<VerifyOptions>("files", "Mesh files of a folder: as the program reads them, and as trimesh does",
                             verify_files_options, verify_files_command),
  };
}

}  // namespace sandglass::host
