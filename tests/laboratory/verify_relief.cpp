// `sandglass_lab verify relief`: the heights that a relief gathers from a device's depth images of a table, against the
// truth, sand that lies on them, and both without what makes them hold.
#include "tests/laboratory/relief/relief_rows.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_seeds = 8, k_quick_seeds = 1;

Options options_of(VerifyOptions& o) {
  return {{"--quick", &o.quick, "", "One seed of noise in place of eight"}, json_option(o.json)};
}

int run(const VerifyOptions& options) {
  const uint32_t seeds = options.quick ? k_quick_seeds : k_seeds;
  const std::vector<Verdict> rows =
      with_steps("verifying", relief_recordings(seeds), [&](const auto& step) { return relief_verdicts(seeds, step); });
  return tell(options, "relief", "scalar", rows);
}

}  // namespace

Command verify_relief_suite() {
  return command<VerifyOptions>("relief", "Heights of a table from depth images against the truth, and sand on them",
                                options_of, run);
}

}  // namespace sandglass::host
