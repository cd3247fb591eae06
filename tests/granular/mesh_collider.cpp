#include "tests/granular/mesh_collider.h"

#include <cstdlib>
#include <stdexcept>

#include "sandglass/field.h"

namespace {

using Block = std::unique_ptr<void, MeshCollider::Free>;

Block new_block(uint64_t bytes) {
  return Block(std::aligned_alloc(
      SANDGLASS_BLOCK_ALIGNMENT,
      (bytes + SANDGLASS_BLOCK_ALIGNMENT - 1) / SANDGLASS_BLOCK_ALIGNMENT * SANDGLASS_BLOCK_ALIGNMENT));
}

}  // namespace

void MeshCollider::Free::operator()(void* memory) const { std::free(memory); }

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
  const Block scratch = new_block(bytes);
  check(sandglass_mesh_inside_create(&view, SANDGLASS_INSIDE_PARITY, scratch.get(), bytes, &inside, &reason));
  check(sandglass_field_bytes(low, high, spacing, &bytes, &reason));
  block = new_block(bytes);
  check(sandglass_field_from_mesh(&view, sandglass_mesh_inside_test, inside, low, high, spacing, band, solid,
                                  block.get(), bytes, &field, &reason));
  collider.shape = SANDGLASS_SHAPE_FIELD;
  collider.field = field;
  collider.rotation[3] = 1.0f;
}
