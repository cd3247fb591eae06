// The grains: what is drawn. They follow a snapshot of the particles.
#pragma once

#include "runtime/core/layout.h"
#include "runtime/granular/cell_sort.h"

namespace sandglass {

// A copy of the particles for a sweep. While the sweep goes on, the particles go on too.
struct Snapshot {
  Particle* particles;  // in sorted order
  float* positions[3];  // x, y and z of the same; those of bodies lie far from everything
  CellSort sort;        // cells as wide as the support radius
};

struct Grains {
  Grain* records;
  uint32_t count;
  CellSort sort;
  Snapshot snapshot;
};

// particle_rows: room for particles and padding.
void grains_layout(Grains* grains, const sandglass_granular_desc& desc, uint32_t particle_rows, Layout* layout);
// What a sort of the grains needs besides them. Nothing is kept there from sort to sort.
void grains_sort_layout(Grains* grains, const sandglass_granular_desc& desc, Layout* layout);
void grains_reset(Grains* grains);

}  // namespace sandglass
