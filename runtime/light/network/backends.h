// Back ends of the lighting network beside the project's own kernels.
#pragma once

#include "runtime/light/network/network.h"

namespace sandglass {

// NULL in *backend stands for the project's own kernels. False, with one sentence, for an unknown back end or one that
// is not in this build.
bool find_light_backend(sandglass_estimator_backend choice, const LightBackend** backend, const char** reason);

// In float: the file's float network where it has one, else its bytes and multipliers without rounding in between. In
// int8: its bytes and multipliers, rounded as the project's own kernels round.
extern const LightBackend k_light_xnnpack_f32, k_light_xnnpack_int8;

}  // namespace sandglass
