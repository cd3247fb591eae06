// The temporal filter against the law that the header states: its step response in numbers, what it rejects, and what
// it accepts.
#include "runtime/light/network/filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "sandglass/estimator.h"

namespace sandglass {
namespace {

constexpr double k_degree = std::numbers::pi / 180.0;
constexpr uint64_t k_period_ns = 250'000'000;

// A light in the x-y plane at an angle of `degrees` from the x axis.
LightSample at(double degrees, double level = 0.5) {
  LightSample s = {{std::cos(degrees * k_degree), std::sin(degrees * k_degree), 0.0}, {}};
  for (double& x : s.levels) x = level;
  return s;
}

// A filter with the default law, and the time of its last estimate.
struct Filter : LightFilter {
  Filter() : LightFilter{} {
    sandglass_estimator_desc desc;
    sandglass_estimator_desc_default(&desc);
    law = {desc.smoothing, desc.interval, desc.turn_limit, desc.outlier_angle, desc.outlier_level};
    light_filter_reset(this);
  }
  // An estimate one period later, or so many of them.
  bool take(const LightSample& sample) { return light_filter_take(this, sample, time_ns += k_period_ns); }
  void settle(double degrees) {
    for (int i = 0; i < 8; ++i) take(at(degrees));
  }
  double azimuth() const { return std::atan2(state.direction[1], state.direction[0]) / k_degree; }
  uint64_t time_ns = 0;
};

TEST(LightFilter, TheFirstEstimateIsTakenWhole) {
  Filter f;
  EXPECT_TRUE(light_filter_take(&f, at(37.0, 0.25), 1));
  EXPECT_NEAR(f.azimuth(), 37.0, 1e-12);
  EXPECT_EQ(f.state.levels[0], 0.25);
  EXPECT_NEAR(light_filter_confidence(f), 0.5, 1e-15);
}

// Each estimate moves the light by a = 0.25 / (0.4 + 0.25) = 5/13 of the angle, at most by 120 degrees a second, which
// is 30 in a quarter of a second.
TEST(LightFilter, StepResponseIsTheDocumentedOne) {
  Filter f;
  f.settle(0.0);
  std::vector<double> angles;
  for (int i = 0; i < 20; ++i) {
    f.take(at(90.0));
    angles.push_back(f.azimuth());
  }
  double expected = 0.0;
  for (size_t i = 0; i < angles.size(); ++i) {
    if (i > 0) expected += std::min(30.0, (90.0 - expected) * 5.0 / 13.0);
    EXPECT_NEAR(angles[i], expected, 1e-5) << i;  // the law is computed in floats
  }
  EXPECT_EQ(angles[0], 0.0);   // rejected
  EXPECT_LT(angles[1], 45.0);  // half way with the third estimate
  EXPECT_GE(angles[2], 45.0);
  EXPECT_LT(angles[4], 81.0);  // 90 % with the sixth: 1.25 s after the first
  EXPECT_GE(angles[5], 81.0);
  for (size_t i = 1; i < angles.size(); ++i) EXPECT_LT(angles[i], 90.0);
  EXPECT_EQ(f.rejected, 1u);
}

// The state depends on time and not on the rate of estimates: at twice the rate it is the same after the same time.
TEST(LightFilter, FollowsASlowLightWithABoundedLag) {
  for (const uint64_t period : {k_period_ns, k_period_ns / 2}) {
    Filter f;
    const double rate = 10.0;  // degrees a second
    double lag = 0.0;
    for (uint64_t t = 0; t < 6'000'000'000; t += period) {
      const double now = rate * static_cast<double>(t) * 1e-9;
      light_filter_take(&f, at(now), t + 1);
      lag = now - f.azimuth();
    }
    EXPECT_NEAR(lag, rate * 0.4, 0.1);  // the lag of a first-order filter: smoothing x rate
  }
}

TEST(LightFilter, ASingleOutlierChangesNothing) {
  Filter f;
  f.settle(20.0);
  const Filter before = f;
  for (const LightSample& odd : {at(110.0), at(20.0, 0.95)}) {
    EXPECT_FALSE(f.take(odd));
    EXPECT_EQ(f.azimuth(), before.azimuth());
    EXPECT_EQ(f.state.levels[3], before.state.levels[3]);
    EXPECT_TRUE(f.take(at(20.0)));
  }
  EXPECT_NEAR(f.azimuth(), 20.0, 1e-9);
  EXPECT_EQ(f.rejected, 2u);
}

// The control: without the gate the same outlier moves the light by 30 degrees.
TEST(LightFilter, WithoutTheGateAnOutlierMovesTheLight) {
  Filter f;
  f.law.outlier_angle = std::numbers::pi;
  f.settle(20.0);
  f.take(at(110.0));
  EXPECT_NEAR(f.azimuth(), 50.0, 1e-5);
}

// Outliers that do not agree with each other are accepted at the third in a row, so the filter never locks up.
TEST(LightFilter, DisagreementDoesNotLockItUp) {
  Filter f;
  f.settle(0.0);
  EXPECT_FALSE(f.take(at(60.0)));
  EXPECT_FALSE(f.take(at(-60.0)));
  EXPECT_TRUE(f.take(at(120.0)));
}

TEST(LightFilter, ConfidenceIsAgreement) {
  Filter steady, torn;
  for (int i = 0; i < 30; ++i) {
    steady.take(at(0.0));
    torn.take(at(i % 2 == 0 ? 100.0 : -100.0));
  }
  EXPECT_NEAR(light_filter_confidence(steady), 30.0 / 31.0, 1e-12);
  EXPECT_LT(light_filter_confidence(torn), 0.6);
}

TEST(LightFilter, SmoothingZeroTakesEveryEstimateWhole) {
  Filter f;
  f.law.smoothing = 0.0;
  for (const double degrees : {10.0, 170.0, -80.0}) {
    EXPECT_TRUE(light_filter_take(&f, at(degrees), 5));
    EXPECT_NEAR(f.azimuth(), degrees, 1e-12);
  }
}

TEST(LightFilter, TurnsAlongTheGreatCircleAlsoToTheOppositeSide) {
  const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, back[3] = {-1, 0, 0};
  double out[3];
  turn_towards(x, y, 30.0 * k_degree, out);
  EXPECT_NEAR(out[0], std::cos(30.0 * k_degree), 1e-15);
  EXPECT_NEAR(out[1], 0.5, 1e-15);
  turn_towards(x, back, 90.0 * k_degree, out);
  EXPECT_NEAR(out[0], 0.0, 1e-15);
  EXPECT_NEAR(out[0] * out[0] + out[1] * out[1] + out[2] * out[2], 1.0, 1e-15);
  turn_towards(x, x, 0.5, out);
  EXPECT_NEAR(out[0], 1.0, 1e-15);
}

TEST(LightFilter, TimesThatDoNotGrowCountAsTheInterval) {
  Filter clocked, still, backward;
  for (uint64_t i = 0; i < 9; ++i) {
    const LightSample s = at(i < 4 ? 0.0 : 25.0);
    clocked.take(s);
    light_filter_take(&still, s, 0);
    light_filter_take(&backward, s, 1'000'000'000 - i);
  }
  EXPECT_EQ(clocked.azimuth(), still.azimuth());
  EXPECT_EQ(clocked.azimuth(), backward.azimuth());
}

}  // namespace
}  // namespace sandglass
