// The C API around a Pile: checks, layout, light, and what the textures look like from outside.
#include <cstring>

#include "platform/floating_point.h"
#include "runtime/frame/create.h"
#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/hash.h"
#include "runtime/math/math.h"
#include "runtime/shadow/pile/pile.h"
#include "runtime/shadow/receiver/cells.h"
#include "runtime/shadow/receiver/light_direction.h"

namespace sandglass {
namespace {

constexpr double k_polar_max = 70 * k_pi / 180;
constexpr double k_narrowest = 0.02, k_widest = 1;  // light, radians
constexpr float k_side_limit = 1e4f;                // metres

sandglass_status check(const sandglass_pile_shadow_desc& desc, const char** reason) {
  for (uint32_t axis = 0; axis < 2; ++axis) {
    if (!within(desc.low[axis], -k_side_limit, k_side_limit) || !within(desc.high[axis], -k_side_limit, k_side_limit))
      return refuse(reason, "desc.low or high is not finite, or beyond 10 km.");
    if (!(desc.high[axis] - desc.low[axis] >= 1e-3f))
      return refuse(reason, "desc.high is not above low by at least a millimetre in x and in z.");
  }
  if (!within(desc.floor, -k_side_limit, k_side_limit))
    return refuse(reason, "desc.floor is not finite, or beyond 10 km.");
  if (desc.texels < 32 || desc.texels > 256 || desc.texels % 32 != 0)
    return refuse(reason, "desc.texels is not a multiple of 32 in 32..256.");
  if (!within(desc.light_tolerance, 0.0f, 1.0f)) return refuse(reason, "desc.light_tolerance is not in 0..1 radians.");
  if (desc.on_sand > 1) return refuse(reason, "desc.on_sand is neither 0 nor 1.");
  if (desc.sky_texels != 0 && desc.sky_texels != desc.texels && 2 * desc.sky_texels != desc.texels &&
      4 * desc.sky_texels != desc.texels)
    return refuse(reason, "desc.sky_texels is neither 0 nor desc.texels, a half or a quarter of it.");
  if (desc.sky_texels != 0 && (desc.sky_texels % k_lane_group != 0 || desc.sky_texels > 128))
    return refuse(reason, "desc.sky_texels is not a multiple of 16, at most 128.");
  if (select_pile_kernels(desc.isa) == nullptr)
    return refuse(reason, SANDGLASS_ERROR_UNSUPPORTED,
                  "desc.isa is not in this build or on this CPU: use SANDGLASS_ISA_AUTOMATIC.");
  return accept(reason);
}

// The one walk: counts the bytes, or hands out the regions.
sandglass_pile_shadow* lay_out(const sandglass_pile_shadow_desc& desc, Layout* layout) {
  const uint64_t n = desc.texels, pitch = n + k_lane_group, columns = n * pitch + 2 * k_lane_group;
  auto* handle = layout_region<sandglass_pile_shadow>(layout, "pile_shadow.state", 1);
  Pile nowhere = {};
  Pile* p = handle == nullptr ? &nowhere : &handle->pile;
  if (handle != nullptr) *handle = {};
  p->rectangle.texels = desc.texels;
  p->columns.pitch = static_cast<uint32_t>(pitch);
  p->columns.tops = layout_region<float>(layout, "pile_shadow.tops", columns);
  p->columns.bottoms = layout_region<float>(layout, "pile_shadow.bottoms", columns);
  p->columns.fills = layout_region<float>(layout, "pile_shadow.fills", columns);
  p->air.shares = layout_region<float>(layout, "pile_shadow.air", n * n);
  float** const rows[] = {&p->lighting.ground, &p->lighting.receivers, &p->lighting.shares};
  for (float** row : rows) *row = layout_region<float>(layout, "pile_shadow.row", n + k_lane_group);
  PileAzimuth** const azimuths[] = {&p->lighting.azimuths, &p->lighting.row_azimuths};
  for (PileAzimuth** some : azimuths)
    *some = layout_region<PileAzimuth>(layout, "pile_shadow.azimuths", k_pile_azimuths);
  PileStep** const steps[] = {&p->lighting.steps, &p->lighting.row_steps};
  for (PileStep** some : steps)
    *some = layout_region<PileStep>(layout, "pile_shadow.steps", k_pile_azimuths * k_pile_steps);
  PileTexture* const textures[] = {&p->textures.front, &p->textures.back};
  for (PileTexture* texture : textures) {
    texture->floor = layout_region<uint8_t>(layout, "pile_shadow.coverage", n * n);
    texture->sand = desc.on_sand != 0 ? layout_region<uint8_t>(layout, "pile_shadow.coverage", n * n) : nullptr;
  }
  sky_lay_out(&p->sky, desc.sky_texels, desc.sky_texels != 0 ? desc.texels / desc.sky_texels : 0, layout);
  return handle;
}

sandglass_status build(const sandglass_pile_shadow_desc& desc, sandglass_pile_shadow* handle, const char** reason) {
  handle->member.capability = &k_pile_capability;
  Pile* p = &handle->pile;
  p->kernels = select_pile_kernels(desc.isa);
  p->columns.tops += k_lane_group;
  p->columns.bottoms += k_lane_group;
  p->columns.fills += k_lane_group;
  for (uint32_t axis = 0; axis < 2; ++axis) {
    p->rectangle.low[axis] = desc.low[axis];
    p->rectangle.high[axis] = desc.high[axis];
    p->rectangle.texel[axis] = (desc.high[axis] - desc.low[axis]) / static_cast<float>(desc.texels);
  }
  for (uint64_t i = 0; i < uint64_t{p->rectangle.texels} * p->rectangle.texels; ++i) p->air.shares[i] = 1;
  p->rectangle.height = desc.floor;
  p->request.width = static_cast<double>(k_usual_diameter);
  p->request.tolerance_squared = static_cast<double>(desc.light_tolerance) * static_cast<double>(desc.light_tolerance);
  p->request.light[1] = 1;
  sky_build(&p->sky, p->rectangle);
  if (p->sky.texels != 0) p->request.asked = k_ask_sky;
  return accept(reason);
}

using Maker = MakerOf<check, lay_out, build>;

__attribute__((noinline)) sandglass_status take_light(Pile* p, const float direction[3], float angular_diameter,
                                                      const char** reason) {
  double light[3], largest = 0;
  if (const sandglass_status status = check_light_direction(direction, light, reason)) return status;
  if (!within(angular_diameter, 0.0f, 1.5f)) return refuse(reason, "angular_diameter is not in 0..1.5 radians.");
  for (const double x : light) largest = absolute(x) > largest ? absolute(x) : largest;
  for (double& x : light) x /= largest;
  const double length = square_root(light[0] * light[0] + light[1] * light[1] + light[2] * light[2]);
  for (double& x : light) x /= length;
  const double flat = square_root(light[0] * light[0] + light[2] * light[2]), polar = arc_tangent2(flat, light[1]);
  p->request.opacity = 1;
  if (polar > k_polar_max) {
    const double fade = (0.5 * k_pi - polar) / (0.5 * k_pi - k_polar_max);
    p->request.opacity = fade > 0 ? static_cast<float>(fade) : 0.0f;
    const SinCos lowest = sin_cos_turns(k_polar_max / (2 * k_pi));
    light[0] = flat > 0 ? light[0] * (lowest.sin / flat) : lowest.sin;
    light[1] = lowest.cos;
    light[2] = flat > 0 ? light[2] * (lowest.sin / flat) : 0;
  }
  double chord = 0;
  for (uint32_t axis = 0; axis < 3; ++axis)
    chord += (light[axis] - p->request.light[axis]) * (light[axis] - p->request.light[axis]);
  const bool any = p->textures.valid || ((p->request.asked | p->progress.making) & k_ask_light) != 0;
  const double diameter = static_cast<double>(angular_diameter > 0.0f ? angular_diameter : k_usual_diameter);
  const double width = diameter < k_narrowest ? k_narrowest : diameter > k_widest ? k_widest : diameter;
  const double edge = 0.5 * (width - p->request.width);
  if (any && !(chord + edge * edge > p->request.tolerance_squared)) return accept(reason);
  p->request.width = width;
  for (uint32_t axis = 0; axis < 3; ++axis) p->request.light[axis] = light[axis];
  p->request.asked |= k_ask_light;
  return accept(reason);
}

__attribute__((noinline)) sandglass_status take_cells(Pile* p, const float* cells, const char** reason) {
  if (p->sky.texels == 0)
    return refuse(reason, "this shadow has no texture of the room's light: set desc.sky_texels at create.");
  if (const sandglass_status status = check_cells(cells, reason)) return status;
  memcpy(p->sky.cells, cells, k_light_cells * sizeof(float));
  if (cells_differ(p->sky.made_for, cells)) p->request.asked |= k_ask_sky;
  return accept(reason);
}

__attribute__((noinline)) sandglass_status take_ground(Pile* p, const sandglass_heights* map, const char** reason) {
  bool changed = p->ground.map.heights != nullptr;
  if (map == nullptr) p->ground = {};
  else if (const sandglass_status status = ground_take(&p->ground, p->rectangle, *map, &changed, reason)) return status;
  if (changed) p->request.asked = k_ask_all;
  return accept(reason);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

void sandglass_pile_shadow_desc_default(sandglass_pile_shadow_desc* desc) {
  if (!empty_struct(desc)) return;
  for (uint32_t axis = 0; axis < 2; ++axis) {
    desc->low[axis] = -0.5f;
    desc->high[axis] = 0.5f;
  }
  desc->texels = 128;
  desc->light_tolerance = 0.01f;
  desc->on_sand = 1;
}

sandglass_status sandglass_pile_shadow_bytes(const sandglass_pile_shadow_desc* desc, uint64_t* bytes,
                                             const char** reason) {
  return bytes_of<Maker>(desc, bytes, reason);
}

sandglass_status sandglass_pile_shadow_create(const sandglass_pile_shadow_desc* desc, void* block, uint64_t bytes,
                                              sandglass_pile_shadow** shadow, const char** reason) {
  return create_in<Maker>(desc, block, bytes, shadow, "shadow is NULL: pass where to store it.", reason);
}

sandglass_status sandglass_pile_shadow_set_light(sandglass_pile_shadow* shadow, const float direction[3],
                                                 float angular_diameter, const char** reason) {
  if (shadow == nullptr || direction == nullptr)
    return refuse(reason, "shadow or direction is NULL: pass the shadow and 3 floats.");
  const ExactFloatingPoint exact;
  return take_light(&shadow->pile, direction, angular_diameter, reason);
}

sandglass_status sandglass_pile_shadow_set_ground(sandglass_pile_shadow* shadow, const sandglass_heights* heights,
                                                  const char** reason) {
  if (shadow == nullptr) return refuse(reason, "shadow is NULL: pass the shadow.");
  const ExactFloatingPoint exact;
  return take_ground(&shadow->pile, heights, reason);
}

void sandglass_pile_shadow_refresh(sandglass_pile_shadow* shadow) {
  if (shadow != nullptr) shadow->pile.request.asked = k_ask_all;
}

uint32_t sandglass_pile_shadow_run(sandglass_pile_shadow* shadow, const float* positions, uint32_t count, float radius,
                                   uint32_t units) {
  if (shadow == nullptr || (positions == nullptr && count != 0)) return 0;
  const ExactFloatingPoint exact;
  const uint32_t usable = radius > 0 && radius < k_pile_radius_limit ? count : 0;
  shadow->pile.request.source = {nullptr, nullptr, positions, usable,
                                 radius,  nullptr, 0,         shadow->pile.request.source.moving};
  return run_members(member_of(shadow, k_pile_shadow_kinds), units);
}

void sandglass_pile_shadow_get_texture(const sandglass_pile_shadow* shadow, sandglass_pile_shadow_part part,
                                       sandglass_texture* out) {
  if (shadow == nullptr || out == nullptr) return;
  const Pile& p = shadow->pile;
  const PileTexture& light = p.textures.front;
  const PileSky& s = p.sky;
  const uint8_t* const bytes[] = {light.floor, light.sand, s.front.floor, s.front.sand, s.front.heights};
  const bool of_light = part <= SANDGLASS_PILE_SHADOW_SAND, heights = part == SANDGLASS_PILE_SHADOW_HEIGHTS;
  sandglass_texture texture = {};
  texture.layers = 1;
  if (part >= 0 && part <= SANDGLASS_PILE_SHADOW_HEIGHTS && bytes[part] != nullptr && (of_light || s.texels != 0)) {
    const bool stale = ((p.request.asked | p.progress.making) & (of_light ? k_ask_light : k_ask_sky)) != 0;
    const PileRectangle& r = p.rectangle;
    texture.valid = of_light ? p.textures.valid : s.valid;
    texture.bytes = bytes[part];
    texture.side = of_light || heights ? r.texels : s.texels;
    texture.behind = stale ? static_cast<uint32_t>(p.request.frame - (of_light ? light.frame : s.front.frame)) : 0;
    texture.corner[0] = r.low[0];
    texture.corner[1] = r.height;
    texture.corner[2] = r.low[1];
    texture.along[0] = r.high[0] - r.low[0];
    texture.across[2] = r.high[1] - r.low[1];
    texture.scale = of_light ? p.request.opacity : heights ? s.front.top : 1.0f;
    texture.version = of_light ? light.version : s.front.version;
  }
  fill_struct(&texture, sizeof texture, out);
}

uint64_t sandglass_pile_shadow_hash(const sandglass_pile_shadow* shadow) {
  if (shadow == nullptr) return 0;
  const Pile& p = shadow->pile;
  const uint64_t texels = uint64_t{p.rectangle.texels} * p.rectangle.texels;
  uint64_t hash = hash_bytes(p.textures.front.floor, texels);
  if (p.textures.front.sand != nullptr) hash = hash_with(hash, hash_bytes(p.textures.front.sand, texels));
  if (p.sky.texels == 0) return hash;
  const uint64_t of_sky = uint64_t{p.sky.texels} * p.sky.texels;
  hash = hash_with(hash, hash_bytes(p.sky.front.floor, of_sky));
  hash = hash_with(hash, hash_bytes(p.sky.front.sand, of_sky));
  return hash_with(hash, hash_bytes(p.sky.front.heights, texels));
}

sandglass_status sandglass_pile_shadow_set_cells(sandglass_pile_shadow* shadow,
                                                 const float cells[SANDGLASS_LIGHT_CELLS], const char** reason) {
  if (shadow == nullptr || cells == nullptr)
    return refuse(reason, "shadow or cells is NULL: pass the shadow and 64 floats.");
  const ExactFloatingPoint exact;
  return take_cells(&shadow->pile, cells, reason);
}

void sandglass_pile_shadow_light_grains(const sandglass_pile_shadow* shadow, const float* positions, uint32_t count,
                                        float radius, uint8_t* visibility) {
  if (shadow == nullptr || positions == nullptr || visibility == nullptr) return;
  const ExactFloatingPoint exact;
  sky_light_grains(shadow->pile, positions, count, radius, visibility);
}
