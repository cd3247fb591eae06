// See shadow_fixture.h. Golden hashes rest on these random numbers.
#include "tests/shadow/shadow_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "flatbuffers/flatbuffers.h"
#include "runtime/asset/shadow_asset.h"
#include "runtime/asset/shadow_generated.h"
#include "tests/int8_kernels.h"

namespace sandglass::tests {

namespace {

uint64_t need(const sandglass_shadow_desc& desc) {
  uint64_t bytes = 0;
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_shadow_bytes(&desc, &bytes, &reason), SANDGLASS_OK) << reason;
  return bytes;
}

// The parts of a file, of one sequence of random numbers: they are made in the order below.
struct RandomWriter {
  const RandomShadow& what;
  uint64_t state = what.seed;
  flatbuffers::FlatBufferBuilder builder{};

  double unit() {  // -1..1
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(static_cast<int64_t>(state) >> 11) * 0x1p-52;
  }
  std::vector<int8_t> bytes(size_t count) {
    std::vector<int8_t> all(count);
    for (int8_t& x : all) x = static_cast<int8_t>(127 * unit());
    return all;
  }

  flatbuffers::Offset<asset::Layer> layer(uint32_t outputs, float multiplier, bool hidden) {
    std::vector<int8_t> weights = bytes(what.width * outputs);
    if (hidden && what.forced_weight != 0) weights[3] = what.forced_weight;
    std::vector<int32_t> bias(outputs);
    for (int32_t& b : bias) b = static_cast<int32_t>(4000 * unit());
    const auto w = builder.CreateVector(weights);
    const auto b = builder.CreateVector(bias);
    const auto multipliers = builder.CreateVector(std::vector<float>(outputs, multiplier));
    const auto start = builder.StartTable();
    builder.AddOffset(asset::Layer::VT_MULTIPLIER, multipliers);
    builder.AddOffset(asset::Layer::VT_BIAS, b);
    builder.AddOffset(asset::Layer::VT_WEIGHTS, w);
    return flatbuffers::Offset<asset::Layer>(builder.EndTable(start));
  }

  void first_layer(std::vector<float>* first, std::vector<float>* bias) {
    const uint32_t of_texel = 1 + 2 * what.texel_frequencies, of_light = 1 + 2 * what.light_frequencies;
    first->resize((2 * of_texel + 3 * of_light) * what.width);
    bias->resize(what.width);
    for (float& w : *first) w = static_cast<float>(static_cast<double>(what.spread) * unit());
    for (float& b : *bias) b = static_cast<float>(unit());
    // High frequencies have smaller weights, so that a texture has smooth parts for the adaptive mode to find.
    for (uint32_t i = 0; i < 2 * of_texel; ++i)
      for (uint32_t c = 0; c < what.width; ++c)
        (*first)[i * what.width + c] /= std::ldexp(1.0f, static_cast<int>(i % of_texel));
    if (what.forced_first != 0 || what.forced_first != what.forced_first) (*first)[5] = what.forced_first;
  }

  flatbuffers::Offset<asset::Ambient> ambient() {
    if (what.ambient_side == 0) return 0;
    std::vector<float> mixing(what.components * SANDGLASS_LIGHT_CELLS);
    for (float& x : mixing) x = static_cast<float>(unit() / 127);
    if (what.forced_mixing != 0) mixing[7] = what.forced_mixing;
    const auto texels = bytes(what.components * what.ambient_side * what.ambient_side - what.missing_texels);
    const auto weights = builder.CreateVector(mixing);
    const auto written = builder.CreateVector(texels);
    using Table = asset::Ambient;
    const auto start = builder.StartTable();
    builder.AddElement<uint16_t>(Table::VT_SIDE, static_cast<uint16_t>(what.ambient_side), 128);
    builder.AddElement<double>(Table::VT_HALF, 1.5, 0);
    builder.AddElement<uint8_t>(Table::VT_COMPONENTS, static_cast<uint8_t>(what.components), 0);
    builder.AddOffset(Table::VT_MIXING, weights);
    builder.AddOffset(Table::VT_TEXELS, written);
    builder.AddElement<float>(Table::VT_RMSE, 0.02f, 0);
    return flatbuffers::Offset<Table>(builder.EndTable(start));
  }

  flatbuffers::Offset<asset::Surface> surface() {
    if (what.surface_vertices == 0) return 0;
    std::vector<float> steps(9);
    for (float& x : steps) x = static_cast<float>(0.01 + 0.001 * unit());
    const auto transfer = bytes(9 * what.surface_vertices), normals = bytes(3 * what.surface_vertices);
    std::vector<uint16_t> positions(3 * what.surface_vertices);
    for (size_t i = 0; i < positions.size(); ++i)
      positions[i] = i % 3 == 0 ? static_cast<uint16_t>(200 * (i / 6)) : static_cast<uint16_t>(30000 + 20000 * unit());
    if (what.unsorted_surface) positions[0] = 65535;
    const auto places = builder.CreateVector(positions);
    const auto axes = builder.CreateVector(normals);
    const auto sizes = builder.CreateVector(steps);
    const auto written = builder.CreateVector(transfer);
    using Table = asset::Surface;
    const auto start = builder.StartTable();
    builder.AddElement<uint32_t>(Table::VT_VERTICES, what.surface_vertices, 0);
    builder.AddElement<float>(Table::VT_LOW_X, 0.5f, 0);
    builder.AddElement<float>(Table::VT_LOW_Y, -0.25f, 0);
    builder.AddElement<float>(Table::VT_LOW_Z, 0.125f, 0);
    builder.AddElement<float>(Table::VT_STEP, 1e-4f, 0);
    builder.AddOffset(Table::VT_POSITIONS, places);
    builder.AddOffset(Table::VT_NORMALS, axes);
    builder.AddOffset(Table::VT_STEPS, sizes);
    builder.AddOffset(Table::VT_TRANSFER, written);
    return flatbuffers::Offset<Table>(builder.EndTable(start));
  }
};

}  // namespace

