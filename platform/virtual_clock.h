// A clock made of numbers, for tests and for `--clock virtual`: it gives the same readings on every machine, so the
// governor makes the same plans. It moves when it is told to, by a fixed step after each reading, along a list of
// increments, or by all three. Arithmetic wraps modulo 2^64, so an increment may also run it backward or let it jump.
#pragma once

#include "sandglass/sandglass.h"

namespace sandglass {

struct VirtualClock {
  uint64_t now_ns = 0;   // what the next reading returns
  uint64_t step_ns = 0;  // added after every reading
  // Increments, one added after each reading. At the end it begins again.
  const uint64_t* trace = nullptr;
  uint32_t trace_count = 0;
  uint32_t trace_cursor = 0;
  uint64_t readings = 0;
};

// The clock as the library takes it. `clock` must outlive its use.
sandglass_clock virtual_clock(VirtualClock* clock);

void virtual_clock_advance(VirtualClock* clock, uint64_t ns);

// Adds `count` increments in turn from the first one on. The array must outlive this use. A count of 0 ends it.
void virtual_clock_follow(VirtualClock* clock, const uint64_t* increments, uint32_t count);

}  // namespace sandglass
