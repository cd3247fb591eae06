// Clocks of Windows. The performance counter never goes backward, and its frequency is fixed while the system runs.
#define WIN32_LEAN_AND_MEAN
#define NOMINMAX
#include <windows.h>

#include "platform/clock.h"

namespace sandglass {
namespace {

constexpr uint64_t k_nanoseconds_per_second = 1000000000u;

uint64_t counter_now(void*) {
  LARGE_INTEGER counter, frequency;
  QueryPerformanceCounter(&counter);  // neither fails since Windows XP
  QueryPerformanceFrequency(&frequency);
  const auto ticks = static_cast<uint64_t>(counter.QuadPart), per_second = static_cast<uint64_t>(frequency.QuadPart);
  // Whole seconds and the rest apart: the product of all ticks and a billion would not fit.
  return ticks / per_second * k_nanoseconds_per_second + ticks % per_second * k_nanoseconds_per_second / per_second;
}

// In steps of some milliseconds: Windows tells no finer.
uint64_t thread_cpu_now(void*) {
  FILETIME created, ended, kernel, user;
  if (GetThreadTimes(GetCurrentThread(), &created, &ended, &kernel, &user) == 0) return 0;
  const auto nanoseconds = [](FILETIME t) { return 100 * ((uint64_t{t.dwHighDateTime} << 32) | t.dwLowDateTime); };
  return nanoseconds(kernel) + nanoseconds(user);
}

}  // namespace

sandglass_clock clock_thread_cpu() { return {thread_cpu_now, nullptr}; }

}  // namespace sandglass

sandglass_clock sandglass_clock_system(void) { return {sandglass::counter_now, nullptr}; }
