#include "models/lighting/light_file.h"

#include <cmath>
#include <initializer_list>

#include "flatbuffers/flatbuffers.h"
#include "runtime/asset/file.h"
#include "runtime/asset/light_asset.h"
#include "runtime/asset/light_generated.h"

namespace sandglass::host {

namespace {

using Builder = flatbuffers::FlatBufferBuilder;

// A table's reference to something that was written before it. 0 refers to nothing and takes no space.
struct Reference {
  flatbuffers::voffset_t field;
  flatbuffers::uoffset_t to;
};

void add_references(Builder& builder, std::initializer_list<Reference> references) {
  for (const Reference& r : references) builder.AddOffset(r.field, flatbuffers::Offset<void>(r.to));
}

flatbuffers::uoffset_t add_table(Builder& builder, std::initializer_list<Reference> references) {
  const flatbuffers::uoffset_t start = builder.StartTable();
  add_references(builder, references);
  return builder.EndTable(start);
}

flatbuffers::uoffset_t add(Builder& builder, const ByteConvolution& c) {
  using Table = asset::Convolution;
  const auto weights = builder.CreateVector(c.weights);
  const auto bias = builder.CreateVector(c.bias);
  const auto multiplier = builder.CreateVector(c.multiplier);
  return add_table(builder,
                   {{Table::VT_MULTIPLIER, multiplier.o}, {Table::VT_BIAS, bias.o}, {Table::VT_WEIGHTS, weights.o}});
}

flatbuffers::uoffset_t add_clamped(Builder& builder, const ByteConvolution& c) {
  using Table = asset::ClampedConvolution;
  const auto low = builder.CreateVector(c.low);
  const auto high = builder.CreateVector(c.high);
  const auto convolution = add(builder, c);
  return add_table(builder, {{Table::VT_CONVOLUTION, convolution}, {Table::VT_HIGH, high.o}, {Table::VT_LOW, low.o}});
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
      const auto wide = add(builder, file.wide.at(layer));
      layers.emplace_back(
          add_table(builder, {{asset::DenseLayer::VT_WIDE, wide}, {asset::DenseLayer::VT_NARROW, narrow}}));
    }
    const auto all = builder.CreateVector(layers);
    flatbuffers::uoffset_t transition = 0;
    if (b < k_transition_count) transition = add_clamped(builder, file.transition.at(b));
    blocks.emplace_back(
        add_table(builder, {{asset::Block::VT_TRANSITION, transition}, {asset::Block::VT_LAYERS, all.o}}));
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
  // The widest numbers come first, so that none needs a gap before it.
  using Table = asset::Light;
  const flatbuffers::uoffset_t start = builder.StartTable();
  builder.AddElement<uint64_t>(Table::VT_SEED, file.seed, 0);
  builder.AddElement<uint64_t>(Table::VT_DATA_HASH, file.data_hash, 0);
  builder.AddOffset(Table::VT_FLOAT_PARAMETERS, float_parameters);
  builder.AddElement<float>(Table::VT_DIFFERENCE, file.difference, 0.0f);
  builder.AddElement<float>(Table::VT_ANGLE_DEG, file.angle_deg, 0.0f);
  builder.AddElement<uint32_t>(Table::VT_CALIBRATION_IMAGES, file.calibration_images, 0);
  builder.AddElement<uint32_t>(Table::VT_TRAINING_IMAGES, file.training_images, 0);
  add_references(builder, {{Table::VT_HEADS_BIAS, heads_bias.o},
                           {Table::VT_HEADS_WEIGHTS, heads_weights.o},
                           {Table::VT_LATENT_BIAS, latent_bias.o},
                           {Table::VT_LATENT_SCALE, latent_scale.o},
                           {Table::VT_LATENT_WEIGHTS, latent_weights.o},
                           {Table::VT_FEATURE_SHIFT, feature_shift.o},
                           {Table::VT_FEATURE_SCALE, feature_scale.o},
                           {Table::VT_LAST_HIGH, last_high.o},
                           {Table::VT_LAST_LOW, last_low.o},
                           {Table::VT_BLOCKS, all_blocks.o},
                           {Table::VT_STEM, stem},
                           {Table::VT_BORDER, border.o},
                           {Table::VT_NAME, name.o}});
  builder.AddElement<uint16_t>(Table::VT_VERSION, k_light_asset_version, 0);
  builder.Finish(flatbuffers::Offset<Table>(builder.EndTable(start)), asset::LightIdentifier());
  std::vector<uint8_t> bytes(builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize());
  const uint64_t hash = hash_bytes(bytes.data(), bytes.size());
  for (uint32_t i = 0; i < k_checksum_bytes; ++i) bytes.push_back(static_cast<uint8_t>(hash >> 8 * i));
  return bytes;
}

LightFile random_light_file(uint64_t seed) {
  // If inputs are bytes around `centre`, outputs lie around `target` and spread over all bytes.
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
  file.data_hash = seed;
  file.seed = seed;
  return file;
}

}  // namespace sandglass::host
