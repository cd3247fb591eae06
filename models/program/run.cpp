// `sandglass run`: fills a scene with sand, runs its frames under the budget, reports, and ends with the hash of the
// final state.
#include "models/program/run.h"

#include <cstdio>

#include "models/program/commands.h"
#include "models/work/progress.h"

namespace sandglass::host {

int run_command(const RunOptions& options) {
  listen_for_interrupt();
  Run run(options);
  run.execute();
  const uint64_t hash = run.hash();
  run.finish(hash);
  const int exit_code = run.exit_code(hash);
  std::printf("hash 0x%016llx\n", static_cast<unsigned long long>(hash));
  return exit_code;
}

}  // namespace sandglass::host
