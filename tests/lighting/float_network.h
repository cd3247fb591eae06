// A random float network. A back end that runs it from a file must give what the plain network in float gives, which
// does not use the file's clamps.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "models/lighting/light_net.h"
#include "models/lighting/light_runner.h"
#include "models/work/random.h"
#include "tests/lighting/network_checks.h"

namespace sandglass::tests {

// The values of maps go far beyond a byte's 255. Normalisations have either sign; those of a few channels are zero or
// nearly so, which makes the channels constant.
inline host::LightNet random_light_net(uint64_t seed) {
  constexpr double k_maps = 300;  // size of values in maps and bottlenecks; behind a normalisation it is 1
  Random random = {seed};
  const auto uniform = [&](double from, double to) {
    return static_cast<float>(from + (to - from) * random.uniform());
  };
  const auto numbers = [&](int count, double most) {
    std::vector<float> values;
    for (int i = 0; i < count; ++i) values.push_back(uniform(-most, most));
    return values;
  };
  const auto affine = [&](int channels, double from, double to) {
    host::ChannelAffine a = {{}, numbers(channels, 0.5 * to)};
    for (int c = 0; c < channels; ++c) {
      const double kind = random.uniform();
      const float scale = uniform(0.5 * to / from, 1.5 * to / from);
      a.scale.push_back(kind < 0.02 ? 0.0f : kind < 0.04 ? 1e-20f : kind < 0.4 ? -scale : scale);
    }
    return a;
  };
  const auto convolution = [&](int size, int inputs, int outputs, double gain = 1) {
    const int places = size * size * inputs;
    return host::Convolution{size, inputs, outputs, numbers(places * outputs, gain * std::sqrt(6.0 / places))};
  };
  host::LightNet net;
  int channels = host::k_stem_channels;
  net.trunk.stem = convolution(7, 3, channels);
  net.trunk.stem_affine = affine(channels, 1, k_maps);
  for (int b = 0; b < 4; ++b) {
    host::DenseBlock& block = net.trunk.blocks[b];
    for (int l = 0; l < host::k_dense_layers[b]; ++l, channels += host::k_growth)
      block.layers.push_back({affine(channels, k_maps, 1), affine(host::k_bottleneck, 1, k_maps),
                              convolution(1, channels, host::k_bottleneck),
                              convolution(3, host::k_bottleneck, host::k_growth)});
    if (b == 3) break;
    block.transition_affine = affine(channels, k_maps, 1);
    block.transition = convolution(1, channels, channels / 2, k_maps);
    channels /= 2;
  }
  net.trunk.last = affine(channels, k_maps, 1);
  net.latent = numbers(host::k_features * host::k_latent, 0.05), net.latent_bias = numbers(host::k_latent, 0.5);
  net.heads = numbers(host::k_latent * host::k_heads, 0.1), net.heads_bias = numbers(host::k_heads, 0.5);
  return net;
}

// The float network, beside the bytes of another network, which a back end in float must not read.
inline host::LightFile float_file(const host::LightNet& net) {
  host::LightFile file = host::random_light_file(7);
  file.float_parameters = host::float_parameters(net);
  for (size_t o = 0; o < host::k_heads; ++o)
    for (size_t i = 0; i < host::k_latent; ++i)
      file.heads_weights[o * host::k_latent + i] = net.heads[i * host::k_heads + o];
  file.heads_bias = net.heads_bias;
  return file;
}

// XNNPACK on a file with float parameters gives the float network's features and heads to within 1e-3.
inline void expect_float_network(const std::vector<uint8_t>& rgb, uint32_t width, uint32_t height) {
  const host::LightNet net = random_light_net(5);
  host::LightRunner runner(host::light_file_bytes(float_file(net)), "random", SANDGLASS_ISA_AUTOMATIC, width, height,
                           SANDGLASS_LIGHT_BACKEND_XNNPACK_F32);
  const host::LightValues values = values_of(runner.run(rgb));
  const std::vector<float> features = runner.features();
  const std::vector<float> truth = host::features_of(net.trunk, rgb, static_cast<int>(width), static_cast<int>(height));
  float worst = 0, worst_value = 0;
  for (size_t c = 0; c < truth.size(); ++c) worst = std::max(worst, std::fabs(features[c] - truth[c]));
  const float greatest = *std::max_element(truth.begin(), truth.end());
  const host::LightValues expected = host::light_of(net, truth);
  for (size_t i = 0; i < values.size(); ++i) worst_value = std::max(worst_value, std::fabs(values[i] - expected[i]));
  EXPECT_LE(worst, 1e-3f);
  EXPECT_LE(worst_value, 1e-3f);
  EXPECT_GT(greatest, 1.0f) << "the features must not all be small";
  std::printf("features off by %.2g of %.3g, outputs by %.2g\n", static_cast<double>(worst),
              static_cast<double>(greatest), static_cast<double>(worst_value));
}

}  // namespace sandglass::tests
