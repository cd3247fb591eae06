// Three checks, as for shadows. The hash finds damage. FlatBuffers' verifier makes sure that every offset stays inside.
// The checks below make sure that the kernels can run on every number.
#include "runtime/asset/light_asset.h"

#include "runtime/asset/file.h"
#include "runtime/math/finite.h"

// The verifier asserts things about the calling code only, and assert would bring in stdio.
#define FLATBUFFERS_ASSERT(condition) ((condition) ? (void)0 : __builtin_trap())
#include "runtime/asset/light_generated.h"

namespace sandglass {
namespace {

constexpr int32_t k_bias_limit = 1 << 29;  // products add up to less than 2^26: sums stay below 2^31
constexpr float k_multiplier_limit = 1e6f;
constexpr float k_number_limit = 1e9f;
// Most tables that the verifier follows: the root, the stem, the blocks, and in them layers and transitions, each with
// its convolutions.
constexpr uint32_t k_tables_limit = 2 + k_dense_blocks + 4 * k_dense_layer_count + 2 * k_transition_count;

constexpr AssetRefusals k_refusals = {
    "asset is NULL: pass the bytes of a lighting network's file",
    "the file is not a lighting network: name one that models/lighting/quantise.py wrote",
    "the lighting file is damaged or cut off (its checksum differs): copy it again"};

// The numbers, if there are `count` and all lie in -limit..limit; else null.
const float* numbers(const flatbuffers::Vector<float>* values, uint32_t count, float limit) {
  if (values == nullptr || values->size() != count) return nullptr;
  return all_within(values->data(), count, -limit, limit) ? values->data() : nullptr;
}

const int8_t* weights_of(const flatbuffers::Vector<int8_t>* values, uint32_t count) {
  if (values == nullptr || values->size() != count) return nullptr;
  bool beyond = false;
  for (uint32_t i = 0; i < count; ++i) beyond |= values->data()[i] == -128;
  return beyond ? nullptr : values->data();
}

// Null, or what is wrong.
const char* check(const asset::Convolution* file, uint32_t inputs, uint32_t outputs, AssetConvolution* out) {
  if (file == nullptr) return "the lighting file lacks a layer of its network: quantise it again.";
  out->weights = weights_of(file->weights(), inputs * outputs);
  if (out->weights == nullptr)
    return "the lighting file has a layer of the wrong size, or a weight of -128: quantise it again.";
  if (file->bias() == nullptr || file->bias()->size() != outputs)
    return "the lighting file has a layer with a bias of the wrong size: quantise it again.";
  out->bias = file->bias()->data();
  for (uint32_t i = 0; i < outputs; ++i)
    if (out->bias[i] < -k_bias_limit || out->bias[i] > k_bias_limit)
      return "the lighting file has a bias beyond 2^29, which no quantisation writes.";
  out->multiplier = numbers(file->multiplier(), outputs, k_multiplier_limit);
  for (uint32_t i = 0; out->multiplier != nullptr && i < outputs; ++i)
    if (out->multiplier[i] < 0) out->multiplier = nullptr;
  if (out->multiplier == nullptr)
    return "the lighting file has a multiplier that is not a number in 0..1e6, which no quantisation writes.";
  return nullptr;
}

const char* check_clamp(const flatbuffers::Vector<uint8_t>* low, const flatbuffers::Vector<uint8_t>* high,
                        uint32_t inputs) {
  if (low == nullptr || high == nullptr || low->size() != inputs || high->size() != inputs)
    return "the lighting file has a clamp of the wrong size: quantise it again.";
  for (uint32_t i = 0; i < inputs; ++i)
    if (low->data()[i] > high->data()[i])
      return "the lighting file has a clamp whose low end is above its high end, which no quantisation writes.";
  return nullptr;
}

const char* check(const asset::ClampedConvolution* file, uint32_t inputs, uint32_t outputs, AssetConvolution* out) {
  if (file == nullptr) return "the lighting file lacks a layer of its network: quantise it again.";
  if (const char* fault = check_clamp(file->low(), file->high(), inputs)) return fault;
  out->low = file->low()->data();
  out->high = file->high()->data();
  return check(file->convolution(), inputs, outputs, out);
}

const char* check_blocks(const asset::Light& file, LightAsset* out) {
  if (file.blocks() == nullptr || file.blocks()->size() != k_dense_blocks)
    return "the lighting file's network is not a DenseNet-121: quantise it again.";
  uint32_t layer = 0;
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    const asset::Block* block = file.blocks()->Get(b);
    if (block == nullptr || block->layers() == nullptr || block->layers()->size() != k_block_layers[b])
      return "the lighting file's network is not a DenseNet-121: quantise it again.";
    uint32_t channels = light_channels_before(b);
    for (uint32_t i = 0; i < k_block_layers[b]; ++i, ++layer, channels += k_light_growth) {
      const asset::DenseLayer* dense = block->layers()->Get(i);
      if (dense == nullptr) return "the lighting file lacks a layer of its network: quantise it again.";
      if (const char* fault = check(dense->narrow(), channels, k_light_bottleneck, &out->narrow[layer])) return fault;
      if (const char* fault = check(dense->wide(), 9 * k_light_bottleneck, k_light_growth, &out->wide[layer]))
        return fault;
    }
    if (b == k_transition_count) continue;
    if (const char* fault = check(block->transition(), channels, channels / 2, &out->transition[b])) return fault;
  }
  return nullptr;
}

const char* check_heads(const asset::Light& file, LightAsset* out) {
  if (const char* fault = check_clamp(file.last_low(), file.last_high(), k_light_features)) return fault;
  out->last_low = file.last_low()->data();
  out->last_high = file.last_high()->data();
  out->feature_scale = numbers(file.feature_scale(), k_light_features, k_number_limit);
  out->feature_shift = numbers(file.feature_shift(), k_light_features, k_number_limit);
  out->latent_weights = weights_of(file.latent_weights(), k_light_latent * k_light_features);
  out->latent_scale = numbers(file.latent_scale(), k_light_latent, k_number_limit);
  out->latent_bias = numbers(file.latent_bias(), k_light_latent, k_number_limit);
  out->heads_weights = numbers(file.heads_weights(), k_light_heads * k_light_latent, k_number_limit);
  out->heads_bias = numbers(file.heads_bias(), k_light_heads, k_number_limit);
  if (out->feature_scale == nullptr || out->feature_shift == nullptr || out->latent_weights == nullptr ||
      out->latent_scale == nullptr || out->latent_bias == nullptr || out->heads_weights == nullptr ||
      out->heads_bias == nullptr)
    return "the lighting file's heads have the wrong size or hold what is not a number: quantise it again.";
  return nullptr;
}

}  // namespace

