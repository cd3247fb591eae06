// Numbers of 16 bits, of 0..65000.
#pragma once

#include <cstdint>

#include "kernels/whole.h"

namespace sandglass {

constexpr double k_half_most = 65000.0;

inline uint16_t half_of(double value) {
  const float x = static_cast<float>(value < k_half_most ? value : k_half_most);
  if (!(x > 0)) return 0;
  if (x < 0x1p-14f) return to_whole<uint16_t>(static_cast<double>(x) * 0x1p24 + 0.5);
  uint32_t bits;
  __builtin_memcpy(&bits, &x, sizeof bits);
  return static_cast<uint16_t>((bits + 0x1000 - 0x38000000u) >> 13);
}

// NaN and what is negative are 0, infinity is as bright as a half can be.
inline double from_half(uint16_t h) {
  const uint32_t exponent = h >> 10 & 31u, mantissa = h & 1023u;
  if ((h & 0x8000u) != 0 || (exponent == 31 && mantissa != 0)) return 0;
  if (exponent == 31) return k_half_most;
  if (exponent == 0) return mantissa * 0x1p-24;
  const uint32_t bits = (exponent + 112) << 23 | mantissa << 13;
  float value;
  __builtin_memcpy(&value, &bits, sizeof value);
  return static_cast<double>(value);
}

}  // namespace sandglass
