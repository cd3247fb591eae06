// A shadow network on any set of texels, 48 at a time: every layer over the block before the next, so that the block's
// activations (2 x 48 x width bytes) and one layer's weights stay in the first cache.

// Where weight (channel, input) of a width x width layer is packed.
static uint32_t weight_position(uint32_t width, uint32_t channel, uint32_t input) {
  const uint32_t panel = channel / k_channel_group * k_channel_group, within = channel % k_channel_group;
  const uint32_t depth = k_matrix ? 8 : 4;  // inputs of one channel that lie together
  return panel * width + (input / depth * k_channel_group + within) * depth + input % depth;
}

static void pack_layer(const int8_t* weights, const int32_t* bias, uint32_t width, int8_t* packed,
                       int32_t* packed_bias) {
  for (uint32_t channel = 0; channel < width; ++channel) {
    int32_t sum = 0;
    for (uint32_t input = 0; input < width; ++input) {
      const int8_t weight = weights[channel * width + input];
      packed[weight_position(width, channel, input)] = weight;
      sum += weight;
    }
    packed_bias[channel] = bias[channel] + (k_signed ? 128 * sum : 0);
  }
}

#if !SANDGLASS_INT8_MATRIX

template <int i>
SANDGLASS_INT8_INLINE void accumulate(Sum (&sum)[k_tile_texels][k_tile_sums], const Activations* a,
                                      const int8_t* weights) {
  Weights w[k_tile_sums];
  for (uint32_t s = 0; s < k_tile_sums; ++s) w[s] = load_weights(weights + 4 * (i * k_channel_group + s * k_sum_lanes));
#pragma GCC unroll 16
  for (uint32_t t = 0; t < k_tile_texels; ++t) {
    const auto four = pick<i>(a[t]);
#pragma GCC unroll 16
    for (uint32_t s = 0; s < k_tile_sums; ++s) dot4(&sum[t][s], four, w[s]);
  }
}

// A tile: k_tile_texels texels, k_tile_sums * k_sum_lanes channels, all inputs.
SANDGLASS_INT8_INLINE void dense_tile(const uint8_t* in, uint32_t width, const int8_t* weights, const int32_t* bias,
                                      const float* multiplier, uint8_t* out) {
  Sum sum[k_tile_texels][k_tile_sums];
#pragma GCC unroll 16
  for (uint32_t t = 0; t < k_tile_texels; ++t)
#pragma GCC unroll 16
    for (uint32_t s = 0; s < k_tile_sums; ++s) sum[t][s] = load_bias(bias + s * k_sum_lanes);
  for (uint32_t input = 0; input < width; input += 16) {
    Activations a[k_tile_texels];
#pragma GCC unroll 16
    for (uint32_t t = 0; t < k_tile_texels; ++t) a[t] = load_activations(in + t * width + input);
    const int8_t* four = weights + input * k_channel_group;
    accumulate<0>(sum, a, four);
    accumulate<1>(sum, a, four);
    accumulate<2>(sum, a, four);
    accumulate<3>(sum, a, four);
  }
#pragma GCC unroll 16
  for (uint32_t t = 0; t < k_tile_texels; ++t) requantise(sum[t], multiplier, out + t * width);
}

#else

SANDGLASS_INT8_INLINE void dense_tile(const uint8_t* in, uint32_t width, const int8_t* weights, const int32_t* bias,
                                      const float* multiplier, uint8_t* out) {
  constexpr uint32_t k_texel_pairs = k_tile_texels / 2, k_channel_pairs = k_tile_sums * k_sum_lanes / 2;
  Pair sum[k_texel_pairs][k_channel_pairs];
#pragma GCC unroll 16
  for (uint32_t t = 0; t < k_texel_pairs; ++t)
#pragma GCC unroll 16
    for (uint32_t c = 0; c < k_channel_pairs; ++c) sum[t][c] = load_bias_pair(bias + 2 * c);
  for (uint32_t input = 0; input < width; input += 8) {
    int8x16_t a[k_texel_pairs];
#pragma GCC unroll 16
    for (uint32_t t = 0; t < k_texel_pairs; ++t)
      a[t] = load_texel_pair(in + 2 * t * width + input, in + (2 * t + 1) * width + input);
    const int8_t* eight = weights + input * k_channel_group;
#pragma GCC unroll 16
    for (uint32_t c = 0; c < k_channel_pairs; ++c) {
      const int8x16_t w = load_weight_pair(eight + 16 * c);
#pragma GCC unroll 16
      for (uint32_t t = 0; t < k_texel_pairs; ++t) sum[t][c] = multiply(sum[t][c], a[t], w);
    }
  }
#pragma GCC unroll 16
  for (uint32_t t = 0; t < k_texel_pairs; ++t) {
    Sum first[k_tile_sums], second[k_tile_sums];
#pragma GCC unroll 16
    for (uint32_t s = 0; s < k_tile_sums; ++s) {
      first[s] = first_texel(sum[t][2 * s], sum[t][2 * s + 1]);
      second[s] = second_texel(sum[t][2 * s], sum[t][2 * s + 1]);
    }
    requantise(first, multiplier, out + 2 * t * width);
    requantise(second, multiplier, out + (2 * t + 1) * width);
  }
}

#endif

static void dense_layer(const Int8Layer& layer, uint32_t width, const uint8_t* in, uint8_t* out) {
  constexpr uint32_t k_tile_channels = k_tile_sums * k_sum_lanes;
  for (uint32_t panel = 0; panel < width; panel += k_channel_group)
    for (uint32_t within = 0; within < k_channel_group; within += k_tile_channels) {
      const uint32_t channel = panel + within;
      const int8_t* weights = layer.weights + panel * width + within * (k_matrix ? 8 : 4);
      for (uint32_t t = 0; t < k_texel_block; t += k_tile_texels)
        dense_tile(in + t * width, width, weights, layer.bias + channel, layer.multiplier + channel,
                   out + t * width + channel);
    }
}

// A table instead of a sigmoid: its argument is rounded to 1/256, which moves no byte by more than 1/8 of a step.
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
      const uint32_t i = begin + t < last ? begin + t : last;  // the last texel again fills the block
      first_layer(net.columns + uint32_t{range->u[i]} * width, net.rows + uint32_t{range->v[i]} * width, width,
                  net.shift, in + t * width);
    }
    for (uint32_t layer = 0; layer < net.layers; ++layer) {
      dense_layer(net.layer[layer], width, in, out);
      uint8_t* swap = in;
      in = out, out = swap;
    }
    for (uint32_t t = 0; t < k_texel_block && begin + t < range->count; ++t)
      range->coverage[begin + t] = coverage_of(net, net.last_bias + dot_row(in + t * width, net.last_weights, width));
  }
}

extern const Int8Kernels k_table;
const Int8Kernels k_table = {SANDGLASS_INT8_ISA, pack_layer, shadow_texels};
