// The suites of sand: `sandglass_lab verify granular` and `follow`.
#include <algorithm>

#include "models/files/failure.h"
#include "models/simulation/simulation.h"
#include "tests/laboratory/sand/follow_cases.h"
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
}  // namespace sandglass::host
