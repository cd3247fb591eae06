#include "tests/lighting/reference_classifier.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "models/files/npy.h"
#include "models/lighting/float_parameters.h"
#include "models/lighting/light_file.h"
#include "models/lighting/quantise.h"

namespace sandglass::host {

namespace {
constexpr const char* k_images[] = {"bird", "parrot", "cat"};
}

ReferenceClassifier::ReferenceClassifier(const std::string& data_folder) : folder_(data_folder + "/pretrained/") {
  net_.trunk = densenet_of(read_npz(folder_ + "densenet121_imagenet_keras_fp32.npz"));
  net_.latent.assign(size_t{k_features} * k_latent, 0.01f), net_.latent_bias.assign(k_latent, 0);
  net_.heads.assign(size_t{k_latent} * k_heads, 0.01f), net_.heads_bias.assign(k_heads, 0);
  const auto truth = read_npz(folder_ + "densenet121_reference_outputs.npz");
  LightRanges ranges;
  ranges.products = false;
  for (const std::string name : k_images) {
    const std::vector<float>& pixels = truth.at(name + "/rgb_u8").values;
    images_.emplace_back(pixels.size());
    std::transform(pixels.begin(), pixels.end(), images_.back().begin(),
                   [](float v) { return static_cast<uint8_t>(v); });
    observe(net_.trunk, images_.back(), k_reference_side, k_reference_side, &ranges);
  }
  LightFile file = quantise(net_, &ranges);
  file_ = light_file_bytes(file);
  file.float_parameters = float_parameters(net_);
  float_file_ = light_file_bytes(file);
}

void ReferenceClassifier::expect_reference(LightRunner* runner) const {
  const auto truth = read_npz(folder_ + "densenet121_reference_outputs.npz");
  size_t image = 0;
  for (const std::string name : k_images) {
    runner->run(images_[image++]);
    const std::vector<float> features = runner->features(), &expected = truth.at(name + "/feat1024").values;
    double error = 0, square = 0;
    for (size_t c = 0; c < features.size(); ++c) {
      error += std::pow(static_cast<double>(features[c] - expected[c]), 2);
      square += std::pow(static_cast<double>(expected[c]), 2);
    }
    std::printf("%s: relative error of the features %.4f\n", name.c_str(), std::sqrt(error / square));
    EXPECT_LE(std::sqrt(error / square), 0.1) << name;
    const std::vector<float> probabilities = probabilities_of(net_.trunk, features),
                             &classes = truth.at(name + "/prob1000").values;
    EXPECT_EQ(std::max_element(probabilities.begin(), probabilities.end()) - probabilities.begin(),
              std::max_element(classes.begin(), classes.end()) - classes.begin())
        << name;
  }
}

void ReferenceClassifier::expect_float_reference(LightRunner* runner) const {
  const auto truth = read_npz(folder_ + "densenet121_reference_outputs.npz");
  const auto worst = [](const std::vector<float>& a, const std::vector<float>& b) {
    double most = a.size() == b.size() ? 0 : 1e9;
    for (size_t i = 0; i < a.size() && i < b.size(); ++i)
      most = std::max(most, std::fabs(static_cast<double>(a[i]) - static_cast<double>(b[i])));
    return most;
  };
  size_t image = 0;
  for (const std::string name : k_images) {
    runner->run(images_[image++]);
    const std::vector<float> features = runner->features(), probabilities = probabilities_of(net_.trunk, features);
    const std::vector<float>&expected = truth.at(name + "/feat1024").values,
          &classes = truth.at(name + "/prob1000").values;
    std::printf("%s: features off by %.2g, probabilities by %.2g\n", name.c_str(), worst(features, expected),
                worst(probabilities, classes));
    EXPECT_LE(worst(features, expected), 1e-3) << name;
    EXPECT_LE(worst(probabilities, classes), 1e-3) << name;
    EXPECT_EQ(std::max_element(probabilities.begin(), probabilities.end()) - probabilities.begin(),
              std::max_element(classes.begin(), classes.end()) - classes.begin())
        << name;
  }
}

}  // namespace sandglass::host
