// Random numbers by counter, not by order: a counter always gives the same number. So results do not depend on threads.
#pragma once

#include "runtime/core/random.h"

namespace sandglass::host {

inline uint64_t random_mix(uint64_t counter) { return mix_bits(counter + k_random_step); }

// A number in 0..1: the first of the sequence that starts at `counter`.
inline double random_unit(uint64_t counter) { return Random{counter}.uniform(); }

}  // namespace sandglass::host
