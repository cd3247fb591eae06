#include "models/lighting/densenet.h"

#include <algorithm>
#include <cmath>

#include "models/files/failure.h"

namespace sandglass::host {

namespace {

constexpr float k_epsilon = 1.001e-5f;  // the epsilon of the pretrained batch normalisations
ChannelAffine affine_of(const Arrays& arrays, const std::string& name, int channels) {
  const std::vector<uint64_t> shape = {static_cast<uint64_t>(channels)};
  const auto& gamma = array_of(arrays, name + "/gamma", shape);
  const auto& beta = array_of(arrays, name + "/beta", shape);
  const auto& mean = array_of(arrays, name + "/moving_mean", shape);
  const auto& variance = array_of(arrays, name + "/moving_variance", shape);
  ChannelAffine affine;
  for (size_t c = 0; c < gamma.size(); ++c) {
    affine.scale.push_back(gamma[c] / std::sqrt(variance[c] + k_epsilon));
    affine.shift.push_back(beta[c] - mean[c] * affine.scale[c]);
  }
  return affine;
}

Convolution convolution_of(const Arrays& arrays, const std::string& name, int size, int inputs, int outputs) {
  const auto n = static_cast<uint64_t>(size);
  return {size, inputs, outputs,
          array_of(arrays, name, {n, n, static_cast<uint64_t>(inputs), static_cast<uint64_t>(outputs)})};
}

// Pixels by rows. Each pixel has `stride` channels, and the first `channels` are in use.
struct Activations {
  int width, height, channels, stride;
  std::vector<float> values;
  Activations(int w, int h, int c, int s)
      : width(w),
        height(h),
        channels(c),
        stride(s),
        values(static_cast<size_t>(w) * static_cast<size_t>(h) * static_cast<size_t>(s)) {}
  float* at(int x, int y) {
    return values.data() +
           (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) * static_cast<size_t>(stride);
  }
  const float* at(int x, int y) const { return const_cast<Activations*>(this)->at(x, y); }
};

void rectified(const ChannelAffine& affine, const float* in, float* out, int channels) {
  for (int c = 0; c < channels; ++c) {
    const auto i = static_cast<size_t>(c);
    out[c] = std::max(0.0f, in[c] * affine.scale[i] + affine.shift[i]);
  }
}

// Adds the products of one pixel's inputs with the weights at one place of the kernel.
void accumulate(const Convolution& conv, int row, int column, const float* in, float* out) {
  const float* weights = conv.weights.data() + static_cast<size_t>((row * conv.size + column) * conv.inputs) *
                                                   static_cast<size_t>(conv.outputs);
  for (int k = 0; k < conv.inputs; ++k, weights += conv.outputs) {
    const float value = in[k];
    if (value == 0.0f) continue;  // behind a rectifier half of all values are 0
    for (int n = 0; n < conv.outputs; ++n) out[n] += value * weights[n];
  }
}

// Convolves with a zero padding of size / 2. Writes the output channels from `to` on.
void convolve(const Convolution& conv, const Activations& in, int step, Activations* out, int to) {
  const int pad = conv.size / 2;
  for (int y = 0; y < out->height; ++y)
    for (int x = 0; x < out->width; ++x) {
      float* result = out->at(x, y) + to;
      std::fill_n(result, conv.outputs, 0.0f);
      for (int row = 0; row < conv.size; ++row)
        for (int column = 0; column < conv.size; ++column) {
          const int u = x * step + column - pad, v = y * step + row - pad;
          if (u >= 0 && v >= 0 && u < in.width && v < in.height) accumulate(conv, row, column, in.at(u, v), result);
        }
    }
}

Activations stem(const DenseNet& net, std::span<const uint8_t> rgb, int width, int height, int stride,
                 const ActivationObserver& observer) {
  Activations image(width, height, 3, 3), convolved(width / 2, height / 2, k_stem_channels, k_stem_channels);
  for (size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = (static_cast<float>(rgb[i]) / 255.0f - static_cast<float>(k_image_mean[i % 3])) /
                      static_cast<float>(k_image_deviation[i % 3]);
  convolve(net.stem, image, 2, &convolved, 0);
  for (int y = 0; y < convolved.height; ++y)
    for (int x = 0; x < convolved.width; ++x) {
      rectified(net.stem_affine, convolved.at(x, y), convolved.at(x, y), k_stem_channels);
      if (observer) observer(Activation::stem, 0, convolved.at(x, y), k_stem_channels);
    }
  Activations pooled(width / 4, height / 4, k_stem_channels, stride);
  for (int y = 0; y < pooled.height; ++y)
    for (int x = 0; x < pooled.width; ++x)
      for (int row = -1; row <= 1; ++row)
        // The padding's zeros never win, because all values are rectified.
        for (int column = -1; column <= 1; ++column) {
          const int u = 2 * x + column, v = 2 * y + row;
          if (u < 0 || v < 0 || u >= convolved.width || v >= convolved.height) continue;
          for (int c = 0; c < k_stem_channels; ++c)
            pooled.at(x, y)[c] = std::max(pooled.at(x, y)[c], convolved.at(u, v)[c]);
        }
  return pooled;
}

void run_layer(const DenseLayer& layer, int index, Activations* block, const ActivationObserver& observer) {
  Activations bottleneck(block->width, block->height, k_bottleneck, k_bottleneck);
  std::vector<float> inputs(static_cast<size_t>(block->channels));
  for (int y = 0; y < block->height; ++y)
    for (int x = 0; x < block->width; ++x) {
      rectified(layer.before, block->at(x, y), inputs.data(), block->channels);
      accumulate(layer.narrow, 0, 0, inputs.data(), bottleneck.at(x, y));
      rectified(layer.between, bottleneck.at(x, y), bottleneck.at(x, y), k_bottleneck);
      if (!observer) continue;
      observer(Activation::narrow_input, index, inputs.data(), block->channels);
      observer(Activation::bottleneck, index, bottleneck.at(x, y), k_bottleneck);
    }
  convolve(layer.wide, bottleneck, 1, block, block->channels);
  for (int y = 0; observer && y < block->height; ++y)
    for (int x = 0; x < block->width; ++x)
      observer(Activation::growth, index, block->at(x, y) + block->channels, k_growth);
  block->channels += k_growth;
}

Activations transition(const DenseBlock& block, int index, const Activations& in, int stride,
                       const ActivationObserver& observer) {
  Activations out(in.width / 2, in.height / 2, block.transition.outputs, stride);
  const auto channels = static_cast<size_t>(in.channels);
  std::vector<float> sum(channels), one(channels);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      std::fill(sum.begin(), sum.end(), 0.0f);
      for (int i = 0; i < 4; ++i) {
        rectified(block.transition_affine, in.at(2 * x + i % 2, 2 * y + i / 2), one.data(), in.channels);
        if (observer) observer(Activation::transition_input, index, one.data(), in.channels);
        for (size_t c = 0; c < channels; ++c) sum[c] += 0.25f * one[c];
      }
      accumulate(block.transition, 0, 0, sum.data(), out.at(x, y));
      if (observer) observer(Activation::transition, index, out.at(x, y), out.channels);
    }
  return out;
}

int channels_after(int block, int before) { return before + k_growth * k_dense_layers[block]; }

}  // namespace

const std::vector<float>& array_of(const Arrays& arrays, const std::string& name, const std::vector<uint64_t>& shape) {
  const auto found = arrays.find(name);
  if (found == arrays.end())
    throw cannot("read", name, "the weights have no array of this name", "Export them with train.py --export");
  if (found->second.shape != shape)
    throw cannot("read", name, "the array has another shape than the network's", "Export the weights again");
  for (const float value : found->second.values)
    if (!std::isfinite(value))
      throw cannot("read", name, "the array holds a value that is not a number", "Train again");
  return found->second.values;
}

DenseNet densenet_of(const Arrays& arrays) {
  DenseNet net;
  net.stem = convolution_of(arrays, "conv1/conv/kernel", 7, 3, k_stem_channels);
  net.stem_affine = affine_of(arrays, "conv1/bn", k_stem_channels);
  int channels = k_stem_channels;
  for (int b = 0; b < 4; ++b) {
    for (int l = 0; l < k_dense_layers[b]; ++l, channels += k_growth) {
      const std::string name = "conv" + std::to_string(b + 2) + "_block" + std::to_string(l + 1);
      net.blocks[b].layers.push_back({affine_of(arrays, name + "_0_bn", channels),
                                      affine_of(arrays, name + "_1_bn", k_bottleneck),
                                      convolution_of(arrays, name + "_1_conv/kernel", 1, channels, k_bottleneck),
                                      convolution_of(arrays, name + "_2_conv/kernel", 3, k_bottleneck, k_growth)});
    }
    if (b == 3) break;
    const std::string name = "pool" + std::to_string(b + 2);
    net.blocks[b].transition_affine = affine_of(arrays, name + "_bn", channels);
    net.blocks[b].transition = convolution_of(arrays, name + "_conv/kernel", 1, channels, channels / 2);
    channels /= 2;
  }
  net.last = affine_of(arrays, "bn", channels);
  return net;
}

std::vector<float> features_of(const DenseNet& net, std::span<const uint8_t> rgb, int width, int height,
                               const ActivationObserver& observer) {
  if (width < 32 || height < 32 || width % 32 != 0 || height % 32 != 0 ||
      rgb.size() != 3 * static_cast<size_t>(width) * static_cast<size_t>(height))
    throw Failure("cannot run DenseNet-121: the image's sides are no multiples of 32 pixels. Resample it.");
  int channels = k_stem_channels, index = 0;
  Activations block = stem(net, rgb, width, height, channels_after(0, channels), observer);
  for (int b = 0; b < 4; ++b) {
    for (const DenseLayer& layer : net.blocks[b].layers) run_layer(layer, index++, &block, observer);
    if (b == 3) break;
    channels = net.blocks[b].transition.outputs;
    block = transition(net.blocks[b], b, block, channels_after(b + 1, channels), observer);
  }
  std::vector<float> features(k_features), one(k_features);
  for (int y = 0; y < block.height; ++y)
    for (int x = 0; x < block.width; ++x) {
      rectified(net.last, block.at(x, y), one.data(), k_features);
      if (observer) observer(Activation::last_input, 0, one.data(), k_features);
      for (size_t c = 0; c < features.size(); ++c)
        features[c] += one[c] / static_cast<float>(block.width * block.height);
    }
  return features;
}

}  // namespace sandglass::host
