// A camera that turns about a point, and the ray through the cursor.
#pragma once

#include "models/geometry/camera.h"
#include "models/geometry/vec3.h"

namespace sandglass::host {

struct Ray {
  Vec3 origin, direction;  // direction of length 1
};

class Orbit {
 public:
  explicit Orbit(const Camera& from);

  void turn(double right, double up);  // radians; the camera stays short of the poles
  void zoom(double factor);            // scales the distance; it stays between 1/20 and 20 times the first
  Camera camera() const;

  // The ray through a pixel. x and y count from the upper left corner of a window of this size.
  Ray ray(double x, double y, int width, int height) const;

 private:
  Vec3 target_;
  double azimuth_, elevation_, distance_, nearest_, furthest_, fov_deg_;
};

// The point where the ray meets the horizontal plane at `height`, if that is at most `reach` metres away. Otherwise the
// point of the plane above or below the ray's end at that distance.
Vec3 on_plane(const Ray& ray, double height, double reach);

}  // namespace sandglass::host
