// `sandglass verify SUITE`: claims with their truth, measured now, and wrong settings that must fail them; as a table
// on the terminal, and with --out as CSV, Markdown and curves.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "models/cli/commands.h"
#include "models/host/atomic_file.h"
#include "models/host/granular_plots.h"
#include "models/host/granular_verdicts.h"
#include "models/host/measurement_json.h"
#include "models/host/physics_cases.h"
#include "models/host/progress.h"
#include "models/host/simulation.h"
#include "models/lighting/dataset.h"
#include "models/shot/light_estimate.h"
#include "models/shot/verify_shot.h"

namespace sandglass::host {

namespace {

constexpr int k_exit_check_failed = 1, k_exit_interrupted = 130;

struct Options {
  std::string suite, json, out, isa = "automatic", panoramas, network;
  uint32_t threads = 1;
  std::vector<std::string> cases;
  bool quick = false;
};

const char* outcome_of(const Verdict& v) {
  if (v.control) return v.pass ? "fails, as it must" : "PASSES, but must fail";
  if (!v.pass) return "FAIL";
  return std::isinf(v.limit) ? "reported" : "pass";
}

std::string number(double value) {
  char text[32];
  if (std::isinf(value)) return "";
  std::snprintf(text, sizeof text, "%.5g", value);
  return text;
}

void print_table(const std::vector<Verdict>& rows) {
  std::printf("%-11s %-32s %11s %11s %11s  %-11s %s\n", "case", "claim", "truth", "result", "limit", "unit", "");
  for (const Verdict& v : rows)
    std::printf("%-11s %-32s %11s %11s %11s  %-11s %s\n", v.group.c_str(), v.name.c_str(), number(v.truth).c_str(),
                number(v.result).c_str(), number(v.limit).c_str(), v.unit.c_str(), outcome_of(v));
}

std::string table_csv(const std::vector<Verdict>& rows) {
  std::string text = "case,claim,unit,truth,result,limit,control,pass\n";
  for (const Verdict& v : rows)
    text += v.group + ",\"" + v.name + "\"," + v.unit + "," + number(v.truth) + "," + number(v.result) + "," +
            number(v.limit) + "," + (v.control ? "1" : "0") + "," + (v.pass ? "1" : "0") + "\n";
  return text;
}

std::string table_markdown(const std::vector<Verdict>& rows) {
  std::string text = "| case | claim | truth | result | limit | unit | |\n|---|---|---|---|---|---|---|\n";
  for (const Verdict& v : rows)
    text += "| " + v.group + " | " + v.name + " | " + number(v.truth) + " | " + number(v.result) + " | " +
            number(v.limit) + " | " + v.unit + " | " + outcome_of(v) + " |\n";
  return text;
}

void write_folder(const std::string& folder, const VerdictTable& table) {
  make_folder(folder);
  write_file(folder + "/verify.csv", table_csv(table.rows));
  write_file(folder + "/verify.md", table_markdown(table.rows));
  std::string drawn;
  for (const GranularPlot& plot : granular_plots(table.curves)) {
    write_png(folder + "/" + plot.name + ".png", draw_plot(plot.plot));
    drawn += ", " + plot.name + ".png";
  }
  std::printf("%s: verify.csv, verify.md%s\n", folder.c_str(), drawn.c_str());
}

int verify_granular(const Options& options) {
  VerdictChoice choice;
  choice.isa = find_isa(options.isa);
  choice.groups = options.cases;
  choice.quick = options.quick;
  sandglass_scene_desc desc = physics_desc(0.6);
  desc.isa = choice.isa;
  desc.granular.particle_capacity = 1;
  const std::string isa_name = sandglass_isa_name(sandglass_scene_isa(Simulation(desc).handle()));
  VerdictTable table;
  {
    Progress progress("verifying", 1);
    table = granular_verdicts(choice, [&](uint64_t done, uint64_t total) {
      progress.total(total);
      progress.done(done);
      return !interrupted();
    });
  }
  print_table(table.rows);
  uint32_t failed = 0;
  std::vector<Measurement> measurements;
  for (const Verdict& v : table.rows) {
    failed += v.pass ? 0 : 1;
    Measurement m;
    m.suite = "granular", m.scene = v.name, m.metric = "result", m.unit = v.unit, m.isa = isa_name, m.value = v.result;
    m.judgement = Measurement::Judgement{v.truth, v.limit, v.pass, v.control};
    measurements.push_back(m);
  }
  std::printf("%zu rows, %u failed\n", table.rows.size(), failed);
  if (!options.json.empty()) write_file(options.json, measurements_json(measurements));
  if (!options.out.empty()) write_folder(options.out, table);
  return interrupted() ? k_exit_interrupted : failed > 0 ? k_exit_check_failed : 0;
}

// Where the data folder's indoor panoramas are; empty: nowhere.
std::vector<std::string> indoor_panoramas(const Options& options) {
  if (!options.panoramas.empty()) return find_panoramas({options.panoramas});
  const char* data = std::getenv("SANDGLASS_DATA_DIR");
  if (data == nullptr || *data == '\0') return {};
  return find_panoramas({std::string(data) + "/hdri/indoor"});
}

int verify_shot(const Options& options) {
  ShotStudyOptions study;
  study.panoramas = indoor_panoramas(options);
  if (study.panoramas.empty()) {
    std::printf("skipped: no panoramas; name a folder with --panoramas, or the data folder in SANDGLASS_DATA_DIR\n");
    return 0;
  }
  study.network = options.network.empty() ? shipped_light_network() : options.network;
  study.folder = options.out, study.threads = options.threads;
  if (options.quick) study.views = 3;
  if (!study.folder.empty()) make_folder(study.folder);
  ShotStudy result;
  {
    Progress progress("compositing and tracing views", std::min(study.views, study.panoramas.size()));
    result = study_shots(study, [&](size_t done) {
      progress.done(done);
      return !interrupted();
    });
  }
  if (interrupted()) return k_exit_interrupted;
  const std::string text = shot_study_text(result);
  std::fputs(text.c_str(), stdout);
  if (study.network.empty()) std::printf("\nno lighting network: without estimates\n");
  if (!study.folder.empty()) write_file(study.folder + "/shot.md", text);
  uint32_t failed = 0;
  std::vector<Measurement> measurements;
  for (const ShotVariant ablation : {ShotVariant::no_shadow, ShotVariant::hard_shadow, ShotVariant::arbitrary_light})
    for (int m = 0; m < k_shot_metrics; ++m) {
      const bool pass = result.beats(ablation, m);
      if (!pass) std::printf("FAIL: true labels do not beat %s in %s\n", name_of(ablation), shot_metric_name(m));
      failed += pass ? 0 : 1;
      Measurement row;
      row.suite = "shot", row.scene = name_of(ablation), row.metric = shot_metric_name(m), row.isa = "automatic";
      row.value = result.mean[static_cast<int>(ablation)][m];
      row.judgement = Measurement::Judgement{result.mean[0][m], result.mean[0][m], pass, true};
      measurements.push_back(row);
    }
  if (!options.json.empty()) write_file(options.json, measurements_json(measurements));
  return failed > 0 ? k_exit_check_failed : 0;
}

}  // namespace

void add_verify_command(CLI::App& program, int* exit_code) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("verify", "Measure claims against their truths; exit code 1 if one fails");
  command->add_option("suite", options->suite, "granular, or shot")
      ->required()
      ->check(CLI::IsMember({"granular", "shot"}));
  command->add_option("--case", options->cases, "Only these cases (all)")->check(CLI::IsMember(verdict_groups()));
  command->add_flag("--quick", options->quick, "Only the cases that take seconds");
  command->add_option(
      "--panoramas", options->panoramas,
      "Of shot: folder of indoor .hdr and .exr files (hdri/indoor of the folder in SANDGLASS_DATA_DIR)");
  command->add_option("--network", options->network,
                      "Of shot: the lighting network's file, instead of the shipped one");
  command->add_option("--threads", options->threads, "Of shot: threads; the result does not depend on them")
      ->check(CLI::Range(1u, 256u));
  command->add_option("--json", options->json, "Write the rows to this file");
  command->add_option("--out", options->out, "Write table and curves into this folder");
  command->add_option("--isa", options->isa, "Kernels to use (automatic)");
  command->callback([options, exit_code] {
    listen_for_interrupt();
    *exit_code = options->suite == "shot" ? verify_shot(*options) : verify_granular(*options);
  });
}

}  // namespace sandglass::host
