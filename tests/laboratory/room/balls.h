// Three balls, the yardstick of papers on lighting since 2022: a mirror, matte silver and a diffuse one, 32 pixels across,
// in the light that a session knows and in that of the panorama, both at the place of its camera.
#pragma once

#include <array>

#include "tests/laboratory/room/session.h"

namespace sandglass::host {

constexpr const char* k_ball_names[] = {"a mirror", "matte silver", "diffuse"};
struct BallErrors {
  double rmse = 0, scale_invariant = 0;  // of the truth's root mean square
  double angle_deg = 0;                  // between the colours of a pixel, the mean
};
using ThreeBalls = std::array<BallErrors, 3>;

// `mirrored`: a control, the light that is known is exchanged left and right.
ThreeBalls ball_errors(const RadianceMap& panorama, const SeenRoom& seen, double azimuth, bool mirrored = false);

}  // namespace sandglass::host
