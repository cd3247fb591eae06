// See shadow_file.h. The tables are written here field by field; runtime/asset/shadow_generated.h only reads them.
#include "models/baking/shadow_file.h"

#include "runtime/asset/file.h"
#include "runtime/asset/shadow_asset.h"
#include "runtime/asset/shadow_generated.h"

namespace sandglass::host {

namespace {

constexpr uint16_t k_default_side = 128;  // in shadow.fbs

void append_checksum(std::vector<uint8_t>* bytes) {
  const uint64_t hash = hash_bytes(bytes->data(), bytes->size());
  for (uint32_t i = 0; i < k_checksum_bytes; ++i) bytes->push_back(static_cast<uint8_t>(hash >> 8 * i));
}

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
