// Measures a simulated pile: overlap between particles, angle of repose, run-out, how evenly grains lie. It computes in double on plain arrays
// and has its own neighbour search, so it does not rely on the library that it measures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace sandglass::host {

// The overlap (2r - d)/r over all touching pairs (d < 2r) at one instant. All values are 0 when no pair touches.
struct Overlap {
  double p99 = 0.0, mean = 0.0, max = 0.0;
  uint64_t pairs = 0;
};
Overlap measure_overlap(std::span<const float> positions, double radius);

// The overlap over a run. P99 and mean are averages over the frames; max is the largest value of the run.
struct OverlapOverRun {
  double p99_sum = 0.0, mean_sum = 0.0, max = 0.0;
  uint64_t frames = 0;
  void add(const Overlap& overlap);
  double p99() const { return frames == 0 ? 0.0 : p99_sum / static_cast<double>(frames); }
  double mean() const { return frames == 0 ? 0.0 : mean_sum / static_cast<double>(frames); }
};

// A pile on a horizontal floor at height 0. Its axis goes through the mean x and z.
//   Run-out: 24 sectors surround the axis. Each has a distance within which 98 % of its particles lie, plus r. The
//   run-out is the mean over the sectors that hold particles. So a few stray particles do not count.
//   Surface profile: in rings one diameter wide, the mean over the sectors of the highest particle top.
//   Angle of repose: the slope of the least-squares line through the profile, between 20 % and 80 % of the run-out.
//   Height: the highest particle top.
struct Pile {
  double runout = 0.0;     // metres
  double height = 0.0;     // metres
  double angle_deg = 0.0;  // 0 when the line has fewer than three rings
};
Pile measure_pile(std::span<const float> positions, double radius);

// How evenly grains lie inside a pile.
//   Variation: of the number of grains in spheres of 0.7 r, over that of random points, whose variance is their mean. The
//   spheres are at random places with particles on all sides within 3 r.
//   Nearest: the median distance of a grain's nearest neighbour, in grain radii. One that is 0.7 r away counts as that.
struct Evenness {
  double variation = 0.0, nearest = 0.0;
  uint32_t spheres = 0;  // 2000 where the pile has so much of an inside; with fewer than 200 both numbers are 0
};
Evenness measure_evenness(std::span<const float> particles, std::span<const float> grains, double radius,
                          double grain_radius, uint64_t seed);

// The root mean square of the speeds; 3 floats per particle.
double speed_rms(std::span<const float> velocities);

// The q-quantile of the values by nearest rank; 0 without values. Reorders the values.
double quantile(std::span<double> values, double q);

// Whether so many values say where an upper quantile is: at least ten lie beyond it. P95 needs 200 values, P99 1000,
// P99.9 10,000. Of fewer it is one of the largest values, or the largest itself, and must be called that.
bool tells_quantile(size_t count, double q);

// The exponent of a power law: the least-squares slope of log y over log x.
double fitted_exponent(std::span<const double> x, std::span<const double> y);

}  // namespace sandglass::host
