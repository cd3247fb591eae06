#include "runtime/light/network/network.h"

#include <cstring>

#include "platform/check.h"
#include "runtime/light/network/heads.h"

namespace sandglass {
namespace {

constexpr uint32_t k_bottleneck_border = 1;  // pixels of zeros

// The size of a block's feature maps. The stem, the pool and every transition halve the image.
uint32_t block_side(uint32_t image_side, uint32_t block) { return image_side >> (2 + block); }

uint64_t block_bytes(uint32_t width, uint32_t height, uint32_t block) {
  return uint64_t{block_side(width, block)} * block_side(height, block) * light_channels_after(block);
}

uint64_t bottleneck_bytes(uint32_t width, uint32_t height) {
  const uint64_t columns = block_side(width, 0) + 2 * k_bottleneck_border;
  const uint64_t rows = block_side(height, 0) + 2 * k_bottleneck_border;
  return (columns * rows + k_tile_slack) * k_light_bottleneck;
}

uint64_t larger(uint64_t a, uint64_t b) { return a > b ? a : b; }

uint64_t even_bytes(uint32_t width, uint32_t height) {
  return larger(block_bytes(width, height, 0), block_bytes(width, height, 2));
}

uint64_t odd_bytes(uint32_t width, uint32_t height) {
  return larger(block_bytes(width, height, 1), block_bytes(width, height, 3));
}

uint64_t stem_bytes(uint32_t width, uint32_t height) { return uint64_t{width / 2} * (height / 2) * k_stem_outputs; }

uint64_t shared_bytes(uint32_t width, uint32_t height) {
  return larger(stem_bytes(width, height), odd_bytes(width, height) + bottleneck_bytes(width, height));
}

constexpr uint64_t k_stem_weights = uint64_t{k_stem_outputs} * k_stem_bytes;

// Packed weights and biases of all convolutions.
struct Sizes {
  uint64_t weights, biases;
};
constexpr Sizes packed_sizes() {
  Sizes sizes = {k_stem_weights, k_stem_outputs};
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    uint32_t channels = light_channels_before(b);
    for (uint32_t i = 0; i < k_block_layers[b]; ++i, channels += k_light_growth) {
      sizes.weights += uint64_t{channels} * k_light_bottleneck + uint64_t{9 * k_light_bottleneck} * k_light_growth;
      sizes.biases += k_light_bottleneck + k_light_growth;
    }
    if (b == k_transition_count) continue;
    sizes.weights += uint64_t{channels} * channels / 2;
    sizes.biases += channels / 2;
  }
  return sizes;
}

void add_operator(LightNetwork* net, uint32_t* count, LightOperator op) {
  const uint64_t rows = k_light_unit_macs / op.row_macs;
  const uint32_t unit_rows = static_cast<uint32_t>(rows < 1 ? 1 : rows > op.rows ? op.rows : rows);
  uint32_t units = (op.rows + unit_rows - 1) / unit_rows;
  while (net->backend != nullptr && op.rows % units != 0) ++units;  // all of one size
  op.unit_rows = (op.rows + units - 1) / units;                     // alike in size
  op.first_unit = net->units;
  net->units += (op.rows + op.unit_rows - 1) / op.unit_rows;
  net->operators[(*count)++] = op;
}

void list_operators(LightNetwork* net) {
  uint32_t count = 0, layer = 0;
  uint64_t pixels = net->width / 2;  // of an output row
  add_operator(net, &count,
               {k_light_kind_stem, 0, 0, 3, net->height / 2, 0, 0, pixels * k_stem_bytes * k_stem_outputs});
  add_operator(net, &count,
               {k_light_kind_pool, 0, 0, k_stem_outputs, net->height / 4, 0, 0, pixels / 2 * 9 * k_stem_outputs});
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    const uint32_t rows = block_side(net->height, b);
    pixels = block_side(net->width, b);
    uint32_t channels = light_channels_before(b);
    for (uint32_t i = 0; i < k_block_layers[b]; ++i, ++layer, channels += k_light_growth) {
      add_operator(net, &count,
                   {k_light_kind_narrow, b, layer, channels, rows, 0, 0, pixels * channels * k_light_bottleneck});
      add_operator(
          net, &count,
          {k_light_kind_wide, b, layer, channels, rows, 0, 0, pixels * 9 * k_light_bottleneck * k_light_growth});
    }
    if (b == k_transition_count) continue;
    add_operator(net, &count,
                 {k_light_kind_transition, b, layer, channels, rows / 2, 0, 0, pixels / 2 * channels * channels / 2});
  }
  add_operator(net, &count,
               {k_light_kind_head, 0, layer, k_light_features, 1, 0, 0, uint64_t{k_light_features} * k_light_latent});
}

