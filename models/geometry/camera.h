// The camera of a picture: where it stands, what it looks at, and its angle of view.
#pragma once

#include <cmath>
#include <numbers>

#include "models/geometry/vec3.h"

namespace sandglass::host {

struct Camera {
  Vec3 eye, target;
  double fov_deg = 32.0;  // vertical
};

// The same by its axes.
struct CameraFrame {
  Vec3 eye, right, up, forward;
  double focal = 1.0;  // picture heights

  // Towards the place (x, y) in pixels of a width x height picture; not normalised.
  Vec3 ray(double x, double y, int width, int height) const {
    return forward * focal + right * ((x - 0.5 * width) / height) + up * ((0.5 * height - y) / height);
  }
};
inline CameraFrame frame_of(const Camera& camera) {
  const Vec3 forward = normalised(camera.target - camera.eye), right = normalised(cross(forward, Vec3{0, 1, 0}));
  return {camera.eye, right, cross(right, forward), forward, 0.5 / std::tan(camera.fov_deg * std::numbers::pi / 360.0)};
}

}  // namespace sandglass::host
