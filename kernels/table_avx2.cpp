// The kernels for avx2.
#include "kernels/simd/avx2.h"
#include "kernels/kernels.h"
#define SANDGLASS_SIMD simd_avx2
#define SANDGLASS_SIMD_ISA SANDGLASS_ISA_AVX2
#include "kernels/bodies.inl"
