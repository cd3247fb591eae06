#include "runtime/granular/boundary.h"

#include "runtime/granular/granular.h"

namespace sandglass {

void boundary_layout(Boundary* b, const sandglass_granular_desc& d, Layout* layout) {
  const char* const axes[3] = {"granular.boundary_x", "granular.boundary_y", "granular.boundary_z"};
  const uint64_t capacity = d.boundary_capacity;
  if (capacity == 0) return;
  for (int k = 0; k < 3; ++k) b->positions[k] = layout_region<float>(layout, axes[k], capacity + k_array_slack);
  cell_sort_layout(&b->sort, layout, "granular.boundary_cells", "granular.boundary_keys", capacity, 4 * capacity);
}

Particle* boundary_particles(const Granular& g) { return g.particles.records[0] + g.particles.rows; }

void boundary_sort(Granular* g, uint32_t count) {
  Boundary& boundary = g->boundary;
  Particles& p = g->particles;
  boundary.count = count;
  boundary.bounds = k_nowhere;
  if (count != 0) {
    Particle* sorted = boundary_particles(*g);
    Particle* unsorted = p.records[1] + p.rows;
    __builtin_memcpy(unsorted, sorted, count * sizeof(Particle));
    for (uint32_t i = 0; i < count; ++i) bounds_include(&boundary.bounds, unsorted[i].position);
    cell_sort_begin(&boundary.sort, neighbours_reach(*g), boundary.bounds.low, boundary.bounds.high, 2);
    const SortTarget target = {
        as_records(sorted), {boundary.positions[0], boundary.positions[1], boundary.positions[2]}, false};
    while (boundary.sort.phase != k_sort_done)
      cell_sort_run(&boundary.sort, *g->kernels, as_records(unsorted), count, g->unit, target);
    particles_copy_to_all(&p, p.rows, count);
  }
  for (Particle* records : p.records) {
    if (records != nullptr) records[p.inert] = inert_particle();
  }
}

}  // namespace sandglass
