// The sources of a sandglass_light: an estimate, the light of a room, and what a system reports of it.
#pragma once

#include "sandglass/renderers.h"

namespace sandglass {

// The sizes of a source and of a sandglass_light in the first version of their headers. All that is read lies within.
constexpr uint32_t k_estimate_bytes_min = 192, k_room_light_bytes_min = 688, k_light_bytes_min = 256;
static_assert(k_estimate_bytes_min <= sizeof(sandglass_estimator_light));
static_assert(k_room_light_bytes_min <= sizeof(sandglass_room_light));
static_assert(k_light_bytes_min <= sizeof(sandglass_light));

bool usable(const sandglass_light& light);
// The radiance of a white surface that faces the main light of a room, by that light alone.
void main_light_of(const sandglass_room_light& light, double facing[3]);

}  // namespace sandglass
