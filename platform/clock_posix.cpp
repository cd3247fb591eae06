// Clocks of Linux, Android and WebAssembly, whose host gives the reading. CLOCK_MONOTONIC does not count the time that the device is suspended. The system may
// slew it but never steps it.
#include <time.h>

#include "platform/clock.h"

namespace sandglass {
namespace {

constexpr uint64_t k_nanoseconds_per_second = 1000000000u;

// A clock that cannot be read returns 0. The governor then sees a frozen clock and ends the frame at its cap of work
// units.
uint64_t read_clock(clockid_t id) {
  struct timespec time = {};
  if (clock_gettime(id, &time) != 0) return 0;
  return static_cast<uint64_t>(time.tv_sec) * k_nanoseconds_per_second + static_cast<uint64_t>(time.tv_nsec);
}

uint64_t monotonic_now(void*) { return read_clock(CLOCK_MONOTONIC); }
uint64_t thread_cpu_now(void*) { return read_clock(CLOCK_THREAD_CPUTIME_ID); }

}  // namespace

sandglass_clock clock_thread_cpu() { return {thread_cpu_now, nullptr}; }

}  // namespace sandglass

sandglass_clock sandglass_clock_system(void) { return {sandglass::monotonic_now, nullptr}; }
