// The surface part of a baked shadow (runtime/asset/shadow.fbs): how the object's vertices see the room past the object
// itself.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "models/geometry/vec3.h"
#include "models/mesh/mesh.h"
#include "models/tracing/embree_scene.h"
#include "models/work/thread_pool.h"

namespace sandglass::host {

constexpr uint32_t k_transfer = 9;  // coefficients of a point

// A vertex, or one side of a crease at a vertex.
struct SurfacePoint {
  Vec3 position, normal;
};

// The points of a mesh, in order of x. Edges longer than a sixteenth of its size are halved first, so that the nearest
// point is near everywhere. Triangles that meet at a vertex share a point where their normals are within 40
// degrees of each other; its normal is the mean of theirs, weighted by their angles there. Meshes that are inside out
// are turned.
std::vector<SurfacePoint> surface_points(const Mesh& mesh);

// k_transfer coefficients a point: 1/pi times the integral over directions of visibility, cosine and harmonic. `object`
// is the scene of the points' mesh, whose longest side is about 1. Stops and returns nothing when go_on, called with
// the points done, returns false.
std::vector<float> trace_transfer(const std::vector<SurfacePoint>& points, const EmbreeScene& object, uint64_t seed,
                                  ThreadPool& pool, const std::function<bool(uint32_t)>& go_on);

// Takes away the points that see less than a fiftieth of what lies before them: those inside other parts of the object,
// such as the end of a leg in the seat. What is looked up between such a point and an open one would be dark.
void drop_buried(std::vector<SurfacePoint>* points, std::vector<float>* transfer);

// Points and coefficients in bytes, in the unit of the points' mesh.
struct SurfacePart {
  uint32_t vertices = 0;  // 0: there is none
  Vec3 low;
  double step = 0;
  std::vector<uint16_t> positions;
  std::vector<int8_t> normals;
  std::vector<float> steps;
  std::vector<int8_t> transfer;
};
SurfacePart round_surface(const std::vector<SurfacePoint>& points, const std::vector<float>& transfer);

}  // namespace sandglass::host
