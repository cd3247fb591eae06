// What stands at the start of a field's block. The values follow, x fastest.
#pragma once

#include "kernels/kernels.h"
#include "sandglass/field.h"

struct sandglass_field {
  uint32_t magic;
  sandglass::FieldGrid grid;
};

namespace sandglass {

constexpr uint32_t k_field_magic = 0x64666773;  // "sgfd"

}  // namespace sandglass
