// Balls that reflect a room, as a screen shows them: lit by the cube that the library's room gives, beside the panorama.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "models/rooms/panorama.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

// `rooms`: panoramas, 512 pixels wide. go_on: called before each; false ends.
std::vector<Verdict> verify_reflections(const std::vector<RadianceMap>& rooms, uint64_t seed,
                                        const std::function<bool()>& go_on);

}  // namespace sandglass::host
