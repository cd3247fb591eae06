// Numbers of 16 bits, of 0..65000.
#pragma once

#include <cstdint>

#include "kernels/whole.h"

namespace sandglass {

constexpr double k_half_max = 65000.0;

inline uint16_t half_of(double value) {
  const float x = static_cast<float>(value < k_half_max ? value : k_half_max);
  if (!(x > 0)) return 0;
  if (x < 0x1p-14f) return to_whole<uint16_t>(static_cast<double>(x) * 0x1p24 + 0.5);
  uint32_t bits;
  __builtin_memcpy(&bits, &x, sizeof bits);
  return static_cast<uint16_t>((bits + 0x1000 - 0x38000000u) >> 13);
}

// Any half, as the same number.
inline float number_from_half(uint16_t h) {
  const uint32_t exponent = h >> 10 & 31u, mantissa = h & 1023u, sign = uint32_t{h & 0x8000u} << 16;
  uint32_t bits = sign | (exponent == 31 ? 255u : exponent + 112) << 23 | mantissa << 13;
  float value = static_cast<float>(mantissa) * 0x1p-24f;
  if (exponent == 0) return sign != 0 ? -value : value;
  __builtin_memcpy(&value, &bits, sizeof value);
  return value;
}
// NaN and what is negative are 0, infinity is as bright as a half can be.
inline double from_half(uint16_t h) {
  const float value = number_from_half(h);
  if (!(value > 0)) return 0;
  return value <= 65504.0f ? static_cast<double>(value) : k_half_max;
}

}  // namespace sandglass
