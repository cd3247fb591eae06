// What a room costs on one thread of this machine: an image into its parts, and the light at a place.
#pragma once

#include <string>
#include <vector>

namespace sandglass::host {

struct RoomBenchRow {
  std::string name;
  double ms = 0;  // CPU time of the thread, the best of some repeats
};
struct RoomBench {
  std::vector<RoomBenchRow> rows;
  uint64_t bytes = 0;  // of the block
};

RoomBench bench_room();

}  // namespace sandglass::host
