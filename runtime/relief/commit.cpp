// From what was seen to what is shown. Heights that follow each image tremble, and sand upon them never comes to rest. So
// a cell changes only where its height would be another one by far, and the more images must agree the longer it was
// still. Beside a wall a tracker's drift of a few millimetres moves a cell by the wall's height: half of what neighbours
// differ counts as noise.
#include "runtime/relief/relief.h"

namespace sandglass {
namespace {

constexpr int32_t k_tolerance = 24;                    // heights, 6 mm
constexpr uint8_t k_calm_max = 40, k_calm_images = 8;  // a cell waits for an image more for so many calm ones
constexpr uint32_t k_few = 3, k_few_unseen = 4;        // neighbours without which there is no median of them

struct Around {
  int32_t height;      // the median of medians
  int32_t difference;  // of what is shown there
};

// Of the cells about one. At the map's edge the cell stands alone.
Around look_around(const ReliefState& relief, uint32_t i) {
  const ReliefCells& cells = relief.cells;
  const uint32_t width = relief.desc.cells[0], x = i % width, z = i / width;
  Around around = {cells.median[i], 0};
  if (x == 0 || z == 0 || x + 1 == width || z + 1 == relief.desc.cells[1]) return around;
  int16_t sorted[9];
  uint32_t count = 0;
  int32_t low = cells.shown[i], high = low;
  for (uint32_t row = 0; row < 3; ++row)
    for (uint32_t column = 0; column < 3; ++column) {
      const uint32_t near = i - width - 1 + row * width + column;
      low = cells.shown[near] < low ? cells.shown[near] : low;
      high = cells.shown[near] > high ? cells.shown[near] : high;
      if (cells.seen[near] < k_relief_looks_min) continue;
      const int16_t median = cells.median[near];
      uint32_t place = count++;
      for (; place > 0 && sorted[place - 1] > median; --place) sorted[place] = sorted[place - 1];
      sorted[place] = median;
    }
  around.difference = high - low;
  if (count < (cells.seen[i] >= k_relief_looks_min ? k_few : k_few_unseen)) return around;
  const uint32_t half = count / 2;
  around.height = count % 2 != 0 ? sorted[half] : (sorted[half] + sorted[half - 1]) / 2;
  return around;
}

void show(ReliefState* relief, uint32_t i, int32_t height) {
  relief_show(relief, i, static_cast<int16_t>(height));
  relief_version_takes(relief, i);
}

// Whether the cell's height would be another one by enough.
bool asks_for(const ReliefState& relief, uint32_t i, int32_t* height) {
  const Around around = look_around(relief, i);
  *height = around.height < k_relief_flat && around.height > -k_relief_flat ? 0 : around.height;
  const int32_t shown = relief.cells.shown[i];
  const int32_t change = *height > shown ? *height - shown : shown - *height;
  const int32_t tolerance = 2 * k_tolerance + around.difference;  // twice
  // Back to the plane half of that is enough: there a height is known best.
  return 2 * change > tolerance || (*height == 0 && 4 * change > tolerance);
}

// Of cells in a row: 0 where nothing about one is so far off what is shown that it could ask for another height. Most
// are so, and this is a tenth of the work.
void find_doubtful(const ReliefCells& cells, uint32_t width, uint32_t first, uint32_t count, uint8_t* doubtful) {
  const int16_t *a = cells.median + first - width, *b = cells.median + first, *c = b + width;
  const int16_t* shown = cells.shown + first;
  const auto least = [](int16_t x, int16_t y) { return x < y ? x : y; };
  const auto most = [](int16_t x, int16_t y) { return x > y ? x : y; };
  for (uint32_t i = 0; i < count; ++i) {
    const int16_t *p = a + i, *q = b + i, *r = c + i;
    const int16_t low =
        least(least(least(least(p[-1], p[0]), least(p[1], q[-1])), least(least(q[0], q[1]), r[-1])), least(r[0], r[1]));
    const int16_t high =
        most(most(most(most(p[-1], p[0]), most(p[1], q[-1])), most(most(q[0], q[1]), r[-1])), most(r[0], r[1]));
    const bool off = (high - shown[i] > k_tolerance) | (shown[i] - low > k_tolerance);
    const bool flattens = (shown[i] != 0) & (low < k_relief_flat) & (high > -k_relief_flat);
    doubtful[i] = off | flattens;
  }
}

// Cells of one row.
void commit_row(ReliefState* relief, uint32_t first, uint32_t count) {
  const ReliefCells& cells = relief->cells;
  const uint32_t width = relief->desc.cells[0], z = first / width, x = first % width;
  uint8_t doubtful[256];
  __builtin_memset(doubtful, 1, sizeof doubtful);
  const uint32_t left = x == 0 ? 1 : 0, right = x + count == width ? 1 : 0;
  if (z != 0 && z + 1 != relief->desc.cells[1] && count > left + right)
    find_doubtful(cells, width, first + left, count - left - right, doubtful + left);
  for (uint32_t i = first; i < first + count; ++i) {
    const bool looked = cells.now[i] != k_relief_none;
    cells.now[i] = k_relief_none;
    int32_t height = 0;
    if (doubtful[i - first] == 0 || !asks_for(*relief, i, &height)) {
      cells.beyond[i] = 0;
      if (looked && cells.calm[i] < k_calm_max) ++cells.calm[i];
      continue;
    }
    if (looked && cells.beyond[i] < UINT8_MAX) ++cells.beyond[i];
    if (cells.beyond[i] < 1 + cells.calm[i] / k_calm_images) continue;
    cells.beyond[i] = cells.calm[i] = 0;
    show(relief, i, height);
  }
}

}  // namespace

void relief_end_change(ReliefState* relief) {
  if (!relief->changes_now) return;
  relief->changes_now = false;
  ++relief->change;
  int16_t highest = 0;
  const uint32_t count = relief_cells(*relief);
  for (uint32_t i = 0; i < count; ++i) highest = relief->cells.shown[i] > highest ? relief->cells.shown[i] : highest;
  relief->heights[count] = static_cast<float>(highest) * k_relief_unit;
}

void relief_version_takes(ReliefState* relief, uint32_t i) {
  const uint32_t at[2] = {i % relief->desc.cells[0], i / relief->desc.cells[0]};
  ReliefBox* box = &relief->changing;
  for (int k = 0; k < 2; ++k) {
    box->low[k] = at[k] < box->low[k] ? at[k] : box->low[k];
    box->high[k] = at[k] + 1 > box->high[k] ? at[k] + 1 : box->high[k];
  }
}

void relief_end_version(ReliefState* relief) {
  if (relief->changing.high[0] == 0) return;
  relief->changed = relief->changing;
  ++relief->version;
}

void relief_commit(ReliefState* relief, uint32_t first, uint32_t end) {
  relief_for_rows(first, end, relief->desc.cells[0], k_relief_unit_cells,
                  [&](uint32_t from, uint32_t count) { commit_row(relief, from, count); });
}

}  // namespace sandglass
