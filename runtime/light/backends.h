// Back ends of the lighting network beside the project's own kernels.
#pragma once

#include "runtime/light/network.h"

namespace sandglass {

// NULL in *backend: the project's own. False, and one sentence, for one that is none or not in this build.
bool find_light_backend(sandglass_light_backend choice, const LightBackend** backend, const char** reason);

// The file's float network, else its bytes and multipliers without any rounding in between; these with it.
extern const LightBackend k_light_xnnpack_f32, k_light_xnnpack_int8;

}  // namespace sandglass
