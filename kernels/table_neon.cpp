// The kernels for neon.
#include "kernels/simd/neon.h"
#include "kernels/kernels.h"
#define SANDGLASS_SIMD simd_neon
#define SANDGLASS_SIMD_ISA SANDGLASS_ISA_NEON
#include "kernels/bodies.inl"
