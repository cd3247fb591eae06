// A mesh as a collider of a test's scene: the steps that an app takes, from triangles to a signed-distance field.
#pragma once

#include "models/mesh/mesh.h"
#include "tests/sand/granular_scene.h"

struct MeshCollider {
  // A field with nodes `spacing` metres apart, exact to `band` from the surface, over the mesh's bounds and a margin.
  MeshCollider(const sandglass::host::Mesh& mesh, sandglass_solid solid, float spacing, float band, float margin) {
    const sandglass_mesh view = mesh.view();
    sandglass::Status bounds;
    bounds.code = sandglass_mesh_bounds(&view, box.min, box.max, &bounds.reason);
    accept(bounds);
    for (int k = 0; k < 3; ++k) {
      box.min[k] -= margin;
      box.max[k] += margin;
    }
    sandglass::MeshInside inside;
    accept(inside.create(view));
    accept(field.from_mesh(view, inside, box, spacing, band, solid));
    collider = sandglass::field_at(field, 0.0f, 0.0f, 0.0f);
  }
  MeshCollider(const sandglass::host::Mesh& mesh, sandglass_solid solid, float spacing)
      : MeshCollider(mesh, solid, spacing, 2 * spacing, 3 * spacing) {}

  sandglass::Box box;
  sandglass::Field field;
  sandglass_collider collider;
};
