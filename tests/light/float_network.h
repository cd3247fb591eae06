// A random float network as a lighting file carries it, and a naive run of it in double as asset/light.fbs describes it.
// Shares no code with the runtime. A back end that runs the file in float must give the same.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "models/lighting/light_runner.h"
#include "models/work/random.h"
#include "tests/light/byte_network.h"
#include "tests/light/network_checks.h"

namespace sandglass::tests {

struct FloatConvolution {
  int size = 1, inputs = 0, outputs = 0;
  std::vector<float> low, high, weights, bias;  // clamps of the inputs, or empty; weights by output, place and input
};

struct FloatNetwork {
  std::vector<float> border;
  std::vector<FloatConvolution> convolutions;  // in the order of the file
  FloatConvolution last;                       // clamps alone
  std::vector<float> scale, shift, latent, latent_bias;

  std::vector<float> parameters() const {
    std::vector<float> all = border;
    const auto add = [&](const std::vector<float>& more) { all.insert(all.end(), more.begin(), more.end()); };
    for (const FloatConvolution& c : convolutions) {
      add(c.low);
      add(c.high);
      add(c.weights);
      add(c.bias);
    }
    add(last.low);
    add(last.high);
    add(scale);
    add(shift);
    add(latent);
    add(latent_bias);
    return all;
  }
};

// The values of maps go far beyond a byte's 255. Clamps are from below or from above. A few channels do not count.
inline FloatNetwork random_float_network(uint64_t seed) {
  constexpr double k_maps = 300;  // size of values in maps and bottlenecks
  Random random = {seed};
  const auto numbers = [&](int count, double magnitude) {
    std::vector<float> values;
    for (int i = 0; i < count; ++i) values.push_back(static_cast<float>(magnitude * (2 * random.uniform() - 1)));
    return values;
  };
  const auto clamps = [&](int channels, FloatConvolution* c) {
    c->low.assign(static_cast<size_t>(channels), -k_light_float_limit);
    c->high.assign(static_cast<size_t>(channels), k_light_float_limit);
    for (size_t i = 0; i < c->low.size(); ++i)
      (random.uniform() < 0.6 ? c->low : c->high)[i] = static_cast<float>(0.5 * k_maps * (2 * random.uniform() - 1));
  };
  const auto convolution = [&](int size, int inputs, int outputs, bool clamped, double gain = 1) {
    FloatConvolution c = {size, inputs, outputs, {}, {}, {}, {}};
    const int places = size * size * inputs;
    if (clamped) clamps(inputs, &c);
    c.weights = numbers(places * outputs, gain * std::sqrt(3.0 / places));
    c.bias = numbers(outputs, 0.5 * k_maps);
    for (int i = 0; clamped && i < inputs; ++i)
      if (random.uniform() < 0.04)
        for (int o = 0; o < outputs; ++o) c.weights[static_cast<size_t>(o * inputs + i)] = 0;
    return c;
  };
  FloatNetwork net;
  net.border = {124, 116, 104};
  int channels = k_light_stem;
  net.convolutions.push_back(convolution(7, 3, channels, false, 3));
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    for (uint32_t l = 0; l < k_block_layers[b]; ++l, channels += k_light_growth) {
      net.convolutions.push_back(convolution(1, channels, k_light_bottleneck, true, std::sqrt(2.0)));
      net.convolutions.push_back(convolution(3, k_light_bottleneck, k_light_growth, false, std::sqrt(2.0)));
    }
    if (b == k_transition_count) break;
    net.convolutions.push_back(convolution(1, channels, channels / 2, true, std::sqrt(2.0)));
    channels /= 2;
  }
  clamps(channels, &net.last);
  net.scale = numbers(channels, 1 / k_maps);
  net.shift = numbers(channels, 0.5);
  net.latent = numbers(channels * k_light_latent, 0.05);
  net.latent_bias = numbers(k_light_latent, 0.5);
  return net;
}

// Windows of size x size, `step` pixels apart.
inline Map<double> convolved(const FloatConvolution& c, const Map<double>& in, int step, const float* border,
                             bool rectified) {
  Map<double> out(in.width / step, in.height / step, c.outputs);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int o = 0; o < c.outputs; ++o) {
        double sum = static_cast<double>(c.bias[static_cast<size_t>(o)]);
        const float* weights = c.weights.data() + static_cast<size_t>(o * c.size * c.size * c.inputs);
        for (int place = 0; place < c.size * c.size; ++place) {
          const int u = x * step + place % c.size - c.size / 2, v = y * step + place / c.size - c.size / 2;
          const bool inside = u >= 0 && v >= 0 && u < in.width && v < in.height;
          for (int i = 0; i < c.inputs; ++i, ++weights)
            sum += static_cast<double>(*weights) * (inside              ? in.at(u, v, i)
                                                    : border == nullptr ? 0
                                                                        : static_cast<double>(border[i]));
        }
        out.at(x, y, o) = rectified ? std::max(0.0, sum) : sum;
      }
  return out;
}

