// The state behind sandglass/relief.h: heights over a plane, in cells. An image passes through it in phases, cut into
// units of the relief's stage:
//   read     the app's pixels, of which those beside steps are rejected, into samples; votes for the plane (read.cpp)
//   gather   the samples into the cells: of each the highest (gather.cpp)
//   look     what the image shows of a cell, into the ring of its last eight looks; their median (look.cpp)
//   commit   the median of medians, into what is shown, where it differs enough (commit.cpp)
// Meshes pass through two more (meshes.cpp):
//   raise    their triangles into heights of their own
//   settle   those into what is shown, where they differ from what meshes gave before
// After any unit the heights are those of a map: cells change one after another. The outline takes cells out (outline.cpp).
//
// Lengths in cells and samples are whole numbers, so that no order of operations matters to a bit.
#pragma once

#include <cstdint>

#include "kernels/kernels.h"
#include "runtime/frame/capability.h"
#include "runtime/math/app_mesh.h"
#include "sandglass/relief.h"

namespace sandglass {

constexpr uint32_t k_relief_samples = 16384;       // of an image at most
constexpr uint32_t k_relief_unit_samples = 1024;   // read or gathered in one unit
constexpr uint32_t k_relief_unit_cells = 2048;     // looked at, committed or settled in one unit
constexpr uint32_t k_relief_unit_triangles = 512;  // raised in one unit
constexpr uint32_t k_relief_looks = 8;
constexpr uint32_t k_relief_looks_min = 5;  // with fewer a cell counts as not seen
constexpr uint32_t k_relief_bins = 128;     // of the votes for the plane
constexpr float k_relief_scale_min = 0.92f, k_relief_scale_max = 1.08f;

constexpr float k_relief_unit = 0.00025f;      // metres of a height
constexpr float k_relief_per_metre = 4000.0f;  // heights
constexpr int16_t k_relief_none = -32768;
// 0.5 m and -3 cm. What is higher hangs over the plane. What is lower is seen past the plane's edge, or was measured
// badly, and says nothing of the cell: as holes such samples were wrong in 6 of 100.
constexpr int16_t k_relief_highest = 2000, k_relief_lowest = -120;
constexpr int32_t k_relief_flat = 32;            // heights, 8 mm: what is lower is the plane
constexpr uint32_t k_relief_magic = 0x68726773;  // "sgrh"
constexpr uint32_t k_relief_lanes = 8;           // cells whose looks are sorted together

// A sample: depth in eighths of a millimetre, 0 where it is unknown, and whether it lies beside a step.
constexpr float k_sample_unit = 0.000125f;
constexpr uint16_t k_sample_depth = 0x7fff, k_sample_rejected = 0x8000;

// Kinds of work unit.
enum : uint32_t { k_relief_read, k_relief_gather, k_relief_look, k_relief_commit, k_relief_raise, k_relief_settle };
static_assert(k_relief_settle + 1 == k_relief_kinds);

enum class ReliefPhase : uint32_t { idle, read, gather, look, commit, raise, settle };

// What is known of the cells, an array of each: passes over them are over many at once.
struct ReliefCells {
  uint32_t pitch;   // of `looks`: the number of cells, rounded up to k_relief_lanes
  int16_t* looks;   // k_relief_looks rows of `pitch`; the highest number where there is none
  int16_t* median;  // of the looks
  int16_t* shown;
  int16_t* now;   // the highest sample of the image under way, or k_relief_none
  uint8_t* seen;  // looks that there are
  uint8_t* next;  // where the next one goes
  // Images in a row that ask for another height; images that did not since the last change, up to k_calm_max.
  uint8_t *beyond, *calm;
};

// The image under way, as seen from the plane's frame.
struct ReliefView {
  sandglass_depth_image image;  // its pointers are null once it was read
  uint32_t step;                // pixels from sample to sample
  uint32_t width, height;       // samples
  // Of the pixel of the principal point, and by how much a pixel to the right, and one down, is another direction. Along
  // `ahead` depth counts.
  float position[3], ahead[3], right[3], down[3];
  uint32_t votes[k_relief_bins], vote_count;
};

struct ReliefMesh {
  sandglass_cast_mesh asked;
  // As it was raised: from its frame into the plane's, three rows of four; and the greatest coordinate of its triangles
  // above the map.
  double rows[12], reach;
};

// What meshes say of the cells.
struct ReliefRaised {
  ReliefMesh* meshes;
  uint32_t count;
  bool due;  // other meshes than those that were raised, or they have moved
  uint32_t restarts;
  uint32_t mesh, triangle, row;  // the next
  int16_t *made, *given;         // heights of the raise under way; of the last one that was settled; or k_relief_none
};

// The cells of the map that a version has changed.
struct ReliefBox {
  uint32_t low[2], high[2];
};

constexpr ReliefBox k_relief_no_cells = {{UINT32_MAX, UINT32_MAX}, {0, 0}};

// Which change was a cell's last one, which the one before, and its height between these, metres.
struct CellChange {
  uint32_t last, before;
  float height_before;
};

struct ReliefState {
  uint32_t magic;
  sandglass_relief_desc desc;
  float position[3];  // of the plane
  float rotation[4];
  float per_metre, middle[2];  // cells of a metre; where the plane's origin lies, in cells
  float scale;                 // of depths
  bool scale_known;
  uint64_t version, last_ns;
  ReliefBox changed, changing;  // by the last version; by the commit under way
  ReliefPhase phase;
  uint32_t cursor;
  ReliefView view;
  ReliefCells cells;
  ReliefRaised raised;
  uint8_t* gone;      // 1: beyond the outline, or in a hole of it
  float* heights;     // and the greatest of them
  uint16_t* samples;  // k_relief_samples
  // For what lies on it, whenever it looks: the last change, counted unit by unit, never 0; what is known of each cell's;
  // and whether the one under way has changed something.
  uint32_t change;
  CellChange* changes;
  bool changes_now;
};

inline uint32_t relief_cells(const ReliefState& r) { return r.desc.cells[0] * r.desc.cells[1]; }
// Whether neither an image nor a mesh is under way, or due.
inline bool relief_idle(const ReliefState& r) { return r.phase == ReliefPhase::idle && !r.raised.due; }
inline uint32_t relief_samples(const ReliefView& v) { return v.width * v.height; }

// The heights as kernels see them, in the plane's frame.
inline FieldGrid relief_grid(const ReliefState& r) {
  FieldGrid grid = {r.heights, {r.desc.cells[0], 1, r.desc.cells[1]}, {}, r.desc.cell, r.per_metre, 1, 0};
  for (int k = 0; k < 2; ++k) grid.low[2 * k] = r.desc.cell * (0.5f - r.middle[k]);
  return grid;
}

// Half the sides of a box, in the plane's frame, that holds what may stand on it.
inline float relief_reach(const ReliefState& r, int axis) {
  const float across = 0.5f * r.desc.cell * static_cast<float>(r.desc.cells[axis == 0 ? 0 : 1] + 1);
  return axis == 1 ? k_relief_unit * k_relief_highest : across;
}

// Shows another height of a cell. relief_end_change ends what was changed at once.
void relief_show(ReliefState* relief, uint32_t cell, int16_t height);
void relief_end_change(ReliefState* relief);
// Makes a cell one that nobody has looked at, of this height.
void relief_set_cell(ReliefState* relief, uint32_t cell, int16_t height);
void relief_reset(ReliefState* relief);
// What is wrong with a depth image, or null.
const char* relief_fault(const sandglass_depth_image& image);
// Takes an image that nothing is wrong with, unless it is the one before or another is under way. It must stay until it
// has been read.
bool relief_take(ReliefState* relief, const sandglass_depth_image& image);

// The direction of a sample in the plane's frame, along which one metre of depth is gone.
inline void relief_ray(const ReliefView& view, uint32_t column, uint32_t row, float ray[3]) {
  const float right = static_cast<float>(column * view.step) - view.image.centre_x;
  const float down = static_cast<float>(row * view.step) - view.image.centre_y;
  for (int k = 0; k < 3; ++k) ray[k] = view.ahead[k] + right * view.right[k] + down * view.down[k];
}

// Calls visit(first, count) for each part of a row, at most `most` long, among items below `end` of rows of `width`.
template <class Visit>
void relief_for_rows(uint32_t first, uint32_t end, uint32_t width, uint32_t most, const Visit& visit) {
  while (first < end) {
    uint32_t count = width - first % width;
    count = count < most ? count : most;
    count = count < end - first ? count : end - first;
    visit(first, count);
    first += count;
  }
}

// Shows a height in a cell, unless it is gone.
void relief_show(ReliefState* relief, uint32_t cell, int16_t height);
// The version that is being made changes this cell; it is done.
void relief_version_takes(ReliefState* relief, uint32_t cell);
void relief_end_version(ReliefState* relief);

// Meshes or plane were set: whether some mesh is to be raised anew.
void relief_meshes_moved(ReliefState* relief);
void relief_begin_raise(ReliefState* relief);
uint32_t relief_raise_items(const ReliefState& relief);
// One unit. True once all are raised.
bool relief_raise(ReliefState* relief);

// The phases. Each runs from `first`, below `end`.
void relief_read(ReliefView* view, const ReliefState& relief, uint32_t first, uint32_t end);
// Once all was read: what depths are multiplied by.
void relief_find_scale(ReliefState* relief);
void relief_gather(const ReliefState& relief, uint32_t first, uint32_t end);
void relief_look(const ReliefState& relief, uint32_t first, uint32_t end);
void relief_commit(ReliefState* relief, uint32_t first, uint32_t end);
void relief_settle(ReliefState* relief, uint32_t first, uint32_t end);

// Runs the next unit.
void relief_run_unit(ReliefState* relief);

extern const Capability k_relief_capability;

}  // namespace sandglass

struct sandglass_relief {
  sandglass::Member member;
  sandglass::ReliefState relief;
};
