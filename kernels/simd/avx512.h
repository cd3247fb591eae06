// The contract of scalar.h for AVX-512 (F, BW, DQ, VL): 16 lanes.
#pragma once

#include <immintrin.h>
#include <stdint.h>

namespace sandglass::simd_avx512 {

#define SANDGLASS_INLINE inline __attribute__((always_inline))
#define SANDGLASS_NOINLINE static __attribute__((noinline))

constexpr uint32_t k_width = 16;

struct Mask {
  __mmask16 m;
};
struct Int {
  __m512i v;
};
struct Float {
  __m512 v;
};

SANDGLASS_INLINE Float broadcast(float a) { return {_mm512_set1_ps(a)}; }
SANDGLASS_INLINE Int broadcast(int32_t a) { return {_mm512_set1_epi32(a)}; }
SANDGLASS_INLINE Float load(const float* p) { return {_mm512_loadu_ps(p)}; }
SANDGLASS_INLINE Int load(const uint32_t* p) { return {_mm512_loadu_si512(p)}; }
SANDGLASS_INLINE void store(float* p, Float a) { _mm512_storeu_ps(p, a.v); }
SANDGLASS_INLINE void store(uint32_t* p, Int a) { _mm512_storeu_si512(p, a.v); }
SANDGLASS_INLINE Int lane_index() { return {_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)}; }

