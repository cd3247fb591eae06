// Real spherical harmonics up to order 2, as sandglass_light_estimate.sh lists them.
#pragma once

#include <cstdint>

namespace sandglass {

constexpr uint32_t k_harmonics = 9;

// The factor before the polynomial of coefficient i, and the polynomials at a unit vector: Y_i = factor * polynomial.
extern const double k_harmonic_factors[k_harmonics];
void harmonic_polynomials(const double v[3], double polynomials[k_harmonics]);

// What convolving with the clamped cosine and dividing by pi makes of coefficient i: 1, 2/3, 1/4 by its l.
extern const double k_cosine_factors[k_harmonics];

}  // namespace sandglass
