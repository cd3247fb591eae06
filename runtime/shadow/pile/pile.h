// The state behind sandglass/pile_shadow.h. Its work is cut into units of the shadow stage. A texture is made in
// phases: columns from the spheres, then rows of the floor, then rows of the sand's own surface. The last of these
// units swaps the two textures. The texture of the room's light follows (pile_sky.h). Either is left out where nothing
// asks for it.
//
// The spheres are the grains, or the particles of a scene without grains; or sand is what lies under a skin (pile_skin.cpp),
// as it was last completed. They are read in place, without a copy. The
// scene may sort them between two units of the first phase: then a sphere may be missed or taken twice, in that one
// texture.
#pragma once

#include <cstdint>

#include "kernels/kernels.h"
#include "runtime/frame/capability.h"
#include "runtime/shadow/pile/sky.h"
#include "sandglass/pile_shadow.h"
#include "sandglass/skin.h"

namespace sandglass {

constexpr uint32_t k_pile_azimuths = 12;  // of a light that holds the zenith; other lights have half as many
constexpr uint32_t k_pile_steps = 48;     // most steps along one azimuth
constexpr uint32_t k_pile_unit_texels = 512;
constexpr uint32_t k_pile_unit_columns = 8192;    // about as many as the spheres of one unit write
constexpr uint32_t k_pile_unit_triangles = 1024;  // of a skin
constexpr float k_loose_outline = 0.3f;           // of a particle's outline that the loose sand of a skin covers
constexpr float k_pile_empty = 1e30f;
constexpr float k_pile_highest = 1e6f;       // metres over the floor; what is higher is left out
constexpr float k_pile_radius_limit = 1e6f;  // metres; spheres of such a radius are left out

// Kinds of work unit.
enum : uint32_t { k_pile_columns, k_pile_rows, k_pile_levels, k_pile_sky_rows };
static_assert(k_pile_sky_rows + 1 == k_pile_shadow_kinds);

enum class PilePhase : uint32_t { idle, columns, floor, sand, levels, sky };

// What is asked for and what is under way, as bits.
enum : uint32_t { k_ask_light = 1, k_ask_sky = 2, k_ask_all = 3 };

constexpr int32_t k_no_brick = INT32_MAX;  // Pile::skin_brick[0]

struct PileTexture {
  uint8_t *floor, *sand;  // sand: null without
  uint64_t frame;         // in which it was begun
  uint64_t version;
};

struct Pile {
  const Kernels* kernels;
  float low[2], high[2];  // corners of the rectangle, x and z
  float height;           // of the floor
  float texel[2];         // metres
  uint32_t texels, pitch;
  double width;                   // of the light, radians
  double half_sine, half_cosine;  // of half of it, as the texture under way is made for
  double tolerance_squared;
  float *tops, *bottoms, *fills;        // texels x pitch, after k_lane_group of padding
  float *nothing, *receivers, *shares;  // one row each: heights of the floor, of the receivers, the kernel's output
  PileAzimuth *azimuths, *row_azimuths;
  PileStep *steps, *row_steps;  // of the row under way: those that meet rows of sand
  // The texture under way.
  PilePhase phase;
  uint32_t cursor;              // next particle or row
  uint32_t sphere_row;          // rows of this particle that are done, where it takes several units
  uint32_t chunk, chunk_first;  // of the skin: where the cursor is, and that chunk's first triangle
  int32_t skin_brick[3];        // of the last triangle,
  float skin_low;               // and where the sand below it begins, over the floor
  uint32_t skin_version;        // that the columns were begun with
  uint32_t restarts;
  int32_t sand_rows[2], sand_columns[2];
  float top;    // of the highest sand, above the floor
  float* air;   // of each texel: what sand in the air leaves of the light (pile_air.cpp)
  bool in_air;  // some of that is below 1
  uint32_t azimuth_count;
  float inverse_total;
  PileTexture front, back;
  bool valid;
  double light[3], made_for[3];
  float opacity;
  // What asks for a texture.
  DrawnSand source;
  uint64_t frame;
  uint32_t asked, making;
  bool skips_sky;  // the texture under way, or the last one
  PileSky sky;
};

// What of that which is asked for can be made: nothing where the light is below the horizon, or there is no such
// texture.
inline uint32_t pile_wanted(const Pile& p) {
  return p.asked & ((p.opacity > 0 ? k_ask_light : 0u) | (p.sky.texels != 0 ? k_ask_sky : 0u));
}

// The columns of the texture whose middles a sphere covers: rows from first[1] to last[1], columns from first[0] to
// last[0]. A last one before the first: none. Any centre and radius will do.
struct PileReach {
  int32_t first[2], last[2];
};
PileReach pile_reach(const Pile& pile, const float* centre, float radius);

// Adds to a column: `share` of its texel is covered from `low` to `high` over the floor. What lies in one column is taken
// to lie independently of each other.
inline void pile_put_column(Pile* p, int32_t column, int32_t row, float share, float low, float high) {
  if (!(high > 0)) return;
  const int64_t at = static_cast<int64_t>(row) * p->pitch + column;
  float *top = p->tops + at, *bottom = p->bottoms + at, *fill = p->fills + at;
  *top = high > *top ? high : *top;
  *bottom = low < *bottom ? low : *bottom;
  *fill += share * (1 - *fill);
  p->top = high > p->top ? high : p->top;
  p->sand_rows[0] = row < p->sand_rows[0] ? row : p->sand_rows[0];
  p->sand_rows[1] = row > p->sand_rows[1] ? row : p->sand_rows[1];
  p->sand_columns[0] = column < p->sand_columns[0] ? column : p->sand_columns[0];
  p->sand_columns[1] = column > p->sand_columns[1] ? column : p->sand_columns[1];
}

// The columns of one of a skin's items. False: as put_sphere says (pile.cpp).
bool pile_put_skin(Pile* p, uint32_t item, uint32_t* visits);
// What one particle in the air hides, once the columns of the mesh stand. False: as above.
bool pile_put_flying(Pile* p, const sandglass_skin_loose& loose, uint32_t* visits);

WorkUnit pile_next(const Pile& pile);
void pile_run(Pile* pile);

extern const Capability k_pile_capability;

}  // namespace sandglass

struct sandglass_pile_shadow {
  sandglass::Member member;
  sandglass::Pile pile;
};
