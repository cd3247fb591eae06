// The rotation nearest to a matrix, for shape matching (4.31).
#pragma once

namespace sandglass {

// The proper rotation R that maximises tr(R^T A), as a unit quaternion (x, y, z, w), for any finite A (row-major):
// reflections, flat, straight and empty bodies and half turns included, at any scale. Where several are equally good
// (A of rank below 2) it is the one nearest to `near`, a unit quaternion.
void nearest_rotation(const double a[9], const double near[4], double q[4]);

}  // namespace sandglass
