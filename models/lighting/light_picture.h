// A light estimate for the eye: the photograph with an arrow towards the light; a matt ball and a mirror ball on a
// floor, lit by it; and the environment map of (5.27 - 5.29). Directions are in the camera's frame (x right, y down, z
// forward), which is assumed to be level.
#pragma once

#include <string>

#include "models/files/image.h"
#include "models/rooms/panorama.h"
#include "sandglass/light.h"

namespace sandglass::host {

// An arrow from the middle towards the light as the camera sees it. Its tip is hollow if the light is behind the
// camera.
void draw_light_arrow(Picture* picture, Vec3 camera_direction, Colour colour);

void paste(Picture* onto, const Picture& picture, int x, int y);

// `estimate.direction` must be in the camera's frame.
Picture light_picture(const Picture& photograph, const sandglass_light_estimate& estimate, const std::string& name);

}  // namespace sandglass::host
