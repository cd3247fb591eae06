// The boundary: fixed particles behind the moving ones, sorted by cell whenever they are set or moved.
#pragma once

#include "runtime/core/layout.h"
#include "runtime/granular/cell_sort.h"
#include "runtime/granular/particles.h"

namespace sandglass {

struct Granular;

struct Boundary {
  float* positions[3];  // x, y and z in sorted order
  CellSort sort;
  Bounds bounds;
  uint32_t count;
};

void boundary_layout(Boundary* boundary, const sandglass_granular_desc& desc, Layout* layout);
// The boundary's particles among those of the state.
Particle* boundary_particles(const Granular& granular);
// Sorts the `count` particles that stand there.
void boundary_sort(Granular* granular, uint32_t count);

}  // namespace sandglass
