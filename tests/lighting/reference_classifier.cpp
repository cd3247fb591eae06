#include "tests/lighting/reference_classifier.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "models/files/npy.h"
#include "models/lighting/light_file.h"
#include "models/lighting/light_net.h"
#include "models/lighting/quantise.h"

namespace sandglass::host {

namespace {

constexpr const char* k_images[] = {"bird", "parrot", "cat"};

double worst_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double most = a.size() == b.size() ? 0 : 1e9;
  for (size_t i = 0; i < a.size() && i < b.size(); ++i)
    most = std::max(most, std::fabs(static_cast<double>(a[i]) - static_cast<double>(b[i])));
  return most;
}

template <class Values>
size_t greatest(const Values& values) {
  return static_cast<size_t>(std::max_element(values.begin(), values.end()) - values.begin());
}

}  // namespace

ReferenceClassifier::ReferenceClassifier(const std::string& data_folder) {
  auto weights = read_npz(data_folder + "/pretrained/densenet121_imagenet_keras_fp32.npz");
  const auto truth = read_npz(data_folder + "/pretrained/densenet121_reference_outputs.npz");
  kernel_ = weights.at("fc1000/kernel").values, bias_ = weights.at("fc1000/bias").values;
  LightNet net;
  net.trunk = densenet_of(weights);
  net.latent.assign(size_t{k_features} * k_latent, 0.01f), net.latent_bias.assign(k_latent, 0);
  net.heads.assign(size_t{k_latent} * k_heads, 0.01f), net.heads_bias.assign(k_heads, 0);
  LightRanges ranges;
  ranges.products = false;
  for (const std::string name : k_images) {
    const std::vector<float>& pixels = truth.at(name + "/rgb_u8").values;
    images_.push_back({name, {}, truth.at(name + "/feat1024").values, greatest(truth.at(name + "/prob1000").values)});
    std::transform(pixels.begin(), pixels.end(), std::back_inserter(images_.back().rgb),
                   [](float v) { return static_cast<uint8_t>(v); });
    expect_float(images_.back(), observe(net.trunk, images_.back().rgb, k_reference_side, k_reference_side, &ranges));
  }
  LightFile file = quantise(net, &ranges);
  file_ = light_file_bytes(file);
  file.float_parameters = float_parameters(net);
  float_file_ = light_file_bytes(file);
}

void ReferenceClassifier::expect_class(const Image& image, const std::vector<float>& features) const {
  std::vector<double> logits(bias_.begin(), bias_.end());
  for (size_t k = 0; k < features.size(); ++k)
    for (size_t n = 0; n < logits.size(); ++n)
      logits[n] += static_cast<double>(features[k]) * static_cast<double>(kernel_[k * logits.size() + n]);
  EXPECT_EQ(greatest(logits), image.label) << image.name;
}

void ReferenceClassifier::expect_float(const Image& image, const std::vector<float>& features) const {
  std::printf("%s: features off by %.2g\n", image.name.c_str(), worst_difference(features, image.features));
  EXPECT_LE(worst_difference(features, image.features), 1e-3) << image.name;
  expect_class(image, features);
}

void ReferenceClassifier::expect_reference(LightRunner* runner) const {
  for (const Image& image : images_) {
    runner->run(image.rgb);
    const std::vector<float> features = runner->features();
    double error = 0, square = 0;
    for (size_t c = 0; c < features.size(); ++c) {
      error += std::pow(static_cast<double>(features[c] - image.features[c]), 2);
      square += std::pow(static_cast<double>(image.features[c]), 2);
    }
    std::printf("%s: relative error of the features %.4f\n", image.name.c_str(), std::sqrt(error / square));
    EXPECT_LE(std::sqrt(error / square), 0.1) << image.name;
    expect_class(image, features);
  }
}

void ReferenceClassifier::expect_float_reference(LightRunner* runner) const {
  for (const Image& image : images_) {
    runner->run(image.rgb);
    expect_float(image, runner->features());
  }
}

}  // namespace sandglass::host
