// The state behind sandglass/skin.h. The surface is found on a lattice of nodes 1.5 particle radii apart, which stands still
// in the world and exists in bricks of 8^3 nodes where there is sand. Its y axis is the axis of the world that is nearest to
// "up". A skin is made in phases, cut into units of the skin's stage:
//   take      where sand and colliders are, at one moment, for all that follows (gather.cpp)
//   gather    what moved is taken out of the sums and put in again (gather.cpp)
//   density   sums to density, beside colliders (density.cpp)
//   fill      from above to below, what dry sand fills (density.cpp)
//   calm      once more through a filter (density.cpp)
//   mesh      vertices brick by brick, triangles chunk by chunk (mesh.cpp), into the other of two meshes
//   loose     what is not in the mesh (loose.cpp); the last unit swaps the two
// Where that takes more than a frame, the mesh before follows its particles meanwhile, at each frame's end (carry.cpp).
// Each works on what the one before has changed. All up to the mesh is in whole numbers, so that sums can be taken back
// exactly and every instruction set gives the same bits.
#pragma once

#include <cstdint>
#include <cstring>

#include "kernels/kernels.h"
#include "runtime/frame/capability.h"
#include "runtime/frame/layout.h"
#include "runtime/math/rigid_way.h"
#include "sandglass/skin.h"

