// Disk, sphere and ring: points on a Fermat spiral, turned by the golden angle from one to the next.
//
// With s = (i - 1/2)/N the sphere's (3.8), cos theta = (N+1-2i)/N, reads cos theta = 1 - 2s, or sin(theta/2)^2 = s. So
// no arccos is needed, nothing cancels near the poles, and the ring's range of indices (3.10) becomes sin^2(theta_a/2)
// <= s <= sin^2(theta_b/2).
#include "runtime/math/math.h"
#include "runtime/solid/sampling/arguments.h"

namespace sandglass {
namespace {

// Phi = 2 pi (1 - 1/golden ratio), (3.2), as a fraction of a turn times 2^64. Multiplication modulo 2^64 drops whole
// turns exactly, so the azimuth of the billionth point is as exact as that of the first.
constexpr uint64_t k_golden_turn = 0x61C8864680B583EAull;

// Most points of a whole sphere. Below this, index times sine keeps eleven bits behind the binary point.
constexpr double k_sphere_limit = 0x1p40;

double golden_turns(uint64_t i) { return static_cast<double>((i * k_golden_turn) >> 11) * 0x1p-53; }

void place_on_sphere(double radius, uint64_t i, double sphere_count, float* point) {
  const double s = (static_cast<double>(i) - 0.5) / sphere_count;
  const double sine = 2 * square_root(s * (1 - s));
  const SinCos azimuth = sin_cos_turns(golden_turns(i));
  point[0] = static_cast<float>(radius * sine * azimuth.cos);
  point[1] = static_cast<float>(radius * (1 - 2 * s));
  point[2] = static_cast<float>(radius * sine * azimuth.sin);
}

sandglass_status check_shape(float radius, uint32_t count, const float* points, const char** reason) {
  if (!is_finite(radius) || !(radius > 0))
    return refuse(reason, "radius is not a finite number above 0: give it in metres.");
  if (count == 0 || count > k_point_limit)
    return refuse(reason, "count is not in 1..2^30: ask for at least one point.");
  if (points == nullptr) return refuse(reason, "points is NULL: pass room for 3*count floats.");
  return accept(reason);
}

double half_angle_sine_squared(float theta) {
  if (static_cast<double>(theta) >= k_pi) return 1;
  const double s = sin_cos_turns(static_cast<double>(theta) / (4 * k_pi)).sin;
  return s * s;
}

struct IndexRange {
  int64_t first, last;
};

// The points i of a sphere of `sphere_count` points that lie in the ring, (3.10).
IndexRange ring_indices(int64_t sphere_count, double low, double high) {
  const double n = static_cast<double>(sphere_count);
  return {ceiling_index(n * low + 0.5), floor_index(n * high + 0.5)};
}

// From N to N+1 both ends of the range move by 0 or 1. So the number of points kept changes by at most 1, and it takes
// every value from 0 up: a sphere that keeps exactly `wanted` points exists, within two points' worth of (3.11).
int64_t ring_sphere_count(uint32_t wanted, double low, double high) {
  const int64_t start = ceiling_index(static_cast<double>(wanted) / (high - low));
  for (int64_t step = 0;; step = step > 0 ? -step : 1 - step) {  // 0, 1, -1, 2, -2, ...
    const int64_t n = start + step;
    if (n < 1) continue;
    const IndexRange range = ring_indices(n, low, high);
    if (range.last - range.first + 1 == wanted) return n;
  }
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

extern "C" {

sandglass_status sandglass_sample_disk(float radius, float* points, uint32_t count, const char** reason) {
  if (const sandglass_status status = check_shape(radius, count, points, reason)) return status;
  for (uint32_t i = 1; i <= count; ++i) {
    const double r = static_cast<double>(radius) * square_root((i - 0.5) / (count - 0.5));
    const SinCos azimuth = sin_cos_turns(golden_turns(i));
    float* point = points + 3ull * (i - 1);
    point[0] = static_cast<float>(r * azimuth.cos);
    point[1] = 0;
    point[2] = static_cast<float>(r * azimuth.sin);
  }
  return accept(reason);
}

sandglass_status sandglass_sample_sphere(float radius, float* points, uint32_t count, const char** reason) {
  if (const sandglass_status status = check_shape(radius, count, points, reason)) return status;
  for (uint32_t i = 1; i <= count; ++i)
    place_on_sphere(static_cast<double>(radius), i, static_cast<double>(count), points + 3ull * (i - 1));
  return accept(reason);
}

sandglass_status sandglass_sample_ring(float radius, float theta_a, float theta_b, float* points, uint32_t count,
                                       const char** reason) {
  if (const sandglass_status status = check_shape(radius, count, points, reason)) return status;
  if (!(theta_a >= 0 && theta_a < theta_b && theta_b <= static_cast<float>(k_pi)))
    return refuse(reason, "the ring is not 0 <= theta_a < theta_b <= pi: give polar angles in radians.");
  const double low = half_angle_sine_squared(theta_a), high = half_angle_sine_squared(theta_b);
  if (!(count / (high - low) <= k_sphere_limit))
    return refuse(reason,
                  "the ring is too thin for that many points (2^40 on the whole sphere): widen theta_a..theta_b.");
  const int64_t sphere_count = ring_sphere_count(count, low, high);
  const IndexRange range = ring_indices(sphere_count, low, high);
  for (int64_t i = range.first; i <= range.last; ++i)
    place_on_sphere(static_cast<double>(radius), static_cast<uint64_t>(i), static_cast<double>(sphere_count),
                    points + 3 * (i - range.first));
  return accept(reason);
}

}  // extern "C"
