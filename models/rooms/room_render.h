// Panoramas of rooms by path tracing (Embree). Every bounce aims a ray at a light chosen by what each could contribute
// there, and at the sun where a window could let it in; light found by chance is weighed against that (balance
// heuristic). Random numbers are a function of seed, pixel and sample alone: equal seeds give equal bits on any number
// of threads.
#pragma once

#include <cstdint>

#include "models/rooms/panorama.h"
#include "models/rooms/room.h"

namespace sandglass::host {

struct RoomRenderOptions {
  int width = 512;   // of the panorama; it is half as high
  int samples = 64;  // paths a pixel
  uint32_t threads = 1;
};

struct RoomPanorama {
  RadianceMap radiance;      // candela per square metre
  std::vector<float> depth;  // metres to the nearest surface along each pixel's centre; a window counts as the wall it
                             // is in, so that depth is always that of the room
};

// A Failure where this build has no Embree. The sun's disk is in the panorama where it is seen.
RoomPanorama trace_room(const Room& room, const RoomRenderOptions& options);

// As a camera would: half of the colour cast is taken out, the logarithmic mean of luminance becomes the key, and what
// is brighter than a captured panorama's limit is cut off.
void expose(RadianceMap* map, double key);

}  // namespace sandglass::host
