#include "models/lighting/quantise.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/asset/light_asset.h"

namespace sandglass::host {

namespace {

constexpr double k_bias_limit = 1 << 28;
constexpr double k_margin = 0.1;              // the share of a range that is added beyond the observed values
constexpr uint64_t k_samples_an_image = 128;  // samples of products
constexpr double k_ridge = 0.5;               // added to a byte's variance; rounding alone makes a variance of 1/12

void note(ChannelRanges* ranges, const float* values, int channels) {
  ranges->resize(static_cast<size_t>(channels));
  for (size_t c = 0; c < ranges->size(); ++c) {
    ChannelRange& range = (*ranges)[c];
    const float x = values[c];
    range.least = range.count == 0 ? x : std::min(range.least, x);
    range.greatest = range.count == 0 ? x : std::max(range.greatest, x);
    range.sum += static_cast<double>(x), range.squares += static_cast<double>(x) * static_cast<double>(x);
    ++range.count;
    range.zeros += x == 0 ? 1 : 0;
  }
}

// The bytes of a channel stand for the values x = step * (byte - zero).
struct Grid {
  double step = 1, zero = 0;
};

Grid grid_of(const ChannelRange& range, bool rectified) {
  double low = static_cast<double>(range.least), high = static_cast<double>(range.greatest);
  const double margin = k_margin * (high - low);
  low = rectified ? 0 : low - margin, high += margin;
  const double width = std::max(high - low, 1e-6 * std::max(1.0, std::fabs(high)));
  return {width / 255, -low * 255 / width};
}

std::vector<Grid> grids_of(const ChannelRanges& ranges, bool rectified) {
  std::vector<Grid> grids;
  for (const ChannelRange& range : ranges) grids.push_back(grid_of(range, rectified));
  return grids;
}

// One input enters a convolution as slope * (clamped byte - origin) + constant. The rest is known about its byte.
struct Input {
  double slope = 1, origin = 0;
  double constant = 0;
  double mean = 0, variance = 0;
  uint8_t low = 0, high = 255;
};

// The input max(0, scale x + shift) on bytes of `grid`. `seen` are the values that were observed.
Input rectified_input(const Grid& grid, double scale, double shift, const ChannelRange& seen) {
  Input input;
  const double slope = scale * grid.step;
  const double count = std::max<double>(1, static_cast<double>(seen.count));
  const double mean = seen.sum / count, variance = std::max(0.0, seen.squares / count - mean * mean);
  const double threshold = grid.zero - shift / slope;  // the byte at which it crosses zero
  const bool never = slope > 0 ? threshold >= 255 : threshold <= 0;
  if (!(std::fabs(slope) > 1e-12) || !std::isfinite(threshold) || never) {
    input.slope = 0, input.constant = std::fabs(slope) > 1e-12 && never ? 0 : mean;
    return input;
  }
  input.slope = slope, input.origin = threshold;
  const double rounded = std::clamp(std::nearbyint(threshold), 0.0, 255.0);
  if (slope > 0) input.low = static_cast<uint8_t>(rounded);
  else input.high = static_cast<uint8_t>(rounded);
  const bool cuts = threshold > 0 && threshold < 255;
  const double off = cuts ? static_cast<double>(seen.zeros) / count : 0;
  // Below the threshold the result is not zero but the threshold's rounding error. On average that is a constant.
  input.constant = -off * slope * (rounded - threshold);
  input.mean = std::clamp(threshold + (mean - input.constant) / slope, 0.0, 255.0);
  input.variance = variance / (slope * slope);
  return input;
}

std::vector<Input> rectified_inputs(const std::vector<Grid>& grids, const ChannelAffine& affine,
                                    const ChannelRanges& seen) {
  std::vector<Input> inputs;
  for (size_t c = 0; c < seen.size(); ++c)
    inputs.push_back(
        rectified_input(grids[c], static_cast<double>(affine.scale[c]), static_cast<double>(affine.shift[c]), seen[c]));
  return inputs;
}

// Inputs without a rectifier, whose values are step * byte. Byte 0 stands for the value 0.
std::vector<Input> plain_inputs(const std::vector<Grid>& grids, const ChannelRanges& seen) {
  std::vector<Input> inputs;
  for (size_t c = 0; c < seen.size(); ++c) {
    const double count = std::max<double>(1, static_cast<double>(seen[c].count)), step = grids[c].step;
    const double mean = seen[c].sum / count;
    Input input;
    input.slope = step;
    input.mean = mean / step;
    input.variance = std::max(0.0, seen[c].squares / count - mean * mean) / (step * step);
    inputs.push_back(input);
  }
  return inputs;
}

struct ByteRow {
  std::vector<int8_t> weights;
  double scale = 1, bias = 0;  // output = scale * (sum of weight * byte) + bias
};

// `weights` are the weights of the inputs' values, for all places and all inputs. `constant` is added.
ByteRow byte_row(const std::vector<double>& weights, double constant, const std::vector<Input>& inputs,
                 const std::vector<float>& factor) {
  std::vector<double> of_bytes(weights.size());
  double largest = 0, bias = constant;
  for (size_t k = 0; k < weights.size(); ++k) {
    const Input& input = inputs[k % inputs.size()];
    of_bytes[k] = weights[k] * input.slope;
    bias += weights[k] * (input.constant - input.slope * input.origin);
    largest = std::max(largest, std::fabs(of_bytes[k]));
  }
  ByteRow row;
  row.weights.resize(weights.size());
  row.bias = bias;
  if (!(largest > 0)) return row;
  double least = std::numeric_limits<double>::infinity();
  for (double share = 1.0; share > 0.35; share -= 0.05) {
    const double scale = share * largest / 127;
    double noise = 0;
    for (size_t k = 0; k < of_bytes.size(); ++k) {
      const double error = of_bytes[k] - scale * std::clamp(std::nearbyint(of_bytes[k] / scale), -127.0, 127.0);
      noise += error * error * inputs[k % inputs.size()].variance;
    }
    if (noise < least) least = noise, row.scale = scale;
  }
  row.weights = rounded(of_bytes, row.scale, factor);
  for (size_t k = 0; k < of_bytes.size(); ++k)
    row.bias += (of_bytes[k] - row.scale * row.weights[k]) * inputs[k % inputs.size()].mean;
  return row;
}

// `affine`, if given, follows the convolution.
ByteConvolution byte_convolution(const Convolution& c, const ChannelAffine* affine, const std::vector<Input>& inputs,
                                 const std::vector<Grid>& outputs, bool clamped,
                                 const InputProducts* products = nullptr) {
  ByteConvolution bytes;
  std::vector<float> factor;
  if (products != nullptr) {
    std::vector<double> slopes;
    for (const Input& input : inputs) slopes.push_back(input.slope);
    factor = triangular_factor(*products, slopes, k_ridge);
  }
  const auto places = static_cast<size_t>(c.size * c.size * c.inputs), count = static_cast<size_t>(c.outputs);
  for (size_t o = 0; o < count; ++o) {
    const double scale = affine == nullptr ? 1 : static_cast<double>(affine->scale[o]);
    std::vector<double> weights(places);
    for (size_t k = 0; k < places; ++k) weights[k] = scale * static_cast<double>(c.weights[k * count + o]);
    ByteRow row = byte_row(weights, affine == nullptr ? 0 : static_cast<double>(affine->shift[o]), inputs, factor);
    // The bias may be at most 2^28 steps. So an output that hardly depends on its inputs gets coarser steps.
    const double bias = row.bias + outputs[o].step * outputs[o].zero;
    row.scale = std::max(row.scale, std::fabs(bias) / k_bias_limit);
    bytes.weights.insert(bytes.weights.end(), row.weights.begin(), row.weights.end());
    bytes.bias.push_back(static_cast<int32_t>(std::nearbyint(bias / row.scale)));
    bytes.multiplier.push_back(static_cast<float>(row.scale / outputs[o].step));
  }
  for (size_t i = 0; clamped && i < inputs.size(); ++i)
    bytes.low.push_back(inputs[i].low), bytes.high.push_back(inputs[i].high);
  return bytes;
}

std::vector<Input> image_inputs() {
  std::vector<Input> inputs(3);
  for (size_t c = 0; c < 3; ++c) {
    inputs[c].slope = 1 / (255 * k_image_deviation[c]), inputs[c].origin = 255 * k_image_mean[c];
    inputs[c].mean = 255 * k_image_mean[c],
    inputs[c].variance = 255 * 255 * k_image_deviation[c] * k_image_deviation[c];
  }
  return inputs;
}

void quantise_latent(const LightNet& net, const std::vector<Input>& inputs, LightFile* file) {
  file->latent_weights.clear(), file->latent_scale.clear(), file->latent_bias.clear();
  for (size_t o = 0; o < k_latent; ++o) {
    std::vector<double> weights(k_features);
    for (size_t i = 0; i < k_features; ++i) weights[i] = static_cast<double>(net.latent[i * k_latent + o]);
    const ByteRow row = byte_row(weights, static_cast<double>(net.latent_bias[o]), inputs, {});
    file->latent_weights.insert(file->latent_weights.end(), row.weights.begin(), row.weights.end());
    file->latent_scale.push_back(static_cast<float>(row.scale));
    file->latent_bias.push_back(static_cast<float>(row.bias));
  }
}

void quantise_heads(const LightNet& net, const std::vector<Input>& inputs, LightFile* file) {
  for (const Input& input : inputs) {
    file->last_low.push_back(input.low), file->last_high.push_back(input.high);
    file->feature_scale.push_back(static_cast<float>(input.slope));
    file->feature_shift.push_back(static_cast<float>(input.constant - input.slope * input.origin));
  }
  quantise_latent(net, inputs, file);
  for (size_t o = 0; o < k_heads; ++o)
    for (size_t i = 0; i < k_latent; ++i) file->heads_weights.push_back(net.heads[i * k_heads + o]);
  file->heads_bias = net.heads_bias;
}

}  // namespace

std::vector<float> observe(const DenseNet& net, std::span<const uint8_t> rgb, int width, int height,
                           LightRanges* ranges) {
  for (auto* all : {&ranges->narrow_inputs, &ranges->bottlenecks, &ranges->growths}) all->resize(k_dense_layer_count);
  for (auto* all : {&ranges->transition_inputs, &ranges->transitions}) all->resize(k_transition_count);
  ranges->narrow_products.resize(k_dense_layer_count), ranges->wide_products.resize(k_dense_layer_count);
  ranges->transition_products.resize(k_transition_count);
  ++ranges->images;
  const auto block_pixels = [&](int block) {
    return static_cast<uint64_t>((width >> (2 + block)) * (height >> (2 + block)));
  };
  const auto block_of = [](int layer) { return layer < 6 ? 0 : layer < 18 ? 1 : layer < 42 ? 2 : 3; };
  // Only some pixels count, at equal distances. Each image has different ones.
  const auto chosen = [&](uint64_t pixel, uint64_t pixels) {
    const uint64_t every = std::max<uint64_t>(1, pixels / k_samples_an_image);
    return ranges->products && (pixel + 7 * ranges->images) % every == 0;
  };
  uint64_t narrow_pixel = 0, transition_pixel = 0;
  std::vector<float> bottleneck, quarters, window(size_t{9} * k_bottleneck);
  // All pixels of the bottleneck are observed before the first pixel of the growth.
  const auto take_windows = [&](int layer) {
    const int columns = width >> (2 + block_of(layer)), rows = height >> (2 + block_of(layer));
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < columns; ++x) {
        if (!chosen(static_cast<uint64_t>(y * columns + x), block_pixels(block_of(layer)))) continue;
        for (int i = 0; i < 9; ++i) {
          const int u = x + i % 3 - 1, v = y + i / 3 - 1;
          float* to = window.data() + i * k_bottleneck;
          if (u < 0 || v < 0 || u >= columns || v >= rows) std::fill_n(to, k_bottleneck, 0.0f);
          else std::copy_n(bottleneck.data() + (v * columns + u) * k_bottleneck, k_bottleneck, to);
        }
        ranges->wide_products[static_cast<size_t>(layer)].add(window.data(), window.size());
      }
    bottleneck.clear();
  };
  return features_of(net, rgb, width, height, [&](Activation place, int index, const float* values, int channels) {
    const auto i = static_cast<size_t>(index), count = static_cast<size_t>(channels);
    switch (place) {
      case Activation::stem:
        return note(&ranges->stem, values, channels);
      case Activation::narrow_input:
        if (chosen(narrow_pixel++, block_pixels(block_of(index)))) ranges->narrow_products[i].add(values, count);
        return note(&ranges->narrow_inputs[i], values, channels);
      case Activation::bottleneck:
        if (ranges->products) bottleneck.insert(bottleneck.end(), values, values + channels);
        return note(&ranges->bottlenecks[i], values, channels);
      case Activation::growth:
        if (!bottleneck.empty()) take_windows(index);
        narrow_pixel = 0;
        return note(&ranges->growths[i], values, channels);
      case Activation::transition_input:
        if (transition_pixel % 4 == 0) quarters.assign(count, 0.0f);
        for (size_t c = 0; c < count; ++c) quarters[c] += 0.25f * values[c];
        if (transition_pixel % 4 == 3 && chosen(transition_pixel / 4, block_pixels(index + 1)))
          ranges->transition_products[i].add(quarters.data(), count);
        transition_pixel = (transition_pixel + 1) % (4 * block_pixels(index + 1));
        return note(&ranges->transition_inputs[i], values, channels);
      case Activation::transition:
        return note(&ranges->transitions[i], values, channels);
      case Activation::last_input:
        return note(&ranges->last_inputs, values, channels);
    }
  });
}

