// Power spectrum of a set of points, (3.1), by direct summation: exact at any frequency, and fast enough for the sizes
// that tests and tools look at.
#include "runtime/core/math.h"
#include "runtime/sampling/arguments.h"

namespace sandglass {
namespace {

constexpr double k_cycle_limit = 1e9;  // beyond this a double has too few digits left for the phase

double power_at(const float* points, uint32_t count, const double frequency[3]) {
  double real = 0, imaginary = 0;
  for (uint64_t i = 0; i < count; ++i) {
    double cycles = 0;
    for (int k = 0; k < 3; ++k) cycles += frequency[k] * static_cast<double>(points[3 * i + k]);
    const SinCos wave = sin_cos_turns(cycles);
    real += wave.cos;
    imaginary -= wave.sin;
  }
  return (real * real + imaginary * imaginary) / count;
}

// Refuses frequencies that are too high for these points, by |v . x| <= |v| |x|, and points that are not finite.
sandglass_status check_points(const float* points, uint32_t count, double frequency, const char** reason) {
  if (points == nullptr || count == 0) return refuse(reason, "points is NULL or count is 0: a spectrum needs points");
  for (uint64_t i = 0; i < count; ++i) {
    double squared = 0;
    for (int k = 0; k < 3; ++k)
      squared += static_cast<double>(points[3 * i + k]) * static_cast<double>(points[3 * i + k]);
    if (!(square_root(squared) * frequency <= k_cycle_limit))
      return refuse(reason, "a point or the frequency is not finite, or their product above 1e9 cycles: rescale");
  }
  return accept(reason);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

extern "C" {

sandglass_status sandglass_sample_power(const float* points, uint32_t count, const float frequency[3], double* power,
                                        const char** reason) {
  if (frequency == nullptr || power == nullptr)
    return refuse(reason, "frequency or power is NULL: pass 3 floats and room for a double");
  const double v[3] = {static_cast<double>(frequency[0]), static_cast<double>(frequency[1]),
                       static_cast<double>(frequency[2])};
  const double magnitude = square_root(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (const sandglass_status status = check_points(points, count, magnitude, reason)) return status;
  *power = power_at(points, count, v);
  return accept(reason);
}

sandglass_status sandglass_sample_spectrum(const float* points, uint32_t count, float frequency_max, uint32_t bins,
                                           uint32_t directions, int32_t planar, double* power, const char** reason) {
  if (power == nullptr) return refuse(reason, "power is NULL: pass room for `bins` doubles");
  if (bins == 0 || bins > 65536 || directions == 0 || directions > 65536)
    return refuse(reason, "bins or directions is not in 1..65536: 64 of each are plenty");
  if (!(frequency_max > 0))
    return refuse(reason, "frequency_max is not above 0: give cycles per metre, twice 1/distance say");
  const double highest = static_cast<double>(frequency_max);
  if (const sandglass_status status = check_points(points, count, highest, reason)) return status;
  for (uint32_t b = 0; b < bins; ++b) {
    const double magnitude = (b + 0.5) / bins * highest;
    double sum = 0;
    for (uint32_t n = 0; n < directions; ++n) {
      // The spectrum is symmetric: half a circle, or half a sphere in the manner of (3.8), holds all of it.
      const double height = planar != 0 ? 0 : (n + 0.5) / directions, ring = square_root(1 - height * height);
      const SinCos azimuth = sin_cos_turns(planar != 0 ? 0.5 * (n + 0.5) / directions : 0.38196601125010515 * n);
      const double v[3] = {magnitude * ring * azimuth.cos, magnitude * height, magnitude * ring * azimuth.sin};
      sum += power_at(points, count, v);
    }
    power[b] = sum / directions;
  }
  return accept(reason);
}

}  // extern "C"
