// The CPU time of the calling thread: what other programs on the machine take does not count.
#pragma once

#include <cstdint>

#include "platform/clock.h"

namespace sandglass::host {

inline double cpu_ms_now() {
  const sandglass_clock clock = clock_thread_cpu();
  return 1e-6 * static_cast<double>(clock.now_ns(clock.user));
}

}  // namespace sandglass::host
