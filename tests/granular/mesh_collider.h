// A mesh as a collider of a test's scene: the steps that an app takes, from triangles to a signed-distance field.
#pragma once

#include <memory>

#include "models/host/mesh/mesh.h"
#include "sandglass/sandglass.h"

struct MeshCollider {
  // A field with nodes `spacing` metres apart, exact to twice that from the surface, and a margin of three.
  MeshCollider(const sandglass::host::Mesh& mesh, sandglass_solid solid, float spacing);

  struct Free {
    void operator()(void* memory) const;
  };
  std::unique_ptr<void, Free> block;
  sandglass_collider collider = {};
};
