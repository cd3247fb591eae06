// What a network's colours and contrast are as light: the rules of sandglass/estimator.h.
#pragma once

#include "runtime/light/harmonics.h"
#include "sandglass/estimator.h"

namespace sandglass {

// How strong the directional light is.
double light_strength(const double direction[3], const double light[3], const double ambient[3], double contrast);

// The harmonics `sh` of an estimate by its other fields, interleaved (r0 g0 b0 ...), in double.
void estimate_harmonics(const sandglass_estimator_light& estimate, double sh[3 * k_harmonics]);

}  // namespace sandglass
