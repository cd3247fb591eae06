// The wide-vector type that every kernel body is written in. This header states the contract once and implements it for
// one lane; neon.h, avx2.h and avx512.h implement the same names for 4, 8 and 16 lanes. Each has a namespace of its
// own, so that the linker can never merge functions of two sets.
//
// Contract
//   Lane = particle (or grain, candidate, texel): no operation adds across lanes, so the width never changes a sum.
//   + - * / and square_root are the IEEE operations, correctly rounded; no contraction, no reciprocal estimates.
//   minimum(a, b) = a < b ? a : b and maximum(a, b) = a > b ? a : b: with a NaN they return b, on every set.
//   at_most and at_least are the same for bounds above 0, and at_least for +0, which some sets do in one instruction.
//   Comparisons are ordered: false where a lane is NaN. select(m, a, b) takes a where m holds, else b, bit for bit.
//   to_int truncates, floor_int rounds down; the caller keeps the value within +-2^30 (out of range, ARM and x86
//   differ).
//   A record is 8 floats, 32 bytes, 32-byte aligned. load_records gathers one record a lane and transposes: out[c]
//   holds component c. The index of lane l is index[l * stride]. broadcast_record puts one record into every lane.
//   load_differences gives record[second] - record[first] component by component; what the difference of two integers
//   is means nothing. load_approaches gives components 0 to 2 of the same plus components 4 to 6.
//   subtract_displacements takes d from components 4 to 6 of the records and leaves the other bits alone. A record may
//   come more than once: d must then be 0 for it, but for one time.
//   compress_store writes the lanes of v where m holds, in lane order, and returns how many. It may write up to k_width
//   values; those behind the count mean nothing.
#pragma once

#include <stdint.h>

#include "kernels/whole.h"

