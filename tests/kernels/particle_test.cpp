// The states of a particle are told apart, and none of them loses its mass or its number. The conversion to whole numbers
// has an answer for every float.
#include "kernels/particle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "kernels/whole.h"

namespace {

using namespace sandglass;

constexpr float k_position[3] = {0.1f, 0.2f, 0.3f}, k_velocity[3] = {1.0f, -2.0f, 3.0f};

// Powers of two and their neighbours, both signs, what is not finite, and the smallest numbers.
template <class Real>
std::vector<Real> special_values() {
  using Limits = std::numeric_limits<Real>;
  std::vector<Real> values = {Limits::quiet_NaN(), -Limits::quiet_NaN(), Limits::signaling_NaN()};
  for (const Real sign : {Real{1}, Real{-1}}) {
    for (const Real x :
         {Real{0}, Real{0.5}, Real{1.5}, Limits::denorm_min(), Limits::min(), Limits::max(), Limits::infinity()})
      values.push_back(sign * x);
    for (int power = 0; power <= 100; ++power) {
      const Real x = std::ldexp(Real{1}, power);
      for (const Real near : {x, std::nextafter(x, Real{0}), std::nextafter(x, Limits::infinity())})
        values.push_back(sign * near);
    }
  }
  return values;
}

// Against comparisons in a type that holds every value exactly. `volatile`: what the processor does, not the compiler.
template <class Whole, class Real>
void expect_bounded() {
  using Limits = std::numeric_limits<Whole>;
  for (const Real value : special_values<Real>()) {
    const long double exact = std::trunc(static_cast<long double>(value));
    const Whole nearest = std::isnan(value)                                  ? Whole{0}
                          : exact <= static_cast<long double>(Limits::min()) ? Limits::min()
                          : exact >= static_cast<long double>(Limits::max()) ? Limits::max()
                                                                             : static_cast<Whole>(exact);
    const volatile Real unknown = value;
    EXPECT_EQ(to_whole<Whole>(static_cast<Real>(unknown)), nearest) << value;
  }
}

template <class Real, class... Wholes>
void expect_all_bounded() {
  (expect_bounded<Wholes, Real>(), ...);
}

TEST(Whole, BoundsEverySpecialValueAlikeOnEveryProcessor) {
  expect_all_bounded<float, int32_t, uint32_t, int64_t, uint64_t, uint8_t>();
  expect_all_bounded<double, int32_t, uint32_t, int64_t, uint64_t, uint8_t, int16_t>();
}

TEST(Whole, FloorsLeaveRoomForTheNumbersBeside) {
  const float whole_max = std::ldexp(1.0f, 29);
  for (const float value : special_values<float>()) {
    const float bounded = std::isnan(value) ? -whole_max : std::clamp(std::floor(value), -whole_max, whole_max);
    const volatile float unknown = value;
    EXPECT_EQ(floor_whole(unknown), static_cast<int32_t>(bounded)) << value;
  }
}

TEST(Particle, SleepsAndWakesWithItsMassAndItsNumberButAtRest) {
  Particle p = moving_particle(k_position, k_velocity, 7);
  join_body(&p, 255, 0.25f);
  put_to_sleep(&p);
  EXPECT_TRUE(is_asleep(p) && !is_awake(p) && !is_fixed(p));
  EXPECT_EQ(inverse_mass(p), 0.25f);
  wake(&p);
  EXPECT_TRUE(is_awake(p) && !is_asleep(p) && !is_fixed(p));
  EXPECT_EQ(inverse_mass(p), 0.25f);
  EXPECT_EQ(p.velocity[1], 0.0f);
  EXPECT_EQ(number_of(p), 7u);
  EXPECT_EQ(body_of(p), 255u);
}

TEST(Particle, OfTheBoundaryIsFixedWhateverItsNumber) {
  const Particle p = fixed_particle(k_position, k_number_mask);
  EXPECT_TRUE(is_fixed(p) && !is_awake(p) && !is_asleep(p));
  EXPECT_FALSE(in_body(p));
  EXPECT_FALSE(is_inert(p));
}

TEST(Particle, ThatPadsIsFixedAndNoOneElses) {
  const Particle p = inert_particle();
  EXPECT_TRUE(is_fixed(p) && is_inert(p));
  EXPECT_FALSE(is_inert(moving_particle(k_position, k_velocity, k_number_mask)));
}

// The kernels rely on this: a particle and a grain are 8 floats each, in this order.
TEST(Particle, AndGrainAreEightLanes) {
  const Particle p = moving_particle(k_position, k_velocity, 7);
  const Grain g = moving_grain(k_position, k_velocity, 7);
  float lanes[2][k_record_floats];
  std::memcpy(lanes[0], &p, sizeof p);
  std::memcpy(lanes[1], &g, sizeof g);
  for (const float(&record)[k_record_floats] : lanes) {
    EXPECT_EQ(record[k_y], k_position[1]);
    EXPECT_EQ(record[k_vz], k_velocity[2]);
  }
  EXPECT_EQ(lanes[0][k_mobility], 1.0f);
  EXPECT_EQ(lanes[1][k_still_sweeps], 0.0f);
}

}  // namespace
