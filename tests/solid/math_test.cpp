// The functions of runtime/math/math.h against libm in long double, with the error bounds that the header states.
#include "runtime/math/math.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime/math/random.h"

namespace sandglass {
namespace {

constexpr int k_arguments = 200000;

// The largest error at random arguments.
template <class Error>
double worst(uint64_t stream, const Error& error) {
  Random random = random_stream(stream, 0);
  double error_max = 0;
  for (int i = 0; i < k_arguments; ++i) error_max = std::max(error_max, static_cast<double>(std::fabs(error(&random))));
  return error_max;
}

TEST(Math, sine_and_cosine_stay_within_their_bound) {
  const auto error = [](Random* random) {
    const double turns = 8 * random->uniform() - 4;
    const long double angle = 2 * 3.141592653589793238462643383279502884L * turns;
    const SinCos value = sin_cos_turns(turns);
    return std::max(std::fabs(value.sin - std::sin(angle)), std::fabs(value.cos - std::cos(angle)));
  };
  EXPECT_LT(worst(1, error), 3e-16);
}

TEST(Math, quarters_of_a_turn_are_exact) {
  for (int quarter = -8; quarter <= 8; ++quarter) {
    const SinCos value = sin_cos_turns(0.25 * quarter);
    const double sine[4] = {0, 1, 0, -1};
    EXPECT_EQ(value.sin, sine[(quarter + 8) % 4]);
    EXPECT_EQ(value.cos, sine[(quarter + 9) % 4]);
  }
}

TEST(Math, arc_tangent_stays_within_its_bound) {
  const auto error = [](Random* random) {
    const double y = 2 * random->uniform() - 1, sign = 2 * random->uniform() - 1;
    const double x = sign * std::pow(10.0, 6 * random->uniform() - 3);
    return arc_tangent2(y, x) - std::atan2(static_cast<long double>(y), static_cast<long double>(x));
  };
  EXPECT_LT(worst(2, error), 5e-16);
  EXPECT_EQ(arc_tangent2(0, 0), 0);
  EXPECT_NEAR(arc_tangent2(0, -1), k_pi, 5e-16);
  EXPECT_NEAR(arc_tangent2(-1, 0), -k_pi / 2, 5e-16);
}

TEST(Math, exponential_stays_within_its_bound) {
  const auto error = [](Random* random) {
    const double x = -690 + 1380 * random->uniform();
    return exponential(x) / std::exp(static_cast<long double>(x)) - 1;
  };
  EXPECT_LT(worst(5, error), 1e-15);
  EXPECT_EQ(exponential(0), 1);
  EXPECT_EQ(exponential(-800), 0);
  EXPECT_EQ(exponential(800), exponential(700));
}

TEST(Math, cube_root_stays_within_its_bound) {
  const auto error = [](Random* random) {
    const double x = std::pow(10.0, 24 * random->uniform() - 12);
    return cube_root(x) / std::cbrt(static_cast<long double>(x)) - 1;
  };
  EXPECT_LT(worst(3, error), 4e-16);
  EXPECT_EQ(cube_root(0), 0);
  EXPECT_EQ(cube_root(8), 2);
}

TEST(Math, floor_and_ceiling_are_those_of_libm) {
  Random random = random_stream(4, 0);
  for (int i = 0; i < k_arguments; ++i) {
    const double x = (random.uniform() - 0.5) * 1e6;
    ASSERT_EQ(static_cast<double>(floor_index(x)), std::floor(x));
    ASSERT_EQ(static_cast<double>(ceiling_index(x)), std::ceil(x));
  }
  for (int64_t i = -3; i <= 3; ++i) {
    EXPECT_EQ(floor_index(static_cast<double>(i)), i);
    EXPECT_EQ(ceiling_index(static_cast<double>(i)), i);
  }
  EXPECT_EQ(floor_index(1e300), int64_t{1} << 62);
  EXPECT_EQ(ceiling_index(1e300), int64_t{1} << 62);
}

}  // namespace
}  // namespace sandglass
