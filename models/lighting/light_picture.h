// A light estimate for the eye: the photograph with an arrow towards the light, and the colours of the light and of the
// rest. Directions are in the camera's frame (x right, y down, z forward), which is assumed to be level.
#pragma once

#include <string>

#include "models/files/image.h"
#include "sandglass/estimator.h"

namespace sandglass::host {

// `estimate.direction` must be in the camera's frame.
Picture light_picture(const Picture& photograph, const sandglass_estimator_light& estimate, const std::string& name);

}  // namespace sandglass::host
