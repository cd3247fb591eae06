// See quantise.h.
#include "models/baking/quantise.h"

#include <algorithm>
#include <cmath>

namespace sandglass::host {

namespace {

constexpr double k_bias_limit = 1 << 24;

ByteLayer quantise_layer(const float* weights, const float* bias, uint32_t inputs, uint32_t outputs, double step_in,
                         double step_out) {
  ByteLayer layer;
  for (uint32_t o = 0; o < outputs; ++o) {
    float largest = 0;
    for (uint32_t i = 0; i < inputs; ++i) largest = std::max(largest, std::fabs(weights[i * outputs + o]));
    const float inverse = largest > 0 ? 127.0f / largest : 0;
    for (uint32_t i = 0; i < inputs; ++i)
      layer.weights.push_back(static_cast<int8_t>(std::nearbyint(weights[i * outputs + o] * inverse)));
    const double unit =
        (largest > 0 ? static_cast<double>(largest) / 127 : 1.0) * step_in;  // the value of one step of the integer sum
    layer.bias.push_back(static_cast<int32_t>(
        std::nearbyint(std::clamp(static_cast<double>(bias[o]) / unit, -k_bias_limit, k_bias_limit))));
    layer.multiplier.push_back(static_cast<float>(unit / step_out));
  }
  return layer;
}

}  // namespace

ByteNetwork quantise(const FloatNetwork& network, const std::vector<float>& clips) {
  const NetworkShape& shape = network.shape;
  ByteNetwork bytes;
  bytes.shape = shape;
  bytes.first_weights.assign(network.first_weights(), network.first_weights() + shape.width * k_inputs);
  bytes.first_bias.assign(network.first_bias(), network.first_bias() + shape.width);
  bytes.first_step = clips[0] / 255.0f;
  for (uint32_t layer = 0; layer < shape.layers; ++layer)
    bytes.layers.push_back(quantise_layer(network.weights(layer), network.bias(layer), shape.width, shape.width,
                                          static_cast<double>(clips[layer]) / 255,
                                          static_cast<double>(clips[layer + 1]) / 255));
  bytes.last = quantise_layer(network.last_weights(), network.last_bias(), shape.width, 1,
                              static_cast<double>(clips[shape.layers]) / 255, 1.0);
  return bytes;
}

}  // namespace sandglass::host
