// The states of a particle are told apart, and none of them loses its mass or its number. The conversion to whole numbers
// has an answer for every float.
#include "kernels/particle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "kernels/whole.h"

namespace {

using namespace sandglass;

constexpr float k_position[3] = {0.1f, 0.2f, 0.3f}, k_velocity[3] = {1.0f, -2.0f, 3.0f};

TEST(Whole, TruncatesWhatFitsAndEndsAtTheNearestThatDoes) {
  EXPECT_EQ(to_whole<int32_t>(2.9f), 2);
  EXPECT_EQ(to_whole<int32_t>(-2.9f), -2);
  EXPECT_EQ(to_whole<uint32_t>(-0.9), 0u);
  EXPECT_EQ(to_whole<uint8_t>(255.9), 255);
  EXPECT_EQ(to_whole<int32_t>(2147483520.0f), 2147483520);  // the last float below 2^31
  EXPECT_EQ(to_whole<int32_t>(2147483648.0f), INT32_MAX);
  EXPECT_EQ(to_whole<int32_t>(-2147483648.0f), INT32_MIN);
  EXPECT_EQ(to_whole<int32_t>(-3e38f), INT32_MIN);
  EXPECT_EQ(to_whole<int32_t>(INFINITY), INT32_MAX);
  EXPECT_EQ(to_whole<int32_t>(NAN), 0);
  EXPECT_EQ(to_whole<uint32_t>(-1e30), 0u);
  EXPECT_EQ(to_whole<uint32_t>(4294967295.5), UINT32_MAX);
  EXPECT_EQ(to_whole<uint32_t>(4294967296.0), UINT32_MAX);
  EXPECT_EQ(to_whole<uint64_t>(18446744073709551616.0), UINT64_MAX);
  EXPECT_EQ(to_whole<int64_t>(-9223372036854775808.0), INT64_MIN);
  EXPECT_EQ(to_whole<int64_t>(static_cast<double>(NAN)), 0);
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
  std::memcpy(lanes[0], &p, sizeof p), std::memcpy(lanes[1], &g, sizeof g);
  for (const float(&record)[k_record_floats] : lanes) {
    EXPECT_EQ(record[k_y], k_position[1]);
    EXPECT_EQ(record[k_vz], k_velocity[2]);
  }
  EXPECT_EQ(lanes[0][k_mobility], 1.0f);
  EXPECT_EQ(lanes[1][k_still_sweeps], 0.0f);
}

}  // namespace