namespace sandglass::simd_scalar {

#define SANDGLASS_INLINE inline __attribute__((always_inline))
#define SANDGLASS_NOINLINE static __attribute__((noinline))

constexpr uint32_t k_width = 1;

struct Mask {
  bool m;
};
struct Int {
  int32_t v;
};
struct Float {
  float v;
};

SANDGLASS_INLINE Float broadcast(float a) { return {a}; }
SANDGLASS_INLINE Int broadcast(int32_t a) { return {a}; }
SANDGLASS_INLINE Float load(const float* p) { return {*p}; }
SANDGLASS_INLINE Int load(const uint32_t* p) { return {static_cast<int32_t>(*p)}; }
SANDGLASS_INLINE void store(float* p, Float a) { *p = a.v; }
SANDGLASS_INLINE void store(uint32_t* p, Int a) { *p = static_cast<uint32_t>(a.v); }
SANDGLASS_INLINE Int lane_index() { return {0}; }  // 0, 1, 2, ...

SANDGLASS_INLINE Float operator+(Float a, Float b) { return {a.v + b.v}; }
SANDGLASS_INLINE Float operator-(Float a, Float b) { return {a.v - b.v}; }
SANDGLASS_INLINE Float operator*(Float a, Float b) { return {a.v * b.v}; }
SANDGLASS_INLINE Float operator/(Float a, Float b) { return {a.v / b.v}; }
SANDGLASS_INLINE Float square_root(Float a) { return {__builtin_sqrtf(a.v)}; }
SANDGLASS_INLINE Float minimum(Float a, Float b) { return {a.v < b.v ? a.v : b.v}; }
SANDGLASS_INLINE Float maximum(Float a, Float b) { return {a.v > b.v ? a.v : b.v}; }
SANDGLASS_INLINE Float at_most(Float a, Float bound) { return minimum(a, bound); }
SANDGLASS_INLINE Float at_least(Float a, Float bound) { return maximum(a, bound); }
SANDGLASS_INLINE Float absolute(Float a) { return {__builtin_fabsf(a.v)}; }

SANDGLASS_INLINE Int operator+(Int a, Int b) { return {a.v + b.v}; }
SANDGLASS_INLINE Int operator-(Int a, Int b) { return {a.v - b.v}; }
SANDGLASS_INLINE Int operator&(Int a, Int b) { return {a.v & b.v}; }
SANDGLASS_INLINE Int operator|(Int a, Int b) { return {a.v | b.v}; }
SANDGLASS_INLINE Int minimum(Int a, Int b) { return {a.v < b.v ? a.v : b.v}; }
SANDGLASS_INLINE Int shift_left(Int a, int count) {
  return {static_cast<int32_t>(static_cast<uint32_t>(a.v) << count)};
}
// Zeros come in.
SANDGLASS_INLINE Int shift_right(Int a, int count) {
  return {static_cast<int32_t>(static_cast<uint32_t>(a.v) >> count)};
}
SANDGLASS_INLINE Int to_int(Float a) { return {to_whole<int32_t>(a.v)}; }
SANDGLASS_INLINE Int floor_int(Float a) { return {floor_whole(a.v)}; }
SANDGLASS_INLINE Float to_float(Int a) { return {static_cast<float>(a.v)}; }
SANDGLASS_INLINE Int as_int(Float a) { return {__builtin_bit_cast(int32_t, a.v)}; }  // the same bits

SANDGLASS_INLINE Mask operator<(Float a, Float b) { return {a.v < b.v}; }
SANDGLASS_INLINE Mask operator<=(Float a, Float b) { return {a.v <= b.v}; }
SANDGLASS_INLINE Mask operator==(Float a, Float b) { return {a.v == b.v}; }
SANDGLASS_INLINE Mask within(Float a, Float limit) { return absolute(a) < limit; }  // |a| < limit
SANDGLASS_INLINE Mask operator<(Int a, Int b) { return {a.v < b.v}; }
SANDGLASS_INLINE Mask operator==(Int a, Int b) { return {a.v == b.v}; }
SANDGLASS_INLINE Mask operator&(Mask a, Mask b) { return {a.m && b.m}; }
SANDGLASS_INLINE Mask operator|(Mask a, Mask b) { return {a.m || b.m}; }
SANDGLASS_INLINE Mask and_not(Mask a, Mask b) { return {a.m && !b.m}; }  // a and not b
SANDGLASS_INLINE bool any(Mask a) { return a.m; }
SANDGLASS_INLINE bool all(Mask a) { return a.m; }
SANDGLASS_INLINE uint32_t count(Mask a) { return a.m ? 1u : 0u; }
SANDGLASS_INLINE uint32_t first(Mask a) { return a.m ? 0u : 1u; }  // the first lane that holds; one must hold
SANDGLASS_INLINE Float select(Mask m, Float a, Float b) { return {m.m ? a.v : b.v}; }
SANDGLASS_INLINE Float keep(Mask m, Float a) { return {m.m ? a.v : 0.0f}; }  // select(m, a, 0)
SANDGLASS_INLINE Int select(Mask m, Int a, Int b) { return {m.m ? a.v : b.v}; }

// The largest and the smallest lane: exact, so the width does not matter. Lanes must not be NaN.
SANDGLASS_INLINE float lane_maximum(Float a) { return a.v; }
SANDGLASS_INLINE float lane_minimum(Float a) { return a.v; }

// base[index] for every lane.
SANDGLASS_INLINE Float gather(const float* base, Int index) { return {base[index.v]}; }

// A record holds integers too, which are loaded as if they were floats. The wide sets' vector types alias anything.
typedef float __attribute__((may_alias)) RecordFloat;
SANDGLASS_INLINE void load_records(const float* base, const uint32_t* index, uint32_t stride, Float out[8]) {
  (void)stride;
  const RecordFloat* p = base + static_cast<uint64_t>(index[0]) * 8;
  for (int c = 0; c < 8; ++c) out[c].v = p[c];
}
// The four floats `offset` floats behind each lane's pointer, aligned to 16 bytes.
SANDGLASS_INLINE void load_quads(const float* const* lanes, uint32_t offset, Float out[4]) {
  const RecordFloat* p = lanes[0] + offset;
  for (int c = 0; c < 4; ++c) out[c].v = p[c];
}
#include "kernels/simd/corners.inl"
// k_width consecutive records.
SANDGLASS_INLINE void load_records(const float* base, Float out[8]) {
  const RecordFloat* p = base;
  for (int c = 0; c < 8; ++c) out[c].v = p[c];
}
SANDGLASS_INLINE void broadcast_record(const float* p, Float out[8]) { load_records(p, out); }
SANDGLASS_INLINE void store_records(float* base, const Float in[8]) {
  RecordFloat* p = base;
  for (int c = 0; c < 8; ++c) p[c] = in[c].v;
}

SANDGLASS_INLINE void load_differences(const float* base, const uint32_t* first, const uint32_t* second, Float out[8]) {
  const RecordFloat* p = base + static_cast<uint64_t>(first[0]) * 8;
  const RecordFloat* q = base + static_cast<uint64_t>(second[0]) * 8;
  for (int c = 0; c < 7; ++c) out[c].v = q[c] - p[c];
  out[7].v = 0.0f;
}
SANDGLASS_INLINE void load_approaches(const float* base, const uint32_t* first, const uint32_t* second, Float out[3]) {
  Float d[8];
  load_differences(base, first, second, d);
  for (int c = 0; c < 3; ++c) out[c] = d[c] + d[4 + c];
}
SANDGLASS_INLINE void subtract_displacements(float* base, const uint32_t* index, const Float d[3]) {
  float* p = base + static_cast<uint64_t>(index[0]) * 8 + 4;
  for (int c = 0; c < 3; ++c) p[c] = p[c] - d[c].v;
}

SANDGLASS_INLINE uint32_t compress_store(uint32_t* p, Int v, Mask m) {
  *p = static_cast<uint32_t>(v.v);
  return m.m ? 1u : 0u;
}

}  // namespace sandglass::simd_scalar
