// See ambient.h. What a texel loses is a sum over the cells, each times 0 to 1. So no texel changes by a whole step of
// its byte while the sum of all rises of cells and the sum of all falls are both below 1 / 255.
#include "runtime/shadow/baked/ambient.h"

#include <cstring>

#include "platform/floating_point.h"
#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/shadow/baked/shadow.h"

namespace sandglass {
namespace {

constexpr float k_yaw_limit = 1e6f;  // beyond it a float says nothing of a direction

uint32_t even(uint32_t count) { return count + count % 2; }
uint64_t texels_of(const AmbientShadow& ambient) { return uint64_t{ambient.side} * ambient.side; }

// The finest steps in which no weight leaves 16 bits, whatever the cells.
void choose_steps(const AmbientAsset& asset, AmbientShadow* ambient) {
  double largest = 0;
  for (uint32_t i = 0; i < asset.components * SANDGLASS_LIGHT_CELLS; ++i) {
    const double weight = absolute(static_cast<double>(asset.mixing[i]));
    largest = weight > largest ? weight : largest;
  }
  uint32_t shift = 1;
  double scale = 2 * 255.0;
  for (; shift < k_ambient_shift_limit && largest * (1 + k_cells_slack) * 2 * scale < 32767; scale *= 2) ++shift;
  ambient->components.shift = shift;
  ambient->weight_scale = scale;
}

void begin_texture(AmbientShadow* ambient) {
  for (uint32_t k = 0; k < ambient->components.count; ++k) {
    const float* mixing = ambient->mixing + k * SANDGLASS_LIGHT_CELLS;
    double sum = 0;
    for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) sum += static_cast<double>(mixing[i]) * ambient->wanted[i];
    const int64_t weight = floor_index(sum * ambient->weight_scale + 0.5);
    ambient->weights[k] = static_cast<int16_t>(weight < -32767 ? -32767 : weight > 32767 ? 32767 : weight);
  }
  ambient->pending = false;
  ambient->under_way = true;
  ambient->cursor = 0;
  ambient->begun_call = ambient->calls;
}

void end_texture(AmbientShadow* ambient) {
  uint8_t* const swap = ambient->front;
  ambient->front = ambient->back;
  ambient->back = swap;
  ambient->front_call = ambient->begun_call;
  ambient->under_way = false;
  ambient->valid = true;
  ambient->gives_way = true;
  ++ambient->completed;
}

__attribute__((noinline)) sandglass_status take_cells(AmbientShadow* ambient, const float* cells, float yaw,
                                                      const char** reason) {
  if (const sandglass_status status = check_cells(cells, reason)) return status;
  if (!within(yaw, -k_yaw_limit, k_yaw_limit)) return refuse(reason, "yaw is not a number of radians within 1e6.");
  if (ambient->components.count != 0) ambient_set_cells(ambient, cells, yaw);
  return accept(reason);
}

}  // namespace

void ambient_lay_out(const AmbientAsset& asset, Layout* layout, AmbientShadow* ambient) {
  const uint64_t components = even(asset.components), texels = uint64_t{asset.side} * asset.side;
  int8_t* const copy = layout_region<int8_t>(layout, "shadow.ambient.components", components * texels);
  float* const mixing = layout_region<float>(layout, "shadow.ambient.mixing", components * SANDGLASS_LIGHT_CELLS);
  ambient->components.texels = copy;
  ambient->mixing = mixing;
  ambient->weights = layout_region<int16_t>(layout, "shadow.ambient.weights", components);
  ambient->front = layout_region<uint8_t>(layout, "shadow.ambient.front", texels);
  ambient->back = layout_region<uint8_t>(layout, "shadow.ambient.back", texels);
  if (copy == nullptr) return;
  const uint64_t used = asset.components * texels, weights = asset.components * SANDGLASS_LIGHT_CELLS;
  memcpy(copy, asset.texels, used);
  memset(copy + used, 0, components * texels - used);
  memcpy(mixing, asset.mixing, weights * sizeof(float));
  memset(mixing + weights, 0, (components * SANDGLASS_LIGHT_CELLS - weights) * sizeof(float));
}

