// What an image shows of each cell, into the ring of its last looks. A cell that no sample fell into may still have been
// looked at: where it is raised, and the camera sees what lies behind it and lower, it is there no more. Without that,
// what was taken away would stay until the camera sees the very plane below it.
#include "kernels/whole.h"
#include "runtime/relief/relief.h"

namespace sandglass {
namespace {

constexpr int16_t k_raised = 40;   // heights, 1 cm
constexpr float k_beyond = 0.04f;  // metres: behind the cell and below its top, more than noise explains
constexpr float k_near = 0.1f;     // metres before the camera

// The least depth of a sample and its eight neighbours, metres. 0: one is unknown.
float depth_about(const ReliefState& relief, int32_t column, int32_t row) {
  const ReliefView& view = relief.view;
  const auto width = static_cast<int32_t>(view.width);
  if (column < 1 || row < 1 || column + 1 >= width || row + 1 >= static_cast<int32_t>(view.height)) return 0;
  int32_t least = k_sample_depth;
  for (int32_t y = row - 1; y <= row + 1; ++y)
    for (int32_t x = column - 1; x <= column + 1; ++x) {
      const int32_t depth = relief.samples[y * width + x] & k_sample_depth;
      least = depth < least ? depth : least;
    }
  return static_cast<float>(least) * k_sample_unit * relief.scale;
}

bool seen_through(const ReliefState& relief, uint32_t x, uint32_t z, int16_t height) {
  const ReliefView& view = relief.view;
  const sandglass_depth_image& image = view.image;
  const float cell = relief.desc.cell;
  const float top[3] = {cell * (static_cast<float>(x) + 0.5f - relief.middle[0]),
                        static_cast<float>(height) * k_relief_unit,
                        cell * (static_cast<float>(z) + 0.5f - relief.middle[1])};
  float ray[3], depth = 0, right = 0, down = 0;
  for (int k = 0; k < 3; ++k) {
    ray[k] = top[k] - view.position[k];
    depth += ray[k] * view.ahead[k];
    right += ray[k] * view.right[k];
    down += ray[k] * view.down[k];
  }
  if (!(depth > k_near)) return false;
  const float steps = static_cast<float>(view.step);
  const float column = (right * image.focal_x * image.focal_x / depth + image.centre_x) / steps,
              row = (down * image.focal_y * image.focal_y / depth + image.centre_y) / steps;
  const float seen = depth_about(relief, floor_whole(column + 0.5f), floor_whole(row + 0.5f));
  const float end = view.position[1] + seen / depth * ray[1];
  return seen > depth + k_beyond && top[1] - end > k_beyond;
}

// Eight cells side by side.
typedef int16_t Lanes __attribute__((vector_size(2 * k_relief_lanes)));

// Sorts the looks of the cells from `first` on. Missing ones are the highest, and lie beyond those that count.
void sort_looks(const ReliefCells& cells, uint32_t first, Lanes v[k_relief_looks]) {
  constexpr uint8_t k_network[19][2] = {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {1, 2}, {5, 6},
                                        {0, 4}, {3, 7}, {1, 5}, {2, 6}, {1, 4}, {3, 6}, {2, 4}, {3, 5}, {3, 4}};
  for (uint32_t k = 0; k < k_relief_looks; ++k)
    __builtin_memcpy(&v[k], cells.looks + k * cells.pitch + first, sizeof v[k]);
  for (const uint8_t* pair : k_network) {
    Lanes *a = &v[pair[0]], *b = &v[pair[1]];
    const Lanes swaps = (*b < *a) & (*a ^ *b);
    *a ^= swaps;
    *b ^= swaps;
  }
}

// Returns whether the image has shown the cell.
bool take_look(const ReliefState& relief, uint32_t i) {
  const ReliefCells& cells = relief.cells;
  const uint32_t width = relief.desc.cells[0];
  if (cells.now[i] == k_relief_none) {
    if (cells.median[i] < k_raised || !seen_through(relief, i % width, i / width, cells.median[i])) return false;
    cells.now[i] = 0;
  }
  cells.looks[cells.next[i] * cells.pitch + i] = cells.now[i];
  cells.next[i] = static_cast<uint8_t>((cells.next[i] + 1) % k_relief_looks);
  if (cells.seen[i] < k_relief_looks) ++cells.seen[i];
  return true;
}

}  // namespace

void relief_look(const ReliefState& relief, uint32_t first, uint32_t end) {
  const ReliefCells& cells = relief.cells;
  for (uint32_t block = first; block < end; block += k_relief_lanes) {
    const uint32_t count = end - block < k_relief_lanes ? end - block : k_relief_lanes;
    bool any = false;
    for (uint32_t i = block; i < block + count; ++i) any |= take_look(relief, i);
    if (!any) continue;
    Lanes v[k_relief_looks];
    sort_looks(cells, block, v);
    for (uint32_t lane = 0; lane < count; ++lane) {
      const uint32_t i = block + lane, seen = cells.seen[i];
      if (cells.now[i] == k_relief_none || seen < k_relief_looks_min) continue;
      cells.median[i] = static_cast<int16_t>((v[(seen - 1) / 2][lane] + v[seen / 2][lane]) / 2);
    }
  }
}

}  // namespace sandglass
