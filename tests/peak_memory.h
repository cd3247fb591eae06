// What the process has had in memory at most so far.
#pragma once

#include <sys/resource.h>

#include <cstdint>

namespace sandglass::tests {

inline int64_t peak_memory_kib() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

}  // namespace sandglass::tests
