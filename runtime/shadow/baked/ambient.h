// The ambient shadow of one object: how much of the room's light each part of the floor around it still receives,
// whatever the light. Its baked components (runtime/asset/shadow.fbs) are mixed for the cells of the light, unit by
// unit, in integers.
#pragma once

#include <cstdint>

#include "kernels/int8.h"
#include "runtime/asset/shadow_asset.h"
#include "runtime/frame/layout.h"
#include "runtime/shadow/receiver/cells.h"

namespace sandglass {

// Texels of one unit: 12 us for 24 components on a phone's core.
constexpr uint32_t k_unit_ambient_texels = 4096;

struct AmbientShadow {
  AmbientComponents components;  // count 0: the file has none, and nothing below is used
  const float* mixing;           // SANDGLASS_LIGHT_CELLS for each component
  int16_t* weights;              // of the texture under way
  double weight_scale;           // weight = share of light * weight_scale
  uint32_t side;                 // texels
  double half;                   // half the side, metres
  // Cells in the object's frame, of the last texture that was asked for.
  double wanted[SANDGLASS_LIGHT_CELLS];
  bool pending;  // the texture for `wanted` is neither done nor under way
  bool under_way;
  bool valid;  // `front` was completed once
  // An ambient texture was completed since the last texture of a light: a light that waits comes first.
  bool gives_way;
  uint32_t cursor;  // next texel
  uint8_t *front, *back;
  uint32_t completed;  // textures so far
  // Calls of set_cells: so far; when the texture under way was begun; and when `front` was.
  uint64_t calls, begun_call, front_call;
};

// Counts or hands out regions of the block; none where the file has no ambient shadow.
void ambient_lay_out(const AmbientAsset& asset, Layout* layout, AmbientShadow* ambient);
// Fills the regions in. The first texture waits for its units: that of the expected light.
void ambient_create(const AmbientAsset& asset, AmbientShadow* ambient);

// `cells` are in the world's frame, the object is turned in it by `yaw`.
void ambient_set_cells(AmbientShadow* ambient, const float cells[SANDGLASS_LIGHT_CELLS], float yaw);

inline bool ambient_waits(const AmbientShadow& ambient) { return ambient.pending || ambient.under_way; }
// Texels left of the texture under way and of the one that waits.
uint64_t ambient_texels_left(const AmbientShadow& ambient);
uint32_t ambient_units_left(const AmbientShadow& ambient);
// Runs the next unit of the texture under way, or begins the one that waits.
void ambient_run(const Int8Kernels& kernels, AmbientShadow* ambient);

}  // namespace sandglass
