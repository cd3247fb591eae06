// The one conversion from floating point to whole numbers. A plain cast is undefined where the number does not fit, and
// ARM and x86 then differ.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

namespace sandglass {

#ifdef __aarch64__

// ARM's own conversion is bounded as to_whole is, in one instruction. It is written as assembly because to a compiler
// it is a cast, which is undefined where the number does not fit; the intrinsics of g++ are such casts.
template <class Whole, class Real>
[[gnu::always_inline]] inline Whole convert_bounded(Real x) {
  constexpr bool k_signed = std::is_signed_v<Whole>, k_wide = sizeof(Whole) == 8, k_double = sizeof(Real) == 8;
  Whole whole;
  if constexpr (k_signed && k_wide && k_double) asm("fcvtzs %x0, %d1" : "=r"(whole) : "w"(x));
  else if constexpr (k_signed && k_wide) asm("fcvtzs %x0, %s1" : "=r"(whole) : "w"(x));
  else if constexpr (k_signed && k_double) asm("fcvtzs %w0, %d1" : "=r"(whole) : "w"(x));
  else if constexpr (k_signed) asm("fcvtzs %w0, %s1" : "=r"(whole) : "w"(x));
  else if constexpr (k_wide && k_double) asm("fcvtzu %x0, %d1" : "=r"(whole) : "w"(x));
  else if constexpr (k_wide) asm("fcvtzu %x0, %s1" : "=r"(whole) : "w"(x));
  else if constexpr (k_double) asm("fcvtzu %w0, %d1" : "=r"(whole) : "w"(x));
  else asm("fcvtzu %w0, %s1" : "=r"(whole) : "w"(x));
  return whole;
}

#elif defined(__wasm_nontrapping_fptoint__)

// So is WebAssembly's.
template <class Whole, class Real>
[[gnu::always_inline]] inline Whole convert_bounded(Real x) {
  constexpr bool k_signed = std::is_signed_v<Whole>, k_wide = sizeof(Whole) == 8, k_double = sizeof(Real) == 8;
  if constexpr (k_signed && k_wide && k_double) return __builtin_wasm_trunc_saturate_s_i64_f64(x);
  else if constexpr (k_signed && k_wide) return __builtin_wasm_trunc_saturate_s_i64_f32(x);
  else if constexpr (k_signed && k_double) return __builtin_wasm_trunc_saturate_s_i32_f64(x);
  else if constexpr (k_signed) return __builtin_wasm_trunc_saturate_s_i32_f32(x);
  else if constexpr (k_wide && k_double) return static_cast<Whole>(__builtin_wasm_trunc_saturate_u_i64_f64(x));
  else if constexpr (k_wide) return static_cast<Whole>(__builtin_wasm_trunc_saturate_u_i64_f32(x));
  else if constexpr (k_double) return static_cast<Whole>(__builtin_wasm_trunc_saturate_u_i32_f64(x));
  else return static_cast<Whole>(__builtin_wasm_trunc_saturate_u_i32_f32(x));
}

#endif

// Toward zero. What does not fit becomes the nearest that does; NaN becomes 0. Always inline, because every instruction
// set compiles it anew.
template <class Whole, class Real>
[[gnu::always_inline]] inline Whole to_whole(Real x) {
  constexpr Whole k_min = std::numeric_limits<Whole>::min(), k_max = std::numeric_limits<Whole>::max();
#if defined(__aarch64__) || defined(__wasm_nontrapping_fptoint__)
  if constexpr (sizeof(Whole) >= 4) return convert_bounded<Whole>(x);
#endif
  // Powers of two.
  constexpr Whole k_half = k_max / 2 + 1;
  constexpr Real k_low = static_cast<Real>(k_min), k_above = 2 * static_cast<Real>(k_half);
  if (!(x > k_low)) return x <= k_low ? k_min : Whole{0};
  return x < k_above ? static_cast<Whole>(x) : k_max;
}

// The largest whole number not above x, within +-2^29: the numbers beside it fit as well. NaN becomes the smallest.
[[gnu::always_inline]] inline int32_t floor_whole(float x) {
  const float bounded = x > -536870912.0f ? (x < 536870912.0f ? x : 536870912.0f) : -536870912.0f;
  const int32_t truncated = to_whole<int32_t>(bounded);
  return bounded < static_cast<float>(truncated) ? truncated - 1 : truncated;
}

}  // namespace sandglass
