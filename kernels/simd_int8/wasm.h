// The contract of scalar.h for WebAssembly's 128-bit SIMD: 4 outputs. There is no product of bytes that adds into 32
// bits, so bytes are widened to 16 bits, even and odd inputs apart. i32x4.dot_i16x8 then adds their products in pairs,
// exactly.
#pragma once

#include <stdint.h>
#include <wasm_simd128.h>

namespace sandglass::int8_wasm {

#define SANDGLASS_INT8_INLINE inline __attribute__((always_inline))

constexpr bool k_matrix = false;
constexpr bool k_signed = false;
constexpr uint32_t k_sum_lanes = 4;
constexpr uint32_t k_tile_texels = 4;  // 8 sums, 4 halves of weights, 2 of activations, 1 product: 15 registers
constexpr uint32_t k_tile_sums = 2;
constexpr uint32_t k_row_texels = 4;
constexpr uint32_t k_bytes = 16;

struct Sum {
  v128_t v;
};
struct Weights {
  v128_t even, odd;
};
struct Activations {
  const uint8_t* p;
};
struct Four {
  v128_t even, odd;
};

SANDGLASS_INT8_INLINE Sum load_bias(const int32_t* p) { return {wasm_v128_load(p)}; }
SANDGLASS_INT8_INLINE Weights load_weights(const int8_t* p) {
  const v128_t w = wasm_v128_load(p);
  return {wasm_i16x8_shr(wasm_i16x8_shl(w, 8), 8), wasm_i16x8_shr(w, 8)};
}
SANDGLASS_INT8_INLINE Activations load_activations(const uint8_t* p) { return {p}; }
template <int i>
SANDGLASS_INT8_INLINE Four pick(Activations a) {
  const v128_t bytes = wasm_v128_load32_splat(a.p + 4 * i);
  return {wasm_v128_and(bytes, wasm_i16x8_const_splat(255)), wasm_u16x8_shr(bytes, 8)};
}
SANDGLASS_INT8_INLINE void dot4(Sum* sum, Four a, Weights w) {
  sum->v =
      wasm_i32x4_add(sum->v, wasm_i32x4_add(wasm_i32x4_dot_i16x8(a.even, w.even), wasm_i32x4_dot_i16x8(a.odd, w.odd)));
}

// Adding 1.5 * 2^23 leaves the integer, rounded to nearest even, in the low bits.
SANDGLASS_INT8_INLINE v128_t round_sums(v128_t sum, const float* multiplier) {
  const v128_t magic = wasm_f32x4_const_splat(12582912.0f);
  v128_t x = wasm_f32x4_mul(wasm_f32x4_convert_i32x4(sum), wasm_v128_load(multiplier));
  x = wasm_f32x4_pmin(wasm_f32x4_const_splat(255.0f), wasm_f32x4_pmax(wasm_f32x4_const_splat(0.0f), x));
  return wasm_i32x4_sub(wasm_f32x4_add(x, magic), magic);
}
// Writes 8 neighbouring channels.
SANDGLASS_INT8_INLINE void requantise(const Sum* sums, const float* multiplier, uint8_t* out) {
  const v128_t words =
      wasm_i16x8_narrow_i32x4(round_sums(sums[0].v, multiplier), round_sums(sums[1].v, multiplier + 4));
  wasm_v128_store64_lane(out, wasm_u8x16_narrow_i16x8(words, words), 0);
}

SANDGLASS_INT8_INLINE void first_layer(const int16_t* columns, const int16_t* rows, uint32_t width, uint32_t shift,
                                       uint8_t* out) {
  for (uint32_t c = 0; c < width; c += 16) {
    v128_t half[2];
    for (uint32_t h = 0; h < 2; ++h) {
      const uint32_t at = c + 8 * h;
      half[h] = wasm_i16x8_shr(wasm_i16x8_add_sat(wasm_v128_load(columns + at), wasm_v128_load(rows + at)), shift);
    }
    wasm_v128_store(out + c, wasm_u8x16_narrow_i16x8(half[0], half[1]));
  }
}

struct Bytes {
  v128_t v;
};
SANDGLASS_INT8_INLINE Bytes load_bytes(const uint8_t* p) { return {wasm_v128_load(p)}; }
SANDGLASS_INT8_INLINE void store_bytes(uint8_t* p, Bytes b) { wasm_v128_store(p, b.v); }
SANDGLASS_INT8_INLINE Bytes maximum(Bytes a, Bytes b) { return {wasm_u8x16_max(a.v, b.v)}; }
SANDGLASS_INT8_INLINE Bytes minimum(Bytes a, Bytes b) { return {wasm_u8x16_min(a.v, b.v)}; }
SANDGLASS_INT8_INLINE Bytes average(const Bytes (&four)[4]) {
  v128_t low = wasm_i16x8_const_splat(2), high = low;
  for (const Bytes& b : four) {
    low = wasm_i16x8_add(low, wasm_u16x8_extend_low_u8x16(b.v));
    high = wasm_i16x8_add(high, wasm_u16x8_extend_high_u8x16(b.v));
  }
  return {wasm_u8x16_narrow_i16x8(wasm_u16x8_shr(low, 2), wasm_u16x8_shr(high, 2))};
}

// The bytes of two components are interleaved, so that a pair of them meets a pair of weights.
struct Mixture {
  v128_t v[4];
};
SANDGLASS_INT8_INLINE Mixture mixture_of(int32_t start) {
  const v128_t all = wasm_i32x4_splat(start);
  return {{all, all, all, all}};
}
SANDGLASS_INT8_INLINE void mix(Mixture* sums, const int8_t* first, const int8_t* second, int16_t a, int16_t b) {
  const v128_t weights =
      wasm_i32x4_splat(static_cast<int32_t>(static_cast<uint16_t>(a) | uint32_t{static_cast<uint16_t>(b)} << 16));
  const v128_t x = wasm_v128_load(first), y = wasm_v128_load(second);
  const v128_t pairs[2] = {wasm_i8x16_shuffle(x, y, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23),
                           wasm_i8x16_shuffle(x, y, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31)};
  for (uint32_t half = 0; half < 2; ++half) {
    v128_t* sum = sums->v + 2 * half;
    sum[0] = wasm_i32x4_add(sum[0], wasm_i32x4_dot_i16x8(wasm_i16x8_extend_low_i8x16(pairs[half]), weights));
    sum[1] = wasm_i32x4_add(sum[1], wasm_i32x4_dot_i16x8(wasm_i16x8_extend_high_i8x16(pairs[half]), weights));
  }
}
SANDGLASS_INT8_INLINE Bytes visibility_of(const Mixture& sums, uint32_t shift) {
  const v128_t low = wasm_i16x8_narrow_i32x4(wasm_i32x4_shr(sums.v[0], shift), wasm_i32x4_shr(sums.v[1], shift));
  const v128_t high = wasm_i16x8_narrow_i32x4(wasm_i32x4_shr(sums.v[2], shift), wasm_i32x4_shr(sums.v[3], shift));
  return {wasm_v128_not(wasm_u8x16_narrow_i16x8(low, high))};
}

SANDGLASS_INT8_INLINE int32_t dot_row(const uint8_t* a, const int8_t* w, uint32_t width) {
  v128_t sum = wasm_i32x4_const_splat(0);
  for (uint32_t c = 0; c < width; c += 8)
    sum = wasm_i32x4_add(sum, wasm_i32x4_dot_i16x8(wasm_u16x8_load8x8(a + c), wasm_i16x8_load8x8(w + c)));
  return wasm_i32x4_extract_lane(sum, 0) + wasm_i32x4_extract_lane(sum, 1) + wasm_i32x4_extract_lane(sum, 2) +
         wasm_i32x4_extract_lane(sum, 3);
}

}  // namespace sandglass::int8_wasm
