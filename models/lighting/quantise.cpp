#include "models/lighting/quantise.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/asset/light_asset.h"

namespace sandglass::host {

namespace {

constexpr double k_mean[3] = {0.485, 0.456, 0.406}, k_deviation[3] = {0.229, 0.224, 0.225};
constexpr double k_bias_limit = 1 << 28;
constexpr uint64_t k_samples_an_image = 48;  // of a channel
constexpr double k_quantiles[] = {0, 1e-4, 3e-4, 1e-3, 2e-3, 4e-3, 8e-3};

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

// Bytes of a channel: x = step * (byte - zero).
struct Grid {
  double step = 1, zero = 0;
};

double rounding_error(const std::vector<float>& samples, const Grid& grid) {
  double sum = 0;
  for (const float x : samples) {
    const double byte = std::clamp(std::nearbyint(static_cast<double>(x) / grid.step + grid.zero), 0.0, 255.0);
    const double error = grid.step * (byte - grid.zero) - static_cast<double>(x);
    sum += error * error;
  }
  return sum;
}

Grid grid_of(const ChannelRange& range, bool rectified) {
  std::vector<float> sorted = range.samples;
  std::sort(sorted.begin(), sorted.end());
  Grid best;
  double least = std::numeric_limits<double>::infinity();
  for (const double quantile : k_quantiles) {
    double low = static_cast<double>(range.least), high = static_cast<double>(range.greatest);
    if (quantile > 0) {
      const auto cut = static_cast<size_t>(quantile * static_cast<double>(sorted.size()));
      if (cut == 0) continue;  // too few samples to say
      low = static_cast<double>(sorted[cut]), high = static_cast<double>(sorted[sorted.size() - 1 - cut]);
    }
    if (rectified) low = 0;
    const double width = std::max(high - low, 1e-6 * std::max(1.0, std::fabs(high)));
    const Grid grid = {width / 255, -low * 255 / width};
    const double error = rounding_error(sorted, grid);
    if (error < least) least = error, best = grid;
  }
  return best;
}

std::vector<Grid> grids_of(const ChannelRanges& ranges, bool rectified) {
  std::vector<Grid> grids;
  for (const ChannelRange& range : ranges) grids.push_back(grid_of(range, rectified));
  return grids;
}

// How one input of a convolution enters: slope * (clamped byte - origin), and what is known of that byte.
struct Input {
  double slope = 1, origin = 0;
  double constant = 0;  // added to slope * (...)
  double mean = 0, variance = 0;
  uint8_t low = 0, high = 255;
};

// max(0, scale x + shift) on bytes of `grid`; `seen` are its values.
Input rectified_input(const Grid& grid, double scale, double shift, const ChannelRange& seen) {
  Input input;
  const double slope = scale * grid.step;
  const double count = std::max<double>(1, static_cast<double>(seen.count));
  const double mean = seen.sum / count, variance = std::max(0.0, seen.squares / count - mean * mean);
  const double threshold = grid.zero - shift / slope;  // the byte at which it passes zero
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
  // Below the threshold stands its rounding error instead of zero, which on the mean is a constant.
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

// Bytes that stand for themselves times a step, zero at zero.
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

// `weights`: of the inputs' values, `places` times all inputs; `constant`: added.
ByteRow byte_row(const std::vector<double>& weights, double constant, const std::vector<Input>& inputs) {
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
  for (size_t k = 0; k < of_bytes.size(); ++k) {
    const double weight = std::clamp(std::nearbyint(of_bytes[k] / row.scale), -127.0, 127.0);
    row.weights[k] = static_cast<int8_t>(weight);
    row.bias += (of_bytes[k] - row.scale * weight) * inputs[k % inputs.size()].mean;
  }
  return row;
}

// `affine`, where given, follows the convolution.
ByteConvolution byte_convolution(const Convolution& c, const ChannelAffine* affine, const std::vector<Input>& inputs,
                                 const std::vector<Grid>& outputs, bool clamped) {
  ByteConvolution bytes;
  const auto places = static_cast<size_t>(c.size * c.size * c.inputs), count = static_cast<size_t>(c.outputs);
  for (size_t o = 0; o < count; ++o) {
    const double scale = affine == nullptr ? 1 : static_cast<double>(affine->scale[o]);
    std::vector<double> weights(places);
    for (size_t k = 0; k < places; ++k) weights[k] = scale * static_cast<double>(c.weights[k * count + o]);
    ByteRow row = byte_row(weights, affine == nullptr ? 0 : static_cast<double>(affine->shift[o]), inputs);
    // A bias of at most 2^28 steps: an output that hardly depends on its inputs has coarser ones.
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
    inputs[c].slope = 1 / (255 * k_deviation[c]), inputs[c].origin = 255 * k_mean[c];
    inputs[c].mean = 255 * k_mean[c], inputs[c].variance = 255 * 255 * k_deviation[c] * k_deviation[c];
  }
  return inputs;
}

void quantise_heads(const LightNet& net, const std::vector<Input>& inputs, LightFile* file) {
  for (const Input& input : inputs) {
    file->last_low.push_back(input.low), file->last_high.push_back(input.high);
    file->feature_scale.push_back(static_cast<float>(input.slope));
    file->feature_shift.push_back(static_cast<float>(input.constant - input.slope * input.origin));
  }
  for (size_t o = 0; o < k_latent; ++o) {
    std::vector<double> weights(k_features);
    for (size_t i = 0; i < k_features; ++i) weights[i] = static_cast<double>(net.latent[i * k_latent + o]);
    const ByteRow row = byte_row(weights, static_cast<double>(net.latent_bias[o]), inputs);
    file->latent_weights.insert(file->latent_weights.end(), row.weights.begin(), row.weights.end());
    file->latent_scale.push_back(static_cast<float>(row.scale));
    file->latent_bias.push_back(static_cast<float>(row.bias));
  }
  for (size_t o = 0; o < k_heads; ++o)
    for (size_t i = 0; i < k_latent; ++i) file->heads_weights.push_back(net.heads[i * k_heads + o]);
  file->heads_bias = net.heads_bias;
}

}  // namespace

std::vector<float> observe(const DenseNet& net, std::span<const uint8_t> rgb, int width, int height,
                           LightRanges* ranges) {
  ranges->narrow_inputs.resize(k_dense_layer_count), ranges->bottlenecks.resize(k_dense_layer_count);
  ranges->growths.resize(k_dense_layer_count);
  ranges->transition_inputs.resize(k_transition_count), ranges->transitions.resize(k_transition_count);
  ++ranges->images;
  const auto pixels_of_stem = static_cast<uint64_t>(width / 2) * static_cast<uint64_t>(height / 2);
  const auto pixels_of_layer = [&](int layer) {
    const int block = layer < 6 ? 0 : layer < 18 ? 1 : layer < 42 ? 2 : 3;
    return (pixels_of_stem / 4) >> (2 * block);
  };
  // Every so many pixels one is kept whole; which ones differs from image to image.
  const auto sample = [&](ChannelRanges* to, const float* values, int channels, uint64_t pixels) {
    note(to, values, channels);
    const uint64_t every = std::max<uint64_t>(1, pixels / k_samples_an_image);
    if ((to->front().count + 7 * ranges->images) % every != 0) return;
    for (size_t c = 0; c < to->size(); ++c) (*to)[c].samples.push_back(values[c]);
  };
  return features_of(net, rgb, width, height, [&](Activation place, int index, const float* values, int channels) {
    const auto i = static_cast<size_t>(index);
    switch (place) {
      case Activation::stem:
        return sample(&ranges->stem, values, channels, pixels_of_stem);
      case Activation::narrow_input:
        return note(&ranges->narrow_inputs[i], values, channels);
      case Activation::bottleneck:
        return sample(&ranges->bottlenecks[i], values, channels, pixels_of_layer(index));
      case Activation::growth:
        return sample(&ranges->growths[i], values, channels, pixels_of_layer(index));
      case Activation::transition_input:
        return note(&ranges->transition_inputs[i], values, channels);
      case Activation::transition:
        return sample(&ranges->transitions[i], values, channels, (pixels_of_stem / 16) >> (2 * index));
      case Activation::last_input:
        return note(&ranges->last_inputs, values, channels);
    }
  });
}

LightFile quantise(const LightNet& net, const LightRanges& ranges) {
  LightFile file;
  for (size_t c = 0; c < 3; ++c) file.border[c] = static_cast<uint8_t>(std::nearbyint(255 * k_mean[c]));
  std::vector<Grid> block = grids_of(ranges.stem, true);
  file.stem = byte_convolution(net.trunk.stem, &net.trunk.stem_affine, image_inputs(), block, false);
  size_t layer = 0;
  for (size_t b = 0; b < k_dense_blocks; ++b) {
    for (const DenseLayer& dense : net.trunk.blocks[b].layers) {
      const std::vector<Grid> bottleneck = grids_of(ranges.bottlenecks[layer], true);
      file.narrow.push_back(byte_convolution(dense.narrow, &dense.between,
                                             rectified_inputs(block, dense.before, ranges.narrow_inputs[layer]),
                                             bottleneck, true));
      const std::vector<Grid> growth = grids_of(ranges.growths[layer], false);
      file.wide.push_back(
          byte_convolution(dense.wide, nullptr, plain_inputs(bottleneck, ranges.bottlenecks[layer]), growth, false));
      block.insert(block.end(), growth.begin(), growth.end());
      ++layer;
    }
    if (b == k_transition_count) break;
    const std::vector<Grid> next = grids_of(ranges.transitions[b], false);
    const DenseBlock& dense = net.trunk.blocks[b];
    file.transition.push_back(
        byte_convolution(dense.transition, nullptr,
                         rectified_inputs(block, dense.transition_affine, ranges.transition_inputs[b]), next, true));
    block = next;
  }
  quantise_heads(net, rectified_inputs(block, net.trunk.last, ranges.last_inputs), &file);
  file.data_hash = net.data_hash, file.seed = net.seed, file.training_images = net.training_images;
  file.calibration_images = ranges.images;
  return file;
}

}  // namespace sandglass::host
