// The contract of scalar.h for AVX-512 with VNNI: 16 outputs.
#pragma once

#include <immintrin.h>
#include <stdint.h>

namespace sandglass::int8_avx512 {

#define SANDGLASS_INT8_INLINE inline __attribute__((always_inline))
#include "kernels/simd_int8/x86_shared.inl"

constexpr bool k_matrix = false;
constexpr bool k_signed = false;
constexpr uint32_t k_sum_lanes = 16;
constexpr uint32_t k_tile_texels = 12;  // 24 sums, 2 weights, 1 activation: 27 of 32 registers
constexpr uint32_t k_tile_sums = 2;
constexpr uint32_t k_row_texels = 8;
constexpr uint32_t k_bytes = 32;

struct Sum {
  __m512i v;
};
struct Weights {
  __m512i v;
};
struct Activations {
  const uint8_t* p;
};
struct Four {
  __m512i v;
};

SANDGLASS_INT8_INLINE Sum load_bias(const int32_t* p) { return {_mm512_loadu_si512(p)}; }
SANDGLASS_INT8_INLINE Weights load_weights(const int8_t* p) { return {_mm512_load_si512(p)}; }
SANDGLASS_INT8_INLINE Activations load_activations(const uint8_t* p) { return {p}; }
template <int i>
SANDGLASS_INT8_INLINE Four pick(Activations a) {
  int32_t four;
  __builtin_memcpy(&four, a.p + 4 * i, 4);
  return {_mm512_set1_epi32(four)};
}
// Assembly, because gcc 12 gives the intrinsic's sum a new register and moves or spills the old one, which doubles the
// time.
SANDGLASS_INT8_INLINE void dot4(Sum* sum, Four a, Weights w) {
  __asm__("vpdpbusd %2, %1, %0" : "+v"(sum->v) : "v"(a.v), "v"(w.v));
}

SANDGLASS_INT8_INLINE void requantise(const Sum* sums, const float* multiplier, uint8_t* out) {
  for (uint32_t s = 0; s < k_tile_sums; ++s) {
    __m512 x = _mm512_mul_ps(_mm512_cvtepi32_ps(sums[s].v), _mm512_loadu_ps(multiplier + 16 * s));
    x = _mm512_min_ps(_mm512_max_ps(x, _mm512_setzero_ps()), _mm512_set1_ps(255.0f));
    _mm_store_si128(reinterpret_cast<__m128i*>(out + 16 * s), _mm512_cvtepi32_epi8(_mm512_cvtps_epi32(x)));
  }
}

SANDGLASS_INT8_INLINE void first_layer(const int16_t* columns, const int16_t* rows, uint32_t width, uint32_t shift,
                                       uint8_t* out) {
  const __m128i by = _mm_cvtsi32_si128(static_cast<int>(shift));
  for (uint32_t c = 0; c < width; c += 32) {
    const __m512i sum =
        _mm512_sra_epi16(_mm512_adds_epi16(_mm512_load_si512(columns + c), _mm512_load_si512(rows + c)), by);
    _mm256_store_si256(reinterpret_cast<__m256i*>(out + c),
                       _mm512_cvtusepi16_epi8(_mm512_max_epi16(sum, _mm512_setzero_si512())));
  }
}

// Interleaved with the second component, each 128-bit part becomes two vectors of pairs; packing restores the order.
struct Mixture {
  __m512i v[2];
};
SANDGLASS_INT8_INLINE Mixture mixture_of(int32_t start) {
  const __m512i all = _mm512_set1_epi32(start);
  return {{all, all}};
}
SANDGLASS_INT8_INLINE void mix(Mixture* sums, const int8_t* first, const int8_t* second, int16_t a, int16_t b) {
  const __m512i weights =
      _mm512_set1_epi32(static_cast<int32_t>(static_cast<uint16_t>(a) | uint32_t{static_cast<uint16_t>(b)} << 16));
  const __m512i x = _mm512_cvtepi8_epi16(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(first)));
  const __m512i y = _mm512_cvtepi8_epi16(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(second)));
  sums->v[0] = _mm512_add_epi32(sums->v[0], _mm512_madd_epi16(_mm512_unpacklo_epi16(x, y), weights));
  sums->v[1] = _mm512_add_epi32(sums->v[1], _mm512_madd_epi16(_mm512_unpackhi_epi16(x, y), weights));
}
SANDGLASS_INT8_INLINE Bytes visibility_of(const Mixture& sums, uint32_t shift) {
  const __m128i by = _mm_cvtsi32_si128(static_cast<int>(shift));
  const __m512i words = _mm512_packs_epi32(_mm512_sra_epi32(sums.v[0], by), _mm512_sra_epi32(sums.v[1], by));
  const __m256i dark = _mm512_cvtusepi16_epi8(_mm512_max_epi16(words, _mm512_setzero_si512()));
  return {_mm256_xor_si256(dark, _mm256_set1_epi8(-1))};
}

SANDGLASS_INT8_INLINE int32_t dot_row(const uint8_t* a, const int8_t* w, uint32_t width) {
  __m256i sum = _mm256_setzero_si256();
  for (uint32_t c = 0; c < width; c += 32)
    sum = _mm256_dpbusd_epi32(sum, _mm256_load_si256(reinterpret_cast<const __m256i*>(a + c)),
                              _mm256_load_si256(reinterpret_cast<const __m256i*>(w + c)));
  return total(sum);
}

}  // namespace sandglass::int8_avx512
