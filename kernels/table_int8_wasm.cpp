// The int8 kernels for WebAssembly's 128-bit SIMD.
#include "kernels/int8.h"
#include "kernels/simd_int8/wasm.h"
#define SANDGLASS_INT8_ISA SANDGLASS_ISA_WASM
#define SANDGLASS_INT8_MATRIX 0
namespace sandglass::int8_wasm {
#include "kernels/ambient_texels.inl"
#include "kernels/int8_tile.inl"
#include "kernels/light_convolution.inl"
#include "kernels/shadow_texels.inl"
// The tables of what the files above define.
#include "kernels/int8_tables.inl"
}  // namespace sandglass::int8_wasm
