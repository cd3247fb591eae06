// See quantise.h. The tables are written here field by field; runtime/asset/shadow_generated.h only reads them.
#include "models/baking/quantise.h"

#include <algorithm>
#include <cmath>

#include "runtime/asset/file.h"
#include "runtime/asset/shadow_asset.h"
#include "runtime/asset/shadow_generated.h"

namespace sandglass::host {

namespace {

constexpr double k_bias_limit = 1 << 24;
constexpr uint16_t k_default_side = 128;  // in shadow.fbs

ByteLayer quantise_layer(const float* weights, const float* bias, uint32_t inputs, uint32_t outputs, double step_in,
                         double step_out) {
  ByteLayer layer;
  for (uint32_t o = 0; o < outputs; ++o) {
    float largest = 0;
    for (uint32_t i = 0; i < inputs; ++i) largest = std::max(largest, std::fabs(weights[i * outputs + o]));
    const float inverse = largest > 0 ? 127.0f / largest : 0;
    for (uint32_t i = 0; i < inputs; ++i)
      layer.weights.push_back(static_cast<int8_t>(std::nearbyint(weights[i * outputs + o] * inverse)));
    const double unit =
        (largest > 0 ? static_cast<double>(largest) / 127 : 1.0) * step_in;  // the value of one step of the integer sum
    layer.bias.push_back(static_cast<int32_t>(
        std::nearbyint(std::clamp(static_cast<double>(bias[o]) / unit, -k_bias_limit, k_bias_limit))));
    layer.multiplier.push_back(static_cast<float>(unit / step_out));
  }
  return layer;
}

}  // namespace

ByteNetwork quantise(const FloatNetwork& network, const std::vector<float>& clips) {
  const NetworkShape& shape = network.shape;
  ByteNetwork bytes;
  bytes.shape = shape;
  bytes.first_weights.assign(network.first_weights(), network.first_weights() + shape.width * k_inputs);
  bytes.first_bias.assign(network.first_bias(), network.first_bias() + shape.width);
  bytes.first_step = clips[0] / 255.0f;
  for (uint32_t layer = 0; layer < shape.layers; ++layer)
    bytes.layers.push_back(quantise_layer(network.weights(layer), network.bias(layer), shape.width, shape.width,
                                          static_cast<double>(clips[layer]) / 255,
                                          static_cast<double>(clips[layer + 1]) / 255));
  bytes.last = quantise_layer(network.last_weights(), network.last_bias(), shape.width, 1,
                              static_cast<double>(clips[shape.layers]) / 255, 1.0);
  return bytes;
}

void append_checksum(std::vector<uint8_t>* bytes) {
  const uint64_t hash = hash_bytes(bytes->data(), bytes->size());
  for (uint32_t i = 0; i < k_checksum_bytes; ++i) bytes->push_back(static_cast<uint8_t>(hash >> 8 * i));
}

namespace {

flatbuffers::Offset<asset::Ambient> write_ambient(const AmbientPart& part, double scale,
                                                  flatbuffers::FlatBufferBuilder* builder) {
  if (part.components == 0) return 0;
  const auto mixing = builder->CreateVector(part.mixing);
  const auto texels = builder->CreateVector(part.texels);
  using Table = asset::Ambient;
  const flatbuffers::uoffset_t start = builder->StartTable();
  builder->AddElement<uint16_t>(Table::VT_SIDE, static_cast<uint16_t>(part.square.side), k_default_side);
  builder->AddElement<double>(Table::VT_HALF, part.square.half * scale, 0.0);
  builder->AddElement<uint8_t>(Table::VT_COMPONENTS, static_cast<uint8_t>(part.components), 0);
  builder->AddOffset(Table::VT_MIXING, mixing);
  builder->AddOffset(Table::VT_TEXELS, texels);
  builder->AddElement<float>(Table::VT_RMSE, static_cast<float>(part.rmse), 0.0f);
  return builder->EndTable(start);
}

flatbuffers::Offset<asset::Surface> write_surface(const SurfacePart& part, const StandingObject& object,
                                                  flatbuffers::FlatBufferBuilder* builder) {
  if (part.vertices == 0) return 0;
  const auto positions = builder->CreateVector(part.positions);
  const auto normals = builder->CreateVector(part.normals);
  const auto steps = builder->CreateVector(part.steps);
  const auto transfer = builder->CreateVector(part.transfer);
  const Vec3 low = part.low * object.scale + Vec3{object.origin[0], object.origin[1], object.origin[2]};
  using Table = asset::Surface;
  const flatbuffers::uoffset_t start = builder->StartTable();
  builder->AddElement<uint32_t>(Table::VT_VERTICES, part.vertices, 0);
  builder->AddElement<float>(Table::VT_LOW_X, static_cast<float>(low.x), 0.0f);
  builder->AddElement<float>(Table::VT_LOW_Y, static_cast<float>(low.y), 0.0f);
  builder->AddElement<float>(Table::VT_LOW_Z, static_cast<float>(low.z), 0.0f);
  builder->AddElement<float>(Table::VT_STEP, static_cast<float>(part.step * object.scale), 0.0f);
  builder->AddOffset(Table::VT_POSITIONS, positions);
  builder->AddOffset(Table::VT_NORMALS, normals);
  builder->AddOffset(Table::VT_STEPS, steps);
  builder->AddOffset(Table::VT_TRANSFER, transfer);
  return builder->EndTable(start);
}

}  // namespace

std::vector<uint8_t> shadow_file_bytes(const ShadowFile& file) {
  flatbuffers::FlatBufferBuilder builder(1 << 16);
  const auto layer_of = [&](const ByteLayer& layer) {
    const auto weights = builder.CreateVector(layer.weights);
    const auto bias = builder.CreateVector(layer.bias);
    const auto multiplier = builder.CreateVector(layer.multiplier);
    const flatbuffers::uoffset_t start = builder.StartTable();
    builder.AddOffset(asset::Layer::VT_MULTIPLIER, multiplier);
    builder.AddOffset(asset::Layer::VT_BIAS, bias);
    builder.AddOffset(asset::Layer::VT_WEIGHTS, weights);
    return flatbuffers::Offset<asset::Layer>(builder.EndTable(start));
  };
  std::vector<flatbuffers::Offset<asset::Layer>> layers;
  for (const ByteLayer& layer : file.network.layers) layers.push_back(layer_of(layer));
  const auto last = layer_of(file.network.last);
  const auto all_layers = builder.CreateVector(layers);
  const auto first_weights = builder.CreateVector(file.network.first_weights);
  const auto first_bias = builder.CreateVector(file.network.first_bias);
  const auto name = builder.CreateString(file.name);
  flatbuffers::Offset<flatbuffers::Vector<float>> parameters = 0;
  if (!file.float_parameters.empty()) parameters = builder.CreateVector(file.float_parameters);
  const StandingObject& object = file.geometry.object;
  const auto ambient = write_ambient(file.ambient, object.scale, &builder);
  const auto surface = write_surface(file.surface, object, &builder);
  const asset::Box box(object.origin[0], object.origin[1], object.origin[2], object.box.half_x * object.scale,
                       object.box.half_z * object.scale, object.box.height * object.scale, 2 * file.geometry.half_angle,
                       file.geometry.polar_max);
  // An older library reads a file that has nothing new.
  const uint16_t version = ambient.IsNull() && surface.IsNull() ? k_shadow_asset_oldest : k_shadow_asset_version;
  using Table = asset::Shadow;
  const flatbuffers::uoffset_t start = builder.StartTable();
  builder.AddElement<uint16_t>(Table::VT_VERSION, version, 0);
  builder.AddOffset(Table::VT_NAME, name);
  builder.AddStruct(Table::VT_BOX, &box);
  builder.AddElement<uint8_t>(Table::VT_PLANE_FITTED, file.geometry.plane == PlaneRule::fitted ? 1 : 0, 0);
  builder.AddElement<uint8_t>(Table::VT_TEXEL_FREQUENCIES, k_texel_frequencies, 0);
  builder.AddElement<uint8_t>(Table::VT_LIGHT_FREQUENCIES, k_light_frequencies, 0);
  builder.AddElement<uint16_t>(Table::VT_WIDTH, static_cast<uint16_t>(file.network.shape.width), 0);
  builder.AddOffset(Table::VT_FIRST_WEIGHTS, first_weights);
  builder.AddOffset(Table::VT_FIRST_BIAS, first_bias);
  builder.AddElement<float>(Table::VT_FIRST_STEP, file.network.first_step, 0.0f);
  builder.AddOffset(Table::VT_LAYERS, all_layers);
  builder.AddOffset(Table::VT_LAST, last);
  builder.AddElement<float>(Table::VT_RMSE_FLOAT, static_cast<float>(file.rmse_float), 0.0f);
  builder.AddElement<float>(Table::VT_RMSE_INT8, static_cast<float>(file.rmse_int8), 0.0f);
  builder.AddElement<uint32_t>(Table::VT_VALIDATED_LIGHTS, file.validated_lights, 0);
  builder.AddElement<uint64_t>(Table::VT_SEED, file.seed, 0);
  if (!file.float_parameters.empty()) builder.AddOffset(Table::VT_FLOAT_PARAMETERS, parameters);
  if (!ambient.IsNull()) builder.AddOffset(Table::VT_AMBIENT, ambient);
  if (!surface.IsNull()) builder.AddOffset(Table::VT_SURFACE, surface);
  builder.Finish(flatbuffers::Offset<Table>(builder.EndTable(start)), asset::ShadowIdentifier());
  std::vector<uint8_t> bytes(builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize());
  append_checksum(&bytes);
  return bytes;
}

}  // namespace sandglass::host
