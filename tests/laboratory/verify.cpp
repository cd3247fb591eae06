// `sandglass_lab verify SUITE`: measures claims against their truth, and wrong settings that must fail them. Here is what
// the suites share.
#include "tests/laboratory/verify.h"

#include <cmath>
#include <cstdio>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/lighting/dataset.h"
#include "models/simulation/simulation.h"

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

CommandOption cases_option(VerifyOptions& o, const char* help, const std::vector<std::string>& all) {
  return standard("all", {"--case", &o.cases, "NAMES", help, one_of(all)});
}
CommandOption panoramas_option(VerifyOptions& o, const char* standard_text) {
  return standard(standard_text,
                  {"--panoramas", &o.panoramas, "FILES", "Files that end in .hdr or .exr, or folders of them"});
}
CommandOption manifest_option(VerifyOptions& o) {
  return {"--manifest", &o.manifest, "FILE",
          "CSV with the columns file, group and fold: which panoramas show the same place"};
}
CommandOption network_option(VerifyOptions& o, const char* help) {
  return standard("the shipped one", {"--network", &o.network, "FILE", help});
}

uint32_t count_failed(const std::vector<Verdict>& rows) {
  uint32_t failed = 0;
  for (const Verdict& v : rows) failed += v.pass ? 0 : 1;
  return failed;
}

std::vector<Measurement> measurements_of(const std::string& suite, const std::string& isa, uint32_t threads,
                                         const std::vector<Verdict>& rows) {
  std::vector<Measurement> measurements;
  for (const Verdict& v : rows)
    measurements.push_back({suite, v.name, "result", v.unit, isa, v.result, threads,
                            Measurement::Judgement{v.truth, v.limit, v.pass, v.control}});
  return measurements;
}

std::string kernels_of(sandglass_isa isa) {
  sandglass_scene_desc desc;
  sandglass_scene_desc_default(&desc);
  desc.isa = isa;
  return sandglass_isa_name(sandglass_scene_isa(Simulation(desc).handle()));
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

}  // namespace sandglass::host
