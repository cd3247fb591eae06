// A scene of triangles or spheres that Embree traces rays against. SphereCaster, the path tracers and the truth of
// baked shadows are built on it. Without Embree only SphereCaster exists (sphere_caster_grid.cpp).
#pragma once

#ifdef SANDGLASS_HAVE_EMBREE

#include <embree3/rtcore.h>

#include <cstdint>
#include <span>

#include "models/geometry/vec3.h"

namespace sandglass::host {

struct EmbreeHit {
  bool found = false;
  float distance = 0.0f;  // in lengths of the direction
  // Of a triangle: by the order of its corners; its length is twice the triangle's area.
  float normal[3] = {};
  uint32_t primitive = 0;

  Vec3 unit_normal() const;
};

// Any number of threads may trace at the same time. triangles() and spheres() throw a Failure when Embree does not
// start or when memory is too small.
class EmbreeScene {
 public:
  // 3 floats per vertex, 3 indices per triangle. The scene is robust: no ray slips through between two triangles.
  static EmbreeScene triangles(std::span<const float> vertices, std::span<const uint32_t> indices,
                               RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM);
  // 4 floats per sphere: centre and radius. May be empty.
  static EmbreeScene spheres(std::span<const float> spheres);

  EmbreeScene(EmbreeScene&& other) noexcept;
  ~EmbreeScene();
  EmbreeScene& operator=(EmbreeScene&&) = delete;

  EmbreeHit closest(Vec3 origin, Vec3 direction, double limit) const;
  bool occluded(Vec3 origin, Vec3 direction, double limit) const;

  // Sixteen rays from (x, 0, z), cast together: neighbouring directions visit the same nodes. Bit i is 1 where direction
  // i is hidden. A direction that does not rise is not. In units of the object's size rays start 1e-5 away, so that a
  // face in the plane hides nothing.
  static constexpr uint32_t k_packet = 16;
  uint32_t hidden(double x, double z, const float* direction_x, const float* direction_y,
                  const float* direction_z) const;

 private:
  explicit EmbreeScene(const char* device);
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

}  // namespace sandglass::host

#endif
