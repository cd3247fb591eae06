// How a struct of the public API reaches the caller that wants it filled: the one place that knows what `struct_size`
// promises. The caller's may be that of an older header, and shorter, or of a newer one, and longer.
#pragma once

#include <cstdint>
#include <cstring>

namespace sandglass {

// The size alone tells nothing: below it, struct_size was not set.
constexpr uint32_t k_least_struct_size = 2 * sizeof(uint32_t);

// Whether `out`, which begins with its struct_size, has room for anything.
inline bool can_fill(const void* out) {
  uint32_t room;
  memcpy(&room, out, sizeof room);
  return room >= k_least_struct_size;
}

// Copies as much of `filled`, of `bytes` bytes, as the caller said that there is room for, and says how much that was.
inline void fill_struct(const void* filled, uint32_t bytes, void* out) {
  if (!can_fill(out)) return;
  uint32_t room;
  memcpy(&room, out, sizeof room);
  const uint32_t written = room < bytes ? room : bytes;
  memcpy(out, filled, written);
  memcpy(out, &written, sizeof written);
}

}  // namespace sandglass
