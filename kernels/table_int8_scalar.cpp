// The int8 kernels for any processor, without vectors.
#include "kernels/int8.h"
#include "kernels/simd_int8/scalar.h"
#define SANDGLASS_INT8_ISA SANDGLASS_ISA_SCALAR
#define SANDGLASS_INT8_MATRIX 0
namespace sandglass::int8_scalar {
#include "kernels/ambient_texels.inl"
#include "kernels/int8_tile.inl"
#include "kernels/light_convolution.inl"
#include "kernels/shadow_texels.inl"
// The tables of what the files above define.
#include "kernels/int8_tables.inl"
}  // namespace sandglass::int8_scalar
