// Clocks of iOS and macOS. CLOCK_UPTIME_RAW is mach_absolute_time in nanoseconds: the system converts it, so no
// timebase has to be kept in a global.
#include <time.h>

#include "platform/clock.h"

namespace sandglass {
namespace {

uint64_t uptime_now(void*) { return clock_gettime_nsec_np(CLOCK_UPTIME_RAW); }
uint64_t thread_cpu_now(void*) { return clock_gettime_nsec_np(CLOCK_THREAD_CPUTIME_ID); }

}  // namespace

sandglass_clock clock_thread_cpu() { return {thread_cpu_now, nullptr}; }

}  // namespace sandglass

sandglass_clock sandglass_clock_system(void) { return {sandglass::uptime_now, nullptr}; }
