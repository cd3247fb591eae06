// How a function of the public API says no: it returns a status and, where the app passed `reason`, stores one static
// sentence there. Success stores NULL. Every function of runtime/ that can fail ends in one of these.
#pragma once

#include <cstdint>

#include "sandglass/types.h"

namespace sandglass {

inline sandglass_status refuse(const char** reason, sandglass_status status, const char* sentence) {
  if (reason != nullptr) *reason = sentence;
  return status;
}

// Most refusals are of this kind.
inline sandglass_status refuse(const char** reason, const char* sentence) {
  return refuse(reason, SANDGLASS_ERROR_INVALID_ARGUMENT, sentence);
}

inline sandglass_status accept(const char** reason) { return refuse(reason, SANDGLASS_OK, nullptr); }

// Whether the app's memory can hold what is created in it, or is worked in.
inline sandglass_status check_block(const void* block, uint64_t bytes, uint64_t need, const char** reason) {
  if (block == nullptr)
    return refuse(reason, "block or scratch is NULL: pass as many bytes as the _bytes function says.");
  if (reinterpret_cast<uintptr_t>(block) % SANDGLASS_BLOCK_ALIGNMENT != 0)
    return refuse(reason, SANDGLASS_ERROR_MEMORY_ALIGNMENT,
                  "the memory block is not aligned to SANDGLASS_BLOCK_ALIGNMENT (64 bytes): align it.");
  if (bytes < need)
    return refuse(reason, SANDGLASS_ERROR_MEMORY_TOO_SMALL,
                  "the memory block is too small: ask the matching _bytes function for the need.");
  return accept(reason);
}

}  // namespace sandglass
