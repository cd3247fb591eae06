// Random numbers by position, not by order: the value for a counter does not depend on who asks when, so results do not
// depend on threads.
#pragma once

#include <cstdint>

namespace sandglass::host {

constexpr uint64_t random_mix(uint64_t x) {  // SplitMix64
  x += 0x9E3779B97F4A7C15ull;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
  return x ^ (x >> 31);
}

// In 0..1, 53 bits, of the hash of `counter`.
constexpr double random_unit(uint64_t counter) { return static_cast<double>(random_mix(counter) >> 11) * 0x1p-53; }

// The same as a stream.
struct Random {
  uint64_t state;
  double unit() {
    const double value = random_unit(state);
    state += 0x9E3779B97F4A7C15ull;
    return value;
  }
};

}  // namespace sandglass::host
