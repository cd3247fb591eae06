// The light model as nine harmonics a colour. A lobe about an axis has coefficients z_l Y_lm(axis), z_l being its
// integral against the Legendre polynomial l (Funk and Hecke); those of the spherical Gaussian of (5.27) are closed.
#pragma once

#include "sandglass/light.h"

namespace sandglass {

constexpr uint32_t k_harmonics = 9;

// Of an estimate in the first version of the header: direction, colours and strength are in it.
constexpr uint32_t k_least_estimate_bytes = 192;
static_assert(k_least_estimate_bytes <= sizeof(sandglass_light_estimate));

// The factor before the polynomial of coefficient i, and the polynomials at a unit vector: Y_i = factor * polynomial.
extern const double k_harmonic_factors[k_harmonics];
void harmonic_polynomials(const double v[3], double polynomials[k_harmonics]);

// What convolving with the clamped cosine and dividing by pi makes of coefficient i: 1, 2/3, 1/4 by its l.
extern const double k_cosine_factors[k_harmonics];

// SH of the model, interleaved, in double.
void light_harmonics(const sandglass_light_estimate& estimate, sandglass_light_model model, double sh[3 * k_harmonics]);

// The rule of the header: how strong the directional light is.
double light_strength(const double direction[3], const double light[3], const double ambient[3], double contrast);

}  // namespace sandglass