LightFile quantise(const LightNet& net, LightRanges* seen) {
  LightRanges& ranges = *seen;
  const auto products = [&](std::vector<InputProducts>* all, size_t i) -> const InputProducts* {
    if (!ranges.products) return nullptr;
    (*all)[i].flush();
    return &(*all)[i];
  };
  LightFile file;
  for (size_t c = 0; c < 3; ++c) file.border[c] = static_cast<uint8_t>(std::nearbyint(255 * k_image_mean[c]));
  std::vector<Grid> block = grids_of(ranges.stem, true);
  file.stem = byte_convolution(net.trunk.stem, &net.trunk.stem_affine, image_inputs(), block, false);
  size_t layer = 0;
  for (size_t b = 0; b < k_dense_blocks; ++b) {
    for (const DenseLayer& dense : net.trunk.blocks[b].layers) {
      const std::vector<Grid> bottleneck = grids_of(ranges.bottlenecks[layer], true);
      file.narrow.push_back(byte_convolution(dense.narrow, &dense.between,
                                             rectified_inputs(block, dense.before, ranges.narrow_inputs[layer]),
                                             bottleneck, true, products(&ranges.narrow_products, layer)));
      const std::vector<Grid> growth = grids_of(ranges.growths[layer], false);
      file.wide.push_back(byte_convolution(dense.wide, nullptr, plain_inputs(bottleneck, ranges.bottlenecks[layer]),
                                           growth, false, products(&ranges.wide_products, layer)));
      block.insert(block.end(), growth.begin(), growth.end());
      ++layer;
    }
    if (b == k_transition_count) break;
    const std::vector<Grid> next = grids_of(ranges.transitions[b], false);
    const DenseBlock& dense = net.trunk.blocks[b];
    file.transition.push_back(byte_convolution(
        dense.transition, nullptr, rectified_inputs(block, dense.transition_affine, ranges.transition_inputs[b]), next,
        true, products(&ranges.transition_products, b)));
    block = next;
  }
  quantise_heads(net, rectified_inputs(block, net.trunk.last, ranges.last_inputs), &file);
  file.data_hash = net.data_hash, file.seed = net.seed, file.training_images = net.training_images;
  file.calibration_images = ranges.images;
  return file;
}

