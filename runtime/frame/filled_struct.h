// How the library fills a struct of the public API for the app. This is the one place that keeps the promise of
// `struct_size`: the app's struct may be shorter, from an older header, or longer, from a newer one.
#pragma once

#include <cstdint>
#include <cstring>

namespace sandglass {

// A struct_size below this was never set: the field itself and one more must fit.
constexpr uint32_t k_struct_size_min = 2 * sizeof(uint32_t);

// Whether `out`, which begins with its struct_size, has room for anything.
inline bool can_fill(const void* out) {
  uint32_t room;
  memcpy(&room, out, sizeof room);
  return room >= k_struct_size_min;
}

// Empties a struct that the app will change, and writes its size. False: there is none.
template <class Struct>
bool empty_struct(Struct* out) {
  if (out == nullptr) return false;
  *out = {};
  out->struct_size = sizeof *out;
  return true;
}

// Copies `filled`, which has `bytes` bytes, as far as the app's struct has room, and sets its struct_size to the number
// of bytes copied.
inline void fill_struct(const void* filled, uint32_t bytes, void* out) {
  if (!can_fill(out)) return;
  uint32_t room;
  memcpy(&room, out, sizeof room);
  const uint32_t written = room < bytes ? room : bytes;
  memcpy(out, filled, written);
  memcpy(out, &written, sizeof written);
}

}  // namespace sandglass