namespace sandglass {

struct Granular;

constexpr uint32_t k_brick_side = 8, k_brick_nodes = 512, k_brick_layer = 64;
constexpr uint32_t k_edges_side = k_brick_side + 1, k_edges_nodes = k_edges_side * k_edges_side * k_edges_side;
constexpr uint32_t k_brick_none = ~0u, k_brick_itself = 13, k_bricks_around = 27;
constexpr uint32_t k_chunk_bricks = 4;   // along an axis
constexpr uint32_t k_outer_bricks = 61;  // of 5^3 less 4^3: those below a chunk along some axis
constexpr uint16_t k_vertex_none = 0xffff;
constexpr uint32_t k_chunk_changed = ~0u;                      // a version to come
constexpr int32_t k_skin_steps = 128;                          // parts of a node's distance, in which places are held
constexpr int32_t k_skin_held = 2;                             // of these a particle may move before it counts
constexpr uint32_t k_skin_shares = 16;                         // parts of a particle
constexpr uint32_t k_skin_one = 4096;                          // a density of 1
constexpr uint32_t k_skin_whole = k_skin_one * k_skin_shares;  // the sum of a whole particle
constexpr float k_skin_spacing = 1.5f;                         // particle radii from node to node
constexpr float k_skin_volume = 6.986f;  // particle radii cubed that a particle takes in a pile (packed to 0.6)
constexpr uint32_t k_skin_level = 2089;  // of the surface: 0.51
constexpr uint32_t k_skin_unit_items = 1024;
constexpr uint32_t k_skin_unit_bricks = 12;     // density, fill, calm
constexpr uint32_t k_skin_unit_mesh = 2;        // bricks
constexpr uint32_t k_skin_unit_taken = 16'000;  // particles of which places are taken
constexpr float k_skin_nowhere = 3e38f;         // metres: of a particle that was not gathered
constexpr sandglass_shape k_no_shape = -1;
constexpr uint32_t k_skin_in_time = 8;  // skins that are made within their frame, before the next is expected to be

// Kinds of work unit.
enum : uint32_t { k_skin_gather, k_skin_density, k_skin_fill, k_skin_calm, k_skin_mesh, k_skin_loose, k_skin_carry };
static_assert(k_skin_carry + 1 == k_skin_kinds);
enum class SkinPhase : uint32_t { idle, take, gather, leave, density, fill, calm, mesh, loose };

// What has to be made anew of a brick, as bits.
enum : uint32_t { k_stale_solid = 1, k_stale_density = 2, k_stale_fill = 4, k_stale_calm = 8, k_stale_mesh = 16 };

using QuadWhole = int32_t __attribute__((vector_size(16)));

// A particle as it was last summed, by number.
struct SkinParticle {
  int32_t at[3];        // in k_skin_steps of a node
  uint32_t next, last;  // of the same cell
  uint8_t share;        // of it that is summed, 1..k_skin_shares; 0: none
  uint8_t seen, moved;  // the cycles in which it was last there, and last summed anew, modulo 256
};

// A particle as a skin finds it.
struct SkinTaken {
  float position[3];
  uint32_t number;
  float velocity[3];
  uint8_t share;
  bool flies;
};

struct Brick {
  int32_t at[3];  // its first node is at 8 * at
  bool used;
  uint32_t around[k_bricks_around];  // x fastest, then z, then y; k_brick_none where there is none
  uint32_t chunk;
  uint32_t stale;
  uint32_t touches;          // particles that are in its sums
  uint32_t wants;            // bits of `around` that its density reaches
  uint32_t first, count;     // its vertices, from the chunk's first
  bool open;                 // no collider is near
  bool walled;               // some of BrickNodes::walls is not 0
  bool room_known;           // BrickNodes::room is that of the colliders
  bool dense, filled, calm;  // some of that is above 0
};

// What one brick holds, node after node: x fastest, then z, then y. A layer is 64 nodes.
struct BrickNodes {
  uint32_t sums[k_brick_nodes];
  uint16_t density[k_brick_nodes], filled[k_brick_nodes], calm[k_brick_nodes];
  uint16_t part[k_brick_nodes];        // of what is filled: what takes part in the filter
  uint16_t room[k_brick_nodes];        // the free shares through the filter, in k_skin_one
  uint8_t solid[k_brick_nodes];        // 128 + 48 times the distance to the nearest collider, in nodes
  uint8_t walls[k_brick_nodes];        // bits: a solid lies between this node and the next one along x, y, z
  uint16_t stands[k_brick_layer];      // of each column: bits of the nodes that hold sand or are solid
  uint16_t can[k_brick_layer];         // of each column: bits of the nodes that sand may fill
  uint8_t inside[k_brick_layer];       // of each row: bits of the nodes whose calm density is above the level
  uint8_t beside_sand[k_brick_layer];  // of each row: bits of the nodes with sand within a node
  uint8_t changed[k_brick_layer];  // of each row: bits of the nodes that have changed since the mesh was made of them
  uint32_t particles[k_brick_nodes];  // the first of each cell, or k_brick_none
  uint16_t vertices[k_brick_nodes];   // of each cell, from the brick's first, or k_vertex_none
};

// What one brick's density and vertices are made of.
constexpr uint32_t k_mesh_apron = 2, k_mesh_pitch = k_brick_side + 2 * k_mesh_apron;
constexpr uint32_t k_mesh_solid_pitch = k_brick_side + 2;
struct SkinBlocks {
  uint16_t calm[k_mesh_pitch * k_mesh_pitch * k_mesh_pitch];
  uint8_t solid[k_mesh_solid_pitch * k_mesh_solid_pitch * k_mesh_solid_pitch];
  uint8_t walls[k_mesh_solid_pitch * k_mesh_solid_pitch * k_mesh_solid_pitch];
  bool walled;                     // some walls are not 0
  uint16_t rows[9][9];             // of y and z: the nodes 0..8 along x that are inside
  uint16_t before[k_brick_nodes];  // BrickNodes::vertices as they were
};

struct SkinChunk {
  int32_t at[3];
  uint32_t bricks;  // that lie in it; 0: free
};

// One of the two meshes.
struct SkinMesh {
  sandglass_skin_vertex* vertices;
  uint32_t* anchors;  // the particle of each vertex
  uint16_t* indices;
  sandglass_skin_loose* loose;
  sandglass_skin_chunk* chunks;
  uint32_t* first_vertex;  // of each chunk
  uint32_t* first_index;
  uint32_t vertex_count, index_count, flying, lying;
  float* from;  // where each particle was gathered, by number: three each; k_skin_nowhere: it was not
};

// What an app is given: the mesh as it was made, or carried on from there.
struct SkinShown {
  sandglass_skin_vertex* vertices;  // of the chunks that are carried, as in SkinMesh
  sandglass_skin_chunk* chunks;
  sandglass_skin_loose* loose;
  uint32_t flying, lying;
  bool lost;       // most of the mesh's sand has left it: from the next frame on it is not shown
  uint64_t frame;  // which it shows, and after so many of its sub-steps
  uint32_t substeps;
};

// Of a particle, by number.
struct SkinCarried {
  Quad way;         // besides the motion
  uint32_t loose;   // of the mesh's list
  uint32_t motion;  // of SkinCarry::motions; k_brick_none: it goes with none
};

// How colliders have gone since the mesh was gathered.
struct SkinMotion : RigidWay {
  bool encloses;  // a field that is solid outside: its sand goes with no other
};
constexpr uint32_t k_skin_motions = 16;

// A carry under way.
struct SkinCarry {
  SkinMotion motions[k_skin_motions];
  uint32_t motion_count;
  uint64_t frame;  // to which it carries, and after so many of its sub-steps
  uint32_t substeps;
  uint32_t record, chunk;  // the next ones
  uint32_t flying, lying;  // that are written
  int32_t left;            // so many more particles have left the mesh than are in it
  uint32_t motion;         // of the last vertex
  bool changed;
};

struct SkinState {
  sandglass_skin_desc desc;
  float spacing, inverse_spacing, inverse_side;  // of a node, of the block of grains
  const Kernels* kernels;
  // Where "up" is: lattice axis a is the world's axis[a], times sign[a]; and how far the nodes of a layer move aside for one
  // of height, in k_skin_one of a node.
  uint32_t axis[3];
  float sign[3];
  int32_t lean[2];
  float up[3];  // in the lattice's axes
  bool falls;   // there is gravity
  // Colliders as they were when sand was taken, and versions of their fields, by slot of `Colliders`; k_no_shape: none.
  ColliderFrame* colliders;
  uint64_t* fields;
  ColliderFrame* met;  // those of the mesh that is shown
  uint32_t* movers;    // slots of those that move
  uint32_t mover_count;
  SkinTaken* taken;
  uint32_t taken_count;
  SkinParticle* particles;
  uint32_t particle_numbers;  // that have been seen
  // Bricks.
  Brick* bricks;
  BrickNodes* nodes;
  uint32_t* slots;  // an open hash table: the number of a brick, plus 1
  uint32_t* free_bricks;
  uint32_t brick_capacity, brick_count, free_count, slot_mask;  // brick_count: that were ever used
  SkinChunk* chunks;
  uint32_t* chunk_order;  // by place
  uint32_t chunk_capacity, chunk_count;
  uint32_t vertex_capacity, index_capacity;
  SkinMesh front, back;
  SkinShown shown;
  SkinCarried* carried;
  SkinCarry carry;
  bool valid;
  uint32_t in_time;                 // skins in a row that took no more than a frame
  uint32_t version, front_version;  // of what is shown, and of that as `front` was made
  uint32_t left_out, left_out_now;
  // What asks for a skin, and the one under way.
  const Granular* granular;
  uint64_t frame, front_frame, begun;
  bool asked, moving, whole_asked;
  bool missing;                                       // particles moved on while they were taken
  bool ran;                                           // a unit, in this frame
  uint64_t gathered_frame;                            // in which sand was taken, last,
  uint32_t gathered_substeps;                         // after so many of its sub-steps,
  uint32_t restarts;                                  // and how often that was not the first time
  uint32_t sand;                                      // particles in the last frame
  uint32_t spent[k_skin_kinds], usual[k_skin_kinds];  // items of the skin under way, and of the last one
  SkinPhase phase;
  uint32_t cursor, layer, work_count;
  int32_t level_low, level;
  uint32_t* work;         // bricks of a level
  uint16_t by_free[256];  // k_skin_one over the free share, by BrickNodes::solid
  uint16_t* outer;        // of a chunk's outer bricks: the index of each cell's vertex in this chunk
  SkinBlocks* blocks;
  SurfacePoint* points;  // of one brick, and of the nodes after it along each axis
  uint8_t cycle;
};

// ---- bricks (bricks.cpp)

// Where the brick is that `around` of one at `at` has at k.
void brick_beside(const int32_t at[3], uint32_t k, int32_t other[3]);
uint32_t brick_find(const SkinState& s, const int32_t at[3]);
// Makes it where it is not there; k_brick_none: there is no room.
uint32_t brick_make(SkinState* s, const int32_t at[3]);
void brick_release(SkinState* s, uint32_t brick);
// To the state without sand.
void skin_forget(SkinState* s);

// Eight nodes along x: compilers know vectors, and do the same to each lane.
using Row = uint16_t __attribute__((vector_size(16)));
inline Row row_at(const uint16_t* nodes) {
  Row row;
  memcpy(&row, nodes, sizeof row);
  return row;
}
inline void set_row(uint16_t* nodes, Row row) { memcpy(nodes, &row, sizeof row); }

// Calls task(y, z, before, own, after) for each row of a brick and of the bricks around, `apron` nodes beyond it on every
// side: where a value of its eight nodes stands, and those of the rows before and after it. `outside` where there is no brick.
template <uint32_t apron, class T, class Task>
void each_row(const SkinState& s, const Brick& brick, T (BrickNodes::*field)[k_brick_nodes], T outside, Task task) {
  constexpr uint32_t k_first[3] = {k_brick_side - apron, 0, 0}, k_count[3] = {apron, k_brick_side, apron};
  constexpr uint32_t k_to[3] = {0, apron, apron + k_brick_side};
  T nothing[k_brick_side];
  for (T& value : nothing) value = outside;
  for (uint32_t by = 0; by < 3; ++by)
    for (uint32_t bz = 0; bz < 3; ++bz) {
      const uint32_t* three = brick.around + 3 * bz + 9 * by;
      const T* from[3];
      uint32_t step_y[3], step_z[3];  // 0: the same row again
      for (uint32_t x = 0; x < 3; ++x) {
        const bool there = three[x] != k_brick_none;
        from[x] =
            there ? (s.nodes[three[x]].*field) + k_brick_layer * k_first[by] + k_brick_side * k_first[bz] : nothing;
        step_y[x] = there ? k_brick_layer : 0;
        step_z[x] = there ? k_brick_side : 0;
      }
      for (uint32_t y = 0; y < k_count[by]; ++y) {
        const T *before = from[0] + y * step_y[0], *own = from[1] + y * step_y[1], *after = from[2] + y * step_y[2];
        for (uint32_t z = 0; z < k_count[bz]; ++z) {
          task(k_to[by] + y, k_to[bz] + z, before, own, after);
          before += step_z[0];
          own += step_z[1];
          after += step_z[2];
        }
      }
    }
}

// A value of a brick's nodes and of those around: a cube of k_brick_side + 2 * apron, in the order of nodes.
template <uint32_t apron, class T>
void brick_block(const SkinState& s, const Brick& brick, T (BrickNodes::*field)[k_brick_nodes], T outside, T* block) {
  constexpr uint32_t k_pitch = k_brick_side + 2 * apron;
  each_row<apron>(s, brick, field, outside, [&](uint32_t y, uint32_t z, const T* before, const T* own, const T* after) {
    T* to = block + (y * k_pitch + z) * k_pitch;
    memcpy(to, before + k_brick_side - apron, apron * sizeof(T));
    memcpy(to + apron, own, k_brick_side * sizeof(T));
    memcpy(to + apron + k_brick_side, after, apron * sizeof(T));
  });
}

// Whether walls stand between nodes of a brick, or of those around it.
inline bool has_walls(const SkinState& s, const Brick& brick) {
  for (const uint32_t other : brick.around)
    if (other != k_brick_none && s.bricks[other].walled) return true;
  return false;
}

// Eight values of a cell, linear between them.
struct CellValues {
  float v[8] = {};
  CellValues() = default;
  // The first one's place, and how far the others are along x, y and z.
  template <class T>
  CellValues(const T* node, const uint32_t step[3]) {
    for (uint32_t c = 0; c < 8; ++c)
      v[c] = static_cast<float>(node[(c & 1) * step[0] + (c >> 1 & 1) * step[1] + (c >> 2) * step[2]]);
  }

