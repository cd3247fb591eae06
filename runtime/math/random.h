// Random numbers: SplitMix64. One 64-bit word of state, any seed is good, independent streams come from hashing. The
// conversions are part of the result's definition: a uniform number is the top 53 bits times 2^-53 (exact, never 1); an
// index below n is the top 32 bits times n, shifted down by 32.
#pragma once

#include <cstdint>

namespace sandglass {

constexpr uint64_t k_random_step = 0x9E3779B97F4A7C15ull;

// Changing any bit of z changes each bit of the result with about even odds.
inline uint64_t mix_bits(uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return z ^ (z >> 31);
}

struct Random {
  uint64_t state;

  uint64_t next() { return mix_bits(state += k_random_step); }
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  uint32_t below(uint32_t n) { return static_cast<uint32_t>(((next() >> 32) * n) >> 32); }
};

// Independent sequences of one seed: what is drawn from one does not shift the others.
inline Random random_stream(uint64_t seed, uint64_t stream) {
  return {mix_bits(seed + k_random_step) ^ mix_bits(stream + 0xD1B54A32D192ED03ull)};
}

}  // namespace sandglass
