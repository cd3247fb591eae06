// `sandglass verify granular`: the claims about sand, each with its truth and its limit.
#include <algorithm>
#include <cstdio>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/laboratory/sand/granular_plots.h"
#include "models/laboratory/sand/physics_cases.h"
#include "models/program/commands.h"
#include "models/program/nearest_name.h"
#include "models/program/verify.h"
#include "models/simulation/simulation.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

// Refuses --quick for a slow case that is named. It would be left out, and so pass without a check.
void expect_quick(const std::vector<std::string>& cases) {
  const std::vector<std::string> quick = quick_verdict_groups();
  for (const std::string& name : cases)
    if (std::find(quick.begin(), quick.end(), name) == quick.end())
      throw cannot("check", name, "it takes minutes, and --quick leaves such cases out",
                   "Leave --quick out, or name quick cases: " + list_of(quick, "or"));
}

void write_folder(const std::string& folder, const VerdictTable& table) {
  make_folder(folder);
  write_verdicts(folder, table.rows);
  std::string drawn;
  for (const GranularPlot& plot : granular_plots(table.curves)) {
    write_png(folder + "/" + plot.name + ".png", draw_plot(plot.plot));
    drawn += ", " + plot.name + ".png";
  }
  std::printf("%s: verify.csv, verify.md%s\n", folder.c_str(), drawn.c_str());
}

std::string kernels_of(sandglass_isa isa) {
  sandglass_scene_desc desc = physics_desc(0.6);
  desc.isa = isa;
  desc.granular.particle_capacity = 1;
  return sandglass_isa_name(sandglass_scene_isa(Simulation(desc).handle()));
}

}  // namespace

int verify_granular_command(const VerifyOptions& options) {
  listen_for_interrupt();
  if (options.quick) expect_quick(options.cases);
  const VerdictChoice choice = {options.cases, options.quick, find_isa(options.isa)};
  const std::string isa_name = kernels_of(choice.isa);
  VerdictTable table;
  {
    Progress progress("verifying", 1);
    table = granular_verdicts(choice, [&](uint64_t done, uint64_t total) {
      progress.total(total);
      progress.done(done);
      return !interrupted();
    });
  }
  print_verdicts(table.rows);
  const uint32_t failed = count_failed(table.rows);
  std::printf("%zu rows, %u failed\n", table.rows.size(), failed);
  if (!options.json.empty())
    write_file(options.json, measurements_json(measurements_of("granular", isa_name, 1, table.rows)));
  if (!options.out.empty()) write_folder(options.out, table);
  return interrupted() ? k_exit_interrupted : failed > 0 ? k_exit_check_failed : k_exit_done;
}

}  // namespace sandglass::host
