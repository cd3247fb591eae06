// The state behind the C API of sandglass/shadow.h: the shadows of one object, one for each light. One texture at a
// time is under way; stage.cpp chooses which. Its work is cut into units that a frame can hand out (frame/governor.h).
//
// A texture is computed in phases, each a list of units:
//   rows     the tables of the network's first layer for this light
//   coarse   the samples of the coarse grid
//   decide   which cells to refine; the other cells are interpolated
//   refine   the texels of those cells
// In mode FULL all texels follow the rows. The last unit swaps the two textures.
//
// Beside them stands the object's ambient shadow (ambient.h), with a texture and units of its own.
#pragma once

#include <cstdint>

#include "kernels/int8.h"
#include "runtime/frame/capability.h"
#include "runtime/frame/layout.h"
#include "runtime/math/shadow_rectangle.h"
#include "runtime/shadow/baked/ambient.h"
#include "sandglass/sandglass.h"
#include "sandglass/shadow.h"

namespace sandglass {

constexpr uint32_t k_shadow_size = SANDGLASS_SHADOW_TEXELS;
constexpr uint32_t k_cell = 4;                        // side of a cell of the coarse grid, texels
constexpr uint32_t k_cells = k_shadow_size / k_cell;  // cells along a side of the texture
constexpr uint32_t k_grid = k_cells + 1;              // coarse samples along a side: the corners of the cells
constexpr uint32_t k_unit_texels_max = 6 * k_texel_block;
constexpr uint64_t k_unit_macs = 5'000'000;           // 45 us on a phone's core, which does 110 GMAC/s of bytes
constexpr uint32_t k_unit_table_rows = 64;            // rows of the first layer's table in one unit
constexpr uint32_t k_unit_cell_rows = 16;             // rows of cells that one unit decides
constexpr uint32_t k_table_rows = k_shadow_size + 1;  // the last corners lie one texel beyond the texture

// Kinds of work unit.
enum : uint32_t { k_kind_rows, k_kind_texels, k_kind_decide, k_kind_refine, k_kind_ambient };
static_assert(k_kind_ambient + 1 == k_shadow_kinds);

enum class ShadowPhase : uint32_t { idle, rows, coarse, decide, refine, full };

struct ShadowTexture {
  uint8_t* coverage;
  ShadowRectangle rectangle;  // in the object's frame
  double light[3];
  // The number of the call of set_light that it was begun for.
  uint64_t light_call;
  uint32_t evaluated;
  bool valid;
  uint64_t version;
};

// One light and the last texture that was completed for it.
struct ShadowLight {
  ShadowTexture front;
  double wanted[3];  // the direction last asked for, clamped to polar_max
  bool pending;      // the texture for `wanted` is neither done nor under way
  bool beyond;
  float opacity, irradiance;
  // Calls of set_light: so far, and when `pending` began.
  uint64_t calls, pending_since;
};

struct Shadow {
  const Int8Kernels* kernels;
  ShadowNetwork network;
  // The object and the light that were baked.
  double origin[3];
  ShadowBox box;
  PlaneRule plane;
  // The sine of the light's half angle, and the tangent of polar_max plus that angle.
  double half_sine, reach;
  double polar_sine, polar_cosine;  // of polar_max
  double polar_max;
  uint32_t light_frequencies;
  // How it is evaluated.
  sandglass_shadow_mode mode;
  uint32_t threshold;
  double tolerance_squared;  // of the chord between two unit vectors
  // The first layer as tables. Their entries count 2^-shift steps of an activation byte.
  double table_scale;          // table units for one unit of activation
  int16_t* columns;            // k_table_rows x width
  int16_t* row_base;           // k_table_rows x width, without the light's part
  int16_t* rows;               // k_table_rows x width, with it
  int16_t* light_sums;         // width
  const float* light_weights;  // 3 * light_inputs x width
  const float* first_bias;
  // The texture under way.
  ShadowPhase phase;
  uint32_t cursor;    // next table row, coarse sample, row of cells, refined cell, or texel
  uint8_t* coarse;    // k_grid^2
  uint8_t* marked;    // k_cells^2: 1 where the corners of the cell differ
  uint16_t* refined;  // cells to refine
  uint32_t refined_count;
  uint32_t unit_texels;       // in one unit of this network, a multiple of the block
  uint16_t *unit_u, *unit_v;  // the texels of one unit
  uint8_t *unit_coverage, *scratch;
  ShadowTexture back;
  uint32_t active;  // light that `back` is for
  ShadowLight* lights;
  uint32_t light_count;
  AmbientShadow ambient;
  bool light_done;  // the last unit completed a texture of a light
};

void shadow_set_light(Shadow* shadow, uint32_t light, const double unit_vector[3], float irradiance);

// The next unit of the texture under way, or the first one of a new texture. shadow_run runs it; a new texture is that
// of `light`.
WorkUnit shadow_next(const Shadow& shadow);
void shadow_run(Shadow* shadow, uint32_t light);

// The next unit of the ambient shadow.
WorkUnit shadow_ambient_next(const Shadow& shadow);

// A whole unit of a kind: how many pieces it does (rows of the table, texels, rows of cells, cells, or texels of
// the ambient shadow), and how many items it counts for the governor.
struct ShadowUnit {
  uint32_t pieces, items;
};
ShadowUnit shadow_unit(const Shadow& shadow, uint32_t kind);

// Pieces left of each kind, in the texture under way and in those that lights wait for. How many cells will be refined
// is known once the grid is decided. Until then all cells count; with `likely`, as many as in the light's last texture.
struct ShadowWork {
  uint64_t pieces[k_shadow_kinds];
};
ShadowWork shadow_work_left(const Shadow& shadow, bool likely);

extern const Capability k_shadow_capability;

}  // namespace sandglass

struct sandglass_shadow {
  sandglass::Member member;
  sandglass::Shadow shadow;
};
