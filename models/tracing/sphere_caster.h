// Rays against many equal spheres: Embree's sphere points where Embree is found, else a grid walk of our own that gives
// the same pictures more slowly (the emulated ARM build, say).
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "models/geometry/vec3.h"

namespace sandglass::host {

struct SphereHit {
  double distance = 0.0;  // along the unit direction
  uint32_t index = 0;     // of the sphere
};

class SphereCaster {
 public:
  SphereCaster(std::span<const float> centres, float radius);  // centres that are not finite are left out
  ~SphereCaster();
  SphereCaster(const SphereCaster&) = delete;
  SphereCaster& operator=(const SphereCaster&) = delete;

  // First sphere on the ray within hit->distance (set it to the limit before); false and *hit untouched if there is
  // none.
  bool closest(Vec3 origin, Vec3 direction, SphereHit* hit) const;
  bool occluded(Vec3 origin, Vec3 direction, double limit) const;

  static const char* engine();  // "embree" or "grid"

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host
