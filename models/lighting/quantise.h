// Turns the trained network, in float, into the bytes that the runtime reads.
//
// WEIGHTS.npz holds the trunk with the names and shapes of the pretrained file (kernels: row, column, input, output):
//   conv1/conv/kernel, conv1/bn/{gamma,beta,moving_mean,moving_variance},
//   conv{2..5}_block{l}_{0_bn,1_conv,1_bn,2_conv}/…, pool{2..4}_{bn,conv}/…, bn/…
// and the heads with these:
//   latent/kernel 1024 x 512, latent/bias 512, latent/bn/{gamma,beta,moving_mean,moving_variance} 512 (epsilon 1e-5),
//   direction/kernel 512 x 3, light/kernel 512 x 3, ambient/kernel 512 x 3, contrast/kernel 512 x 1, and their /bias;
// optionally data_hash (16 hexadecimal digits as uint8 characters), seed and training_images (one float32 each).
//
// How bytes are chosen. Every channel of a feature map has a scale and a zero point of its own. Its range is that of
// the calibration images and a tenth more on both sides (cutting off costs more than coarser steps: quantiles were
// worse by a fifth). The scale of an input becomes part of the weights that read it. The weights of an output have one
// scale, which adds the least noise given how much each input varies. They are rounded together (rounding.h), and the
// bias is corrected for the change of the output's mean. At the end each feature is fitted to the float network's.
#pragma once

#include <span>
#include <vector>

#include "models/lighting/light_file.h"
#include "models/lighting/light_net.h"
#include "models/lighting/rounding.h"

namespace sandglass::host {

// The values of one channel that were observed.
struct ChannelRange {
  float least = 0, greatest = 0;
  double sum = 0, squares = 0;
  uint64_t count = 0, zeros = 0;
};

// The ranges of all channels at one place in the network.
using ChannelRanges = std::vector<ChannelRange>;

struct LightRanges {
  ChannelRanges stem;
  std::vector<ChannelRanges> narrow_inputs, bottlenecks, growths;  // by layer
  std::vector<ChannelRanges> transition_inputs, transitions;       // by block
  ChannelRanges last_inputs;
  uint32_t images = 0;
  // Whether products of inputs are kept too (half a gigabyte). Without them weights are rounded one by one.
  bool products = true;
  std::vector<InputProducts> narrow_products, wide_products;  // by layer
  std::vector<InputProducts> transition_products;
};

// Runs the float trunk on an image, records ranges and products, and returns its features.
std::vector<float> observe(const DenseNet& net, std::span<const uint8_t> rgb, int width, int height,
                           LightRanges* ranges);

LightFile quantise(const LightNet& net, LightRanges* ranges);

// The features of one image by both networks: in float, and in the bytes of a file.
struct FeaturePair {
  std::vector<float> truth, bytes;
};

// Fits each feature's scale and shift to the float network's, and adapts the layer that reads them. Rounding everywhere
// shifts a feature on average and makes it flatter or steeper.
void fit_features(const LightNet& net, std::span<const FeaturePair> pairs, LightFile* file);

}  // namespace sandglass::host
