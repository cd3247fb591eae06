// Random numbers by counter, not by order: a counter always gives the same number. So results do not depend on threads.
#pragma once

#include <cmath>
#include <numbers>

#include "runtime/math/random.h"

namespace sandglass::host {

inline uint64_t random_mix(uint64_t counter) { return mix_bits(counter + k_random_step); }

// A number in 0..1: the first of the sequence that starts at `counter`.
inline double random_unit(uint64_t counter) { return Random{counter}.uniform(); }

// The next number of a normal distribution with deviation 1, by Box and Muller. Takes two of the sequence.
inline double normal_deviate(Random* random) {
  const double far = std::sqrt(-2.0 * std::log(1.0 - random->uniform()));
  return far * std::cos(2.0 * std::numbers::pi * random->uniform());
}

}  // namespace sandglass::host
