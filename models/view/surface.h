// The triangles that draw a collider.
#pragma once

#include <vector>

#include "models/mesh/mesh.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

// In the collider's local frame. `of_field` is the mesh that its field was made of; other shapes need none. Front faces
// look to where sand can be, so that a container shows its far wall. Empty for a half-space, because that has no end.
Mesh collider_mesh(const sandglass_collider& collider, const Mesh* of_field);

// Three vertices per triangle, and six floats per vertex: its position, and the unit normal of its triangle.
std::vector<float> flat_triangles(const Mesh& mesh);

}  // namespace sandglass::host
