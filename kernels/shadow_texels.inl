// A shadow network on any set of texels, in blocks of 48. Each layer is computed for the whole block before the next
// layer. At a width of 128 the activations of a block (2 x 48 x 128 bytes) and the weights of one layer (128 x 128)
// then stay in a first cache of 32 KB.

static void dense_layer(const Int8Layer& layer, uint32_t width, const uint8_t* in, uint8_t* out) {
  const Window window = {width, 1, width, 0};
  for (uint32_t panel = 0; panel < width; panel += k_channel_group)
    for (uint32_t within = 0; within < k_channel_group; within += k_tile_channels) {
      const uint32_t channel = panel + within;
      const int8_t* weights = layer.weights + panel * width + within * (k_matrix ? 8 : 4);
      for (uint32_t t = 0; t < k_texel_block; t += k_tile_texels)
        dense_tile<k_tile_texels>(in + t * width, window, weights, layer.bias + channel, layer.multiplier + channel,
                                  out + t * width + channel, width, k_tile_texels);
    }
}

// A table instead of a sigmoid. Its argument is rounded to 1/256, which changes no coverage by more than 1/8 of a
// byte's step.
static uint8_t coverage_of(const ShadowNetwork& network, int32_t sum) {
  constexpr float k_half = static_cast<float>(k_coverage_steps) / 2;
  float x = static_cast<float>(sum) * network.last_multiplier;
  x = x > -k_half ? x : -k_half;
  x = x < k_half - 1 ? x : k_half - 1;
  // Adding 1.5 * 2^23 leaves the rounded integer in the low bits.
  const uint32_t index = __builtin_bit_cast(uint32_t, x + 12582912.0f) + k_coverage_steps / 2;
  return network.coverage[index & (k_coverage_steps - 1)];
}

static void shadow_texels(const ShadowNetwork* network, const TexelRange* range) {
  const ShadowNetwork& net = *network;
  const uint32_t width = net.width;
  for (uint32_t begin = 0; begin < range->count; begin += k_texel_block) {
    uint8_t *in = range->scratch, *out = in + k_texel_block * width;
    const uint32_t last = range->count - 1;
    for (uint32_t t = 0; t < k_texel_block; ++t) {
      const uint32_t i = begin + t < last ? begin + t : last;  // repeats the last texel to fill the block
      first_layer(net.columns + uint32_t{range->u[i]} * width, net.rows + uint32_t{range->v[i]} * width, width,
                  net.shift, in + t * width);
    }
    for (uint32_t layer = 0; layer < net.layers; ++layer) {
      dense_layer(net.layer[layer], width, in, out);
      uint8_t* swap = in;
      in = out;
      out = swap;
    }
    for (uint32_t t = 0; t < k_texel_block && begin + t < range->count; ++t)
      range->coverage[begin + t] = coverage_of(net, net.last_bias + dot_row(in + t * width, net.last_weights, width));
  }
}
