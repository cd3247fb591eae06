// A room of the library that knows a panorama, as if another system had handed it over as a cube.
#pragma once

#include "models/rooms/panorama.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

// The panorama's frame is the world. Throws the library's reason.
void know_room(const RadianceMap& panorama, cpp::Room* room);

// The light of a plane through the origin.
sandglass_room_light light_on(const cpp::Room& room, const float normal[3], const float along[3]);

}  // namespace sandglass::host
