// The kernels for AVX-512.
#include "kernels/kernels.h"
#include "kernels/simd/avx512.h"
#define SANDGLASS_SIMD simd_avx512
#define SANDGLASS_SIMD_ISA SANDGLASS_ISA_AVX512
#include "kernels/bodies.inl"
