// What the tests of the int8 kernels share: the tables that this CPU runs, aligned arrays, and integers at random.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "kernels/int8.h"

namespace sandglass::tests {

// The tables of int8 kernels that this CPU can run.
inline std::vector<sandglass_isa> int8_sets() {
  std::vector<sandglass_isa> sets;
  for (sandglass_isa isa = SANDGLASS_ISA_SCALAR; isa <= SANDGLASS_ISA_WASM; ++isa)
    if (select_int8_kernels(isa) != nullptr) sets.push_back(isa);
  return sets;
}

template <class T>
struct Aligned {
  struct alignas(64) Line {
    uint8_t bytes[64];
  };
  std::vector<Line> lines;
  explicit Aligned(size_t count) : lines(count * sizeof(T) / 64 + 1) {}
  explicit Aligned(const std::vector<T>& values) : Aligned(values.size()) {
    std::memcpy(lines.data(), values.data(), values.size() * sizeof(T));
  }
  T* data() { return reinterpret_cast<T*>(lines.data()); }
};

struct Integers {
  uint64_t state;
  int64_t next(int64_t low, int64_t high) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return low + static_cast<int64_t>((state >> 33) % static_cast<uint64_t>(high - low + 1));
  }
};

}  // namespace sandglass::tests
