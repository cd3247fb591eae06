// Contacts in pairs and their colours. From the neighbour lists every pair is taken once and gets a colour: the first
// that neither of its particles has in another pair. So pairs of one colour have no particle in common, and may be
// solved in any order, by any number of lanes and threads, with the same bits (kernels/pairs.inl).
//
// Pairs of one colour are a run. Near pairs come before the others, and a run has pairs of two moving particles or pairs
// with the boundary, never both. Each run is filled up to whole lane groups. It takes groups as it needs them, so that
// one walk over the lists is enough. A pass goes over all runs, always from the first to the last.
#pragma once

#include "runtime/core/layout.h"

namespace sandglass {

struct Granular;

// Colours of a class of pairs. A dense packing needs about sixteen; a pair for which none is left is dropped.
constexpr uint32_t k_pair_colours = 32;
constexpr uint32_t k_pair_runs = 4 * k_pair_colours;

// Pairs that count as one item of a work unit. A particle of a dense packing has about five.
constexpr uint32_t k_pairs_an_item = 4;

struct PairColours {
  uint32_t *first, *second;          // indices of the particles of each pair, in groups as they were needed
  uint32_t* groups;                  // the groups in the order of a pass
  uint8_t* runs;                     // the run of each group
  uint32_t* taken[2];                // colours that a particle has: of near pairs, of the others
  uint32_t capacity, group_count;    // groups
  uint32_t starts[k_pair_runs + 1];  // of the runs, in pairs of a pass
  uint32_t ends[k_pair_runs];        // behind the last pair of each run in `first` and `second`; 0: it has none
  uint8_t filled[k_pair_runs];       // the runs that hold pairs, in order
  uint32_t filled_count;
  uint32_t step;  // of the colouring
  bool ready;     // false: the lists have changed since
};

void pair_colours_layout(PairColours* colours, const sandglass_granular_desc& desc, uint32_t rows, Layout* layout);
// The lists have changed: colours must be found again before the next pass.
void pair_colours_forget(PairColours* colours);
// Colouring, in units. True once it is done.
bool pair_colours_run(Granular* granular);

// Part of a pass: pairs [begin, end) of one run. Pair p is lane p % 16 of group groups[p / 16].
struct PairPiece {
  uint32_t begin, end;
  bool fixed;  // pairs with the boundary
};
uint32_t pair_count(const PairColours& colours);  // with what fills the runs
// Pairs of a work unit of at most `items` items. A pass is cut evenly: a short last unit would look dear for its items.
uint32_t pair_unit(const PairColours& colours, uint32_t items);
// The piece of at most `most` pairs that comes after `done` pairs of a pass.
PairPiece pair_piece(const PairColours& colours, uint32_t done, uint32_t most);

}  // namespace sandglass
