// `sandglass bench machine`: what this machine can do at most, which the other suites' shares of the peak refer to.
#include <cstdio>

#include "models/laboratory/machine_peak.h"
#include "models/program/bench.h"
#include "models/program/commands.h"
#include "models/work/progress.h"

namespace sandglass::host {

int bench_machine_command(const BenchOptions& options) {
  listen_for_interrupt();
  Bench measured("machine", "automatic", Bench::Kernels::sand);
  const MachinePeak peak = measure_machine_peak();
  std::printf("peak, one thread: %.2f GMAC/s (f32), %.2f GMAC/s (int8), %.2f GB/s read\n", peak.f32_gmac_per_s,
              peak.int8_gmac_per_s, peak.read_gb_per_s);
  measured.keep("peak", "f32_gmac_per_s", "GMAC/s", peak.f32_gmac_per_s);
  measured.keep("peak", "int8_gmac_per_s", "GMAC/s", peak.int8_gmac_per_s);
  measured.keep("peak", "read_gb_per_s", "GB/s", peak.read_gb_per_s);
  return measured.finish(options.json);
}

}  // namespace sandglass::host
