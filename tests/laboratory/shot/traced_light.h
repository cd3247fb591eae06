// How well a panorama that was taken at the height of the eye tells what light reaches the floor elsewhere.
#pragma once

#include <cstdint>

namespace sandglass::host {

// In made-up rooms, whose light can be traced at the foot itself: |ln| of the irradiance there by the panorama that was
// taken at the height of the eye, warped to the foot, and to the place above it at the height of the eye.
struct Warped {
  double to_foot = 0, to_level = 0;
};

Warped warped_beside_traced(uint64_t seed, uint32_t threads);

}  // namespace sandglass::host
