// A counting sort of records by grid cell, cut into work units: clear, count, sum, scatter. It is stable, so the order
// never depends on how it was cut. The source records are only read; the result is complete after the last unit. A sort
// in place swaps them instead: between any two units every record is there once.
#pragma once

#include "kernels/kernels.h"
#include "runtime/core/layout.h"

namespace sandglass {

// Kernels may read arrays up to a vector beyond their last item: every array has this many more.
constexpr uint32_t k_array_slack = 2 * k_lane_group;

struct CellSort {
  Grid grid;         // grid.starts == starts
  uint32_t* starts;  // cells + 2
  uint32_t* keys;    // one a record; in place: later its place in the order
  uint32_t cells;
  uint32_t cells_max;  // a power of two
  uint32_t phase;      // k_sort_clear ... k_sort_done
  uint32_t cursor;
  uint32_t sum;
  bool serpentine;   // an order only, not looked up: see GridCellsArgs
  int32_t first[3];  // cell of the lower bound
};

enum : uint32_t { k_sort_clear, k_sort_count, k_sort_prefix, k_sort_scatter, k_sort_swap, k_sort_done };

// Where the sorted copy goes: records (the source itself: in place), and where wanted their positions, one array for
// each axis.
struct SortTarget {
  Record* records;
  float* positions[3];  // null: not wanted
  bool sand_only;       // the records are particles; those of bodies get a position far from everything
};

// Regions for sorting up to `records` records into about `cells` cells.
void cell_sort_layout(CellSort* sort, Layout* layout, const char* starts_name, const char* keys_name, uint64_t records,
                      uint64_t cells);

// Chooses the grid and starts the sort. Cells have the edge `cell`. Along each axis there are as many as the bounds
// need, at least 2^bits_min, and at most cells_max in all.
void cell_sort_begin(CellSort* sort, float cell, const float low[3], const float high[3], uint32_t bits_min);

// Cost of the next unit in records: at most `unit` of them, and a fixed share for the unit itself.
uint32_t cell_sort_items(const CellSort& sort, uint32_t record_count, uint32_t unit);

// Runs the next unit.
void cell_sort_run(CellSort* sort, const Kernels& kernels, const Record* records, uint32_t record_count, uint32_t unit,
                   const SortTarget& target);

}  // namespace sandglass
