// Clocks that can be handed to a scene. sandglass_clock_system() of the public header is the system's monotonic clock.
// The clock here counts the processor time of the calling thread, so that tests on a shared machine measure their own
// work and not that of other processes. The library reads no clock that the app did not hand over.
#pragma once

#include "sandglass/sandglass.h"

namespace sandglass {

// Nanoseconds of processor time that the calling thread has used. Not for apps: most systems need a system call for
// each reading.
sandglass_clock clock_thread_cpu();

}  // namespace sandglass
