// The CPU time of the calling thread: what other programs on the machine take does not count.
#pragma once

#include <algorithm>
#include <cstdint>

#include "models/work/progress.h"
#include "platform/clock.h"

namespace sandglass::host {

inline double cpu_ms_now() {
  const sandglass_clock clock = clock_thread_cpu();
  return 1e-6 * static_cast<double>(clock.now_ns(clock.user));
}

// The least time of `work` over some repeats, in ms: the machine may be shared. `before` runs before each repeat and is
// not timed. After Ctrl-C the time is that of fewer repeats.
template <class Work, class Before>
double best_cpu_ms(Work work, Before before) {
  constexpr uint32_t k_repeats = 7;
  double best = 1e30;
  for (uint32_t i = 0; i < k_repeats && !(i > 0 && interrupted()); ++i) {
    before();
    const double from = cpu_ms_now();
    work();
    best = std::min(best, cpu_ms_now() - from);
  }
  return best;
}

template <class Work>
double best_cpu_ms(Work work) {
  return best_cpu_ms(work, [] {});
}

}  // namespace sandglass::host
