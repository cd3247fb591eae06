// Meshes made by formula: closed, consistently oriented outwards, and the same to the bit on every machine (no libm),
// so that golden hashes may rest on them. Sizes in metres. All are centred at the origin, except for the chair and the
// surfaces of revolution, which stand on y = 0.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "models/mesh/mesh.h"

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

// A chair of separate closed boxes: seat, four legs, two posts with three slats and a top rail, three stretchers.
Mesh make_chair();

// A closed outline in the half plane (r, y), r >= 0, counter-clockwise with r to the right and y up.
using Profile = std::vector<std::array<double, 2>>;

// The outline turned about the y axis in `around` planes. Its corners lie on the turned surface, so the mesh encloses
// sin(a)/a of the surface's volume, a = 2 pi/around. An edge on the axis (r = 0 at both ends) has no triangles.
Mesh make_revolved(const Profile& profile, uint32_t around);

// The inner wall of an hourglass: two bulbs of radius `bulb`, flat at both ends with rounded corners, joined by a neck
// of radius `neck` half way up. A half cosine leads from neck to bulb, as steep as (bulb - neck) pi/(3/4 height) at
// most. `steps` corners a curve.
Profile hourglass_profile(double height, double bulb, double neck, uint32_t steps);

// The radius of that wall at a height, 0 below and above.
double hourglass_radius(double height, double bulb, double neck, double y);

// A shell, open at the top: outer radii at the ground and at the top, a wall `thickness` thick (measured along r; the
// bottom along y) and a rim that stands out by as much.
Profile bucket_profile(double height, double bottom, double top, double thickness);

// A shell, open at both ends: a cylinder of inner radius `radius` above a cone of height `cone` that narrows to an
// outlet of inner radius `outlet` at y = 0. `thickness` is measured along r.
Profile silo_profile(double height, double radius, double cone, double outlet, double thickness);

// The names that make_named knows.
const std::vector<std::string>& mesh_names();

// A generated mesh in the size of a hand; an error sentence for any other name.
MeshResult make_named(const std::string& name);

}  // namespace sandglass::host
