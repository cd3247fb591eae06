// `sandglass_lab bench machine`: what this machine can do at most, which the other suites' shares of the peak refer to.
#include <cstdio>

#include "tests/laboratory/bench.h"
#include "tests/laboratory/machine_peak.h"

namespace sandglass::host {

namespace {

void measure(const BenchOptions&, Bench* bench) {
  const MachinePeak peak = measure_machine_peak();
  std::printf("peak, one thread: %.2f GMAC/s (f32), %.2f GMAC/s (int8), %.2f GB/s read\n", peak.f32_gmac_per_s,
              peak.int8_gmac_per_s, peak.read_gb_per_s);
  bench->keep("peak", "f32_gmac_per_s", "GMAC/s", peak.f32_gmac_per_s);
  bench->keep("peak", "int8_gmac_per_s", "GMAC/s", peak.int8_gmac_per_s);
  bench->keep("peak", "read_gb_per_s", "GB/s", peak.read_gb_per_s);
}

Options options_of(BenchOptions& o) { return {json_option(o.json)}; }

}  // namespace

Command bench_machine_suite() {
  return bench_command("machine", "This machine: peak arithmetic and memory speed of one thread", options_of, measure);
}

}  // namespace sandglass::host
