#include "models/lighting/light_file.h"

#include <cmath>

#include "models/lighting/light_builders.h"
#include "runtime/asset/file.h"
#include "runtime/asset/light_asset.h"

namespace sandglass::host {

namespace {

using Builder = flatbuffers::FlatBufferBuilder;

flatbuffers::Offset<asset::Convolution> add(Builder& builder, const ByteConvolution& c) {
  const auto weights = builder.CreateVector(c.weights);
  const auto bias = builder.CreateVector(c.bias);
  return asset::CreateConvolution(builder, weights, bias, builder.CreateVector(c.multiplier));
}

flatbuffers::Offset<asset::ClampedConvolution> add_clamped(Builder& builder, const ByteConvolution& c) {
  const auto low = builder.CreateVector(c.low);
  const auto high = builder.CreateVector(c.high);
  return asset::CreateClampedConvolution(builder, low, high, add(builder, c));
}

}  // namespace

std::vector<uint8_t> light_file_bytes(const LightFile& file) {
  Builder builder(1 << 23);
  std::vector<flatbuffers::Offset<asset::Block>> blocks;
  size_t layer = 0;
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    std::vector<flatbuffers::Offset<asset::DenseLayer>> layers;
    for (uint32_t i = 0; i < k_block_layers[b]; ++i, ++layer) {
      const auto narrow = add_clamped(builder, file.narrow.at(layer));
      layers.push_back(asset::CreateDenseLayer(builder, narrow, add(builder, file.wide.at(layer))));
    }
    const auto all = builder.CreateVector(layers);
    flatbuffers::Offset<asset::ClampedConvolution> transition = 0;
    if (b < k_transition_count) transition = add_clamped(builder, file.transition.at(b));
    blocks.push_back(asset::CreateBlock(builder, all, transition));
  }
  const auto all_blocks = builder.CreateVector(blocks);
  const auto stem = add(builder, file.stem);
  const auto name = builder.CreateString(file.name);
  const auto border = builder.CreateVector(file.border, 3);
  const auto last_low = builder.CreateVector(file.last_low), last_high = builder.CreateVector(file.last_high);
  const auto feature_scale = builder.CreateVector(file.feature_scale);
  const auto feature_shift = builder.CreateVector(file.feature_shift);
  const auto latent_weights = builder.CreateVector(file.latent_weights);
  const auto latent_scale = builder.CreateVector(file.latent_scale);
  const auto latent_bias = builder.CreateVector(file.latent_bias);
  const auto heads_weights = builder.CreateVector(file.heads_weights);
  const auto heads_bias = builder.CreateVector(file.heads_bias);
  flatbuffers::Offset<flatbuffers::Vector<float>> float_parameters = 0;
  if (!file.float_parameters.empty()) float_parameters = builder.CreateVector(file.float_parameters);
  builder.Finish(asset::CreateLight(builder, k_light_asset_version, name, border, stem, all_blocks, last_low, last_high,
                                    feature_scale, feature_shift, latent_weights, latent_scale, latent_bias,
                                    heads_weights, heads_bias, file.data_hash, file.seed, file.training_images,
                                    file.calibration_images, file.angle_deg, file.difference, float_parameters),
                 asset::LightIdentifier());
  std::vector<uint8_t> bytes(builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize());
  const uint64_t hash = hash_bytes(bytes.data(), bytes.size());
  for (uint32_t i = 0; i < k_checksum_bytes; ++i) bytes.push_back(static_cast<uint8_t>(hash >> 8 * i));
  return bytes;
}

LightFile random_light_file(uint64_t seed) {
  // Inputs are assumed to be bytes around `centre`. Outputs then lie around `target`, spread over all bytes.
  constexpr double k_spread_of_weights = 73;  // standard deviation of uniform -127..127
  constexpr double k_spread_of_inputs = 50, k_spread_of_outputs = 55;
  uint64_t state = seed;
  const auto next = [&](int64_t low, int64_t high) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return low + static_cast<int64_t>((state >> 33) % static_cast<uint64_t>(high - low + 1));
  };
  const auto convolution = [&](uint32_t inputs, uint32_t outputs, int32_t centre, int32_t target, bool clamped) {
    ByteConvolution c;
    const double deviation = k_spread_of_weights * k_spread_of_inputs * std::sqrt(static_cast<double>(inputs));
    const float multiplier = static_cast<float>(k_spread_of_outputs / deviation);
    for (uint32_t o = 0; o < outputs; ++o) {
      int32_t sum = 0;
      for (uint32_t i = 0; i < inputs; ++i) {
        c.weights.push_back(static_cast<int8_t>(next(-127, 127)));
        sum += c.weights.back();
      }
      c.multiplier.push_back(multiplier * static_cast<float>(next(80, 120)) / 100);
      c.bias.push_back(static_cast<int32_t>(static_cast<float>(target) / c.multiplier.back()) - centre * sum);
    }
    for (uint32_t i = 0; clamped && i < inputs; ++i) {
      const bool above = next(0, 3) > 0;
      c.low.push_back(above ? static_cast<uint8_t>(next(0, 160)) : uint8_t{0});
      c.high.push_back(above ? uint8_t{255} : static_cast<uint8_t>(next(100, 255)));
    }
    return c;
  };
  const auto numbers = [&](size_t count, double from, double to) {
    std::vector<float> values(count);
    for (float& v : values)
      v = static_cast<float>(from + (to - from) * static_cast<double>(next(0, 1 << 20)) / (1 << 20));
    return values;
  };
  LightFile file;
  file.name = "random";
  for (uint8_t& b : file.border) b = static_cast<uint8_t>(next(100, 130));
  file.stem = convolution(3 * k_stem_size * k_stem_size, k_light_stem, 128, 60, false);
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    uint32_t channels = light_channels_before(b);
    for (uint32_t i = 0; i < k_block_layers[b]; ++i, channels += k_light_growth) {
      file.narrow.push_back(convolution(channels, k_light_bottleneck, 140, 20, true));
      file.wide.push_back(convolution(9 * k_light_bottleneck, k_light_growth, 40, 128, false));
    }
    if (b < k_transition_count) file.transition.push_back(convolution(channels, channels / 2, 140, 128, true));
  }
  for (uint32_t c = 0; c < k_light_features; ++c) {
    file.last_low.push_back(static_cast<uint8_t>(next(0, 160)));
    file.last_high.push_back(255);
  }
  file.feature_scale = numbers(k_light_features, 0.005, 0.02);
  file.feature_shift = numbers(k_light_features, -1, 0);
  for (uint32_t i = 0; i < k_light_latent * k_light_features; ++i)
    file.latent_weights.push_back(static_cast<int8_t>(next(-127, 127)));
  file.latent_scale = numbers(k_light_latent, 1e-5, 2e-5);
  file.latent_bias = numbers(k_light_latent, -1, 1);
  file.heads_weights = numbers(size_t{k_light_heads} * k_light_latent, -0.06, 0.06);
  file.heads_bias = numbers(k_light_heads, -0.5, 0.5);
  file.data_hash = seed, file.seed = seed;
  return file;
}

}  // namespace sandglass::host
