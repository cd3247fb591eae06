// A clock made of numbers, for tests and for `--clock virtual`: it gives the same readings on every machine, so the
// governor makes the same plans. It moves when its owner sets `now_ns`, and by a fixed step after each reading.
#pragma once

#include "sandglass/sandglass.h"

namespace sandglass {

// Of the program's virtual clock, which advances by this much at every reading. The library reads it once or twice a
// work unit. So a plan depends only on the scene and the budget.
constexpr uint64_t k_virtual_step_ns = 5000;

struct VirtualClock {
  uint64_t now_ns = 0;   // what the next reading returns
  uint64_t step_ns = 0;  // added after every reading
};

// The clock as the library takes it. `clock` must outlive its use.
sandglass_clock virtual_clock(VirtualClock* clock);

}  // namespace sandglass
