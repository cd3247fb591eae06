// FNV-1a, 64 bits: the checksum of asset files and saved scenes, and the hash of a state. It finds damage, not intent:
// who wants to forge a file can. Integer arithmetic only, so it is equal on every machine.
#pragma once

#include <cstdint>

namespace sandglass {

constexpr uint64_t k_hash_basis = 0xCBF29CE484222325ull;
constexpr uint64_t k_hash_prime = 0x100000001B3ull;

// One more value: a byte, or a hash of something else.
constexpr uint64_t hash_with(uint64_t hash, uint64_t value) { return (hash ^ value) * k_hash_prime; }

// Bytes one after another. Pass the hash so far to go on with it.
inline uint64_t hash_bytes(const void* bytes, uint64_t count, uint64_t hash = k_hash_basis) {
  const uint8_t* from = static_cast<const uint8_t*>(bytes);
  for (uint64_t i = 0; i < count; ++i) hash = hash_with(hash, from[i]);
  return hash;
}

}  // namespace sandglass
