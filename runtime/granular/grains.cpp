#include "runtime/granular/grains.h"

namespace sandglass {

void grains_layout(Grains* g, const sandglass_granular_desc& d, uint32_t particle_rows, Layout* layout) {
  if (d.grain_capacity == 0) return;
  const char* const axes[3] = {"granular.snapshot_x", "granular.snapshot_y", "granular.snapshot_z"};
  const uint64_t rows = particle_rows, grain_rows = static_cast<uint64_t>(d.grain_capacity) + k_array_slack;
  Snapshot& s = g->snapshot;
  for (int k = 0; k < 3; ++k) s.positions[k] = layout_region<float>(layout, axes[k], rows + k_array_slack);
  s.particles = layout_region<Particle>(layout, "granular.snapshot", rows);
  cell_sort_layout(&s.sort, layout, "granular.snapshot_cells", "granular.snapshot_keys", rows, 2 * rows);
  g->records = layout_region<Grain>(layout, "granular.grains", grain_rows);
}

void grains_sort_layout(Grains* g, const sandglass_granular_desc& d, Layout* layout) {
  const uint64_t grain_rows = static_cast<uint64_t>(d.grain_capacity) + k_array_slack;
  cell_sort_layout(&g->sort, layout, "cells", "keys", grain_rows, grain_rows);
  g->sort.serpentine = true;
}

void grains_reset(Grains* g) { g->count = 0; }

}  // namespace sandglass
