// Calls of the app's hooks. Each hook may be absent.
#pragma once

#include "sandglass/sandglass.h"

namespace sandglass {

inline void trace_begin(const sandglass_trace& trace, const char* name) {
  if (trace.begin != nullptr) trace.begin(trace.user, name);
}

inline void trace_end(const sandglass_trace& trace, const char* name) {
  if (trace.end != nullptr) trace.end(trace.user, name);
}

inline void log_write(const sandglass_log& log, const char* sentence) {
  if (log.write != nullptr) log.write(log.user, sentence);
}

}  // namespace sandglass
