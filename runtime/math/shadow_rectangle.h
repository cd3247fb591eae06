// The rectangle of the receiving plane that a shadow texture covers, in closed form from the object's bounding box.
//
// FITTED follows the light: the smallest axis-aligned rectangle that holds the footprint and every point where a ray of
// the light, through any point of the box, meets the plane. A light of half angle a around the direction d is a cone;
// seen from the top of the box it cuts the plane in an ellipse, and the tangent planes of the cone give the ellipse's
// extent along x: the roots p of (d_x - p d_y)^2 = sin(a)^2 (1 + p^2). FIXED is the dissertation's square (6.11), the
// same for every light up to a polar angle. The network sees coordinates normalised to the kind of rectangle that was
// baked.
//
// The object's frame: the plane is y = 0, the footprint's centre is the origin, the object lies at y >= 0.
#pragma once

#include <cstdint>

#include "runtime/math/math.h"

namespace sandglass {

struct ShadowBox {
  double half_x, half_z;  // of the footprint, metres
  double height;          // above the plane
};

struct ShadowRectangle {
  double low_x, low_z, high_x, high_z;
};

enum class PlaneRule : uint8_t { fitted, fixed };

// The smallest and largest slope p = r_x / r_y of the light's rays r. `d` is the light's component along the axis, `up`
// its vertical one. up > sine, so that no ray of the light comes from below the horizon.
struct SlopeRange {
  double low, high;
};
inline SlopeRange slope_range(double d, double up, double sine) {
  const double spread = sine * square_root(d * d + up * up - sine * sine), scale = 1 / (up * up - sine * sine);
  return {(d * up - spread) * scale, (d * up + spread) * scale};
}

// `light` is a unit vector towards the light with polar angle at most polar_max; polar_max + half the angular diameter
// is below 90 degrees. The sine and the tangent are handed in, because no elementary function is computed here.
// `half_sine` = sin(half the angular diameter), `reach` = tan(polar_max + half the angular diameter), used by FIXED.
inline ShadowRectangle shadow_rectangle(const ShadowBox& box, PlaneRule rule, const double light[3], double half_sine,
                                        double reach) {
  if (rule == PlaneRule::fixed) {
    const double widest = box.half_x > box.half_z ? box.half_x : box.half_z, half = widest + reach * box.height;
    return {-half, -half, half, half};
  }
  const SlopeRange x = slope_range(light[0], light[1], half_sine), z = slope_range(light[2], light[1], half_sine);
  // A point at height y casts its shadow at -p y: the far corners are those of the top, the near ones of the footprint.
  return {-box.half_x - (x.high > 0 ? x.high * box.height : 0), -box.half_z - (z.high > 0 ? z.high * box.height : 0),
          box.half_x - (x.low < 0 ? x.low * box.height : 0), box.half_z - (z.low < 0 ? z.low * box.height : 0)};
}

// The centre of texel `index` of `size`, in -1..1.
inline double texel_centre(uint32_t index, uint32_t size) { return (2.0 * index + 1.0) / size - 1.0; }

}  // namespace sandglass
