// The camera of a picture: where it stands, what it looks at, and its angle of view.
#pragma once

#include "models/geometry/vec3.h"

namespace sandglass::host {

struct Camera {
  Vec3 eye, target;
  double fov_deg = 32.0;  // vertical
};

}  // namespace sandglass::host
