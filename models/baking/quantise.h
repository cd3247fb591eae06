// From a trained network to the file that the runtime reads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/baking/trainer.h"

namespace sandglass::host {

// A layer of bytes: byte out = round((sum of weight * byte in + bias) * multiplier).
struct ByteLayer {
  std::vector<int8_t> weights;  // all inputs of output 0 first
  std::vector<int32_t> bias;
  std::vector<float> multiplier;
};

struct ByteNetwork {
  NetworkShape shape;
  std::vector<float> first_weights, first_bias;  // the first layer stays in float: it becomes tables of 16 bits
  float first_step = 1;
  std::vector<ByteLayer> layers;
  ByteLayer last;
};

// Weights: 255 steps per output, its largest magnitude is 127. Activations: 255 steps from 0 to the layer's clip.
ByteNetwork quantise(const FloatNetwork& network, const std::vector<float>& clips);

struct ShadowFile {
  std::string name;
  LightGeometry geometry;
  ByteNetwork network;
  double rmse_float = 0, rmse_int8 = 0;
  uint32_t validated_lights = 0;
  uint64_t seed = 0;
  std::vector<float> float_parameters;  // empty: left out
};

// The bytes of the file: FlatBuffer and checksum.
std::vector<uint8_t> shadow_file_bytes(const ShadowFile& file);

// Puts the checksum behind a FlatBuffer's bytes.
void append_checksum(std::vector<uint8_t>* bytes);

}  // namespace sandglass::host
