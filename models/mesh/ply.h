// Points as PLY files.
#pragma once

#include <string>
#include <vector>

namespace sandglass::host {

// Binary, little-endian, with float x, y, z: `points` holds 3 floats a point. Whole or not at all: else a Failure.
void write_points_ply(const std::string& path, const std::vector<float>& points);

}  // namespace sandglass::host
