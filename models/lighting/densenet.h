// DenseNet-121's feature extractor in plain float, read from the pretrained weights. The runtime's back ends and the
// training are compared with it. It is written to be clear, not fast.
//
// Two things are done as in the runtime. A dense block works in place: its pixels have room for all channels that the
// block ends with, and every layer writes its 32 behind those it reads. A transition pools before its 1x1 convolution:
// both are linear, so the order does not matter, and only a quarter of the multiplications is left.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "models/files/npy.h"

namespace sandglass::host {

constexpr int k_dense_layers[4] = {6, 12, 24, 16};
constexpr double k_image_mean[3] = {0.485, 0.456, 0.406}, k_image_deviation[3] = {0.229, 0.224, 0.225};  // of sRGB 0..1
constexpr int k_growth = 32, k_bottleneck = 128, k_stem_channels = 64, k_features = 1024;

// A multiplication and an addition per channel: a batch normalisation together with its statistics.
struct ChannelAffine {
  std::vector<float> scale, shift;
};

struct Convolution {
  int size = 1, inputs = 0, outputs = 0;  // size x size
  std::vector<float> weights;             // row, column, input, output
};

struct DenseLayer {
  ChannelAffine before, between;
  Convolution narrow, wide;  // 1x1 to the bottleneck, 3x3 to the growth
};

struct DenseBlock {
  std::vector<DenseLayer> layers;
  ChannelAffine transition_affine;  // empty after the last block
  Convolution transition;
};

struct DenseNet {
  Convolution stem;
  ChannelAffine stem_affine, last;
  DenseBlock blocks[4];
};

// Weights by name. A Failure names an array that is missing, has another shape, or holds a value that is no number.
using Arrays = std::map<std::string, NpyArray>;
const std::vector<float>& array_of(const Arrays& arrays, const std::string& name, const std::vector<uint64_t>& shape);

// Reads arrays that are named as in the data folder's README.
DenseNet densenet_of(const Arrays& arrays);

// The places in the network whose values are observed pixel by pixel, to measure ranges before activations become
// bytes.
enum class Activation {
  stem,              // rectified, before the pool
  narrow_input,      // rectified, by layer, one of 58 after another
  bottleneck,        // rectified, by layer
  growth,            // the 32 channels that a layer adds, by layer
  transition_input,  // rectified, before the average, by block
  transition,        // by block
  last_input,        // rectified, before the average
};
using ActivationObserver = std::function<void(Activation, int index, const float* values, int channels)>;

// The 1024 features of an sRGB image (width and height are multiples of 32): batch normalised, rectified, averaged.
std::vector<float> features_of(const DenseNet& net, std::span<const uint8_t> rgb, int width, int height,
                               const ActivationObserver& observer = {});

}  // namespace sandglass::host
