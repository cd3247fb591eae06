// The contract of scalar.h for ARMv8.0 NEON: 4 lanes. minimum and maximum are compares and selects, because FMIN and
// FMAX treat NaN differently from the other sets. There is no fused multiply-add, because it rounds differently.
#pragma once

#include <arm_neon.h>
#include <stdint.h>

namespace sandglass::simd_neon {

#define SANDGLASS_INLINE inline __attribute__((always_inline))
#define SANDGLASS_NOINLINE static __attribute__((noinline))

constexpr uint32_t k_width = 4;

struct Mask {
  uint32x4_t m;
};
struct Int {
  int32x4_t v;
};
struct Float {
  float32x4_t v;
};

SANDGLASS_INLINE Float broadcast(float a) { return {vdupq_n_f32(a)}; }
SANDGLASS_INLINE Int broadcast(int32_t a) { return {vdupq_n_s32(a)}; }
SANDGLASS_INLINE Float load(const float* p) { return {vld1q_f32(p)}; }
SANDGLASS_INLINE Int load(const uint32_t* p) { return {vreinterpretq_s32_u32(vld1q_u32(p))}; }
SANDGLASS_INLINE void store(float* p, Float a) { vst1q_f32(p, a.v); }
SANDGLASS_INLINE void store(uint32_t* p, Int a) { vst1q_u32(p, vreinterpretq_u32_s32(a.v)); }
SANDGLASS_INLINE Int lane_index() {
  const int32_t lanes[4] = {0, 1, 2, 3};
  return {vld1q_s32(lanes)};
}

SANDGLASS_INLINE Float operator+(Float a, Float b) { return {vaddq_f32(a.v, b.v)}; }
SANDGLASS_INLINE Float operator-(Float a, Float b) { return {vsubq_f32(a.v, b.v)}; }
SANDGLASS_INLINE Float operator*(Float a, Float b) { return {vmulq_f32(a.v, b.v)}; }
SANDGLASS_INLINE Float operator/(Float a, Float b) { return {vdivq_f32(a.v, b.v)}; }
SANDGLASS_INLINE Float square_root(Float a) { return {vsqrtq_f32(a.v)}; }
SANDGLASS_INLINE Float minimum(Float a, Float b) { return {vbslq_f32(vcltq_f32(a.v, b.v), a.v, b.v)}; }
SANDGLASS_INLINE Float maximum(Float a, Float b) { return {vbslq_f32(vcgtq_f32(a.v, b.v), a.v, b.v)}; }
SANDGLASS_INLINE Float at_most(Float a, Float bound) { return {vminnmq_f32(a.v, bound.v)}; }
SANDGLASS_INLINE Float at_least(Float a, Float bound) { return {vmaxnmq_f32(a.v, bound.v)}; }
SANDGLASS_INLINE Float absolute(Float a) { return {vabsq_f32(a.v)}; }

SANDGLASS_INLINE Int operator+(Int a, Int b) { return {vaddq_s32(a.v, b.v)}; }
SANDGLASS_INLINE Int operator-(Int a, Int b) { return {vsubq_s32(a.v, b.v)}; }
SANDGLASS_INLINE Int operator&(Int a, Int b) { return {vandq_s32(a.v, b.v)}; }
SANDGLASS_INLINE Int operator|(Int a, Int b) { return {vorrq_s32(a.v, b.v)}; }
SANDGLASS_INLINE Int minimum(Int a, Int b) { return {vminq_s32(a.v, b.v)}; }
SANDGLASS_INLINE Int shift_left(Int a, int count) { return {vshlq_s32(a.v, vdupq_n_s32(count))}; }
SANDGLASS_INLINE Int shift_right(Int a, int count) {
  return {vreinterpretq_s32_u32(vshlq_u32(vreinterpretq_u32_s32(a.v), vdupq_n_s32(-count)))};
}
SANDGLASS_INLINE Int to_int(Float a) { return {vcvtq_s32_f32(a.v)}; }
SANDGLASS_INLINE Int floor_int(Float a) { return {vcvtmq_s32_f32(a.v)}; }
SANDGLASS_INLINE Float to_float(Int a) { return {vcvtq_f32_s32(a.v)}; }
SANDGLASS_INLINE Int as_int(Float a) { return {vreinterpretq_s32_f32(a.v)}; }

SANDGLASS_INLINE Mask operator<(Float a, Float b) { return {vcltq_f32(a.v, b.v)}; }
SANDGLASS_INLINE Mask operator<=(Float a, Float b) { return {vcleq_f32(a.v, b.v)}; }
SANDGLASS_INLINE Mask operator==(Float a, Float b) { return {vceqq_f32(a.v, b.v)}; }
SANDGLASS_INLINE Mask within(Float a, Float limit) { return {vcaltq_f32(a.v, limit.v)}; }
SANDGLASS_INLINE Mask operator<(Int a, Int b) { return {vcltq_s32(a.v, b.v)}; }
SANDGLASS_INLINE Mask operator==(Int a, Int b) { return {vceqq_s32(a.v, b.v)}; }
SANDGLASS_INLINE Mask operator&(Mask a, Mask b) { return {vandq_u32(a.m, b.m)}; }
SANDGLASS_INLINE Mask operator|(Mask a, Mask b) { return {vorrq_u32(a.m, b.m)}; }
SANDGLASS_INLINE Mask and_not(Mask a, Mask b) { return {vbicq_u32(a.m, b.m)}; }
SANDGLASS_INLINE bool any(Mask a) { return vmaxvq_u32(a.m) != 0; }
SANDGLASS_INLINE bool all(Mask a) { return vminvq_u32(a.m) != 0; }
SANDGLASS_INLINE uint32_t count(Mask a) { return vaddvq_u32(vshrq_n_u32(a.m, 31)); }
SANDGLASS_INLINE uint32_t first(Mask a) {
  const uint64_t halves = vget_lane_u64(vreinterpret_u64_u16(vmovn_u32(a.m)), 0);  // 16 bits a lane
  return static_cast<uint32_t>(__builtin_ctzll(halves)) >> 4;
}
SANDGLASS_INLINE Float select(Mask m, Float a, Float b) { return {vbslq_f32(m.m, a.v, b.v)}; }
SANDGLASS_INLINE Float keep(Mask m, Float a) {
  return {vreinterpretq_f32_u32(vandq_u32(m.m, vreinterpretq_u32_f32(a.v)))};
}
SANDGLASS_INLINE Int select(Mask m, Int a, Int b) { return {vbslq_s32(m.m, a.v, b.v)}; }

SANDGLASS_INLINE float lane_maximum(Float a) { return vmaxvq_f32(a.v); }
SANDGLASS_INLINE float lane_minimum(Float a) { return vminvq_f32(a.v); }

SANDGLASS_INLINE void transpose(float32x4_t r0, float32x4_t r1, float32x4_t r2, float32x4_t r3, float32x4_t out[4]) {
  const float64x2_t a0 = vreinterpretq_f64_f32(vtrn1q_f32(r0, r1)), a1 = vreinterpretq_f64_f32(vtrn2q_f32(r0, r1));
  const float64x2_t a2 = vreinterpretq_f64_f32(vtrn1q_f32(r2, r3)), a3 = vreinterpretq_f64_f32(vtrn2q_f32(r2, r3));
  out[0] = vreinterpretq_f32_f64(vtrn1q_f64(a0, a2));
  out[1] = vreinterpretq_f32_f64(vtrn1q_f64(a1, a3));
  out[2] = vreinterpretq_f32_f64(vtrn2q_f64(a0, a2));
  out[3] = vreinterpretq_f32_f64(vtrn2q_f64(a1, a3));
}

SANDGLASS_INLINE Float gather(const float* base, Int index) {
  int32_t i[4];
  vst1q_s32(i, index.v);
  const float v[4] = {base[i[0]], base[i[1]], base[i[2]], base[i[3]]};
  return {vld1q_f32(v)};
}

SANDGLASS_INLINE void load_records(const float* base, const uint32_t* index, uint32_t stride, Float out[8]) {
  const float* p0 = base + static_cast<uint64_t>(index[0]) * 8;
  const float* p1 = base + static_cast<uint64_t>(index[stride]) * 8;
  const float* p2 = base + static_cast<uint64_t>(index[2 * stride]) * 8;
  const float* p3 = base + static_cast<uint64_t>(index[3 * stride]) * 8;
  const float32x4x2_t r0 = vld1q_f32_x2(p0), r1 = vld1q_f32_x2(p1), r2 = vld1q_f32_x2(p2), r3 = vld1q_f32_x2(p3);
  float32x4_t t[4];
  transpose(r0.val[0], r1.val[0], r2.val[0], r3.val[0], t);
  for (int c = 0; c < 4; ++c) out[c].v = t[c];
  transpose(r0.val[1], r1.val[1], r2.val[1], r3.val[1], t);
  for (int c = 0; c < 4; ++c) out[4 + c].v = t[c];
}
SANDGLASS_INLINE void load_quads(const float* const* lanes, uint32_t offset, Float out[4]) {
  float32x4_t t[4];
  transpose(vld1q_f32(lanes[0] + offset), vld1q_f32(lanes[1] + offset), vld1q_f32(lanes[2] + offset),
            vld1q_f32(lanes[3] + offset), t);
  for (int c = 0; c < 4; ++c) out[c].v = t[c];
}
// Lane by lane, without a transpose of each quad: a product takes its share from a lane of a register.
SANDGLASS_INLINE void blend_quads(const float* const* lanes, const uint32_t offsets[8], const Float share[8],
                                  Float out[4]) {
  float32x4_t sum[4];
  for (int k = 0; k < 8; ++k) {
    const float32x4_t shares[4] = {vmulq_laneq_f32(vld1q_f32(lanes[0] + offsets[k]), share[k].v, 0),
                                   vmulq_laneq_f32(vld1q_f32(lanes[1] + offsets[k]), share[k].v, 1),
                                   vmulq_laneq_f32(vld1q_f32(lanes[2] + offsets[k]), share[k].v, 2),
                                   vmulq_laneq_f32(vld1q_f32(lanes[3] + offsets[k]), share[k].v, 3)};
    for (int l = 0; l < 4; ++l) sum[l] = k == 0 ? shares[l] : vaddq_f32(sum[l], shares[l]);
  }
  float32x4_t t[4];
  transpose(sum[0], sum[1], sum[2], sum[3], t);
  for (int c = 0; c < 4; ++c) out[c].v = t[c];
}
// The first and the last two of 16 bytes.
SANDGLASS_INLINE uint32x4_t load_byte_square(const uint8_t* p) {
  const uint8x16_t row = vld1q_u8(p);
  return vreinterpretq_u32_u8(vextq_u8(row, row, 14));
}
template <uint32_t k_row>
SANDGLASS_INLINE Int load_byte_squares(const uint8_t* const* lanes, int32_t offset) {
  static_assert(k_row == 14);
  const uint32x4_t low = vzip1q_u32(load_byte_square(lanes[0] + offset), load_byte_square(lanes[1] + offset));
  const uint32x4_t high = vzip1q_u32(load_byte_square(lanes[2] + offset), load_byte_square(lanes[3] + offset));
  const uint64x2_t all = vzip1q_u64(vreinterpretq_u64_u32(low), vreinterpretq_u64_u32(high));
  return {vreinterpretq_s32_u16(vrev32q_u16(vreinterpretq_u16_u64(all)))};
}
// One load takes two records apart into x y z w of both and of both their second halves.
SANDGLASS_INLINE void load_records(const float* p, Float out[8]) {
  const float32x4x4_t low = vld4q_f32(p), high = vld4q_f32(p + 16);
  for (int c = 0; c < 4; ++c) {
    out[c].v = vuzp1q_f32(low.val[c], high.val[c]);
    out[4 + c].v = vuzp2q_f32(low.val[c], high.val[c]);
  }
}
SANDGLASS_INLINE void broadcast_record(const float* p, Float out[8]) {
  const float32x4x2_t r = vld1q_f32_x2(p);  // one load; a product can name a lane of it, which saves the copy
  for (int half = 0; half < 2; ++half) {
    out[4 * half].v = vdupq_laneq_f32(r.val[half], 0);
    out[4 * half + 1].v = vdupq_laneq_f32(r.val[half], 1);
    out[4 * half + 2].v = vdupq_laneq_f32(r.val[half], 2);
    out[4 * half + 3].v = vdupq_laneq_f32(r.val[half], 3);
  }
}
SANDGLASS_INLINE void store_records(float* p, const Float in[8]) {
  float32x4_t t[4];
  transpose(in[0].v, in[1].v, in[2].v, in[3].v, t);
  for (int k = 0; k < 4; ++k) vst1q_f32(p + 8 * k, t[k]);
  transpose(in[4].v, in[5].v, in[6].v, in[7].v, t);
  for (int k = 0; k < 4; ++k) vst1q_f32(p + 8 * k + 4, t[k]);
}

SANDGLASS_INLINE void load_differences(const float* base, const uint32_t* first, const uint32_t* second, Float out[8]) {
  float32x4_t low[4], high[4], t[4];
  for (int k = 0; k < 4; ++k) {
    const float32x4x2_t p = vld1q_f32_x2(base + static_cast<uint64_t>(first[k]) * 8);
    const float32x4x2_t q = vld1q_f32_x2(base + static_cast<uint64_t>(second[k]) * 8);
    low[k] = vsubq_f32(q.val[0], p.val[0]);
    high[k] = vsubq_f32(q.val[1], p.val[1]);
  }
  transpose(low[0], low[1], low[2], low[3], t);
  for (int c = 0; c < 4; ++c) out[c].v = t[c];
  transpose(high[0], high[1], high[2], high[3], t);
  for (int c = 0; c < 4; ++c) out[4 + c].v = t[c];
}
SANDGLASS_INLINE void load_approaches(const float* base, const uint32_t* first, const uint32_t* second, Float out[3]) {
  float32x4_t r[4], t[4];
  for (int k = 0; k < 4; ++k) {
    const float32x4x2_t p = vld1q_f32_x2(base + static_cast<uint64_t>(first[k]) * 8);
    const float32x4x2_t q = vld1q_f32_x2(base + static_cast<uint64_t>(second[k]) * 8);
    r[k] = vaddq_f32(vsubq_f32(q.val[0], p.val[0]), vsubq_f32(q.val[1], p.val[1]));
  }
  transpose(r[0], r[1], r[2], r[3], t);
  for (int c = 0; c < 3; ++c) out[c].v = t[c];
}
SANDGLASS_INLINE void subtract_displacements(float* base, const uint32_t* index, const Float d[3]) {
  float32x4_t t[4];
  transpose(d[0].v, d[1].v, d[2].v, vdupq_n_f32(0.0f), t);
  for (int k = 0; k < 4; ++k) {
    float* p = base + static_cast<uint64_t>(index[k]) * 8 + 4;
    const float32x4_t old = vld1q_f32(p);
    vst1q_f32(p, vcopyq_laneq_f32(vsubq_f32(old, t[k]), 3, old, 3));
  }
}

#include "kernels/simd/compress.inl"
constexpr uint8_t k_kept[16] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};

SANDGLASS_INLINE uint32_t compress_store(uint32_t* p, Int v, Mask m) {
  const uint32_t bits[4] = {1, 2, 4, 8};
  const uint32_t kept = vaddvq_u32(vandq_u32(m.m, vld1q_u32(bits)));
  vst1q_u8(reinterpret_cast<uint8_t*>(p), vqtbl1q_u8(vreinterpretq_u8_s32(v.v), vld1q_u8(k_compress[kept])));
  return k_kept[kept];
}

}  // namespace sandglass::simd_neon
