// The int8 kernels for AVX-512 with VNNI.
#include "kernels/int8.h"
#include "kernels/simd_int8/avx512vnni.h"
#define SANDGLASS_INT8_ISA SANDGLASS_ISA_AVX512
#define SANDGLASS_INT8_MATRIX 0
namespace sandglass::int8_avx512 {
#include "kernels/ambient_texels.inl"
#include "kernels/int8_tile.inl"
#include "kernels/light_convolution.inl"
#include "kernels/shadow_texels.inl"
// The tables of what the files above define.
#include "kernels/int8_tables.inl"
}  // namespace sandglass::int8_avx512
