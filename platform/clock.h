// Clocks that can be handed to a scene. sandglass_clock_system() of the public header is the platform's monotonic
// clock; the clock here counts the processor time of the calling thread, so that tests on a shared machine measure
// their own work and not their neighbours'. Nothing in the library reads a clock that the app did not hand over.
#pragma once

#include "sandglass/sandglass.h"

namespace sandglass {

// Nanoseconds of processor time spent by the calling thread. Reading it is a system call on most kernels: not for apps.
sandglass_clock clock_thread_cpu();

}  // namespace sandglass
