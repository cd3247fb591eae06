// The state behind sandglass/cast.h. A texture is made in phases, cut into units of the shadow stage:
//   gather   the meshes' triangles, in the plane's frame (triangles.cpp); left out while they are as they were
//   draw     one image of bits for each direction of the light (directions.cpp), counted (accumulate.cpp)
//   calm     the counts become bytes, through a filter (calm.cpp); the last unit swaps the two textures
// The texture of the light and the ambient one share all of it, and take turns (stage.cpp). What the app sets is
// compared with what was gathered (compare.cpp).
//
// The state is put together from parts. Each is a section here, which names the source file that changes it: functions
// take that part as a pointer, and the rest as `const CastState&`. stage.cpp and compare.cpp put the whole together
// (tests/docs/parts.py).
#pragma once

#include <cstdint>

#include "kernels/kernels.h"
#include "runtime/frame/capability.h"
#include "runtime/frame/layout.h"
#include "runtime/light/light_cells.h"
#include "runtime/math/app_mesh.h"
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
constexpr double k_cast_slope_max = 5;             // a shadow is drawn this many heights long
constexpr double k_cast_slope_fade = 1;            // over which its end fades, if it goes on
constexpr double k_cast_ambient_slope = 1.5;       // the ambient shadow, this many around the object
constexpr double k_cast_still = 0.1;               // of a texel; what moves less makes no new texture
constexpr uint32_t k_cast_layers = 8;              // at most
constexpr uint32_t k_cast_reaches = 40;            // octaves of distance, from 2^-16 m on
constexpr float k_cast_far = k_mesh_far;           // metres; corners farther than that are left out

// Kinds of work unit.
enum : uint32_t { k_cast_gather, k_cast_draw, k_cast_calm };
static_assert(k_cast_calm + 1 == k_cast_kinds);

enum class CastPhase : uint32_t { idle, gather, draw, calm };

// The two textures.
enum : uint32_t { k_cast_light, k_cast_ambient, k_cast_targets };

// What is drawn together. Real ones come first, because they mask the others.
enum : uint32_t { k_cast_real_closed, k_cast_real, k_cast_virtual_closed, k_cast_virtual, k_cast_groups };

// A plane's frame: x and z lie along it, y is its normal.
struct CastFrame {
  double origin[3], axes[3][3];
  float low[2], high[2], bias, height;
  bool is_virtual;
};

// One direction of the light: how many metres a metre of height moves a shadow along x and z, and the shift of its
// image's grid in texels.
struct CastDirection {
  float slope[2], shift[2];
};

// ---- CastTarget (stage.cpp; the texture under way: accumulate.cpp, calm.cpp)

struct CastTexture {
  uint8_t* bytes;
  CastFrame frame;
  // In that frame, and how far a metre of height slides along it.
  double low[2], texel[2], slide[2];
  // Texels at the low and the high side over which a shadow that goes on fades; 0: it ends there.
  float fade[2][2];
  double light[3];  // world
  uint32_t directions, left_out, too_far;
  float open;
};

// A texture that the app sees, and what is to be made next.
struct CastTarget {
  uint32_t texels;  // 0: none
  CastTexture front, back;
  bool valid;
  // Something has changed since the texture under way, or the last one, was begun.
  bool asked;
  // The next texture is a draft, of few directions.
  bool draft;
  uint32_t completed;
  // Rows that the last texture took, counted as in k_cast_unit_rows.
  uint64_t rows;
};

// ---- CastRequest (create.cpp)

// A mesh as the app has set it; and as its triangles were gathered (triangles.cpp).
struct CastMesh {
  sandglass_cast_mesh asked, gathered;
  // Into the plane's frame, as `gathered` was placed: three rows of four.
  double plane_from_mesh[12];
  // The box of the corners that were gathered, in the mesh's frame.
  float low[3], high[3];
};

// What is asked for.
struct CastRequest {
  CastFrame frame;
  CastMesh* meshes;
  uint32_t mesh_count;
  bool light_known;
  // Direction in the world, and half the angular diameter in turns.
  double light[3], half;
  float cells[k_light_cells];
};

// ---- CastGathered (triangles.cpp)

// Gathered triangles that darken the plane, by the octave of the distance of their farthest point from the anchor.
struct CastReach {
  float low[3], high[3];
  // The smallest distance of a triangle's nearest point, and of a triangle's farthest point.
  float nearest, farthest_min;
  // Triangles, and those of the first mesh.
  uint32_t count, first_mesh;
  bool is_far;
};

