// The columns of the sand, from its spheres or from a skin.
#include <cstdint>

#include "kernels/whole.h"
#include "runtime/math/math.h"
#include "runtime/shadow/baked/shadow.h"
#include "runtime/shadow/pile/pile.h"
#include "runtime/shadow/pile/thin.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

// A sphere goes into the column that holds its centre, and covers it by `share` (thin.h). It reaches as high and
// as low as its two halves do in the mean. A sphere as wide as a texel counts as the cube whose faces are as large as
// its silhouette. It also fills every column whose middle lies under or over it. `visits` is what is left of this
// unit's columns. False: it is spent, and the sphere goes on in the next unit.
bool put_sphere(PileColumns* columns, const Pile& p, const float* centre, float share, uint32_t* visits) {
  const PileRectangle& r = p.rectangle;
  const float radius = p.request.source.radius, n = static_cast<float>(r.texels);
  const float rise = (is_finer_than_texels(p) ? k_fine_rise : k_half_face) * radius;
  const float x = (centre[0] - r.low[0]) / r.texel[0], z = (centre[2] - r.low[1]) / r.texel[1];
  const float y = centre[1] - r.height;
  if (columns->sphere_row == 0 && x >= 0 && z >= 0 && x < n && z < n && y < k_pile_highest)
    pile_put_column(columns, to_whole<int32_t>(x), to_whole<int32_t>(z), share, y - rise, y + rise);
  if (is_finer_than_texels(p)) return true;
  const PileReach reach = pile_reach(r, centre, radius);
  const int32_t wide = reach.last[0] - reach.first[0] + 1;
  for (int32_t v = reach.first[1] + static_cast<int32_t>(columns->sphere_row); v <= reach.last[1] && wide > 0; ++v) {
    if (*visits < static_cast<uint32_t>(wide)) {
      columns->sphere_row = static_cast<uint32_t>(v - reach.first[1]);
      return false;
    }
    *visits -= static_cast<uint32_t>(wide);
    for (int32_t u = reach.first[0]; u <= reach.last[0]; ++u) {
      const float dx = (static_cast<float>(u) + 0.5f - x) * r.texel[0];
      const float dz = (static_cast<float>(v) + 0.5f - z) * r.texel[1];
      const float square = radius * radius - dx * dx - dz * dz;
      if (!(square > 0)) continue;
      const float half = __builtin_sqrtf(square);
      pile_put_column(columns, u, v, 1, y - half, y + half);
    }
  }
  columns->sphere_row = 0;
  return true;
}

// Columns that a sphere may cover along an axis.
float columns_across(const Pile& p, uint32_t axis) {
  const float columns = 2 * p.request.source.radius / p.rectangle.texel[axis] + 1,
              n = static_cast<float>(p.rectangle.texels);
  return columns < n ? columns : n;
}

// The centres of a source: the first one, and how many floats lie from each to the next.
struct Centres {
  const float* first;
  uint64_t stride;
};

Centres centres_of(const DrawnSand& source) {
  if (source.grains != nullptr) return {(*source.grains)->position, sizeof(Grain) / sizeof(float)};
  if (source.particles != nullptr) return {(*source.particles)->position, sizeof(Particle) / sizeof(float)};
  return {source.positions, 3};
}

}  // namespace

PileReach pile_reach(const PileRectangle& r, const float* centre, float radius) {
  PileReach reach = {{0, 0}, {-1, -1}};
  const float y = centre[1] - r.height, n = static_cast<float>(r.texels);
  if (!(radius > 0 && radius < k_pile_radius_limit && y < k_pile_highest && y + radius > 0)) return reach;
  float from[2], to[2];
  for (uint32_t axis = 0; axis < 2; ++axis) {
    const float middle = (centre[2 * axis] - r.low[axis]) / r.texel[axis], half = radius / r.texel[axis];
    from[axis] = middle - half - 0.5f;
    to[axis] = middle + half - 0.5f;
    if (!(from[axis] < n && to[axis] >= 0)) return reach;
  }
  for (uint32_t axis = 0; axis < 2; ++axis) {  // what is converted lies from 0 to n
    const double first = from[axis] > 0 ? static_cast<double>(from[axis]) : 0.0;
    const double last = to[axis] < n - 1 ? static_cast<double>(to[axis]) : static_cast<double>(n) - 1;
    reach.first[axis] = static_cast<int32_t>(ceiling_index(first));
    reach.last[axis] = static_cast<int32_t>(floor_index(last));
  }
  return reach;
}

void columns_begin(PileColumns* columns, uint32_t texels) {
  const uint32_t count = texels * columns->pitch + k_lane_group;
  float* tops = columns->tops - k_lane_group;
  float* bottoms = columns->bottoms - k_lane_group;
  float* fills = columns->fills - k_lane_group;
  for (uint32_t i = 0; i < count; ++i) {
    tops[i] = -k_pile_empty;
    bottoms[i] = k_pile_empty;
    fills[i] = 0;
  }
  columns->sand_rows[0] = columns->sand_columns[0] = static_cast<int32_t>(texels);
  columns->sand_rows[1] = columns->sand_columns[1] = -1;
  columns->top = 0;
  columns->next = columns->sphere_row = 0;
}

uint32_t columns_unit_items(const Pile& p) {
  if (p.request.source.skin != nullptr) return k_pile_unit_triangles;
  const float count = static_cast<float>(k_pile_unit_columns) / (columns_across(p, 0) * columns_across(p, 1));
  return count > 1024 ? 1024u : count > 1 ? to_whole<uint32_t>(count) : 1u;
}

bool columns_run(PileColumns* columns, PileSkin* skin, PileAir* air, const Pile& p) {
  const DrawnSand& source = p.request.source;
  const uint32_t count = source.skin != nullptr ? skin_items(*source.skin) : source.count;
  const uint32_t left = count > columns->next ? count - columns->next : 0, limit = columns_unit_items(p);
  const uint32_t end = columns->next + (left < limit ? left : limit);
  uint32_t visits = k_pile_unit_columns;
  if (source.skin != nullptr) {
    for (; columns->next < end; ++columns->next)
      if (!pile_put_skin(columns, skin, air, p, columns->next, &visits)) return false;
  } else {
    const Centres centres = centres_of(source);
    const float share = sphere_share(p);
    for (; columns->next < end; ++columns->next)
      if (!put_sphere(columns, p, centres.first + columns->next * centres.stride, share, &visits)) return false;
  }
  return columns->next >= count;
}

}  // namespace sandglass
