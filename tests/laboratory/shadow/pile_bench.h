// What the textures of a pile cost, on one thread of this machine: the soft shadow of one light, and the room's light.
// Each is counted from the columns to the last unit.
#pragma once

#include <string>
#include <vector>

#include "sandglass/types.h"

namespace sandglass::host {

struct PileBenchRow {
  std::string name;
  double ms = 0;  // both textures, on the floor and on the sand: CPU time of the thread, the best of some repeats
  uint32_t units = 0;
  uint64_t bytes = 0;  // of the block
};

std::vector<PileBenchRow> bench_pile_shadow(sandglass_isa isa);

}  // namespace sandglass::host
