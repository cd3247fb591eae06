// Panoramas that are functions of the direction.
#pragma once

#include "models/rooms/panorama.h"

namespace sandglass::tests {

// `width` x `width` / 2 pixels; `radiance` gives the colour in a direction.
template <class Radiance>
host::RadianceMap panorama_of(int width, Radiance&& radiance) {
  host::RadianceMap map(width, width / 2);
  for (int v = 0; v < map.height; ++v)
    for (int u = 0; u < width; ++u) map.set(u, v, radiance(host::panorama_direction(u, v, width, map.height)));
  return map;
}

}  // namespace sandglass::tests