uint8_t* block_of(const LightNetwork& net, uint32_t block) { return block % 2 == 0 ? net.even : net.odd; }

// The two sides of an operator's weights: values of its window, and outputs. The pool has none.
struct Shape {
  uint32_t places, outputs;
};
Shape shape_of(const LightOperator& op) {
  switch (op.kind) {
    case k_light_kind_stem:
      return {3 * k_stem_size * k_stem_size, k_light_stem};
    case k_light_kind_pool:
      return {0, 0};
    case k_light_kind_narrow:
      return {op.inputs, k_light_bottleneck};
    case k_light_kind_wide:
      return {9 * k_light_bottleneck, k_light_growth};
    case k_light_kind_transition:
      return {op.inputs, op.inputs / 2};
    default:
      return {op.inputs, k_light_latent};
  }
}

const LightOperator& operator_of(const LightNetwork& net, uint32_t unit) {
  uint32_t low = 0, high = k_light_operators;  // the last one that does not begin after the unit
  while (high - low > 1) {
    const uint32_t middle = (low + high) / 2;
    if (net.operators[middle].first_unit <= unit) low = middle;
    else high = middle;
  }
  return net.operators[low];
}

uint32_t first_row(const LightOperator& op, uint32_t unit) { return (unit - op.first_unit) * op.unit_rows; }

uint32_t row_count(const LightOperator& op, uint32_t unit) {
  const uint32_t left = op.rows - first_row(op, unit);
  return left < op.unit_rows ? left : op.unit_rows;
}

void run_stem(const LightNetwork& net, uint32_t y) {
  net.kernels->stem(&net.stem, net.rgb, net.asset.border, net.width, net.height, y,
                    net.stem_rows + uint64_t{y} * (net.width / 2) * k_stem_outputs);
}

void run_pool(const LightNetwork& net, uint32_t y) {
  const uint32_t stride = light_channels_after(0);
  net.kernels->pool(net.stem_rows, net.width / 2, net.height / 2, y, net.even + uint64_t{y} * (net.width / 4) * stride,
                    stride);
}

// The bottleneck has a border of zeros. The rows that touch it write it.
void run_narrow(const LightNetwork& net, const LightOperator& op, uint32_t y) {
  const uint32_t width = block_side(net.width, op.block), stride = light_channels_after(op.block);
  const uint32_t pitch = (width + 2 * k_bottleneck_border) * k_light_bottleneck;
  uint8_t* row = net.bottleneck + uint64_t{y + k_bottleneck_border} * pitch;
  if (y == 0) memset(row - pitch, 0, pitch);
  if (y + 1 == op.rows) memset(row + pitch, 0, pitch + k_tile_slack * k_light_bottleneck);
  memset(row, 0, k_light_bottleneck);
  memset(row + pitch - k_light_bottleneck, 0, k_light_bottleneck);
  const PixelRow pixels = {block_of(net, op.block) + uint64_t{y} * width * stride,
                           stride,
                           0,
                           width,
                           row + k_bottleneck_border * k_light_bottleneck,
                           k_light_bottleneck};
  net.kernels->narrow(&net.narrow[op.layer], &pixels);
}

void run_wide(const LightNetwork& net, const LightOperator& op, uint32_t y) {
  const uint32_t width = block_side(net.width, op.block), stride = light_channels_after(op.block);
  const uint32_t pitch = (width + 2 * k_bottleneck_border) * k_light_bottleneck;
  const PixelRow pixels = {net.bottleneck + uint64_t{y} * pitch,
                           k_light_bottleneck,
                           pitch,
                           width,
                           block_of(net, op.block) + uint64_t{y} * width * stride + op.inputs,
                           stride};
  net.kernels->wide(&net.wide[op.layer], &pixels);
}

