// A relief takes an image, with or without what makes its heights hold.
#pragma once

#include "sandglass/sandglass.hpp"

namespace sandglass::host {

// What is left out, or done as one would at first.
enum class Left { nothing, lock, clearing, lowest_peak, hysteresis };

void take_image(cpp::Relief* relief, const sandglass_depth_image& image, Left left);

}  // namespace sandglass::host
