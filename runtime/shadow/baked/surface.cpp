// How an object's own surface sees a room: the baked coefficients of its vertices.
#include "platform/floating_point.h"
#include "runtime/asset/shadow_asset.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/math.h"
#include "sandglass/shadow.h"

namespace sandglass {
namespace {

// How far a point of the surface is from a vertex, in squared steps of its positions. A point that faces elsewhere
// counts as farther: one on the back of a thin board is nearer than the next one on the front, and sees another room.
// Points of one crease have one place, and `k_distance_offset` lets the normals decide there.
constexpr double k_normal_weight = 4, k_distance_offset = 4;

struct Vertex {
  double position[3];  // in steps
  double normal[3];    // all 0: unknown
};

double distance_of(const SurfaceAsset& surface, uint32_t point, const Vertex& vertex) {
  double squared = 0, cosine = 0;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const double difference = vertex.position[axis] - surface.positions[3 * point + axis];
    squared += difference * difference;
    cosine += vertex.normal[axis] * surface.normals[3 * point + axis] / 127;
  }
  return (squared + k_distance_offset) * (1 + k_normal_weight * (cosine < 1 ? 1 - cosine : 0));  // bytes round normals
}

// Points are in order of x. So the search begins at the vertex's own x, and ends where the points beyond differ by more
// in x alone than the nearest one so far.
uint32_t nearest_point(const SurfaceAsset& surface, const Vertex& vertex) {
  const double x = vertex.position[0];
  uint32_t low = 0, high = surface.vertices;
  while (low < high) {
    const uint32_t middle = low + (high - low) / 2;
    if (surface.positions[3 * middle] < x) low = middle + 1;
    else high = middle;
  }
  uint32_t nearest = low < surface.vertices ? low : surface.vertices - 1;
  double smallest = distance_of(surface, nearest, vertex);
  const auto look_at = [&](uint32_t point) {
    const double difference = x - surface.positions[3 * point];
    if (difference * difference > smallest) return false;
    const double distance = distance_of(surface, point, vertex);
    if (distance < smallest) {
      smallest = distance;
      nearest = point;
    }
    return true;
  };
  for (uint32_t i = low; i < surface.vertices && look_at(i); ++i) {
  }
  for (uint32_t i = low; i > 0 && look_at(i - 1); --i) {
  }
  return nearest;
}

__attribute__((noinline)) void look_up_surface(const SurfaceAsset& surface, const float* positions,
                                               const float* normals, uint32_t count, float* transfer) {
  for (uint32_t i = 0; i < count; ++i) {
    Vertex vertex = {};
    double squared = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const double offset = static_cast<double>(positions[3 * i + axis]) - static_cast<double>(surface.low[axis]);
      vertex.position[axis] = offset / static_cast<double>(surface.step);
      if (normals != nullptr) vertex.normal[axis] = static_cast<double>(normals[3 * i + axis]);
      squared += vertex.normal[axis] * vertex.normal[axis];
    }
    if (squared > 0)
      for (double& x : vertex.normal) x /= square_root(squared);
    const uint32_t point = nearest_point(surface, vertex);
    for (uint32_t j = 0; j < k_surface_coefficients; ++j)
      transfer[uint64_t{k_surface_coefficients} * i + j] =
          surface.steps[j] * static_cast<float>(surface.transfer[uint64_t{k_surface_coefficients} * point + j]);
  }
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

sandglass_status sandglass_shadow_transfer(const void* bytes, uint64_t size, const float* positions,
                                           const float* normals, uint32_t count, float* transfer, const char** reason) {
  if (count != 0 && (positions == nullptr || transfer == nullptr))
    return refuse(reason, "positions or transfer is NULL: pass 3 floats a vertex, and room for 9 a vertex.");
  if (!all_finite(positions, uint64_t{3} * count) || (normals != nullptr && !all_finite(normals, uint64_t{3} * count)))
    return refuse(reason, "a position or a normal is not finite.");
  ShadowAsset asset;
  if (const sandglass_status status = open_shadow_asset(bytes, size, &asset, reason)) return status;
  if (asset.surface.vertices == 0)
    return refuse(reason, "the shadow file says nothing of the object's surface: bake it again.");
  const ExactFloatingPoint exact;
  look_up_surface(asset.surface, positions, normals, count, transfer);
  return accept(reason);
}