void run_transition(const LightNetwork& net, const LightOperator& op, uint32_t y) {
  const uint32_t width = block_side(net.width, op.block), to = op.block + 1;
  const PixelRow pixels = {block_of(net, op.block) + uint64_t{2 * y} * width * op.inputs,
                           op.inputs,
                           width * op.inputs,
                           width / 2,
                           block_of(net, to) + uint64_t{y} * (width / 2) * light_channels_after(to),
                           light_channels_after(to)};
  net.kernels->transition(&net.transition[op.block], &pixels);
}

void run_rows(const LightNetwork& net, const LightOperator& op, uint32_t first, uint32_t count) {
  for (uint32_t y = first; y < first + count; ++y) switch (op.kind) {
      case k_light_kind_stem:
        run_stem(net, y);
        break;
      case k_light_kind_pool:
        run_pool(net, y);
        break;
      case k_light_kind_narrow:
        run_narrow(net, op, y);
        break;
      case k_light_kind_wide:
        run_wide(net, op, y);
        break;
      default:
        run_transition(net, op, y);
    }
}

// Averages of all pixels in steps of 1/256 byte, as high and low bytes: two exact products of bytes then make one of 16
// bits. Out of line, so that its sums do not lie on the stack beside those of a kernel.
__attribute__((noinline)) void average_features(LightNetwork* net) {
  const uint32_t pixels = block_side(net->width, 3) * block_side(net->height, 3);
  SANDGLASS_CHECK(pixels > 0);
  const uint8_t* in = block_of(*net, 3);
  const uint8_t *low = net->asset.last_low, *high = net->asset.last_high;
  uint16_t sums[k_light_features] = {};  // of at most 64 pixels
  for (uint32_t p = 0; p < pixels; ++p, in += k_light_features)
    for (uint32_t c = 0; c < k_light_features; ++c) {
      const uint8_t above = in[c] > low[c] ? in[c] : low[c];
      sums[c] = static_cast<uint16_t>(sums[c] + (above < high[c] ? above : high[c]));
    }
  for (uint32_t c = 0; c < k_light_features; ++c) {
    const uint32_t average = (256 * sums[c] + pixels / 2) / pixels;
    net->pooled_high[c] = static_cast<uint8_t>(average >> 8);
    net->pooled_low[c] = static_cast<uint8_t>(average);
  }
}

void run_latent(const LightNetwork& net, double* latent) {
  for (uint32_t i = 0; i < k_light_latent; ++i) {
    const int8_t* weights = net.latent + i * k_light_features;
    const int64_t sum = int64_t{256} * net.kernels->dot(net.pooled_high, weights, k_light_features) +
                        net.kernels->dot(net.pooled_low, weights, k_light_features);
    latent[i] = elu(static_cast<double>(sum) / 256 * static_cast<double>(net.asset.latent_scale[i]) +
                    static_cast<double>(net.asset.latent_bias[i]));
  }
}

// Outputs side by side make vectors. Four features at a time, so that sums are loaded and stored a quarter as often.
void run_float_latent(const LightNetwork& net, double* latent, float* __restrict sums) {
  const LightFloats floats = light_floats(net, net.operators[k_light_operators - 1]);
  memcpy(sums, floats.bias, k_light_latent * sizeof(float));
  const float* __restrict weights = floats.weights;
  for (uint32_t c = 0; c < k_light_features; c += 4, weights += 4 * k_light_latent)
    for (uint32_t i = 0; i < k_light_latent; ++i)
      sums[i] += (net.features[c] * weights[i] + net.features[c + 1] * weights[k_light_latent + i]) +
                 (net.features[c + 2] * weights[2 * k_light_latent + i] +
                  net.features[c + 3] * weights[3 * k_light_latent + i]);
  for (uint32_t i = 0; i < k_light_latent; ++i) latent[i] = elu(static_cast<double>(sums[i]));
}

// `latent` is scratch for twice k_light_latent: the stack is small.
void run_head(LightNetwork* net, double* latent) {
  if (net->features == nullptr) run_latent(*net, latent);
  else run_float_latent(*net, latent, reinterpret_cast<float*>(latent + k_light_latent));
  double heads[k_light_heads];
  for (uint32_t i = 0; i < k_light_heads; ++i) {
    heads[i] = static_cast<double>(net->asset.heads_bias[i]);
    for (uint32_t k = 0; k < k_light_latent; ++k)
      heads[i] += static_cast<double>(net->asset.heads_weights[i * k_light_latent + k]) * latent[k];
  }
  net->outputs = light_outputs_of(heads);
}

