// A camera that turns about a point, and the ray under the cursor.
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

  void turn(double right, double up);  // radians; the elevation stays within the poles
  void zoom(double factor);            // of the distance; it stays between 1/20 and 20 times the first one
  Camera camera() const;

  // Through a pixel, from the upper left corner of a window of this size.
  Ray ray(double x, double y, int width, int height) const;

 private:
  Vec3 target_;
  double azimuth_, elevation_, distance_, nearest_, furthest_, fov_deg_;
};

// Where the ray meets the horizontal plane at `height`, at most `reach` metres away; beyond that, the point of the
// plane under the ray's end.
Vec3 on_plane(const Ray& ray, double height, double reach);

}  // namespace sandglass::host
