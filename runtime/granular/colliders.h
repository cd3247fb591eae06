// Analytic colliders on their way through a frame: checked once, then posed at the instant a sub-step ends.
#pragma once

#include "kernels/kernels.h"
#include "sandglass/sandglass.h"

namespace sandglass {

// Finite, with positive sizes and a usable rotation? Writes the collider with its rotation normalised.
bool collider_accept(const sandglass_collider& collider, sandglass_collider* accepted);

// Poses each collider `before` seconds before the end of the frame, moving back along its velocities.
void colliders_pose(const sandglass_collider* colliders, uint32_t count, float before, ColliderFrame* frames);

}  // namespace sandglass
