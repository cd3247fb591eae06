// The one conversion from floating point to whole numbers. A plain cast is undefined where the number does not fit, and
// ARM and x86 then differ.
#pragma once

#include <limits>

namespace sandglass {

// Toward zero. What does not fit becomes the nearest that does; NaN becomes 0. Always inline, because every instruction
// set compiles it anew.
template <class Whole, class Real>
[[gnu::always_inline]] inline Whole to_whole(Real x) {
  constexpr Whole k_least = std::numeric_limits<Whole>::min(), k_most = std::numeric_limits<Whole>::max();
  // Powers of two.
  constexpr Whole k_half = k_most / 2 + 1;
  constexpr Real k_low = static_cast<Real>(k_least), k_above = 2 * static_cast<Real>(k_half);
  if (!(x > k_low)) return x <= k_low ? k_least : Whole{0};
  return x < k_above ? static_cast<Whole>(x) : k_most;
}

}  // namespace sandglass
