// The float network in the form in which a lighting file has it beside the bytes (runtime/asset/light.fbs): rounded
// only to float, and not calibrated.
#pragma once

#include <vector>

#include "models/lighting/light_net.h"

namespace sandglass::host {

std::vector<float> float_parameters(const LightNet& net);

}  // namespace sandglass::host
