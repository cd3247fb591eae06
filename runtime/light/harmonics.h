// The light model as nine harmonics a colour. A lobe about an axis has the coefficients z_l Y_lm(axis), where z_l is
// its integral against the Legendre polynomial l (Funk and Hecke). For the spherical Gaussian of (5.27) these integrals
// have a closed form.
#pragma once

#include "sandglass/light.h"
#include "sandglass/room.h"

namespace sandglass {

constexpr uint32_t k_harmonics = 9;

// The size of an estimate in the first version of the header. Direction, colours and strength lie within it.
constexpr uint32_t k_least_estimate_bytes = 192;
static_assert(k_least_estimate_bytes <= sizeof(sandglass_light_estimate));
// The same of the light of a room.
constexpr uint32_t k_least_room_light_bytes = 688;
static_assert(k_least_room_light_bytes <= sizeof(sandglass_room_light));

// The factor before the polynomial of coefficient i, and the polynomials at a unit vector: Y_i = factor * polynomial.
extern const double k_harmonic_factors[k_harmonics];
void harmonic_polynomials(const double v[3], double polynomials[k_harmonics]);

// What convolving with the clamped cosine and dividing by pi makes of coefficient i: 1, 2/3, 1/4 by its l.
extern const double k_cosine_factors[k_harmonics];

// The harmonics of the model, interleaved (r0 g0 b0 ...), in double.
void light_harmonics(const sandglass_light_estimate& estimate, sandglass_light_model model, double sh[3 * k_harmonics]);

// The radiance of a white surface that faces the main light of a room, by that light alone.
void main_light_of(const sandglass_room_light& light, double facing[3]);
// The same for the light of a room; models AMBIENT and WHOLE.
void room_harmonics(const sandglass_room_light& light, sandglass_light_model model, double sh[3 * k_harmonics]);

// How strong the directional light is: the rule of sandglass/light.h.
double light_strength(const double direction[3], const double light[3], const double ambient[3], double contrast);

}  // namespace sandglass
