// Triangles in arrays of the app, as engines have them: what is wrong with them, and where their corners are.
#pragma once

#include "runtime/math/finite.h"
#include "sandglass/cast.h"

namespace sandglass {

constexpr float k_mesh_far = 1e6f;  // metres; what is there is nowhere

// What is wrong with a mesh, or null. Its arrays are not looked into.
inline const char* mesh_fault(const sandglass_cast_mesh& mesh) {
  if (mesh.triangle_count == 0) return nullptr;
  if (mesh.positions == nullptr) return "a mesh's positions are NULL, but it has triangles.";
  if (mesh.stride < 12 || mesh.stride % 4 != 0)
    return "a mesh's stride is not a multiple of 4, at least 12: start from sandglass_cast_mesh_default.";
  if (mesh.index_bytes != 2 && mesh.index_bytes != 4)
    return "a mesh's index_bytes is neither 2 nor 4: start from sandglass_cast_mesh_default.";
  if (mesh.closed > 1 || mesh.is_real > 1) return "a mesh's closed or is_real is neither 0 nor 1.";
  for (uint32_t column = 0; column < 4; ++column)
    if (!all_within(mesh.world_from_mesh + 4 * column, 3, -k_mesh_far, k_mesh_far))
      return "a mesh's world_from_mesh is not finite, or beyond 1000 km.";
  return nullptr;
}

inline bool same_arrays(const sandglass_cast_mesh& a, const sandglass_cast_mesh& b) {
  return a.positions == b.positions && a.stride == b.stride && a.vertex_count == b.vertex_count &&
         a.indices == b.indices && a.index_bytes == b.index_bytes && a.triangle_count == b.triangle_count;
}

// Corner `i` of all: its place, or null where there is no such vertex.
inline const float* mesh_corner(const sandglass_cast_mesh& mesh, uint64_t i) {
  uint32_t vertex = static_cast<uint32_t>(i);
  if (mesh.indices != nullptr)
    vertex = mesh.index_bytes == 2 ? static_cast<const uint16_t*>(mesh.indices)[i]
                                   : static_cast<const uint32_t*>(mesh.indices)[i];
  return vertex < mesh.vertex_count ? mesh.positions + uint64_t{vertex} * (mesh.stride / sizeof(float)) : nullptr;
}

// From a mesh's frame into one with these axes and this origin, all of the world: three rows of four.
inline void place_mesh(const double axes[3][3], const double origin[3], const float world_from_mesh[16],
                       double rows[12]) {
  for (uint32_t axis = 0; axis < 3; ++axis)
    for (uint32_t column = 0; column < 4; ++column) {
      double sum = 0;
      for (uint32_t k = 0; k < 3; ++k) {
        const double entry = static_cast<double>(world_from_mesh[4 * column + k]);
        sum += axes[axis][k] * (column == 3 ? entry - origin[k] : entry);
      }
      rows[4 * axis + column] = sum;
    }
}

}  // namespace sandglass
