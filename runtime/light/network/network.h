// The lighting network at run time: DenseNet-121 and its heads in bytes, one operator after another, each in slices of
// rows. Nothing here reads a clock, allocates or waits; the caller decides how many units fit into a frame.
//
// How to use it (the stage does, and tests):
//   open_light_asset(...)            the file's bytes are checked once, and stay where they are
//   layout_light_network(...)        once with a layout that counts, once with one that hands out memory
//   create_light_network(...)        packs the weights for this CPU; the file's bytes are read later too
//   begin_light_network(net, rgb)    an image of width x height, three bytes a pixel, sRGB, upright
//   run_light_unit(net, i)           for i = 0 .. units - 1
//   finish_light_network(net, &out)  after the last unit
// The units of one operator are those below light_operator_end(net, i). They write to different places and may run at
// the same time, in any order. An operator begins when all units of the one before are done. The result does not depend
// on the order.
//
// The app chose the back end that computes the operators: this project's own kernels, or another one with the same
// units and heads. The units of another back end may run in any order too, but not at the same time.
//
// A feature is an unsigned byte with the scale and zero point of its channel. A batch normalisation and its rectifier
// before a 1x1 convolution are then a clamp of bytes to [low, high] of the channel. All else about them is linear and
// lies in the weights and bias of the convolution. See asset/light.fbs.
#pragma once

#include <cstdint>

#include "kernels/int8.h"
#include "runtime/asset/light_asset.h"
#include "runtime/frame/governor.h"
#include "runtime/frame/layout.h"
#include "sandglass/estimator.h"

namespace sandglass {

// In the camera's frame: x right, y down, z forward. Colours and contrast in 0..1.
struct LightOutputs {
  float direction[3];  // unit vector towards the light
  float light[3], ambient[3];
  float contrast;
};

// Kinds of work unit. Items are thousands of multiplications, for the pool thousands of comparisons.
enum : uint32_t {
  k_light_kind_stem,
  k_light_kind_pool,
  k_light_kind_narrow,
  k_light_kind_wide,
  k_light_kind_transition,
  k_light_kind_head,
  k_light_kinds
};

constexpr uint32_t k_light_operators = 2 + 2 * k_dense_layer_count + k_transition_count + 1;
constexpr uint64_t k_light_unit_macs = 5'000'000;  // 45 us on a phone's core, which does 110 GMAC/s of bytes
constexpr uint32_t k_light_side_limit = k_stem_pixels_limit;
constexpr uint32_t k_light_side_step = 32;  // the network halves its image five times

struct LightOperator {
  uint32_t kind;
  uint32_t block;       // 0..3
  uint32_t layer;       // 0..57, counted over all blocks
  uint32_t inputs;      // channels
  uint32_t rows;        // of its output
  uint32_t unit_rows;   // of its output in one unit
  uint32_t first_unit;  // number of its first unit
  uint64_t row_macs;
};

// An operator's part of a file's float parameters. Null where the operator has none.
struct LightFloats {
  const float* border;                         // of the stem
  const float *low, *high;                     // of the inputs
  const float *feature_scale, *feature_shift;  // of the heads
  const float *weights, *bias;
};

struct LightNetwork;
struct LightMemory;

// A back end other than this project's own kernels. Those are called by name, so that a test can follow their stack.
struct LightBackend {
  bool in_float;  // takes the file's float parameters where it has them
  void (*lay_out)(uint32_t width, uint32_t height, Layout* layout, LightMemory* memory);
  // `release` gives back what is not in the block. False, with one sentence, where the back end cannot be had.
  bool (*create)(LightNetwork* network, const LightMemory& memory, const char** reason);
  void (*run_rows)(LightNetwork* network, const LightOperator& op, uint32_t first, uint32_t count);
  void (*average)(LightNetwork* network);  // fills pooled_high and pooled_low or, with float parameters, features
  void (*release)(LightNetwork* network);
  uint64_t (*bytes_beside)();  // bytes that all its networks hold beside their blocks
};

struct LightNetwork {
  const LightBackend* backend;  // NULL: the project's own kernels
  void* backend_state;
  const Int8Kernels* kernels;
  LightAsset asset;        // points into the file's bytes; no float parameters unless the back end takes them
  uint32_t width, height;  // of the image, multiples of 32
  uint32_t units;          // of one estimate
  LightOperator operators[k_light_operators];
  const uint8_t* rgb;  // of the image under way
  // Packed weights, an operator after another in the network's order.
  Int8Convolution stem;
  Int8Convolution narrow[k_dense_layer_count], wide[k_dense_layer_count];
  Int8Convolution transition[k_transition_count];
  int8_t* latent;   // 512 x 1024; without float parameters
  float* features;  // k_light_features; with them, in the same place
  // Activations. Blocks 0 and 2 live in `even`, 1 and 3 in `odd`. `odd` and the bottleneck use the memory of the stem's
  // rows, which are done by then.
  uint8_t *even, *odd, *stem_rows;
  uint8_t* bottleneck;                // with a border of one pixel
  uint8_t *pooled_high, *pooled_low;  // k_light_features averages in steps of 1/256 byte
  LightOutputs outputs;
};

// What the layout hands out and creation fills.
struct LightMemory {
  LightNetwork* network;
  int8_t* latent;  // packed
  uint8_t* pooled;
  // Of the project's own kernels.
  int8_t* weights;  // packed
  int32_t* biases;
  uint8_t *even, *shared;
  // Of another back end.
  void *state, *maps[2], *stem, *bottleneck, *slice;
};

// Width and height are multiples of k_light_side_step up to k_light_side_limit. Regions are named "light.…".
LightMemory layout_light_network(uint32_t width, uint32_t height, Layout* layout,
                                 const LightBackend* backend = nullptr);
LightNetwork* create_light_network(const LightAsset& asset, const Int8Kernels* kernels, uint32_t width, uint32_t height,
                                   const LightMemory& memory);
// `memory` is what was laid out for this back end. NULL, with one sentence, where the back end cannot be had.
LightNetwork* create_light_network(const LightAsset& asset, const Int8Kernels* kernels, const LightBackend* backend,
                                   uint32_t width, uint32_t height, const LightMemory& memory, const char** reason);
void release_light_network(LightNetwork* network);
uint64_t light_activation_bytes(uint32_t width, uint32_t height);

// `rgb` is read until the units of operator 0 are done.
void begin_light_network(LightNetwork* network, const uint8_t* rgb);
void run_light_unit(LightNetwork* network, uint32_t unit);
void finish_light_network(const LightNetwork& network, LightOutputs* outputs);

// The float parameters of an operator; the network must have them.
LightFloats light_floats(const LightNetwork& network, const LightOperator& op);

uint32_t light_operator_end(const LightNetwork& network, uint32_t unit);
WorkUnit light_unit(const LightNetwork& network, uint32_t unit);
// Items by kind of the units from `unit` on.
void light_items_left(const LightNetwork& network, uint32_t unit, uint64_t items[k_light_kinds]);

// The trunk's 1024 features, for tests and measurements; valid with the outputs.
void light_features(const LightNetwork& network, float features[k_light_features]);

}  // namespace sandglass