AssetFile make_shadow_file(const RandomShadow& what) {
  RandomWriter writer{what};
  flatbuffers::FlatBufferBuilder& builder = writer.builder;
  std::vector<float> first, first_bias;
  writer.first_layer(&first, &first_bias);
  std::vector<flatbuffers::Offset<asset::Layer>> layers;
  for (uint32_t i = 0; i < what.layers; ++i) layers.push_back(writer.layer(what.width, 0.004f, true));
  const auto last = writer.layer(1, 0.0001f, false);
  const auto all = builder.CreateVector(layers);
  const auto first_weights = builder.CreateVector(first);
  const auto biases = builder.CreateVector(first_bias);
  const auto name = builder.CreateString("random");
  const auto ambient = writer.ambient();
  const auto surface = writer.surface();
  const asset::Box box(1, 2, 3, 0.2, 0.1, 0.5, 0.349065850398866, 1.2217304763960306);  // 20 and 70 degrees
  using Table = asset::Shadow;
  const auto start = builder.StartTable();
  builder.AddElement<uint16_t>(Table::VT_VERSION, what.version, 0);
  builder.AddOffset(Table::VT_NAME, name);
  builder.AddStruct(Table::VT_BOX, &box);
  builder.AddElement<uint8_t>(Table::VT_PLANE_FITTED, 1, 0);
  builder.AddElement<uint8_t>(Table::VT_TEXEL_FREQUENCIES, static_cast<uint8_t>(what.texel_frequencies), 0);
  builder.AddElement<uint8_t>(Table::VT_LIGHT_FREQUENCIES, static_cast<uint8_t>(what.light_frequencies), 0);
  builder.AddElement<uint16_t>(Table::VT_WIDTH, static_cast<uint16_t>(what.width), 0);
  builder.AddOffset(Table::VT_FIRST_WEIGHTS, first_weights);
  builder.AddOffset(Table::VT_FIRST_BIAS, biases);
  builder.AddElement<float>(Table::VT_FIRST_STEP, 0.02f, 0.0f);
  builder.AddOffset(Table::VT_LAYERS, all);
  builder.AddOffset(Table::VT_LAST, last);
  if (!ambient.IsNull()) builder.AddOffset(Table::VT_AMBIENT, ambient);
  if (!surface.IsNull()) builder.AddOffset(Table::VT_SURFACE, surface);
  builder.Finish(flatbuffers::Offset<Table>(builder.EndTable(start)), asset::ShadowIdentifier());
  std::vector<uint8_t> content(builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize());
  content.resize(content.size() + k_checksum_bytes);
  AssetFile file(content);
  file.repair_checksum();
  return file;
}

std::vector<sandglass_isa> golden_sets() {
  return SANDGLASS_EMULATED ? std::vector<sandglass_isa>{SANDGLASS_ISA_AUTOMATIC} : int8_sets();
}

sandglass_shadow_desc describe(const AssetFile& file, sandglass_isa isa, sandglass_shadow_mode mode) {
  sandglass_shadow_desc desc;
  sandglass_shadow_desc_default(&desc);
  desc.asset = file.data();
  desc.asset_bytes = file.bytes;
  desc.isa = isa;
  desc.mode = mode;
  return desc;
}

LiveShadow::LiveShadow(const sandglass_shadow_desc& desc) : block(need(desc)) {
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_shadow_create(&desc, block.data(), need(desc), &shadow, &reason), SANDGLASS_OK) << reason;
}
void LiveShadow::light(float x, float y, float z) {
  const float direction[3] = {x, y, z};
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_shadow_set_light(shadow, 0, direction, 1, &reason), SANDGLASS_OK) << reason;
}
void LiveShadow::finish() {
  while (sandglass_shadow_run(&shadow, 1, 1000) > 0) {
  }
}
sandglass_texture LiveShadow::texture(uint32_t light) const {
  sandglass_texture texture = {};
  texture.struct_size = sizeof texture;
  sandglass_shadow_get_texture(shadow, light, &texture);
  return texture;
}
std::vector<uint8_t> LiveShadow::coverage(uint32_t light) const {
  const uint8_t* c = texture(light).bytes;
  return {c, c + SANDGLASS_SHADOW_TEXELS * SANDGLASS_SHADOW_TEXELS};
}

}  // namespace sandglass::tests
