// This system has no profiler to call. perf and its like see the functions themselves, and an app may hand over a hook.
#include "sandglass/sandglass.h"

sandglass_trace sandglass_trace_system(void) { return {nullptr, nullptr, nullptr}; }
