// What a room costs on one thread of this machine: an image into its parts, unit by unit, and the light at a place.
#pragma once

#include <string>
#include <vector>

namespace sandglass::host {

struct RoomBenchRow {
  std::string name;
  double ms = 0;       // CPU time of the thread, the best of some repeats
  double unit_us = 0;  // the longest unit of that repeat; 0: it has no units
  uint32_t units = 0;
};
struct RoomBench {
  std::vector<RoomBenchRow> rows;
  uint64_t bytes = 0;  // of the block
};

RoomBench bench_room();

}  // namespace sandglass::host
