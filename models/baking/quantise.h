// Turns a trained network into the file that the runtime reads: rounds it to bytes and writes the FlatBuffer.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/baking/ambient.h"
#include "models/baking/surface.h"
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

struct ShadowFile {
  std::string name;
  LightGeometry geometry;
  ByteNetwork network;
  double rmse_float = 0, rmse_int8 = 0;
  uint32_t validated_lights = 0;
  uint64_t seed = 0;
  std::vector<float> float_parameters;  // empty: the file holds none
  AmbientPart ambient = {};
  SurfacePart surface = {};
};

// The bytes of the file: a FlatBuffer, then its checksum.
std::vector<uint8_t> shadow_file_bytes(const ShadowFile& file);

// Appends the checksum to a FlatBuffer's bytes.
void append_checksum(std::vector<uint8_t>* bytes);

}  // namespace sandglass::host
