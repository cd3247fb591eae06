// See virtual_clock.h.
#include "platform/virtual_clock.h"

namespace sandglass {
namespace {

uint64_t read_virtual(void* user) {
  VirtualClock* clock = static_cast<VirtualClock*>(user);
  const uint64_t reading = clock->now_ns;
  clock->now_ns += clock->step_ns;
  return reading;
}

}  // namespace

sandglass_clock virtual_clock(VirtualClock* clock) { return {read_virtual, clock}; }

}  // namespace sandglass
