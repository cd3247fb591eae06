// The C API around a Shadow: checks, layout, and what the texture looks like from outside.
#include <cstring>

#include "platform/floating_point.h"
#include "runtime/asset/shadow_asset.h"
#include "runtime/frame/create.h"
#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/hash.h"
#include "runtime/math/math.h"
#include "runtime/shadow/baked/pack.h"
#include "runtime/shadow/baked/shadow.h"
#include "runtime/shadow/receiver/light_direction.h"

namespace sandglass {
namespace {

// What a description and its asset say, and where the network is packed.
struct Maker {
  using Desc = sandglass_shadow_desc;
  using Handle = sandglass_shadow;
  ShadowAsset asset;
  const Int8Kernels* kernels;
  PackedShadow packed;
  sandglass_status check(const sandglass_shadow_desc& desc, const char** reason);
  sandglass_shadow* lay_out(const sandglass_shadow_desc& desc, Layout* layout);
  sandglass_status build(const sandglass_shadow_desc& desc, sandglass_shadow* handle, const char** reason) const;
};

sandglass_status Maker::check(const sandglass_shadow_desc& desc, const char** reason) {
  if (desc.mode != SANDGLASS_SHADOW_ADAPTIVE && desc.mode != SANDGLASS_SHADOW_FULL)
    return refuse(reason, "desc.mode is neither ADAPTIVE nor FULL.");
  if (desc.threshold > 255) return refuse(reason, "desc.threshold is not in 0..255, steps of coverage.");
  if (!(desc.light_tolerance >= 0 && desc.light_tolerance <= 1))
    return refuse(reason, "desc.light_tolerance is not in 0..1 radians.");
  if (desc.light_count == 0 || desc.light_count > SANDGLASS_SHADOW_LIGHTS)
    return refuse(reason, "desc.light_count is not in 1..8: set it to the number of lights.");
  kernels = select_shadow_kernels(desc.isa);
  if (kernels == nullptr)
    return refuse(reason, SANDGLASS_ERROR_UNSUPPORTED,
                  "desc.isa is not in this build or on this CPU: use SANDGLASS_ISA_AUTOMATIC.");
  return open_shadow_asset(desc.asset, desc.asset_bytes, &asset, reason);
}

// The one walk: counts the bytes, or hands out the regions.
sandglass_shadow* Maker::lay_out(const sandglass_shadow_desc& desc, Layout* layout) {
  const uint64_t width = shadow_padded_width(asset.width);
  sandglass_shadow* handle = layout_region<sandglass_shadow>(layout, "shadow.state", 1);
  Shadow nowhere = {};
  Shadow* s = handle == nullptr ? &nowhere : &handle->shadow;
  for (uint32_t i = 0; i < asset.layers; ++i) {
    packed.weights[i] = layout_region<int8_t>(layout, "shadow.weights", width * width);
    packed.bias[i] = layout_region<int32_t>(layout, "shadow.bias", width);
    packed.multiplier[i] = layout_region<float>(layout, "shadow.multiplier", width);
  }
  packed.last_weights = layout_region<int8_t>(layout, "shadow.last_weights", width);
  packed.coverage = layout_region<uint8_t>(layout, "shadow.sigmoid", k_coverage_steps);
  packed.light_weights = layout_region<float>(layout, "shadow.light_weights", 3 * asset.light_inputs() * width);
  packed.first_bias = layout_region<float>(layout, "shadow.first_bias", width);
  s->columns = layout_region<int16_t>(layout, "shadow.columns", k_table_rows * width);
  s->row_base = layout_region<int16_t>(layout, "shadow.row_base", k_table_rows * width);
  s->rows = layout_region<int16_t>(layout, "shadow.rows", k_table_rows * width);
  s->light_sums = layout_region<int16_t>(layout, "shadow.light_sums", width);
  s->coarse = layout_region<uint8_t>(layout, "shadow.coarse", k_grid * k_grid);
  s->marked = layout_region<uint8_t>(layout, "shadow.marked", k_cells * k_cells);
  s->refined = layout_region<uint16_t>(layout, "shadow.refined", k_cells * k_cells);
  s->unit_u = layout_region<uint16_t>(layout, "shadow.unit_u", k_unit_texels_max);
  s->unit_v = layout_region<uint16_t>(layout, "shadow.unit_v", k_unit_texels_max);
  s->unit_coverage = layout_region<uint8_t>(layout, "shadow.unit_coverage", k_unit_texels_max);
  s->scratch = layout_region<uint8_t>(layout, "shadow.activations", shadow_scratch_bytes(static_cast<uint32_t>(width)));
  s->lights = layout_region<ShadowLight>(layout, "shadow.lights", desc.light_count);
  for (uint32_t i = 0; i < desc.light_count; ++i) {
    uint8_t* front = layout_region<uint8_t>(layout, "shadow.front", k_shadow_size * k_shadow_size);
    if (front == nullptr) continue;
    s->lights[i] = {};
    s->lights[i].front.coverage = front;
  }
  s->back.coverage = layout_region<uint8_t>(layout, "shadow.back", k_shadow_size * k_shadow_size);
  ambient_lay_out(asset.ambient, layout, &s->ambient);
  return handle;
}

void describe(const ShadowAsset& asset, const sandglass_shadow_desc& desc, Shadow* s) {
  for (uint32_t axis = 0; axis < 3; ++axis) s->origin[axis] = asset.origin[axis];
  s->box = asset.box;
  s->plane = asset.plane;
  s->polar_max = asset.polar_max;
  const double turn = 1 / (2 * k_pi);
  const SinCos half = sin_cos_turns(0.5 * asset.angular_diameter * turn), polar = sin_cos_turns(asset.polar_max * turn);
  const SinCos steepest = sin_cos_turns((asset.polar_max + 0.5 * asset.angular_diameter) * turn);
  s->half_sine = half.sin;
  s->reach = steepest.sin / steepest.cos;
  s->polar_sine = polar.sin;
  s->polar_cosine = polar.cos;
  s->light_frequencies = asset.light_frequencies;
  s->mode = desc.mode;
  s->threshold = desc.threshold;
  s->tolerance_squared = static_cast<double>(desc.light_tolerance) * static_cast<double>(desc.light_tolerance);
}

sandglass_status Maker::build(const sandglass_shadow_desc& desc, sandglass_shadow* handle, const char** reason) const {
  handle->member.capability = &k_shadow_capability;
  Shadow* s = &handle->shadow;
  s->kernels = kernels;
  s->light_count = desc.light_count;
  describe(asset, desc, s);
  s->network.width = shadow_padded_width(asset.width);
  s->network.layers = asset.layers;
  s->network.columns = s->columns;
  s->network.rows = s->rows;
  s->network.last_weights = packed.last_weights;
  s->network.last_bias = asset.last.bias[0];
  s->network.last_multiplier = asset.last.multiplier[0] * k_coverage_scale;
  s->network.coverage = packed.coverage;
  s->light_weights = packed.light_weights;
  s->first_bias = packed.first_bias;
  pack_shadow_network(asset, packed, s);
  const uint64_t blocks = k_unit_macs / (k_texel_block * asset.layers * s->network.width * s->network.width);
  s->unit_texels = k_texel_block * static_cast<uint32_t>(blocks < 1 ? 1 : blocks > 6 ? 6 : blocks);
  ambient_create(asset.ambient, &s->ambient);
  return accept(reason);
}

__attribute__((noinline)) sandglass_status take_light(Shadow* s, uint32_t number, const float direction[3],
                                                      float irradiance, const char** reason) {
  if (!(irradiance >= 0 && is_finite(irradiance))) return refuse(reason, "irradiance is negative or not finite.");
  double light[3];
  if (const sandglass_status status = check_light_direction(direction, light, reason)) return status;
  const double length = square_root(light[0] * light[0] + light[1] * light[1] + light[2] * light[2]);
  for (double& x : light) x /= length;
  shadow_set_light(s, number, light, irradiance);
  return accept(reason);
}

void fill_info(const ShadowAsset& asset, sandglass_shadow_info* out) {
  sandglass_shadow_info info = {};
  info.version = asset.version;
  for (uint32_t axis = 0; axis < 3; ++axis) info.origin[axis] = static_cast<float>(asset.origin[axis]);
  info.half_x = static_cast<float>(asset.box.half_x);
  info.half_z = static_cast<float>(asset.box.half_z);
  info.height = static_cast<float>(asset.box.height);
  info.angular_diameter = static_cast<float>(asset.angular_diameter);
  info.polar_max = static_cast<float>(asset.polar_max);
  info.plane_fitted = asset.plane == PlaneRule::fitted ? 1 : 0;
  info.width = asset.width;
  info.layers = asset.layers;
  info.macs_per_texel = uint64_t{asset.width} * (asset.layers * asset.width + 1);
  info.rmse_float = asset.rmse_float;
  info.rmse_int8 = asset.rmse_int8;
  info.validated_lights = asset.validated_lights;
  info.float_parameters = asset.float_parameter_count;
  info.ambient_texels = asset.ambient.components == 0 ? 0 : asset.ambient.side;
  info.ambient_half = static_cast<float>(asset.ambient.half);
  info.ambient_components = asset.ambient.components;
  info.ambient_rmse = asset.ambient.rmse;
  info.surface_vertices = asset.surface.vertices;
  fill_struct(&info, sizeof info, out);
}

void fill_texture(const Shadow& s, uint32_t light, sandglass_texture* out) {
  sandglass_texture texture = {};
  texture.layers = 1;
  if (light < s.light_count) {
    const ShadowLight& l = s.lights[light];
    const ShadowTexture& t = l.front;
    texture.valid = t.valid ? 1 : 0;
    texture.bytes = t.coverage;
    texture.side = SANDGLASS_SHADOW_TEXELS;
    texture.corner[0] = static_cast<float>(t.rectangle.low_x + s.origin[0]);
    texture.corner[1] = static_cast<float>(s.origin[1]);
    texture.corner[2] = static_cast<float>(t.rectangle.low_z + s.origin[2]);
    texture.along[0] = static_cast<float>(t.rectangle.high_x - t.rectangle.low_x);
    texture.across[2] = static_cast<float>(t.rectangle.high_z - t.rectangle.low_z);
    for (uint32_t axis = 0; axis < 3; ++axis) texture.light[axis] = static_cast<float>(t.light[axis]);
    texture.scale = l.opacity;
    const bool under_way = s.phase != ShadowPhase::idle && s.active == light;
    texture.behind = l.pending || under_way ? static_cast<uint32_t>(l.calls - t.light_call) : 0;
    texture.version = t.version;
  }
  fill_struct(&texture, sizeof texture, out);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

void sandglass_shadow_desc_default(sandglass_shadow_desc* desc) {
  if (!empty_struct(desc)) return;
  desc->threshold = 48;
  desc->light_tolerance = 0.01f;
  desc->light_count = 1;
}

sandglass_status sandglass_shadow_inspect(const void* bytes, uint64_t count, sandglass_shadow_info* info,
                                          const char** reason) {
  if (info == nullptr || !can_fill(info))
    return refuse(reason, "info is NULL or its struct_size is not set: set it to sizeof(sandglass_shadow_info).");
  ShadowAsset asset;
  if (const sandglass_status status = open_shadow_asset(bytes, count, &asset, reason)) return status;
  fill_info(asset, info);
  return SANDGLASS_OK;
}

sandglass_status sandglass_shadow_bytes(const sandglass_shadow_desc* desc, uint64_t* bytes, const char** reason) {
  return bytes_of<Maker>(desc, bytes, reason);
}

sandglass_status sandglass_shadow_create(const sandglass_shadow_desc* desc, void* block, uint64_t bytes,
                                         sandglass_shadow** shadow, const char** reason) {
  return create_in<Maker>(desc, block, bytes, shadow, "shadow is NULL: pass where to store it.", reason);
}

sandglass_status sandglass_shadow_set_light(sandglass_shadow* shadow, uint32_t light, const float direction[3],
                                            float irradiance, const char** reason) {
  if (shadow == nullptr || direction == nullptr)
    return refuse(reason, "shadow or direction is NULL: pass the shadow and 3 floats.");
  if (light >= shadow->shadow.light_count)
    return refuse(reason, "light is not below the light_count of the description: count from 0.");
  const ExactFloatingPoint exact;
  return take_light(&shadow->shadow, light, direction, irradiance, reason);
}

uint32_t sandglass_shadow_run(sandglass_shadow* const* shadows, uint32_t count, uint32_t units) {
  if (shadows == nullptr) return 0;
  for (uint32_t i = 0; i < count; ++i)
    if (shadows[i] == nullptr) return 0;
  const ExactFloatingPoint exact;
  return run_members(Members{shadows, count, k_shadow_kinds}, units);
}

uint32_t sandglass_shadow_units_left(const sandglass_shadow* shadow) {
  if (shadow == nullptr) return 0;
  const Shadow& s = shadow->shadow;
  const ShadowWork left = shadow_work_left(s, false);
  uint32_t waiting = 0;
  for (uint32_t i = 0; i < s.light_count; ++i) waiting += s.lights[i].pending ? 1 : 0;
  // In every texture the last unit of each kind may be smaller than the others: one more for each that waits.
  uint32_t units = ambient_units_left(s.ambient);
  for (uint32_t kind = 0; kind < k_kind_ambient; ++kind) {
    const uint32_t pieces = shadow_unit(s, kind).pieces;
    if (left.pieces[kind] != 0) units += static_cast<uint32_t>((left.pieces[kind] + pieces - 1) / pieces) + waiting;
  }
  return units;
}

void sandglass_shadow_get_texture(const sandglass_shadow* shadow, uint32_t light, sandglass_texture* texture) {
  if (shadow != nullptr && texture != nullptr) fill_texture(shadow->shadow, light, texture);
}

uint32_t sandglass_shadow_evaluated(const sandglass_shadow* shadow, uint32_t light) {
  return shadow != nullptr && light < shadow->shadow.light_count ? shadow->shadow.lights[light].front.evaluated : 0;
}

uint64_t sandglass_shadow_hash(const sandglass_shadow* shadow) {
  if (shadow == nullptr) return 0;
  uint64_t hash = k_hash_basis;
  for (uint32_t i = 0; i < shadow->shadow.light_count; ++i) {
    const ShadowTexture& t = shadow->shadow.lights[i].front;
    hash = hash_with(hash, hash_bytes(t.coverage, k_shadow_size * k_shadow_size));
    hash = hash_with(hash, hash_bytes(t.light, sizeof t.light));
  }
  const AmbientShadow& ambient = shadow->shadow.ambient;
  if (ambient.components.count != 0) hash = hash_with(hash, hash_bytes(ambient.front, ambient.components.size));
  return hash;
}

sandglass_isa sandglass_shadow_isa(const sandglass_shadow* shadow) {
  return shadow == nullptr ? SANDGLASS_ISA_AUTOMATIC : shadow->shadow.kernels->isa;
}
