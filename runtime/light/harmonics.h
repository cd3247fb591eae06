// Real spherical harmonics up to order 2, as sandglass_estimator_light.sh lists them.
#pragma once

#include <cstdint>

namespace sandglass {

constexpr uint32_t k_harmonics = 9;

// The factor before the polynomial of coefficient i, and the polynomials at a unit vector: Y_i = factor * polynomial.
extern const double k_harmonic_factors[k_harmonics];
void harmonic_polynomials(const double v[3], double polynomials[k_harmonics]);

// Coefficients 0 and 1 of radiance 1 from everywhere below the horizon, sqrt(pi) and -pi sqrt(3 / (4 pi)); the others
// are 0.
constexpr double k_below_harmonics[2] = {1.7724538509055159, -1.5349900619197328};

// What convolving with the clamped cosine and dividing by pi makes of coefficient i: 1, 2/3, 1/4 by its l.
extern const double k_cosine_factors[k_harmonics];

// Of coefficient i: the sign that the Condon-Shortley phase changes, where m is odd.
constexpr double phase_of(uint32_t i) { return i % 2 == 1 ? -1.0 : 1.0; }

}  // namespace sandglass
