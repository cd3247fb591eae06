// The state behind sandglass/skin.h. The surface is found on a lattice of nodes 1.5 particle radii apart, which stands
// still in the world and exists in bricks of 8^3 nodes where there is sand (bricks.h). Its y axis is the axis of the
// world that is nearest to "up". A skin is made in phases, cut into units of the skin's stage:
//   take          where sand and colliders are, at one moment, for all that follows (gather.cpp, solid.cpp)
//   gather_moved  what moved is taken out of the sums and put in again (gather.cpp)
//   gather_gone   what is there no more is taken out (gather.cpp)
//   density       sums to density, beside colliders (density.cpp)
//   fill          from above to below, what dry sand fills (fill.cpp)
//   calm          once more through a filter (density.cpp)
//   mesh          vertices brick by brick, triangles chunk by chunk (mesh.cpp), into the other of two meshes
//   loose         what is not in the mesh (loose.cpp); the last unit swaps the two, and numbers chunks (versions.cpp)
// Where that takes more than a frame, the mesh before follows its particles meanwhile, at each frame's end (carry.cpp).
// Each works on what the one before has changed. All up to the mesh is in whole numbers, so that sums can be taken back
// exactly and every instruction set gives the same bits.
//
// The state is put together from parts. Each is a section here, which names the source file that changes it: functions
// take that part as a pointer, and the rest as `const SkinState&`. stage.cpp and versions.cpp put the whole
// together (tests/docs/parts.py).
#pragma once

#include <cstdint>

#include "kernels/kernels.h"
#include "runtime/frame/capability.h"
#include "runtime/frame/layout.h"
#include "runtime/math/rigid_motion.h"
#include "runtime/skin/bricks.h"
#include "sandglass/skin.h"

