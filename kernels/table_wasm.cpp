// The kernels for WebAssembly's 128-bit SIMD.
#include "kernels/kernels.h"
#include "kernels/simd/wasm.h"
#define SANDGLASS_SIMD simd_wasm
#define SANDGLASS_SIMD_ISA SANDGLASS_ISA_WASM
#include "kernels/bodies.inl"
