// The contract of scalar.h for AVX2: 8 outputs. The byte multiply of this set saturates (255 * 127 * 2 > 32767), so
// bytes are widened to 16 bits, even and odd inputs apart. Their products are then added in pairs, exactly, in 32 bits.
#pragma once

#include <immintrin.h>
#include <stdint.h>

namespace sandglass::int8_avx2 {

#define SANDGLASS_INT8_INLINE inline __attribute__((always_inline))
#include "kernels/simd_int8/x86_shared.inl"

constexpr bool k_matrix = false;
constexpr bool k_signed = false;
constexpr uint32_t k_sum_lanes = 8;
constexpr uint32_t k_tile_texels = 4;  // 8 sums, 4 halves of weights, 2 of activations, 1 product: 15 of 16 registers
constexpr uint32_t k_tile_sums = 2;
constexpr uint32_t k_row_texels = 4;
constexpr uint32_t k_bytes = 32;

struct Sum {
  __m256i v;
};
struct Weights {
  __m256i even, odd;
};
struct Activations {
  const uint8_t* p;
};
struct Four {
  __m256i even, odd;
};

SANDGLASS_INT8_INLINE Sum load_bias(const int32_t* p) {
  return {_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p))};
}
SANDGLASS_INT8_INLINE Weights load_weights(const int8_t* p) {
  const __m256i w = _mm256_load_si256(reinterpret_cast<const __m256i*>(p));
  return {_mm256_srai_epi16(_mm256_slli_epi16(w, 8), 8), _mm256_srai_epi16(w, 8)};
}
SANDGLASS_INT8_INLINE Activations load_activations(const uint8_t* p) { return {p}; }
template <int i>
SANDGLASS_INT8_INLINE Four pick(Activations a) {
  int32_t four;
  __builtin_memcpy(&four, a.p + 4 * i, 4);
  const __m256i bytes = _mm256_set1_epi32(four);
  return {_mm256_and_si256(bytes, _mm256_set1_epi16(255)), _mm256_srli_epi16(bytes, 8)};
}
SANDGLASS_INT8_INLINE void dot4(Sum* sum, Four a, Weights w) {
  sum->v =
      _mm256_add_epi32(sum->v, _mm256_add_epi32(_mm256_madd_epi16(a.even, w.even), _mm256_madd_epi16(a.odd, w.odd)));
}

SANDGLASS_INT8_INLINE void requantise(const Sum* sums, const float* multiplier, uint8_t* out) {
  __m256i rounded[2];
  for (uint32_t s = 0; s < 2; ++s) {
    __m256 x = _mm256_mul_ps(_mm256_cvtepi32_ps(sums[s].v), _mm256_loadu_ps(multiplier + 8 * s));
    x = _mm256_min_ps(_mm256_max_ps(x, _mm256_setzero_ps()), _mm256_set1_ps(255.0f));
    rounded[s] = _mm256_cvtps_epi32(x);
  }
  const __m256i words = _mm256_permute4x64_epi64(_mm256_packs_epi32(rounded[0], rounded[1]), 0xD8);
  _mm_store_si128(reinterpret_cast<__m128i*>(out),
                  _mm_packus_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1)));
}

SANDGLASS_INT8_INLINE void first_layer(const int16_t* columns, const int16_t* rows, uint32_t width, uint32_t shift,
                                       uint8_t* out) {
  const __m128i by = _mm_cvtsi32_si128(static_cast<int>(shift));
  for (uint32_t c = 0; c < width; c += 32) {
    __m256i half[2];
    for (uint32_t h = 0; h < 2; ++h)
      half[h] =
          _mm256_sra_epi16(_mm256_adds_epi16(_mm256_load_si256(reinterpret_cast<const __m256i*>(columns + c + 16 * h)),
                                             _mm256_load_si256(reinterpret_cast<const __m256i*>(rows + c + 16 * h))),
                           by);
    _mm256_store_si256(reinterpret_cast<__m256i*>(out + c),
                       _mm256_permute4x64_epi64(_mm256_packus_epi16(half[0], half[1]), 0xD8));
  }
}

// Interleaved with the second component, each 128-bit half becomes two vectors of pairs; packing restores the order.
struct Mixture {
  __m256i v[4];
};
SANDGLASS_INT8_INLINE Mixture mixture_of(int32_t start) {
  const __m256i all = _mm256_set1_epi32(start);
  return {{all, all, all, all}};
}
SANDGLASS_INT8_INLINE void mix(Mixture* sums, const int8_t* first, const int8_t* second, int16_t a, int16_t b) {
  const __m256i weights =
      _mm256_set1_epi32(static_cast<int32_t>(static_cast<uint16_t>(a) | uint32_t{static_cast<uint16_t>(b)} << 16));
  for (uint32_t half = 0; half < 2; ++half) {
    const __m256i x = _mm256_cvtepi8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(first + 16 * half)));
    const __m256i y = _mm256_cvtepi8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(second + 16 * half)));
    __m256i* sum = sums->v + 2 * half;
    sum[0] = _mm256_add_epi32(sum[0], _mm256_madd_epi16(_mm256_unpacklo_epi16(x, y), weights));
    sum[1] = _mm256_add_epi32(sum[1], _mm256_madd_epi16(_mm256_unpackhi_epi16(x, y), weights));
  }
}
SANDGLASS_INT8_INLINE Bytes visibility_of(const Mixture& sums, uint32_t shift) {
  const __m128i by = _mm_cvtsi32_si128(static_cast<int>(shift));
  const auto half = [&](const __m256i* v) {
    return _mm256_packs_epi32(_mm256_sra_epi32(v[0], by), _mm256_sra_epi32(v[1], by));
  };
  const __m256i dark = _mm256_permute4x64_epi64(_mm256_packus_epi16(half(sums.v), half(sums.v + 2)), 0xD8);
  return {_mm256_xor_si256(dark, _mm256_set1_epi8(-1))};
}

SANDGLASS_INT8_INLINE int32_t dot_row(const uint8_t* a, const int8_t* w, uint32_t width) {
  __m256i sum = _mm256_setzero_si256();
  for (uint32_t c = 0; c < width; c += 16)
    sum = _mm256_add_epi32(
        sum, _mm256_madd_epi16(_mm256_cvtepu8_epi16(_mm_load_si128(reinterpret_cast<const __m128i*>(a + c))),
                               _mm256_cvtepi8_epi16(_mm_load_si128(reinterpret_cast<const __m128i*>(w + c)))));
  return total(sum);
}

}  // namespace sandglass::int8_avx2