namespace sandglass {

struct Granular;
struct SkinState;

constexpr uint32_t k_skin_step_shift = 7;
constexpr int32_t k_skin_steps = 1 << k_skin_step_shift;  // parts of a node's distance, in which places are held
constexpr uint32_t k_skin_shares = 16;                    // parts of a particle
constexpr uint32_t k_skin_one_shift = 12;
constexpr uint32_t k_skin_one = 1u << k_skin_one_shift;  // a density of 1
constexpr float k_skin_spacing = 1.5f;                   // particle radii from node to node
constexpr int32_t k_skin_held = 2;                       // lattice steps that a particle may move before it counts
constexpr uint32_t k_skin_level = 2089;                  // of the surface: 0.51
constexpr uint32_t k_skin_unit_items = 1024;
constexpr uint32_t k_skin_unit_bricks = 12;                                 // density, calm
constexpr uint32_t k_skin_unit_layers = k_brick_side * k_skin_unit_bricks;  // of bricks, fill
constexpr uint32_t k_skin_unit_mesh = 2;                                    // bricks
constexpr float k_skin_nowhere = 3e38f;  // metres: of a particle that was not gathered
constexpr sandglass_shape k_no_shape = -1;

// Kinds of work unit. Taking sand is of the first kind, too.
enum : uint32_t { k_skin_gather, k_skin_density, k_skin_fill, k_skin_calm, k_skin_mesh, k_skin_loose, k_skin_carry };
static_assert(k_skin_carry + 1 == k_skin_kinds);
enum class SkinPhase : uint32_t { idle, take, gather_moved, gather_gone, density, fill, calm, mesh, loose };

using QuadWhole = int32_t __attribute__((vector_size(16)));

// ---- SkinLattice (lattice.cpp)

struct SkinLattice {
  // Metres from node to node.
  float spacing, inverse_spacing;
  // Lattice axis a is the world's axis[a], times sign[a].
  uint32_t axis[3];
  float sign[3];
  // The direction "up" along the lattice's axes.
  float up[3];
  // There is gravity.
  bool falls;
  // How far the next layer of nodes up lies aside along x and z, in k_skin_one of a node.
  int32_t lean[2];
};

enum class SkinTurn : uint32_t { none, leans, other_axes };
// Up as gravity has it; the world's y where there is none.
SkinTurn lattice_follow(SkinLattice* lattice, const Granular& g);

// A place in the world, in lattice steps.
inline void lattice_place(const SkinLattice& l, const float position[3], int32_t at[3]) {
  for (uint32_t a = 0; a < 3; ++a)
    at[a] =
        floor_whole((l.sign[a] * position[l.axis[a]] * l.inverse_spacing - 0.5f) * static_cast<float>(k_skin_steps));
}

// ---- SkinSolids (solid.cpp)

constexpr uint32_t k_edges_side = k_brick_side + 1, k_edges_nodes = k_edges_side * k_edges_side * k_edges_side;

struct SkinSolids {
  // Colliders as they were when sand was taken, and versions of their fields, by slot of `Colliders`; k_no_shape: none.
  ColliderFrame* colliders;
  uint64_t* fields;
  // Slots of those that move.
  uint32_t* movers;
  uint32_t mover_count;
  // Of the brick under way: its nodes and the next ones after it along each axis.
  SurfacePoint* points;
  // BrickNodes::solid and walls of that brick, as they were.
  uint8_t *solid_before, *walls_before;
};

// ---- SkinSand (gather.cpp)

// A particle as it was last summed, by number.
struct SkinParticle {
  int32_t at[3];        // in k_skin_steps of a node
  uint32_t next, last;  // numbers of the next and the last particle of the same cell
  uint8_t share;        // k_skin_shares are a whole particle; 0: it is not summed
  // The cycles in which it was last there, and last summed anew, modulo 256.
  uint8_t seen, moved;
};

// A particle as a skin finds it.
struct SkinTaken {
  float position[3];
  uint32_t number;
  float velocity[3];
  uint8_t share;
  bool flies;
};

struct SkinSand {
  // The moment at which sand was taken last: a frame, and so many of its sub-steps.
  uint64_t frame;
  uint32_t substeps;
  // How often it was taken anew for this skin.
  uint32_t restarts;
  // Particles moved on while sand was taken.
  bool missing;
  SkinTaken* taken;
  uint32_t taken_count;
  // The next item of each phase: a particle of the scene to take, one of `taken` to gather, a number to look for in
  // gather_gone.
  uint32_t next_record, next_taken, next_number;
  // By number; and how many numbers there have been.
  SkinParticle* particles;
  uint32_t numbers;
  // By number, three coordinates each: where the particle was gathered. k_skin_nowhere: it was not.
  float* from;
  // Particles for which there was no room.
  uint32_t left_out;
  // Counts skins, modulo 256.
  uint8_t cycle;
};

// ---- SkinFilter (density.cpp)

struct SkinFilter {
  // The next brick of which the phase asks whether it is stale.
  uint32_t next;
  // k_skin_one over the free share, by BrickNodes::solid.
  uint16_t by_free[256];
};

// ---- SkinFill (fill.cpp)

// Bricks of one height are a level. Levels are filled from the highest one down, each layer by layer.
struct SkinFill {
  int32_t level, level_low;
  // The next layer. k_brick_side: the level's bricks are still to be found.
  uint32_t layer;
  // Bricks of the level, and the next one of them.
  uint32_t* work;
  uint32_t work_count, next;
};

// ---- SkinMeshes (mesh.cpp; loose sand: loose.cpp)

constexpr uint32_t k_outer_bricks = 61;    // of 5^3 less 4^3: those below a chunk along some axis
constexpr uint32_t k_chunk_changed = ~0u;  // a version to come

struct SkinMesh {
  sandglass_skin_vertex* vertices;
  // The particle of each vertex.
  uint32_t* anchors;
  uint16_t* indices;
  sandglass_skin_loose* loose;
  sandglass_skin_chunk* chunks;
  // The first vertex and index of each chunk.
  uint32_t *first_vertex, *first_index;
  uint32_t vertex_count, index_count, flying, lying;
};

// What one brick's vertices are made of.
constexpr uint32_t k_mesh_apron = 2, k_mesh_pitch = k_brick_side + 2 * k_mesh_apron;
constexpr uint32_t k_mesh_solid_pitch = k_brick_side + 2;
struct SkinBlocks {
  uint16_t calm[k_mesh_pitch * k_mesh_pitch * k_mesh_pitch];
  uint8_t solid[k_mesh_solid_pitch * k_mesh_solid_pitch * k_mesh_solid_pitch];
  uint8_t walls[k_mesh_solid_pitch * k_mesh_solid_pitch * k_mesh_solid_pitch];
  bool walled;                                // some walls are not 0
  uint16_t rows[k_edges_side][k_edges_side];  // of y and z: the nodes 0..8 along x that are inside
  uint16_t before[k_brick_nodes];             // BrickNodes::vertices as they were
};

struct SkinMeshes {
  // The mesh that was made last, and the one under way.
  SkinMesh front, back;
  uint32_t vertex_capacity, index_capacity;
  // The next chunk in their order, and the next step in it: vertices of each of its bricks, then triangles of each.
  uint32_t chunk, step;
  // The next of SkinSand::taken that may be loose.
  uint32_t next_loose;
  SkinBlocks* blocks;
  // Of each cell in a chunk's outer bricks: the index of its vertex in this chunk.
  uint16_t* outer;
};

// ---- SkinCarry (carry.cpp)

// How a particle has moved since the mesh was gathered. By number.
struct SkinCarried {
  Quad offset;      // its displacement, less that of the motion
  uint32_t loose;   // its index in the mesh's list of loose sand; k_none: it is not in there
  uint32_t motion;  // in SkinCarry::motions; k_none: it goes with none
};

// How colliders have moved since the mesh was gathered.
struct SkinMotion : RigidMotion {
  bool encloses;  // a field that is solid outside: its sand goes with no other
};
constexpr uint32_t k_skin_motions = 16;

struct SkinCarry {
  // Of the mesh that was made last: where its sand was gathered, as in SkinSand::from, and where colliders were then.
  float* from;
  ColliderFrame* met;
  float inverse_side;  // 1 / metres, of the block of grains
  // The moment to which it is carried: a frame, and so many of its sub-steps.
  uint64_t frame;
  uint32_t substeps;
  SkinMotion motions[k_skin_motions];
  uint32_t motion_count;
  SkinCarried* carried;
  // The next particle and chunk.
  uint32_t record, chunk;
  // Loose sand that is written.
  uint32_t flying, lying;
  // Particles that have left the mesh, less those that are still in it.
  int32_t left_surplus;
  // The motion of the last vertex.
  uint32_t motion;
  // Some chunk has changed.
  bool changed;
};

// ---- SkinShown (versions.cpp; as it is carried: carry.cpp)

// What an app is given: the mesh as it was made, or carried on from there.
struct SkinShown {
  // As in SkinMesh, of the chunks that are carried.
  sandglass_skin_vertex* vertices;
  sandglass_skin_chunk* chunks;
  sandglass_skin_loose* loose;
  uint32_t flying, lying;
  uint32_t version;
  // Particles for which there was no room.
  uint32_t left_out;
  // Most of the mesh's sand has left it: from the next frame on it is not shown.
  bool lost;
  // The moment that it shows: a frame, and so many of its sub-steps.
  uint64_t frame;
  uint32_t substeps;
  // The frame in which the mesh was begun.
  uint64_t begun;
};

// ---- SkinRequests (stage.cpp)

// What asks for a skin.
struct SkinRequests {
  bool asked, whole_asked;
  // A unit has run in this frame.
  bool ran;
  // As the last frame had it: whether sand moved, and how many particles there were.
  bool moving;
  uint32_t particles;
};

// ---- SkinProgress (stage.cpp)

constexpr uint32_t k_skin_in_time = 8;  // skins that are made within their frame, before the next is expected to be

// How far the skin under way has come.
struct SkinProgress {
  SkinPhase phase;
  // The frame in which it was begun.
  uint64_t begun;
  // Items of each kind that it has taken, and that the last skin took.
  uint32_t spent[k_skin_kinds], usual[k_skin_kinds];
  // Skins in a row that took no more than a frame.
  uint32_t in_time;
};

// ---- the whole

struct SkinState {
  sandglass_skin_desc desc;
  const Kernels* kernels;
  // The sand and the number of the frame under way.
  const Granular* granular;
  uint64_t frame;
  SkinLattice lattice;
  SkinSolids solids;
  SkinSand sand;
  SkinBricks bricks;
  SkinFilter filter;
  SkinFill fill;
  SkinMeshes meshes;
  SkinCarry carry;
  SkinShown shown;
  SkinRequests requests;
  SkinProgress progress;
  // There is a mesh.
  bool valid;
  // SkinShown::version of the mesh as it was made, for what draws that.
  uint32_t front_version;
};

// ---- phases: each runs one unit, and returns true once its phase is done

// Whether sand is taken from the start: then colliders are, too.
bool sand_begins(SkinSand* sand, const SkinState& s);
uint32_t skin_take_items(const SkinState& s);
bool skin_take(SkinSand* sand, const SkinState& s);
bool skin_gather_moved(SkinSand* sand, SkinBricks* bricks, const SkinState& s);
bool skin_gather_gone(SkinSand* sand, SkinBricks* bricks);
// A skin begins.
void sand_begin_cycle(SkinSand* sand, uint32_t capacity);
// From now on no particle is in the sums.
void sand_forget(SkinSand* sand, uint32_t capacity);
// Compares a particle's velocity with that of what is below it: a collider that moves, or the world. *falls: m/s
// towards it.
void skin_find_fall(const SkinState& s, const float position[3], const float velocity[3], float* falls, bool* flies);

// Colliders as they are `before` seconds before the frame's end. `asked` becomes true where sand feels what has
// changed.
void solids_take(SkinSolids* solids, SkinBricks* bricks, const SkinState& s, float before, bool* asked);
// The app may free a field that it does not pass any more: a skin under way goes on without it.
void solids_drop_gone_fields(SkinSolids* solids, SkinBricks* bricks, const SkinState& s, bool* asked);
// Finds what is solid in a brick, and what that changes.
void solids_renew(SkinSolids* solids, SkinBricks* bricks, const SkinState& s, uint32_t number);
// How free the surroundings of a node are, in 1/256, by BrickNodes::solid: the ramp of a wall through the sums' spread
// and the filter, whose slope is 0.49 a node.
inline uint16_t skin_free(uint8_t solid) {
  constexpr uint16_t k_scaled_min = 208;  // 128 * 21 / 8 - 128
  const uint16_t scaled = static_cast<uint16_t>(static_cast<uint16_t>(solid * 21) >> 3);
  const uint16_t above = static_cast<uint16_t>((scaled > k_scaled_min ? scaled : k_scaled_min) - k_scaled_min);
  return above < 256 ? above : uint16_t{256};
}
// A node's part in the calm density: as free as it is; a little even in a collider, so that the surface goes on in
// there.
inline uint16_t skin_part(uint8_t solid) {
  const uint16_t free = skin_free(solid), deep = solid >> 3;
  return free > deep ? free : deep;
}
// What takes part in the filter, of a row of nodes.
inline void take_part(BrickNodes* nodes, uint32_t row) {
  for (uint32_t i = row; i < row + k_brick_side; ++i)
    nodes->part[i] = static_cast<uint16_t>(uint32_t{nodes->filled[i]} * skin_part(nodes->solid[i]) >> 8);
}

bool skin_density(SkinFilter* filter, SkinSolids* solids, SkinBricks* bricks, const SkinState& s);
bool skin_calm(SkinFilter* filter, SkinBricks* bricks, bool closed);

void skin_begin_fill(SkinFill* fill, const SkinBricks& bricks);
bool skin_fill(SkinFill* fill, SkinBricks* bricks, const SkinLattice& lattice);

void skin_begin_mesh(SkinMeshes* meshes, const SkinState& s);
bool skin_mesh(SkinMeshes* meshes, SkinBricks* bricks, const SkinState& s);
// Reads what a brick's vertices are made of (vertex.cpp).
void vertex_read_blocks(const SkinState& s, const Brick& brick, SkinBlocks* blocks);
// Makes the vertex of a cell. `anchor`: the particle of the vertex before, then of this one. False: it lies deep in a
// collider, where nobody sees it.
bool vertex_make(const SkinState& s, const Brick& brick, const SkinBlocks& blocks, const uint32_t cell[3],
                 sandglass_skin_vertex* out, uint32_t* anchor);

void skin_begin_loose(SkinMeshes* meshes);
bool skin_loose(SkinMeshes* meshes, SkinBricks* bricks, const SkinState& s);

// The mesh that is complete becomes the shown one (versions.cpp).
void skin_publish(SkinState* s);

// ---- between two skins (carry.cpp)

// Whether a skin may take more than a frame.
inline bool skin_is_late(const SkinState& s) { return s.progress.in_time < k_skin_in_time; }
inline bool skin_has_work(const SkinState& s) { return s.progress.phase != SkinPhase::idle || s.requests.asked; }
// The mesh that is carried from here on is of the colliders that were taken.
void carry_from_here(SkinCarry* carry, const SkinState& s);
// At the end of a frame, whatever the budget: carries what is shown to where sand is, if sand has moved since or there
// is no mesh yet.
Stage skin_carry_stage(void* skin);

// Triangles and loose sand of the mesh as it is.
inline uint32_t skin_items(const SkinState& s) {
  return s.meshes.front.index_count / 3 + s.meshes.front.flying + s.meshes.front.lying;
}

extern const Capability k_skin_capability;

}  // namespace sandglass

struct sandglass_skin {
  sandglass::Member member;
  sandglass::SkinState skin;
};
