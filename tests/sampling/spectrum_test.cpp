// The power spectrum, (3.1) of the dissertation, against its sum in long double, and the colour of the samplers' noise.
// White noise is the control that must fail.
#include <gtest/gtest.h>

#include <cmath>

#include "models/mesh/generated.h"
#include "runtime/core/math.h"
#include "runtime/core/random.h"
#include "tests/sampling/point_checks.h"

namespace sandglass::test {
namespace {

constexpr double k_distance = 0.02;
constexpr uint32_t k_bins = 40, k_directions = 48;

// |F|^2/count at a frequency in cycles per metre, F as in (3.1) with k_FT = 1.
double power_at(const Points& points, const std::array<double, 3>& frequency) {
  double real = 0, imaginary = 0;
  for (size_t i = 0; i < points.size(); i += 3) {
    double cycles = 0;
    for (size_t k = 0; k < 3; ++k) cycles += frequency[k] * static_cast<double>(points[i + k]);
    const SinCos wave = sin_cos_turns(cycles);
    real += wave.cos;
    imaginary -= wave.sin;
  }
  return (real * real + imaginary * imaginary) / static_cast<double>(points.size() / 3);
}

TEST(Spectrum, equals_the_sum_in_long_double) {
  Random random = random_stream(1, 1);
  Points points;
  for (int i = 0; i < 300; ++i) points.push_back(static_cast<float>(random.uniform() * 4 - 2));
  const std::array<double, 3> frequency = {3.7, -11.25, 0.5};
  long double real = 0, imaginary = 0;
  for (size_t i = 0; i < points.size(); i += 3) {
    long double cycles = 0;
    for (size_t k = 0; k < 3; ++k) cycles += static_cast<long double>(frequency[k]) * points[i + k];
    real += std::cos(2 * 3.141592653589793238462643L * cycles);
    imaginary -= std::sin(2 * 3.141592653589793238462643L * cycles);
  }
  EXPECT_NEAR(power_at(points, frequency), static_cast<double>((real * real + imaginary * imaginary) / 100), 1e-11);
}

// The mean power of a flat set between 0.15/l and 0.5/l: above the frequencies of the set's 1 m outline, and well below
// that of the spacing. The spectrum is symmetric, so half a circle of directions holds all of it.
double low_frequency_power(const Points& points) {
  double sum = 0;
  int count = 0;
  for (uint32_t b = 0; b < k_bins; ++b) {
    const double frequency = (b + 0.5) / k_bins * 2 / k_distance;
    if (frequency * k_distance < 0.15 || frequency * k_distance > 0.5) continue;
    for (uint32_t n = 0; n < k_directions; ++n) {
      const SinCos azimuth = sin_cos_turns(0.5 * (n + 0.5) / k_directions);
      sum += power_at(points, {frequency * azimuth.cos, 0, frequency * azimuth.sin});
      ++count;
    }
  }
  return sum / count;
}

constexpr double k_blue_limit = 0.3;  // white noise has 1

TEST(Spectrum, surface_samples_are_blue_noise) {
  const Points points = sample_surface(unit_square(), static_cast<float>(k_distance), desc_with_seed(1));
  EXPECT_LT(low_frequency_power(points), k_blue_limit);
}

// The same for a cube of edge `edge`, at the frequencies (i, j, k)/edge only. There the outline of the cube has no
// power at all; in a radial mean it would hide the noise.
double low_frequency_power_of_cube(const Points& points, double edge) {
  const int lowest = static_cast<int>(0.15 * edge / k_distance), highest = static_cast<int>(0.5 * edge / k_distance);
  double sum = 0;
  int count = 0;
  for (int i = -highest; i <= highest; ++i)
    for (int j = -highest; j <= highest; ++j)
      for (int k = 0; k <= highest; ++k) {
        const int squared = i * i + j * j + k * k;
        if (squared < lowest * lowest || squared > highest * highest || (i + 2 * j + 3 * k) % 4 != 0) continue;
        sum += power_at(points, {i / edge, j / edge, k / edge});
        ++count;
      }
  return sum / count;
}

constexpr double k_edge = 0.4;

TEST(Spectrum, volume_samples_are_blue_noise) {
  const Points points =
      sample_volume({{0, 0, 0}, {0.4f, 0.4f, 0.4f}}, static_cast<float>(k_distance), everywhere, desc_with_seed(1));
  EXPECT_LT(low_frequency_power_of_cube(points, k_edge), k_blue_limit);
}

TEST(Spectrum, white_noise_is_not_blue) {  // negative control: an expected power of 1 at every frequency
  Random random = random_stream(2, 2);
  Points flat, deep;
  for (int i = 0; i < 1700; ++i)
    flat.insert(flat.end(), {static_cast<float>(random.uniform()), 0, static_cast<float>(random.uniform())});
  for (int i = 0; i < 3 * 5000; ++i) deep.push_back(static_cast<float>(k_edge * random.uniform()));
  EXPECT_NEAR(low_frequency_power(flat), 1, 0.15);
  EXPECT_NEAR(low_frequency_power_of_cube(deep, k_edge), 1, 0.15);
}

}  // namespace
}  // namespace sandglass::test
