// The lighting network's file in memory. Quantisation fills it, and it becomes the bytes of asset/light.fbs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sandglass::host {

struct ByteConvolution {
  std::vector<int8_t> weights;  // output, row, column, input
  std::vector<int32_t> bias;
  std::vector<float> multiplier;
  std::vector<uint8_t> low, high;  // clamps of the inputs; empty if they are not clamped
};

struct LightFile {
  std::string name;
  uint8_t border[3] = {};
  ByteConvolution stem;
  std::vector<ByteConvolution> narrow, wide;  // 58 each
  std::vector<ByteConvolution> transition;    // 3
  std::vector<uint8_t> last_low, last_high;
  std::vector<float> feature_scale, feature_shift;
  std::vector<int8_t> latent_weights;
  std::vector<float> latent_scale, latent_bias, heads_weights, heads_bias;
  uint64_t data_hash = 0, seed = 0;
  uint32_t training_images = 0, calibration_images = 0;
  float angle_deg = 0, difference = 0;
  std::vector<float> float_parameters;  // if empty, the file has none
};

// The FlatBuffer with its checksum: a file for open_light_asset.
std::vector<uint8_t> light_file_bytes(const LightFile& file);

// A valid network with random weights from the seed, for tests. Its outputs depend on the image.
LightFile random_light_file(uint64_t seed);

}  // namespace sandglass::host
