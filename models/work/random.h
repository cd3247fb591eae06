// Random numbers by position, not by order: the number of a counter does not depend on who asks when, so results do not
// depend on threads.
#pragma once

#include "runtime/core/random.h"

namespace sandglass::host {

inline uint64_t random_mix(uint64_t counter) { return mix_bits(counter + k_random_step); }

// In 0..1: the first number of the sequence that starts at `counter`.
inline double random_unit(uint64_t counter) { return Random{counter}.uniform(); }

}  // namespace sandglass::host
