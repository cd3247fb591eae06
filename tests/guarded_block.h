// A block of memory that tells whether it, or anything about it, was written to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sandglass/sandglass.h"

namespace sandglass::test {

constexpr size_t k_guard = 4096;  // bytes watched on either side of the block

// A pattern without period, which a stray write cannot match everywhere.
inline uint8_t poison(size_t i) {
  uint32_t x = static_cast<uint32_t>(i) * 2654435761u;
  return static_cast<uint8_t>((x ^ (x >> 15)) * 2246822519u >> 24);
}

// An aligned block of exactly `bytes` bytes between guards, all of it poisoned.
class GuardedBlock {
 public:
  explicit GuardedBlock(uint64_t bytes) : bytes_(bytes), memory_(bytes + 2 * k_guard + SANDGLASS_BLOCK_ALIGNMENT) {
    for (size_t i = 0; i < memory_.size(); ++i) memory_[i] = poison(i);
    const size_t past = reinterpret_cast<uintptr_t>(memory_.data() + k_guard) % SANDGLASS_BLOCK_ALIGNMENT;
    first_ = k_guard + (SANDGLASS_BLOCK_ALIGNMENT - past) % SANDGLASS_BLOCK_ALIGNMENT;
  }
  uint64_t bytes() const { return bytes_; }
  uint8_t* data() { return memory_.data() + first_; }
  bool untouched() const { return intact(0, memory_.size()); }
  bool guards_intact() const { return intact(0, first_) && intact(first_ + bytes_, memory_.size()); }

 private:
  bool intact(size_t begin, size_t end) const {
    for (size_t i = begin; i < end; ++i)
      if (memory_[i] != poison(i)) return false;
    return true;
  }
  uint64_t bytes_;
  std::vector<uint8_t> memory_;
  size_t first_ = 0;
};

}  // namespace sandglass::test
