// Rounds a trained network to the bytes that the runtime computes with.
#pragma once

#include <cstdint>
#include <vector>

#include "models/baking/trainer.h"

namespace sandglass::host {

// A layer in bytes: byte out = round((sum of weight * byte in + bias) * multiplier).
struct ByteLayer {
  std::vector<int8_t> weights;  // all inputs of output 0 first
  std::vector<int32_t> bias;
  std::vector<float> multiplier;
};

struct ByteNetwork {
  NetworkShape shape;
  // The first layer stays in float here. The runtime turns it into tables of 16 bits.
  std::vector<float> first_weights, first_bias;
  float first_step = 1;
  std::vector<ByteLayer> layers;
  ByteLayer last;
};

// Weights become -127..127; the largest magnitude of each output becomes 127. Activations become 0..255, from 0 to the
// layer's clip.
ByteNetwork quantise(const FloatNetwork& network, const std::vector<float>& clips);

}  // namespace sandglass::host
