// What is measured on a simulated pile: overlap between particles, angle of repose, run-out. In double, on plain
// arrays, with a neighbour search of its own.
#pragma once

#include <cstdint>
#include <span>

namespace sandglass::host {

// Overlap (2r - d)/r over the touching pairs (d < 2r) of one instant; all 0 when no pair touches.
struct Overlap {
  double p99 = 0.0, mean = 0.0, max = 0.0;
  uint64_t pairs = 0;
};
Overlap measure_overlap(std::span<const float> positions, double radius);

// The overlap over a run: P99 and mean are averages of the frames' values, max is the largest of the run.
struct OverlapOverRun {
  double p99_sum = 0.0, mean_sum = 0.0, max = 0.0;
  uint64_t frames = 0;
  void add(const Overlap& overlap);
  double p99() const { return frames == 0 ? 0.0 : p99_sum / static_cast<double>(frames); }
  double mean() const { return frames == 0 ? 0.0 : mean_sum / static_cast<double>(frames); }
};

// A pile on a horizontal floor at height 0. Axis: the mean x and z. Run-out: in each of 24 sectors about the axis the
// distance within which 98 % of the sector's particles lie, plus r; the mean over the sectors (so a few stray rollers
// do not count). Surface profile: in rings one diameter wide, the mean over the sectors of the highest particle top.
// Angle of repose: slope of the least-squares line through the profile between 20 % and 80 % of the run-out. Height:
// highest top.
struct Pile {
  double runout = 0.0;     // metres
  double height = 0.0;     // metres
  double angle_deg = 0.0;  // 0 when fewer than three rings are occupied
};
Pile measure_pile(std::span<const float> positions, double radius);

double speed_rms(std::span<const float> velocities);

// The value below which the fraction q of the values lies (nearest rank); 0 for none. Reorders the values.
double quantile(std::span<double> values, double q);

// The exponent of a power law: the least-squares slope of log y in log x.
double fitted_exponent(std::span<const double> x, std::span<const double> y);

}  // namespace sandglass::host
