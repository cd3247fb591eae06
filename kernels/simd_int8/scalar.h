// Dot products of bytes: the layer that int8 kernels are written over. This header states the contract once and
// implements it for one output; avx2.h, avx512vnni.h, neon.h, neon_dotprod.h and neon_i8mm.h implement the same names.
//
// Contract
//   Lane = output channel. A Sum holds k_sum_lanes 32-bit sums of neighbouring channels; sums are exact.
//   Weights are signed bytes in -127..127, activations unsigned bytes.
//   A panel is k_channel_group channels of packed weights: for each group of four inputs, four bytes a channel, channel
//   after channel (weight_position). With k_matrix (neon_i8mm.h) the groups are of eight inputs.
//   load_activations(p) takes 16 bytes of one texel; pick<i> is the i-th group of four, for all lanes.
//   dot4(sum, four, weights): every lane += the dot product of the four activations with its four weights.
//   requantise(sums, multiplier, out): k_tile_sums Sums of one texel to bytes, by the rule of int8.h.
//   first_layer(columns, rows, width, shift, out) computes the first layer of int8.h's ShadowNetwork for one texel.
//   dot_row(activations, weights, width) is the dot product of two rows of bytes.
//   A tile of a shadow network is k_tile_texels texels x k_tile_sums Sums, as many as fit the registers beside weights
//   and activations. k_tile_texels divides k_texel_block. k_sum_lanes * k_tile_sums divides k_channel_group.
//   A tile of a convolution is k_row_texels texels of one row x k_tile_sums Sums. k_row_texels divides k_tile_slack.
//   Bytes holds k_bytes unsigned bytes. load_bytes and store_bytes take any address. maximum and minimum work byte by
//   byte; average of four is (a + b + c + d + 2) / 4, rounded down.
//   A Mixture holds k_bytes 32-bit sums, one a byte. mix(sums, first, second, a, b): sum t += a * first[t] + b *
//   second[t]; the bytes are signed, at any address. visibility_of is 255 - clamp(sum >> shift, 0, 255).
//   k_bytes divides k_ambient_group.
//   k_signed: activations enter the products less 128, in sets that only multiply signed bytes. pack_layer adds
//   128 * (sum of the weights) to the bias.
#pragma once

#include <stdint.h>

namespace sandglass::int8_scalar {

#define SANDGLASS_INT8_INLINE inline __attribute__((always_inline))

constexpr bool k_matrix = false;
constexpr bool k_signed = false;
constexpr uint32_t k_sum_lanes = 1;
constexpr uint32_t k_tile_texels = 2;
constexpr uint32_t k_tile_sums = 4;
constexpr uint32_t k_row_texels = 2;
constexpr uint32_t k_bytes = 16;

struct Sum {
  int32_t v;
};
struct Weights {
  const int8_t* p;
};
struct Activations {
  const uint8_t* p;
};

struct Bytes {
  uint8_t v[k_bytes];
};

SANDGLASS_INT8_INLINE Sum load_bias(const int32_t* p) { return {*p}; }
SANDGLASS_INT8_INLINE Weights load_weights(const int8_t* p) { return {p}; }
SANDGLASS_INT8_INLINE Activations load_activations(const uint8_t* p) { return {p}; }
template <int i>
SANDGLASS_INT8_INLINE Activations pick(Activations a) {
  return {a.p + 4 * i};
}
SANDGLASS_INT8_INLINE void dot4(Sum* sum, Activations a, Weights w) {
  for (int k = 0; k < 4; ++k) sum->v += a.p[k] * w.p[k];
}

// Clamps to 0..255. Adding 1.5 * 2^23 then leaves the integer, rounded to nearest even, in the low bits.
SANDGLASS_INT8_INLINE uint8_t round_to_byte(float x) {
  x = x > 0.0f ? x : 0.0f;
  x = x < 255.0f ? x : 255.0f;
  return static_cast<uint8_t>(__builtin_bit_cast(uint32_t, x + 12582912.0f));
}
SANDGLASS_INT8_INLINE void requantise(const Sum* sums, const float* multiplier, uint8_t* out) {
  for (uint32_t s = 0; s < k_tile_sums; ++s) out[s] = round_to_byte(static_cast<float>(sums[s].v) * multiplier[s]);
}

SANDGLASS_INT8_INLINE void first_layer(const int16_t* columns, const int16_t* rows, uint32_t width, uint32_t shift,
                                       uint8_t* out) {
  for (uint32_t c = 0; c < width; ++c) {
    int32_t sum = columns[c] + rows[c];
    sum = sum < -32768 ? -32768 : sum > 32767 ? 32767 : sum;
    sum >>= shift;
    out[c] = static_cast<uint8_t>(sum < 0 ? 0 : sum > 255 ? 255 : sum);
  }
}

SANDGLASS_INT8_INLINE Bytes load_bytes(const uint8_t* p) {
  Bytes b;
  __builtin_memcpy(b.v, p, k_bytes);
  return b;
}
SANDGLASS_INT8_INLINE void store_bytes(uint8_t* p, const Bytes& b) { __builtin_memcpy(p, b.v, k_bytes); }
SANDGLASS_INT8_INLINE Bytes maximum(Bytes a, const Bytes& b) {
  for (uint32_t i = 0; i < k_bytes; ++i) a.v[i] = a.v[i] > b.v[i] ? a.v[i] : b.v[i];
  return a;
}
SANDGLASS_INT8_INLINE Bytes minimum(Bytes a, const Bytes& b) {
  for (uint32_t i = 0; i < k_bytes; ++i) a.v[i] = a.v[i] < b.v[i] ? a.v[i] : b.v[i];
  return a;
}
SANDGLASS_INT8_INLINE Bytes average(const Bytes (&four)[4]) {
  Bytes b;
  for (uint32_t i = 0; i < k_bytes; ++i)
    b.v[i] = static_cast<uint8_t>((four[0].v[i] + four[1].v[i] + four[2].v[i] + four[3].v[i] + 2) / 4);
  return b;
}

struct Mixture {
  int32_t v[k_bytes];
};
SANDGLASS_INT8_INLINE Mixture mixture_of(int32_t start) {
  Mixture sums;
  for (uint32_t i = 0; i < k_bytes; ++i) sums.v[i] = start;
  return sums;
}
SANDGLASS_INT8_INLINE void mix(Mixture* sums, const int8_t* first, const int8_t* second, int16_t a, int16_t b) {
  for (uint32_t i = 0; i < k_bytes; ++i) sums->v[i] += a * first[i] + b * second[i];
}
SANDGLASS_INT8_INLINE Bytes visibility_of(const Mixture& sums, uint32_t shift) {
  Bytes bytes;
  for (uint32_t i = 0; i < k_bytes; ++i) {
    const int32_t dark = sums.v[i] >> shift;
    bytes.v[i] = static_cast<uint8_t>(255 - (dark < 0 ? 0 : dark > 255 ? 255 : dark));
  }
  return bytes;
}

SANDGLASS_INT8_INLINE int32_t dot_row(const uint8_t* a, const int8_t* w, uint32_t width) {
  int32_t sum = 0;
  for (uint32_t c = 0; c < width; ++c) sum += a[c] * w[c];
  return sum;
}

}  // namespace sandglass::int8_scalar
