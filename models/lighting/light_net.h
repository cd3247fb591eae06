// The lighting network in float, as trained: DenseNet-121's trunk and the heads behind it. The runtime's bytes are made
// from it and compared with it. The names of the arrays are in quantise.h.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "models/lighting/densenet.h"

namespace sandglass::host {

constexpr int k_latent = 512, k_heads = 10;

struct LightNet {
  DenseNet trunk;
  std::vector<float> latent, latent_bias;  // 1024 x 512 and 512, with the batch normalisation included
  std::vector<float> heads, heads_bias;    // 512 x 10 and 10: direction, light, ambient, contrast
  uint64_t data_hash = 0, seed = 0;
  uint32_t training_images = 0;
};

LightNet light_net_of(const Arrays& arrays);

// The network in the form in which a lighting file has it beside the bytes (runtime/asset/light.fbs): rounded only to
// float, and not calibrated.
std::vector<float> float_parameters(const LightNet& net);

// The unit direction in the camera's frame, light, ambient, contrast.
using LightValues = std::array<float, k_heads>;
LightValues light_of(const LightNet& net, std::span<const float> features);

// Medians over images, with a[i] compared to b[i]: of the angle between the directions, and of the greatest difference
// among the colours' channels and the contrast.
struct LightDifference {
  double angle_deg, other;
};
LightDifference median_difference(std::span<const LightValues> a, std::span<const LightValues> b);

}  // namespace sandglass::host
