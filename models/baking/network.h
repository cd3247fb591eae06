// A shadow network in float, as it is trained: encoded texel and light -> ReLU layers -> sigmoid (section 6.5 of the
// dissertation).
//
// A coordinate x is encoded as x, sin(2^0 pi x), cos(2^0 pi x), sin(2^1 pi x), ...: 10 frequencies for each texel
// coordinate and 4 for each component of the light give 69 inputs. The dissertation's Table 6.1 counts the layers after
// the first (see the corrections in runtime/README.md). So its 128 x 2 is 69 -> 128 -> 128 -> 128 -> 1.
#pragma once

#include <cstdint>
#include <vector>

#include "models/baking/batch_math.h"
#include "models/baking/truth.h"

namespace sandglass::host {

constexpr uint32_t k_texel_frequencies = 10, k_light_frequencies = 4;
constexpr uint32_t k_texel_inputs = 1 + 2 * k_texel_frequencies;  // for one coordinate
constexpr uint32_t k_light_inputs = 1 + 2 * k_light_frequencies;  // for one component
constexpr uint32_t k_inputs = 2 * k_texel_inputs + 3 * k_light_inputs;
constexpr uint32_t k_native_size = 256;  // networks are trained for textures with this many texels a side

struct NetworkShape {
  uint32_t width = 128;  // of every hidden layer
  uint32_t layers = 2;   // hidden layers after the first

  uint32_t parameters() const { return width * (k_inputs + 1) + layers * width * (width + 1) + width + 1; }
  uint64_t macs() const { return uint64_t{width} * (k_inputs + layers * width + 1); }
};

// The layers are stored in order. Each holds its weights input by input (all outputs of input 0, then of input 1, ...),
// then its biases. The last layer has one output.
struct FloatNetwork {
  NetworkShape shape;
  Floats parameters;

  const float* first_weights() const { return parameters.data(); }
  const float* first_bias() const { return parameters.data() + shape.width * k_inputs; }
  const float* weights(uint32_t layer) const {
    return first_bias() + shape.width + size_t{layer} * shape.width * (shape.width + 1);
  }
  const float* bias(uint32_t layer) const { return weights(layer) + shape.width * shape.width; }
  const float* last_weights() const { return weights(shape.layers); }
  const float* last_bias() const { return last_weights() + shape.width; }
};

// A network with He's initial weights and zero biases. Equal seeds give equal networks.
FloatNetwork make_network(const NetworkShape& shape, uint64_t seed);

// Writes the encoding of one coordinate with `frequencies` octaves: 1 + 2 * frequencies values. It uses the library's
// own sine, so that runtime and training see the same numbers.
void encode(double x, uint32_t frequencies, float* out);
void encode_light(const Direction& light, float* out);

// Evaluates the network on `count` texels of a size x size texture for one light. `uv` holds two numbers (u, v) for
// each texel. The values are transparencies in 0..1. The hot loops are those of batch_math.h.
void evaluate_texels(const FloatNetwork& network, const Direction& light, uint32_t size, const uint32_t* uv,
                     uint32_t count, float* values);

// Evaluates all texels, row by row. The pool shares the work.
std::vector<float> evaluate(const FloatNetwork& network, const Direction& light, uint32_t size, ThreadPool& pool);

}  // namespace sandglass::host
