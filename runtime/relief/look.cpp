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

void put_in_order(int16_t* a, int16_t* b) {
  const int16_t least = *a < *b ? *a : *b, most = *a < *b ? *b : *a;
  *a = least;
  *b = most;
}

// Of the looks that there are. Missing ones count as the highest, and lie beyond those that are asked for.
int16_t median_of(const ReliefCell& cell) {
  constexpr uint8_t k_network[19][2] = {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {1, 2}, {5, 6},
                                        {0, 4}, {3, 7}, {1, 5}, {2, 6}, {1, 4}, {3, 6}, {2, 4}, {3, 5}, {3, 4}};
  int16_t v[k_relief_looks];
  for (uint32_t i = 0; i < k_relief_looks; ++i) v[i] = i < cell.seen ? cell.looks[i] : INT16_MAX;
  for (const uint8_t* pair : k_network) put_in_order(&v[pair[0]], &v[pair[1]]);
  const uint32_t half = cell.seen / 2;
  return cell.seen % 2 != 0 ? v[half] : static_cast<int16_t>((v[half] + v[half - 1]) / 2);
}

}  // namespace

void relief_look(const ReliefState& relief, uint32_t first, uint32_t end) {
  const uint32_t width = relief.desc.cells[0];
  for (uint32_t i = first; i < end; ++i) {
    ReliefCell* cell = &relief.cells[i];
    if (cell->now == k_relief_none && cell->median >= k_raised &&
        seen_through(relief, i % width, i / width, cell->median))
      cell->now = 0;
    if (cell->now == k_relief_none) continue;
    cell->looks[cell->next] = cell->now;
    cell->next = (cell->next + 1) % k_relief_looks;
    if (cell->seen < k_relief_looks) ++cell->seen;
    if (cell->seen >= k_relief_looks_min) cell->median = median_of(*cell);
  }
}

}  // namespace sandglass
