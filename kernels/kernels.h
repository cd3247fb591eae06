// The kernels: pure functions on the caller's arrays, without state, memory or clock. Every instruction set exports one
// table of them; select_kernels picks a table. All tables give the same bits.
//
// Ranges begin at multiples of 16. Arrays of particles and grains are padded to whole groups of 16; the padding of
// particles is inert.
#pragma once

#include <cstdint>

#include "kernels/particle.h"
#include "kernels/whole.h"
#include "sandglass/sandglass.h"

namespace sandglass {

constexpr uint32_t k_lane_group = 16;                                    // every width divides it
constexpr float k_coordinate_bound = 2.0f * SANDGLASS_COORDINATE_LIMIT;  // metres; what strays beyond is quarantined
// Neighbours that a particle's list can hold. In a dense packing 12 to 15 lie within a list's reach.
constexpr uint32_t k_list_slots = 32;

// A grid of cubic cells that covers all space by wrapping round: the cell with integer coordinates c is stored at c mod
// 2^bits per axis. So nothing can leave the grid. Distant cells that share storage cost distance tests, not errors.
struct Grid {
  float inverse_cell;  // 1 / edge
  // log2 of the number of cells per axis. At least 2, so that a cell's neighbours stay distinct. At least 3 for
  // refine_grains, which visits more than four cells along an axis.
  uint32_t bits[3];
  const uint32_t* starts;  // first item of each cell in sorted order, one past the end at last
};

struct GridCellsArgs {
  Grid grid;
  const Record* records;
  uint32_t* keys;  // storage index of each record's cell
  // 1: for an order that keeps neighbours together and in which no cell is looked up. Cells count from `first`, and
  // every other row and plane runs backward, so that the end of one lies beside the beginning of the next.
  int32_t serpentine;
  int32_t first[3];
};

struct ListArgs {
  Grid grid;                  // of the moving particles, which are sorted by it; cell edge >= reach
  Grid boundary_grid;         // of the boundary particles; the same cell edge
  const float* positions[3];  // x, y, z of the moving particles, in sorted order
  const float* boundary_positions[3];
  uint32_t boundary_count;  // 0: no boundary
  uint32_t boundary_first;  // record index of the first boundary particle
  uint32_t inert;           // record index of an inert record far away: pads every row
  float reach_squared;
  float near_squared;    // neighbours closer than this come first in a row
  uint32_t* lists;       // k_list_slots record indices for each particle
  uint8_t* counts;       // used slots of each particle
  uint8_t* near_counts;  // of them, those whose neighbour is near
  // 1: a list has only those moving particles that come after its own, so that every pair is in one list.
  int32_t halves;
};

// A regular grid of signed distances, x fastest, in the collider's own axes. Above 0 is free. Beyond the grid all is
// free (outward 1) or all is solid (outward -1).
struct FieldGrid {
  const float* values;
  uint32_t counts[3];  // >= 2; at most 2^24 values in all, so that indices are exact as floats
  float low[3];
  float spacing, inverse_spacing;
  float outward;
  float border;  // the value nearest to the surface on the faces of the grid
};

// Of a relief `values` are heights at nodes over x and z, and counts[1] is 1. After them comes the greatest, in the same
// memory: it may change between two units, as they do.
static inline float greatest_height(const FieldGrid& relief) {
  return relief.values[relief.counts[0] * relief.counts[2]];
}

// A collider at one instant, in world coordinates.
struct ColliderFrame {
  sandglass_shape shape;
  float position[3];
  float axes[3][3];  // local x, y, z in the world
  float size[3];
  float extent[3];  // half the sides of a box along the world's axes that holds it; not of a half space or a field
  // Metres, of a relief: how far above its surface the centre of what lies on it is. Raised by that, the surface is
  // continuous for centres. The distance from the plane below them is not, and would throw what crosses a step.
  float offset;
  float linear[3];  // velocity, m/s
  float angular[3];
  uint32_t slides;      // 0: the next two are none
  float slide[3];       // of the velocity what moves no face: a belt's
  float slide_turn[3];  // and of the angular one
  FieldGrid field;      // of SANDGLASS_SHAPE_FIELD and SANDGLASS_SHAPE_RELIEF
};

// From shape, axes and size; a thousandth longer, for what is rounded away.
static inline void find_extent(ColliderFrame* frame) {
  for (int k = 0; k < 3; ++k) {
    float half = frame->size[0];
    if (frame->shape == SANDGLASS_SHAPE_CAPSULE) half += __builtin_fabsf(frame->axes[1][k]) * frame->size[1];
    if (frame->shape == SANDGLASS_SHAPE_BOX || frame->shape == SANDGLASS_SHAPE_RELIEF) {
      half = 0.0f;
      for (int a = 0; a < 3; ++a) half += __builtin_fabsf(frame->axes[a][k]) * frame->size[a];
    }
    frame->extent[k] = 1.001f * half;
  }
}

// What a contact of two particles does, by either scheme.
struct ContactLaw {
  float diameter;
  float static_friction, kinetic_friction;
  float relaxation;                   // omega
  float weight_linear, weight_cubic;  // height weighting: share = 1/2 + linear*c + cubic*c^3, c = n . up
  // Metres. Jacobi: height weighting lifts a particle by no more in this pass. Pairs: it lifts no pair that rises faster
  // in this sub-step.
  float lift_max;
  float up[3];
  int32_t bodies;  // 1: masses may differ, and particles of one body ignore each other
  // Metres. A particle that moves further in this sub-step and touches a sleeper marks its own group.
  float wake_displacement;
  uint8_t* touched;  // one for each group: 1 where it is marked
};

// A pass over particles reads `in` and writes `out`. The range is of items: item i is lane i % 16 of record group
// groups[i / 16]. predict_motion and complete_motion are what comes before and after contact_pairs; they need no lists.
struct PredictArgs {
  const Particle* in;
  Particle* out;
  const uint32_t* groups;
  float scale;  // displacement = scale * u + gravity * w: the time step, and g dt^2
  float gravity[3];
};

// How a sub-step ends: colliders, limits, and the new state.
struct CompleteArgs {
  const Particle* in;
  Particle* out;
  const uint32_t* groups;
  uint32_t particle_count;  // lanes from here on are padding
  float radius;
  float static_friction, kinetic_friction;  // of colliders
  float step;                               // dt
  float displacement_max;                   // CFL limit of one sub-step, metres
  float leave_max;   // metres a sub-step: how much faster than a collider what is deep in it leaves it
  int32_t departed;  // 1: some particles have departed
  uint32_t collider_count;
  const ColliderFrame* colliders;
};

// contact_stabilise and contact_solve are Jacobi passes: contacts and friction from the positions before the pass, then
// colliders.
struct AveragedArgs {
  ContactLaw law;
  CompleteArgs end;
  const uint32_t* lists;
  const uint8_t* counts;
  float scale;  // as of PredictArgs in the first pass; (1, 0) later
  float gravity[3];
  int32_t last;  // 1: write x + displacement and velocity; 0: x and displacement
};

// What a range of the last pass saw, of what has not departed. Extrema are exact, so they combine in any order.
struct ContactExtent {
  float speed_squared;
  float low[3], high[3];                            // positions
  float displacement_low[3], displacement_high[3];  // of this sub-step
  uint32_t quarantined;                             // lanes not finite or out of bounds, which were put to rest
  uint32_t touched;                                 // 1: some group was marked
};

// One Gauss-Seidel pass over contacts in pairs. The range is of pairs, in which no particle that may be written comes
// twice; pairs with the inert record fill it up to a multiple of 16. Pair p is lane p % 16 of group groups[p / 16].
// predict_motion has written the particles, complete_motion goes over them afterwards.
struct PairArgs {
  ContactLaw law;
  Particle* particles;  // at the start of the sub-step, with their displacement since then
  const uint32_t *first, *second, *groups;
  int32_t fixed;  // 1: the second particle of each pair is one of the boundary, and is never written
  // 1 / omega, and in metres what a pair may be driven apart by in a sub-step.
  float inverse_relaxation, separation_max;
  float stick;  // the share of the slip that friction takes in a sub-step as long as it sticks
};

// Wakes the sleepers near colliders: those whose distance to a collider is below its margin and their own radius
// together.
struct WakeArgs {
  Sleeper* sleepers;
  uint32_t sleeper_count;
  const ColliderFrame* colliders;
  const float* margins;  // metres, one a collider
  uint32_t collider_count;
};

// Distance and normal of a collider at points.
struct SurfaceArgs {
  SurfacePoint* points;
  const ColliderFrame* collider;
};

// Which points of records lie inside a shape.
struct InsideArgs {
  const Record* records;
  uint32_t record_count;
  const ColliderFrame* shapes;
  uint32_t shape_count;
  uint8_t* inside;  // 1 or 0 for each record of the range
};

// The particles' motion on the nodes of a grid that exists where there are particles, in blocks. A node holds what the
// particles within the support radius give it. As a record: the sum of their weights W, the sum of W u, the position of
// the nearest one, and that one's place in the snapshot, as a float: it is below 2^24.
constexpr uint32_t k_node_weight = 0, k_node_momentum = 1, k_node_nearest = 4, k_node_number = 7;
constexpr uint32_t k_node_largest = 8;  // W of the nearest one, while particles are added; not in the record
constexpr uint32_t k_block_planes = 9;
constexpr uint32_t k_block_side = 4;       // nodes of its own that a block has along an axis
constexpr uint32_t k_block_nodes = 64;     // of its own
constexpr uint32_t k_block_records = 128;  // and those of the next blocks that its cells reach: 5^3, padded
constexpr uint32_t k_block_floats = 688;   // planes of nodes, and later 14^3 bytes of density
constexpr uint32_t k_block_cells = 12;     // of the grains' density, along an axis
constexpr uint32_t k_block_counts = k_block_cells * k_block_cells * k_block_cells;
constexpr uint32_t k_density_cells = 14;  // those and one more on either side
constexpr uint32_t k_grain_count = 16;    // what a grain adds to its cell
constexpr uint32_t k_no_block = ~0u;
constexpr uint32_t k_block_holds = 4;       // grains
constexpr uint32_t k_block_incomplete = 2;  // there was no room for a block that its cells reach

constexpr uint32_t k_blocks_around = 27;  // a block and those that share a face, an edge or a corner with it
constexpr uint32_t k_itself = 13;

struct MotionBlock {
  int32_t at[3];  // its first node is at 4 * at
  uint32_t state;
  // Their numbers, x fastest, or k_no_block; complete once all blocks are joined.
  uint32_t around[k_blocks_around];
  uint32_t unused;
};

struct MotionGrid {
  float origin[3];                 // metres; the node (0, 0, 0) of block (0, 0, 0)
  float spacing, inverse_spacing;  // metres from node to node
  float support;                   // h = 3r, of the nearest particle's weight
  float reach;                     // of the sums: shorter than h, because reading between nodes widens them
  float gain;                      // (h / reach)^3: makes the sums as large as those of h
  uint32_t slot_mask;
  uint32_t* slots;  // an open hash table: the number of a block, plus 1; 0: empty
  MotionBlock* blocks;
  uint32_t block_count, block_capacity;
  uint32_t overflowed;  // 1: there was no room for a block
  float* planes;        // a block's own nodes while particles are added: 8 planes of 64
  float* nodes;         // its records, x fastest, 5 along an axis; positions are relative to the origin
  uint8_t* counts;      // k_grain_count for each grain in a cell of a block, x fastest
};

// The density of the grains in a block's cells and those around, in the place of its planes.
static inline uint8_t* density_of(const MotionGrid& grid, uint32_t block) {
  return reinterpret_cast<uint8_t*>(grid.planes + static_cast<uint64_t>(block) * k_block_floats);
}

static inline uint32_t motion_hash(int32_t x, int32_t y, int32_t z) {
  const uint32_t mixed = static_cast<uint32_t>(x) * 0x9e3779b1u ^ static_cast<uint32_t>(y) * 0x85ebca77u ^
                         static_cast<uint32_t>(z) * 0xc2b2ae3du;
  return mixed ^ (mixed >> 15);
}

// A set of places with whole coordinates, as bits of their hashes. It may hold a place that was never put in.
constexpr uint32_t k_place_bits = 1u << 14;
struct PlaceSet {
  uint64_t bits[k_place_bits / 64];
};
static inline void place_put(PlaceSet* set, int32_t x, int32_t y, int32_t z) {
  const uint32_t bit = motion_hash(x, y, z) & (k_place_bits - 1);
  set->bits[bit >> 6] |= uint64_t{1} << (bit & 63);
}
static inline bool place_in(const PlaceSet& set, int32_t x, int32_t y, int32_t z) {
  const uint32_t bit = motion_hash(x, y, z) & (k_place_bits - 1);
  return (set.bits[bit >> 6] >> (bit & 63) & 1) != 0;
}

// The number of the block at these coordinates, or k_no_block.
static inline uint32_t motion_find(const MotionGrid& grid, int32_t x, int32_t y, int32_t z) {
  for (uint32_t slot = motion_hash(x, y, z) & grid.slot_mask; grid.slots[slot] != 0;
       slot = (slot + 1) & grid.slot_mask) {
    const MotionBlock& block = grid.blocks[grid.slots[slot] - 1];
    if (block.at[0] == x && block.at[1] == y && block.at[2] == z) return grid.slots[slot] - 1;
  }
  return k_no_block;
}

// The range is of particles. What they add is their motion during `time`, at its begin.
struct ScatterMotionArgs {
  MotionGrid* grid;
  const Particle* particles;  // the velocity is the mean one of `time`; with a share of free fall
  uint32_t particle_count;
  float time;  // seconds
  // Blocks that are made, and those of them whose nodes are read; both null: all.
  const PlaceSet *wanted, *read;
};

// The range is of grains.
struct CountGrainsArgs {
  const MotionGrid* grid;
  const Grain* grains;
  uint32_t grain_count;
};

struct RefineArgs {
  Grid grid;                  // of the particles' snapshot; cell edge = support radius
  const Particle* snapshot;   // in sorted order
  const float* positions[3];  // the same positions, one array an axis
  const MotionGrid* motion;   // null: every step looks the particles up
  Grain* grains;
  uint32_t grain_count;
  const uint32_t* groups;  // the range is of items: item i is lane i % 16 of grain group groups[i / 16]
  uint8_t* still;          // one for each group: 1 once every grain of it has kept still for still_sweeps
  uint32_t* stamps;        // one for each group: set to `stamp` where a position or a velocity in it has changed
  uint32_t stamp;
  float speed_scale;     // metres a second: sqrt(g d)
  float still_distance;  // metres that a still grain may move in a sweep, per axis
  float still_sweeps;
  float support;     // h = 3r
  float step;        // seconds
  float push;        // metres; the density's gradient moves a grain by push / density at a slope of 1 a cell
  float push_max;    // metres
  float push_reach;  // metres from the nearest particle, about which the push ends outside the pile
  uint32_t steps;    // equal steps on the same snapshot; with a motion grid, on the same sums
  float gravity[3];
  float fall;              // metres a second that gravity adds in all steps
  int32_t source_rule;     // 1: (4.44) as printed
  int32_t own_particles;   // 0: with a motion grid, grains follow means alone
  float weight_at_radius;  // W(r)
  const ColliderFrame* colliders;
  const ColliderFrame* step_colliders;  // the colliders after each step but the last; null: they are where they end
  uint32_t collider_count;
  float grain_radius;
  float friction;
};

struct RefineExtent {
  uint32_t quarantined;
  uint32_t changed;  // groups
};

// One azimuth of a soft light.
struct PileAzimuth {
  float low, high;                 // its elevations, as sin^2
  float weight;                    // its share of the horizon
  float foot, cap;                 // the slopes of its lower edge, and of what is as good as its upper edge
  uint32_t first_step, last_step;  // that are walked along it; last_step is one past the end
  // What the receiver's own column leaves to a receiver on the floor, where its sand is thin:
  // 1 + near (own[0] + own[1] y^(1/4) + own[2] y^(1/2) + own[3] y + own[4] y^2), with y = 1 - fill and
  // near = near_from - bottom * near_per_metre, within 0..1. It stands for the first step, which is then left out.
  float own[5];
  float near_from, near_per_metre;
  uint32_t thin;  // 0: the own column is a step as all others are
};
struct PileStep {
  int32_t columns, rows;   // from the receiver
  float inverse_distance;  // 1 / metres
};

// The range is of texels of one row. Every texel has a column of sand: its top and bottom as heights over the floor,
// and its fill, the share of the texel that sand covers. An empty column has its top far below and its bottom far above
// everything. k_lane_group empty columns stand before and after every row.
struct PileLightArgs {
  const float *tops, *bottoms, *fills;  // row 0, column 0
  uint32_t pitch;                       // floats from row to row
  int32_t row;
  int32_t sand_rows[2], sand_columns[2];  // first and last with sand
  const float* receivers;                 // heights of this row's surface over the floor
  const PileAzimuth* azimuths;
  uint32_t azimuth_count;
  const PileStep* steps;  // of each azimuth, the nearest first
  uint32_t on_floor;      // 1: the receivers are on the floor, 0: on the sand
  float inverse_total;    // 1 / sum of weight * (high - low)
  float* shares;          // of the light that reaches each texel, 0..1
};

// A sector of azimuth. The light below an elevation is the sum over rings of bends * max(4 sin^2 - ring, 0).
struct PileSector {
  float bends[4];
  uint32_t first_step, last_step;  // that are walked along it; last_step is one past the end
  uint32_t in_air;                 // 0: all columns that these steps meet stand on the floor, with a bottom of 0
};
struct PileSkyStep {
  int32_t at;           // of the column that the row's texel 0 meets
  int32_t first, last;  // texels of the row that may meet sand
  float inverse_distance;
};

// The range is of texels of one row. Columns are as in PileLightArgs; those that a texel of the range meets where it
// meets no sand are empty, or stand for no sand at all.
struct PileSkyArgs {
  const float *tops, *bottoms, *fills;
  const PileSkyStep* steps;
  const PileSector* sectors;
  uint32_t sector_count;
  float cap;               // the slope up to which thin sand is told from full sand
  const float* receivers;  // heights of this row's surface over the floor
  float* lights;           // 1 less the light that is hidden from each texel
};

// Triangles above a plane, in its frame: y is the height over it. A point throws its shadow where the line from the light
// through it meets the plane; in texels, whose middles are whole numbers, at
//   u = x scale[0] - y shear[0] + offset[0], v = z scale[1] - y shear[1] + offset[1].
// The range is of triangles. Where `closed` is 1, what turns as the image does (area 0 and NaN among them) draws
// nothing.
struct CastTrianglesArgs {
  const float* corners[9];  // x y z of the first corners, of the second, of the third
  float scale[2], shear[2], offset[2];
  uint32_t texels, words;  // along a side of the image; 64-bit words in a row of it
  uint32_t closed;         // 1: only triangles that face the light
  uint64_t* image;         // a bit is set where a triangle hides the light
};
struct CastExtent {
  uint32_t rows;                 // of all triangles together
  uint32_t texels;               // the same; one that two triangles cover counts twice
  uint32_t first_row, last_row;  // that were written; set them to ~0 and 0 before
};

// The range is of texels of one row; `radius` values stand before and after it.
struct CastWindowArgs {
  const float* row;
  uint32_t radius;
  float *low, *high, *sum;
};

// The range is of texels of one row, which is changed in place. `rows` windows of as many values lie about it.
constexpr uint32_t k_cast_rows = 9;
struct CastCalmArgs {
  const float *low[k_cast_rows], *high[k_cast_rows], *sum[k_cast_rows];
  uint32_t rows;
  float difference_max;
  float* row;
};

#define SANDGLASS_KERNEL(user, name, Args, Result) \
  using name##_function = void (*)(const Args* args, uint32_t begin, uint32_t end, Result* result);
#include "kernels/kernels.inc"
#undef SANDGLASS_KERNEL

// One table an instruction set.
struct Kernels {
  sandglass_isa isa;
  uint32_t width;  // lanes
#define SANDGLASS_KERNEL(user, name, Args, Result) name##_function name;
#include "kernels/kernels.inc"
#undef SANDGLASS_KERNEL
};

// Who uses a kernel: the sand itself, its shadow and light, or the shadows of triangles.
enum class KernelUser { sand, pile, cast };

// The table for `isa` (AUTOMATIC: the fastest that this CPU runs), or null where build or CPU lack it. The tables of
// one user have null for the others' kernels and do not link them into the program.
const Kernels* select_kernels(sandglass_isa isa);
const Kernels* select_sand_kernels(sandglass_isa isa);
const Kernels* select_pile_kernels(sandglass_isa isa);
const Kernels* select_cast_kernels(sandglass_isa isa);

}  // namespace sandglass
