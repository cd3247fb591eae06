// Columns from a skin: sand lies under its surface, and its loose sand beside it, thinner than particles are.
//
// A triangle that looks up fills each column whose middle it covers, from where the sand below it begins, or from the
// floor where that is near: below sand on a seat the floor is free. Loose sand that lies goes into the column of its
// centre; for what flies see air.cpp.
#include "runtime/skin/skin.h"
#include "kernels/whole.h"
#include "runtime/math/math.h"
#include "runtime/shadow/pile/pile.h"

namespace sandglass {
namespace {

constexpr float k_near_floor = 2;     // radii
constexpr float k_edge = 1e-3f;       // of a triangle beyond its edges, so that rounding leaves no gap between two
constexpr float k_lying_high = 0.6f;  // radii: how high it lies

void put_lying(PileColumns* columns, const Pile& p, const sandglass_skin_loose& loose) {
  const float radius = p.request.source.radius, n = static_cast<float>(p.rectangle.texels);
  const float x = (loose.position[0] - p.rectangle.low[0]) / p.rectangle.texel[0],
              z = (loose.position[2] - p.rectangle.low[1]) / p.rectangle.texel[1];
  const float low = loose.position[1] - radius - p.rectangle.height;
  if (!(x >= 0 && z >= 0 && x < n && z < n && low < k_pile_highest)) return;
  const int64_t column = to_whole<int64_t>(z) * columns->pitch + to_whole<int64_t>(x);
  if (columns->tops[column] > low - radius) return;  // it lies on the mesh, flat
  const float outline = 3.14159265f * (radius / p.rectangle.texel[0]) * (radius / p.rectangle.texel[1]);
  const float share = loose.weight * k_loose_outline * (outline < 1 ? outline : 1);
  pile_put_column(columns, to_whole<int32_t>(x), to_whole<int32_t>(z), share, low, low + k_lying_high * radius);
}

// False: this unit's columns are spent, and the triangle goes on at the same row in the next unit.
bool put_triangle(PileColumns* columns, const PileRectangle& r, const float* a, const float* b, const float* c,
                  float from, uint32_t* visits) {
  const float ux = b[0] - a[0], uz = b[2] - a[2], vx = c[0] - a[0], vz = c[2] - a[2], across = uz * vx - ux * vz;
  if (!(across > 0)) return true;  // it looks down or aside
  int32_t first[2], last[2];
  for (uint32_t axis = 0; axis < 2; ++axis) {
    const uint32_t w = 2 * axis;
    const float smallest = a[w] < b[w] ? (a[w] < c[w] ? a[w] : c[w]) : (b[w] < c[w] ? b[w] : c[w]);
    const float largest = a[w] > b[w] ? (a[w] > c[w] ? a[w] : c[w]) : (b[w] > c[w] ? b[w] : c[w]);
    const float low = (smallest - r.low[axis]) / r.texel[axis] - 0.5f, n = static_cast<float>(r.texels);
    const float high = (largest - r.low[axis]) / r.texel[axis] - 0.5f;
    if (!(low < n && high >= 0)) return true;
    first[axis] = low > 0 ? static_cast<int32_t>(ceiling_index(static_cast<double>(low))) : 0;
    last[axis] = high < n - 1 ? to_whole<int32_t>(high) : static_cast<int32_t>(r.texels) - 1;
  }
  const uint32_t wide = last[0] >= first[0] ? static_cast<uint32_t>(last[0] - first[0] + 1) : 0;
  const float inverse = 1 / across;
  for (int32_t row = first[1] + static_cast<int32_t>(columns->sphere_row); row <= last[1] && wide != 0; ++row) {
    if (*visits < wide) {
      columns->sphere_row = static_cast<uint32_t>(row - first[1]);
      return false;
    }
    *visits -= wide;
    const float z = r.low[1] + (static_cast<float>(row) + 0.5f) * r.texel[1] - a[2];
    for (int32_t column = first[0]; column <= last[0]; ++column) {
      const float x = r.low[0] + (static_cast<float>(column) + 0.5f) * r.texel[0] - a[0];
      const float s = (z * vx - x * vz) * inverse, t = (uz * x - ux * z) * inverse;
      if (s < -k_edge || t < -k_edge || s + t > 1 + k_edge) continue;
      const float height = a[1] + s * (b[1] - a[1]) + t * (c[1] - a[1]) - r.height;
      if (height < k_pile_highest) pile_put_column(columns, column, row, 1, from, height);
    }
  }
  columns->sphere_row = 0;
  return true;
}

// Where the sand below a triangle begins: bricks with particles follow one another down to there. Triangles come brick
// by brick. Where the skin's "up" is not the world's, the chunk's lowest place stands for it.
float lowest_below(PileSkin* walk, const Pile& p, const SkinState& skin, const sandglass_skin_vertex& vertex,
                   float low) {
  if (skin.lattice.axis[1] != 1 || skin.lattice.sign[1] < 0) return low;
  float inside[3];
  int32_t at[3], brick[3];
  for (uint32_t k = 0; k < 3; ++k)
    inside[k] = vertex.position[k] - 0.5f / 127 * skin.lattice.spacing * static_cast<float>(vertex.normal[k]);
  lattice_place(skin.lattice, inside, at);
  for (uint32_t k = 0; k < 3; ++k) brick[k] = brick_along(at[k] >> k_skin_step_shift);
  if (brick[0] == walk->brick[0] && brick[1] == walk->brick[1] && brick[2] == walk->brick[2]) return walk->low;
  for (uint32_t k = 0; k < 3; ++k) walk->brick[k] = brick[k];
  const auto has_sand = [&] {
    const uint32_t number = brick_find(skin.bricks, brick);
    return number != k_none && skin.bricks.records[number].touches != 0;
  };
  if (!has_sand()) --brick[1];
  while (has_sand()) --brick[1];
  const float begins =
      (static_cast<float>(k_brick_side) * static_cast<float>(brick[1] + 1) + 0.5f) * skin.lattice.spacing;
  const float lowest = begins - p.request.source.radius - p.rectangle.height;
  return walk->low = lowest > low ? lowest : low;
}

}  // namespace

void walk_begin(PileSkin* walk, const DrawnSand& source) {
  walk->chunk = walk->chunk_first = 0;
  walk->brick[0] = k_no_brick;
  if (source.skin != nullptr) walk->version = source.skin->front_version;
}

bool pile_put_skin(PileColumns* columns, PileSkin* walk, PileAir* air, const Pile& p, uint32_t item, uint32_t* visits) {
  const SkinState& skin = *p.request.source.skin;
  const SkinMesh& mesh = skin.meshes.front;
  const uint32_t triangles = mesh.index_count / 3;
  if (item >= triangles) {
    const uint32_t loose = item - triangles;
    if (loose < mesh.flying) return pile_put_flying(air, p, mesh.loose[loose], visits);
    if (loose < mesh.flying + mesh.lying) put_lying(columns, p, mesh.loose[loose]);
    return true;
  }
  while (walk->chunk < skin.bricks.chunks.capacity &&
         item - walk->chunk_first >= mesh.chunks[walk->chunk].index_count / 3)
    walk->chunk_first += mesh.chunks[walk->chunk++].index_count / 3;
  if (walk->chunk == skin.bricks.chunks.capacity) return true;  // the mesh was exchanged meanwhile
  const sandglass_skin_chunk& chunk = mesh.chunks[walk->chunk];
  const uint16_t* corner = chunk.indices + 3 * (item - walk->chunk_first);
  const float low = lowest_below(walk, p, skin, chunk.vertices[corner[0]], chunk.low[1] - p.rectangle.height);
  const float* at[3];
  for (uint32_t k = 0; k < 3; ++k) at[k] = chunk.vertices[corner[k]].position;
  return put_triangle(columns, p.rectangle, at[0], at[1], at[2], low < k_near_floor * p.request.source.radius ? 0 : low,
                      visits);
}

}  // namespace sandglass