void ambient_create(const AmbientAsset& asset, AmbientShadow* ambient) {
  if (asset.components == 0) return;
  ambient->side = asset.side;
  ambient->half = asset.half;
  ambient->components.size = static_cast<uint32_t>(texels_of(*ambient));
  ambient->components.count = even(asset.components);
  ambient->components.weights = ambient->weights;
  choose_steps(asset, ambient);
  memset(ambient->front, 255, texels_of(*ambient));
  memset(ambient->back, 255, texels_of(*ambient));
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i)
    ambient->wanted[i] = static_cast<double>(k_prior_ring_shares[i / k_cell_sectors]);
  ambient->pending = true;
}

void ambient_set_cells(AmbientShadow* ambient, const float cells[SANDGLASS_LIGHT_CELLS], float yaw) {
  double world[SANDGLASS_LIGHT_CELLS], object[SANDGLASS_LIGHT_CELLS];
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) world[i] = static_cast<double>(cells[i]);
  turn_cells(world, static_cast<double>(yaw), object);
  ++ambient->calls;
  if (!ambient->pending && !cells_differ(ambient->wanted, object)) return;
  memcpy(ambient->wanted, object, sizeof object);
  ambient->pending = true;
}

uint64_t ambient_texels_left(const AmbientShadow& ambient) {
  const uint64_t all = texels_of(ambient);
  return (ambient.pending ? all : 0) + (ambient.under_way ? all - ambient.cursor : 0);
}

uint32_t ambient_units_left(const AmbientShadow& ambient) {
  const auto units = [](uint64_t texels) {
    return static_cast<uint32_t>((texels + k_unit_ambient_texels - 1) / k_unit_ambient_texels);
  };
  const uint64_t all = texels_of(ambient);
  return (ambient.pending ? units(all) : 0) + (ambient.under_way ? units(all - ambient.cursor) : 0);
}

void ambient_run(const Int8Kernels& kernels, AmbientShadow* ambient) {
  if (!ambient->under_way) begin_texture(ambient);
  const uint32_t all = ambient->components.size, next = ambient->cursor + k_unit_ambient_texels;
  const uint32_t end = next < all ? next : all;
  kernels.ambient_texels(&ambient->components, ambient->cursor, end, ambient->back);
  ambient->cursor = end;
  if (end == all) end_texture(ambient);
}

}  // namespace sandglass

using namespace sandglass;

sandglass_status sandglass_shadow_set_cells(sandglass_shadow* shadow, const float cells[SANDGLASS_LIGHT_CELLS],
                                            float yaw, const char** reason) {
  if (shadow == nullptr || cells == nullptr)
    return refuse(reason, "shadow or cells is NULL: pass the shadow and 64 floats.");
  const ExactFloatingPoint exact;
  return take_cells(&shadow->shadow.ambient, cells, yaw, reason);
}

void sandglass_shadow_get_ambient(const sandglass_shadow* shadow, sandglass_texture* ambient) {
  if (shadow == nullptr || ambient == nullptr) return;
  const Shadow& s = shadow->shadow;
  const AmbientShadow& a = s.ambient;
  sandglass_texture out = {};
  out.layers = 1;
  if (a.components.count != 0) {
    out.valid = a.valid ? 1 : 0;
    out.bytes = a.front;
    out.side = a.side;
    for (uint32_t axis = 0; axis < 3; ++axis) out.corner[axis] = static_cast<float>(s.origin[axis]);
    out.corner[0] = static_cast<float>(s.origin[0] - a.half);
    out.corner[2] = static_cast<float>(s.origin[2] - a.half);
    out.along[0] = out.across[2] = static_cast<float>(2 * a.half);
    out.scale = 1;
    out.version = a.completed;
    out.behind = ambient_waits(a) ? static_cast<uint32_t>(a.calls - a.front_call) : 0;
  }
  fill_struct(&out, sizeof out, ambient);
}
