// See arguments.h. The bounds and the area of a mesh are here too: they need no more than checked arguments.
#include "runtime/solid/sampling/arguments.h"

#include "runtime/math/math.h"
#include "runtime/solid/sampling/candidates.h"

namespace sandglass {

namespace {

bool is_coordinate(float x) { return within(x, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT); }

}  // namespace

sandglass_status check_mesh(const sandglass_mesh* mesh, const char** reason) {
  if (mesh == nullptr || mesh->vertices == nullptr || mesh->indices == nullptr)
    return refuse(reason, "the mesh, its vertices or its indices are NULL: pass all three.");
  if (mesh->triangle_count == 0 || mesh->vertex_count == 0)
    return refuse(reason, "the mesh has no triangles: check that it was loaded and triangulated.");
  if (mesh->triangle_count > k_triangle_limit)
    return refuse(reason, "the mesh has more than 2^27 triangles: simplify or split it.");
  if (!all_within(mesh->vertices, 3ull * mesh->vertex_count, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
    return refuse(
        reason, "a mesh vertex is not finite or beyond SANDGLASS_COORDINATE_LIMIT: repair, move or rescale the mesh.");
  for (uint64_t i = 0; i < 3ull * mesh->triangle_count; ++i)
    if (mesh->indices[i] >= mesh->vertex_count)
      return refuse(reason, "a mesh index is not below vertex_count: repair the mesh.");
  return accept(reason);
}

sandglass_status check_volume(const sandglass_sample_desc& desc, const char** reason) {
  for (int k = 0; k < 3; ++k)
    if (!is_coordinate(desc.bounds_min[k]) || !is_coordinate(desc.bounds_max[k]) ||
        desc.bounds_min[k] > desc.bounds_max[k])
      return refuse(reason,
                    "desc.bounds_min and desc.bounds_max are inverted, not finite or beyond "
                    "SANDGLASS_COORDINATE_LIMIT: see sandglass_mesh_bounds.");
  if (desc.inside == nullptr) return refuse(reason, "desc.inside is NULL: pass an inside test.");
  return accept(reason);
}

}  // namespace sandglass

extern "C" {

sandglass_status sandglass_mesh_bounds(const sandglass_mesh* mesh, float bounds_min[3], float bounds_max[3],
                                       const char** reason) {
  using namespace sandglass;
  if (const sandglass_status status = check_mesh(mesh, reason)) return status;
  if (bounds_min == nullptr || bounds_max == nullptr)
    return refuse(reason, "bounds_min or bounds_max is NULL: pass room for 3 floats each.");
  for (int k = 0; k < 3; ++k) {
    bounds_min[k] = SANDGLASS_COORDINATE_LIMIT;
    bounds_max[k] = -SANDGLASS_COORDINATE_LIMIT;
  }
  for (uint64_t i = 0; i < 3ull * mesh->triangle_count; ++i)
    for (int k = 0; k < 3; ++k) {
      const float x = mesh->vertices[3ull * mesh->indices[i] + k];
      if (x < bounds_min[k]) bounds_min[k] = x;
      if (x > bounds_max[k]) bounds_max[k] = x;
    }
  return accept(reason);
}

sandglass_status sandglass_mesh_area(const sandglass_mesh* mesh, double* area, const char** reason) {
  using namespace sandglass;
  if (const sandglass_status status = check_mesh(mesh, reason)) return status;
  if (area == nullptr) return refuse(reason, "area is NULL: pass room for a double.");
  *area = sum_areas(*mesh, nullptr);
  return accept(reason);
}

}  // extern "C"
