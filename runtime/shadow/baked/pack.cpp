// See pack.h. The first layer has no weights at run time: its inputs are the encoded coordinates of a texel and of the
// light, so its sums are those of a column, a row and the light, and the first two are tables.
#include "runtime/shadow/baked/pack.h"

#include <cstring>

#include "kernels/whole.h"
#include "runtime/math/math.h"

namespace sandglass {
namespace {

constexpr uint32_t k_shift_limit = 6;  // steps finer than 1/64 of a byte's change nothing
constexpr double k_table_limit = 32000;

// One row of a table, in double and in units of activation: the encoded texel coordinate times its weights.
void table_row(const float* weights, uint32_t width, uint32_t frequencies, uint32_t index, double* sums) {
  const double x = texel_centre(index, k_shadow_size);
  for (uint32_t c = 0; c < width; ++c) sums[c] = x * static_cast<double>(weights[c]);
  double turns = 0.5 * x;
  for (uint32_t k = 0; k < frequencies; ++k, turns *= 2) {
    const SinCos wave = sin_cos_turns(turns);
    const float *sine = weights + (1 + 2 * k) * width, *cosine = sine + width;
    for (uint32_t c = 0; c < width; ++c)
      sums[c] += wave.sin * static_cast<double>(sine[c]) + wave.cos * static_cast<double>(cosine[c]);
  }
}

int16_t table_entry(double x) {
  x = x < -32767 ? -32767 : x > 32767 ? 32767 : x;
  return static_cast<int16_t>(floor_index(x + 0.5));
}

// The finest shift at which the table entries of every channel fit 16 bits, whatever the texel and the light. Out of
// line, so that its arrays do not lie on the stack beside those of fill_tables.
__attribute__((noinline)) uint32_t choose_shift(const ShadowAsset& asset) {
  double sums[k_shadow_width_limit], column_max[k_shadow_width_limit] = {}, row_max[k_shadow_width_limit] = {};
  const uint32_t width = asset.width;
  const float* row_weights = asset.first_weights + asset.texel_inputs() * width;
  for (uint32_t i = 0; i < k_table_rows; ++i) {
    table_row(asset.first_weights, width, asset.texel_frequencies, i, sums);
    for (uint32_t c = 0; c < width; ++c)
      column_max[c] = absolute(sums[c]) > column_max[c] ? absolute(sums[c]) : column_max[c];
    table_row(row_weights, width, asset.texel_frequencies, i, sums);
    for (uint32_t c = 0; c < width; ++c) row_max[c] = absolute(sums[c]) > row_max[c] ? absolute(sums[c]) : row_max[c];
  }
  const float* light_weights = row_weights + asset.texel_inputs() * width;
  double largest = 0;
  for (uint32_t c = 0; c < width; ++c) {
    double sum = column_max[c] + row_max[c] + absolute(static_cast<double>(asset.first_bias[c]));
    for (uint32_t i = 0; i < 3 * asset.light_inputs(); ++i)
      sum += absolute(static_cast<double>(light_weights[i * width + c]));
    largest = sum > largest ? sum : largest;
  }
  uint32_t shift = k_shift_limit;
  while (shift > 0 &&
         largest * static_cast<double>(1u << shift) > k_table_limit * static_cast<double>(asset.first_step))
    --shift;
  return shift;
}

__attribute__((noinline)) void fill_tables(const ShadowAsset& asset, Shadow* s, const PackedShadow& packed) {
  const uint32_t own = asset.width, width = s->network.width;
  s->table_scale = static_cast<double>(1u << s->network.shift) / static_cast<double>(asset.first_step);
  double sums[k_shadow_width_limit];
  for (uint32_t part = 0; part < 2; ++part) {
    int16_t* table = part == 0 ? s->columns : s->row_base;
    const float* weights = asset.first_weights + part * asset.texel_inputs() * own;
    for (uint32_t i = 0; i < k_table_rows; ++i) {
      table_row(weights, own, asset.texel_frequencies, i, sums);
      for (uint32_t c = 0; c < width; ++c)
        table[i * width + c] = c < own ? table_entry(sums[c] * s->table_scale) : int16_t{0};
    }
  }
  const float* light = asset.first_weights + 2 * asset.texel_inputs() * own;
  for (uint32_t i = 0; i < 3 * asset.light_inputs(); ++i)
    for (uint32_t c = 0; c < width; ++c) packed.light_weights[i * width + c] = c < own ? light[i * own + c] : 0.0f;
  for (uint32_t c = 0; c < width; ++c) packed.first_bias[c] = c < own ? asset.first_bias[c] : 0.0f;
}

// Packs the weights for this CPU. Each row first grows to the padded width; the memory of `rows`, which is free until
// the first texture, serves as scratch.
void pack_layers(const ShadowAsset& asset, Shadow* s, const PackedShadow& packed) {
  const uint32_t own = asset.width, width = s->network.width;
  static_assert(k_table_rows * sizeof(int16_t) > k_shadow_width_limit + sizeof(int32_t));
  int8_t* grown = reinterpret_cast<int8_t*>(s->rows);
  int32_t* grown_bias = reinterpret_cast<int32_t*>(grown + width * width);
  for (uint32_t i = 0; i < asset.layers; ++i) {
    memset(grown, 0, width * width);
    memset(grown_bias, 0, width * sizeof *grown_bias);
    for (uint32_t c = 0; c < width; ++c) packed.multiplier[i][c] = 0;
    for (uint32_t c = 0; c < own; ++c) {
      memcpy(grown + c * width, asset.layer[i].weights + c * own, own);
      grown_bias[c] = asset.layer[i].bias[c];
      packed.multiplier[i][c] = asset.layer[i].multiplier[c];
    }
    s->kernels->pack_layer(grown, grown_bias, width, width, packed.weights[i], packed.bias[i]);
    s->network.layer[i] = {packed.weights[i], packed.bias[i], packed.multiplier[i]};
  }
  memset(packed.last_weights, 0, width);
  memcpy(packed.last_weights, asset.last.weights, own);
}

// Coverage is 1 - sigmoid(x) = 1/(1 + e^x) at x = (i - half)/256. The powers of e^(1/256) come from repeated
// multiplication, from the middle outward; each is correct to 1e-12.
void fill_coverage(uint8_t* coverage) {
  constexpr double k_factor = 1.0039138893383475;  // e^(1/256)
  constexpr uint32_t k_half = k_coverage_steps / 2;
  double power = 1;
  for (uint32_t i = 0; i <= k_half; ++i, power *= k_factor) {
    const double share = 1 / (1 + power);
    if (i < k_half) coverage[k_half + i] = to_whole<uint8_t>(255 * share + 0.5);
    coverage[k_half - i] = to_whole<uint8_t>(255 * (1 - share) + 0.5);
  }
}

}  // namespace

void pack_shadow_network(const ShadowAsset& asset, const PackedShadow& packed, Shadow* shadow) {
  shadow->network.shift = choose_shift(asset);
  fill_tables(asset, shadow, packed);
  pack_layers(asset, shadow, packed);
  fill_coverage(packed.coverage);
}

}  // namespace sandglass
