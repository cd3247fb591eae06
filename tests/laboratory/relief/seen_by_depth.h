// What a receiver by depth (models/kit/depth.glsl, here in double) shows wrongly of a table that depth images see: a virtual
// board's shadow, and virtual points that real things hide.
#pragma once

#include <array>

#include "tests/laboratory/relief/depth_table.h"

namespace sandglass::host {

// By what a place is known: the plane, as by a floor's texture; depth, else the plane; the same times the relief's factor; that,
// else the relief's heights; these alone.
enum class KnownBy { floor, depth, scaled, scaled_or_heights, heights };
constexpr size_t k_known_by = 5;

// Of 100, on average of a recording's images.
struct SeenWrongly {
  double shade = 0;  // of the pixels in shade, or in the floor's: those off by more than a quarter of the light
  double seen = 0, hidden = 0;  // of the points that are hidden: those that are seen; and the other way
};
std::array<SeenWrongly, k_known_by> seen_by_depth(const DepthRecording& recording, uint64_t seed);

}  // namespace sandglass::host
