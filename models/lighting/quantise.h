// From the trained network, in float, to the bytes that the runtime reads.
//
// WEIGHTS.npz holds the trunk by the names and shapes of the pretrained file (kernels row, column, input, output):
//   conv1/conv/kernel, conv1/bn/{gamma,beta,moving_mean,moving_variance},
//   conv{2..5}_block{l}_{0_bn,1_conv,1_bn,2_conv}/…, pool{2..4}_{bn,conv}/…, bn/…
// and the heads by these:
//   latent/kernel 1024 x 512, latent/bias 512, latent/bn/{gamma,beta,moving_mean,moving_variance} 512 (epsilon 1e-5),
//   direction/kernel 512 x 3, light/kernel 512 x 3, ambient/kernel 512 x 3, contrast/kernel 512 x 1, and their /bias;
// optionally data_hash (16 hexadecimal digits as uint8 characters), seed and training_images (one float32 each).
//
// How bytes are chosen. Every channel of a feature map has a scale and zero point of its own; the range is that of the
// calibration images and a tenth more on both sides (cutting off costs more than coarser steps: quantiles were worse by
// a fifth). An input's scale goes into the weights that read it. Weights have a scale an output, the one that adds the
// least noise given how much each input varies; they are rounded together (rounding.h); what that moves the mean of an
// output by is taken off its bias. At the end each feature is fitted to the float network's.
#pragma once

#include <span>
#include <vector>

#include "models/lighting/light_file.h"
#include "models/lighting/light_net.h"
#include "models/lighting/rounding.h"

namespace sandglass::host {

// What was seen of one channel.
struct ChannelRange {
  float least = 0, greatest = 0;
  double sum = 0, squares = 0;
  uint64_t count = 0, zeros = 0;
};

// Of all channels of one place in the network.
using ChannelRanges = std::vector<ChannelRange>;

struct LightRanges {
  ChannelRanges stem;
  std::vector<ChannelRanges> narrow_inputs, bottlenecks, growths;  // by layer
  std::vector<ChannelRanges> transition_inputs, transitions;       // by block
  ChannelRanges last_inputs;
  uint32_t images = 0;
  // Whether products of inputs are kept too (half a gigabyte); without them weights are rounded one by one.
  bool products = true;
  std::vector<InputProducts> narrow_products, wide_products;  // by layer
  std::vector<InputProducts> transition_products;
};

// Runs the float trunk on an image and takes notes; returns its features.
std::vector<float> observe(const DenseNet& net, std::span<const uint8_t> rgb, int width, int height,
                           LightRanges* ranges);

LightFile quantise(const LightNet& net, LightRanges* ranges);

// Features of one image by both networks, in float and in the bytes of a file.
struct FeaturePair {
  std::vector<float> truth, bytes;
};

// Fits each feature's scale and shift to the float network's (on the mean, rounding everywhere moves a feature and
// flattens or steepens it), and the layer that reads them.
void fit_features(const LightNet& net, std::span<const FeaturePair> pairs, LightFile* file);

}  // namespace sandglass::host
