// What x86's sets share, in each one's namespace: 32 bytes at a time.

struct Bytes {
  __m256i v;
};
SANDGLASS_INT8_INLINE Bytes load_bytes(const uint8_t* p) {
  return {_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p))};
}
SANDGLASS_INT8_INLINE void store_bytes(uint8_t* p, Bytes b) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), b.v); }
SANDGLASS_INT8_INLINE Bytes maximum(Bytes a, Bytes b) { return {_mm256_max_epu8(a.v, b.v)}; }
SANDGLASS_INT8_INLINE Bytes minimum(Bytes a, Bytes b) { return {_mm256_min_epu8(a.v, b.v)}; }
// Unpacking splits each 128-bit half into two vectors of 16-bit sums; packing restores the order.
SANDGLASS_INT8_INLINE Bytes average(const Bytes (&four)[4]) {
  const __m256i zero = _mm256_setzero_si256();
  __m256i low = _mm256_set1_epi16(2), high = low;
  for (const Bytes& b : four) {
    low = _mm256_add_epi16(low, _mm256_unpacklo_epi8(b.v, zero));
    high = _mm256_add_epi16(high, _mm256_unpackhi_epi8(b.v, zero));
  }
  return {_mm256_packus_epi16(_mm256_srli_epi16(low, 2), _mm256_srli_epi16(high, 2))};
}

SANDGLASS_INT8_INLINE int32_t total(__m256i sum) {
  __m128i half = _mm_add_epi32(_mm256_castsi256_si128(sum), _mm256_extracti128_si256(sum, 1));
  half = _mm_add_epi32(half, _mm_shuffle_epi32(half, 0x4E));
  half = _mm_add_epi32(half, _mm_shuffle_epi32(half, 0xB1));
  return _mm_cvtsi128_si32(half);
}
