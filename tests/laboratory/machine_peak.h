// What this machine can do at best, for putting measured times into proportion: one thread, a fraction of a second
// each.
#pragma once

namespace sandglass::host {

struct MachinePeak {
  double f32_gmac_per_s = 0.0;   // multiply-adds on registers, with the widest vectors that the CPU has
  double int8_gmac_per_s = 0.0;  // dot products of bytes on registers, the same way; 0 where the CPU has none
  double read_gb_per_s = 0.0;    // from memory, far beyond every cache
};
MachinePeak measure_machine_peak();

}  // namespace sandglass::host
