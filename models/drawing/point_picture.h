// Draws a point set as shaded balls in perspective under one light; near balls hide far ones.
#pragma once

#include <string>
#include <vector>

namespace sandglass::host {

// `points` holds 3 floats per point; `ball_radius` has the points' unit. Writes a PNG, whole or not at all. Returns an
// empty string, or one sentence on what went wrong.
std::string write_point_picture(const std::string& path, const std::vector<float>& points, float ball_radius, int width,
                                int height);

}  // namespace sandglass::host
