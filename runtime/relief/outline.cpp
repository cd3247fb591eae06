// Which cells are within the plane's outline: along each row of cells, every edge that is crossed turns outside into inside
// for all that follow, and back.
#include "platform/floating_point.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/relief/relief.h"

namespace sandglass {
namespace {

constexpr uint64_t k_corners_max = 4096;  // each is asked once for each row of cells

const char* outline_fault(const float* corners, const uint32_t* counts, uint32_t rings) {
  if (rings != 0 && (corners == nullptr || counts == nullptr)) return "corners or counts is NULL: pass both.";
  uint64_t all = 0;
  for (uint32_t i = 0; i < rings; ++i) {
    if (counts[i] < 3) return "a ring has fewer than 3 corners.";
    all += counts[i];
    if (all > k_corners_max) return "the outline has more than 4096 corners: pass a coarser one.";
  }
  for (uint64_t i = 0; i < 2 * all; ++i)
    if (!within(corners[i], -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
      return "a corner is not finite, or beyond 1000 m: they are metres in the plane's frame.";
  return nullptr;
}

// Cells of a row beyond where the edge crosses its middle, at `z`. Of an edge its lower end counts, and not its upper one.
void cross(uint8_t* row, uint32_t cells, float z, const float a[2], const float b[2]) {
  if ((a[1] <= z) == (b[1] <= z)) return;
  const float x = a[0] + (z - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
  for (uint32_t i = 0; i < cells; ++i) row[i] ^= static_cast<float>(i) + 0.5f > x ? 1 : 0;
}

// Corners in cells.
void find_gone(const ReliefState& relief, const float* corners, const uint32_t* counts, uint32_t rings, uint32_t row,
               uint8_t* gone) {
  const uint32_t cells = relief.desc.cells[0];
  const float z = static_cast<float>(row) + 0.5f;
  __builtin_memset(gone, rings != 0 ? 1 : 0, cells);
  const auto corner = [&](const float* at, float cell[2]) {
    for (int k = 0; k < 2; ++k) cell[k] = at[k] * relief.per_metre + relief.middle[k];
  };
  for (uint32_t ring = 0; ring < rings; corners += 2ull * counts[ring++]) {
    float from[2], to[2];
    corner(corners + 2ull * (counts[ring] - 1), from);
    for (uint32_t i = 0; i < counts[ring]; ++i) {
      corner(corners + 2ull * i, to);
      cross(gone, cells, z, from, to);
      __builtin_memcpy(from, to, sizeof from);
    }
  }
}

__attribute__((noinline)) void take_outline(ReliefState* relief, const float* corners, const uint32_t* counts,
                                            uint32_t rings) {
  const ReliefBox under_way = relief->changing;
  relief->changing = k_relief_no_cells;
  for (uint32_t row = 0; row < relief->desc.cells[1]; ++row) {
    uint8_t gone[256];
    find_gone(*relief, corners, counts, rings, row, gone);
    for (uint32_t x = 0; x < relief->desc.cells[0]; ++x) {
      const uint32_t i = row * relief->desc.cells[0] + x;
      if (relief->gone[i] == gone[x]) continue;
      relief->gone[i] = gone[x];
      relief_show(relief, i, relief->cells.shown[i]);
      relief_version_takes(relief, i);
    }
  }
  relief_end_change(relief);
  relief_end_version(relief);
  relief->changing = under_way;
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

sandglass_status sandglass_relief_set_outline(sandglass_relief* relief, const float* corners, const uint32_t* counts,
                                              uint32_t rings, const char** reason) {
  if (relief == nullptr) return refuse(reason, "relief is NULL.");
  if (const char* fault = outline_fault(corners, counts, rings)) return refuse(reason, fault);
  const ExactFloatingPoint exact;
  take_outline(&relief->relief, corners, counts, rings);
  return accept(reason);
}
