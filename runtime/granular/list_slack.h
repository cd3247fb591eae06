// How far pairs that no neighbour list holds may still approach each other, measured. The bound that the sub-steps add
// up (neighbours_wear) counts motion against each other anywhere in the scene. Once it is used up, this asks where
// things really are.
//
// Particles are put into blocks of two cells an axis, by where they were when the lists were built. A cell is as wide
// as the lists reach. So two particles that were within two reaches of each other along every axis lie in one window of
// two blocks an axis, and since then they have approached by no more than the diagonal of the box that holds all
// displacements of that window. Two that lay farther apart must approach by two reaches less a diameter before they
// touch; they have approached by no more than the diagonal of the box that holds all displacements.
#pragma once

#include "runtime/core/layout.h"
#include "runtime/granular/cell_sort.h"

namespace sandglass {

struct Granular;

// x, y, z and 0, in the registers of four that all targets have or the compiler makes do without.
typedef float Quad __attribute__((vector_size(16)));

// The box around displacements, in metres. Empty: low above high.
struct DisplacementBox {
  Quad low, high;
};

struct ListSlack {
  DisplacementBox* blocks;
  uint32_t* counts;  // particles in each row of blocks
  DisplacementBox all;
  uint32_t step;
  float widest2;  // squared diagonal of the widest window
};

void list_slack_layout(ListSlack* slack, const CellSort& sort, Layout* layout);
void list_slack_begin(ListSlack* slack);
// Measuring, in units. True once it is done: *metres may then still be closed.
bool list_slack_run(Granular* granular, float* metres);

}  // namespace sandglass
