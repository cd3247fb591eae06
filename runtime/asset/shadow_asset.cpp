// Three checks. The hash finds damage. FlatBuffers' verifier makes sure that every offset stays inside. The checks
// below make sure that the kernels can run on every number.
#include "runtime/asset/shadow_asset.h"

#include "runtime/asset/file.h"
#include "runtime/math/finite.h"

// The verifier asserts things about the calling code only, and assert would bring in stdio.
#define FLATBUFFERS_ASSERT(condition) ((condition) ? (void)0 : __builtin_trap())
#include "runtime/asset/shadow_generated.h"

namespace sandglass {
namespace {

constexpr float k_weight_limit = 1e6f;        // of the first layer
constexpr int32_t k_bias_limit = 1 << 24;     // sums then stay below 2^25
constexpr double k_horizon = 1.5533430;       // 89 degrees: polar_max plus half the light
constexpr float k_mixing_limit = 1.0f;        // of a step of a component's byte, for all light from one cell
constexpr uint32_t k_points_limit = 1 << 24;  // of the surface
constexpr uint32_t k_tables_limit =
    16;  // tables that the verifier follows, at most: the root, `last`, the layers, two more

constexpr AssetRefusals k_refusals = {
    "asset is NULL: pass the bytes of a file that `sandglass bake` wrote",
    "the file is not a baked shadow: name one that `sandglass bake` wrote",
    "the shadow file is damaged or cut off (its checksum differs): copy or bake it again"};

bool numbers_within(const flatbuffers::Vector<float>& values, float low, float high) {
  return all_within(values.data(), values.size(), low, high);
}

// Null, or what is wrong.
const char* check_layer(const asset::Layer* layer, uint32_t inputs, uint32_t outputs, AssetLayer* out) {
  if (layer == nullptr || layer->weights() == nullptr || layer->bias() == nullptr || layer->multiplier() == nullptr)
    return "the shadow file lacks a layer of its network: bake it again.";
  if (layer->weights()->size() != inputs * outputs || layer->bias()->size() != outputs ||
      layer->multiplier()->size() != outputs)
    return "the shadow file has a layer of the wrong size: bake it again.";
  for (uint32_t i = 0; i < inputs * outputs; ++i)
    if (layer->weights()->data()[i] == -128) return "the shadow file has a weight of -128, which no baking writes.";
  for (uint32_t i = 0; i < outputs; ++i)
    if (layer->bias()->data()[i] < -k_bias_limit || layer->bias()->data()[i] > k_bias_limit)
      return "the shadow file has a bias beyond 2^24, which no baking writes.";
  if (!numbers_within(*layer->multiplier(), 0.0f, k_weight_limit))
    return "the shadow file has a multiplier that is not a number in 0..1e6, which no baking writes.";
  *out = {layer->weights()->data(), layer->bias()->data(), layer->multiplier()->data()};
  return nullptr;
}

const char* check_ambient(const asset::Ambient& file, AmbientAsset* out) {
  const uint32_t side = file.side(), components = file.components();
  if (side < 16 || side > k_ambient_side_limit || side % 16 != 0)
    return "the shadow file's ambient shadow does not have 16 to 256 texels a side, in steps of 16: bake it again.";
  if (components == 0 || components > k_ambient_components_limit)
    return "the shadow file's ambient shadow does not have 1 to 32 components: bake it again.";
  if (!within(file.half(), 1e-30, 1e30)) return "the shadow file's ambient shadow has no size: bake it again.";
  if (file.mixing() == nullptr || file.mixing()->size() != components * SANDGLASS_LIGHT_CELLS ||
      file.texels() == nullptr || file.texels()->size() != components * side * side)
    return "the shadow file's ambient shadow has the wrong size: bake it again.";
  if (!numbers_within(*file.mixing(), -k_mixing_limit, k_mixing_limit))
    return "the shadow file's ambient shadow has a weight that is not a number in -1..1: bake it again.";
  if (!within(static_cast<double>(file.rmse()), 0, 1))
    return "the shadow file's ambient error is not a number in 0..1: bake it again.";
  *out = {side, file.half(), components, file.mixing()->data(), file.texels()->data(), file.rmse()};
  return nullptr;
}

const char* check_surface(const asset::Surface& file, SurfaceAsset* out) {
  const uint32_t points = file.vertices();
  if (points == 0 || points > k_points_limit)
    return "the shadow file's surface does not have 1 to 2^24 points: bake it again.";
  if (file.positions() == nullptr || file.positions()->size() != 3 * points || file.normals() == nullptr ||
      file.normals()->size() != 3 * points || file.steps() == nullptr ||
      file.steps()->size() != k_surface_coefficients || file.transfer() == nullptr ||
      file.transfer()->size() != k_surface_coefficients * points)
    return "the shadow file's surface has the wrong size: bake it again.";
  if (!numbers_within(*file.steps(), 0.0f, 1.0f))
    return "the shadow file's surface has a step that is not a number in 0..1: bake it again.";
  *out = {points,
          {file.low_x(), file.low_y(), file.low_z()},
          file.step(),
          file.positions()->data(),
          file.normals()->data(),
          file.steps()->data(),
          file.transfer()->data()};
  if (!all_within(out->low, 3, -1e30f, 1e30f) || !within(out->step, 1e-30f, 1e30f))
    return "the shadow file's surface does not say where it is: bake it again.";
  for (uint32_t i = 1; i < points; ++i)
    if (out->positions[3 * i] < out->positions[3 * i - 3])
      return "the shadow file's surface is not in order, which no baking writes.";
  return nullptr;
}

// The object's size, and the lights that were baked for it.
const char* check_box(const asset::Box& box, ShadowAsset* out) {
  out->origin[0] = box.origin_x();
  out->origin[1] = box.origin_y();
  out->origin[2] = box.origin_z();
  out->box = {box.half_x(), box.half_z(), box.height()};
  out->angular_diameter = box.angular_diameter();
  out->polar_max = box.polar_max();
  for (const double x : out->origin)
    if (!within(x, -1e30, 1e30)) return "the shadow file's origin is not a number: bake it again.";
  if (!within(out->box.half_x, 0, 1e30) || !within(out->box.half_z, 0, 1e30) || !within(out->box.height, 1e-30, 1e30))
    return "the shadow file's box is not a size: bake it again.";
  if (!within(out->angular_diameter, 1e-4, k_horizon) || !within(out->polar_max, 1e-4, k_horizon) ||
      !(out->polar_max + 0.5 * out->angular_diameter <= k_horizon))
    return "the shadow file's light reaches the horizon: bake it with a smaller --max-polar.";
  return nullptr;
}

const char* check_network(const asset::Shadow& file, ShadowAsset* out) {
  out->texel_frequencies = file.texel_frequencies();
  out->light_frequencies = file.light_frequencies();
  out->width = file.width();
  if (out->texel_frequencies > k_frequencies_limit || out->light_frequencies > k_frequencies_limit)
    return "the shadow file's encoding has more than 16 frequencies, which no baking writes.";
  if (out->width == 0 || out->width > k_shadow_width_limit)
    return "the shadow file's network is wider than 256 neurons or has none: bake it again.";
  if (file.layers() == nullptr || file.layers()->size() == 0 || file.layers()->size() > k_shadow_layers_limit)
    return "the shadow file's network does not have 1 to 8 hidden layers: bake it again.";
  out->layers = file.layers()->size();
  if (file.first_weights() == nullptr || file.first_bias() == nullptr ||
      file.first_weights()->size() != out->inputs() * out->width || file.first_bias()->size() != out->width)
    return "the shadow file's first layer has the wrong size: bake it again.";
  if (!numbers_within(*file.first_weights(), -k_weight_limit, k_weight_limit) ||
      !numbers_within(*file.first_bias(), -k_weight_limit, k_weight_limit) ||
      !within(static_cast<double>(file.first_step()), 1e-9, 1e9))
    return "the shadow file's first layer has a weight that is not a number: bake it again.";
  out->first_weights = file.first_weights()->data();
  out->first_bias = file.first_bias()->data();
  out->first_step = file.first_step();
  for (uint32_t i = 0; i < out->layers; ++i)
    if (const char* fault = check_layer(file.layers()->Get(i), out->width, out->width, &out->layer[i])) return fault;
  if (const char* fault = check_layer(file.last(), out->width, 1, &out->last)) return fault;
  out->rmse_float = file.rmse_float();
  out->rmse_int8 = file.rmse_int8();
  if (!within(static_cast<double>(out->rmse_float), 0, 1) || !within(static_cast<double>(out->rmse_int8), 0, 1))
    return "the shadow file's error is not a number in 0..1: bake it again.";
  out->validated_lights = file.validated_lights();
  out->seed = file.seed();
  if (file.float_parameters() != nullptr) {
    const uint32_t expected =
        out->width * (out->inputs() + 1) + out->layers * out->width * (out->width + 1) + out->width + 1;
    if (file.float_parameters()->size() != expected ||
        !numbers_within(*file.float_parameters(), -k_weight_limit, k_weight_limit))
      return "the shadow file's float network has the wrong size or a weight that is not a number.";
    out->float_parameters = file.float_parameters()->data();
    out->float_parameter_count = expected;
  }
  return nullptr;
}

}  // namespace

sandglass_status open_shadow_asset(const void* bytes, uint64_t count, ShadowAsset* out, const char** reason) {
  if (const sandglass_status whole = check_asset_bytes(bytes, count, asset::ShadowIdentifier(), k_refusals, reason))
    return whole;
  const uint8_t* data = static_cast<const uint8_t*>(bytes);
  flatbuffers::Verifier verifier(data, count - k_checksum_bytes, 8, k_tables_limit);
  if (!asset::VerifyShadowBuffer(verifier))
    return refuse(reason, "the shadow file has an offset that leads outside of it: bake it again.");

  const asset::Shadow& file = *asset::GetShadow(data);
  if (file.version() < k_shadow_asset_oldest || file.version() > k_shadow_asset_version)
    return refuse(reason, "the shadow file is of another version than this library reads (1 and 2): bake it again.");
  if (file.box() == nullptr) return refuse(reason, "the shadow file says nothing of the object's size: bake it again.");
  *out = {};
  out->version = file.version();
  out->name = file.name() == nullptr ? "" : file.name()->c_str();
  out->plane = file.plane_fitted() ? PlaneRule::fitted : PlaneRule::fixed;
  if (const char* fault = check_box(*file.box(), out)) return refuse(reason, fault);
  if (const char* fault = check_network(file, out)) return refuse(reason, fault);
  if (out->version >= 2 && file.ambient() != nullptr)
    if (const char* fault = check_ambient(*file.ambient(), &out->ambient)) return refuse(reason, fault);
  if (out->version >= 2 && file.surface() != nullptr)
    if (const char* fault = check_surface(*file.surface(), &out->surface)) return refuse(reason, fault);
  return accept(reason);
}

}  // namespace sandglass
