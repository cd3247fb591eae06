#include <cmath>

#include "models/lighting/light_net.h"
#include "runtime/asset/light_asset.h"

namespace sandglass::host {

namespace {

constexpr double k_limit = static_cast<double>(k_light_float_limit);

// How an input enters a convolution: slope * clamped(x, low, high) + constant.
struct Input {
  double slope = 1, constant = 0;
  double low = -k_limit, high = k_limit;
};
using Inputs = std::vector<Input>;

// The input max(0, scale x + shift).
Input rectified(double scale, double shift) {
  // If the line crosses zero beyond every x, the shift alone decides.
  if (std::fabs(shift) >= k_limit * std::fabs(scale)) return shift > 0 ? Input{scale, shift} : Input{0};
  const double zero = -shift / scale;
  return scale > 0 ? Input{scale, shift, zero, k_limit} : Input{scale, shift, -k_limit, zero};
}

Inputs rectified(const ChannelAffine& affine) {
  Inputs inputs;
  for (size_t c = 0; c < affine.scale.size(); ++c)
    inputs.push_back(rectified(static_cast<double>(affine.scale[c]), static_cast<double>(affine.shift[c])));
  return inputs;
}

struct Parameters {
  std::vector<float> values;

  void add(double value) { values.push_back(static_cast<float>(value)); }
  void add(const std::vector<float>& more) { values.insert(values.end(), more.begin(), more.end()); }
  void add_clamps(const Inputs& inputs) {
    for (const Input& input : inputs) add(input.low);
    for (const Input& input : inputs) add(input.high);
  }
  // `affine`, if given, follows the convolution.
  void add_convolution(const Convolution& c, const Inputs& inputs, const ChannelAffine* affine) {
    const size_t places = c.weights.size() / static_cast<size_t>(c.outputs), count = static_cast<size_t>(c.outputs);
    std::vector<double> bias;
    for (size_t o = 0; o < count; ++o) {
      const double scale = affine == nullptr ? 1 : static_cast<double>(affine->scale[o]);
      bias.push_back(affine == nullptr ? 0 : static_cast<double>(affine->shift[o]));
      for (size_t k = 0; k < places; ++k) {
        const Input& input = inputs[k % inputs.size()];
        const double weight = scale * static_cast<double>(c.weights[k * count + o]);
        add(weight * input.slope);
        bias[o] += weight * input.constant;
      }
    }
    for (const double b : bias) add(b);
  }
  void add_rectified_convolution(const Convolution& c, const ChannelAffine& before, const ChannelAffine* behind) {
    const Inputs inputs = rectified(before);
    add_clamps(inputs);
    add_convolution(c, inputs, behind);
  }
};

}  // namespace

std::vector<float> float_parameters(const LightNet& net) {
  Parameters parameters;
  Inputs image;
  for (size_t c = 0; c < 3; ++c) {
    image.push_back({1 / (255 * k_image_deviation[c]), -k_image_mean[c] / k_image_deviation[c]});
    parameters.add(255 * k_image_mean[c]);
  }
  parameters.add_convolution(net.trunk.stem, image, &net.trunk.stem_affine);
  for (const DenseBlock& block : net.trunk.blocks) {
    for (const DenseLayer& layer : block.layers) {
      parameters.add_rectified_convolution(layer.narrow, layer.before, &layer.between);
      parameters.add_convolution(layer.wide, {Input{}}, nullptr);
    }
    if (!block.transition_affine.scale.empty())
      parameters.add_rectified_convolution(block.transition, block.transition_affine, nullptr);
  }
  const Inputs last = rectified(net.trunk.last);
  parameters.add_clamps(last);
  for (const Input& input : last) parameters.add(input.slope);
  for (const Input& input : last) parameters.add(input.constant);
  parameters.add(net.latent);
  parameters.add(net.latent_bias);
  return parameters.values;
}

}  // namespace sandglass::host
