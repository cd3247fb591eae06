// The int8 kernels for neon.
#include "kernels/int8.h"
#include "kernels/simd_int8/neon.h"
#define SANDGLASS_INT8_ISA SANDGLASS_ISA_NEON
#define SANDGLASS_INT8_MATRIX 0
namespace sandglass::int8_neon {
#include "kernels/int8_tile.inl"
#include "kernels/light_convolution.inl"
#include "kernels/shadow_texels.inl"
extern const Int8Kernels k_table;
const Int8Kernels k_table = {SANDGLASS_INT8_ISA, pack_layer, shadow_texels, narrow, transition, wide, stem, pool, dot};
}  // namespace sandglass::int8_neon
