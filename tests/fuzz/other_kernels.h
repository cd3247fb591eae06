// The kernels that an input is tried on beside the scalar ones. All sets that this processor has get their share of the
// inputs, and one input always gets the same.
#pragma once

#include <vector>

#include "runtime/math/hash.h"
#include "sandglass/types.h"

namespace sandglass::fuzz {

inline sandglass_isa other_kernels(const uint8_t* data, size_t size) {
  static const std::vector<sandglass_isa> sets = [] {
    std::vector<sandglass_isa> available;
    for (sandglass_isa isa = SANDGLASS_ISA_SCALAR + 1; isa <= SANDGLASS_ISA_WASM; ++isa)
      if (sandglass_isa_available(isa) != 0) available.push_back(isa);
    if (available.empty()) available.push_back(SANDGLASS_ISA_SCALAR);
    return available;
  }();
  return sets[hash_bytes(data, size) % sets.size()];
}

}  // namespace sandglass::fuzz
