// The float network as a lighting file carries it beside the bytes (runtime/asset/light.fbs): nothing rounded but to
// float, nothing calibrated.
#pragma once

#include <vector>

#include "models/lighting/light_net.h"

namespace sandglass::host {

std::vector<float> float_parameters(const LightNet& net);

}  // namespace sandglass::host