  float sum() const { return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7])); }
  float at(const float u[3]) const {
    float w[4];
    for (uint32_t c = 0; c < 4; ++c) w[c] = v[c] + u[2] * (v[c + 4] - v[c]);
    const float low = w[0] + u[1] * (w[2] - w[0]), high = w[1] + u[1] * (w[3] - w[1]);
    return low + u[0] * (high - low);
  }
  void gradient(const float u[3], float out[3]) const {
    for (uint32_t m = 0; m < 3; ++m) {
      const uint32_t a = 1u << m, b = m == 0 ? 2 : 1, c = m == 2 ? 2 : 4;
      const float ub = m == 0 ? u[1] : u[0], uc = m == 2 ? u[1] : u[2];
      const float d0 = v[a] - v[0], d1 = v[a + b] - v[b], d2 = v[a + c] - v[c], d3 = v[a + b + c] - v[b + c];
      const float low = d0 + ub * (d1 - d0), high = d2 + ub * (d3 - d2);
      out[m] = low + uc * (high - low);
    }
  }
};

// ---- phases: each runs one unit, and returns true once its phase is done

// Colliders as they are `before` seconds before the frame's end.
void skin_take_colliders(SkinState* s, float before);
// A field that is not passed any more must not be read: a skin under way goes on without it.
void skin_drop_gone_fields(SkinState* s);
uint32_t skin_take_items(const SkinState& s);
bool skin_take(SkinState* s);
bool skin_gather(SkinState* s);
bool skin_leave(SkinState* s);
bool skin_density(SkinState* s);
// How free the surroundings of a node are, in 1/256, by BrickNodes::solid: the ramp of a wall through the sums' spread and the
// filter, whose slope is 0.49 a node.
inline uint16_t skin_free(uint8_t solid) {
  constexpr uint16_t k_least = 208;  // 128 * 21 / 8 - 128
  const uint16_t scaled = static_cast<uint16_t>(static_cast<uint16_t>(solid * 21) >> 3);
  const uint16_t above = static_cast<uint16_t>((scaled > k_least ? scaled : k_least) - k_least);
  return above < 256 ? above : uint16_t{256};
}
// A node's part in the calm density: as free as it is; a little even in a collider, so that the surface goes on in there.
inline uint16_t skin_part(uint8_t solid) {
  const uint16_t free = skin_free(solid), deep = solid >> 3;
  return free > deep ? free : deep;
}
void skin_begin_fill(SkinState* s);
bool skin_fill(SkinState* s);
bool skin_calm(SkinState* s);
void skin_begin_mesh(SkinState* s);
bool skin_mesh(SkinState* s);
void skin_begin_loose(SkinState* s);
bool skin_loose(SkinState* s);

