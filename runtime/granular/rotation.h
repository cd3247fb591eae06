// The rotation nearest to a matrix, for shape matching (4.31).
#pragma once

namespace sandglass {

// The proper rotation R that maximises tr(R^T A), as a unit quaternion (x, y, z, w). A is row-major; reflections, flat
// and straight bodies and half turns are allowed. Where several rotations are equally good, as for a straight body or a
// mirrored cube, it is the one nearest to `near`, a unit quaternion. It is `near` itself where an entry is not finite
// or beyond 1e300, and where all are below 1e-300.
void nearest_rotation(const double a[9], const double near[4], double q[4]);

}  // namespace sandglass
