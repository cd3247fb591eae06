// Traces rays against many spheres. It uses Embree's sphere points when Embree is found. Otherwise, as in the
// emulated ARM build, it walks a grid of our own, which gives the same pictures more slowly.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "models/geometry/vec3.h"

namespace sandglass::host {

struct SphereHit {
  double distance = 0.0;  // along the ray; its direction has length 1
  uint32_t index = 0;     // of the sphere
};

class SphereCaster {
 public:
  // Centres that are not finite are left out. sizes: none, or one a sphere, of which each is as many radii large.
  SphereCaster(std::span<const float> centres, float radius, std::span<const float> sizes = {});
  ~SphereCaster();
  SphereCaster(const SphereCaster&) = delete;
  SphereCaster& operator=(const SphereCaster&) = delete;

  // Finds the first sphere on the ray within hit->distance, which must hold the limit. Returns false and leaves *hit as
  // it was when there is none.
  bool closest(Vec3 origin, Vec3 direction, SphereHit* hit) const;
  bool occluded(Vec3 origin, Vec3 direction, double limit) const;

  static const char* engine();  // "embree" or "grid"

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host
