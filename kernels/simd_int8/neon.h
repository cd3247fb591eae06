// The contract of scalar.h for every 64-bit ARM core: 4 outputs. The sum of two products of a signed activation and a
// weight fits 16 bits (2 * 128 * 127 = 32512), so products are added in pairs there, and the pairs in 32 bits.
#pragma once

#include <arm_neon.h>
#include <stdint.h>

namespace sandglass::int8_neon {

#define SANDGLASS_INT8_INLINE inline __attribute__((always_inline))
#include "kernels/simd_int8/neon_shared.inl"

constexpr bool k_matrix = false;
constexpr uint32_t k_tile_texels = 4;
constexpr uint32_t k_tile_sums = 4;

struct Weights {
  int8x16_t v;
};
struct Activations {
  int8x16_t v;
};
struct Four {
  int8x16_t v;
};

SANDGLASS_INT8_INLINE Weights load_weights(const int8_t* p) { return {vld1q_s8(p)}; }
SANDGLASS_INT8_INLINE Activations load_activations(const uint8_t* p) { return {load_signed(p)}; }
template <int i>
SANDGLASS_INT8_INLINE Four pick(Activations a) {
  return {vreinterpretq_s8_s32(vdupq_laneq_s32(vreinterpretq_s32_s8(a.v), i))};
}
SANDGLASS_INT8_INLINE void dot4(Sum* sum, Four a, Weights w) {
  const int16x8_t low = vmull_s8(vget_low_s8(a.v), vget_low_s8(w.v)), high = vmull_high_s8(a.v, w.v);
  sum->v = vpadalq_s16(sum->v, vpaddq_s16(low, high));
}

}  // namespace sandglass::int8_neon
