// A clock made of numbers, for tests and for `--clock virtual`: the same readings on every machine, so the same plans.
// It moves when it is told to, by a fixed step a reading, along a recorded trace of increments, or by all three.
// Arithmetic wraps modulo 2^64, so a trace may also run it backward or let it jump.
#pragma once

#include "sandglass/sandglass.h"

namespace sandglass {

struct VirtualClock {
  uint64_t now_ns = 0;              // what the next reading returns
  uint64_t step_ns = 0;             // added after every reading
  const uint64_t* trace = nullptr;  // increments, one a reading, added after it; from the start again at the end
  uint32_t trace_count = 0;
  uint32_t trace_cursor = 0;
  uint64_t readings = 0;
};

// The clock as the library takes it. `clock` must outlive its use.
sandglass_clock virtual_clock(VirtualClock* clock);

void virtual_clock_advance(VirtualClock* clock, uint64_t ns);

// Follows `count` increments from the first one on; the array stays the caller's. A count of 0 ends the following.
void virtual_clock_follow(VirtualClock* clock, const uint64_t* increments, uint32_t count);

}  // namespace sandglass
