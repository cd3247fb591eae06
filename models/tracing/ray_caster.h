// Rays against a mesh, by Embree: occlusion for baking, the closest hit, and an inside test that doubts itself.
#pragma once

#ifdef SANDGLASS_HAVE_EMBREE

#include <memory>

#include "models/mesh/mesh.h"

namespace sandglass::host {

struct RayHit {
  bool hit;
  float distance;   // in lengths of the direction
  float normal[3];  // geometric, by the triangle's orientation, unit length
  uint32_t triangle;
};

// Copies what it needs of the mesh. Any number of threads may query at the same time.
class RayCaster {
 public:
  explicit RayCaster(const Mesh& mesh);
  ~RayCaster();
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  // Empty, or the sentence of why Embree could not be used; then no other member may be called.
  const std::string& error() const;

  bool occluded(const float origin[3], const float direction[3], float nearest, float farthest) const;
  RayHit closest(const float origin[3], const float direction[3], float nearest, float farthest) const;

  // Parity of ray crossings. A ray that passes close to an edge, or along a face, proves nothing and is cast again in
  // another direction; two rays that prove something must agree, else more are asked and the majority counts.
  bool inside(const float point[3]) const;
  // The same in the form of sandglass_inside; user is the RayCaster.
  static int inside_test(void* user, const float point[3]);

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace sandglass::host

#endif
