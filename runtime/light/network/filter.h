// The temporal filter. Estimates come a few times a second, each with its error; the filter makes one light of them
// that moves as a light does. It does not jump, and a single estimate that contradicts the others changes nothing. The
// law is documented at sandglass_estimator_desc. Directions are in the world's frame, so the camera's turns are already
// gone. Only + - * / and square roots, in double: the same bits everywhere.
#pragma once

#include <cstdint>

namespace sandglass {

enum : uint32_t { k_sample_light = 0, k_sample_ambient = 3, k_sample_contrast = 6, k_sample_levels = 7 };

struct LightSample {
  double direction[3];  // unit vector
  double levels[k_sample_levels];
};

struct LightFilterLaw {
  double smoothing, interval;  // seconds
  double turn_limit;           // radians a second
  double outlier_angle, outlier_level;
};

struct LightFilter {
  LightFilterLaw law;
  LightSample state, outlier;
  double agreement;            // smoothed mean of the cosines between estimates and state
  uint64_t time_ns;            // of the last estimate
  uint32_t accepted;           // estimates that were taken: n of the law
  uint32_t outliers_in_a_row;  // the last of them is `outlier`
  uint32_t rejected;           // estimates that were not taken
};

void light_filter_reset(LightFilter* filter);

// Whether the state changed. Where time_ns is 0 or not after that of the last estimate, `interval` counts as passed.
bool light_filter_take(LightFilter* filter, const LightSample& sample, uint64_t time_ns);

// 0..1, as documented at sandglass_estimator_light.
double light_filter_confidence(const LightFilter& filter);

void light_filter_turn(LightFilter* filter, const double rotation[3][3]);

// The angle between two unit vectors. The unit vector at `angle` from `from` towards `to`, on their great circle; where
// they are opposite, on any great circle through both.
double angle_between(const double a[3], const double b[3]);
void turn_towards(const double from[3], const double to[3], double angle, double out[3]);

}  // namespace sandglass
