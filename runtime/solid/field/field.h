// What stands at the start of a field's block. The values follow, x fastest. It holds no address: its bytes are the
// field wherever they lie.
#pragma once

#include "kernels/kernels.h"
#include "sandglass/field.h"

struct alignas(SANDGLASS_BLOCK_ALIGNMENT) sandglass_field {
  uint32_t magic;
  uint64_t version;            // of what it holds, never 0: two fields in the same memory differ by it
  sandglass::FieldGrid shape;  // without its values
};

namespace sandglass {

constexpr uint32_t k_field_magic = 0x64666773;  // "sgfd"

inline FieldGrid grid_of(const sandglass_field* field) {
  FieldGrid grid = field->shape;
  grid.values = reinterpret_cast<const float*>(field + 1);
  return grid;
}

}  // namespace sandglass
