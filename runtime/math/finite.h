// Whether numbers that an app or a file hands over can be computed with. Every test here is false for NaN.
#pragma once

#include <cstdint>

namespace sandglass {

inline bool is_finite(float x) { return x - x == 0.0f; }
inline bool is_finite(double x) { return x - x == 0.0; }

inline bool all_finite(const float* values, uint64_t count) {
  for (uint64_t i = 0; i < count; ++i) {
    if (!is_finite(values[i])) return false;
  }
  return true;
}

inline bool within(float x, float low, float high) { return x >= low && x <= high; }
inline bool within(double x, double low, double high) { return x >= low && x <= high; }

inline bool all_within(const float* values, uint64_t count, float low, float high) {
  for (uint64_t i = 0; i < count; ++i) {
    if (!within(values[i], low, high)) return false;
  }
  return true;
}

}  // namespace sandglass
