// The contract of scalar.h for WebAssembly's 128-bit SIMD: 4 lanes. The pseudo-minimum pmin(b, a) is a < b ? a : b, as
// the contract asks; f32x4.min treats NaN in another way. Plain SIMD128 has no fused multiply-add. This header needs
// the option -msimd128.
#pragma once

#include <stdint.h>
#include <wasm_simd128.h>

namespace sandglass::simd_wasm {

#define SANDGLASS_INLINE inline __attribute__((always_inline))
#define SANDGLASS_NOINLINE static __attribute__((noinline))

constexpr uint32_t k_width = 4;

struct Mask {
  v128_t m;
};
struct Int {
  v128_t v;
};
struct Float {
  v128_t v;
};

SANDGLASS_INLINE Float broadcast(float a) { return {wasm_f32x4_splat(a)}; }
SANDGLASS_INLINE Int broadcast(int32_t a) { return {wasm_i32x4_splat(a)}; }
SANDGLASS_INLINE Float load(const float* p) { return {wasm_v128_load(p)}; }
SANDGLASS_INLINE Int load(const uint32_t* p) { return {wasm_v128_load(p)}; }
SANDGLASS_INLINE void store(float* p, Float a) { wasm_v128_store(p, a.v); }
SANDGLASS_INLINE void store(uint32_t* p, Int a) { wasm_v128_store(p, a.v); }
SANDGLASS_INLINE Int lane_index() { return {wasm_i32x4_const(0, 1, 2, 3)}; }

SANDGLASS_INLINE Float operator+(Float a, Float b) { return {wasm_f32x4_add(a.v, b.v)}; }
SANDGLASS_INLINE Float operator-(Float a, Float b) { return {wasm_f32x4_sub(a.v, b.v)}; }
SANDGLASS_INLINE Float operator*(Float a, Float b) { return {wasm_f32x4_mul(a.v, b.v)}; }
SANDGLASS_INLINE Float operator/(Float a, Float b) { return {wasm_f32x4_div(a.v, b.v)}; }
SANDGLASS_INLINE Float square_root(Float a) { return {wasm_f32x4_sqrt(a.v)}; }
SANDGLASS_INLINE Float minimum(Float a, Float b) { return {wasm_f32x4_pmin(b.v, a.v)}; }
SANDGLASS_INLINE Float maximum(Float a, Float b) { return {wasm_f32x4_pmax(b.v, a.v)}; }
SANDGLASS_INLINE Float at_most(Float a, Float bound) { return minimum(a, bound); }
SANDGLASS_INLINE Float at_least(Float a, Float bound) { return maximum(a, bound); }
SANDGLASS_INLINE Float absolute(Float a) { return {wasm_f32x4_abs(a.v)}; }

SANDGLASS_INLINE Int operator+(Int a, Int b) { return {wasm_i32x4_add(a.v, b.v)}; }
SANDGLASS_INLINE Int operator-(Int a, Int b) { return {wasm_i32x4_sub(a.v, b.v)}; }
SANDGLASS_INLINE Int operator&(Int a, Int b) { return {wasm_v128_and(a.v, b.v)}; }
SANDGLASS_INLINE Int operator|(Int a, Int b) { return {wasm_v128_or(a.v, b.v)}; }
SANDGLASS_INLINE Int minimum(Int a, Int b) { return {wasm_i32x4_min(a.v, b.v)}; }
SANDGLASS_INLINE Int shift_left(Int a, int count) { return {wasm_i32x4_shl(a.v, count)}; }
SANDGLASS_INLINE Int shift_right(Int a, int count) { return {wasm_u32x4_shr(a.v, count)}; }
SANDGLASS_INLINE Int to_int(Float a) { return {wasm_i32x4_trunc_sat_f32x4(a.v)}; }
SANDGLASS_INLINE Int floor_int(Float a) { return {wasm_i32x4_trunc_sat_f32x4(wasm_f32x4_floor(a.v))}; }
SANDGLASS_INLINE Float to_float(Int a) { return {wasm_f32x4_convert_i32x4(a.v)}; }
SANDGLASS_INLINE Int as_int(Float a) { return {a.v}; }

SANDGLASS_INLINE Mask operator<(Float a, Float b) { return {wasm_f32x4_lt(a.v, b.v)}; }
SANDGLASS_INLINE Mask operator<=(Float a, Float b) { return {wasm_f32x4_le(a.v, b.v)}; }
SANDGLASS_INLINE Mask operator==(Float a, Float b) { return {wasm_f32x4_eq(a.v, b.v)}; }
SANDGLASS_INLINE Mask within(Float a, Float limit) { return absolute(a) < limit; }
SANDGLASS_INLINE Mask operator<(Int a, Int b) { return {wasm_i32x4_lt(a.v, b.v)}; }
SANDGLASS_INLINE Mask operator==(Int a, Int b) { return {wasm_i32x4_eq(a.v, b.v)}; }
SANDGLASS_INLINE Mask operator&(Mask a, Mask b) { return {wasm_v128_and(a.m, b.m)}; }
SANDGLASS_INLINE Mask operator|(Mask a, Mask b) { return {wasm_v128_or(a.m, b.m)}; }
SANDGLASS_INLINE Mask and_not(Mask a, Mask b) { return {wasm_v128_andnot(a.m, b.m)}; }
SANDGLASS_INLINE bool any(Mask a) { return wasm_v128_any_true(a.m); }
SANDGLASS_INLINE bool all(Mask a) { return wasm_i32x4_all_true(a.m); }
SANDGLASS_INLINE uint32_t lane_bits(Mask a) { return static_cast<uint32_t>(wasm_i32x4_bitmask(a.m)); }
SANDGLASS_INLINE uint32_t count(Mask a) { return static_cast<uint32_t>(__builtin_popcount(lane_bits(a))); }
SANDGLASS_INLINE uint32_t first(Mask a) { return static_cast<uint32_t>(__builtin_ctz(lane_bits(a))); }
SANDGLASS_INLINE Float select(Mask m, Float a, Float b) { return {wasm_v128_bitselect(a.v, b.v, m.m)}; }
SANDGLASS_INLINE Float keep(Mask m, Float a) { return {wasm_v128_and(m.m, a.v)}; }
SANDGLASS_INLINE Int select(Mask m, Int a, Int b) { return {wasm_v128_bitselect(a.v, b.v, m.m)}; }

SANDGLASS_INLINE float lane_maximum(Float a) {
  const v128_t two = wasm_f32x4_pmax(a.v, wasm_i32x4_shuffle(a.v, a.v, 2, 3, 0, 1));
  return wasm_f32x4_extract_lane(wasm_f32x4_pmax(two, wasm_i32x4_shuffle(two, two, 1, 0, 3, 2)), 0);
}
SANDGLASS_INLINE float lane_minimum(Float a) {
  const v128_t two = wasm_f32x4_pmin(a.v, wasm_i32x4_shuffle(a.v, a.v, 2, 3, 0, 1));
  return wasm_f32x4_extract_lane(wasm_f32x4_pmin(two, wasm_i32x4_shuffle(two, two, 1, 0, 3, 2)), 0);
}

SANDGLASS_INLINE void transpose(v128_t r0, v128_t r1, v128_t r2, v128_t r3, v128_t out[4]) {
  const v128_t a0 = wasm_i32x4_shuffle(r0, r1, 0, 4, 1, 5), a1 = wasm_i32x4_shuffle(r0, r1, 2, 6, 3, 7);
  const v128_t a2 = wasm_i32x4_shuffle(r2, r3, 0, 4, 1, 5), a3 = wasm_i32x4_shuffle(r2, r3, 2, 6, 3, 7);
  out[0] = wasm_i64x2_shuffle(a0, a2, 0, 2);
  out[1] = wasm_i64x2_shuffle(a0, a2, 1, 3);
  out[2] = wasm_i64x2_shuffle(a1, a3, 0, 2);
  out[3] = wasm_i64x2_shuffle(a1, a3, 1, 3);
}

SANDGLASS_INLINE Float gather(const float* base, Int index) {
  return {wasm_f32x4_make(base[wasm_i32x4_extract_lane(index.v, 0)], base[wasm_i32x4_extract_lane(index.v, 1)],
                          base[wasm_i32x4_extract_lane(index.v, 2)], base[wasm_i32x4_extract_lane(index.v, 3)])};
}

SANDGLASS_INLINE void transpose_records(const float* p0, const float* p1, const float* p2, const float* p3,
                                        Float out[8]) {
  v128_t t[4];
  for (int half = 0; half < 2; ++half) {
    const int at = 4 * half;
    transpose(wasm_v128_load(p0 + at), wasm_v128_load(p1 + at), wasm_v128_load(p2 + at), wasm_v128_load(p3 + at), t);
    for (int c = 0; c < 4; ++c) out[at + c].v = t[c];
  }
}
SANDGLASS_INLINE void load_records(const float* base, const uint32_t* index, uint32_t stride, Float out[8]) {
  transpose_records(base + static_cast<uint64_t>(index[0]) * 8, base + static_cast<uint64_t>(index[stride]) * 8,
                    base + static_cast<uint64_t>(index[2 * stride]) * 8,
                    base + static_cast<uint64_t>(index[3 * stride]) * 8, out);
}
SANDGLASS_INLINE void load_quads(const float* const* lanes, uint32_t offset, Float out[4]) {
  v128_t t[4];
  transpose(wasm_v128_load(lanes[0] + offset), wasm_v128_load(lanes[1] + offset), wasm_v128_load(lanes[2] + offset),
            wasm_v128_load(lanes[3] + offset), t);
  for (int c = 0; c < 4; ++c) out[c].v = t[c];
}
#include "kernels/simd/corners.inl"
SANDGLASS_INLINE void load_differences(const float* base, const uint32_t* first, const uint32_t* second, Float out[8]) {
  v128_t r[4], t[4];
  for (int half = 0; half < 2; ++half) {
    for (int k = 0; k < 4; ++k) {
      r[k] = wasm_f32x4_sub(wasm_v128_load(base + static_cast<uint64_t>(second[k]) * 8 + 4 * half),
                            wasm_v128_load(base + static_cast<uint64_t>(first[k]) * 8 + 4 * half));
    }
    transpose(r[0], r[1], r[2], r[3], t);
    for (int c = 0; c < 4; ++c) out[4 * half + c].v = t[c];
  }
}
SANDGLASS_INLINE void load_approaches(const float* base, const uint32_t* first, const uint32_t* second, Float out[3]) {
  v128_t r[4], t[4];
  for (int k = 0; k < 4; ++k) {
    const float* p = base + static_cast<uint64_t>(first[k]) * 8;
    const float* q = base + static_cast<uint64_t>(second[k]) * 8;
    r[k] = wasm_f32x4_add(wasm_f32x4_sub(wasm_v128_load(q), wasm_v128_load(p)),
                          wasm_f32x4_sub(wasm_v128_load(q + 4), wasm_v128_load(p + 4)));
  }
  transpose(r[0], r[1], r[2], r[3], t);
  for (int c = 0; c < 3; ++c) out[c].v = t[c];
}
SANDGLASS_INLINE void subtract_displacements(float* base, const uint32_t* index, const Float d[3]) {
  v128_t t[4];
  transpose(d[0].v, d[1].v, d[2].v, d[2].v, t);
  for (int k = 0; k < 4; ++k) {
    float* p = base + static_cast<uint64_t>(index[k]) * 8 + 4;
    const v128_t old = wasm_v128_load(p);
    wasm_v128_store(p, wasm_i32x4_shuffle(wasm_f32x4_sub(old, t[k]), old, 0, 1, 2, 7));
  }
}
SANDGLASS_INLINE void load_records(const float* p, Float out[8]) { transpose_records(p, p + 8, p + 16, p + 24, out); }
SANDGLASS_INLINE void broadcast_record(const float* p, Float out[8]) {
  for (int c = 0; c < 8; ++c) out[c].v = wasm_v128_load32_splat(p + c);
}
SANDGLASS_INLINE void store_records(float* p, const Float in[8]) {
  v128_t t[4];
  transpose(in[0].v, in[1].v, in[2].v, in[3].v, t);
  for (int k = 0; k < 4; ++k) wasm_v128_store(p + 8 * k, t[k]);
  transpose(in[4].v, in[5].v, in[6].v, in[7].v, t);
  for (int k = 0; k < 4; ++k) wasm_v128_store(p + 8 * k + 4, t[k]);
}

#include "kernels/simd/compress.inl"

SANDGLASS_INLINE uint32_t compress_store(uint32_t* p, Int v, Mask m) {
  const uint32_t kept = lane_bits(m);
  wasm_v128_store(p, wasm_i8x16_swizzle(v.v, wasm_v128_load(k_compress[kept])));
  return static_cast<uint32_t>(__builtin_popcount(kept));
}

}  // namespace sandglass::simd_wasm
