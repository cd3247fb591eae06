// How well a panorama that was taken at the height of the eye tells what light reaches the floor elsewhere.
#pragma once

#include <cstdint>

namespace sandglass::host {

// In made-up rooms, whose light can be traced at the foot itself: what a panorama tells of it that is warped to the foot,
// and what one tells that is warped to the place above it at the height of the eye. `level`: |ln| of the irradiance.
// `shares`: the sum of what the 64 cells are apart, 0..2.
struct Warped {
  struct Errors {
    double level = 0, shares = 0;
  } foot, eye;
};
Warped warped_beside_traced(uint64_t seed, uint32_t threads);

}  // namespace sandglass::host
