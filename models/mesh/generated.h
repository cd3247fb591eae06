// Meshes made by formula. They are closed and oriented outwards. They have the same bits on every machine (no libm), so
// golden hashes may depend on them. Sizes are in metres. All are centred at the origin, except the chair and the
// surfaces of revolution, which stand on y = 0.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "models/mesh/mesh.h"

namespace sandglass::host {

// A tube of radius `tube` around the trefoil knot (sin t + 2 sin 2t, cos t - 2 cos 2t, -sin 3t)/3 * size. The outer
// radius is about size + tube. The axes of its strands come as close as 0.405 size, so a tube of more than half that
// crosses itself.
Mesh make_trefoil(float size, float tube, uint32_t along, uint32_t around);

// The project's demonstration knot: size 0.1, tube 0.018, 400 x 32.
Mesh make_trefoil();

// A torus around the y axis with ring radius `major` and tube radius `minor`. Its vertices lie on the exact torus.
Mesh make_torus(float major, float minor, uint32_t along, uint32_t around);

// A box of twelve triangles. `size` holds its full edge lengths.
Mesh make_box(const float size[3]);

// An icosahedron whose triangles are split into four, `subdivisions` times. All vertices lie on the sphere of `radius`.
Mesh make_icosphere(float radius, uint32_t subdivisions);

// A chair of separate closed boxes: seat, four legs, two posts with three slats and a top rail, three stretchers.
Mesh make_chair();

// A closed outline in the half plane (r, y), r >= 0, counter-clockwise with r to the right and y up.
using Profile = std::vector<std::array<double, 2>>;

// The outline turned about the y axis, with corners in `around` half planes. The corners lie on the turned surface, so
// the mesh encloses sin(a)/a of the surface's volume, with a = 2 pi/around. An edge on the axis (r = 0 at both ends)
// has no triangles.
Mesh make_revolved(const Profile& profile, uint32_t around);

// The inner wall of an hourglass: two bulbs of radius `bulb`, flat at both ends with rounded corners, joined by a neck
// of radius `neck` half way up. A half cosine leads from neck to bulb. Its steepest slope dr/dy is
// (bulb - neck) pi/(3/4 height). Each curve has `steps` pieces.
Profile hourglass_profile(double height, double bulb, double neck, uint32_t steps);

// The radius of that wall at the height y; 0 below and above the hourglass.
double hourglass_radius(double height, double bulb, double neck, double y);

// A shell that is open at the top. `bottom` and `top` are the outer radii at the ground and at the top. The wall's
// `thickness` is measured along r, the bottom's along y. A rim stands out by the same thickness.
Profile bucket_profile(double height, double bottom, double top, double thickness);

// A shell that is open at both ends: a cylinder of inner radius `radius` above a cone of height `cone` that narrows to
// an outlet of inner radius `outlet` at y = 0. `thickness` is measured along r.
Profile silo_profile(double height, double radius, double cone, double outlet, double thickness);

// The names that make_named knows.
const std::vector<std::string>& mesh_names();

// A generated mesh of 0.1 to 0.3 m; the chair has the size of a chair. Any other name gives an error sentence.
MeshResult make_named(const std::string& name);

// That, or the mesh of a file. A Failure says what cannot be read.
MeshResult named_mesh(const MeshFile& name_or_file);

}  // namespace sandglass::host
