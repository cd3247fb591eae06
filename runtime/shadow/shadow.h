// The shadow of one object as a stage of the frame: units that the governor can hand out (core/governor.h), and the
// state behind the C API of shadow.h.
//
// A texture is computed in phases, each a list of units: rows (the first layer's tables for this light), the coarse
// grid, the decision which cells to refine together with the interpolation of the others, and the refined cells. In
// mode FULL the rows are followed by all texels. The last unit swaps the two textures.
#pragma once

#include <cstdint>

#include "kernels/int8.h"
#include "runtime/core/governor.h"
#include "runtime/core/layout.h"
#include "runtime/shadow/plane.h"
#include "sandglass/shadow.h"

namespace sandglass {

constexpr uint32_t k_shadow_size = SANDGLASS_SHADOW_TEXELS;
constexpr uint32_t k_cell = 4;                         // texels a side of a cell of the coarse grid
constexpr uint32_t k_cells = k_shadow_size / k_cell;   // a side
constexpr uint32_t k_grid = k_cells + 1;               // coarse samples a side: the corners of the cells
constexpr uint32_t k_unit_texels = 6 * k_texel_block;  // 40 us on the slowest core aimed at
constexpr uint32_t k_unit_table_rows = 64;             // of the first layer's table
constexpr uint32_t k_unit_cell_rows = 16;              // of the decision
constexpr uint32_t k_table_rows = k_shadow_size + 1;   // the last corners lie one texel beyond the texture

enum class ShadowPhase : uint32_t { idle, rows, coarse, decide, refine, full };

struct ShadowTexture {
  uint8_t* coverage;
  ShadowRectangle rectangle;  // in the object's frame
  double light[3];
  uint64_t light_call;  // number of the set_light call that it was begun for
  uint32_t evaluated;
  bool valid;
};

struct Shadow {
  const Int8Kernels* kernels;
  ShadowNetwork network;
  // Of the object and the light that was baked.
  double origin[3];
  ShadowBox box;
  PlaneRule plane;
  double half_sine, reach;          // of half the light; tan(polar_max + half the light)
  double polar_sine, polar_cosine;  // of polar_max
  double polar_max;
  uint32_t light_frequencies;
  // How it is evaluated.
  sandglass_shadow_mode mode;
  uint32_t threshold;
  double tolerance_squared;  // of the chord between two unit vectors
  // Tables: bytes' units times 2^shift.
  double table_scale;          // from activation to table units
  int16_t* columns;            // k_table_rows x width
  int16_t* row_base;           // k_table_rows x width, without the light
  int16_t* rows;               // with it
  int16_t* light_sums;         // width
  const float* light_weights;  // 3 * light_inputs x width
  const float* first_bias;
  // The texture under way.
  ShadowPhase phase;
  uint32_t cursor;    // next table row, coarse sample, row of cells, refined cell, or texel
  uint8_t* coarse;    // k_grid^2
  uint8_t* marked;    // k_cells^2: 1 where the corners differ
  uint16_t* refined;  // cells to refine
  uint32_t refined_count;
  uint16_t *unit_u, *unit_v;  // texels of one unit
  uint8_t *unit_coverage, *scratch;
  ShadowTexture front, back;
  // The light.
  double wanted[3];         // clamped to polar_max
  bool has_light, pending;  // pending: the texture of `wanted` is neither done nor under way
  float opacity;
  bool beyond;
  uint64_t light_calls;
};

void shadow_set_light(Shadow* shadow, const double unit_vector[3]);

// As Stage's functions. Kinds are counted from first_kind on; k_shadow_kinds of them.
constexpr uint32_t k_shadow_kinds = 4;
bool shadow_next(const Shadow* shadow, uint32_t first_kind, WorkUnit* unit);
void shadow_run(Shadow* shadow);
uint32_t shadow_forecast(const Shadow* shadow, uint32_t first_kind, Forecast* entries);

}  // namespace sandglass
