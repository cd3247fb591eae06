// Rays against a mesh, by Embree: occlusion for baking, the closest hit, and an inside test that doubts itself.
#pragma once

#ifdef SANDGLASS_HAVE_EMBREE

#include "models/mesh/mesh.h"
#include "models/tracing/embree_scene.h"

namespace sandglass::host {

struct RayHit {
  bool hit;
  float distance;   // in lengths of the direction
  float normal[3];  // geometric, by the triangle's orientation, unit length
  uint32_t triangle;
};

// Copies what it needs of the mesh. Any number of threads may query at the same time. A Failure where Embree does not
// start.
class RayCaster {
 public:
  explicit RayCaster(const Mesh& mesh);

  bool occluded(const float origin[3], const float direction[3], float nearest, float farthest) const {
    return scene_.occluded(origin, direction, nearest, farthest);
  }
  bool occluded(Vec3 origin, Vec3 direction, double limit) const { return scene_.occluded(origin, direction, limit); }
  RayHit closest(const float origin[3], const float direction[3], float nearest, float farthest) const;
  RayHit closest(Vec3 origin, Vec3 direction, double limit) const;

  // Parity of ray crossings. A ray that passes close to an edge, or along a face, proves nothing and is cast again in
  // another direction. Two rays that prove something must agree; else more are asked, and the majority counts.
  bool inside(const float point[3]) const;
  // The same in the form of sandglass_inside; user is the RayCaster.
  static int inside_test(void* user, const float point[3]);

 private:
  EmbreeScene scene_;
};

}  // namespace sandglass::host

#endif
