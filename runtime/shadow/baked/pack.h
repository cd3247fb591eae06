// A baked network in the form that the kernels run: weights packed for this CPU, the first layer as tables, the sigmoid
// as a table (pack.cpp).
#pragma once

#include "runtime/asset/shadow_asset.h"
#include "runtime/shadow/baked/shadow.h"

namespace sandglass {

// Where the packed network goes, as the layout hands it out.
struct PackedShadow {
  int8_t* weights[k_shadow_layers_limit];
  int32_t* bias[k_shadow_layers_limit];
  float* multiplier[k_shadow_layers_limit];
  int8_t* last_weights;
  uint8_t* coverage;
  float *light_weights, *first_bias;
};

// The width of a network with whole groups of channels.
inline uint32_t shadow_padded_width(uint32_t width) {
  return (width + k_channel_group - 1) / k_channel_group * k_channel_group;
}

// Fills the tables and packs the weights. The network's width, its layers and the kernels must be set.
void pack_shadow_network(const ShadowAsset& asset, const PackedShadow& packed, Shadow* shadow);

}  // namespace sandglass
