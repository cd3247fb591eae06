// Traces rays against a mesh with Embree: occlusion, the closest hit, and an inside test that does not trust rays near
// edges.
#pragma once

#ifdef SANDGLASS_HAVE_EMBREE

#include "models/mesh/mesh.h"
#include "models/tracing/embree_scene.h"

namespace sandglass::host {

struct RayHit {
  bool hit;
  float distance;   // in lengths of the direction
  float normal[3];  // of the triangle, by the order of its corners; unit length
  uint32_t triangle;
};

// Copies what it needs from the mesh. Any number of threads may query at the same time. The constructor throws a
// Failure when Embree does not start or when memory is too small.
class RayCaster {
 public:
  explicit RayCaster(const Mesh& mesh);

  bool occluded(const float origin[3], const float direction[3], float nearest, float farthest) const {
    return scene_.occluded(origin, direction, nearest, farthest);
  }
  bool occluded(Vec3 origin, Vec3 direction, double limit) const { return scene_.occluded(origin, direction, limit); }
  RayHit closest(const float origin[3], const float direction[3], float nearest, float farthest) const;
  RayHit closest(Vec3 origin, Vec3 direction, double limit) const;

  // The parity of a ray's crossings tells inside from outside. A ray that passes close to an edge or along a face is
  // doubtful, and another direction is tried. The first answer that two sure rays give counts. If nine rays do not
  // reach that, the majority of the sure rays counts, then that of the doubtful rays.
  bool inside(const float point[3]) const;
  // The same in the form of sandglass_inside; `user` is the RayCaster.
  static int inside_test(void* user, const float point[3]);

 private:
  EmbreeScene scene_;
};

}  // namespace sandglass::host

#endif
