// `sandglass verify SUITE`: claims with their truth, measured now, and wrong settings that must fail them.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "models/cli/commands.h"
#include "models/host/atomic_file.h"
#include "models/host/measurement_json.h"
#include "models/host/physics_cases.h"
#include "models/host/progress.h"
#include "models/host/simulation.h"

namespace sandglass::host {

namespace {

constexpr int k_exit_check_failed = 1, k_exit_interrupted = 130;

struct Options {
  std::string suite, json, isa = "automatic";
};

int verify_granular(const Options& options) {
  const sandglass_isa isa = find_isa(options.isa);
  sandglass_scene_desc desc = physics_desc(0.6);
  desc.isa = isa;
  desc.granular.particle_capacity = 1;
  const std::string isa_name = sandglass_isa_name(sandglass_scene_isa(Simulation(desc).handle()));
  std::vector<Verdict> table;
  {
    Progress progress("verifying", 1);
    table = granular_verdicts(isa, [&](uint32_t done, uint32_t total) {
      progress.total(total);
      progress.done(done);
      return !interrupted();
    });
  }
  uint32_t failed = 0;
  std::vector<Measurement> measurements;
  std::printf("%-28s %13s %13s %13s  %-10s %s\n", "case", "truth", "result", "limit", "unit", "");
  for (const Verdict& v : table) {
    const char* outcome = v.control ? (v.pass ? "fails, as it must" : "PASSES, but must fail")
                          : v.pass  ? "pass"
                                    : "FAIL";
    std::printf("%-28s %13.6g %13.6g %13.6g  %-10s %s\n", v.name.c_str(), v.truth, v.result, v.limit, v.unit.c_str(),
                outcome);
    failed += v.pass ? 0 : 1;
    Measurement m;
    m.suite = "granular", m.scene = v.name, m.metric = "result", m.unit = v.unit, m.isa = isa_name, m.value = v.result;
    m.judgement = Measurement::Judgement{v.truth, v.limit, v.pass, v.control};
    measurements.push_back(m);
  }
  std::printf("%zu rows, %u failed\n", table.size(), failed);
  if (!options.json.empty()) write_file(options.json, measurements_json(measurements));
  return interrupted() ? k_exit_interrupted : failed > 0 ? k_exit_check_failed : 0;
}

}  // namespace

void add_verify_command(CLI::App& program, int* exit_code) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("verify", "Measure claims against their truths; exit code 1 if one fails");
  command->add_option("suite", options->suite, "granular")->required()->check(CLI::IsMember({"granular"}));
  command->add_option("--json", options->json, "Write the rows to this file");
  command->add_option("--isa", options->isa, "Kernels to use (automatic)");
  command->callback([options, exit_code] {
    listen_for_interrupt();
    *exit_code = verify_granular(*options);
  });
}

}  // namespace sandglass::host
