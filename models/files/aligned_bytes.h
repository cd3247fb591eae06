// A file's content at an aligned address. The library reads an asset in place, so the address must be a multiple of
// eight.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "models/files/atomic_file.h"

namespace sandglass::host {

class AlignedBytes {
 public:
  AlignedBytes() = default;
  explicit AlignedBytes(std::span<const uint8_t> bytes) : AlignedBytes(bytes.data(), bytes.size()) {}
  explicit AlignedBytes(std::string_view content) : AlignedBytes(content.data(), content.size()) {}

  const void* data() const { return words_.data(); }
  size_t size() const { return size_; }

 private:
  AlignedBytes(const void* bytes, size_t size) : words_(size / 8 + 1), size_(size) {
    std::memcpy(words_.data(), bytes, size);
  }
  std::vector<uint64_t> words_;
  size_t size_ = 0;
};

inline AlignedBytes read_aligned(const std::string& path, const std::string& kind) {
  return AlignedBytes(read_file(path, kind, k_asset_limit));
}

}  // namespace sandglass::host