inline Map<double> clamped(const FloatConvolution& c, Map<double> map) {
  for (size_t i = 0; i < map.values.size(); ++i) {
    const size_t channel = i % c.low.size();
    map.values[i] =
        std::clamp(map.values[i], static_cast<double>(c.low[channel]), static_cast<double>(c.high[channel]));
  }
  return map;
}

inline std::vector<double> features_of(const FloatNetwork& net, const std::vector<uint8_t>& rgb, int width,
                                       int height) {
  Map<double> image(width, height, 3);
  image.values.assign(rgb.begin(), rgb.end());
  auto next = net.convolutions.begin();
  Map<double> map = pooled(convolved(*next++, image, 2, net.border.data(), true));
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    for (uint32_t l = 0; l < k_block_layers[b]; ++l, next += 2)
      map = appended(
          map, convolved(next[1], convolved(next[0], clamped(next[0], map), 1, nullptr, true), 1, nullptr, false));
    if (b == k_transition_count) break;
    map = convolved(*next, averaged(clamped(*next, map)), 1, nullptr, false);
    ++next;
  }
  map = clamped(net.last, map);
  std::vector<double> features(net.scale.size());
  for (size_t i = 0; i < map.values.size(); ++i) features[i % features.size()] += map.values[i];
  for (size_t c = 0; c < features.size(); ++c)
    features[c] =
        static_cast<double>(net.scale[c]) * features[c] / (map.width * map.height) + static_cast<double>(net.shift[c]);
  return features;
}

inline host::LightValues values_of(const FloatNetwork& net, const host::LightFile& file,
                                   const std::vector<double>& features) {
  std::vector<double> latent(net.latent_bias.begin(), net.latent_bias.end());
  for (size_t c = 0; c < features.size(); ++c)
    for (size_t i = 0; i < latent.size(); ++i)
      latent[i] += features[c] * static_cast<double>(net.latent[c * latent.size() + i]);
  double heads[k_light_heads];
  for (size_t o = 0; o < k_light_heads; ++o) {
    heads[o] = static_cast<double>(file.heads_bias[o]);
    for (size_t i = 0; i < latent.size(); ++i)
      heads[o] += static_cast<double>(file.heads_weights[o * latent.size() + i]) *
                  (latent[i] > 0 ? latent[i] : std::expm1(latent[i]));
  }
  double length = 0;
  for (size_t o = 0; o < 3; ++o) length += std::pow(std::tanh(heads[o]), 2);
  host::LightValues values;
  for (size_t o = 0; o < k_light_heads; ++o)
    values[o] = static_cast<float>(o < 3 ? std::tanh(heads[o]) / std::sqrt(length) : 1 / (1 + std::exp(-heads[o])));
  return values;
}

// XNNPACK on a file with float parameters gives the naive network's features and heads to within 1e-3. The bytes beside
// them are those of another network, which a back end in float must not read.
inline void expect_float_network(const std::vector<uint8_t>& rgb, uint32_t width, uint32_t height) {
  const FloatNetwork net = random_float_network(5);
  host::LightFile file = host::random_light_file(7);
  file.float_parameters = net.parameters();
  ASSERT_EQ(file.float_parameters.size(), k_light_float_parameters);
  host::LightRunner runner(host::light_file_bytes(file), "random", SANDGLASS_ISA_AUTOMATIC, width, height,
                           SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32);
  const host::LightValues values = values_of(runner.run(rgb));
  const std::vector<float> features = runner.features();
  const std::vector<double> truth = features_of(net, rgb, static_cast<int>(width), static_cast<int>(height));
  const std::vector<double> of_grey =
      features_of(net, std::vector<uint8_t>(rgb.size(), 128), static_cast<int>(width), static_cast<int>(height));
  const host::LightValues expected = values_of(net, file, truth);
  double worst = 0, greatest = 0;
  float worst_value = 0;
  for (size_t c = 0; c < truth.size(); ++c) {
    worst = std::max(worst, std::fabs(static_cast<double>(features[c]) - truth[c]));
    greatest = std::max(greatest, std::fabs(truth[c] - of_grey[c]));
  }
  for (size_t i = 0; i < values.size(); ++i) worst_value = std::max(worst_value, std::fabs(values[i] - expected[i]));
  EXPECT_LE(worst, 1e-3);
  EXPECT_LE(worst_value, 1e-3f);
  EXPECT_GT(greatest, 0.1) << "the features must depend on the image";
  std::printf("features off by %.2g; another image changes them by %.3g; outputs off by %.2g\n", worst, greatest,
              static_cast<double>(worst_value));
}

}  // namespace sandglass::tests