void fit_features(const LightNet& net, std::span<const FeaturePair> pairs, LightFile* file) {
  constexpr double k_slope_least = 0.5, k_slope_most = 1.5;
  const auto count = static_cast<double>(pairs.size());
  std::vector<Input> inputs(k_features);
  for (size_t c = 0; c < k_features; ++c) {
    const auto scale = static_cast<double>(file->feature_scale[c]), shift = static_cast<double>(file->feature_shift[c]);
    double truth = 0, bytes = 0, products = 0, squares = 0;
    for (const FeaturePair& p : pairs)
      truth += static_cast<double>(p.truth[c]) / count, bytes += static_cast<double>(p.bytes[c]) / count;
    for (const FeaturePair& p : pairs) {
      const double x = static_cast<double>(p.bytes[c]) - bytes;
      products += x * (static_cast<double>(p.truth[c]) - truth), squares += x * x;
    }
    const double slope = squares > 0 ? std::clamp(products / squares, k_slope_least, k_slope_most) : 1;
    inputs[c].slope = slope * scale, inputs[c].constant = truth + slope * (shift - bytes);
    if (scale != 0) inputs[c].mean = (bytes - shift) / scale, inputs[c].variance = squares / count / (scale * scale);
    file->feature_scale[c] = static_cast<float>(inputs[c].slope);
    file->feature_shift[c] = static_cast<float>(inputs[c].constant);
  }
  quantise_latent(net, inputs, file);
}

}  // namespace sandglass::host
