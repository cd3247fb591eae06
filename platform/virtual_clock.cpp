// See virtual_clock.h.
#include "platform/virtual_clock.h"

namespace sandglass {
namespace {

uint64_t read_virtual(void* user) {
  VirtualClock* clock = static_cast<VirtualClock*>(user);
  const uint64_t reading = clock->now_ns;
  clock->now_ns += clock->step_ns;
  if (clock->trace_count > 0) {
    clock->now_ns += clock->trace[clock->trace_cursor];
    clock->trace_cursor = clock->trace_cursor + 1 < clock->trace_count ? clock->trace_cursor + 1 : 0;
  }
  ++clock->readings;
  return reading;
}

}  // namespace

sandglass_clock virtual_clock(VirtualClock* clock) { return {read_virtual, clock}; }

void virtual_clock_advance(VirtualClock* clock, uint64_t ns) { clock->now_ns += ns; }

void virtual_clock_follow(VirtualClock* clock, const uint64_t* increments, uint32_t count) {
  clock->trace = increments;
  clock->trace_count = increments == nullptr ? 0 : count;
  clock->trace_cursor = 0;
}

}  // namespace sandglass
