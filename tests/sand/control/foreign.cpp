// A part that changes others in each way that owners.py knows. It is read, and never compiled.
#include "runtime/sand/granular.h"

namespace sandglass {

void foreign(Granular* g) {
  g->sleep.awake_count += 1;
  --g->neighbours.slack;
  g->sleep.anchors[g->bodies.numbers[0]].quiet++;
  Particles& particles = g->particles;
  bounds_include(&g->sleep.resting, particles.low);
}

}  // namespace sandglass
