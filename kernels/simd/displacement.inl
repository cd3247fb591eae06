// The same in avx2.h and avx512.h, which include it inside their namespaces: takes d from components 4 to 6 of one record.
// p is at component 4.
SANDGLASS_INLINE void subtract_displacement(float* p, __m128 d) {
  const __m128 old = _mm_load_ps(p);
  _mm_store_ps(p, _mm_blend_ps(_mm_sub_ps(old, d), old, 8));
}
