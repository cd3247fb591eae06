// A mesh as a collider of a test's scene: the steps that an app takes, from triangles to a signed-distance field.
#pragma once

#include <memory>

#include "models/mesh/mesh.h"
#include "sandglass/sandglass.h"

struct MeshCollider {
  // A field with nodes `spacing` metres apart, exact to `band` from the surface, over the mesh's bounds and a margin.
  MeshCollider(const sandglass::host::Mesh& mesh, sandglass_solid solid, float spacing, float band, float margin);
  MeshCollider(const sandglass::host::Mesh& mesh, sandglass_solid solid, float spacing)
      : MeshCollider(mesh, solid, spacing, 2 * spacing, 3 * spacing) {}

  struct Free {
    void operator()(void* memory) const;
  };
  float low[3], high[3];  // of the field
  std::unique_ptr<void, Free> block;
  sandglass_collider collider = {};
};
