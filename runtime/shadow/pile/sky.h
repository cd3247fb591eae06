// How much of the light of a room the sand leaves to the floor and to itself: a texture beside those of pile.h, made
// from the same columns. The room's light comes in the cells of light/light_cells.h.
//
// The columns are joined into a grid as fine as this texture, and this grid into levels of windows. Those of each level
// are twice as wide as those of the one before. A step along an azimuth reads the level whose windows are about as
// wide as the sector is at its distance. So a texel costs the same number of steps whatever its neighbourhood, and no
// step misses thin sand. The last window ends 93 texels away; sand beyond it hides nothing.
#pragma once

#include <cstdint>

#include "kernels/kernels.h"
#include "runtime/frame/layout.h"
#include "runtime/light/light_cells.h"

namespace sandglass {

struct Pile;
struct PileRectangle;

constexpr uint32_t k_sky_levels = 4;
constexpr uint32_t k_sky_steps = 18;  // along an azimuth
constexpr uint32_t k_sky_unit_windows = 512;
constexpr uint32_t k_sky_unit_texels = 256;

// A step of a sector: from a receiver to the first row and column of a window of 2^level columns square.
struct SkyStep {
  uint32_t level;
  int32_t columns, rows;
  float inverse_distance;  // 1 / metres, to the window's middle
};

struct SkyTexture {
  uint8_t *floor, *sand, *heights;
  float top;       // of the highest sand, above the floor, metres
  uint64_t frame;  // in which it was begun
  uint64_t version;
};

// ---- PileSky (sky.cpp)

struct PileSky {
  uint32_t texels;  // along a side; 0: the app asked for none
  uint32_t joined;  // columns of the pile along a side of a texel
  // Every column and every row begins a window of each level, also those before the first. The levels' rows lie one
  // after the other in the arrays; `origins` are the rows of the windows that begin at row 0.
  uint32_t pitch, rows;
  uint32_t origins[k_sky_levels];
  float *tops, *bottoms, *fills;
  uint8_t* in_air;                     // one for each row: 1 where some of its columns do not stand on the floor
  float *ground, *receivers, *lights;  // one row each
  SkyStep* walks;                      // k_sky_steps for every sector
  PileSkyStep* steps;                  // of the row under way: those that meet sand
  PileSector *sectors, *row_sectors;   // all; those with steps that meet sand
  SkyTexture front, back;
  bool valid;
  // The next row of the levels, and of the texture.
  uint32_t level_row, row;
  float *cells, *made_for;  // k_light_cells each
};

// The one walk of the layout; `sky` may be a stand-in.
void sky_lay_out(PileSky* sky, uint32_t texels, uint32_t joined, Layout* layout);
void sky_build(PileSky* sky, const PileRectangle& rectangle);

// Fixes the cells that the texture under way is made for. `frame`: in which it is begun.
void sky_begin(PileSky* sky, uint64_t frame);

// The phases: every row of every level, then every row of the texture. They run a unit. False: there are more.
bool sky_run_levels(PileSky* sky, const Pile& pile);
bool sky_run_rows(PileSky* sky, const Pile& pile);
// Swaps the two textures.
void sky_end(PileSky* sky, const Pile& pile);

// See sandglass_pile_shadow_light_grains.
void sky_light_grains(const Pile& pile, const float* positions, uint32_t count, float radius, uint8_t* visibility);

}  // namespace sandglass
