// A lighting network's file as the runtime sees it: checked from the first byte to the last, then pointers into the
// app's bytes. Only light_asset.cpp knows FlatBuffers.
#pragma once

#include <cstdint>

#include "sandglass/sandglass.h"

namespace sandglass {

constexpr uint32_t k_light_asset_version = 1;
constexpr uint32_t k_dense_blocks = 4, k_transition_count = 3;
constexpr uint32_t k_block_layers[k_dense_blocks] = {6, 12, 24, 16};
constexpr uint32_t k_dense_layer_count = 58;
constexpr uint32_t k_light_stem = 64, k_light_growth = 32, k_light_bottleneck = 128;  // channels
constexpr uint32_t k_light_features = 1024, k_light_latent = 512, k_light_heads = 10;
constexpr uint32_t k_stem_size = 7;  // pixels a side

struct AssetConvolution {
  const int8_t* weights;
  const int32_t* bias;
  const float* multiplier;
  const uint8_t *low, *high;  // null: inputs are not clamped
};

struct LightAsset {
  const char* name;
  uint8_t border[3];
  AssetConvolution stem;
  AssetConvolution narrow[k_dense_layer_count], wide[k_dense_layer_count];
  AssetConvolution transition[k_transition_count];
  const uint8_t *last_low, *last_high;
  const float *feature_scale, *feature_shift;
  const int8_t* latent_weights;
  const float *latent_scale, *latent_bias;
  const float *heads_weights, *heads_bias;
  uint64_t data_hash, seed;
  uint32_t training_images, calibration_images;
  float angle_deg, difference;
  const float* float_parameters;  // null: the file has none; see light.fbs
};

// Channels that the first layer of a block reads, and channels that its last layer leaves.
constexpr uint32_t light_channels_before(uint32_t block) {
  uint32_t channels = k_light_stem;
  for (uint32_t b = 0; b < block; ++b) channels = (channels + k_light_growth * k_block_layers[b]) / 2;
  return channels;
}
constexpr uint32_t light_channels_after(uint32_t block) {
  return light_channels_before(block) + k_light_growth * k_block_layers[block];
}

// How many numbers the network has in float: clamps, weights and biases, and what light.fbs lists before and after
// them.
constexpr uint32_t light_float_parameters() {
  uint32_t count = 3 + (3 * k_stem_size * k_stem_size + 1) * k_light_stem;
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    uint32_t channels = light_channels_before(b);
    for (uint32_t i = 0; i < k_block_layers[b]; ++i, channels += k_light_growth)
      count += 2 * channels + (channels + 1) * k_light_bottleneck + (9 * k_light_bottleneck + 1) * k_light_growth;
    if (b < k_transition_count) count += 2 * channels + (channels + 1) * channels / 2;
  }
  return count + 4 * k_light_features + (k_light_features + 1) * k_light_latent;
}
constexpr uint32_t k_light_float_parameters = light_float_parameters();
constexpr float k_light_float_limit = 1e9f;  // greatest size of each number; a clamp at the limit does not clamp

// `bytes` is aligned to 8. Refuses, with one sentence, everything but a whole, undamaged file of this version whose
// numbers the kernels can run on blindly.
sandglass_status open_light_asset(const void* bytes, uint64_t count, LightAsset* asset, const char** reason);

}  // namespace sandglass
