// One walk over a description lays out a block. With a null base the walk counts bytes; with the block it hands out the
// same regions. So size and creation cannot drift apart. Every region has a name and starts on a cache line; a scene
// reports its regions.
#pragma once

#include <cstdint>

#include "sandglass/sandglass.h"

namespace sandglass {

constexpr uint32_t k_region_capacity = 104;  // a scene with everything has 98

struct Layout {
  uint8_t* base = nullptr;  // null: only count
  uint64_t size = 0;
  sandglass_region regions[k_region_capacity] = {};
  uint32_t region_count = 0;
};

// A region of `count` items of T, aligned to SANDGLASS_BLOCK_ALIGNMENT; null while counting. Its bytes are rounded up
// to that alignment, so a kernel may touch whole vectors at its end.
template <class T>
T* layout_region(Layout* layout, const char* name, uint64_t count) {
  const uint64_t size = sizeof(T);  // NOLINT(bugprone-sizeof-expression): some regions hold pointers
  const uint64_t bytes =
      (count * size + SANDGLASS_BLOCK_ALIGNMENT - 1) / SANDGLASS_BLOCK_ALIGNMENT * SANDGLASS_BLOCK_ALIGNMENT;
  const uint64_t offset = layout->size;
  layout->size += bytes;
  if (bytes == 0) return nullptr;
  if (layout->region_count < k_region_capacity) layout->regions[layout->region_count++] = {name, offset, bytes};
  return layout->base == nullptr ? nullptr : reinterpret_cast<T*>(layout->base + offset);
}

}  // namespace sandglass
