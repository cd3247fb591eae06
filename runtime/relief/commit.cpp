// From what was seen to what is shown. Heights that follow each image tremble, and sand upon them never comes to rest. So
// a cell changes only where its height would be another one by far, and the more images must agree the longer it was
// still. Beside a wall a tracker's drift of a few millimetres moves a cell by the wall's height: half of what neighbours
// differ counts as noise.
#include "runtime/relief/relief.h"

namespace sandglass {
namespace {

constexpr int32_t k_flat = 32;                         // heights, 8 mm: what is lower is the plane
constexpr int32_t k_tolerance = 24;                    // heights, 6 mm
constexpr uint8_t k_calm_max = 40, k_calm_images = 8;  // a cell waits for an image more for so many calm ones
constexpr uint32_t k_few = 3, k_few_unseen = 4;        // neighbours without which there is no median of them

struct Around {
  int32_t height;      // the median of medians
  int32_t difference;  // of what is shown there
};

// Of the cells about one. At the map's edge the cell stands alone.
Around look_around(const ReliefState& relief, uint32_t i) {
  const uint32_t width = relief.desc.cells[0], x = i % width, z = i / width;
  const ReliefCell& cell = relief.cells[i];
  Around around = {cell.median, 0};
  if (x == 0 || z == 0 || x + 1 == width || z + 1 == relief.desc.cells[1]) return around;
  int16_t sorted[9];
  uint32_t count = 0;
  int32_t low = cell.shown, high = cell.shown;
  for (uint32_t row = 0; row < 3; ++row)
    for (uint32_t column = 0; column < 3; ++column) {
      const ReliefCell& near = relief.cells[i - width - 1 + row * width + column];
      low = near.shown < low ? near.shown : low;
      high = near.shown > high ? near.shown : high;
      if (near.seen < k_relief_looks_min) continue;
      uint32_t place = count++;
      for (; place > 0 && sorted[place - 1] > near.median; --place) sorted[place] = sorted[place - 1];
      sorted[place] = near.median;
    }
  around.difference = high - low;
  if (count < (cell.seen >= k_relief_looks_min ? k_few : k_few_unseen)) return around;
  const uint32_t half = count / 2;
  around.height = count % 2 != 0 ? sorted[half] : (sorted[half] + sorted[half - 1]) / 2;
  return around;
}

void show(ReliefState* relief, uint32_t i, int32_t height) {
  relief->cells[i].shown = static_cast<int16_t>(height);
  relief->heights[i] = static_cast<float>(height) * k_relief_unit;
  const uint32_t at[2] = {i % relief->desc.cells[0], i / relief->desc.cells[0]};
  ReliefBox* box = &relief->changing;
  for (int k = 0; k < 2; ++k) {
    box->low[k] = at[k] < box->low[k] ? at[k] : box->low[k];
    box->high[k] = at[k] + 1 > box->high[k] ? at[k] + 1 : box->high[k];
  }
}

}  // namespace

void relief_commit(ReliefState* relief, uint32_t first, uint32_t end) {
  for (uint32_t i = first; i < end; ++i) {
    ReliefCell* cell = &relief->cells[i];
    const bool looked = cell->now != k_relief_none;
    cell->now = k_relief_none;
    const Around around = look_around(*relief, i);
    const int32_t height = around.height < k_flat && around.height > -k_flat ? 0 : around.height;
    const int32_t change = height > cell->shown ? height - cell->shown : cell->shown - height;
    const int32_t tolerance = 2 * k_tolerance + around.difference;  // twice
    // Back to the plane half of that is enough: there a height is known best.
    const bool beyond = 2 * change > tolerance || (height == 0 && 4 * change > tolerance);
    if (!beyond) {
      cell->beyond = 0;
      if (looked && cell->calm < k_calm_max) ++cell->calm;
      continue;
    }
    if (looked && cell->beyond < UINT8_MAX) ++cell->beyond;
    if (cell->beyond < 1 + cell->calm / k_calm_images) continue;
    cell->beyond = cell->calm = 0;
    show(relief, i, height);
  }
}

}  // namespace sandglass
