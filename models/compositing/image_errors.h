// How far a picture is from its truth: the dissertation's four measures and the literature's scale-invariant one.
#pragma once

#include "models/rooms/panorama.h"

namespace sandglass::host {

struct ImageErrors {
  double rmse = 0.0;             // (5.30)
  double relative = 0.0;         // RMSE over the root mean square of the truth (5.31, with a mean instead of a sum)
  double scale_invariant = 0.0;  // the least RMSE over all scalings of the picture
  double logarithmic = 0.0;      // RMSE of log(1 + value) (5.32)
  double angle_deg = 0.0;        // mean angle between colours (5.33); black pixels have none and are left out
};

ImageErrors compare(const RadianceMap& truth, const RadianceMap& picture);

}  // namespace sandglass::host
