// The state behind sandglass/pile_shadow.h. Its work is cut into units of the shadow stage. A texture is made in
// phases: columns from the spheres, then rows of the floor, then rows of the sand's own surface. The last of these
// units swaps the two textures. The texture of the room's light follows (sky.h). Either is left out where nothing
// asks for it.
//
// The spheres are the grains, or the particles of a scene without grains; or sand is what lies under a skin
// (skin.cpp), as it was last completed. They are read in place, without a copy. The scene may sort them between
// two units of the first phase: then a sphere may be missed or taken twice, in that one texture.
//
// The state is put together from parts. Each is a section here, which names the source file that changes it: functions
// take that part as a pointer, and the rest as `const Pile&`. stage.cpp puts the whole together (tests/docs/parts.py).
#pragma once

#include <cstdint>

#include "kernels/kernels.h"
#include "runtime/frame/capability.h"
#include "runtime/shadow/pile/sky.h"
#include "sandglass/pile_shadow.h"
#include "sandglass/relief.h"
#include "sandglass/skin.h"

namespace sandglass {

constexpr uint32_t k_pile_azimuths = 12;  // of a light that holds the zenith; other lights have half as many
constexpr uint32_t k_pile_steps = 48;     // along one azimuth, at most
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

// ---- PileRectangle (create.cpp)

// The rectangle of the floor that the texture covers.
struct PileRectangle {
  // Its corners, x and z, and its height.
  float low[2], high[2], height;
  // Metres, and how many along a side.
  float texel[2];
  uint32_t texels;
};

// ---- PileGround (ground.cpp)

struct PileGround {
  // As the app told it; its array is null where there is the floor alone.
  sandglass_heights map;
  // Cells along x and z of the map from texel to texel along u and v; where texel 0 begins, from the middle of the
  // first cell.
  float per_texel[2][2], first[2];
  // Metres over the floor: of the map's corner; more from cell to cell, of a plane that is not quite level; at most.
  float foot, rise[2], highest;
};

// ---- PileColumns (columns.cpp, skin.cpp)

struct PileColumns {
  // texels x pitch, after k_lane_group of padding.
  float *tops, *bottoms, *fills;
  uint32_t pitch;
  // The first and last row and column with sand.
  int32_t sand_rows[2], sand_columns[2];
  // The highest sand, over the floor.
  float top;
  // The next sphere, or item of a skin. A large sphere takes several units: how many of its rows are done.
  uint32_t next, sphere_row;
};

// ---- PileSkin (skin.cpp)

constexpr int32_t k_no_brick = INT32_MAX;  // PileSkin::brick[0]

// The walk over a skin's triangles.
struct PileSkin {
  // SkinState::front_version that the columns were begun with.
  uint32_t version;
  // The chunk of the next triangle, and that chunk's first triangle.
  uint32_t chunk, chunk_first;
  // The brick of the last triangle.
  int32_t brick[3];
  // The height over the floor at which the sand in and below that brick begins.
  float low;
};

// ---- PileAir (air.cpp)

struct PileAir {
  // Of each texel: the share of the light that sand in the air leaves.
  float* shares;
  // Some share is below 1.
  bool any;
};

// ---- PileLighting (lighting.cpp)

struct PileLighting {
  // The light of the texture under way, or of the last one.
  double made_for[3];
  // Sine and cosine of half its angular diameter.
  double half_sine, half_cosine;
  PileAzimuth* azimuths;
  PileStep* steps;
  uint32_t azimuth_count;
  float inverse_total;
  // The next row.
  uint32_t row;
  // Of the row under way: azimuths and steps that meet rows of sand.
  PileAzimuth* row_azimuths;
  PileStep* row_steps;
  // Of the row under way: heights of the ground and of the sand's surface, and the kernel's output.
  float *ground, *receivers, *shares;
};

// ---- PileTextures (stage.cpp)

struct PileTexture {
  // sand: null without.
  uint8_t *floor, *sand;
  // The frame in which it was begun.
  uint64_t frame;
  uint64_t version;
};

struct PileTextures {
  PileTexture front, back;
  bool valid;
};

// ---- PileRequest (create.cpp; of a frame: stage.cpp)

// What asks for a texture.
struct PileRequest {
  DrawnSand source;
  uint64_t frame;
  uint32_t asked;
  // The light's direction; its angular diameter in radians; how far both may move before a new texture, squared.
  double light[3], width, tolerance_squared;
  float opacity;
};

// ---- PileProgress (stage.cpp)

struct PileProgress {
  PilePhase phase;
  uint32_t making;
  // How often the columns were begun anew.
  uint32_t restarts;
  // The texture under way, or the last one, leaves the sky out.
  bool skips_sky;
};

// ---- the whole

struct Pile {
  const Kernels* kernels;
  PileRectangle rectangle;
  PileGround ground;
  PileColumns columns;
  PileSkin skin;
  PileAir air;
  PileLighting lighting;
  PileTextures textures;
  PileRequest request;
  PileProgress progress;
  PileSky sky;
};

// Which textures are asked for and can be made: that of the light while it is above the horizon, that of the sky if
// there is one.
inline uint32_t pile_wanted(const Pile& p) {
  return p.request.asked & ((p.request.opacity > 0 ? k_ask_light : 0u) | (p.sky.texels != 0 ? k_ask_sky : 0u));
}

// The columns of the texture whose middles a sphere covers: columns from first[0] to last[0], rows from first[1] to
// last[1]. None where a last one lies before the first. The sphere may lie anywhere and have any radius.
struct PileReach {
  int32_t first[2], last[2];
};
PileReach pile_reach(const PileRectangle& rectangle, const float* centre, float radius);

// Adds to a column: `share` of its texel is covered from `low` to `high` over the floor. Shares that are added to one
// column count as independent of each other.
inline void pile_put_column(PileColumns* p, int32_t column, int32_t row, float share, float low, float high) {
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

// Takes what the app tells. *changed: it is not what was told before.
sandglass_status ground_take(PileGround* ground, const PileRectangle& rectangle, const sandglass_heights& map,
                             bool* changed, const char** reason);
// Metres over the floor, at a place in texels; never below it.
float ground_at(const PileGround& ground, float column, float row);
// The same of a row of texels that are so many of the columns wide and high.
void ground_row(const PileGround& ground, uint32_t row, uint32_t texels, uint32_t joined, float* heights);

// There is no sand yet.
void columns_begin(PileColumns* columns, uint32_t texels);
uint32_t columns_unit_items(const Pile& p);
// One unit. False: there are more.
bool columns_run(PileColumns* columns, PileSkin* skin, PileAir* air, const Pile& p);
void walk_begin(PileSkin* skin, const DrawnSand& source);
// The columns of one of a skin's items. False: as put_sphere says (columns.cpp).
bool pile_put_skin(PileColumns* columns, PileSkin* skin, PileAir* air, const Pile& p, uint32_t item, uint32_t* visits);
void air_begin(PileAir* air, uint32_t texels);
// What one particle in the air hides, once the columns of the mesh stand. False: as above.
bool pile_put_flying(PileAir* air, const Pile& p, const sandglass_skin_loose& loose, uint32_t* visits);

// Cuts the light into azimuths.
void lighting_cut(PileLighting* lighting, const Pile& p);
// One unit: rows of the floor, or of the sand's own surface. False: there are more.
bool lighting_run(PileLighting* lighting, const Pile& p, uint8_t* texture, bool floor);

WorkUnit pile_next(const Pile& pile);
void pile_run(Pile* pile);

extern const Capability k_pile_capability;

}  // namespace sandglass

struct sandglass_pile_shadow {
  sandglass::Member member;
  sandglass::Pile pile;
};
