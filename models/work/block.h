// Blocks of memory for the library, with the alignment that it needs.
#pragma once

#include <cstdint>
#include <memory>
#include <new>
#include <string>

#include "models/files/failure.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

struct BlockDelete {
  void operator()(void* block) const { ::operator delete(block, std::align_val_t(SANDGLASS_BLOCK_ALIGNMENT)); }
};
using Block = std::unique_ptr<void, BlockDelete>;

// Throws a Failure when there is not enough memory. `purpose` and `remedy` complete its sentence.
inline Block new_block(uint64_t bytes, const char* purpose, const char* remedy) {
  Block block(::operator new(bytes, std::align_val_t(SANDGLASS_BLOCK_ALIGNMENT), std::nothrow));
  if (block == nullptr)
    throw cannot("hold", purpose, "this machine has no block of " + std::to_string(bytes >> 20) + " MiB", remedy);
  return block;
}

}  // namespace sandglass::host
