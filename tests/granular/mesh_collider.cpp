#include "tests/granular/mesh_collider.h"

#include <stdexcept>

#include "sandglass/field.h"

MeshCollider::MeshCollider(const sandglass::host::Mesh& mesh, sandglass_solid solid, float spacing, float band,
                           float margin) {
  const sandglass_mesh view = {mesh.vertices.data(), mesh.vertex_count(), mesh.indices.data(), mesh.triangle_count()};
  const char* reason = nullptr;
  const auto check = [&](sandglass_status status) {
    if (status != SANDGLASS_OK) throw std::invalid_argument(reason);
  };
  uint64_t bytes = 0;
  sandglass_mesh_inside* inside = nullptr;
  sandglass_field* field = nullptr;
  check(sandglass_mesh_bounds(&view, low, high, &reason));
  for (int k = 0; k < 3; ++k) low[k] -= margin, high[k] += margin;
  check(sandglass_mesh_inside_bytes(&view, SANDGLASS_INSIDE_PARITY, &bytes, &reason));
  const sandglass::cpp::Block scratch = sandglass::cpp::allocate_block(bytes);
  check(sandglass_mesh_inside_create(&view, SANDGLASS_INSIDE_PARITY, scratch.get(), bytes, &inside, &reason));
  check(sandglass_field_bytes(low, high, spacing, &bytes, &reason));
  block = sandglass::cpp::allocate_block(bytes);
  check(sandglass_field_from_mesh(&view, sandglass_mesh_inside_test, inside, low, high, spacing, band, solid,
                                  block.get(), bytes, &field, &reason));
  collider.shape = SANDGLASS_SHAPE_FIELD;
  collider.field = field;
  collider.rotation[3] = 1.0f;
}
