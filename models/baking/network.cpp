// See network.h.
#include "models/baking/network.h"

#include <algorithm>
#include <cmath>

#include "models/baking/batch_math.h"
#include "models/work/random.h"
#include "runtime/math/math.h"

namespace sandglass::host {

FloatNetwork make_network(const NetworkShape& shape, uint64_t seed) {
  FloatNetwork network = {shape, Floats(shape.parameters(), 0.0f)};
  uint64_t counter = 0;
  const auto fill = [&](const float* from, uint32_t inputs, uint32_t outputs) {
    float* weights = network.parameters.data() + (from - network.parameters.data());
    const double spread = std::sqrt(6.0 / inputs);  // a uniform distribution with He's variance 2/inputs
    for (uint32_t i = 0; i < inputs * outputs; ++i)
      weights[i] = static_cast<float>(spread * (2 * random_unit(random_mix(seed) + counter++) - 1));
  };
  fill(network.first_weights(), k_inputs, shape.width);
  // The weights of octave k start scaled by 2^-k. So a network starts smooth, and every octave contributes the same
  // slope. Otherwise training would first have to remove the noise of the high octaves.
  uint32_t input = 0;
  const auto damp = [&](uint32_t frequencies) {
    for (uint32_t i = 0; i < 1 + 2 * frequencies; ++i, ++input)
      for (uint32_t c = 0; c < shape.width; ++c)
        network.parameters[input * shape.width + c] *= i == 0 ? 1.0f : 1.0f / static_cast<float>(1u << (i - 1) / 2);
  };
  damp(k_texel_frequencies);
  damp(k_texel_frequencies);
  for (uint32_t axis = 0; axis < 3; ++axis) damp(k_light_frequencies);
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

void evaluate_texels(const FloatNetwork& network, const Direction& light, uint32_t size, const uint32_t* uv,
                     uint32_t count, float* values) {
  constexpr uint32_t k_chunk = 256;
  const NetworkShape& shape = network.shape;
  std::vector<float> positions(size_t{size} * k_texel_inputs);
  Floats input(size_t{k_chunk} * k_inputs), scratch(batch_scratch(shape.width, shape.layers, k_chunk));
  Floats output(k_chunk);
  for (uint32_t i = 0; i < size; ++i)
    encode(texel_centre(i, size), k_texel_frequencies, &positions[size_t{i} * k_texel_inputs]);
  float encoded[3 * k_light_inputs];
  encode_light(light, encoded);
  for (uint32_t first = 0; first < count; first += k_chunk) {
    const uint32_t samples = std::min(k_chunk, count - first);
    for (uint32_t i = 0; i < samples; ++i) {
      float* x = &input[size_t{i} * k_inputs];
      const uint32_t* texel = uv + 2 * size_t{first + i};
      std::copy_n(&positions[size_t{texel[0]} * k_texel_inputs], k_texel_inputs, x);
      std::copy_n(&positions[size_t{texel[1]} * k_texel_inputs], k_texel_inputs, x + k_texel_inputs);
      std::copy_n(encoded, 3 * k_light_inputs, x + 2 * k_texel_inputs);
    }
    const Batch batch = {k_inputs,     shape.width, shape.layers,  samples, network.parameters.data(),
                         input.data(), nullptr,     scratch.data()};
    batch_math().forward(batch, output.data());
    std::copy_n(output.data(), samples, values + first);
  }
}

std::vector<float> evaluate(const FloatNetwork& network, const Direction& light, uint32_t size, ThreadPool& pool) {
  return whole_texture(size, pool, [&](const uint32_t* uv, uint32_t count, float* values) {
    evaluate_texels(network, light, size, uv, count, values);
  });
}

}  // namespace sandglass::host
