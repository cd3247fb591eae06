// Writes points and meshes as PLY or OBJ files, whole or not at all. Each function returns an empty string, or one
// sentence on what went wrong.
#pragma once

#include <string>
#include <vector>

#include "models/mesh/mesh.h"

namespace sandglass::host {

// Binary little-endian PLY with float x, y, z. `points` holds 3 floats per point.
std::string write_points_ply(const std::string& path, const std::vector<float>& points);
// The same with a face list.
std::string write_mesh_ply(const std::string& path, const Mesh& mesh);
// Wavefront OBJ with nine significant digits, so that a reader gets every float back exactly.
std::string write_mesh_obj(const std::string& path, const Mesh& mesh);

}  // namespace sandglass::host