Int8Convolution pack(const AssetConvolution& file, uint32_t inputs, uint32_t window, uint32_t outputs,
                     const Int8Kernels* kernels, int8_t** weights, int32_t** biases) {
  const Int8Convolution convolution = {*weights, *biases, file.multiplier, file.low, file.high, inputs, outputs};
  kernels->pack_layer(file.weights, file.bias, outputs, window * inputs, *weights, *biases);
  *weights += uint64_t{outputs} * window * inputs;
  *biases += outputs;
  return convolution;
}

void create_own(LightNetwork* net, const LightMemory& memory) {
  const LightAsset& asset = net->asset;
  const Int8Kernels* kernels = net->kernels;
  int8_t* weights = memory.weights;
  int32_t* biases = memory.biases;

  // The stem's 147 inputs grow to k_stem_bytes, in memory that activations use later.
  constexpr uint32_t k_stem_inputs = 3 * k_stem_window * k_stem_window;
  int8_t* grown = reinterpret_cast<int8_t*>(memory.even);
  memset(grown, 0, k_stem_weights);
  for (uint32_t i = 0; i < k_stem_outputs; ++i)
    memcpy(grown + i * k_stem_bytes, asset.stem.weights + i * k_stem_inputs, k_stem_inputs);
  AssetConvolution stem = asset.stem;
  stem.weights = grown;
  net->stem = pack(stem, k_stem_bytes, 1, k_stem_outputs, kernels, &weights, &biases);

  uint32_t layer = 0;
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    uint32_t channels = light_channels_before(b);
    for (uint32_t i = 0; i < k_block_layers[b]; ++i, ++layer, channels += k_light_growth) {
      net->narrow[layer] = pack(asset.narrow[layer], channels, 1, k_light_bottleneck, kernels, &weights, &biases);
      net->wide[layer] = pack(asset.wide[layer], k_light_bottleneck, 9, k_light_growth, kernels, &weights, &biases);
    }
    if (b == k_transition_count) continue;
    net->transition[b] = pack(asset.transition[b], channels, 1, channels / 2, kernels, &weights, &biases);
  }
  net->even = memory.even;
  net->stem_rows = net->odd = memory.shared;
  net->bottleneck = memory.shared + odd_bytes(net->width, net->height);
  memset(memory.even, 0, even_bytes(net->width, net->height));
  memset(memory.shared, 0, shared_bytes(net->width, net->height));
}

}  // namespace

LightMemory layout_light_network(uint32_t width, uint32_t height, Layout* layout, const LightBackend* backend) {
  SANDGLASS_CHECK(width >= k_light_side_step && width <= k_light_side_limit && width % k_light_side_step == 0);
  SANDGLASS_CHECK(height >= k_light_side_step && height <= k_light_side_limit && height % k_light_side_step == 0);
  constexpr Sizes k_sizes = packed_sizes();
  LightMemory memory = {};
  memory.network = layout_region<LightNetwork>(layout, "light.state", 1);
  memory.latent = layout_region<int8_t>(layout, "light.latent", uint64_t{k_light_latent} * k_light_features);
  memory.pooled = layout_region<uint8_t>(layout, "light.pooled", 2 * k_light_features);
  if (backend != nullptr) {
    backend->lay_out(width, height, layout, &memory);
    return memory;
  }
  memory.weights = layout_region<int8_t>(layout, "light.weights", k_sizes.weights);
  memory.biases = layout_region<int32_t>(layout, "light.biases", k_sizes.biases);
  memory.even = layout_region<uint8_t>(layout, "light.even", even_bytes(width, height));
  memory.shared = layout_region<uint8_t>(layout, "light.shared", shared_bytes(width, height));
  return memory;
}

uint64_t light_activation_bytes(uint32_t width, uint32_t height) {
  return even_bytes(width, height) + shared_bytes(width, height) + 2 * k_light_features;
}

