// What another system would tell of a panorama's light: cubes and harmonics (room.h), made from the panorama itself. So
// what they reach is the most that a system's own can reach.
#pragma once

#include <vector>

#include "tests/laboratory/room/session.h"

namespace sandglass::host {

// A probe alone, or beneath what a full turn of the camera has seen; a control is the linear cube or the harmonics passed
// wrongly.
struct ProbeVariant {
  const char* name;
  double limit;  // of ambient occlusion's error beside an object; for a control 1
  bool control;
};
constexpr ProbeVariant k_probe_variants[] = {{"probe: a linear cube of 16", 0.32, false},
                                             {"probe: a cube of bytes, 128", 0.68, false},
                                             {"probe: harmonics and a main light", 0.48, false},
                                             {"probe: harmonics of all light", 0.65, false},
                                             {"probe: a linear cube of 16, and a full turn", 0.35, false},
                                             {"control: a probe, mirrored", 1, true},
                                             {"control: a probe, turned by 90 degrees", 1, true},
                                             {"control: harmonics, the other sign of the phase", 1, true}};
constexpr const char* k_probe_elsewhere = "control: a probe in another room";  // the first of them

// The light at a place in radii of the panorama's sphere, by k_probe_variants. `turn`: what a full turn has seen.
std::vector<sandglass_room_light> probe_lights(const RadianceMap& panorama, const SeenRoom& turn, bool exposure_known,
                                               Vec3 place);

}  // namespace sandglass::host
