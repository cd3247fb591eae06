// The kernels for any processor, without vectors.
#include "kernels/kernels.h"
#include "kernels/simd/scalar.h"
#define SANDGLASS_SIMD simd_scalar
#define SANDGLASS_SIMD_ISA SANDGLASS_ISA_SCALAR
#include "kernels/bodies.inl"
