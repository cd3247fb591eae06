// How much of the light of a room the sand leaves to the floor and to itself: a texture beside those of pile.h, made
// from the same columns. The room's light comes in the cells of core/light_cells.h.
//
// The columns are joined into a grid as fine as this texture, and that into levels of ever wider windows, each twice as
// wide as the one before. A step along an azimuth reads the level whose windows are about as wide as the sector is at
// its distance. So a texel costs the same number of steps whatever its neighbourhood, and no step misses thin sand.
#pragma once

#include <cstdint>

#include "kernels/kernels.h"
#include "runtime/core/layout.h"
#include "runtime/core/light_cells.h"

namespace sandglass {

struct Pile;

constexpr uint32_t k_sky_levels = 5;
constexpr uint32_t k_sky_steps = 12;         // along an azimuth
constexpr uint32_t k_sky_placed_steps = 48;  // with those of every place of a row between the rows of its levels
constexpr uint32_t k_sky_unit_windows = 512;
constexpr uint32_t k_sky_unit_texels = 256;

// Windows of 2^level columns square. Every column begins a window; so does every row of level 0 and 1, every second of
// level 2, and so on.
struct SkyLevel {
  uint32_t first;  // row of the arrays
  uint32_t rows;
};

// A step as seen from one row. Rows are those of the level.
struct SkyPlacedStep {
  int32_t columns, rows;
  float inverse_distance;  // 1 / metres
};

struct SkyTexture {
  uint8_t *floor, *sand, *heights;
  float top;       // of the highest sand, above the floor, metres
  uint64_t frame;  // in which it was begun
};

struct PileSky {
  uint32_t texels;  // along a side; 0: the app asked for none
  uint32_t joined;  // columns of the pile along a side of a texel
  uint32_t pitch, rows;
  SkyLevel levels[k_sky_levels];
  float *tops, *bottoms, *fills;
  uint8_t* in_air;                      // one for each row: 1 where some of its columns do not stand on the floor
  float *nothing, *receivers, *lights;  // one row each
  SkyPlacedStep* placed;                // k_sky_placed_steps for every sector
  PileSkyStep* steps;                   // of the row under way
  PileSector sectors[k_cell_sectors], row_sectors[k_cell_sectors];
  SkyTexture front, back;
  bool valid;
  float cells[k_light_cells], made_for[k_light_cells];
};

// The one walk of the layout; `owner` may be a stand-in.
void sky_lay_out(PileSky* sky, uint32_t texels, uint32_t joined, Layout* layout);
void sky_build(Pile* pile);

void sky_begin(Pile* pile);

// The phases: every row of every level, then every row of the texture. They run at most a unit from `cursor` on and
// return where they stopped.
uint32_t sky_run_levels(Pile* pile, uint32_t cursor);
uint32_t sky_run_rows(Pile* pile, uint32_t cursor);

// Whether light that comes in `cells` can differ by a byte's step from that which the texture was made for.
bool sky_differs(const PileSky& sky, const float* cells);

void sky_light_grains(const Pile& pile, const float* positions, uint32_t count, float radius, uint8_t* visibility);

}  // namespace sandglass
