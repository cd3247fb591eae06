// The suites of sand: `sandglass_lab verify granular`, `follow` and `carried`.
#include <algorithm>
#include <cstdio>

#include "models/files/failure.h"
#include "models/simulation/simulation.h"
#include "tests/laboratory/sand/carried_cases.h"
#include "tests/laboratory/sand/follow_cases.h"
#include "tests/laboratory/sand/physics_cases.h"
#include "tests/laboratory/verify.h"

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

std::string kernels_of(sandglass_isa isa) {
  sandglass_scene_desc desc = physics_desc(0.6);
  desc.isa = isa;
  desc.granular.particle_capacity = 1;
  return sandglass_isa_name(sandglass_scene_isa(Simulation(desc).handle()));
}

Options granular_options(VerifyOptions& o) {
  return {cases_option(o, "Only these cases", verdict_groups()),
          {"--quick", &o.quick, "", "Only the cases that take seconds"},
          seed_option(o.seed, "Where the poured sand begins"),
          isa_option(o.isa),
          json_option(o.json)};
}

int run_granular(const VerifyOptions& options) {
  if (options.quick) expect_quick(options.cases);
  const VerdictChoice choice = {options.cases, options.quick, find_isa(options.isa), options.seed};
  const std::string isa_name = kernels_of(choice.isa);
  return tell(options, "granular", isa_name,
              with_progress("verifying", [&](const auto& progress) { return granular_verdicts(choice, progress); }));
}

Options follow_options(VerifyOptions& o) {
  return {cases_option(o, "Only these scenes", follow_groups()),
          seed_option(o.seed, "How the sand of every scene is turned, and where its grains are"), isa_option(o.isa),
          json_option(o.json)};
}

int run_follow(const VerifyOptions& options) {
  const sandglass_isa isa = find_isa(options.isa);
  const std::string isa_name = kernels_of(isa);
  return tell(options, "follow", isa_name, with_progress("verifying", [&](const auto& progress) {
                return follow_verdicts(options.cases, options.seed, isa, progress);
              }));
}

Options carried_options(VerifyOptions& o) {
  return {cases_option(o, "Only these", carried_groups()),
          {"--quick", &o.quick, "", "Three scenes, two budgets, 60 Hz"},
          seed_option(o.seed, "By which part of a frame a way begins later"),
          isa_option(o.isa),
          json_option(o.json)};
}

int run_carried(const VerifyOptions& options) {
  const VerdictChoice choice = {options.cases, options.quick, find_isa(options.isa), options.seed};
  std::string table;
  const std::vector<Verdict> rows =
      with_progress("verifying", [&](const auto& progress) { return carried_verdicts(choice, &table, progress); });
  std::fputs(table.c_str(), stdout);
  return tell(options, "carried", kernels_of(choice.isa), rows);
}

}  // namespace

Command verify_granular_suite() {
  return command<VerifyOptions>("granular", "Sand: friction, piles, flow, momentum, hard cases", granular_options,
                                run_granular);
}

Command verify_follow_suite() {
  return command<VerifyOptions>("follow",
                                "Grains: whether what is drawn is where the particles are, and moves with them",
                                follow_options, run_follow);
}

Command verify_carried_suite() {
  return command<VerifyOptions>("carried",
                                "Sand in what is moved: whether it stays and flows where the budget is short",
                                carried_options, run_carried);
}

}  // namespace sandglass::host
