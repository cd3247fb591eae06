// The hash behind every asset file.
#pragma once

#include <cstdint>

namespace sandglass {

constexpr uint64_t k_checksum_bytes = 8;

inline uint64_t asset_checksum(const uint8_t* bytes, uint64_t count) {  // FNV-1a
  uint64_t hash = 0xCBF29CE484222325ull;
  for (uint64_t i = 0; i < count; ++i) hash = (hash ^ bytes[i]) * 0x100000001B3ull;
  return hash;
}

}  // namespace sandglass
