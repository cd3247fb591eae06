// A picture of a point set: shaded balls in perspective under one light, nearest in front.
#pragma once

#include <string>
#include <vector>

namespace sandglass::host {

// 3 floats a point; `ball_radius` in the points' unit. Writes a PNG, whole or not at all. An empty string, or one
// sentence on what went wrong.
std::string write_point_picture(const std::string& path, const std::vector<float>& points, float ball_radius, int width,
                                int height);

}  // namespace sandglass::host
