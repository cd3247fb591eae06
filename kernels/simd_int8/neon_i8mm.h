// The contract of scalar.h, in the form that k_matrix stands for, on ARM cores with SMMLA: one instruction adds to the
// sums of 2 texels x 2 channels the products of 8 inputs. A Pair holds the sums of texels t, t + 1 and channels c, c +
// 1 in the order (t,c) (t,c+1) (t+1,c) (t+1,c+1). Packed weights are 8 inputs of channel c, then 8 of c + 1.
#pragma once

#include <arm_neon.h>
#include <stdint.h>

namespace sandglass::int8_neon_i8mm {

#define SANDGLASS_INT8_INLINE inline __attribute__((always_inline))
#include "kernels/simd_int8/neon_shared.inl"

constexpr bool k_matrix = true;
constexpr uint32_t k_tile_texels = 4;  // in pairs: 2 x 8 Pairs of sums
constexpr uint32_t k_tile_sums = 4;    // 16 channels in 8 pairs

using Pair = int32x4_t;

SANDGLASS_INT8_INLINE Pair load_bias_pair(const int32_t* p) {
  const int32x2_t two = vld1_s32(p);
  return vcombine_s32(two, two);
}
SANDGLASS_INT8_INLINE int8x16_t load_texel_pair(const uint8_t* first, const uint8_t* second) {
  return vreinterpretq_s8_u8(veorq_u8(vcombine_u8(vld1_u8(first), vld1_u8(second)), vdupq_n_u8(0x80)));
}
SANDGLASS_INT8_INLINE int8x16_t load_weight_pair(const int8_t* p) { return vld1q_s8(p); }
SANDGLASS_INT8_INLINE Pair multiply(Pair sum, int8x16_t texels, int8x16_t weights) {
  return vmmlaq_s32(sum, texels, weights);
}
// The sums of four channels of one texel, from two neighbouring Pairs.
SANDGLASS_INT8_INLINE Sum first_texel(Pair a, Pair b) { return {vcombine_s32(vget_low_s32(a), vget_low_s32(b))}; }
SANDGLASS_INT8_INLINE Sum second_texel(Pair a, Pair b) { return {vcombine_s32(vget_high_s32(a), vget_high_s32(b))}; }

}  // namespace sandglass::int8_neon_i8mm
