// The C API around a Shadow: checks, layout, tables, and what the texture looks like from outside.
#include <cstring>

#include "platform/floating_point.h"
#include "runtime/asset/shadow_asset.h"
#include "runtime/core/filled_struct.h"
#include "runtime/core/finite.h"
#include "runtime/core/hash.h"
#include "runtime/core/math.h"
#include "runtime/core/refuse.h"
#include "runtime/shadow/light_direction.h"
#include "runtime/shadow/shadow.h"

namespace sandglass {
namespace {

constexpr uint32_t k_shift_limit = 6;  // steps finer than 1/64 of a byte's change nothing
constexpr double k_table_limit = 32000;

uint32_t padded(uint32_t width) { return (width + k_channel_group - 1) / k_channel_group * k_channel_group; }

sandglass_status check(const sandglass_shadow_desc* desc, ShadowAsset* asset, const Int8Kernels** kernels,
                       const char** reason) {
  if (desc == nullptr) return refuse(reason, "desc is NULL: start from sandglass_shadow_desc_default");
  if (desc->struct_size != sizeof *desc)
    return refuse(reason, "desc.struct_size is not that of this library: start from sandglass_shadow_desc_default");
  if (desc->mode != SANDGLASS_SHADOW_ADAPTIVE && desc->mode != SANDGLASS_SHADOW_FULL)
    return refuse(reason, "desc.mode is neither ADAPTIVE nor FULL");
  if (desc->threshold > 255) return refuse(reason, "desc.threshold is not in 0..255, steps of coverage");
  if (!(desc->light_tolerance >= 0 && desc->light_tolerance <= 1))
    return refuse(reason, "desc.light_tolerance is not in 0..1 radians");
  if (desc->light_count == 0 || desc->light_count > SANDGLASS_SHADOW_LIGHTS)
    return refuse(reason, "desc.light_count is not in 1..8");
  *kernels = select_shadow_kernels(desc->isa);
  if (*kernels == nullptr)
    return refuse(reason, SANDGLASS_ERROR_UNSUPPORTED,
                  "desc.isa is not in this build or on this CPU: use SANDGLASS_ISA_AUTOMATIC");
  return open_shadow_asset(desc->asset, desc->asset_bytes, asset, reason);
}

struct Packed {
  int8_t* weights[k_shadow_layers_limit];
  int32_t* bias[k_shadow_layers_limit];
  float* multiplier[k_shadow_layers_limit];
  int8_t* last_weights;
  uint8_t* coverage;
  float *light_weights, *first_bias;
};

// The one walk: counts the bytes, or hands out the regions.
sandglass_shadow* lay_out(const ShadowAsset& asset, uint32_t light_count, Layout* layout, Packed* packed) {
  const uint64_t width = padded(asset.width);
  sandglass_shadow* owner = layout_region<sandglass_shadow>(layout, "shadow.state", 1);
  Shadow nowhere = {};
  Shadow* s = owner == nullptr ? &nowhere : &owner->shadow;
  if (owner != nullptr) *s = {};
  for (uint32_t i = 0; i < asset.layers; ++i) {
    packed->weights[i] = layout_region<int8_t>(layout, "shadow.weights", width * width);
    packed->bias[i] = layout_region<int32_t>(layout, "shadow.bias", width);
    packed->multiplier[i] = layout_region<float>(layout, "shadow.multiplier", width);
  }
  packed->last_weights = layout_region<int8_t>(layout, "shadow.last_weights", width);
  packed->coverage = layout_region<uint8_t>(layout, "shadow.sigmoid", k_coverage_steps);
  packed->light_weights = layout_region<float>(layout, "shadow.light_weights", 3 * asset.light_inputs() * width);
  packed->first_bias = layout_region<float>(layout, "shadow.first_bias", width);
  s->columns = layout_region<int16_t>(layout, "shadow.columns", k_table_rows * width);
  s->row_base = layout_region<int16_t>(layout, "shadow.row_base", k_table_rows * width);
  s->rows = layout_region<int16_t>(layout, "shadow.rows", k_table_rows * width);
  s->light_sums = layout_region<int16_t>(layout, "shadow.light_sums", width);
  s->coarse = layout_region<uint8_t>(layout, "shadow.coarse", k_grid * k_grid);
  s->marked = layout_region<uint8_t>(layout, "shadow.marked", k_cells * k_cells);
  s->refined = layout_region<uint16_t>(layout, "shadow.refined", k_cells * k_cells);
  s->unit_u = layout_region<uint16_t>(layout, "shadow.unit_u", k_unit_texels_most);
  s->unit_v = layout_region<uint16_t>(layout, "shadow.unit_v", k_unit_texels_most);
  s->unit_coverage = layout_region<uint8_t>(layout, "shadow.unit_coverage", k_unit_texels_most);
  s->scratch = layout_region<uint8_t>(layout, "shadow.activations", shadow_scratch_bytes(static_cast<uint32_t>(width)));
  s->lights = layout_region<ShadowLight>(layout, "shadow.lights", light_count);
  for (uint32_t i = 0; i < light_count; ++i) {
    uint8_t* front = layout_region<uint8_t>(layout, "shadow.front", k_shadow_size * k_shadow_size);
    if (front == nullptr) continue;
    s->lights[i] = {};
    s->lights[i].front.coverage = front;
    memset(front, 0, k_shadow_size * k_shadow_size);
  }
  s->back.coverage = layout_region<uint8_t>(layout, "shadow.back", k_shadow_size * k_shadow_size);
  return owner;
}

// One row of a table, in double and in units of activation: the encoded texel coordinate times its weights.
void table_row(const float* weights, uint32_t width, uint32_t frequencies, uint32_t index, double* sums) {
  const double x = texel_centre(index, k_shadow_size);
  for (uint32_t c = 0; c < width; ++c) sums[c] = x * static_cast<double>(weights[c]);
  double turns = 0.5 * x;
  for (uint32_t k = 0; k < frequencies; ++k, turns *= 2) {
    const SinCos wave = sin_cos_turns(turns);
    const float *sine = weights + (1 + 2 * k) * width, *cosine = sine + width;
    for (uint32_t c = 0; c < width; ++c)
      sums[c] += wave.sin * static_cast<double>(sine[c]) + wave.cos * static_cast<double>(cosine[c]);
  }
}

int16_t table_entry(double x) {
  x = x < -32767 ? -32767 : x > 32767 ? 32767 : x;
  return static_cast<int16_t>(floor_index(x + 0.5));
}

// The finest shift at which the table entries of every channel fit 16 bits, whatever the texel and the light. Out of
// line, so that its arrays do not lie on the stack beside those of fill_tables.
__attribute__((noinline)) uint32_t choose_shift(const ShadowAsset& asset) {
  double sums[k_shadow_width_limit], column_most[k_shadow_width_limit] = {}, row_most[k_shadow_width_limit] = {};
  const uint32_t width = asset.width;
  const float* row_weights = asset.first_weights + asset.texel_inputs() * width;
  for (uint32_t i = 0; i < k_table_rows; ++i) {
    table_row(asset.first_weights, width, asset.texel_frequencies, i, sums);
    for (uint32_t c = 0; c < width; ++c)
      column_most[c] = absolute(sums[c]) > column_most[c] ? absolute(sums[c]) : column_most[c];
    table_row(row_weights, width, asset.texel_frequencies, i, sums);
    for (uint32_t c = 0; c < width; ++c)
      row_most[c] = absolute(sums[c]) > row_most[c] ? absolute(sums[c]) : row_most[c];
  }
  const float* light_weights = row_weights + asset.texel_inputs() * width;
  double most = 0;
  for (uint32_t c = 0; c < width; ++c) {
    double sum = column_most[c] + row_most[c] + absolute(static_cast<double>(asset.first_bias[c]));
    for (uint32_t i = 0; i < 3 * asset.light_inputs(); ++i)
      sum += absolute(static_cast<double>(light_weights[i * width + c]));
    most = sum > most ? sum : most;
  }
  uint32_t shift = k_shift_limit;
  while (shift > 0 && most * static_cast<double>(1u << shift) > k_table_limit * static_cast<double>(asset.first_step))
    --shift;
  return shift;
}

__attribute__((noinline)) void fill_tables(const ShadowAsset& asset, Shadow* s, const Packed& packed) {
  const uint32_t own = asset.width, width = s->network.width;
  s->table_scale = static_cast<double>(1u << s->network.shift) / static_cast<double>(asset.first_step);
  double sums[k_shadow_width_limit];
  for (uint32_t part = 0; part < 2; ++part) {
    int16_t* table = part == 0 ? s->columns : s->row_base;
    const float* weights = asset.first_weights + part * asset.texel_inputs() * own;
    for (uint32_t i = 0; i < k_table_rows; ++i) {
      table_row(weights, own, asset.texel_frequencies, i, sums);
      for (uint32_t c = 0; c < width; ++c)
        table[i * width + c] = c < own ? table_entry(sums[c] * s->table_scale) : int16_t{0};
    }
  }
  const float* light = asset.first_weights + 2 * asset.texel_inputs() * own;
  for (uint32_t i = 0; i < 3 * asset.light_inputs(); ++i)
    for (uint32_t c = 0; c < width; ++c) packed.light_weights[i * width + c] = c < own ? light[i * own + c] : 0.0f;
  for (uint32_t c = 0; c < width; ++c) packed.first_bias[c] = c < own ? asset.first_bias[c] : 0.0f;
}

// Packs the weights for this CPU. Each row first grows to the padded width; the memory of `rows`, which is free until
// the first texture, serves as scratch.
void pack_layers(const ShadowAsset& asset, Shadow* s, const Packed& packed) {
  const uint32_t own = asset.width, width = s->network.width;
  static_assert(k_table_rows * sizeof(int16_t) > k_shadow_width_limit + sizeof(int32_t));
  int8_t* grown = reinterpret_cast<int8_t*>(s->rows);
  int32_t* grown_bias = reinterpret_cast<int32_t*>(grown + width * width);
  for (uint32_t i = 0; i < asset.layers; ++i) {
    memset(grown, 0, width * width);
    memset(grown_bias, 0, width * sizeof *grown_bias);
    for (uint32_t c = 0; c < width; ++c) packed.multiplier[i][c] = 0;
    for (uint32_t c = 0; c < own; ++c) {
      memcpy(grown + c * width, asset.layer[i].weights + c * own, own);
      grown_bias[c] = asset.layer[i].bias[c];
      packed.multiplier[i][c] = asset.layer[i].multiplier[c];
    }
    s->kernels->pack_layer(grown, grown_bias, width, width, packed.weights[i], packed.bias[i]);
    s->network.layer[i] = {packed.weights[i], packed.bias[i], packed.multiplier[i]};
  }
  memset(packed.last_weights, 0, width);
  memcpy(packed.last_weights, asset.last.weights, own);
}

// Coverage is 1 - sigmoid(x) = 1/(1 + e^x) at x = (i - half)/256. The powers of e^(1/256) come from repeated
// multiplication, from the middle outward; each is correct to 1e-12.
void fill_coverage(uint8_t* coverage) {
  constexpr double k_factor = 1.0039138893383475;  // e^(1/256)
  constexpr uint32_t k_half = k_coverage_steps / 2;
  double power = 1;
  for (uint32_t i = 0; i <= k_half; ++i, power *= k_factor) {
    const double share = 1 / (1 + power);
    if (i < k_half) coverage[k_half + i] = static_cast<uint8_t>(255 * share + 0.5);
    coverage[k_half - i] = static_cast<uint8_t>(255 * (1 - share) + 0.5);
  }
}

void describe(const ShadowAsset& asset, const sandglass_shadow_desc& desc, Shadow* s) {
  for (uint32_t axis = 0; axis < 3; ++axis) s->origin[axis] = asset.origin[axis];
  s->box = asset.box;
  s->plane = asset.plane;
  s->polar_max = asset.polar_max;
  const double turn = 1 / (2 * k_pi);
  const SinCos half = sin_cos_turns(0.5 * asset.angular_diameter * turn), polar = sin_cos_turns(asset.polar_max * turn);
  const SinCos most = sin_cos_turns((asset.polar_max + 0.5 * asset.angular_diameter) * turn);
  s->half_sine = half.sin;
  s->reach = most.sin / most.cos;
  s->polar_sine = polar.sin, s->polar_cosine = polar.cos;
  s->light_frequencies = asset.light_frequencies;
  s->mode = desc.mode;
  s->threshold = desc.threshold;
  s->tolerance_squared = static_cast<double>(desc.light_tolerance) * static_cast<double>(desc.light_tolerance);
}

// Out of line, so that its layout does not lie on the stack beside that of build.
__attribute__((noinline)) sandglass_status size_of(const ShadowAsset& asset, const sandglass_shadow_desc& desc,
                                                   uint64_t* bytes, const char** reason) {
  Layout layout;
  Packed packed;
  lay_out(asset, desc.light_count, &layout, &packed);
  *bytes = layout.size;
  return accept(reason);
}

__attribute__((noinline)) void build(const ShadowAsset& asset, const sandglass_shadow_desc& desc,
                                     const Int8Kernels* kernels, void* block, sandglass_shadow** shadow) {
  Layout layout;
  layout.base = static_cast<uint8_t*>(block);
  Packed packed;
  sandglass_shadow* owner = lay_out(asset, desc.light_count, &layout, &packed);
  owner->functions = &k_shadow_functions;
  Shadow* s = &owner->shadow;
  s->kernels = kernels;
  s->light_count = desc.light_count;
  describe(asset, desc, s);
  s->network.width = padded(asset.width);
  s->network.layers = asset.layers;
  s->network.columns = s->columns, s->network.rows = s->rows;
  s->network.last_weights = packed.last_weights;
  s->network.last_bias = asset.last.bias[0];
  s->network.last_multiplier = asset.last.multiplier[0] * k_coverage_scale;
  s->network.coverage = packed.coverage;
  s->light_weights = packed.light_weights, s->first_bias = packed.first_bias;
  s->network.shift = choose_shift(asset);
  fill_tables(asset, s, packed);
  pack_layers(asset, s, packed);
  fill_coverage(packed.coverage);
  const uint64_t blocks = k_unit_macs / (k_texel_block * asset.layers * s->network.width * s->network.width);
  s->unit_texels = k_texel_block * static_cast<uint32_t>(blocks < 1 ? 1 : blocks > 6 ? 6 : blocks);
  memset(s->back.coverage, 0, k_shadow_size * k_shadow_size);
  *shadow = owner;
}

__attribute__((noinline)) uint32_t run_units(ShadowSet set, uint32_t units) {
  const Stage stage = shadow_set_stage(&set);
  WorkUnit unit;
  uint32_t done = 0;
  while (done < units && stage.next(stage.state, 0, &unit)) stage.run(stage.state, 0), ++done;
  return done;
}

__attribute__((noinline)) sandglass_status take_light(Shadow* s, uint32_t number, const float direction[3],
                                                      float irradiance, const char** reason) {
  if (!(irradiance >= 0 && is_finite(irradiance))) return refuse(reason, "irradiance is negative or not finite");
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
  info.half_x = static_cast<float>(asset.box.half_x), info.half_z = static_cast<float>(asset.box.half_z);
  info.height = static_cast<float>(asset.box.height);
  info.angular_diameter = static_cast<float>(asset.angular_diameter);
  info.polar_max = static_cast<float>(asset.polar_max);
  info.plane_fitted = asset.plane == PlaneRule::fitted ? 1 : 0;
  info.width = asset.width, info.layers = asset.layers;
  info.macs_per_texel = uint64_t{asset.width} * (asset.layers * asset.width + 1);
  info.rmse_float = asset.rmse_float, info.rmse_int8 = asset.rmse_int8;
  info.validated_lights = asset.validated_lights;
  info.float_parameters = asset.float_parameter_count;
  fill_struct(&info, sizeof info, out);
}

void fill_texture(const Shadow& s, uint32_t light, sandglass_shadow_texture* out) {
  sandglass_shadow_texture texture = {};
  if (light < s.light_count) {
    const ShadowLight& l = s.lights[light];
    const ShadowTexture& t = l.front;
    texture.valid = t.valid ? 1 : 0;
    texture.coverage = t.coverage;
    texture.low[0] = static_cast<float>(t.rectangle.low_x + s.origin[0]);
    texture.low[1] = static_cast<float>(t.rectangle.low_z + s.origin[2]);
    texture.high[0] = static_cast<float>(t.rectangle.high_x + s.origin[0]);
    texture.high[1] = static_cast<float>(t.rectangle.high_z + s.origin[2]);
    for (uint32_t axis = 0; axis < 3; ++axis) texture.light[axis] = static_cast<float>(t.light[axis]);
    texture.opacity = l.opacity;
    texture.beyond = l.beyond ? 1 : 0;
    const bool under_way = s.phase != ShadowPhase::idle && s.active == light;
    texture.age = l.pending || under_way ? static_cast<uint32_t>(l.calls - t.light_call) : 0;
    texture.evaluated = t.evaluated;
  }
  fill_struct(&texture, sizeof texture, out);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

void sandglass_shadow_desc_default(sandglass_shadow_desc* desc) {
  if (desc == nullptr) return;
  *desc = {};
  desc->struct_size = sizeof *desc;
  desc->threshold = 48;
  desc->light_tolerance = 0.01f;
  desc->light_count = 1;
}

sandglass_status sandglass_shadow_inspect(const void* bytes, uint64_t count, sandglass_shadow_info* info,
                                          const char** reason) {
  if (info == nullptr || !can_fill(info))
    return refuse(reason, "info is NULL or its struct_size is not set: set it to sizeof(sandglass_shadow_info)");
  ShadowAsset asset;
  const sandglass_status status = open_shadow_asset(bytes, count, &asset, reason);
  if (status != SANDGLASS_OK) return status;
  fill_info(asset, info);
  return SANDGLASS_OK;
}

sandglass_status sandglass_shadow_bytes(const sandglass_shadow_desc* desc, uint64_t* bytes, const char** reason) {
  ShadowAsset asset;
  const Int8Kernels* kernels = nullptr;
  const sandglass_status status = check(desc, &asset, &kernels, reason);
  if (status != SANDGLASS_OK) return status;
  if (bytes == nullptr) return refuse(reason, "bytes is NULL: pass where to store it");
  return size_of(asset, *desc, bytes, reason);
}

sandglass_status sandglass_shadow_create(const sandglass_shadow_desc* desc, void* block, uint64_t bytes,
                                         sandglass_shadow** shadow, const char** reason) {
  ShadowAsset asset;
  const Int8Kernels* kernels = nullptr;
  const sandglass_status status = check(desc, &asset, &kernels, reason);
  if (status != SANDGLASS_OK) return status;
  uint64_t need = 0;
  (void)size_of(asset, *desc, &need, reason);
  if (shadow == nullptr) return refuse(reason, "shadow is NULL: pass where to store it");
  const sandglass_status usable = check_block(block, bytes, need, reason);
  if (usable != SANDGLASS_OK) return usable;
  const FloatingPointControl saved = floating_point_enter();
  build(asset, *desc, kernels, block, shadow);
  floating_point_restore(saved);
  return accept(reason);
}

sandglass_status sandglass_shadow_set_light(sandglass_shadow* shadow, uint32_t light, const float direction[3],
                                            float irradiance, const char** reason) {
  if (shadow == nullptr || direction == nullptr)
    return refuse(reason, "shadow or direction is NULL: pass the shadow and 3 floats");
  if (light >= shadow->shadow.light_count)
    return refuse(reason, "light is not below the light_count of the description");
  const FloatingPointControl saved = floating_point_enter();
  const sandglass_status status = take_light(&shadow->shadow, light, direction, irradiance, reason);
  floating_point_restore(saved);
  return status;
}

uint32_t sandglass_shadow_run(sandglass_shadow* const* shadows, uint32_t count, uint32_t units) {
  if (shadows == nullptr) return 0;
  for (uint32_t i = 0; i < count; ++i)
    if (shadows[i] == nullptr) return 0;
  const FloatingPointControl saved = floating_point_enter();
  const uint32_t done = run_units({shadows, count}, units);
  floating_point_restore(saved);
  return done;
}

uint32_t sandglass_shadow_units_left(const sandglass_shadow* shadow) {
  if (shadow == nullptr) return 0;
  const Shadow& s = shadow->shadow;
  const ShadowWork left = shadow_work_left(s, false);
  uint32_t waiting = 0;
  for (uint32_t i = 0; i < s.light_count; ++i) waiting += s.lights[i].pending ? 1 : 0;
  // In every texture the last unit of each kind may be smaller than the others: one more for each that waits.
  uint32_t units = 0;
  for (uint32_t kind = 0; kind < k_shadow_kinds; ++kind) {
    const uint32_t pieces = shadow_unit(s, kind).pieces;
    if (left.pieces[kind] != 0) units += static_cast<uint32_t>((left.pieces[kind] + pieces - 1) / pieces) + waiting;
  }
  return units;
}

void sandglass_shadow_get_texture(const sandglass_shadow* shadow, uint32_t light, sandglass_shadow_texture* texture) {
  if (shadow != nullptr && texture != nullptr) fill_texture(shadow->shadow, light, texture);
}

uint64_t sandglass_shadow_hash(const sandglass_shadow* shadow) {
  if (shadow == nullptr) return 0;
  uint64_t hash = k_hash_basis;
  for (uint32_t i = 0; i < shadow->shadow.light_count; ++i) {
    const ShadowTexture& t = shadow->shadow.lights[i].front;
    hash = hash_with(hash, hash_bytes(t.coverage, k_shadow_size * k_shadow_size));
    hash = hash_with(hash, hash_bytes(t.light, sizeof t.light));
  }
  return hash;
}

sandglass_isa sandglass_shadow_isa(const sandglass_shadow* shadow) {
  return shadow == nullptr ? SANDGLASS_ISA_AUTOMATIC : shadow->shadow.kernels->isa;
}