// ---- between two skins (carry.cpp)

// Whether a skin may take more than a frame.
inline bool skin_is_late(const SkinState& s) { return s.in_time < k_skin_in_time; }
inline bool skin_has_work(const SkinState& s) { return s.phase != SkinPhase::idle || s.asked; }
// A particle against what is below it: a collider that moves, or the world. Whether it flies, and what of it falls.
void skin_find_fall(const SkinState& s, const float position[3], const float velocity[3], float* falls, bool* flies);
// Until there is a mesh, and where sand has gone on since what is shown: at the end of a frame, whatever the budget.
Stage skin_carry_stage(void* skin);

// Of a place in lattice steps: its cell, and the brick and node of that.
inline void skin_place(const SkinState& s, const float position[3], int32_t at[3]) {
  for (uint32_t a = 0; a < 3; ++a)
    at[a] =
        floor_whole((s.sign[a] * position[s.axis[a]] * s.inverse_spacing - 0.5f) * static_cast<float>(k_skin_steps));
}
inline uint32_t node_of(const int32_t cell[3]) {
  return static_cast<uint32_t>(cell[0] & 7) + k_brick_side * static_cast<uint32_t>(cell[2] & 7) +
         k_brick_layer * static_cast<uint32_t>(cell[1] & 7);
}

// Triangles and loose sand of the mesh as it is.
inline uint32_t skin_items(const SkinState& s) { return s.front.index_count / 3 + s.front.flying + s.front.lying; }

extern const Capability k_skin_capability;

}  // namespace sandglass

struct sandglass_skin {
  sandglass::Member member;
  sandglass::SkinState skin;
};
