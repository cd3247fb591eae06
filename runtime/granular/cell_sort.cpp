#include "runtime/granular/cell_sort.h"
#include "kernels/whole.h"

namespace sandglass {

namespace {

// As many cells are cleared or summed for what moving one record costs.
constexpr uint32_t k_cells_per_item = 8;

// What a unit costs besides its items, in items. Without it the last, short unit of a phase would look expensive.
constexpr uint32_t k_unit_overhead = 64;

uint32_t power_of_two(uint64_t at_least) {
  uint32_t p = 512;  // 8 cells an axis, the fewest that a sweep looks at
  while (p < at_least && p < (1u << 30)) p *= 2;
  return p;
}

uint32_t unit_size(const CellSort& sort, uint32_t unit) {
  return sort.phase == k_sort_clear || sort.phase == k_sort_prefix ? unit * k_cells_per_item : unit;
}

// Finds the places in the order of the records from `first` to `last`.
void find_places(CellSort* sort, uint32_t first, uint32_t last) {
  for (uint32_t i = first; i < last; ++i) sort->keys[i] = sort->starts[sort->keys[i] + 1]++;
}

// Swaps records into their places, or passes those that are there, `steps` times. Returns the first that is not in its
// place. Each swap puts a record into its place for good, so there are two steps a record at most.
uint32_t swap_records(Record* records, uint32_t* places, uint32_t first, uint32_t count, uint32_t steps) {
  uint32_t i = first;
  for (; steps != 0 && i < count; --steps) {
    const uint32_t place = places[i];
    if (place == i) {
      ++i;
      continue;
    }
    const Record moved = records[i];
    records[i] = records[place], records[place] = moved;
    places[i] = places[place], places[place] = place;
  }
  return i;
}

// To where the target wants them.
void scatter(CellSort* sort, const Record* records, uint32_t first, uint32_t last, const SortTarget& target) {
  for (uint32_t i = first; i < last; ++i) {
    const uint32_t to = sort->starts[sort->keys[i] + 1]++;
    target.records[to] = records[i];
    if (target.positions[0] == nullptr) continue;
    const bool hidden = target.sand_only && in_body(as_particle(records[i]));
    for (int k = 0; k < 3; ++k) target.positions[k][to] = hidden ? k_inert_position : records[i].position[k];
  }
}

uint32_t phase_end(const CellSort& sort, uint32_t record_count) {
  if (sort.phase == k_sort_clear) return sort.cells + 2;
  if (sort.phase == k_sort_prefix) return sort.cells;
  return record_count;
}

}  // namespace

void cell_sort_layout(CellSort* sort, Layout* layout, const char* starts_name, const char* keys_name, uint64_t records,
                      uint64_t cells) {
  sort->cells_max = power_of_two(cells);
  sort->starts = layout_region<uint32_t>(layout, starts_name, static_cast<uint64_t>(sort->cells_max) + k_array_slack);
  sort->keys = layout_region<uint32_t>(layout, keys_name, records + k_array_slack);
}

void cell_sort_begin(CellSort* sort, float cell, const float low[3], const float high[3], uint32_t bits_min) {
  const float inverse = 1.0f / cell;
  uint32_t bits[3];
  for (int k = 0; k < 3; ++k) {
    const float extent = (high[k] - low[k]) * inverse + 2.0f;
    const uint32_t cells = extent > 1.0f && extent < 1048576.0f ? to_whole<uint32_t>(extent) : 1048576u;
    bits[k] = bits_min;
    while ((1u << bits[k]) < cells) ++bits[k];
  }
  while ((1ull << (bits[0] + bits[1] + bits[2])) > sort->cells_max) {
    const int longest = bits[0] >= bits[1] && bits[0] >= bits[2] ? 0 : bits[1] >= bits[2] ? 1 : 2;
    if (bits[longest] == bits_min) break;
    --bits[longest];
  }
  sort->grid.inverse_cell = inverse;
  for (int k = 0; k < 3; ++k) {
    sort->grid.bits[k] = bits[k];
    const float scaled = low[k] * inverse;
    sort->first[k] = scaled > -1e9f && scaled < 1e9f ? to_whole<int32_t>(scaled) - 1 : 0;
  }
  sort->grid.starts = sort->starts;
  sort->cells = 1u << (bits[0] + bits[1] + bits[2]);
  sort->phase = k_sort_clear;
  sort->cursor = 0;
  sort->sum = 0;
}

uint32_t cell_sort_items(const CellSort& sort, uint32_t record_count, uint32_t unit) {
  const uint32_t left = phase_end(sort, record_count) - sort.cursor, size = unit_size(sort, unit);
  const uint32_t items = left < size ? left : size;
  return k_unit_overhead +
         (sort.phase == k_sort_clear || sort.phase == k_sort_prefix ? items / k_cells_per_item : items);
}

void cell_sort_run(CellSort* sort, const Kernels& kernels, const Record* records, uint32_t record_count, uint32_t unit,
                   const SortTarget& target) {
  const uint32_t end = phase_end(*sort, record_count), size = unit_size(*sort, unit);
  const uint32_t first = sort->cursor;
  uint32_t last = end - first < size ? end : first + size;
  uint32_t* starts = sort->starts;
  switch (sort->phase) {
    case k_sort_clear:
      for (uint32_t c = first; c < last; ++c) starts[c] = 0;
      break;
    case k_sort_count: {
      const GridCellsArgs args = {
          sort->grid, records, sort->keys, sort->serpentine ? 1 : 0, {sort->first[0], sort->first[1], sort->first[2]}};
      uint32_t unused = 0;
      kernels.grid_cells(&args, first, last, &unused);
      // Counts stand two places on, so the sums stand one place on, and scattering moves them into place.
      for (uint32_t i = first; i < last; ++i) ++starts[sort->keys[i] + 2];
      break;
    }
    case k_sort_prefix: {
      uint32_t sum = sort->sum;
      for (uint32_t c = first; c < last; ++c) {
        sum += starts[c + 1];
        starts[c + 1] = sum;
      }
      sort->sum = sum;
      break;
    }
    case k_sort_scatter:
      if (target.records == records) find_places(sort, first, last);
      else scatter(sort, records, first, last, target);
      break;
    default:
      last = swap_records(target.records, sort->keys, first, end, size);
      break;
  }
  sort->cursor = last;
  if (last == end) {
    sort->cursor = 0;
    ++sort->phase;
    if (sort->phase == k_sort_swap && target.records != records) sort->phase = k_sort_done;
  }
}

}  // namespace sandglass
