// Meshes made by formula: closed, consistently oriented outwards, and the same to the bit on every machine (no libm),
// so that golden hashes may rest on them. All are centred at the origin; sizes in metres.
#pragma once

#include "models/host/mesh/mesh.h"

namespace sandglass::host {

// A tube of radius `tube` around the trefoil knot (sin t + 2 sin 2t, cos t - 2 cos 2t, -sin 3t)/3 * size: outer radius
// about size + tube. Its strands come as close as 0.405 size, axis to axis: a tube of more than half that crosses
// itself.
Mesh make_trefoil(float size, float tube, uint32_t along, uint32_t around);

// The project's demonstration knot: size 0.1, tube 0.018, 400 x 32.
Mesh make_trefoil();

// Around the y axis: ring radius `major`, tube radius `minor`. Vertices lie on the analytic torus.
Mesh make_torus(float major, float minor, uint32_t along, uint32_t around);

// Twelve triangles.
Mesh make_box(const float size[3]);

// An icosahedron, each triangle split into four `subdivisions` times, on the sphere of `radius`.
Mesh make_icosphere(float radius, uint32_t subdivisions);

// A chair: seat, four legs, two posts with three slats and a top rail, as separate closed boxes. Its feet stand on y =
// 0, unlike the others it is not centred.
Mesh make_chair();

// "trefoil", "torus", "box", "sphere" or "chair" in sizes of a hand; an error sentence for anything else.
MeshResult make_named(const std::string& name);

}  // namespace sandglass::host
