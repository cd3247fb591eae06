// The contract of scalar.h for ARM cores with SDOT: 4 outputs.
#pragma once

#include <arm_neon.h>
#include <stdint.h>

namespace sandglass::int8_neon_dotprod {

#define SANDGLASS_INT8_INLINE inline __attribute__((always_inline))
#include "kernels/simd_int8/neon_shared.inl"

constexpr bool k_matrix = false;
constexpr uint32_t k_tile_texels = 4;  // 16 sums, 4 activations, 4 weights: 24 of 32 registers
constexpr uint32_t k_tile_sums = 4;

struct Weights {
  int8x16_t v;
};
struct Activations {
  int8x16_t v;
};
template <int i>
struct Four {
  int8x16_t v;
};

SANDGLASS_INT8_INLINE Weights load_weights(const int8_t* p) { return {vld1q_s8(p)}; }
SANDGLASS_INT8_INLINE Activations load_activations(const uint8_t* p) { return {load_signed(p)}; }
template <int i>
SANDGLASS_INT8_INLINE Four<i> pick(Activations a) {
  return {a.v};
}
// The instruction names the group of four, so nothing is broadcast.
template <int i>
SANDGLASS_INT8_INLINE void dot4(Sum* sum, Four<i> a, Weights w) {
  sum->v = vdotq_laneq_s32(sum->v, w.v, a.v, i);
}

}  // namespace sandglass::int8_neon_dotprod
