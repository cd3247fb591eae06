// The int8 kernels for NEON with SMMLA.
#include "kernels/int8.h"
#include "kernels/simd_int8/neon_i8mm.h"
#define SANDGLASS_INT8_ISA SANDGLASS_ISA_NEON_I8MM
#define SANDGLASS_INT8_MATRIX 1
namespace sandglass::int8_neon_i8mm {
#include "kernels/ambient_texels.inl"
#include "kernels/int8_tile.inl"
#include "kernels/light_convolution.inl"
#include "kernels/shadow_texels.inl"
// The tables of what the files above define.
#include "kernels/int8_tables.inl"
}  // namespace sandglass::int8_neon_i8mm
