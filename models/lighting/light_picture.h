// A light estimate for the eye: the photograph with an arrow towards the light, two balls on a floor lit by it, one
// matt, one of mirror, and the environment map of (5.27 - 5.29). Directions are in the camera's frame (x right, y down,
// z forward), which is taken to be level.
#pragma once

#include <string>

#include "models/files/image.h"
#include "models/rooms/panorama.h"
#include "sandglass/light.h"

namespace sandglass::host {

// From the middle towards the light as the camera sees it; a hollow tip for one behind the camera.
void draw_light_arrow(Picture* picture, Vec3 camera_direction, Colour colour);

void paste(Picture* onto, const Picture& picture, int x, int y);

// Box mean or bilinear; into width x height, whatever the shape was.
Picture scaled(const Picture& picture, int width, int height);

// `estimate.direction` in the camera's frame.
Picture lit_balls(const sandglass_light_estimate& estimate, int width, int height);
Picture environment_picture(const sandglass_light_estimate& estimate, int width, int height);

Picture light_picture(const Picture& photograph, const sandglass_light_estimate& estimate, const std::string& name);

}  // namespace sandglass::host
