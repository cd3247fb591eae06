// An asset's file in memory, aligned as the library asks. A test may damage it and make its checksum right again.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "runtime/asset/file.h"

namespace sandglass::tests {

struct AssetFile {
  std::vector<uint64_t> words;
  uint64_t bytes = 0;

  explicit AssetFile(std::span<const uint8_t> content) : words(content.size() / 8 + 1), bytes(content.size()) {
    if (bytes > 0) std::memcpy(words.data(), content.data(), content.size());
  }
  uint8_t* data() { return reinterpret_cast<uint8_t*>(words.data()); }
  const uint8_t* data() const { return reinterpret_cast<const uint8_t*>(words.data()); }
  void repair_checksum() {
    const uint64_t body = bytes - k_checksum_bytes, hash = hash_bytes(data(), body);
    for (uint32_t i = 0; i < k_checksum_bytes; ++i) data()[body + i] = static_cast<uint8_t>(hash >> 8 * i);
  }
};

}  // namespace sandglass::tests
