// A light estimate for the eye: the photograph with an arrow towards the light, a matt ball lit by the estimate, and the
// colours of the light and of the rest. Directions are in the camera's frame (x right, y down, z forward), which is
// assumed to be level.
#pragma once

#include <string>

#include "models/files/image.h"
#include "models/geometry/vec3.h"
#include "sandglass/estimate.h"

namespace sandglass::host {

// An arrow from the middle towards the light as the camera sees it. Its tip is hollow if the light is behind the
// camera.
void draw_light_arrow(Picture* picture, Vec3 camera_direction, Colour colour);

// `estimate.direction` must be in the camera's frame.
Picture light_picture(const Picture& photograph, const sandglass_light_estimate& estimate, const std::string& name);

}  // namespace sandglass::host
