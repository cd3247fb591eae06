// A mesh as a collider of a test's scene: the steps that an app takes, from triangles to a signed-distance field.
#pragma once

#include "models/mesh/mesh.h"
#include "sandglass/sandglass.hpp"

struct MeshCollider {
  // A field with nodes `spacing` metres apart, exact to `band` from the surface, over the mesh's bounds and a margin.
  MeshCollider(const sandglass::host::Mesh& mesh, sandglass_solid solid, float spacing, float band, float margin);
  MeshCollider(const sandglass::host::Mesh& mesh, sandglass_solid solid, float spacing)
      : MeshCollider(mesh, solid, spacing, 2 * spacing, 3 * spacing) {}

  float low[3], high[3];  // of the field
  sandglass::cpp::Block block;
  sandglass_collider collider = {};
};