LightNetwork* create_light_network(const LightAsset& asset, const Int8Kernels* kernels, const LightBackend* backend,
                                   uint32_t width, uint32_t height, const LightMemory& memory, const char** reason) {
  LightNetwork* net = memory.network;
  *net = {};
  net->backend = backend;
  net->kernels = kernels;
  net->asset = asset;
  net->width = width;
  net->height = height;
  if (backend == nullptr || !backend->in_float) net->asset.float_parameters = nullptr;
  if (net->asset.float_parameters == nullptr) {
    memcpy(memory.latent, asset.latent_weights, uint64_t{k_light_latent} * k_light_features);
    net->latent = memory.latent;
  } else {
    net->features = reinterpret_cast<float*>(memory.latent);
    memset(net->features, 0, k_light_features * sizeof(float));
  }
  net->pooled_high = memory.pooled;
  net->pooled_low = memory.pooled + k_light_features;
  list_operators(net);
  if (backend != nullptr) return backend->create(net, memory, reason) ? net : nullptr;
  create_own(net, memory);
  return net;
}

LightNetwork* create_light_network(const LightAsset& asset, const Int8Kernels* kernels, uint32_t width, uint32_t height,
                                   const LightMemory& memory) {
  return create_light_network(asset, kernels, nullptr, width, height, memory, nullptr);
}

void release_light_network(LightNetwork* network) {
  if (network->backend != nullptr) network->backend->release(network);
}

void begin_light_network(LightNetwork* network, const uint8_t* rgb) { network->rgb = rgb; }

void run_light_unit(LightNetwork* network, uint32_t unit) {
  SANDGLASS_CHECK(unit < network->units);
  const LightOperator& op = operator_of(*network, unit);
  const uint32_t first = first_row(op, unit), count = row_count(op, unit);
  const LightBackend* other = network->backend;
  if (op.kind == k_light_kind_head) {
    if (other != nullptr) other->average(network);
    else average_features(network);
    run_head(network, reinterpret_cast<double*>(network->even));  // a block's buffer, free by now
  } else if (other != nullptr) {
    other->run_rows(network, op, first, count);
  } else {
    run_rows(*network, op, first, count);
  }
}

void finish_light_network(const LightNetwork& network, LightOutputs* outputs) { *outputs = network.outputs; }

LightFloats light_floats(const LightNetwork& network, const LightOperator& op) {
  LightFloats floats = {};
  const float* at = network.asset.float_parameters;
  const auto take = [&](uint32_t count) {
    at += count;
    return at - count;
  };
  for (const LightOperator* o = network.operators; o <= &op; ++o) {
    floats = {};
    if (o->kind == k_light_kind_stem) floats.border = take(3);
    if (o->kind == k_light_kind_narrow || o->kind == k_light_kind_transition || o->kind == k_light_kind_head) {
      floats.low = take(o->inputs);
      floats.high = take(o->inputs);
    }
    if (o->kind == k_light_kind_head) {
      floats.feature_scale = take(o->inputs);
      floats.feature_shift = take(o->inputs);
    }
    const Shape shape = shape_of(*o);
    floats.weights = take(shape.places * shape.outputs);
    floats.bias = take(shape.outputs);
  }
  return floats;
}

uint32_t light_operator_end(const LightNetwork& network, uint32_t unit) {
  const LightOperator& op = operator_of(network, unit);
  return op.first_unit + (op.rows + op.unit_rows - 1) / op.unit_rows;
}

WorkUnit light_unit(const LightNetwork& network, uint32_t unit) {
  static constexpr const char* k_names[k_light_kinds] = {"light.stem", "light.pool",       "light.1x1",
                                                         "light.3x3",  "light.transition", "light.heads"};
  const LightOperator& op = operator_of(network, unit);
  return {op.kind, static_cast<uint32_t>(op.row_macs * row_count(op, unit) / 1000), k_names[op.kind]};
}

void light_items_left(const LightNetwork& network, uint32_t unit, uint64_t items[k_light_kinds]) {
  for (uint32_t kind = 0; kind < k_light_kinds; ++kind) items[kind] = 0;
  for (const LightOperator& op : network.operators) {
    const uint32_t done = unit > op.first_unit ? (unit - op.first_unit) * op.unit_rows : 0;
    if (done < op.rows) items[op.kind] += op.row_macs * (op.rows - done) / 1000;
  }
}

void light_features(const LightNetwork& network, float features[k_light_features]) {
  if (network.features != nullptr) {
    memcpy(features, network.features, k_light_features * sizeof(float));
    return;
  }
  for (uint32_t c = 0; c < k_light_features; ++c) {
    const uint32_t average = 256u * network.pooled_high[c] + network.pooled_low[c];
    features[c] = network.asset.feature_scale[c] * (static_cast<float>(average) / 256) + network.asset.feature_shift[c];
  }
}

}  // namespace sandglass
