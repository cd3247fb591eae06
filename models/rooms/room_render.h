// Panoramas of rooms by path tracing (Embree). Every bounce aims a ray at one light, chosen by what each could
// contribute there, and at the sun if a window could let it in. Light found by chance is weighed against that (balance
// heuristic). Random numbers depend on seed, pixel and sample alone: equal seeds give equal bits on any number of
// threads.
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
  RadianceMap radiance;  // candela per square metre
  // Metres to the nearest surface along each pixel's centre. A window counts as the wall that it is in.
  std::vector<float> depth;
};

// Throws a Failure if this build has no Embree. The sun's disk is in the panorama where it is seen.
RoomPanorama trace_room(const Room& room, const RoomRenderOptions& options);

// Exposes as a camera does: half of the colour cast is taken out, the logarithmic mean of luminance becomes the key,
// and values above the limit of captured panoramas are cut off.
void expose(RadianceMap* map, double key);

}  // namespace sandglass::host
