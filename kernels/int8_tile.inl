// The inner loop of every int8 kernel: a tile of texels x channels, summed over the inputs of a window. Registers hold
// the sums, while activations and weights stream by.

static_assert(k_tile_slack % k_row_texels == 0);

// The inputs of one texel: rows of neighbouring bytes.
struct Window {
  uint32_t stride;     // bytes from texel to texel
  uint32_t rows;       // rows of the window
  uint32_t row_bytes;  // bytes of a row, a multiple of 16
  uint32_t row_pitch;  // bytes from row to row
};

constexpr uint32_t k_tile_channels = k_tile_sums * k_sum_lanes;
constexpr uint32_t k_pack_depth = k_matrix ? 8 : 4;  // inputs of one channel that lie together

// Where the weight of (channel, input) lies in the packed matrix.
static uint32_t weight_position(uint32_t inputs, uint32_t channel, uint32_t input) {
  const uint32_t panel = channel / k_channel_group * k_channel_group, within = channel % k_channel_group;
  return panel * inputs + (input / k_pack_depth * k_channel_group + within) * k_pack_depth + input % k_pack_depth;
}

static void pack_layer(const int8_t* weights, const int32_t* bias, uint32_t outputs, uint32_t inputs, int8_t* packed,
                       int32_t* packed_bias) {
  for (uint32_t channel = 0; channel < outputs; ++channel) {
    int32_t sum = 0;
    for (uint32_t input = 0; input < inputs; ++input) {
      const int8_t weight = weights[channel * inputs + input];
      packed[weight_position(inputs, channel, input)] = weight;
      sum += weight;
    }
    packed_bias[channel] = bias[channel] + (k_signed ? 128 * sum : 0);
  }
}

#if !SANDGLASS_INT8_MATRIX

template <int i, uint32_t k_texels>
SANDGLASS_INT8_INLINE void accumulate(Sum (&sum)[k_texels][k_tile_sums], const Activations* a, const int8_t* weights) {
  Weights w[k_tile_sums];
  for (uint32_t s = 0; s < k_tile_sums; ++s) w[s] = load_weights(weights + 4 * (i * k_channel_group + s * k_sum_lanes));
#pragma GCC unroll 16
  for (uint32_t t = 0; t < k_texels; ++t) {
    const auto four = pick<i>(a[t]);
#pragma GCC unroll 16
    for (uint32_t s = 0; s < k_tile_sums; ++s) dot4(&sum[t][s], four, w[s]);
  }
}

// Sums k_texels texels x k_tile_channels channels over all inputs, and writes the first `count` texels.
template <uint32_t k_texels>
SANDGLASS_INT8_INLINE void dense_tile(const uint8_t* in, const Window& window, const int8_t* weights,
                                      const int32_t* bias, const float* multiplier, uint8_t* out, uint32_t out_stride,
                                      uint32_t count) {
  Sum sum[k_texels][k_tile_sums];
#pragma GCC unroll 16
  for (uint32_t t = 0; t < k_texels; ++t)
#pragma GCC unroll 16
    for (uint32_t s = 0; s < k_tile_sums; ++s) sum[t][s] = load_bias(bias + s * k_sum_lanes);
  for (uint32_t row = 0; row < window.rows; ++row, in += window.row_pitch)
    for (uint32_t input = 0; input < window.row_bytes; input += 16, weights += 16 * k_channel_group) {
      Activations a[k_texels];
#pragma GCC unroll 16
      for (uint32_t t = 0; t < k_texels; ++t) a[t] = load_activations(in + t * window.stride + input);
      accumulate<0>(sum, a, weights);
      accumulate<1>(sum, a, weights);
      accumulate<2>(sum, a, weights);
      accumulate<3>(sum, a, weights);
    }
#pragma GCC unroll 16
  for (uint32_t t = 0; t < k_texels; ++t)
    if (t < count) requantise(sum[t], multiplier, out + t * out_stride);
}

#else

template <uint32_t k_texels>
SANDGLASS_INT8_INLINE void dense_tile(const uint8_t* in, const Window& window, const int8_t* weights,
                                      const int32_t* bias, const float* multiplier, uint8_t* out, uint32_t out_stride,
                                      uint32_t count) {
  constexpr uint32_t k_texel_pairs = k_texels / 2, k_channel_pairs = k_tile_channels / 2;
  Pair sum[k_texel_pairs][k_channel_pairs];
#pragma GCC unroll 16
  for (uint32_t t = 0; t < k_texel_pairs; ++t)
#pragma GCC unroll 16
    for (uint32_t c = 0; c < k_channel_pairs; ++c) sum[t][c] = load_bias_pair(bias + 2 * c);
  for (uint32_t row = 0; row < window.rows; ++row, in += window.row_pitch)
    for (uint32_t input = 0; input < window.row_bytes; input += 8, weights += 8 * k_channel_group) {
      int8x16_t a[k_texel_pairs];
#pragma GCC unroll 16
      for (uint32_t t = 0; t < k_texel_pairs; ++t)
        a[t] = load_texel_pair(in + 2 * t * window.stride + input, in + (2 * t + 1) * window.stride + input);
#pragma GCC unroll 16
      for (uint32_t c = 0; c < k_channel_pairs; ++c) {
        const int8x16_t w = load_weight_pair(weights + 16 * c);
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
    if (2 * t < count) requantise(first, multiplier, out + 2 * t * out_stride);
    if (2 * t + 1 < count) requantise(second, multiplier, out + (2 * t + 1) * out_stride);
  }
}

#endif
