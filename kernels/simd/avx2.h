// The contract of scalar.h for AVX2: 8 lanes. A mask is a vector of all-ones or all-zeros lanes.
#pragma once

#include <immintrin.h>
#include <stdint.h>

namespace sandglass::simd_avx2 {

#define SANDGLASS_INLINE inline __attribute__((always_inline))
#define SANDGLASS_NOINLINE static __attribute__((noinline))

constexpr uint32_t k_width = 8;

struct Mask {
  __m256 m;
};
struct Int {
  __m256i v;
};
struct Float {
  __m256 v;
};

SANDGLASS_INLINE Float broadcast(float a) { return {_mm256_set1_ps(a)}; }
SANDGLASS_INLINE Int broadcast(int32_t a) { return {_mm256_set1_epi32(a)}; }
SANDGLASS_INLINE Float load(const float* p) { return {_mm256_loadu_ps(p)}; }
SANDGLASS_INLINE Int load(const uint32_t* p) { return {_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p))}; }
SANDGLASS_INLINE void store(float* p, Float a) { _mm256_storeu_ps(p, a.v); }
SANDGLASS_INLINE void store(uint32_t* p, Int a) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a.v); }
SANDGLASS_INLINE Int lane_index() { return {_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)}; }

SANDGLASS_INLINE Float operator+(Float a, Float b) { return {_mm256_add_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float operator-(Float a, Float b) { return {_mm256_sub_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float operator*(Float a, Float b) { return {_mm256_mul_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float operator/(Float a, Float b) { return {_mm256_div_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float square_root(Float a) { return {_mm256_sqrt_ps(a.v)}; }
SANDGLASS_INLINE Float minimum(Float a, Float b) { return {_mm256_min_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float maximum(Float a, Float b) { return {_mm256_max_ps(a.v, b.v)}; }
SANDGLASS_INLINE Float at_most(Float a, Float bound) { return minimum(a, bound); }
SANDGLASS_INLINE Float at_least(Float a, Float bound) { return maximum(a, bound); }
SANDGLASS_INLINE Float absolute(Float a) { return {_mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v)}; }

SANDGLASS_INLINE Int operator+(Int a, Int b) { return {_mm256_add_epi32(a.v, b.v)}; }
SANDGLASS_INLINE Int operator-(Int a, Int b) { return {_mm256_sub_epi32(a.v, b.v)}; }
SANDGLASS_INLINE Int operator&(Int a, Int b) { return {_mm256_and_si256(a.v, b.v)}; }
SANDGLASS_INLINE Int operator|(Int a, Int b) { return {_mm256_or_si256(a.v, b.v)}; }
SANDGLASS_INLINE Int minimum(Int a, Int b) { return {_mm256_min_epi32(a.v, b.v)}; }
SANDGLASS_INLINE Int shift_left(Int a, int count) { return {_mm256_sll_epi32(a.v, _mm_cvtsi32_si128(count))}; }
SANDGLASS_INLINE Int shift_right(Int a, int count) { return {_mm256_srl_epi32(a.v, _mm_cvtsi32_si128(count))}; }
SANDGLASS_INLINE Int to_int(Float a) { return {_mm256_cvttps_epi32(a.v)}; }
SANDGLASS_INLINE Int floor_int(Float a) { return {_mm256_cvttps_epi32(_mm256_floor_ps(a.v))}; }
SANDGLASS_INLINE Float to_float(Int a) { return {_mm256_cvtepi32_ps(a.v)}; }
SANDGLASS_INLINE Int as_int(Float a) { return {_mm256_castps_si256(a.v)}; }

SANDGLASS_INLINE Mask operator<(Float a, Float b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)}; }
SANDGLASS_INLINE Mask operator<=(Float a, Float b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)}; }
SANDGLASS_INLINE Mask operator==(Float a, Float b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ)}; }
SANDGLASS_INLINE Mask within(Float a, Float limit) { return absolute(a) < limit; }
SANDGLASS_INLINE Mask operator<(Int a, Int b) { return {_mm256_castsi256_ps(_mm256_cmpgt_epi32(b.v, a.v))}; }
SANDGLASS_INLINE Mask operator==(Int a, Int b) { return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(a.v, b.v))}; }
SANDGLASS_INLINE Mask operator&(Mask a, Mask b) { return {_mm256_and_ps(a.m, b.m)}; }
SANDGLASS_INLINE Mask operator|(Mask a, Mask b) { return {_mm256_or_ps(a.m, b.m)}; }
SANDGLASS_INLINE Mask and_not(Mask a, Mask b) { return {_mm256_andnot_ps(b.m, a.m)}; }
SANDGLASS_INLINE uint32_t bits(Mask a) { return static_cast<uint32_t>(_mm256_movemask_ps(a.m)); }
SANDGLASS_INLINE bool any(Mask a) { return bits(a) != 0; }
SANDGLASS_INLINE bool all(Mask a) { return bits(a) == 0xFF; }
SANDGLASS_INLINE uint32_t count(Mask a) { return static_cast<uint32_t>(__builtin_popcount(bits(a))); }
SANDGLASS_INLINE uint32_t first(Mask a) { return static_cast<uint32_t>(__builtin_ctz(bits(a))); }
SANDGLASS_INLINE Float select(Mask m, Float a, Float b) { return {_mm256_blendv_ps(b.v, a.v, m.m)}; }
SANDGLASS_INLINE Float keep(Mask m, Float a) { return {_mm256_and_ps(m.m, a.v)}; }
SANDGLASS_INLINE Int select(Mask m, Int a, Int b) { return {_mm256_blendv_epi8(b.v, a.v, _mm256_castps_si256(m.m))}; }

SANDGLASS_INLINE float lane_maximum(Float a) {
  __m128 m = _mm_max_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
  m = _mm_max_ps(m, _mm_movehl_ps(m, m));
  return _mm_cvtss_f32(_mm_max_ss(m, _mm_shuffle_ps(m, m, 1)));
}
SANDGLASS_INLINE float lane_minimum(Float a) {
  __m128 m = _mm_min_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
  m = _mm_min_ps(m, _mm_movehl_ps(m, m));
  return _mm_cvtss_f32(_mm_min_ss(m, _mm_shuffle_ps(m, m, 1)));
}

// The 8x8 transpose is its own inverse: rows to columns and back.
SANDGLASS_INLINE void transpose(const __m256 r[8], __m256 out[8]) {
  const __m256 a0 = _mm256_unpacklo_ps(r[0], r[1]), a1 = _mm256_unpackhi_ps(r[0], r[1]);
  const __m256 a2 = _mm256_unpacklo_ps(r[2], r[3]), a3 = _mm256_unpackhi_ps(r[2], r[3]);
  const __m256 a4 = _mm256_unpacklo_ps(r[4], r[5]), a5 = _mm256_unpackhi_ps(r[4], r[5]);
  const __m256 a6 = _mm256_unpacklo_ps(r[6], r[7]), a7 = _mm256_unpackhi_ps(r[6], r[7]);
  const __m256 b0 = _mm256_shuffle_ps(a0, a2, 0x44), b1 = _mm256_shuffle_ps(a0, a2, 0xEE);
  const __m256 b2 = _mm256_shuffle_ps(a1, a3, 0x44), b3 = _mm256_shuffle_ps(a1, a3, 0xEE);
  const __m256 d0 = _mm256_shuffle_ps(a4, a6, 0x44), d1 = _mm256_shuffle_ps(a4, a6, 0xEE);
  const __m256 d2 = _mm256_shuffle_ps(a5, a7, 0x44), d3 = _mm256_shuffle_ps(a5, a7, 0xEE);
  out[0] = _mm256_permute2f128_ps(b0, d0, 0x20);
  out[1] = _mm256_permute2f128_ps(b1, d1, 0x20);
  out[2] = _mm256_permute2f128_ps(b2, d2, 0x20);
  out[3] = _mm256_permute2f128_ps(b3, d3, 0x20);
  out[4] = _mm256_permute2f128_ps(b0, d0, 0x31);
  out[5] = _mm256_permute2f128_ps(b1, d1, 0x31);
  out[6] = _mm256_permute2f128_ps(b2, d2, 0x31);
  out[7] = _mm256_permute2f128_ps(b3, d3, 0x31);
}

SANDGLASS_INLINE Float gather(const float* base, Int index) { return {_mm256_i32gather_ps(base, index.v, 4)}; }

SANDGLASS_INLINE void load_records(const float* base, const uint32_t* index, uint32_t stride, Float out[8]) {
  __m256 r[8], t[8];
  for (uint32_t k = 0; k < 8; ++k) r[k] = _mm256_load_ps(base + static_cast<uint64_t>(index[k * stride]) * 8);
  transpose(r, t);
  for (int c = 0; c < 8; ++c) out[c].v = t[c];
}
SANDGLASS_INLINE void load_quads(const float* const* lanes, uint32_t offset, Float out[4]) {
  __m256 r[4];
  for (uint32_t k = 0; k < 4; ++k)
    r[k] = _mm256_set_m128(_mm_load_ps(lanes[k + 4] + offset), _mm_load_ps(lanes[k] + offset));
  const __m256 a = _mm256_unpacklo_ps(r[0], r[1]), b = _mm256_unpackhi_ps(r[0], r[1]);
  const __m256 c = _mm256_unpacklo_ps(r[2], r[3]), d = _mm256_unpackhi_ps(r[2], r[3]);
  out[0].v = _mm256_shuffle_ps(a, c, 0x44);
  out[1].v = _mm256_shuffle_ps(a, c, 0xee);
  out[2].v = _mm256_shuffle_ps(b, d, 0x44);
  out[3].v = _mm256_shuffle_ps(b, d, 0xee);
}
#include "kernels/simd/corners.inl"
SANDGLASS_INLINE void load_records(const float* p, Float out[8]) {
  __m256 r[8], t[8];
  for (uint32_t k = 0; k < 8; ++k) r[k] = _mm256_load_ps(p + 8 * k);
  transpose(r, t);
  for (int c = 0; c < 8; ++c) out[c].v = t[c];
}
SANDGLASS_INLINE void broadcast_record(const float* p, Float out[8]) {
  for (int c = 0; c < 8; ++c) out[c] = broadcast(p[c]);
}
SANDGLASS_INLINE void store_records(float* p, const Float in[8]) {
  __m256 r[8], t[8];
  for (int c = 0; c < 8; ++c) r[c] = in[c].v;
  transpose(r, t);
  for (uint32_t k = 0; k < 8; ++k) _mm256_store_ps(p + 8 * k, t[k]);
}

SANDGLASS_INLINE void load_differences(const float* base, const uint32_t* first, const uint32_t* second, Float out[8]) {
  __m256 r[8], t[8];
  for (uint32_t k = 0; k < 8; ++k) {
    r[k] = _mm256_sub_ps(_mm256_load_ps(base + static_cast<uint64_t>(second[k]) * 8),
                         _mm256_load_ps(base + static_cast<uint64_t>(first[k]) * 8));
  }
  transpose(r, t);
  for (int c = 0; c < 8; ++c) out[c].v = t[c];
}
SANDGLASS_INLINE void load_approaches(const float* base, const uint32_t* first, const uint32_t* second, Float out[3]) {
  __m256 r[4];  // the sums of records k and k + 4
  for (uint32_t k = 0; k < 4; ++k) {
    const __m256 a = _mm256_sub_ps(_mm256_load_ps(base + static_cast<uint64_t>(second[k]) * 8),
                                   _mm256_load_ps(base + static_cast<uint64_t>(first[k]) * 8));
    const __m256 b = _mm256_sub_ps(_mm256_load_ps(base + static_cast<uint64_t>(second[k + 4]) * 8),
                                   _mm256_load_ps(base + static_cast<uint64_t>(first[k + 4]) * 8));
    r[k] = _mm256_add_ps(_mm256_permute2f128_ps(a, b, 0x20), _mm256_permute2f128_ps(a, b, 0x31));
  }
  const __m256 a0 = _mm256_unpacklo_ps(r[0], r[1]), a1 = _mm256_unpackhi_ps(r[0], r[1]);
  const __m256 a2 = _mm256_unpacklo_ps(r[2], r[3]), a3 = _mm256_unpackhi_ps(r[2], r[3]);
  out[0].v = _mm256_shuffle_ps(a0, a2, 0x44);
  out[1].v = _mm256_shuffle_ps(a0, a2, 0xEE);
  out[2].v = _mm256_shuffle_ps(a1, a3, 0x44);
}
#include "kernels/simd/displacement.inl"

SANDGLASS_INLINE void subtract_displacements(float* base, const uint32_t* index, const Float d[3]) {
  const __m256 a0 = _mm256_unpacklo_ps(d[0].v, d[1].v), a1 = _mm256_unpackhi_ps(d[0].v, d[1].v);
  const __m256 b0 = _mm256_unpacklo_ps(d[2].v, d[2].v), b1 = _mm256_unpackhi_ps(d[2].v, d[2].v);
  const __m256 t[4] = {_mm256_shuffle_ps(a0, b0, 0x44), _mm256_shuffle_ps(a0, b0, 0xEE),
                       _mm256_shuffle_ps(a1, b1, 0x44), _mm256_shuffle_ps(a1, b1, 0xEE)};
  for (uint32_t k = 0; k < 4; ++k) {
    subtract_displacement(base + static_cast<uint64_t>(index[k]) * 8 + 4, _mm256_castps256_ps128(t[k]));
    subtract_displacement(base + static_cast<uint64_t>(index[k + 4]) * 8 + 4, _mm256_extractf128_ps(t[k], 1));
  }
}

// AVX2 has no compress instruction. For each of the 256 masks a permutation puts the kept lanes first.
struct Permutations {
  uint8_t lanes[256][8];
};
constexpr Permutations kept_first() {
  Permutations all = {};
  for (uint32_t mask = 0; mask < 256; ++mask) {
    uint32_t kept = 0;
    for (uint32_t lane = 0; lane < 8; ++lane) {
      if ((mask >> lane & 1u) != 0) all.lanes[mask][kept++] = static_cast<uint8_t>(lane);
    }
  }
  return all;
}
constexpr Permutations k_compress = kept_first();

SANDGLASS_INLINE uint32_t compress_store(uint32_t* p, Int v, Mask m) {
  const uint32_t mask = bits(m);
  const __m128i lanes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(k_compress.lanes[mask]));
  const __m256i kept = _mm256_permutevar8x32_epi32(v.v, _mm256_cvtepu8_epi32(lanes));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), kept);
  return static_cast<uint32_t>(__builtin_popcount(mask));
}

}  // namespace sandglass::simd_avx2
