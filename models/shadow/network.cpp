#include "models/shadow/network.h"

#include <algorithm>
#include <cmath>

#include "models/shadow/batch_math.h"
#include "models/shadow/random.h"
#include "runtime/core/math.h"

namespace sandglass::host {

FloatNetwork make_network(const NetworkShape& shape, uint64_t seed) {
  FloatNetwork network = {shape, std::vector<float>(shape.parameters(), 0.0f)};
  uint64_t counter = 0;
  const auto fill = [&](const float* from, uint32_t inputs, uint32_t outputs) {
    float* weights = network.parameters.data() + (from - network.parameters.data());
    const double spread = std::sqrt(6.0 / inputs);  // uniform with He's variance 2/inputs
    for (uint32_t i = 0; i < inputs * outputs; ++i)
      weights[i] = static_cast<float>(spread * (2 * random_unit(random_mix(seed) + counter++) - 1));
  };
  fill(network.first_weights(), k_inputs, shape.width);
  for (uint32_t layer = 0; layer < shape.layers; ++layer) fill(network.weights(layer), shape.width, shape.width);
  fill(network.last_weights(), shape.width, 1);
  return network;
}

void encode(double x, uint32_t frequencies, float* out) {
  *out++ = static_cast<float>(x);
  double turns = 0.5 * x;  // 2^k pi x radians are 2^(k-1) x turns
  for (uint32_t k = 0; k < frequencies; ++k, turns *= 2) {
    const SinCos wave = sin_cos_turns(turns);
    *out++ = static_cast<float>(wave.sin);
    *out++ = static_cast<float>(wave.cos);
  }
}

void encode_light(const Direction& light, float* out) {
  for (size_t axis = 0; axis < 3; ++axis) encode(light[axis], k_light_frequencies, out + axis * k_light_inputs);
}

std::vector<float> evaluate(const FloatNetwork& network, const Direction& light, uint32_t size, ThreadPool& pool) {
  std::vector<float> texels(size_t{size} * size), positions(size_t{size} * k_texel_inputs);
  for (uint32_t i = 0; i < size; ++i)
    encode(texel_centre(i, size), k_texel_frequencies, &positions[i * k_texel_inputs]);
  float encoded[3 * k_light_inputs];
  encode_light(light, encoded);
  const NetworkShape& shape = network.shape;
  run_on(pool, size, [&](uint32_t v) {
    std::vector<float> input(size_t{size} * k_inputs), scratch(batch_scratch(shape.width, shape.layers, size));
    for (uint32_t u = 0; u < size; ++u) {
      float* x = &input[size_t{u} * k_inputs];
      std::copy_n(&positions[size_t{u} * k_texel_inputs], k_texel_inputs, x);
      std::copy_n(&positions[size_t{v} * k_texel_inputs], k_texel_inputs, x + k_texel_inputs);
      std::copy_n(encoded, 3 * k_light_inputs, x + 2 * k_texel_inputs);
    }
    const Batch batch = {k_inputs,     shape.width, shape.layers,  size, network.parameters.data(),
                         input.data(), nullptr,     scratch.data()};
    batch_math().forward(batch, &texels[size_t{v} * size]);
  });
  return texels;
}

}  // namespace sandglass::host
