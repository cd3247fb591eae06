// Poisson-disk sampling of a volume: Alg. 2, on a dense grid with cell edge l in which each cell chains its samples.
//
// Growth from the first seed fills the part of the volume that the seed lies in. The walk over the cells then gives
// every other part its seed: a probe that lies inside and conflicts with nothing. A try is tested for conflicts first
// and for being inside second, because the grid is cheap and the inside test may be a ray tracer. The outcome is the
// same.
#include "runtime/solid/sampling/volume.h"

#include "kernels/whole.h"
#include "runtime/frame/layout.h"
#include "runtime/solid/sampling/arguments.h"
#include "runtime/solid/sampling/methods.h"

namespace sandglass {
namespace {

constexpr uint32_t k_none = 0xFFFFFFFFu;
constexpr uint32_t k_lone_probes = 1000;  // more probes, where that of no cell lies inside
constexpr uint32_t k_progress_interval = 1024;

struct VolumeMemory {
  uint32_t* head;  // of each cell: its newest sample
  uint32_t* next;
  float* positions;
  uint32_t* active;
};

VolumeMemory lay_out(Layout* layout, const CellGrid& grid, uint32_t capacity) {
  VolumeMemory memory;
  const uint64_t cells = static_cast<uint64_t>(grid.cells[0]) * grid.cells[1] * grid.cells[2];
  memory.head = layout_region<uint32_t>(layout, "sampling.volume.head", cells);
  memory.next = layout_region<uint32_t>(layout, "sampling.volume.next", capacity);
  memory.positions = layout_region<float>(layout, "sampling.volume.positions", 3ull * capacity);
  memory.active = layout_region<uint32_t>(layout, "sampling.volume.active", capacity);
  return memory;
}

// An upper bound of the samples. The densest packing of spheres fills pi/sqrt(18) of space, and spheres of diameter l
// around centres in the box stay within l/2 of it: so there are at most sqrt(2) * product of (extent/l + 1).
double packing_bound(const CellGrid& grid) {
  double bound = square_root(2.0);
  for (int k = 0; k < 3; ++k) bound *= (grid.far[k] - grid.origin[k]) / grid.edge + 1;
  return bound;
}

sandglass_status measure(const sandglass_sample_desc& desc, CellGrid* grid, const char** reason) {
  if (const sandglass_status status = check_volume(desc, reason)) return status;
  if (!make_cell_grid(desc.bounds_min, desc.bounds_max, desc.distance, grid) || !(packing_bound(*grid) < 0xFFFFFFFEu))
    return refuse(reason, "distance is too small: more than 2^30 cells of it in the bounding box; enlarge it.");
  return accept(reason);
}

struct VolumeRun {
  const CellGrid& grid;
  const VolumeMemory& memory;
  const sandglass_sample_desc& desc;
  Random random;
  double distance, distance_squared;
  uint32_t capacity, count = 0, active_count = 0;
};

uint64_t cell_index(const CellGrid& grid, uint32_t x, uint32_t y, uint32_t z) {
  return (static_cast<uint64_t>(z) * grid.cells[1] + y) * grid.cells[0] + x;
}

bool conflicts(const VolumeRun& run, const float point[3]) {
  uint32_t low[3], high[3];
  for (int k = 0; k < 3; ++k) {
    // From the coordinates one distance away, not by cell +- 1: right whatever the division rounds to.
    const double x = static_cast<double>(point[k]), reach = run.distance * (1 + 0x1p-30);
    low[k] = cell_along(run.grid, k, x - reach);
    high[k] = cell_along(run.grid, k, x + reach);
  }
  for (uint32_t z = low[2]; z <= high[2]; ++z)
    for (uint32_t y = low[1]; y <= high[1]; ++y)
      for (uint32_t x = low[0]; x <= high[0]; ++x)
        for (uint32_t i = run.memory.head[cell_index(run.grid, x, y, z)]; i != k_none; i = run.memory.next[i]) {
          double sum = 0;
          for (int k = 0; k < 3; ++k) {
            const double d = static_cast<double>(point[k]) - static_cast<double>(run.memory.positions[3ull * i + k]);
            sum += d * d;
          }
          if (sum < run.distance_squared) return true;
        }
  return false;
}

bool in_box(const CellGrid& grid, const float point[3]) {
  for (int k = 0; k < 3; ++k) {
    const double x = static_cast<double>(point[k]);
    if (!(x >= grid.origin[k] && x <= grid.far[k])) return false;
  }
  return true;
}

bool fits(const VolumeRun& run, const float point[3]) {
  return in_box(run.grid, point) && !conflicts(run, point) && run.desc.inside(run.desc.inside_user, point) != 0;
}

bool take_sample(VolumeRun* run, const float point[3]) {
  if (run->count == run->capacity) return false;
  const uint32_t sample = run->count++;
  uint32_t cell[3];
  for (int k = 0; k < 3; ++k) {
    run->memory.positions[3ull * sample + k] = point[k];
    cell[k] = cell_along(run->grid, k, static_cast<double>(point[k]));
  }
  uint32_t* head = &run->memory.head[cell_index(run->grid, cell[0], cell[1], cell[2])];
  run->memory.next[sample] = *head;
  *head = sample;
  run->memory.active[run->active_count++] = sample;
  if (run->desc.progress != nullptr && run->count % k_progress_interval == 0)
    run->desc.progress(run->desc.progress_user, run->count, 0);
  return true;
}

// Alg. 2, lines 4-24.
bool grow(VolumeRun* run) {
  while (run->active_count > 0) {
    const uint32_t chosen = run->random.below(run->active_count);
    const float* centre = run->memory.positions + 3ull * run->memory.active[chosen];
    bool found = false;
    for (uint32_t k = 0; k < run->desc.tries && !found; ++k) {
      const Offset offset = draw_in_shell(&run->random, run->distance);
      const float point[3] = {static_cast<float>(static_cast<double>(centre[0]) + offset.x),
                              static_cast<float>(static_cast<double>(centre[1]) + offset.y),
                              static_cast<float>(static_cast<double>(centre[2]) + offset.z)};
      if (!fits(*run, point)) continue;
      if (!take_sample(run, point)) return false;
      found = true;
    }
    if (!found) run->memory.active[chosen] = run->memory.active[--run->active_count];
  }
  return true;
}

bool seed_and_grow(VolumeRun* run, const float point[3]) {
  return !fits(*run, point) || (take_sample(run, point) && grow(run));
}

bool sample_all(VolumeRun* run) {
  const CellGrid& grid = run->grid;
  const uint64_t cells = static_cast<uint64_t>(grid.cells[0]) * grid.cells[1] * grid.cells[2];
  for (uint64_t i = 0; i < cells; ++i) run->memory.head[i] = k_none;
  float point[3];
  uint32_t cell[3];
  for (cell[2] = 0; cell[2] < grid.cells[2]; ++cell[2])
    for (cell[1] = 0; cell[1] < grid.cells[1]; ++cell[1])
      for (cell[0] = 0; cell[0] < grid.cells[0]; ++cell[0]) {
        draw_probe(grid, run->desc.seed, cell, point);
        if (!seed_and_grow(run, point)) return false;
      }
  for (uint32_t i = 0; i < k_lone_probes && run->count == 0; ++i) {
    for (int k = 0; k < 3; ++k)
      point[k] = static_cast<float>(grid.origin[k] + run->random.uniform() * (grid.far[k] - grid.origin[k]));
    if (!seed_and_grow(run, point)) return false;
  }
  return true;
}

}  // namespace

bool make_cell_grid(const float bounds_min[3], const float bounds_max[3], float distance, CellGrid* grid) {
  double total = 1;
  grid->edge = static_cast<double>(distance);
  for (int k = 0; k < 3; ++k) {
    grid->origin[k] = static_cast<double>(bounds_min[k]);
    grid->far[k] = static_cast<double>(bounds_max[k]);
    const double cells = (grid->far[k] - grid->origin[k]) / grid->edge;
    if (!(cells < static_cast<double>(k_point_limit))) return false;
    grid->cells[k] = cells > 1 ? static_cast<uint32_t>(ceiling_index(cells)) : 1;
    total *= grid->cells[k];
  }
  return total <= static_cast<double>(k_point_limit);
}

sandglass_status sample_in_volume(const sandglass_sample_desc& desc, SampleCall* call, const char** reason) {
  CellGrid grid;
  if (const sandglass_status status = measure(desc, &grid, reason)) return status;
  call->enough = to_whole<uint32_t>(packing_bound(grid)) + 1;
  Layout size;
  lay_out(&size, grid, call->capacity);
  call->bytes = size.size;
  if (call->points == nullptr) return accept(reason);
  if (const sandglass_status status = check_block(call->scratch, call->scratch_bytes, call->bytes, reason))
    return status;

  Layout layout;
  layout.base = static_cast<uint8_t*>(call->scratch);
  const VolumeMemory memory = lay_out(&layout, grid, call->capacity);
  VolumeRun run = {
      grid, memory, desc, random_stream(desc.seed, k_stream_growth), grid.edge, grid.edge * grid.edge, call->capacity};
  if (!sample_all(&run)) return refuse(reason, SANDGLASS_ERROR_CAPACITY, k_beyond_capacity);
  for (uint64_t i = 0; i < 3ull * run.count; ++i) call->points[i] = memory.positions[i];
  call->count = run.count;
  return accept(reason);
}

}  // namespace sandglass
