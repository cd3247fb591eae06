// The kernels for AVX2.
#include "kernels/kernels.h"
#include "kernels/simd/avx2.h"
#define SANDGLASS_SIMD simd_avx2
#define SANDGLASS_SIMD_ISA SANDGLASS_ISA_AVX2
#include "kernels/bodies.inl"
