// The clock of Windows. The performance counter never goes backward, and its frequency is fixed while the system runs.
// There is no clock_thread_cpu: Windows counts in steps of milliseconds.
#define WIN32_LEAN_AND_MEAN
#define NOMINMAX
#include <windows.h>

#include "platform/clock.h"

namespace sandglass {
namespace {

uint64_t counter_now(void*) {
  LARGE_INTEGER counter, frequency;  // neither call can fail
  QueryPerformanceCounter(&counter);
  QueryPerformanceFrequency(&frequency);
  const auto ticks = static_cast<uint64_t>(counter.QuadPart), per_second = static_cast<uint64_t>(frequency.QuadPart);
  // Whole seconds and the rest apart: the product of all ticks and a billion would not fit.
  constexpr uint64_t k_second = 1000000000u;
  return ticks / per_second * k_second + ticks % per_second * k_second / per_second;
}

}  // namespace
}  // namespace sandglass

sandglass_clock sandglass_clock_system(void) { return {sandglass::counter_now, nullptr}; }
