// See orbit.h.
#include "models/view/orbit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sandglass::host {

// k_highest: radians, short of the pole, where "right" has no meaning.
constexpr double k_zoom_range = 20.0, k_highest = 1.55;

Orbit::Orbit(const Camera& from) : target_(from.target), fov_deg_(from.fov_deg) {
  const Vec3 to_eye = from.eye - from.target;
  distance_ = std::max(1e-3, length(to_eye));
  nearest_ = distance_ / k_zoom_range, furthest_ = distance_ * k_zoom_range;
  azimuth_ = std::atan2(to_eye.x, to_eye.z);
  elevation_ = std::asin(std::clamp(to_eye.y / distance_, -1.0, 1.0));
  turn(0.0, 0.0);
}

void Orbit::turn(double right, double up) {
  azimuth_ += right;
  elevation_ = std::clamp(elevation_ + up, -k_highest, k_highest);
}

void Orbit::zoom(double factor) { distance_ = std::clamp(distance_ * factor, nearest_, furthest_); }

Camera Orbit::camera() const {
  Camera camera;
  const double flat = std::cos(elevation_);
  camera.target = target_;
  camera.eye = target_ + Vec3{std::sin(azimuth_) * flat, std::sin(elevation_), std::cos(azimuth_) * flat} * distance_;
  camera.fov_deg = fov_deg_;
  return camera;
}

Ray Orbit::ray(double x, double y, int width, int height) const {
  const Camera from = camera();
  const Vec3 forward = normalised(from.target - from.eye), right = normalised(cross(forward, Vec3{0, 1, 0})),
             up = cross(right, forward);
  const double focal = 0.5 / std::tan(fov_deg_ * std::numbers::pi / 360.0);  // in window heights
  return {from.eye,
          normalised(forward * focal + right * ((x - 0.5 * width) / height) + up * ((0.5 * height - y) / height))};
}

Vec3 on_plane(const Ray& ray, double height, double reach) {
  const double along = ray.direction.y == 0.0 ? -1.0 : (height - ray.origin.y) / ray.direction.y;
  Vec3 at = ray.origin + ray.direction * (along > 0.0 ? std::min(along, reach) : reach);
  at.y = height;
  return at;
}

}  // namespace sandglass::host
