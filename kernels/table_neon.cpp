// The kernels for NEON.
#include "kernels/kernels.h"
#include "kernels/simd/neon.h"
#define SANDGLASS_SIMD simd_neon
#define SANDGLASS_SIMD_ISA SANDGLASS_ISA_NEON
#include "kernels/bodies.inl"
