// How weights become bytes, and which weights are refused.
#include "models/lighting/quantise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "models/files/image.h"
#include "models/lighting/light_runner.h"
#include "models/lighting/rounding.h"
#include "models/work/random.h"
#include "tests/refusal.h"

namespace sandglass::host {
namespace {

constexpr size_t k_inputs = 48, k_samples = 4000;

// Inputs that have the share `shared` of their variance in common, and the mean square that rounding adds to an output.
struct Inputs {
  std::vector<float> values;
  InputProducts products;
  explicit Inputs(double shared) {
    Random random = {5};
    const auto normal = [&] {
      return std::sqrt(-2 * std::log(1 - random.uniform())) * std::cos(2 * M_PI * random.uniform());
    };
    for (size_t s = 0; s < k_samples; ++s) {
      const double common = normal();
      std::vector<float> sample;
      for (size_t i = 0; i < k_inputs; ++i)
        sample.push_back(
            static_cast<float>(100 + 20 * (std::sqrt(shared) * common + std::sqrt(1 - shared) * normal())));
      products.add(sample.data(), sample.size());
      values.insert(values.end(), sample.begin(), sample.end());
    }
    products.flush();
  }
  double error(const std::vector<double>& weights, const std::vector<int8_t>& integers) const {
    double sum = 0, squares = 0;
    for (size_t s = 0; s < k_samples; ++s) {
      double e = 0;
      for (size_t i = 0; i < k_inputs; ++i)
        e += (integers[i] - weights[i]) * static_cast<double>(values[s * k_inputs + i]);
      sum += e, squares += e * e;
    }
    return squares / k_samples - std::pow(sum / k_samples, 2);  // the mean goes into the bias
  }
};

std::vector<double> random_weights(uint64_t seed) {
  Random random = {seed};
  std::vector<double> weights;
  for (size_t i = 0; i < k_inputs; ++i) weights.push_back(40 * random.uniform() - 20);
  return weights;
}

// Rounding to nearest leaves, on the mean of many rows, k_inputs/12 of the common variance (400 x 0.9) and of each
// input's own (400 x 0.1). Rounding that lets weights make up for one another leaves little more than the second part.
TEST(Rounding, WeightsMakeUpForOneAnotherWhereInputsVaryTogether) {
  constexpr int k_rows = 40;
  const Inputs inputs(0.9);
  const std::vector<float> factor = triangular_factor(inputs.products, {1}, 0.5);
  double nearest = 0, together = 0;
  for (int row = 0; row < k_rows; ++row) {
    const std::vector<double> weights = random_weights(static_cast<uint64_t>(100 + row));
    nearest += inputs.error(weights, rounded(weights, 1, {})) / k_rows;
    together += inputs.error(weights, rounded(weights, 1, factor)) / k_rows;
  }
  EXPECT_NEAR(nearest, 400.0 * k_inputs / 12, 0.35 * 400 * k_inputs / 12);
  EXPECT_LT(together, 1.5 * 400 * 0.1 * k_inputs / 12);
}

TEST(Rounding, IndependentInputsAreRoundedToNearest) {
  InputProducts products;
  for (size_t s = 0; s < 2 * k_inputs; ++s) {  // plus and minus each axis: the covariance is exactly diagonal
    std::vector<float> sample(k_inputs, 0.0f);
    sample[s / 2] = s % 2 == 0 ? 8.0f : -8.0f;
    products.add(sample.data(), sample.size());
  }
  products.flush();
  const std::vector<double> weights = random_weights(9);
  EXPECT_EQ(rounded(weights, 1, triangular_factor(products, {1}, 0.5)), rounded(weights, 1, {}));
}

TEST(LightNetImport, WhatIsMissingOrNotANetworkIsNamed) {
  tests::expect_refusal("conv1/conv/kernel", [] { light_net_of({}); });
  const std::vector<uint8_t> rubbish(1000, 7);
  tests::expect_refusal("\"rubbish.light\": the file is not", [&] { LightRunner(rubbish, "rubbish.light"); });
  tests::expect_refusal("no/such/picture.png", [] { read_picture("no/such/picture.png"); });
}

}  // namespace
}  // namespace sandglass::host