// The triangles of the meshes.
struct CastGathered {
  float* corners[9];
  // Of each group's parts, from the lowest layer to the highest: a part is what lies between a layer and the next. Multiples
  // of 16.
  uint32_t starts[k_cast_groups * k_cast_layers + 1], room;
  uint32_t layers;
  CastFrame frame;
  // Whether something darkens the plane, and its box.
  bool darkens;
  double low[3], high[3];
  uint32_t left_out, too_far;
  CastReach reaches[k_cast_reaches];
  // The middle of the first mesh that darkens the plane.
  float anchor[3];
  uint32_t first_mesh;
  // Triangles that are too far are being taken out.
  bool sifts;
  // The next triangle: of a mesh, or while `sifts` of all. How many are kept.
  uint32_t part, mesh, triangle, kept;
};

// ---- CastComparison (compare.cpp)

struct CastComparison {
  // The gathered triangles are not those of the meshes.
  bool stale;
  // All triangles of all meshes.
  uint32_t triangles;
  // Gatherings since the last texture that were begun anew because a mesh had another count.
  uint32_t restarts;
};

// ---- CastDrawing (accumulate.cpp)

struct CastDrawing {
  // Directions of the texture's light, then of the other light.
  CastDirection* directions;
  uint32_t direction_count, other_count;
  // The share of the main light, see cast_share.
  double share;
  // The cells of the last ambient texture.
  float cells[k_light_cells];
  // The next direction, layer, from the highest to the floor, and triangle of all.
  uint32_t direction, layer, group, triangle;
  // Words of bits.
  uint64_t *image, *mask;
  // k_cast_planes words for each word of an image, layer after layer: of the texture's light, and of the other.
  uint64_t *counts[2], *mask_counts[2];
  // Covered texels: each once, and each as often as it is covered.
  uint64_t covered, drawn;
  // Counted as in k_cast_unit_rows.
  uint64_t rows;
};

// ---- CastCalm (calm.cpp)

struct CastCalm {
  uint32_t layer, pass, row;
  // Rows of counts, with k_lane_group before and after each.
  float* values;
  // Minimum, maximum and sum: k_cast_rows rows each.
  float* windows[3];
  // The ambient texture holds less than it should.
  bool shade_found;
};

// ---- CastProgress (stage.cpp)

struct CastProgress {
  CastPhase phase;
  uint32_t target, last_target;
  // CastCalm::shade_found of the last ambient texture.
  bool in_shade;
};

// ---- the whole

struct CastState {
  sandglass_cast_desc desc;
  const Kernels* kernels;
  CastTarget targets[k_cast_targets];
  CastRequest request;
  CastGathered gathered;
  CastComparison comparison;
  CastDrawing drawing;
  CastCalm calm;
  CastProgress progress;
};

inline uint32_t cast_words(uint32_t texels) { return texels / 64; }
inline uint32_t cast_pitch(uint32_t texels) { return texels + 2 * k_lane_group; }
// Whether what is real keeps virtual objects from darkening the plane.
inline bool cast_masks(const CastGathered& g) {
  return !g.frame.is_virtual && g.starts[k_cast_virtual_closed * g.layers] != 0;
}
// How high a layer is above the plane.
inline float cast_level(const CastFrame& frame, uint32_t layers, uint32_t layer) {
  return layer == 0 ? 0 : frame.height * static_cast<float>(layer) / static_cast<float>(layers - 1);
}

// The main light's share of all light, where textures are divided by what real things leave of both lights; else 0.
double cast_share(const CastState& cast);

// After a call that has changed meshes or plane: what is gathered and shown may be out of date.
void cast_compare(CastState* cast);
// Three rows of four, from a mesh's frame into the plane's.
void cast_place(const CastFrame& frame, const float world_from_mesh[16], double rows[12]);

// The phases: each runs one unit, and returns true once its phase is done.
void cast_begin_gather(CastGathered* gathered, CastMesh* meshes, const CastRequest& request);
bool cast_gather(CastGathered* gathered, CastMesh* meshes, uint32_t mesh_count, float farthest);
void cast_begin_draw(CastDrawing* drawing, CastTarget* target, const CastState& c);
bool cast_draw(CastDrawing* drawing, CastTarget* target, const CastState& c);
void cast_begin_calm(CastCalm* calm);
bool cast_calm(CastCalm* calm, uint8_t* bytes, const CastState& c);

// Directions of equal irradiance on the plane, in its frame. 0: the light is below it.
uint32_t cast_light_directions(const double light[3], double half_turns, uint32_t count, CastDirection* directions);
uint32_t cast_cell_directions(const float cells[k_light_cells], uint32_t count, CastDirection* directions);

extern const Capability k_cast_capability;

}  // namespace sandglass

struct sandglass_cast {
  sandglass::Member member;
  sandglass::CastState cast;
};