sandglass_status open_light_asset(const void* bytes, uint64_t count, LightAsset* out, const char** reason) {
  if (const sandglass_status whole = check_asset_bytes(bytes, count, asset::LightIdentifier(), k_refusals, reason))
    return whole;
  const uint8_t* data = static_cast<const uint8_t*>(bytes);
  flatbuffers::Verifier verifier(data, count - k_checksum_bytes, 8, k_tables_limit);
  if (!asset::VerifyLightBuffer(verifier))
    return refuse(reason, "the lighting file has an offset that leads outside of it: quantise it again.");

  const asset::Light& file = *asset::GetLight(data);
  if (file.version() != k_light_asset_version)
    return refuse(reason, "the lighting file is of another version than this library reads (1): quantise it again.");
  *out = {};
  out->name = file.name() == nullptr ? "" : file.name()->c_str();
  if (file.border() == nullptr || file.border()->size() != 3)
    return refuse(reason, "the lighting file does not say what colour lies beyond the image: quantise it again.");
  for (uint32_t i = 0; i < 3; ++i) out->border[i] = file.border()->data()[i];
  if (const char* fault = check(file.stem(), 3 * k_stem_size * k_stem_size, k_light_stem, &out->stem))
    return refuse(reason, fault);
  if (const char* fault = check_blocks(file, out)) return refuse(reason, fault);
  if (const char* fault = check_heads(file, out)) return refuse(reason, fault);
  if (file.float_parameters() != nullptr) {
    out->float_parameters = numbers(file.float_parameters(), k_light_float_parameters, k_light_float_limit);
    if (out->float_parameters == nullptr)
      return refuse(reason,
                    "the lighting file's float network has the wrong size or holds what is not a number: quantise it "
                    "again.");
  }
  out->data_hash = file.data_hash();
  out->seed = file.seed();
  out->training_images = file.training_images();
  out->calibration_images = file.calibration_images();
  out->angle_deg = file.angle_deg();
  out->difference = file.difference();
  if (!(out->angle_deg >= 0 && out->angle_deg <= 180) || !(out->difference >= 0 && out->difference <= 1))
    return refuse(reason, "the lighting file's errors are not numbers in 0..180 degrees and 0..1: quantise it again.");
  return accept(reason);
}

}  // namespace sandglass