SANDGLASS_INLINE Float operator+(Float a, Float b) { return {_mm512_add_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float operator-(Float a, Float b) { return {_mm512_sub_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float operator*(Float a, Float b) { return {_mm512_mul_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float operator/(Float a, Float b) { return {_mm512_div_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float square_root(Float a) { return {_mm512_sqrt_ps(a.v)}; }
SANDGLASS_INLINE Float minimum(Float a, Float b) { return {_mm512_min_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float maximum(Float a, Float b) { return {_mm512_max_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float at_most(Float a, Float bound) { return minimum(a, bound); }
SANDGLASS_INLINE Float at_least(Float a, Float bound) { return maximum(a, bound); }
SANDGLASS_INLINE Float absolute(Float a) { return {_mm512_abs_ps(a.v)}; }

SANDGLASS_INLINE Int operator+(Int a, Int b) { return {_mm512_add_epi32(a.v, b.v)}; }
SANDGLASS_INLINE Int operator-(Int a, Int b) { return {_mm512_sub_epi32(a.v, b.v)}; }
SANDGLASS_INLINE Int operator&(Int a, Int b) { return {_mm512_and_si512(a.v, b.v)}; }
SANDGLASS_INLINE Int operator|(Int a, Int b) { return {_mm512_or_si512(a.v, b.v)}; }
SANDGLASS_INLINE Int minimum(Int a, Int b) { return {_mm512_min_epi32(a.v, b.v)}; }
SANDGLASS_INLINE Int shift_left(Int a, int count) { return {_mm512_sll_epi32(a.v, _mm_cvtsi32_si128(count))}; }
SANDGLASS_INLINE Int shift_right(Int a, int count) { return {_mm512_srl_epi32(a.v, _mm_cvtsi32_si128(count))}; }
SANDGLASS_INLINE Int to_int(Float a) { return {_mm512_cvttps_epi32(a.v)}; }
SANDGLASS_INLINE Int floor_int(Float a) {
  return {_mm512_cvt_roundps_epi32(a.v, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC)};
}
SANDGLASS_INLINE Float to_float(Int a) { return {_mm512_cvtepi32_ps(a.v)}; }
SANDGLASS_INLINE Int as_int(Float a) { return {_mm512_castps_si512(a.v)}; }

SANDGLASS_INLINE Mask operator<(Float a, Float b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ)}; }
SANDGLASS_INLINE Mask operator<=(Float a, Float b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ)}; }
SANDGLASS_INLINE Mask operator==(Float a, Float b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ)}; }
SANDGLASS_INLINE Mask within(Float a, Float limit) { return absolute(a) < limit; }
SANDGLASS_INLINE Mask operator<(Int a, Int b) { return {_mm512_cmplt_epi32_mask(a.v, b.v)}; }
SANDGLASS_INLINE Mask operator==(Int a, Int b) { return {_mm512_cmpeq_epi32_mask(a.v, b.v)}; }
SANDGLASS_INLINE Mask operator&(Mask a, Mask b) { return {static_cast<__mmask16>(a.m & b.m)}; }
SANDGLASS_INLINE Mask operator|(Mask a, Mask b) { return {static_cast<__mmask16>(a.m | b.m)}; }
SANDGLASS_INLINE Mask and_not(Mask a, Mask b) { return {static_cast<__mmask16>(a.m & ~b.m)}; }
SANDGLASS_INLINE bool any(Mask a) { return a.m != 0; }
SANDGLASS_INLINE bool all(Mask a) { return a.m == 0xFFFF; }
SANDGLASS_INLINE uint32_t count(Mask a) { return static_cast<uint32_t>(__builtin_popcount(a.m)); }
SANDGLASS_INLINE uint32_t first(Mask a) { return static_cast<uint32_t>(__builtin_ctz(a.m)); }
SANDGLASS_INLINE Float select(Mask m, Float a, Float b) { return {_mm512_mask_blend_ps(m.m, b.v, a.v)}; }
SANDGLASS_INLINE Float keep(Mask m, Float a) { return {_mm512_maskz_mov_ps(m.m, a.v)}; }
SANDGLASS_INLINE Int select(Mask m, Int a, Int b) { return {_mm512_mask_blend_epi32(m.m, b.v, a.v)}; }

SANDGLASS_INLINE float lane_maximum(Float a) { return _mm512_reduce_max_ps(a.v); }
SANDGLASS_INLINE float lane_minimum(Float a) { return _mm512_reduce_min_ps(a.v); }

// Transposes 16 records, held as rows r[k] = { record k, record k+8 } of 8 floats each, into 8 component vectors of
// lanes 0..15. It takes three rounds of two-input shuffles; the last also brings the two halves into lane order.
SANDGLASS_INLINE void transpose_in(const __m512 r[8], Float out[8]) {
  // Pairs (0,1) (2,3) (4,5) (6,7) of records: interleave 32-bit, then 64-bit, inside 128-bit blocks.
  const __m512 a0 = _mm512_unpacklo_ps(r[0], r[1]), a1 = _mm512_unpackhi_ps(r[0], r[1]);
  const __m512 a2 = _mm512_unpacklo_ps(r[2], r[3]), a3 = _mm512_unpackhi_ps(r[2], r[3]);
  const __m512 a4 = _mm512_unpacklo_ps(r[4], r[5]), a5 = _mm512_unpackhi_ps(r[4], r[5]);
  const __m512 a6 = _mm512_unpacklo_ps(r[6], r[7]), a7 = _mm512_unpackhi_ps(r[6], r[7]);
  // b_c: blocks { c of records 0-3, c+4 of 0-3, c of 8-11, c+4 of 8-11 }; d_c the same for records 4-7 and 12-15.
  const __m512 b0 = _mm512_shuffle_ps(a0, a2, 0x44), b1 = _mm512_shuffle_ps(a0, a2, 0xEE);
  const __m512 b2 = _mm512_shuffle_ps(a1, a3, 0x44), b3 = _mm512_shuffle_ps(a1, a3, 0xEE);
  const __m512 d0 = _mm512_shuffle_ps(a4, a6, 0x44), d1 = _mm512_shuffle_ps(a4, a6, 0xEE);
  const __m512 d2 = _mm512_shuffle_ps(a5, a7, 0x44), d3 = _mm512_shuffle_ps(a5, a7, 0xEE);
  // Component c: blocks 0 and 2 of b_c and d_c, in the order b0 d0 b2 d2; component c+4: blocks 1 and 3.
  const __m512i low = _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27);
  const __m512i high = _mm512_setr_epi32(4, 5, 6, 7, 20, 21, 22, 23, 12, 13, 14, 15, 28, 29, 30, 31);
  out[0].v = _mm512_permutex2var_ps(b0, low, d0);
  out[1].v = _mm512_permutex2var_ps(b1, low, d1);
  out[2].v = _mm512_permutex2var_ps(b2, low, d2);
  out[3].v = _mm512_permutex2var_ps(b3, low, d3);
  out[4].v = _mm512_permutex2var_ps(b0, high, d0);
  out[5].v = _mm512_permutex2var_ps(b1, high, d1);
  out[6].v = _mm512_permutex2var_ps(b2, high, d2);
  out[7].v = _mm512_permutex2var_ps(b3, high, d3);
}

SANDGLASS_INLINE Float gather(const float* base, Int index) { return {_mm512_i32gather_ps(index.v, base, 4)}; }

SANDGLASS_INLINE void load_records(const float* base, const uint32_t* index, uint32_t stride, Float out[8]) {
  __m512 r[8];
  for (uint32_t k = 0; k < 8; ++k) {
    const float* p = base + static_cast<uint64_t>(index[k * stride]) * 8;
    const float* q = base + static_cast<uint64_t>(index[(k + 8) * stride]) * 8;
    r[k] = _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_load_ps(p)), _mm256_load_ps(q), 1);
  }
  transpose_in(r, out);
}
SANDGLASS_INLINE void load_quads(const float* const* lanes, uint32_t offset, Float out[4]) {
  __m512 r[4];
  for (uint32_t k = 0; k < 4; ++k) {
    r[k] = _mm512_castps128_ps512(_mm_load_ps(lanes[k] + offset));
    r[k] = _mm512_insertf32x4(r[k], _mm_load_ps(lanes[k + 4] + offset), 1);
    r[k] = _mm512_insertf32x4(r[k], _mm_load_ps(lanes[k + 8] + offset), 2);
    r[k] = _mm512_insertf32x4(r[k], _mm_load_ps(lanes[k + 12] + offset), 3);
  }
  const __m512 a = _mm512_unpacklo_ps(r[0], r[1]), b = _mm512_unpackhi_ps(r[0], r[1]);
  const __m512 c = _mm512_unpacklo_ps(r[2], r[3]), d = _mm512_unpackhi_ps(r[2], r[3]);
  out[0].v = _mm512_shuffle_ps(a, c, 0x44);
  out[1].v = _mm512_shuffle_ps(a, c, 0xee);
  out[2].v = _mm512_shuffle_ps(b, d, 0x44);
  out[3].v = _mm512_shuffle_ps(b, d, 0xee);
}
#include "kernels/simd/corners.inl"
SANDGLASS_INLINE void load_records(const float* p, Float out[8]) {
  __m512 r[8];
  for (uint32_t k = 0; k < 8; ++k) {
    r[k] = _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_load_ps(p + 8 * k)), _mm256_load_ps(p + 8 * (k + 8)), 1);
  }
  transpose_in(r, out);
}
SANDGLASS_INLINE void broadcast_record(const float* p, Float out[8]) {
  for (int c = 0; c < 8; ++c) out[c] = broadcast(p[c]);
}
SANDGLASS_INLINE void store_records(float* p, const Float in[8]) {
  // Each input vector is one component of 16 records. Interleaves 4 components at a time into halves of records, 128
  // bits each.
  const __m512 a0 = _mm512_unpacklo_ps(in[0].v, in[1].v), a1 = _mm512_unpackhi_ps(in[0].v, in[1].v);
  const __m512 a2 = _mm512_unpacklo_ps(in[2].v, in[3].v), a3 = _mm512_unpackhi_ps(in[2].v, in[3].v);
  const __m512 a4 = _mm512_unpacklo_ps(in[4].v, in[5].v), a5 = _mm512_unpackhi_ps(in[4].v, in[5].v);
  const __m512 a6 = _mm512_unpacklo_ps(in[6].v, in[7].v), a7 = _mm512_unpackhi_ps(in[6].v, in[7].v);
  // b_k: components 0-3 of lanes k, k+4, k+8, k+12; d_k: components 4-7 of the same lanes.
  const __m512 b[4] = {_mm512_shuffle_ps(a0, a2, 0x44), _mm512_shuffle_ps(a0, a2, 0xEE),
                       _mm512_shuffle_ps(a1, a3, 0x44), _mm512_shuffle_ps(a1, a3, 0xEE)};
  const __m512 d[4] = {_mm512_shuffle_ps(a4, a6, 0x44), _mm512_shuffle_ps(a4, a6, 0xEE),
                       _mm512_shuffle_ps(a5, a7, 0x44), _mm512_shuffle_ps(a5, a7, 0xEE)};
  for (uint32_t k = 0; k < 4; ++k) {
    float* q = p + 8 * k;
    _mm_store_ps(q, _mm512_castps512_ps128(b[k]));
    _mm_store_ps(q + 4, _mm512_castps512_ps128(d[k]));
    _mm_store_ps(q + 32, _mm512_extractf32x4_ps(b[k], 1));
    _mm_store_ps(q + 36, _mm512_extractf32x4_ps(d[k], 1));
    _mm_store_ps(q + 64, _mm512_extractf32x4_ps(b[k], 2));
    _mm_store_ps(q + 68, _mm512_extractf32x4_ps(d[k], 2));
    _mm_store_ps(q + 96, _mm512_extractf32x4_ps(b[k], 3));
    _mm_store_ps(q + 100, _mm512_extractf32x4_ps(d[k], 3));
  }
}

SANDGLASS_INLINE void load_differences(const float* base, const uint32_t* first, const uint32_t* second, Float out[8]) {
  __m512 r[8];
  for (uint32_t k = 0; k < 8; ++k) {
    const __m256 low = _mm256_sub_ps(_mm256_load_ps(base + static_cast<uint64_t>(second[k]) * 8),
                                     _mm256_load_ps(base + static_cast<uint64_t>(first[k]) * 8));
    const __m256 high = _mm256_sub_ps(_mm256_load_ps(base + static_cast<uint64_t>(second[k + 8]) * 8),
                                      _mm256_load_ps(base + static_cast<uint64_t>(first[k + 8]) * 8));
    r[k] = _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
  }
  transpose_in(r, out);
}
// second[k] - first[k] and the same of k + 4, each record in one half.
SANDGLASS_INLINE __m512 difference_of_two(const float* base, const uint32_t* first, const uint32_t* second,
                                          uint32_t k) {
  const __m256 low = _mm256_sub_ps(_mm256_load_ps(base + static_cast<uint64_t>(second[k]) * 8),
                                   _mm256_load_ps(base + static_cast<uint64_t>(first[k]) * 8));
  const __m256 high = _mm256_sub_ps(_mm256_load_ps(base + static_cast<uint64_t>(second[k + 4]) * 8),
                                    _mm256_load_ps(base + static_cast<uint64_t>(first[k + 4]) * 8));
  return _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
}
SANDGLASS_INLINE void load_approaches(const float* base, const uint32_t* first, const uint32_t* second, Float out[3]) {
  __m512 r[4];  // the sums of records k, k + 4, k + 8, k + 12
  for (uint32_t k = 0; k < 4; ++k) {
    const __m512 a = difference_of_two(base, first, second, k), b = difference_of_two(base, first, second, k + 8);
    r[k] = _mm512_add_ps(_mm512_shuffle_f32x4(a, b, 0x88), _mm512_shuffle_f32x4(a, b, 0xDD));
  }
  const __m512 a0 = _mm512_unpacklo_ps(r[0], r[1]), a1 = _mm512_unpackhi_ps(r[0], r[1]);
  const __m512 a2 = _mm512_unpacklo_ps(r[2], r[3]), a3 = _mm512_unpackhi_ps(r[2], r[3]);
  out[0].v = _mm512_shuffle_ps(a0, a2, 0x44);
  out[1].v = _mm512_shuffle_ps(a0, a2, 0xEE);
  out[2].v = _mm512_shuffle_ps(a1, a3, 0x44);
}
#include "kernels/simd/displacement.inl"

SANDGLASS_INLINE void subtract_displacements(float* base, const uint32_t* index, const Float d[3]) {
  const __m512 a0 = _mm512_unpacklo_ps(d[0].v, d[1].v), a1 = _mm512_unpackhi_ps(d[0].v, d[1].v);
  const __m512 b0 = _mm512_unpacklo_ps(d[2].v, d[2].v), b1 = _mm512_unpackhi_ps(d[2].v, d[2].v);
  // t_k: lanes k, k+4, k+8, k+12.
  const __m512 t[4] = {_mm512_shuffle_ps(a0, b0, 0x44), _mm512_shuffle_ps(a0, b0, 0xEE),
                       _mm512_shuffle_ps(a1, b1, 0x44), _mm512_shuffle_ps(a1, b1, 0xEE)};
  for (uint32_t k = 0; k < 4; ++k) {
    subtract_displacement(base + static_cast<uint64_t>(index[k]) * 8 + 4, _mm512_castps512_ps128(t[k]));
    subtract_displacement(base + static_cast<uint64_t>(index[k + 4]) * 8 + 4, _mm512_extractf32x4_ps(t[k], 1));
    subtract_displacement(base + static_cast<uint64_t>(index[k + 8]) * 8 + 4, _mm512_extractf32x4_ps(t[k], 2));
    subtract_displacement(base + static_cast<uint64_t>(index[k + 12]) * 8 + 4, _mm512_extractf32x4_ps(t[k], 3));
  }
}

SANDGLASS_INLINE uint32_t compress_store(uint32_t* p, Int v, Mask m) {
  _mm512_storeu_si512(p, _mm512_maskz_compress_epi32(m.m, v.v));
  return static_cast<uint32_t>(__builtin_popcount(m.m));
}

}  // namespace sandglass::simd_avx512
