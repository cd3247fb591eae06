// The state behind sandglass/cast.h. A texture is made in phases, cut into units of the shadow stage:
//   gather   the meshes' triangles, in the plane's frame (gather.cpp); left out while they are as they were
//   draw     one image of bits for each direction of the light (directions.cpp), counted (draw.cpp)
//   calm     the counts become bytes, through a filter (calm.cpp); the last unit swaps the two textures
// The texture of the light and the ambient one share all of it, and take turns (stage.cpp).
#pragma once

#include <cstdint>

#include "kernels/kernels.h"
#include "runtime/frame/capability.h"
#include "runtime/frame/layout.h"
#include "runtime/light/light_cells.h"
#include "sandglass/cast.h"

namespace sandglass {

constexpr uint32_t k_cast_ambient_directions = 128;
constexpr uint32_t k_cast_other_directions = 32;   // of the other light, where real things hide some of both
constexpr uint32_t k_cast_planes = 8;              // bits of a count: up to 128
constexpr uint32_t k_cast_draft_directions = 8;    // of a first texture
constexpr uint32_t k_cast_draft_triangles = 4000;  // more than these get a first texture
constexpr uint32_t k_cast_unit_triangles = 512;    // gathered in one unit
constexpr uint32_t k_cast_unit_rows = 4500;        // rows of triangles, and triangles, drawn in one unit
constexpr uint32_t k_cast_step = 16;               // triangles between two looks at that
constexpr uint32_t k_cast_unit_texels = 4096;      // filtered in one unit
constexpr double k_cast_slope_most = 5;            // a shadow is drawn this many heights long
constexpr double k_cast_slope_fade = 1;            // over which its end fades, if it goes on
constexpr double k_cast_ambient_slope = 1.5;       // the ambient shadow, this many around the object
constexpr double k_cast_still = 0.1;               // of a texel; what moves less makes no new texture
constexpr uint32_t k_cast_reaches = 40;            // octaves of distance, from 2^-16 m on
constexpr float k_cast_far = 1e6f;                 // metres; corners farther than that are left out

// Kinds of work unit.
enum : uint32_t { k_cast_gather, k_cast_draw, k_cast_calm };
static_assert(k_cast_calm + 1 == k_cast_kinds);

enum class CastPhase : uint32_t { idle, gather, draw, calm };

// The two textures, also as bits of what is asked for.
enum : uint32_t { k_cast_light, k_cast_ambient, k_cast_targets };

// What is drawn together. Real ones come first, because they mask the others.
enum : uint32_t { k_cast_real_closed, k_cast_real, k_cast_virtual_closed, k_cast_virtual, k_cast_groups };

// A plane's frame: x and z lie along it, y is its normal.
struct CastFrame {
  double origin[3], axes[3][3];
  float low[2], high[2], bias;
  bool is_virtual;
};

// Gathered triangles that darken the plane, by the octave of the distance that they reach from the anchor: their box,
// the nearest that one begins, the least that one reaches, how many they are, and how many of the first mesh.
struct CastReach {
  float low[3], high[3], nearest, least;
  uint32_t count, first_mesh;
  bool is_far;
};

// A mesh as the app has set it, and as its triangles were gathered.
struct CastMesh {
  sandglass_cast_mesh asked, gathered;
  double plane_from_mesh[12];  // of `gathered`: three rows of four
  float low[3], high[3];       // of the corners that were gathered, in the mesh's frame
};

// One direction of the light: how far a metre of height moves a shadow, and where in a texel its grid is.
struct CastDirection {
  float slope[2], shift[2];
};

struct CastTexture {
  uint8_t* bytes;
  CastFrame frame;
  double low[2], texel[2];  // in that frame
  float fade[2][2];  // texels at the low and the high side over which a shadow that goes on fades; 0: it ends there
  double light[3];   // world
  uint32_t directions, left_out, too_far;
  float open;
};

// A texture that the app sees, and what is to be made next.
struct CastTarget {
  uint32_t texels;  // 0: none
  CastTexture front, back;
  bool valid;
  bool asked;  // something has changed since the texture under way, or the last one, was begun
  bool draft;  // the next one is a first texture
  uint32_t completed;
  uint64_t rows;  // that the last one drew, counted as in k_cast_unit_rows
};

struct CastState {
  const Kernels* kernels;
  uint32_t directions_of_light, triangle_capacity, mesh_capacity;
  double tolerance_squared;
  CastTarget targets[k_cast_targets];
  // What is asked for.
  CastFrame frame;
  CastMesh* meshes;
  uint32_t mesh_count;
  bool stale;  // the gathered triangles are not those of the meshes
  bool light_known;
  double light[3], half;  // world; half the angular diameter, in turns
  float cells[k_light_cells], cells_made[k_light_cells];
  // The gathered triangles.
  float* corners[9];
  uint32_t starts[k_cast_groups + 1], room;  // multiples of 16
  CastFrame gathered_frame;
  double low[3], high[3];  // of what darkens the plane
  uint32_t left_out, too_far, triangles;
  float reach;  // of the description
  CastReach reaches[k_cast_reaches];
  float anchor[3];  // the middle of the first mesh that darkens the plane
  uint32_t first_mesh;
  bool sifts;         // what is too far is taken out
  uint32_t restarts;  // since the last texture: gatherings that were begun anew as there were other counts
  // The texture under way.
  CastPhase phase;
  uint32_t target, last_target;
  uint32_t group, mesh, cursor, kept;  // of gather: next triangle of a mesh; of draw: next triangle of all
  CastDirection* directions;           // of the texture's light, then of the other light
  uint32_t direction_count, other_count, direction;
  uint64_t *image, *mask;                // words of bits
  uint64_t *counts[2], *mask_counts[2];  // of the texture's light and the other: k_cast_planes words for each of those
  double share;                          // of the main light, see cast_share
  bool shade_found, in_shade;  // the ambient texture holds less than it should, see calm.cpp; the last one did
  uint64_t covered, drawn;     // texels, once and as often as they are covered
  uint64_t rows;
  uint32_t pass, row;  // of calm
  float* values;       // rows of counts, with k_lane_group before and after each
  float* windows[3];   // least, greatest, sum: k_cast_rows rows each
};

inline uint32_t cast_words(uint32_t texels) { return texels / 64; }
inline uint32_t cast_pitch(uint32_t texels) { return texels + 2 * k_lane_group; }
// Whether what is real keeps virtual objects from darkening the plane.
inline bool cast_masks(const CastState& c) {
  return !c.gathered_frame.is_virtual && c.starts[k_cast_virtual_closed] != 0;
}

// What the cells leave for the main light, where both textures are divided by what real things leave of both lights; or
// 0.
double cast_share(const CastState& cast);

// After a call that has changed meshes or plane: what is gathered and shown may be out of date.
void cast_compare(CastState* cast);

// The phases: each runs one unit, and returns true once its phase is done.
void cast_begin_gather(CastState* cast);
bool cast_gather(CastState* cast);
void cast_begin_draw(CastState* cast);
bool cast_draw(CastState* cast);
void cast_begin_calm(CastState* cast);
bool cast_calm(CastState* cast);

// Directions of equal irradiance on the plane, in its frame. 0: the light is below it.
uint32_t cast_light_directions(const double light[3], double half_turns, uint32_t count, CastDirection* directions);
uint32_t cast_cell_directions(const float cells[k_light_cells], uint32_t count, CastDirection* directions);

extern const Capability k_cast_capability;

}  // namespace sandglass

struct sandglass_cast {
  sandglass::Member member;
  sandglass::CastState cast;
};
