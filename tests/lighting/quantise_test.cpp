// How weights become bytes, and what is refused as weights.
#include "models/lighting/quantise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "models/host/failure.h"
#include "models/host/random.h"
#include "models/lighting/light_runner.h"
#include "models/lighting/picture_file.h"
#include "models/lighting/rounding.h"

namespace sandglass::host {
namespace {

constexpr size_t k_inputs = 48, k_samples = 4000;

// Inputs that share `shared` of their variance, and the mean square that rounding adds to an output.
struct Inputs {
  std::vector<float> values;
  InputProducts products;
  explicit Inputs(double shared) {
    Random random = {5};
    const auto normal = [&] {
      return std::sqrt(-2 * std::log(1 - random.unit())) * std::cos(2 * M_PI * random.unit());
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

std::vector<double> random_weights() {
  Random random = {9};
  std::vector<double> weights;
  for (size_t i = 0; i < k_inputs; ++i) weights.push_back(40 * random.unit() - 20);
  return weights;
}

// Of the common part, variance 400 x 0.9, nearly nothing of the k_inputs/12 that rounding to nearest leaves may remain.
TEST(Rounding, WeightsMakeUpForOneAnotherWhereInputsVaryTogether) {
  const Inputs inputs(0.9);
  const std::vector<double> weights = random_weights();
  const std::vector<float> factor = triangular_factor(inputs.products, {1}, 0.5);
  const double nearest = inputs.error(weights, rounded(weights, 1, {})),
               together = inputs.error(weights, rounded(weights, 1, factor));
  // What is left at the least: each weight's own rounding times the variance that is its alone.
  EXPECT_LT(together, 2 * 400 * 0.1 * k_inputs / 12);
  EXPECT_LT(together, 0.5 * nearest);
}

TEST(Rounding, IndependentInputsAreRoundedToNearest) {
  InputProducts products;
  for (size_t s = 0; s < 2 * k_inputs; ++s) {  // plus and minus each axis: a diagonal covariance, exactly
    std::vector<float> sample(k_inputs, 0.0f);
    sample[s / 2] = s % 2 == 0 ? 8.0f : -8.0f;
    products.add(sample.data(), sample.size());
  }
  products.flush();
  const std::vector<double> weights = random_weights();
  EXPECT_EQ(rounded(weights, 1, triangular_factor(products, {1}, 0.5)), rounded(weights, 1, {}));
}

std::string sentence_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Failure& failure) {
    return failure.what();
  }
  return "";
}

TEST(LightNetImport, WhatIsMissingOrNotANetworkIsNamed) {
  EXPECT_NE(sentence_of([] { light_net_of({}); }).find("conv1/conv/kernel"), std::string::npos);
  const std::vector<uint8_t> rubbish(1000, 7);
  EXPECT_NE(sentence_of([&] { LightRunner(rubbish, "rubbish.light"); }).find("'rubbish.light': the file is not"),
            std::string::npos);
  EXPECT_NE(sentence_of([] { read_picture("no/such/picture.png"); }).find("no/such/picture.png"), std::string::npos);
}

}  // namespace
}  // namespace sandglass::host
