// Layer 2 of granular: the records of the material's physics, those that move and those that stand, in order of cells,
// and who of them may touch.
#pragma once

#include "kernels/kernels.h"
#include "kernels/particle.h"
#include "runtime/frame/layout.h"
#include "runtime/sand/world.h"

namespace sandglass {

struct Granular;

// ---- CellSort (particles.cpp)
//
// A counting sort of records by grid cell, cut into work units: clear, count, sum, scatter. It is stable, so the order
// never depends on how it was cut. The source records are only read; the result is complete after the last unit. A sort
// in place swaps them instead: between any two units every record is there once.

// Kernels may read arrays up to a vector beyond their last item: every array has this many more.
constexpr uint32_t k_array_slack = 2 * k_lane_group;

struct CellSort {
  Grid grid;         // grid.starts == starts
  uint32_t* starts;  // cells + 2
  uint32_t* keys;    // one a record: its cell; then, in a sort in place, its place in the order
  uint32_t cells;
  uint32_t cells_max;  // a power of two
  uint32_t phase;      // k_sort_clear ... k_sort_done
  uint32_t cursor;
  uint32_t sum;
  bool serpentine;   // see GridCellsArgs
  int32_t first[3];  // cell of the lower bound
};

enum : uint32_t { k_sort_clear, k_sort_count, k_sort_prefix, k_sort_scatter, k_sort_swap, k_sort_done };

// Where the sorted copy goes.
struct SortTarget {
  Record* records;      // the source itself: the sort is in place
  float* positions[3];  // x, y and z of the records; null: not wanted
  // The records are particles, and those of bodies get positions far from everything.
  bool sand_only;
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

// ---- Particles (particles.cpp)
//
// The particles: the records of the material's physics, and the box that holds them.

// A box around points, metres. Empty: low above high.
struct Bounds {
  float low[3], high[3];
};
constexpr Bounds k_nowhere = {{3e38f, 3e38f, 3e38f}, {-3e38f, -3e38f, -3e38f}};

static inline bool is_empty(const Bounds& b) { return b.low[0] > b.high[0]; }
static inline void bounds_join(Bounds* b, const Bounds& other) {
  for (int k = 0; k < 3; ++k) {
    b->low[k] = other.low[k] < b->low[k] ? other.low[k] : b->low[k];
    b->high[k] = other.high[k] > b->high[k] ? other.high[k] : b->high[k];
  }
}
// A ball.
static inline void bounds_include(Bounds* b, const float at[3], float radius = 0.0f) {
  bounds_join(b, {{at[0] - radius, at[1] - radius, at[2] - radius}, {at[0] + radius, at[1] + radius, at[2] + radius}});
}

// Those of sixteen records whose bits are set, in order: most often all, so those that follow one another are one loop.
template <class Of, class Do>
static inline void for_bits(uint32_t which, Of* records, const Do& each) {
  for (; which != 0; which &= which + (which & -which)) {
    const int first = __builtin_ctz(which);
    Of* const end = records + first + __builtin_ctz(~(which >> first));
    for (Of* record = records + first; record != end; ++record) each(record);
  }
}

struct Particles {
  // [0]: the state after the last complete sub-step. [1]: what the next one writes. [2]: only where a sub-step has more
  // than one pass. Each array holds the particles sorted by cell, padding, the boundary, and at last an inert particle.
  Particle* records[3];
  uint32_t count;
  uint32_t rows;   // room for particles and padding; the boundary follows
  uint32_t inert;  // index of the inert particle that pads neighbour rows
  // The box that holds the particles. Not known: no particle has been added yet.
  float low[3], high[3];
  bool bounds_known;
  float speed_max;  // m/s, of the last sub-step and of what was added since
};

void particles_layout(Particles* particles, const sandglass_granular_desc& desc, Layout* layout);
void particles_reset(Particles* particles);

// What records[1] holds becomes the state.
void particles_swap(Particles* particles);
// The same for all arrays: `count` particles from `first` on, as the state has them.
void particles_copy_to_all(const Particles& particles, uint32_t first, uint32_t count);
// A particle that was not there before. Its bounds and its speed count.
void particles_append(Particles* particles, const float position[3], const float velocity[3], uint32_t number);
// Takes particle i out; the last one moves into its place.
void particles_remove(Particles* particles, uint32_t i);

// Widens the bounds and the greatest speed to hold this particle.
void particles_include(Particles* particles, const float position[3], const float velocity[3]);
// The bounds of the particles as they are.
void particles_find_bounds(Particles* particles);
void particles_move(Particles* particles, const SceneMove& move);
void particles_restore(Particles* particles, const SavedScene& saved);

// Particles that have departed count again.
void particles_recall(Particles* particles);
// After a sub-step: bounds and greatest speed are those of `extent` and of what rests.
void particles_take_extent(Particles* particles, const ContactExtent& extent, const Bounds& resting);
// The particles that count have this greatest speed and, where they are not empty, these bounds.
void particles_narrow(Particles* particles, const Bounds& all, float speed_max);
// Particles as fast as this will be added.
void particles_expect_speed(Particles* particles, float speed);
// All stand still.
void particles_stand(Particles* particles);

// Puts inert particles behind the last one, so that kernels may process whole vectors.
void particles_seal(const Particles& particles);

// ---- Boundary (particles.cpp)
//
// The boundary: fixed particles behind the moving ones, sorted by cell whenever they are set or moved.

struct Boundary {
  float* positions[3];  // x, y and z in sorted order
  CellSort sort;
  Bounds bounds;
  uint32_t count;
};

void boundary_layout(Boundary* boundary, const sandglass_granular_desc& desc, Layout* layout);
void boundary_reset(Boundary* boundary);
void boundary_move(Boundary* boundary, const Granular& granular, const SceneMove& move);
// The boundary's particles among those of the state.
Particle* boundary_particles(const Granular& granular);
// Sorts the `count` particles that stand there.
void boundary_sort(Boundary* boundary, const Granular& granular, uint32_t count);

// ---- ListSlack (neighbours.cpp)
//
// How far pairs that no neighbour list holds may still approach each other, measured. The bound that the sub-steps add
// up (neighbours_wear) counts motion against each other anywhere in the scene. Once it is used up, this asks where
// things really are.
//
// Particles are put into blocks of two cells an axis, by where they were when the lists were built. A cell is as wide
// as the lists reach. So two particles that were within two reaches of each other along every axis lie in one window of
// two blocks an axis, and since then they have approached by no more than the diagonal of the box that holds all
// displacements of that window. Two that lay farther apart must approach by two reaches less a diameter before they
// touch; they have approached by no more than the diagonal of the box that holds all displacements.

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

// ---- Neighbours (neighbours.cpp)
//
// Neighbour lists: which particles may touch in the next sub-steps, and how long that stays true.
//
// A list holds every pair that was closer than 2r + skin when it was built. It stays complete while no pair has
// approached by more than the skin, so lists are rebuilt by motion, not after a fixed number of sub-steps. Motion that
// all share does not count: half the range of the displacements bounds how far any particle strays from their mean, and
// a falling body needs no rebuild. Once the motion of the sub-steps has used up the skin, what is left of it is
// measured, place by place (ListSlack).

struct Neighbours {
  CellSort sort;             // of the particles
  float* positions[3];       // x, y and z of the particles in sorted order, as the last build saw them
  uint32_t* lists;           // k_list_slots record indices a particle
  uint8_t* counts;           // used slots a particle
  uint8_t* near_counts;      // of them, near ones
  uint8_t* listed;           // one a group: 1 where the particles have lists
  bool halves;               // every pair is in one list only
  bool valid;                // false: the lists must be rebuilt before the next sub-step
  float slack;               // metres by which pairs may still approach before the lists are stale
  float worn;                // metres that they have approached by while lists are built
  bool measured;             // the slack is that of a measurement, and no sub-step has run since
  float last_spread;         // metres; half the range of the last sub-step's displacements
  float last_substep;        // seconds; its length
  float builds_per_substep;  // recent average, for the forecast
  ListSlack measurement;
};

void neighbours_layout(Neighbours* neighbours, uint32_t rows, Layout* layout);
void neighbours_reset(Neighbours* neighbours, float substep);
// Forgets the lists, as if the particles had just been added.
void neighbours_forget(Neighbours* neighbours, float substep);

// How far apart two particles of a list were at most when it was built, metres.
float neighbours_reach(const Granular& granular);

// Whether a sub-step of this length may need pairs that the lists lack.
bool neighbours_stale(const Granular& granular, uint32_t level, float substep);
// Whether measuring the slack could show that the lists are not stale after all.
bool neighbours_doubt(const Granular& granular);
// Measuring it, in units. True once it is done.
void neighbours_begin_measuring(Neighbours* neighbours);
bool neighbours_run_measuring(Neighbours* neighbours, const Granular& granular, uint32_t* cursor);

// What a unit of building lists has found.
struct ListsSeen {
  uint32_t dropped;  // neighbours that had no room
  uint32_t awake;    // particles
  Bounds resting;    // around particles that sleep
};

// Rebuilding, in units: sort, after which the particles are swapped, then lists. A `run` function is true once its phase
// is done.
void neighbours_begin_sort(Neighbours* neighbours, const Granular& granular);
bool neighbours_run_sort(Neighbours* neighbours, const Granular& granular);
bool neighbours_run_lists(Neighbours* neighbours, const Granular& granular, uint32_t* cursor, ListsSeen* seen);
// The lists must be rebuilt: the records are not what they were built from.
void neighbours_invalidate(Neighbours* neighbours);

// Builds the lists of particles [begin, end) from the grid of the last build. Returns how many neighbours had no room.
uint32_t neighbours_build(const Granular& granular, uint32_t begin, uint32_t end);
// The same for a group that has no lists.
uint32_t neighbours_build_group(const Granular& granular, uint32_t group);
// The whole list of particle i.
const uint32_t* neighbours_of(const Granular& granular, uint32_t i, uint32_t* count);

// After a sub-step: uses up the slack by its motion.
void neighbours_wear(Neighbours* neighbours, const Granular& granular);
// Some particles were put elsewhere and others not: pairs have approached by so much.
void neighbours_carried(Neighbours* neighbours, float metres);
// Nothing moves.
void neighbours_stand(Neighbours* neighbours);
void neighbours_restore(Neighbours* neighbours, const SavedScene& saved);
// At the start of a frame: what the last frame taught about how often lists are rebuilt.
void neighbours_learn(Neighbours* neighbours, uint32_t builds, uint32_t substeps);

// Empty lists, which point at the inert particle, for the inert particles behind the last one.
void neighbours_seal(const Neighbours& neighbours, const Particles& particles);

// ---- PairColours (pairs.cpp)
//
// Contacts in pairs and their colours. From the neighbour lists every pair is taken once and gets a colour: the first
// that neither of its particles has in another pair. So pairs of one colour have no particle in common, and may be
// solved in any order, by any number of lanes and threads, with the same bits (kernels/pairs.inl).
//
// Pairs of one colour are a run. Near pairs come before the others, and a run has pairs of two moving particles or pairs
// with the boundary, never both. Each run is filled up to whole lane groups. It takes groups as it needs them, so that
// one walk over the lists is enough. A pass goes over all runs, always from the first to the last.

// Colours of a class of pairs. A dense packing needs about sixteen; a pair for which none is left is dropped.
constexpr uint32_t k_pair_colours = 32;
constexpr uint32_t k_pair_runs = 4 * k_pair_colours;

// Pairs that count as one item of a work unit. A particle of a dense packing has about five.
constexpr uint32_t k_pairs_an_item = 4;

struct PairColours {
  // The particles of each pair, in groups as they were needed; the groups in the order of a pass; the run of each
  // group.
  uint32_t *first, *second;
  uint32_t* groups;
  uint8_t* runs;
  // Bits of the colours that a particle has: of near pairs, and of the others.
  uint32_t* taken[2];
  uint32_t capacity, group_count;  // groups
  // Where each run starts, in pairs of a pass; and the place after its last pair in `first` and `second`, 0: it has
  // none.
  uint32_t starts[k_pair_runs + 1];
  uint32_t ends[k_pair_runs];
  uint8_t filled[k_pair_runs];  // the runs that hold pairs, in order
  uint32_t filled_count;
  uint32_t step;  // of the colouring
  bool ready;     // false: the lists have changed since
};

void pair_colours_layout(PairColours* colours, const sandglass_granular_desc& desc, uint32_t rows, Layout* layout);
// The lists have changed: colours must be found again before the next pass.
void pair_colours_forget(PairColours* colours);
// Colouring, in units. True once it is done.
bool pair_colours_run(PairColours* colours, const Granular& granular, uint32_t* cursor, FrameCounts* counts);

// Part of a pass: pairs [begin, end) of one run. Pair p is lane p % 16 of group groups[p / 16].
struct PairPiece {
  uint32_t begin, end;
  bool fixed;  // pairs with the boundary
};
uint32_t pair_count(const PairColours& colours);  // with what fills the runs
// Pairs of a work unit of at most `items` items. A pass is cut evenly: a short last unit would look dear for its items.
uint32_t pair_unit(const PairColours& colours, uint32_t items);
// The piece of at most `limit` pairs that comes after `done` pairs of a pass.
PairPiece pair_piece(const PairColours& colours, uint32_t done, uint32_t limit);

}  // namespace sandglass
